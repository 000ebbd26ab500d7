//! Verification: how far the source lies outside the hulls, as an upper bound.
//!
//! Points that are close together are compared with a hull as a bucket, since most planes of a hull
//! have none of them in front.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::OnceLock;

use crate::bvh::Bvh;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, bounds, centre, larger, smaller};
use crate::hull::ConvexHull;
use crate::mesh::TriangleMesh;
use crate::sorting::sort_by_key;

/// A point less in front of every face than this, as a fraction of the diagonal, is in the hull:
/// the rounding of heights over planes in double precision, with a margin.
const ROUNDING: f64 = 1e-9;

/// The plane of a face.
#[derive(Clone, Copy)]
struct FacePlane {
    plane: Plane,
    face: u32,
}

impl FacePlane {
    #[inline]
    fn height(&self, point: Vector) -> f64 {
        self.plane.height(point)
    }
}

/// Distances to a hull.
pub(crate) struct HullDistance<'a> {
    hull: &'a ConvexHull,
    planes: Vec<FacePlane>,
    /// Corners of its bounding box.
    corners: [Vector; 2],
    /// Built on demand: most hulls never need it.
    bvh: OnceLock<Bvh>,
}

impl<'a> HullDistance<'a> {
    pub(crate) fn new(hull: &'a ConvexHull) -> Self {
        let planes = (0..).zip(hull.face_planes());
        let planes = planes.map(|(face, plane)| FacePlane { plane, face });
        let (min, max) = bounds(hull.points().iter().copied());
        Self { hull, planes: planes.collect(), corners: [min, max], bvh: OnceLock::new() }
    }

    /// Adds the parts of a polygon that are outside the hull.
    fn cut_off(&self, polygon: Vec<Vector>, outside: &mut Vec<Vec<Vector>>) {
        let is_beyond =
            |plane: &FacePlane| polygon.iter().all(|&corner| plane.height(corner) > 0.0);
        if self.planes.iter().any(is_beyond) {
            outside.push(polygon);
            return;
        }
        let mut rest = polygon;
        for plane in &self.planes {
            let heights: Vec<f64> =
                rest.iter().map(|&corner| plane.height(corner) - ROUNDING).collect();
            if heights.iter().all(|&height| height <= 0.0) {
                continue;
            }
            let [beyond, behind] = split(&rest, &heights);
            outside.push(beyond);
            rest = behind;
            if rest.len() < 3 {
                return;
            }
        }
    }

    /// Whether one of the points is certainly farther from the hull than `limit`, by its bounding
    /// box.
    fn is_far_from(&self, points: &[Vector], limit: f64) -> bool {
        let [min, max] = self.corners;
        let gap = |point: Vector| (min - point).max(point - max).max_element();
        points.iter().any(|&point| gap(point) > limit + ROUNDING)
    }

    /// The distance from a point to the hull, 0 inside. If it exceeds `limit`, any value above
    /// `limit` may be returned.
    fn distance(&self, point: Vector, limit: f64) -> f64 {
        self.distance_by(&self.planes, point, limit)
    }

    /// The same for a point that is behind all planes except some of `planes`.
    fn distance_by(&self, planes: &[FacePlane], point: Vector, limit: f64) -> f64 {
        let (mut beyond, mut face) = (f64::NEG_INFINITY, 0);
        for plane in planes {
            let height = plane.height(point);
            if height > beyond {
                (beyond, face) = (height, plane.face);
            }
        }
        if beyond > limit {
            return beyond;
        }
        if beyond <= ROUNDING {
            return 0.0;
        }
        // Above a face and not beyond its edges, that face is the closest part of the hull.
        let corners = self.hull.triangles[face as usize];
        let [a, b, c] = corners.map(|corner| self.hull.points()[corner as usize] - point);
        let to_face = closest_point_on_triangle(a, b, c).length();
        if to_face <= beyond + ROUNDING {
            return to_face;
        }
        let bvh = self.bvh.get_or_init(|| Bvh::new(self.hull.points(), &self.hull.triangles));
        bvh.closest_point(point, f64::INFINITY).map_or(beyond, |closest| closest.distance)
    }
}

