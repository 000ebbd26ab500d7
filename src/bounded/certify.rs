//! Verification against the source: how far a hull stands out of the solid, and how far the
//! surface lies outside the hulls. Upper bounds, not samples.
//!
//! The same rules as in the fit test decide a face, without its leniences: no part of a face is
//! left undecided because it is small. The grid serves where it bounds a distance from above, and
//! tells the side of points that are nearer to the middle of their cell than the surface is. Where the solid
//! is that of a clustered mesh, distances are those to the source (see `Solid::near`), and what is inside may be
//! as far outside of the source as vertices have moved: no less is ever told.

use std::sync::OnceLock;

use super::solid::{OPEN_INSIDE, Solid, halves};
use crate::bvh::Bvh;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, bounds, distance, dot, length, scale, subtract};
use crate::hull::ConvexHull;
use crate::mesh::TriangleMesh;

/// No triangle that might be near is known.
const NO_GUESS: u32 = u32::MAX;

/// A maximum is bounded up to this share of the bound.
const RESOLUTION: f64 = 0.04;

/// The same for what is hardly below the bound.
const FINE_RESOLUTION: f64 = 0.005;

/// Where the surface is open, the inside ends without it: a part as far from the surface as it is
/// large is inside if the winding number at its centre is this much above one half.
const STEEPEST: f64 = 0.5;

/// The winding number close below an open sheet.
const BELOW_A_SHEET: f64 = 0.5;

/// There parts smaller than this share of the bound are where their centre is.
const OPEN: f64 = 0.1;

/// Faces are not halved more often than this; needles would otherwise go on for ever.
const MOST_PARTS: usize = 200_000;

/// Where the distance is largest all along a line, as halfway between two sheets, finding out how
/// large takes parts without end. After so many it is only asked whether the bound is kept.
const MANY_PARTS: usize = 20_000;

/// Parts of faces between two looks at the control.
const PARTS_PER_CHECK: usize = 1024;

/// Triangles of the surface between two looks at the control.
const TRIANGLES_PER_CHECK: usize = 256;

/// No point of the faces is farther than this from the solid, in diagonals. Once it is known to
/// be more than `limit`, any value above `limit` may be returned.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn phantom(
    hull: &ConvexHull,
    solid: &Solid,
    bound: f64,
    limit: f64,
    control: &Control,
) -> Result<f64, Error> {
    let reach = solid.reach();
    // Below a quarter of the bound nobody asks for the exact figure, and below the reach nobody knows it.
    let mut known: f64 = (0.25 * bound).max(reach);
    if !solid.cavities.is_empty() {
        let planes = hull.planes();
        let holds = |point| planes.iter().all(|&(normal, offset)| dot(normal, point) <= offset);
        for &(point, depth) in &solid.cavities {
            if depth > known && holds(point) {
                known = depth;
            }
        }
        if known > limit {
            return Ok(known);
        }
    }
    let mut stack: Vec<[Vector; 3]> = hull.corners().collect();
    // A face on which a hull stands out far makes the rest quick.
    for &[a, b, c] in &stack {
        control.check()?;
        let centre = scale(add(add(a, b), c), 1.0 / 3.0);
        if solid.upper_distance(centre) + reach > known
            && let Some(near) = solid.near(centre, NO_GUESS)
            && near.upper > known
            && !solid.holds_inside(centre, &near)
        {
            known = near.upper;
        }
    }
    let mut parts = 0;
    while let Some([a, b, c]) = stack.pop() {
        parts += 1;
        // Where the mesh was clustered a part may take long.
        if parts % PARTS_PER_CHECK == 0 || reach > 0.0 {
            control.check()?;
        }
        if parts == MANY_PARTS && limit >= bound {
            known = known.max((1.0 - FINE_RESOLUTION) * bound);
        }
        if parts > MOST_PARTS {
            stack.push([a, b, c]);
            let rest = stack.iter().map(|&part| at_most(part, solid));
            return Ok(rest.fold(enough(known, bound), f64::max));
        }
        let centre = scale(add(add(a, b), c), 1.0 / 3.0);
        let radius = distance(centre, a).max(distance(centre, b)).max(distance(centre, c));
        let enough = enough(known, bound);
        if solid.upper_distance_of([a, b, c], centre, enough - reach) <= enough - reach
            || (solid.is_closed
                && solid.depth(centre).is_some_and(|depth| radius - depth <= enough - reach))
        {
            continue;
        }
        let (close, guess) = solid.close_distance(centre);
        let slack = if known > bound { RESOLUTION * known } else { FINE_RESOLUTION * bound };
        let may_divide = radius > slack;
        // A distance that can't raise what is known only decides where it is known to be small.
        if may_divide && close <= known && reach == 0.0 {
            stack.extend(halves([a, b, c]));
            continue;
        }
        let Some(near) = solid.near(centre, guess) else { return Ok(f64::INFINITY) };
        if near.upper + radius <= enough || solid.farthest_corner_from([a, b, c], &near) <= enough {
            continue;
        }
        // The side is dear, and only asked for where it decides.
        let may_be_enough = solid.is_closed && radius - near.lower <= enough;
        if near.upper > known || may_be_enough || !may_divide || !solid.is_closed {
            let is_inside = if solid.is_closed {
                solid.holds_inside(centre, &near)
            } else {
                // The side may change without a surface in between, but not on a sudden.
                let number = solid.bvh.winding_number(centre);
                let winding = number - OPEN_INSIDE;
                let is_small = radius <= OPEN * bound;
                // Each sheet that it is below makes it the steeper.
                let sheets = (number / BELOW_A_SHEET).max(1.0);
                let steepest = sheets * STEEPEST * radius / near.lower;
                if winding > 0.0 && (is_small || (radius <= near.lower && winding > steepest)) {
                    continue;
                }
                winding > 0.0
            };
            if is_inside {
                if may_be_enough || !may_divide {
                    continue;
                }
            } else {
                known = known.max(near.upper);
                if known > limit {
                    return Ok(known + radius);
                }
            }
        }
        if may_divide {
            stack.extend(halves([a, b, c]));
        }
    }
    Ok(enough(known, bound))
}

