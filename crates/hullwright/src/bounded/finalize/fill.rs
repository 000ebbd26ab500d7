//! Filling: hulls cover the surface and may leave the inside of a solid hollow, since each has
//! shrunk to what it owns.
//!
//! Takes verified hulls, extends some over points inside that none contains, and verifies them
//! again. There are as many hulls as before. O(points · faces of all hulls), and a limited number
//! of joint hulls.

use super::final_hull::{FinalHull, make_hull};
use super::hull_simplification::FinalizeContext;
use crate::bounded::patch::Piece;
use crate::bounded::search::Search;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds, spread_in_box};
use crate::hull::HullBuilder;
use crate::hull::growing_hull::GrowingHull;
use crate::solid::{FitTester, Side, Solid};
use crate::sorting::sort_by;

/// Points in the box around all hulls that look for a hollow: one of a thousandth of the box holds
/// a few.
const POINTS: usize = 2000;

/// Fewer points that no hull contains are no hollow: a single one of [`POINTS`] may be a crack
/// between hulls.
const MIN_POINTS: usize = 2;

/// Where there is a hollow, so many points in the solid show how far it goes: what lies between
/// them may stay hollow.
const POINTS_INSIDE: usize = 4000;

/// Points in the box among which those are sought: a solid may fill little of it.
const MAX_POINTS: usize = 64_000;

/// Joint hulls that are tested: a limit on time that hardly any mesh meets.
const MAX_ATTEMPTS: usize = 2000;

/// A hull that has refused so many points in turn is not extended further.
const MAX_REFUSALS: usize = 8;

/// Once so many pieces could not be given back, the rest is not tried: where a shape is round, all
/// exceed the limit on vertices, and each attempt to keep it is slow.
const MAX_REFUSED_PIECES: usize = 3;

/// A hull is extended over so many points at a time: more would need more vertices than it may
/// have.
const MAX_INSERTED: usize = 16;

/// Points this near to a hull count as covered. As a fraction of the diagonal.
const COVERED: f64 = 1e-3;

/// Extends hulls over points inside a closed solid that none contains.
///
/// `overlapping` are pieces that fit, before they shrank: what a hull owns is a part of one.
pub(super) fn fill(
    context: &FinalizeContext<'_>,
    hulls: &mut [FinalHull],
    overlapping: &[Piece],
) -> Result<(), Error> {
    let solid = context.search.exact_solid;
    if !solid.is_closed() {
        return Ok(());
    }
    let shapes: Vec<GrowingHull> = hulls.iter().map(shape_of).collect();
    let hollow = hollow(&shapes, solid);
    let mut filling = Filling { context, hulls, shapes, hollow, builder: HullBuilder::new() };
    filling.return_what_was_lost(overlapping)?;
    filling.extend_hulls()
}

/// Hulls that are being extended.
struct Filling<'a, 'h> {
    context: &'a FinalizeContext<'a>,
    hulls: &'h mut [FinalHull],
    /// The same hulls, that can grow.
    shapes: Vec<GrowingHull>,
    /// Points that none contains.
    hollow: Vec<Vector>,
    builder: HullBuilder,
}

impl Filling<'_, '_> {
    fn is_done(&self) -> bool {
        self.hollow.len() < MIN_POINTS || self.context.search.control.is_past_deadline()
    }

    /// Gives hulls back what the pieces that they come from contained, from the most points on.
    fn return_what_was_lost(&mut self, overlapping: &[Piece]) -> Result<(), Error> {
        let mut left: Vec<&Piece> = overlapping.iter().collect();
        let mut refusals = 0;
        while !self.is_done() && refusals < MAX_REFUSED_PIECES {
            self.context.search.control.check()?;
            let gain = |piece: &Piece| {
                self.hollow.iter().filter(|&&point| contains(&piece.hull, point)).count()
            };
            let best = (0..left.len()).map(|index| (gain(left[index]), index)).max();
            let Some((MIN_POINTS.., index)) = best else { break };
            let whole = left.remove(index);
            let is_part = |hull: &FinalHull| {
                hull.owned.patches.iter().all(|patch| whole.patches.contains(patch))
            };
            let vertices = whole.hull.clone().vertices();
            let is_extended = match self.hulls.iter().position(is_part) {
                Some(part) => self.extend_hull(part, &vertices)?,
                None => false,
            };
            refusals += usize::from(!is_extended);
        }
        Ok(())
    }