/// The greatest distance of the points outside a hull, 0 if it contains all. If it exceeds `limit`,
/// any value above `limit` may be returned. O(points + buckets · faces), typically far less.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn distance_outside(
    hull: &ConvexHull,
    points: &PointBuckets,
    limit: f64,
    control: &Control,
) -> Result<f64, Error> {
    let hull = HullDistance::new(hull);
    let mut farthest: f64 = 0.0;
    let (mut of_large, mut of_small) = (Vec::new(), Vec::new());
    let small = points.small.chunks(LARGE / SMALL).zip(points.points.chunks(LARGE));
    for (large, (buckets, points)) in points.large.iter().zip(small) {
        control.check()?;
        large.planes_in_reach(&hull.planes, &mut of_large);
        if of_large.is_empty() {
            continue;
        }
        for (small, points) in buckets.iter().zip(points.chunks(SMALL)) {
            small.planes_in_reach(&of_large, &mut of_small);
            if of_small.is_empty() {
                continue;
            }
            for &point in points {
                farthest = farthest.max(hull.distance_by(&of_small, point, limit));
                if farthest > limit {
                    return Ok(farthest);
                }
            }
        }
    }
    Ok(farthest)
}

/// Points in buckets of points that are close together.
pub(crate) struct PointBuckets {
    /// In the order of a space-filling curve.
    points: Vec<Vector>,
    /// Of [`LARGE`] points each, and of [`SMALL`].
    large: Vec<Bucket>,
    small: Vec<Bucket>,
}

/// A ball around consecutive points.
struct Bucket {
    centre: Vector,
    radius: f64,
}

/// Points of a large bucket, and of a small bucket within it. Testing a bucket against a plane
/// takes as long as a point: a small bucket needs several points, and a large one several small
/// buckets.
const LARGE: usize = 128;
const SMALL: usize = 8;

impl Bucket {
    fn all(points: &[Vector], size: usize) -> Vec<Self> {
        let buckets = points.chunks(size).map(|points| {
            let sum = points.iter().fold(Vector::ZERO, |sum, &point| sum + point);
            let centre = sum * (1.0 / points.len() as f64);
            let radius = points.iter().map(|&point| centre.distance(point)).fold(0.0, f64::max);
            Self { centre, radius }
        });
        buckets.collect()
    }

    /// Collects the planes that a point of the bucket may be in front of.
    fn planes_in_reach(&self, planes: &[FacePlane], in_reach: &mut Vec<FacePlane>) {
        let may_matter = |plane: &&FacePlane| plane.height(self.centre) + self.radius > -ROUNDING;
        in_reach.clear();
        in_reach.extend(planes.iter().filter(may_matter).copied());
    }
}

impl PointBuckets {
    /// O(n log n).
    pub(crate) fn new(points: &[Vector]) -> Self {
        let (min, max) = bounds(points.iter().copied());
        let extent = (max - min).to_array().into_iter().fold(0.0, f64::max);
        let cells = f64::from(1_u32 << BITS);
        let place = |x: f64| (x / extent * cells).clamp(0.0, cells - 1.0) as u32;
        let number = |point: Vector| {
            let [x, y, z] = (point - min).to_array().map(place);
            (0..BITS).rev().fold(0, |number, bit| {
                number << 3 | (x >> bit & 1) << 2 | (y >> bit & 1) << 1 | (z >> bit & 1)
            })
        };
        let mut numbered: Vec<(u32, Vector)> =
            points.iter().map(|&point| (number(point), point)).collect();
        sort_by_key(&mut numbered, |&(number, _)| number);
        let points: Vec<Vector> = numbered.into_iter().map(|(_, point)| point).collect();
        let (large, small) = (Bucket::all(&points, LARGE), Bucket::all(&points, SMALL));
        Self { points, large, small }
    }
}