/// No point of a triangle is farther than this from the surface.
fn at_most([a, b, c]: [Vector; 3], solid: &Solid) -> f64 {
    let centre = scale(add(add(a, b), c), 1.0 / 3.0);
    let radius = distance(centre, a).max(distance(centre, b)).max(distance(centre, c));
    solid.near(centre, NO_GUESS).map_or(f64::INFINITY, |near| near.upper + radius)
}

/// What a maximum that is at least `known` is bounded by: near the bound as finely as it takes to
/// tell whether it is kept.
fn enough(known: f64, bound: f64) -> f64 {
    if known > bound {
        known * (1.0 + RESOLUTION)
    } else if known + RESOLUTION * bound <= bound {
        known + RESOLUTION * bound
    } else {
        bound.max(known + FINE_RESOLUTION * bound)
    }
}

/// A point that is less in front of all faces, in diagonals, is in a hull.
const ROUNDING: f64 = 1e-9;

/// The plane of a face.
#[derive(Clone, Copy)]
struct Plane {
    normal: Vector,
    offset: f64,
    face: u32,
}

impl Plane {
    #[inline]
    fn height(&self, point: Vector) -> f64 {
        dot(self.normal, point) - self.offset
    }
}

/// A hull that can be asked how far a point is outside of it.
pub(super) struct Outside<'a> {
    hull: &'a ConvexHull,
    planes: Vec<Plane>,
    /// Most hulls never need it.
    bvh: OnceLock<Bvh>,
}

impl<'a> Outside<'a> {
    pub(super) fn new(hull: &'a ConvexHull) -> Self {
        let planes = (0..).zip(hull.planes());
        let planes = planes.map(|(face, (normal, offset))| Plane { normal, offset, face });
        Self { hull, planes: planes.collect(), bvh: OnceLock::new() }
    }

    /// 0 for a point in the hull. Once that is known to be more than `limit`, any value above
    /// `limit` may be returned.
    fn distance(&self, point: Vector, limit: f64) -> f64 {
        self.distance_from(&self.planes, point, limit)
    }

    /// The same, if the point is behind all planes but some.
    fn distance_from(&self, planes: &[Plane], point: Vector, limit: f64) -> f64 {
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
        // Above a face and not beyond its edges no other part of the hull is nearer.
        let corners = self.hull.triangles[face as usize];
        let [a, b, c] = corners.map(|corner| subtract(self.hull.points[corner as usize], point));
        let to_face = length(closest_point_on_triangle(a, b, c));
        if to_face <= beyond + ROUNDING {
            return to_face;
        }
        let bvh = self.bvh.get_or_init(|| Bvh::new(&self.hull.points, &self.hull.triangles));
        bvh.closest_point(point, f64::INFINITY).map_or(beyond, |closest| closest.distance)
    }
}

