//! Cover: few pieces that together contain all patches.
//!
//! Takes the pieces of merging, gives fewer of them, each patch with one owner. A set cover by local search.
//!
//! | file | contents |
//! |---|---|
//! | `grow` | each piece takes the patches that fit |
//! | `coverage` | pieces that others cover are dropped; each patch stays with one piece |
//! | `dissolve` | pieces leave their patches to others and disappear |
//! | `nogoods` | patches that do not fit together, learned from refusals |
//! | `fill` | pieces extend over what they have left hollow |

pub(super) mod coverage;
mod dissolve;
mod fill;
mod grow;
mod nogoods;

use super::patch::Piece;
use super::search::Search;
use crate::error::Error;
use crate::parallel;
use crate::solid::FitTester;
use coverage::{area, assign_owners, drop_redundant};
use dissolve::dissolve;
use fill::fill;
use grow::Grower;
use nogoods::{Learning, Nogoods, PointsOfPatches};

/// Share of the first round's budget that the last round of dissolving may spend: more than nearly
/// all meshes need. Without a budget, a mesh of 464 hulls took ten times as long.
const LAST_ROUND_BUDGET: f64 = 0.1;

/// Pieces that may grow at the same time. They do not learn from each other.
const AT_ONCE: usize = 4;

/// Few pieces that cover all patches.
pub(crate) struct Cover {
    /// Each patch belongs to one of them.
    pub pieces: Vec<Piece>,
    /// The pieces before the last round of dissolving, if it dissolved any. They overlap.
    pub before_last_round: Option<Vec<Piece>>,
}

/// Covers all patches with fewer pieces.
pub(crate) fn cover(search: &Search<'_>, pieces: Vec<Piece>) -> Result<Cover, Error> {
    if pieces.len() < 2 {
        return Ok(Cover { pieces, before_last_round: None });
    }
    let &Search { solid, patches, settings, control } = search;
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
    let mut owned = assign_owners(patches, &pieces, control)?;
    if solid.is_coarse() && solid.is_closed() {
        fill(&mut owned, &pieces, search)?;
    }
    Ok(Cover { pieces: owned, before_last_round })
}

/// Pieces that have taken the patches that fit, those of the largest area first. One that others cover by
/// then is left out.
fn grow_all(
    search: &Search<'_>,
    mut pieces: Vec<Piece>,
    nogoods: &mut Nogoods<'_>,
) -> Result<Vec<Piece>, Error> {
    let &Search { solid, patches, settings, control } = search;
    let all = patches.all();
    pieces.sort_by(|a, b| area(patches, &b.patches).total_cmp(&area(patches, &a.patches)));
    let mut covered = (all.clone(), Vec::new());
    for some in pieces.chunks(AT_ONCE) {
        let known = &*nogoods;
        let grow_one = |piece: &Piece| {
            control.check()?;
            let mut piece = piece.clone();
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
            |(open, ..), piece| piece.patches.intersects(open),
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