/// The Morton curve's grid has 2 to this many cells along each axis: finer than buckets, and three
/// coordinates fit a 32-bit key.
const BITS: u32 = 8;

/// Maximum number of times that a triangle whose corners are in different hulls is divided in four:
/// parts are then 256 times as short, and what remains is an upper bound. A side of a plain shape
/// may be one triangle.
const MAX_DIVISIONS: u32 = 8;

/// Parts into which hulls cut a triangle at most: no more hulls are compared then, and what is left
/// is divided.
const MAX_PARTS: usize = 64;

/// Triangles between two checks for cancellation. A divided one may take a millisecond, and has its
/// own.
const TRIANGLES_PER_CHECK: usize = 64;

/// No point of some triangles of a surface is farther than this outside all hulls. Each is given
/// with the hull that should contain it; one without a valid one is compared with all. The result
/// is at least `tolerance`: less counts as covered.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn uncovered_distance(
    surface: &TriangleMesh,
    triangles: &[(u32, u32)],
    hulls: &[HullDistance<'_>],
    tolerance: f64,
    control: &Control,
) -> Result<f64, Error> {
    // For each vertex its distances to the hulls that own triangles around it. The distance to a
    // convex set is a convex function: on a triangle it is largest at a corner.
    let mut known: Vec<Vec<(u32, f64)>> = vec![Vec::new(); surface.positions.len()];
    let mut worst = tolerance;
    for (index, &(triangle, owner)) in triangles.iter().enumerate() {
        if index.is_multiple_of(TRIANGLES_PER_CHECK) {
            control.check()?;
        }
        let triangle = surface.triangles[triangle as usize];
        let mut outside: f64 = 0.0;
        for vertex in triangle {
            let Some(hull) = hulls.get(owner as usize) else {
                outside = f64::INFINITY;
                break;
            };
            let known = &mut known[vertex as usize];
            let value = match known.iter().find(|entry| entry.0 == owner) {
                Some(entry) => entry.1,
                None => {
                    let value = hull.distance(surface.points()[vertex as usize], f64::INFINITY);
                    known.push((owner, value));
                    value
                }
            };
            outside = outside.max(value);
        }
        if outside > worst {
            control.check()?;
            let corners = triangle.map(|vertex| surface.points()[vertex as usize]);
            for piece in outside_each(corners, hulls) {
                for (&b, &c) in piece.iter().skip(1).zip(piece.iter().skip(2)) {
                    let part = [piece[0], b, c];
                    worst = worst.max(outside_all(part, hulls, worst, outside, MAX_DIVISIONS));
                }
            }
        }
    }
    Ok(worst)
}

