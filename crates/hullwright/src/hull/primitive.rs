//! Boxes, balls and capsules in place of hulls.
//!
//! Distances are verified, not sampled. Distance to a convex set is a convex function, so a box is
//! nowhere farther outside a hull than at its corners. A ball or capsule of radius r is nowhere
//! farther than d outside if its centre, or both ends of its segment, lie r - d behind every plane
//! of the hull. And a hull is nowhere farther outside of a primitive than at its vertices.

use super::convex_hull::{ConvexHull, any_across};
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, area_normal, bounds};

/// A simple shape.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Primitive {
    /// A box.
    Cuboid {
        /// Its centre.
        centre: [f64; 3],
        /// Unit vectors along its edges, right-handed.
        axes: [[f64; 3]; 3],
        /// Half the lengths of its edges.
        half: [f64; 3],
    },
    /// A ball.
    Ball {
        /// Its centre.
        centre: [f64; 3],
        /// Its radius.
        radius: f64,
    },
    /// All within a radius of a segment.
    Capsule {
        /// The ends of the segment.
        ends: [[f64; 3]; 2],
        /// Its radius.
        radius: f64,
    },
}

/// How far a primitive and a hull may be apart, in the hull's units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slack {
    /// No point of the primitive may be farther outside of the hull.
    pub outside: f64,
    /// No point of the hull may be farther outside of the primitive.
    pub inside: f64,
}

/// The primitive that is nearest to a hull, if there is one within `slack`. O(faces²).
pub fn fit_primitive(hull: &ConvexHull, slack: Slack) -> Option<Primitive> {
    if !(slack.outside >= 0.0 && slack.inside >= 0.0) || hull.points.is_empty() {
        return None;
    }
    let planes = hull.face_planes();
    let axes = axes(hull);
    let cuboid = axes.and_then(|axes| cuboid(hull, &planes, axes, slack));
    let ball = ball(hull, &planes, slack);
    let lengthwise = axes.into_iter().flatten().chain(longest_chord(hull));
    let capsules = lengthwise.filter_map(|axis| capsule(hull, &planes, axis, slack));
    let fits = cuboid.into_iter().chain(ball).chain(capsules);
    fits.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(primitive, _)| primitive)
}

/// A primitive, and how far it is from the hull.
type Fit = (Primitive, f64);

/// Faces whose normals differ by less count as parallel: the cosine of two degrees.
const PARALLEL: f64 = 0.9994;

/// Faces whose normals are this near to upright give a second axis: the cosine of 85 degrees.
const UPRIGHT: f64 = 0.087;

