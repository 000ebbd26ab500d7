//! Cover: few pieces that together contain all patches.
//!
//! Takes the pieces of merging, gives fewer of them, each patch with one owner. A set cover by
//! local search.
//!
//! | file | contents |
//! |---|---|
//! | `grow` | each piece takes the patches that fit |
//! | `coverage` | pieces that others cover are dropped; each patch stays with one piece |
//! | `dissolve` | pieces leave their patches to others and disappear |
//! | `nogoods` | three points of patches that no hull that fits contains, learned from refusals |

pub(super) mod coverage;
mod dissolve;
mod grow;
mod nogoods;

use super::patch::Piece;
use super::search::Search;
use crate::error::Error;
use crate::parallel;
use crate::solid::FitTester;
use crate::sorting::sort_by_number;
use coverage::{area, assign_owners, drop_redundant};
use dissolve::dissolve;
use grow::Grower;
use nogoods::{Learning, Nogoods, PointsOfPatches};

/// Share of the first round's budget that the last round of dissolving may spend: more than nearly
/// all meshes need.
const LAST_ROUND_BUDGET: f64 = 0.1;

/// Pieces that may grow at the same time. They do not share their nogoods.
const AT_ONCE: usize = 4;

/// Few pieces that cover all patches.
pub(crate) struct Cover {
    /// Each patch belongs to one of them.
    pub pieces: Vec<Piece>,
    /// The same before they shrank to what they own. They overlap.
    pub overlapping: Vec<Piece>,
    /// The pieces before the last round of dissolving, if it dissolved any. They overlap.
    pub before_last_round: Option<Vec<Piece>>,
}

/// Covers all patches with fewer pieces.
pub(crate) fn cover(search: &Search<'_>, pieces: Vec<Piece>) -> Result<Cover, Error> {
    if pieces.len() < 2 {
        let overlapping = Vec::new();
        return Ok(Cover { pieces, overlapping, before_last_round: None });
    }
    let &Search { solid, patches, settings, control, .. } = search;
    let points = PointsOfPatches::new(patches);
    let mut nogoods = Nogoods::new(&points, patches.count());
    let mut pieces = grow_all(search, pieces, &mut nogoods)?;
    drop_redundant(patches, &mut pieces);
    let budget = settings.dissolve_attempts;
    dissolve(search, &mut pieces, settings.bound.search(), budget, &mut nogoods)?;
    let before = pieces.clone();
    let budget = (LAST_ROUND_BUDGET * budget as f64) as usize;
    let bound = settings.bound.last_round();
    let mut nogoods = nogoods.under(solid, bound);
    dissolve(search, &mut pieces, bound, budget, &mut nogoods)?;
    let before_last_round = (pieces.len() < before.len()).then_some(before);
    let owned = assign_owners(patches, &pieces, control)?;
    Ok(Cover { pieces: owned, overlapping: pieces, before_last_round })
}

/// Pieces that have taken the patches that fit, those of the largest area first. One that others
/// cover by then is left out.
fn grow_all(
    search: &Search<'_>,
    pieces: Vec<Piece>,
    nogoods: &mut Nogoods<'_>,
) -> Result<Vec<Piece>, Error> {
    let &Search { solid, patches, settings, control, .. } = search;
    let all = patches.all();
    let areas = pieces.iter().map(|piece| -area(patches, &piece.patches));
    let mut order: Vec<(f64, usize)> = areas.zip(0..).collect();
    sort_by_number(&mut order);
    let mut covered = (all.clone(), Vec::new());
    for some in order.chunks(AT_ONCE) {
        let known = &*nogoods;
        let grow_one = |&(_, index): &(f64, usize)| {
            control.check()?;
            let mut piece = pieces[index].clone();
            let tester = FitTester::new(solid, settings.bound.search());
            let learning = Learning::after(known);
            let mut grower = Grower { patches, tester, learning, control };
            if !control.is_past_deadline() {
                grower.grow(&mut piece, &all)?;
            }
            Ok((piece, grower.learning.into_refusals()))
        };
        let (open, grown, refusals) = parallel::fold_ahead(
            some,
            (covered.0, covered.1, Vec::new()),
            |(open, ..), &(_, index)| pieces[index].patches.intersects(open),
            grow_one,
            |(open, grown, refusals), (piece, learned)| {
                open.difference_with(&piece.patches);
                grown.push(piece);
                refusals.extend(learned);
            },
        )?;
        refusals.iter().for_each(|refusal| nogoods.learn(refusal));
        covered = (open, grown);
    }
    Ok(covered.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism, times_in, u_prism};
    use crate::bounded::merge::merge;
    use crate::mesh::shapes::{cuboid, torus};

    #[test]
    fn a_single_piece_stays_as_it_is() {
        let fixture = Fixture::new(&cuboid([0.0; 3], [1.0; 3]), 0.02);
        let Cover { pieces, before_last_round, .. } =
            cover(&fixture.search(), vec![fixture.piece([0])]).unwrap();
        assert_eq!(pieces.len(), 1);
        assert!(before_last_round.is_none());
    }

    #[test]
    fn each_patch_has_one_owner_and_there_are_no_more_pieces_than_before() {
        for mesh in [cubes([0.0, 1.5, 3.0]), l_prism(), u_prism(), torus(24, 12)] {
            let fixture = Fixture::new(&mesh, 0.03);
            let merged = merge(&fixture.search()).unwrap();
            let before = merged.len();
            let Cover { pieces, .. } = cover(&fixture.search(), merged).unwrap();
            assert!(pieces.len() <= before);
            let count = fixture.patches.count();
            assert_eq!(times_in(count, pieces.iter().map(|piece| &piece.patches)), vec![1; count]);
        }
    }

    #[test]
    fn a_piece_that_others_cover_once_they_have_grown_is_left_out() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 3.0]), 0.02);
        let pieces = [0, 1, 2].map(|patch| fixture.piece([patch])).to_vec();
        let points = PointsOfPatches::new(&fixture.patches);
        let mut nogoods = Nogoods::new(&points, 3);
        let grown = grow_all(&fixture.search(), pieces, &mut nogoods).unwrap();
        let mut sets: Vec<Vec<u32>> =
            grown.iter().map(|piece| piece.patches.iter().collect()).collect();
        sets.sort();
        assert_eq!(sets, [vec![0, 1], vec![2]]);
    }
}
