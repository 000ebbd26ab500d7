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
//!
//! Then filling: hulls of large patches cover the surface and may leave the inside of a solid
//! hollow, above all after pieces have shrunk to what they own. Points inside that no piece
//! contains go back to a piece that contained them before, or to one that can grow over them. There
//! are as many hulls as before. O(points · faces of all pieces), and a limited number of joint
//! hulls.

pub(super) mod coverage;
mod dissolve;
mod grow;
mod nogoods;

use super::patch::Piece;
use super::search::Search;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds, spread_in_box};
use crate::hull::growing_hull::GrowingHull;
use crate::parallel;
use crate::solid::{FitTester, Side, Solid};
use coverage::{area, assign_owners, drop_redundant};
use dissolve::dissolve;
use grow::Grower;
use nogoods::{Learning, Nogoods, PointsOfPatches};

/// Share of the first round's budget that the last round of dissolving may spend: more than nearly
/// all meshes need.
const LAST_ROUND_BUDGET: f64 = 0.1;

/// Pieces that may grow at the same time. They do not learn from each other.
const AT_ONCE: usize = 4;

/// Points in the box around all pieces: a cavity of a thousandth of the box holds a few.
const POINTS: usize = 2000;

/// A piece gets back what it contained if that holds at least this many points that are uncovered:
/// a single one of [`POINTS`] may be a crack between hulls.
const MIN_POINTS: usize = 2;

/// Joint hulls that are tested for points that no piece has contained: a limit on time that hardly
/// any mesh meets.
const MAX_ATTEMPTS: usize = 96;

/// Points this near to a hull count as covered. As a fraction of the diagonal.
const COVERED: f64 = 1e-3;

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
    let mut owned = assign_owners(patches, &pieces, control)?;
    if solid.is_closed() {
        fill(&mut owned, &pieces, search)?;
    }
    Ok(Cover { pieces: owned, before_last_round })
}

/// Pieces that have taken the patches that fit, those of the largest area first. One that others
/// cover by then is left out.
fn grow_all(
    search: &Search<'_>,
    mut pieces: Vec<Piece>,
    nogoods: &mut Nogoods<'_>,
) -> Result<Vec<Piece>, Error> {
    let &Search { solid, patches, settings, control, .. } = search;
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

/// Extends pieces over points inside the solid that none contains. `before` are pieces that fit,
/// before they shrank.
fn fill(pieces: &mut [Piece], before: &[Piece], search: &Search<'_>) -> Result<(), Error> {
    let mut hollow = hollow(pieces, search.solid);
    search.control.check()?;
    while hollow.len() >= MIN_POINTS {
        // A piece is extended by a piece before that has the same patches, and others.
        let gain =
            |piece: &Piece| hollow.iter().filter(|&&point| contains(&piece.hull, point)).count();
        let best = before
            .iter()
            .map(|piece| (gain(piece), piece))
            .filter(|&(gain, _)| gain >= MIN_POINTS)
            .max_by_key(|&(gain, _)| gain);
        let Some((_, whole)) = best else { break };
        let owner = pieces
            .iter_mut()
            .find(|piece| piece.patches.iter().all(|patch| whole.patches.contains(patch)));
        let Some(owner) = owner else { break };
        let vertices = whole.hull.clone().vertices();
        owner.hull.insert(&vertices, Vector::ZERO);
        owner.hull.volume = owner.hull.current_volume();
        owner.inner_points.extend(vertices);
        let count = hollow.len();
        hollow.retain(|&point| !contains(&owner.hull, point));
        if hollow.len() == count {
            break;
        }
    }
    grow_over(pieces, hollow, search)
}

/// Extends pieces by single points, flat pieces among them: under a large face of a thin solid, the
/// piece of that face is often the only one that can be extended.
fn grow_over(
    pieces: &mut [Piece],
    mut hollow: Vec<Vector>,
    search: &Search<'_>,
) -> Result<(), Error> {
    let mut tester = FitTester::new(search.solid, search.settings.bound.search());
    while let Some(point) = hollow.pop() {
        search.control.check()?;
        let single = [point];
        let mut order: Vec<(f64, usize)> = pieces
            .iter()
            .enumerate()
            .map(|(index, piece)| (distance(&piece.hull, point), index))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, index) in order {
            if tester.attempts >= MAX_ATTEMPTS {
                return Ok(());
            }
            let Some(piece) = pieces.get_mut(index) else { continue };
            if tester.try_insert(&mut piece.hull, [(&single[..], Vector::ZERO)].into_iter()) {
                piece.hull.volume = piece.hull.current_volume();
                piece.inner_points.push(point);
                let hull = &piece.hull;
                hollow.retain(|&point| !contains(hull, point));
                break;
            }
        }
    }
    Ok(())
}

/// Points inside the solid that no piece contains.
fn hollow(pieces: &[Piece], solid: &Solid) -> Vec<Vector> {
    let corners = pieces.iter().flat_map(|piece| [piece.hull.min, piece.hull.max]);
    let (min, max) = bounds(corners);
    (0..POINTS)
        .map(|index| spread_in_box(index, min, max))
        .filter(|&point| !pieces.iter().any(|piece| contains(&piece.hull, point)))
        .filter(|&point| solid.side(point) == Side::Inside)
        .collect()
}