    /// Extends hulls over what is hollow still, the nearest hull first.
    fn extend_hulls(&mut self) -> Result<(), Error> {
        let &Search { solid, settings, control, .. } = &self.context.search;
        let mut tester = FitTester::new(solid, settings.bound.search());
        while !self.is_done() {
            control.check()?;
            let Some(point) = self.hollow.pop() else { break };
            let distances: Vec<f64> =
                self.shapes.iter().map(|shape| distance(shape, point)).collect();
            for index in ascending(&distances) {
                if tester.attempts >= MAX_ATTEMPTS {
                    return Ok(());
                }
                let mut joint = self.shapes[index].clone();
                if !tester.try_insert(&mut joint, std::iter::once((&[point][..], Vector::ZERO))) {
                    continue;
                }
                let mut points = extend(&mut tester, &mut joint, &self.hollow);
                points.push(point);
                let chosen = farthest_first(self.shapes[index].clone(), points);
                if self.extend_by_most(index, &chosen)? {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Extends a hull by points, or by the first half of them, and so on: fewer may keep the limit
    /// on vertices. Whether it contains some now.
    fn extend_by_most(&mut self, index: usize, points: &[Vector]) -> Result<bool, Error> {
        let counts = std::iter::successors(Some(points.len()), |count| Some(count / 2));
        for count in counts.take_while(|&count| count > 0) {
            if self.extend_hull(index, &points[..count])? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether a hull contains points too, which it does where it keeps the bound.
    fn extend_hull(&mut self, index: usize, points: &[Vector]) -> Result<bool, Error> {
        let mut owned = self.hulls[index].owned.clone();
        owned.inner_points.extend(points);
        let extended = make_hull(self.context, owned, &mut self.builder)?;
        let keeps_bound = extended.keeps_bound(self.context.search.settings);
        if keeps_bound {
            let shape = shape_of(&extended);
            self.hollow.retain(|&point| !contains(&shape, point));
            self.hulls[index] = extended;
            self.shapes[index] = shape;
        }
        Ok(keeps_bound)
    }
}

fn shape_of(hull: &FinalHull) -> GrowingHull {
    GrowingHull::new(hull.hull.points(), Vector::ZERO)
}

/// The places of distances, from the least on.
fn ascending(distances: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..distances.len()).collect();
    sort_by(&mut order, |&a, &b| distances[a].total_cmp(&distances[b]).then(a.cmp(&b)));
    order
}

fn distance(shape: &GrowingHull, point: Vector) -> f64 {
    shape.builder.farthest_outside(&[point])
}

/// Extends a hull over more points, the nearest first, and gives those. As many at once as before
/// fitted and twice as many, or half as many if they do not fit.
fn extend(tester: &mut FitTester<'_>, shape: &mut GrowingHull, points: &[Vector]) -> Vec<Vector> {
    let distances: Vec<f64> = points.iter().map(|&point| distance(shape, point)).collect();
    let mut rest: Vec<Vector> =
        ascending(&distances).into_iter().map(|index| points[index]).collect();
    let (mut inserted, mut count, mut refusals) = (Vec::new(), 1, 0);
    while !rest.is_empty() && refusals < MAX_REFUSALS {
        count = count.min(rest.len());
        let some = &rest[..count];
        if tester.try_insert(shape, std::iter::once((some, Vector::ZERO))) {
            inserted.extend_from_slice(some);
            rest.retain(|&point| !contains(shape, point));
            (count, refusals) = (2 * count, 0);
        } else if count > 1 {
            count /= 2;
        } else {
            rest.remove(0);
            refusals += 1;
        }
    }
    inserted
}

/// The points that a hull has to be extended by to contain nearly all of some points, the farthest
/// of those that are left first.
fn farthest_first(mut shape: GrowingHull, mut points: Vec<Vector>) -> Vec<Vector> {
    let mut chosen = Vec::new();
    while chosen.len() < MAX_INSERTED {
        points.retain(|&point| !contains(&shape, point));
        let distances: Vec<f64> = points.iter().map(|&point| distance(&shape, point)).collect();
        let Some(&farthest) = ascending(&distances).last() else { break };
        let point = points[farthest];
        shape.insert(&[point], Vector::ZERO);
        chosen.push(point);
    }
    chosen
}

/// Points inside the solid that no hull contains; none where there are too few for a hollow.
fn hollow(shapes: &[GrowingHull], solid: &Solid) -> Vec<Vector> {
    let (min, max) = bounds(shapes.iter().flat_map(|shape| [shape.min, shape.max]));
    let (mut hollow, mut covered) = (Vec::new(), 0);
    for index in 0..MAX_POINTS {
        let is_full = hollow.len() + covered >= POINTS_INSIDE;
        if is_full || index == POINTS && hollow.len() < MIN_POINTS {
            break;
        }
        let point = spread_in_box(index, min, max);
        if shapes.iter().any(|shape| contains(shape, point)) {
            covered += 1;
        } else if solid.side(point) == Side::Inside {
            hollow.push(point);
        }
    }
    hollow
}

fn contains(shape: &GrowingHull, point: Vector) -> bool {
    shape.is_solid
        && (0..3).all(|k| shape.min[k] <= point[k] && point[k] <= shape.max[k])
        && distance(shape, point) <= COVERED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::finalize::final_hull::Owned;
    use crate::bounded::fixture::{Fixture, l_prism, u_prism};
    use crate::bounded::merge::merge;
    use crate::mesh::shapes::{cuboid, hemisphere};

    fn context(fixture: &Fixture) -> FinalizeContext<'_> {
        FinalizeContext { search: fixture.search(), volume_per_vertex: 0.0 }
    }

    /// A hull for each triangle of the surface, which leave the inside hollow.
    fn hulls_of_triangles(fixture: &Fixture) -> Vec<FinalHull> {
        let mut hulls = Vec::new();
        for (index, patch) in (0..).zip(&fixture.patches.patches) {
            for &triangle in &patch.triangles {
                let patches = fixture.set([index]);
                let owned = Owned { patches, part: Some(vec![triangle]), inner_points: Vec::new() };
                hulls.push(make_hull(&context(fixture), owned, &mut HullBuilder::new()).unwrap());
            }
        }
        hulls
    }

    fn hollow_of(fixture: &Fixture, hulls: &[FinalHull]) -> Vec<Vector> {
        hollow(&hulls.iter().map(shape_of).collect::<Vec<_>>(), &fixture.solids.exact)
    }

    #[test]
    fn the_inside_of_a_box_that_only_its_sides_cover_is_hollow() {
        let fixture = Fixture::new(&cuboid([0.0; 3], [1.0; 3]), 0.02);
        let points = hollow_of(&fixture, &hulls_of_triangles(&fixture));
        assert!(points.len() > POINTS_INSIDE / 2);
        let is_inside = |&point: &Vector| fixture.solids.exact.side(point) == Side::Inside;
        assert!(points.iter().all(is_inside));
        assert!(hollow_of(&fixture, &fixture.hulls_of_patches()).is_empty());
    }

    #[test]
    fn hulls_fill_a_solid_within_the_bound_and_keep_what_they_own() {
        for mesh in [cuboid([0.0; 3], [1.0; 3]), u_prism()] {
            let fixture = Fixture::new(&mesh, 0.02);
            let mut hulls = hulls_of_triangles(&fixture);
            let (count, before) = (hulls.len(), hollow_of(&fixture, &hulls).len());
            fill(&context(&fixture), &mut hulls, &[]).unwrap();
            let left = hollow_of(&fixture, &hulls).len();
            assert!(left * 100 < before, "{left} of {before}");
            assert_eq!(hulls.len(), count);
            assert!(hulls.iter().all(|hull| hull.keeps_bound(&fixture.settings)));
        }
    }

    #[test]
    fn a_hull_gets_back_what_the_piece_it_comes_from_contained() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        let overlapping = merge(&fixture.search()).unwrap();
        let mut hulls = hulls_of_triangles(&fixture);
        fill(&context(&fixture), &mut hulls, &overlapping).unwrap();
        let are_filled = hulls.iter().filter(|hull| !hull.owned.inner_points.is_empty());
        let boxes = are_filled.filter(|hull| hull.hull.points.len() == 8);
        assert_eq!(boxes.count(), overlapping.len());
        assert!(hollow_of(&fixture, &hulls).is_empty());
    }

    #[test]
    fn an_open_surface_has_no_inside_to_fill() {
        let fixture = Fixture::new(&hemisphere(6), 0.02);
        let mut hulls = hulls_of_triangles(&fixture);
        fill(&context(&fixture), &mut hulls, &[]).unwrap();
        assert!(hulls.iter().all(|hull| hull.owned.inner_points.is_empty()));
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