/// The normals of the largest parallel faces, and of the largest upright to them.
fn axes(hull: &ConvexHull) -> Option<[Vector; 3]> {
    let faces: Vec<(Vector, f64)> = hull
        .faces()
        .map(|[a, b, c]| area_normal(a, b, c))
        .map(|normal| (normal.normalize_or_zero(), normal.length()))
        .collect();
    let area = |normal: Vector| -> f64 {
        let parallel = faces.iter().filter(|(other, _)| other.dot(normal).abs() > PARALLEL);
        parallel.map(|(_, area)| area).sum()
    };
    let largest = |candidates: &mut dyn Iterator<Item = Vector>| {
        candidates.map(|normal| (normal, area(normal))).max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let (first, _) = largest(&mut faces.iter().map(|(normal, _)| *normal))?;
    let upright = faces.iter().map(|(normal, _)| *normal).filter(|n| n.dot(first).abs() < UPRIGHT);
    let (second, _) = largest(&mut { upright })?;
    let second = (second - first * second.dot(first)).normalize_or_zero();
    Some([first, second, first.cross(second)])
}

/// The direction between the two vertices that are farthest apart.
fn longest_chord(hull: &ConvexHull) -> Option<Vector> {
    let pairs = hull.points().iter().enumerate();
    let pairs = pairs.flat_map(|(index, a)| hull.points()[index + 1..].iter().map(|b| *b - *a));
    let longest = pairs.max_by(|a, b| a.dot(*a).total_cmp(&b.dot(*b)))?;
    Some(longest.normalize_or_zero())
}

/// The hull's extent along axes: their middle in space, and halves.
fn extent(hull: &ConvexHull, axes: [Vector; 3]) -> (Vector, Vector) {
    let (low, high) =
        bounds(hull.points().iter().map(|point| Vector::from(axes.map(|axis| axis.dot(*point)))));
    let middle = (low + high) * 0.5;
    (in_space(middle, axes), (high - low) * 0.5)
}

fn in_space(point: Vector, axes: [Vector; 3]) -> Vector {
    let [x, y, z] = axes;
    x * point[0] + y * point[1] + z * point[2]
}

/// The hull is inside of it.
fn cuboid(hull: &ConvexHull, planes: &[Plane], axes: [Vector; 3], slack: Slack) -> Option<Fit> {
    let (centre, half) = extent(hull, axes);
    let corner = |index: usize| {
        let signed = Vector::from_array(
            [0, 1, 2].map(|axis| if index >> axis & 1 == 1 { half[axis] } else { -half[axis] }),
        );
        centre + in_space(signed, axes)
    };
    let distances = (0..8).map(|index| hull.distance_outside(planes, corner(index)));
    let outside = distances.fold(0.0, f64::max);
    let is_usable = half.to_array().iter().all(|half| *half > 0.0) && outside <= slack.outside;
    is_usable.then_some((
        Primitive::Cuboid {
            centre: centre.to_array(),
            axes: axes.map(Into::into),
            half: half.to_array(),
        },
        outside,
    ))
}

/// How far a point is behind the nearest plane.
fn depth(planes: &[Plane], point: Vector) -> f64 {
    let depths = planes.iter().map(|plane| -plane.height(point));
    depths.fold(f64::INFINITY, f64::min)
}

/// A radius within slack: the hull reaches to `farthest` from the middle and is `depth` deep there.
fn radius(farthest: f64, depth: f64, slack: Slack) -> Option<f64> {
    let (least, most) = (farthest - slack.inside, depth + slack.outside);
    let middle = (farthest + depth) / 2.0;
    (least <= most && most > 0.0 && depth > 0.0).then(|| middle.clamp(least, most))
}

fn ball(hull: &ConvexHull, planes: &[Plane], slack: Slack) -> Option<Fit> {
    let (low, high) = bounds(hull.points().iter().copied());
    let centre = (low + high) * 0.5;
    let farthest = hull.points().iter().map(|point| point.distance(centre)).fold(0.0, f64::max);
    let depth = depth(planes, centre);
    let radius = radius(farthest, depth, slack)?;
    Some((Primitive::Ball { centre: centre.to_array(), radius }, farthest - depth))
}

fn capsule(hull: &ConvexHull, planes: &[Plane], axis: Vector, slack: Slack) -> Option<Fit> {
    let second = any_across(axis);
    let (centre, half) = extent(hull, [axis, second, axis.cross(second)]);
    let across = |point: &Vector| {
        let from_centre = *point - centre;
        from_centre.distance(axis * axis.dot(from_centre))
    };
    let widest = hull.points().iter().map(across).fold(0.0, f64::max);
    let along = half[0] - widest;
    if along <= 0.0 {
        return None;
    }
    let ends = [-along, along].map(|along| centre + axis * along);
    let to_segment = |point: &Vector| {
        let place = axis.dot(*point - centre).clamp(-along, along);
        point.distance(centre + axis * place)
    };
    let farthest = hull.points().iter().map(to_segment).fold(0.0, f64::max);
    let depth = ends.map(|end| depth(planes, end)).into_iter().fold(f64::INFINITY, f64::min);
    let radius = radius(farthest, depth, slack)?;
    Some((Primitive::Capsule { ends: ends.map(Into::into), radius }, farthest - depth))
}