/// How far the farthest of some points is outside of a hull. Once that is known to be more than
/// `limit`, any value above `limit` may be returned.
pub(super) fn left_out(hull: &ConvexHull, points: &PointGroups, limit: f64) -> f64 {
    let outside = Outside::new(hull);
    let mut farthest: f64 = 0.0;
    let (mut of_coarse, mut of_fine) = (Vec::new(), Vec::new());
    let fine = points.fine.chunks(MANY / FEW).zip(points.points.chunks(MANY));
    for (coarse, (groups, points)) in points.coarse.iter().zip(fine) {
        coarse.planes_in_reach(&outside.planes, &mut of_coarse);
        if of_coarse.is_empty() {
            continue;
        }
        for (fine, points) in groups.iter().zip(points.chunks(FEW)) {
            fine.planes_in_reach(&of_coarse, &mut of_fine);
            if of_fine.is_empty() {
                continue;
            }
            for &point in points {
                farthest = farthest.max(outside.distance_from(&of_fine, point, limit));
                if farthest > limit {
                    return farthest;
                }
            }
        }
    }
    farthest
}

/// Points that are asked together where they are close together: most planes of a hull have none of them
/// in front.
pub(super) struct PointGroups {
    /// Along a space-filling curve.
    points: Vec<Vector>,
    /// Each of [`MANY`] points, and of [`FEW`].
    coarse: Vec<PointGroup>,
    fine: Vec<PointGroup>,
}

/// A ball around points that follow each other.
struct PointGroup {
    centre: Vector,
    radius: f64,
}

/// Points of a group, and of one within it.
const MANY: usize = 128;
const FEW: usize = 8;

impl PointGroup {
    fn all(points: &[Vector], size: usize) -> Vec<Self> {
        let groups = points.chunks(size).map(|points| {
            let sum = points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
            let centre = scale(sum, 1.0 / points.len() as f64);
            let radius = points.iter().map(|&point| distance(centre, point)).fold(0.0, f64::max);
            Self { centre, radius }
        });
        groups.collect()
    }

    /// Those of some planes that a point of the group may be in front of.
    fn planes_in_reach(&self, planes: &[Plane], in_reach: &mut Vec<Plane>) {
        let may_matter = |plane: &&Plane| plane.height(self.centre) + self.radius > -ROUNDING;
        in_reach.clear();
        in_reach.extend(planes.iter().filter(may_matter).copied());
    }
}

impl PointGroups {
    /// O(n log n).
    pub(super) fn new(points: &[Vector]) -> Self {
        let (min, max) = bounds(points.iter().copied());
        let extent = subtract(max, min).into_iter().fold(0.0, f64::max);
        let cells = f64::from(1_u32 << BITS);
        let place = |x: f64| (x / extent * cells).clamp(0.0, cells - 1.0) as u32;
        let number = |point: Vector| {
            let [x, y, z] = subtract(point, min).map(place);
            (0..BITS).rev().fold(0, |number, bit| {
                number << 3 | (x >> bit & 1) << 2 | (y >> bit & 1) << 1 | (z >> bit & 1)
            })
        };
        let mut numbered: Vec<(u32, Vector)> =
            points.iter().map(|&point| (number(point), point)).collect();
        numbered.sort_by_key(|&(number, _)| number);
        let points: Vec<Vector> = numbered.into_iter().map(|(_, point)| point).collect();
        let (coarse, fine) = (PointGroup::all(&points, MANY), PointGroup::all(&points, FEW));
        Self { points, coarse, fine }
    }
}

/// The curve goes through a grid of 2 to this many cells along each axis.
const BITS: u32 = 8;

/// Halvings of a triangle whose corners are in different hulls.
const MOST_HALVINGS: u32 = 6;