/// How far a point is outside a hull, or outside the box of a flat one.
fn distance(hull: &GrowingHull, point: Vector) -> f64 {
    match hull.is_solid {
        true => hull.builder.farthest_outside(&[point]),
        false => point.distance(point.clamp(hull.min, hull.max)),
    }
}

fn contains(hull: &GrowingHull, point: Vector) -> bool {
    hull.is_solid
        && (0..3).all(|k| hull.min[k] <= point[k] && point[k] <= hull.max[k])
        && hull.builder.farthest_outside(&[point]) <= COVERED
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
        let Cover { pieces, before_last_round } =
            cover(&fixture.search(), vec![fixture.piece([0])]).unwrap();
        assert_eq!(pieces.len(), 1);
        assert!(before_last_round.is_none() && pieces[0].inner_points.is_empty());
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

    #[test]
    fn points_in_the_solid_that_no_piece_contains_are_hollow() {
        let fixture = Fixture::new(&cubes([0.0, 1.02]), 0.02);
        let solid = &*fixture.solids.coarse;
        let pieces = [0, 1].map(|patch| fixture.piece([patch]));
        assert!(hollow(&pieces, solid).is_empty());
        // A plate at the bottom of a cube, and another one at its top, leave the rest of it.
        let mut plates = pieces[..1].to_vec();
        let Vector { x, y, z } = plates[0].hull.max - plates[0].hull.min;
        let corners: Vec<Vector> = [0.0, 0.9]
            .map(|share| {
                let low = plates[0].hull.min + Vector::Z * z * share;
                [Vector::ZERO, Vector::X * x, Vector::Y * y].map(|side| low + side)
            })
            .concat();
        plates[0].hull = GrowingHull::new(&corners[..3], Vector::ZERO);
        plates.push(crate::bounded::patch::Piece {
            hull: GrowingHull::new(&corners[3..], Vector::ZERO),
            ..plates[0].clone()
        });
        let points = hollow(&plates, solid);
        assert!(points.len() > POINTS / 2 && points.iter().all(|&p| solid.side(p) == Side::Inside));
    }

    #[test]
    fn a_piece_that_has_shrunk_gets_the_inside_back_that_it_contained() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        let whole = merge(&fixture.search()).unwrap();
        // One of them is a single patch anyway, the other one loses half of its volume.
        let last = |piece: &Piece| fixture.piece(piece.patches.iter().last());
        let mut shrunk: Vec<Piece> = whole.iter().map(last).collect();
        let volume = |pieces: &[Piece]| pieces.iter().map(|piece| piece.hull.volume).sum::<f64>();
        assert!(volume(&shrunk) < 0.9 * volume(&whole));
        fill(&mut shrunk, &whole, &fixture.search()).unwrap();
        let returned = shrunk.iter().filter(|piece| !piece.inner_points.is_empty());
        assert_eq!(returned.count(), 1);
        for (piece, whole) in shrunk.iter().zip(&whole) {
            assert_eq!(piece.patches.count(), 1);
            assert!((piece.hull.volume - whole.hull.volume).abs() < 1e-6);
        }
        assert!(hollow(&shrunk, &fixture.solids.coarse).len() < MIN_POINTS);
    }

    #[test]
    fn pieces_grow_over_points_that_none_has_contained_as_far_as_they_fit() {
        let fixture = Fixture::new(&cubes([0.0, 3.0]), 0.02);
        let mut pieces = vec![fixture.piece([0])];
        let high = pieces[0].hull.max;
        let (near, far) = (high + Vector::Z * 0.01, high + Vector::Z * 0.1);
        grow_over(&mut pieces, vec![far, near], &fixture.search()).unwrap();
        assert_eq!(pieces[0].inner_points, [near]);
        assert!(pieces[0].hull.max.z < far.z);
    }

    #[test]
    fn a_point_is_as_far_from_a_flat_hull_as_from_its_box() {
        let square = [Vector::ZERO, Vector::X, Vector::Y, Vector::X + Vector::Y];
        let flat = GrowingHull::new(&square, Vector::Z);
        let point = Vector::new(4.0, 0.5, 4.0);
        assert_eq!(distance(&flat, point), 5.0);
        assert!(!contains(&flat, Vector::new(0.5, 0.5, 0.0)));
        let cube = GrowingHull::new(cuboid([0.0; 3], [1.0; 3]).points(), Vector::ZERO);
        assert!((distance(&cube, Vector::new(0.5, 0.5, 4.0)) - 3.0).abs() < 1e-9);
        assert!(contains(&cube, Vector::splat(0.5)));
        assert!(!contains(&cube, Vector::new(0.5, 0.5, 1.0005)));
    }

    #[test]
    fn a_point_a_thousandth_in_front_of_a_face_is_covered_and_one_farther_away_is_not() {
        let corner = [Vector::ZERO, Vector::X, Vector::Y, Vector::Z];
        let hull = GrowingHull::new(&corner, Vector::ZERO);
        // The face is oblique, so that these points are within the box of the hull.
        let in_front = |distance: f64| (Vector::ONE / 3.0) + Vector::ONE.normalize() * distance;
        assert!(contains(&hull, in_front(0.0009)) && !contains(&hull, in_front(0.0011)));
    }
}