/// The parts of a triangle that no hull contains, as convex polygons. Where hulls meet across it,
/// nothing is left but rounding. O(faces) for each hull near it and each part.
fn outside_each(corners: [Vector; 3], hulls: &[HullDistance<'_>]) -> Vec<Vec<Vector>> {
    let (min, max) = bounds(corners);
    let mut parts = vec![corners.to_vec()];
    for hull in hulls {
        let [low, high] = hull.corners;
        if (low - max).max(min - high).max_element() > 0.0 {
            continue;
        }
        let mut left = Vec::new();
        parts.drain(..).for_each(|part| hull.cut_off(part, &mut left));
        parts = left;
        if parts.len() > MAX_PARTS {
            break;
        }
    }
    parts
}

/// The two sides of a polygon cut by a plane: in front of it, and behind.
fn split(polygon: &[Vector], heights: &[f64]) -> [Vec<Vector>; 2] {
    let mut sides = [Vec::new(), Vec::new()];
    for (index, (&corner, &height)) in polygon.iter().zip(heights).enumerate() {
        sides[usize::from(height <= 0.0)].push(corner);
        let next = (index + 1) % polygon.len();
        if (height > 0.0) != (heights[next] > 0.0) {
            let share = height / (height - heights[next]);
            let crossing = corner + (polygon[next] - corner) * share;
            sides.iter_mut().for_each(|side| side.push(crossing));
        }
    }
    sides
}

/// The same for a part of a triangle that its owner does not contain: other hulls may contain parts
/// of it. `known` bounds its distance outside its owner.
fn outside_all(
    corners: [Vector; 3],
    hulls: &[HullDistance<'_>],
    worst: f64,
    known: f64,
    divisions: u32,
) -> f64 {
    let least = outside_one(&corners, hulls, known);
    if least <= worst || divisions == 0 {
        return least;
    }
    quarters(corners).into_iter().fold(0.0, |most: f64, part| {
        larger(most, outside_all(part, hulls, larger(worst, most), least, divisions - 1))
    })
}

/// No point of a part is farther than this outside the hull that holds most of it. `known` bounds
/// that already.
fn outside_one(corners: &[Vector], hulls: &[HullDistance<'_>], known: f64) -> f64 {
    hulls.iter().fold(known, |least: f64, hull| {
        // Most hulls are elsewhere: without this, scans take up to a fifth more instructions.
        if hull.is_far_from(corners, least) {
            return least;
        }
        let outside = corners.iter().map(|&corner| hull.distance(corner, least));
        smaller(least, outside.fold(0.0, larger))
    })
}

fn quarters([a, b, c]: [Vector; 3]) -> [[Vector; 3]; 4] {
    let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| (p + q) * 0.5);
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// The same for a whole surface and hulls of any tool, whose owners are not known: cracks between
/// hulls run across large triangles. The part with the largest bound is divided first, until that
/// is hardly above the distance of some point, or there are too many parts.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn uncovered_by_any(
    surface: &TriangleMesh,
    hulls: &[HullDistance<'_>],
    tolerance: f64,
    control: &Control,
) -> Result<f64, Error> {
    let open = |corners: [Vector; 3], known: f64| Open {
        most: outside_one(&corners, hulls, known),
        corners,
    };
    let is_covered = |corners: &[Vector; 3], hull: &HullDistance<'_>| {
        !hull.is_far_from(corners, tolerance)
            && corners.iter().all(|&corner| hull.distance(corner, tolerance) <= tolerance)
    };
    let mut parts = BinaryHeap::new();
    for (index, &triangle) in surface.triangles.iter().enumerate() {
        if index.is_multiple_of(TRIANGLES_PER_CHECK) {
            control.check()?;
        }
        let corners = triangle.map(|vertex| surface.points()[vertex as usize]);
        if hulls.iter().any(|hull| is_covered(&corners, hull)) {
            continue;
        }
        for piece in outside_each(corners, hulls) {
            for (&b, &c) in piece.iter().skip(1).zip(piece.iter().skip(2)) {
                parts.push(open([piece[0], b, c], f64::INFINITY));
            }
        }
    }
    let mut least = tolerance;
    for count in 0..MAX_PARTS_OF_ANY {
        if count.is_multiple_of(TRIANGLES_PER_CHECK) {
            control.check()?;
        }
        let Some(Open { most, corners }) = parts.pop() else { return Ok(least) };
        least = larger(least, outside_one(&[centre(corners)], hulls, most));
        if most <= (1.0 + RESOLUTION_OF_ANY) * least {
            return Ok(larger(most, least));
        }
        parts.extend(quarters(corners).map(|part| open(part, most)));
    }
    Ok(parts.peek().map_or(least, |open| larger(open.most, least)))
}

/// What is found for hulls of any tool may be above the true distance by this share of it.
const RESOLUTION_OF_ANY: f64 = 0.01;

/// Parts that are divided for hulls of any tool, at most: about a second.
const MAX_PARTS_OF_ANY: usize = 100_000;

/// A part of a triangle, and what no point of it is farther outside all hulls than.
struct Open {
    most: f64,
    corners: [Vector; 3],
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        self.most.total_cmp(&other.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::into_arrays;
    use crate::hull::convex_hull;
    use crate::mesh::shapes::cuboid;

    fn cube() -> ConvexHull {
        convex_hull(&cuboid([0.0; 3], [1.0; 3]).positions).unwrap()
    }

    #[test]
    fn beyond_an_edge_the_distance_is_to_the_edge_and_beyond_a_corner_to_the_corner() {
        let cube = cube();
        let to_cube = HullDistance::new(&cube);
        for (point, expected) in [
            (Vector::splat(0.5), 0.0),
            (Vector::new(0.2, 0.7, 1.0), 0.0),
            (Vector::new(0.2, 0.7, 1.25), 0.25),
            (Vector::new(1.3, 1.4, 0.5), 0.5),
            (Vector::new(1.2, -0.4, 1.4), 0.6),
        ] {
            for limit in [expected + 1e-9, 1.0, f64::INFINITY] {
                let found = to_cube.distance(point, limit);
                assert!((found - expected).abs() < 1e-12, "{point:?}: {found}");
            }
        }
    }

    #[test]
    fn what_is_farther_than_the_limit_is_reported_to_be() {
        let cube = cube();
        let to_cube = HullDistance::new(&cube);
        // A quarter above two faces, and 0.35 from their edge.
        for limit in [0.0, 0.1, 0.25, 0.3, 0.35] {
            assert!(to_cube.distance(Vector::new(1.25, 1.25, 0.5), limit) > limit, "{limit}");
        }
    }

    #[test]
    fn points_in_buckets_are_as_far_outside_as_single_ones() {
        // Points on a sphere around a cube, whose corners extend beyond it.
        let corners = (0..8).map(|i| [0, 1, 2].map(|k| f64::from(i >> k & 1) - 0.5));
        let cube = convex_hull(&corners.collect::<Vec<_>>()).unwrap();
        let points: Vec<Vector> = (0..3000)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 3000.0;
                let angle = f64::from(i) * 2.4;
                let ring = (1.0 - z * z).sqrt();
                Vector::new(ring * angle.cos(), ring * angle.sin(), z) * 0.8
            })
            .collect();
        let to_cube = HullDistance::new(&cube);
        let expected = |points: &[Vector]| {
            points.iter().map(|&p| to_cube.distance(p, f64::INFINITY)).fold(0.0, f64::max)
        };
        for points in [&points[..], &points[..50], &points[1400..1600], &[]] {
            let buckets = PointBuckets::new(points);
            let found = distance_outside(&cube, &buckets, f64::INFINITY, &Control::new()).unwrap();
            assert_eq!(found, expected(points));
        }
        assert!((expected(&points) - 0.3).abs() < 1e-3);
    }

    const TOLERANCE: f64 = 1e-4;

    fn boxes(ranges: &[[f64; 2]]) -> Vec<ConvexHull> {
        let hull = |&[low, high]: &[f64; 2]| cuboid([low, 0.0, 0.0], [high, 1.0, 1.0]).positions;
        ranges.iter().map(|range| convex_hull(&hull(range)).unwrap()).collect()
    }

    fn uncovered(positions: &[Vector], owners: &[u32], hulls: &[ConvexHull]) -> f64 {
        let triangles = [[0, 1, 2], [0, 3, 1]];
        let surface = TriangleMesh {
            positions: into_arrays(positions.to_vec()),
            triangles: triangles[..owners.len()].to_vec(),
            ..TriangleMesh::default()
        };
        let hulls: Vec<HullDistance<'_>> = hulls.iter().map(HullDistance::new).collect();
        let owned: Vec<(u32, u32)> = (0..).zip(owners.iter().copied()).collect();
        uncovered_distance(&surface, &owned, &hulls, TOLERANCE, &Control::new()).unwrap()
    }

    #[test]
    fn a_triangle_is_as_far_outside_as_its_farthest_corner() {
        let hulls = boxes(&[[0.0, 1.0]]);
        let inside = [[0.1, 0.2, 0.3], [0.9, 0.2, 0.3], [0.5, 0.8, 1.0]].map(Vector::from);
        assert_eq!(uncovered(&inside, &[0], &hulls), TOLERANCE);
        for corner in 0..3 {
            let mut positions = inside;
            positions[corner] = Vector::new(1.3, 1.4, 0.5);
            let found = uncovered(&positions, &[0], &hulls);
            // An upper bound, and no more than a part's size too large.
            assert!((0.5 - 1e-12..0.51).contains(&found), "{corner}: {found}");
        }
    }

    #[test]
    fn a_vertex_counts_for_each_hull_that_owns_a_triangle_there() {
        // The first triangle is in the first box, and both share two vertices.
        let positions =
            [[0.9, 0.5, 0.5], [0.9, 0.6, 0.5], [0.2, 0.5, 0.5], [1.6, 0.5, 0.5]].map(Vector::from);
        let near = boxes(&[[0.0, 1.0], [0.95, 2.0]]);
        let found = uncovered(&positions, &[0, 1], &near);
        assert!(found <= 0.01, "{found}");
        let far = boxes(&[[0.0, 1.0], [1.4, 2.0]]);
        let found = uncovered(&positions, &[0, 1], &far);
        // From the middle of the gap.
        assert!((0.2 - 1e-12..0.21).contains(&found), "{found}");
    }

    #[test]
    fn a_triangle_that_hulls_cover_together_is_covered_up_to_the_gap_between_them() {
        let positions = [[0.1, 0.1, 0.5], [1.9, 0.1, 0.5], [1.9, 0.9, 0.5]].map(Vector::from);
        for owner in [0, 1] {
            let found = uncovered(&positions, &[owner], &boxes(&[[0.0, 1.0], [1.0, 2.0]]));
            assert!(found < 0.01, "{found}");
            let found = uncovered(&positions, &[owner], &boxes(&[[0.0, 1.0], [1.2, 2.0]]));
            assert!((0.1..0.11).contains(&found), "{found}");
            let outside = [[0.1, 0.1, 0.5], [2.5, 0.1, 0.5], [1.9, 0.9, 0.5]].map(Vector::from);
            let found = uncovered(&outside, &[owner], &boxes(&[[0.0, 1.0], [1.2, 2.0]]));
            assert!((0.5 - 1e-12..0.51).contains(&found), "{found}");
        }
    }

    #[test]
    fn a_triangle_without_an_owner_is_compared_with_all_hulls() {
        let far = [[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]].map(Vector::from);
        let found = uncovered(&far, &[u32::MAX], &boxes(&[[0.0, 1.0]]));
        assert!((5.0 - 1e-12..5.01).contains(&found), "{found}");
        let within = far.map(|point| point * 0.1);
        assert_eq!(uncovered(&within, &[u32::MAX], &boxes(&[[0.0, 1.0]])), TOLERANCE);
    }

    #[test]
    fn where_hulls_meet_across_a_large_triangle_nothing_is_uncovered() {
        let positions = [[0.1, 0.1, 0.5], [1.9, 0.1, 0.5], [1.9, 0.9, 0.5]].map(Vector::from);
        let touching = boxes(&[[0.0, 0.3], [0.3, 0.31], [0.31, 1.7], [1.7, 2.0]]);
        assert_eq!(uncovered(&positions, &[2], &touching), TOLERANCE);
    }

    #[test]
    fn a_cancelled_measurement_is_an_error() {
        let control = Control::new();
        control.cancel();
        let surface = cuboid([0.0; 3], [1.0; 3]);
        let result = uncovered_distance(&surface, &[(0, 0)], &[], TOLERANCE, &control);
        assert_eq!(result, Err(Error::Cancelled));
    }
}