/// No point of the surface is farther than this outside all hulls. `owners` names for each
/// triangle the hull that should hold it, if it has to be looked at. Less than `enough` is not told apart
/// from it.
pub(super) fn exposed(
    surface: &TriangleMesh,
    owners: &[u32],
    hulls: &[Outside<'_>],
    enough: f64,
    control: &Control,
) -> Result<f64, Error> {
    // Distance to a convex set is a convex function: on a triangle it is largest at a corner.
    let mut known: Vec<Vec<(u32, f64)>> = vec![Vec::new(); surface.positions.len()];
    let mut worst = enough;
    for (index, (triangle, &owner)) in surface.triangles.iter().zip(owners).enumerate() {
        if index.is_multiple_of(TRIANGLES_PER_CHECK) {
            control.check()?;
        }
        let Some(hull) = hulls.get(owner as usize) else { continue };
        let mut outside: f64 = 0.0;
        for &vertex in triangle {
            let known = &mut known[vertex as usize];
            let value = match known.iter().find(|entry| entry.0 == owner) {
                Some(entry) => entry.1,
                None => {
                    let value = hull.distance(surface.positions[vertex as usize], f64::INFINITY);
                    known.push((owner, value));
                    value
                }
            };
            outside = outside.max(value);
        }
        if outside > worst {
            let corners = triangle.map(|vertex| surface.positions[vertex as usize]);
            worst = worst.max(outside_all(corners, hulls, worst, outside, MOST_HALVINGS));
        }
    }
    Ok(worst)
}

/// The same for a triangle that its owner does not hold: other hulls may hold parts of it.
fn outside_all(
    corners: [Vector; 3],
    hulls: &[Outside<'_>],
    worst: f64,
    known: f64,
    halvings: u32,
) -> f64 {
    let least = hulls.iter().fold(known, |least: f64, hull| {
        let outside = corners.iter().map(|&corner| hull.distance(corner, least));
        least.min(outside.fold(0.0, f64::max))
    });
    if least <= worst || halvings == 0 {
        return least;
    }
    let [a, b, c] = corners;
    let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| scale(add(p, q), 0.5));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        .into_iter()
        .fold(0.0, |most: f64, part| {
            most.max(outside_all(part, hulls, worst.max(most), least, halvings - 1))
        })
}

#[cfg(test)]
mod tests {
    use super::super::solid::is_inside;
    use super::*;
    use crate::hull::convex_hull;

    #[test]
    fn below_a_stack_of_open_sheets_a_large_face_is_not_inside_as_a_whole() {
        // Six unit squares, one close above the other: right below them the winding number is 3,
        // but at a depth of 0.9 less than one half.
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for sheet in 0..6_u32 {
            let z = 1e-3 * f64::from(sheet);
            positions.extend([[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]]);
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|v| v + 4 * sheet)));
        }
        let control = Control::new();
        let bound = 0.01;
        let solid = Solid::new(&positions, &triangles, false, bound, &control).unwrap();
        let depth = 0.9;
        let corners = [[0.5, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, 0.5, -depth], [0.6, 0.5, -0.1]];
        let hull = convex_hull(&corners).unwrap();
        assert!(!is_inside(&solid.bvh, corners[2], solid.is_closed));
        assert!(is_inside(&solid.bvh, [0.5, 0.5, -0.3], solid.is_closed));
        let found = phantom(&hull, &solid, bound, f64::INFINITY, &control).unwrap();
        assert!(found >= depth, "{found}");
    }

    #[test]
    fn points_in_clusters_are_as_far_outside_as_one_by_one() {
        // Points on a sphere around a cube, whose corners reach through it.
        let corners = (0..8).map(|i| [0, 1, 2].map(|k| f64::from(i >> k & 1) - 0.5));
        let cube = convex_hull(&corners.collect::<Vec<_>>()).unwrap();
        let points: Vec<Vector> = (0..3000)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 3000.0;
                let angle = f64::from(i) * 2.4;
                let ring = (1.0 - z * z).sqrt();
                scale([ring * angle.cos(), ring * angle.sin(), z], 0.8)
            })
            .collect();
        let outside = Outside::new(&cube);
        let expected = |points: &[Vector]| {
            points.iter().map(|&p| outside.distance(p, f64::INFINITY)).fold(0.0, f64::max)
        };
        for points in [&points[..], &points[..50], &points[1400..1600], &[]] {
            let found = left_out(&cube, &PointGroups::new(points), f64::INFINITY);
            assert_eq!(found, expected(points));
        }
        assert!((expected(&points) - 0.3).abs() < 1e-3);
    }

    #[test]
    fn a_hull_beside_its_solid_stands_out_by_their_distance() {
        let cube = |low: f64| {
            let corners = (0..8).map(|i| [0, 1, 2].map(|k| low + f64::from(i >> k & 1)));
            convex_hull(&corners.collect::<Vec<_>>()).unwrap()
        };
        let (inner, outer) = (cube(0.0), cube(0.25));
        let control = Control::new();
        let bound = 0.02;
        let solid = Solid::new(&inner.points, &inner.triangles, true, bound, &control).unwrap();
        let of = |hull| phantom(hull, &solid, bound, f64::INFINITY, &control).unwrap();
        assert!(of(&inner) <= bound);
        // The farthest corner is a quarter away along each axis.
        let farthest = 0.25 * 3f64.sqrt();
        assert!((farthest..1.05 * farthest).contains(&of(&outer)), "{}", of(&outer));
    }
}
