//! Boxes, balls and capsules that stand for hulls.
//!
//! Whether one does is verified, not sampled. Distance to a convex set is a convex function, so a box is nowhere
//! farther outside a hull than at its corners. A ball or capsule of radius r is nowhere farther than d outside
//! if its centre, or both ends of its segment, lie r - d behind every plane of the hull. And a hull is nowhere
//! farther outside of a primitive than at its vertices.

use crate::bvh::closest_point::closest_point_on_triangle;
use crate::geometry::vector::{
    Vector, add, area_normal, bounds, cross, distance, dot, length, normalize, scale, subtract,
};
use crate::hull::ConvexHull;

/// A simple shape.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
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
///
/// ```
/// use hullwright::hull::{Primitive, Slack, convex_hull, fit_primitive};
///
/// let corners: Vec<[f64; 3]> =
///     (0..8).map(|i| [0, 1, 2].map(|axis| f64::from(i >> axis & 1))).collect();
/// let cube = convex_hull(&corners)?;
/// let found = fit_primitive(&cube, Slack { outside: 0.01, inside: 0.01 });
/// assert!(matches!(found, Some(Primitive::Cuboid { .. })));
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn fit_primitive(hull: &ConvexHull, slack: Slack) -> Option<Primitive> {
    if !(slack.outside >= 0.0 && slack.inside >= 0.0) || hull.points.is_empty() {
        return None;
    }
    let planes = hull.planes();
    let axes = axes(hull);
    let cuboid = axes.and_then(|axes| cuboid(hull, axes, slack));
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
        .corners()
        .map(|[a, b, c]| area_normal(a, b, c))
        .map(|normal| (normalize(normal), length(normal)))
        .collect();
    let area = |normal: Vector| -> f64 {
        let parallel = faces.iter().filter(|(other, _)| dot(*other, normal).abs() > PARALLEL);
        parallel.map(|(_, area)| area).sum()
    };
    let largest = |candidates: &mut dyn Iterator<Item = Vector>| {
        candidates.map(|normal| (normal, area(normal))).max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let (first, _) = largest(&mut faces.iter().map(|(normal, _)| *normal))?;
    let upright =
        faces.iter().map(|(normal, _)| *normal).filter(|n| dot(*n, first).abs() < UPRIGHT);
    let (second, _) = largest(&mut { upright })?;
    let second = normalize(subtract(second, scale(first, dot(second, first))));
    Some([first, second, cross(first, second)])
}

/// The direction between the two vertices that are farthest apart.
fn longest_chord(hull: &ConvexHull) -> Option<Vector> {
    let pairs = hull.points.iter().enumerate();
    let pairs =
        pairs.flat_map(|(index, a)| hull.points[index + 1..].iter().map(|b| subtract(*b, *a)));
    let longest = pairs.max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)))?;
    Some(normalize(longest))
}

/// The hull's extent along axes: their middle in space, and halves.
fn extent(hull: &ConvexHull, axes: [Vector; 3]) -> (Vector, Vector) {
    let (low, high) = bounds(hull.points.iter().map(|point| axes.map(|axis| dot(axis, *point))));
    let middle = scale(add(low, high), 0.5);
    (in_space(middle, axes), scale(subtract(high, low), 0.5))
}

fn in_space(point: Vector, axes: [Vector; 3]) -> Vector {
    let [x, y, z] = axes;
    add(add(scale(x, point[0]), scale(y, point[1])), scale(z, point[2]))
}

/// The hull is inside of it.
fn cuboid(hull: &ConvexHull, axes: [Vector; 3], slack: Slack) -> Option<Fit> {
    let (centre, half) = extent(hull, axes);
    let corner = |index: usize| {
        let signed =
            [0, 1, 2].map(|axis| if index >> axis & 1 == 1 { half[axis] } else { -half[axis] });
        add(centre, in_space(signed, axes))
    };
    let distances = (0..8).map(|index| distance_outside(hull, corner(index)));
    let outside = distances.fold(0.0, f64::max);
    let is_usable = half.iter().all(|half| *half > 0.0) && outside <= slack.outside;
    is_usable.then_some((Primitive::Cuboid { centre, axes, half }, outside))
}

/// 0 for a point inside.
fn distance_outside(hull: &ConvexHull, point: Vector) -> f64 {
    let is_inside = hull.planes().iter().all(|(normal, offset)| dot(*normal, point) <= *offset);
    if is_inside {
        return 0.0;
    }
    let faces = hull.corners().map(|[a, b, c]| {
        length(closest_point_on_triangle(
            subtract(a, point),
            subtract(b, point),
            subtract(c, point),
        ))
    });
    faces.fold(f64::INFINITY, f64::min)
}

/// How far a point is behind the nearest plane.
fn depth(planes: &[(Vector, f64)], point: Vector) -> f64 {
    let depths = planes.iter().map(|(normal, offset)| offset - dot(*normal, point));
    depths.fold(f64::INFINITY, f64::min)
}

/// A radius within slack: the hull reaches to `farthest` from the middle and is `depth` deep there.
fn radius(farthest: f64, depth: f64, slack: Slack) -> Option<f64> {
    let (least, most) = (farthest - slack.inside, depth + slack.outside);
    let middle = (farthest + depth) / 2.0;
    (least <= most && most > 0.0 && depth > 0.0).then(|| middle.clamp(least, most))
}

fn ball(hull: &ConvexHull, planes: &[(Vector, f64)], slack: Slack) -> Option<Fit> {
    let (low, high) = bounds(hull.points.iter().copied());
    let centre = scale(add(low, high), 0.5);
    let farthest = hull.points.iter().map(|point| distance(*point, centre)).fold(0.0, f64::max);
    let depth = depth(planes, centre);
    let radius = radius(farthest, depth, slack)?;
    Some((Primitive::Ball { centre, radius }, farthest - depth))
}

fn capsule(hull: &ConvexHull, planes: &[(Vector, f64)], axis: Vector, slack: Slack) -> Option<Fit> {
    // Any two directions upright to the axis.
    let least = (0..3).min_by(|a, b| axis[*a].abs().total_cmp(&axis[*b].abs()))?;
    let mut other = [0.0; 3];
    other[least] = 1.0;
    let second = normalize(cross(axis, other));
    let (centre, half) = extent(hull, [axis, second, cross(axis, second)]);
    let across = |point: &Vector| {
        let from_centre = subtract(*point, centre);
        length(subtract(from_centre, scale(axis, dot(axis, from_centre))))
    };
    let widest = hull.points.iter().map(across).fold(0.0, f64::max);
    let along = half[0] - widest;
    if along <= 0.0 {
        return None;
    }
    let ends = [-along, along].map(|along| add(centre, scale(axis, along)));
    let to_segment = |point: &Vector| {
        let place = dot(axis, subtract(*point, centre)).clamp(-along, along);
        distance(*point, add(centre, scale(axis, place)))
    };
    let farthest = hull.points.iter().map(to_segment).fold(0.0, f64::max);
    let depth = ends.map(|end| depth(planes, end)).into_iter().fold(f64::INFINITY, f64::min);
    let radius = radius(farthest, depth, slack)?;
    Some((Primitive::Capsule { ends, radius }, farthest - depth))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;

    fn sphere(rings: usize) -> Vec<Vector> {
        let turn = |share: f64| (share * std::f64::consts::TAU).sin_cos();
        let ring = move |ring: usize| {
            let (sin, cos) = turn(0.5 * (ring as f64 + 0.5) / rings as f64);
            (0..2 * rings).map(move |step| {
                let (y, x) = turn(step as f64 / (2 * rings) as f64);
                [sin * x, sin * y, cos]
            })
        };
        (0..rings).flat_map(ring).collect()
    }

    fn corners(half: Vector) -> Vec<Vector> {
        let sign = |index: usize, axis: usize| if index >> axis & 1 == 1 { 1.0 } else { -1.0 };
        (0..8).map(|index| [0, 1, 2].map(|axis| sign(index, axis) * half[axis])).collect()
    }

    /// Turned and moved, so that nothing lies along the axes.
    fn placed(points: &[Vector]) -> ConvexHull {
        let axes = [[0.6, 0.8, 0.0], [-0.8 * 0.6, 0.36, 0.8], [0.64, -0.48, 0.6]];
        let placed = points.iter().map(|point| add(in_space(*point, axes), [5.0, -3.0, 2.0]));
        convex_hull(&placed.collect::<Vec<_>>()).unwrap()
    }

    fn slack(both: f64) -> Slack {
        Slack { outside: both, inside: both }
    }

    #[test]
    fn a_turned_box_is_a_box_of_its_size() {
        let hull = placed(&corners([3.0, 2.0, 0.5]));
        let Some(Primitive::Cuboid { centre, half, .. }) = fit_primitive(&hull, slack(1e-6)) else {
            panic!("it is no box");
        };
        let mut half = half;
        half.sort_by(f64::total_cmp);
        assert!(
            distance(half, [0.5, 2.0, 3.0]) < 1e-6 && distance(centre, [5.0, -3.0, 2.0]) < 1e-6
        );
    }

    #[test]
    fn round_hulls_are_balls_and_capsules_within_their_slack_and_not_below() {
        let ball = placed(&sphere(10));
        assert!(matches!(
            fit_primitive(&ball, slack(0.03)),
            Some(Primitive::Ball { radius, .. }) if (radius - 1.0).abs() < 0.03
        ));
        // Where the slack allows more, the radius is still halfway between what is in and what is out.
        assert!(matches!(
            fit_primitive(&ball, slack(0.2)),
            Some(Primitive::Ball { radius, .. }) if (radius - 1.0).abs() < 0.03
        ));
        assert_eq!(fit_primitive(&ball, slack(0.001)), None);
        let long: Vec<Vector> =
            sphere(10).iter().map(|[x, y, z]| [*x, *y, z + 2.0 * z.signum()]).collect();
        let capsule = placed(&long);
        let Some(Primitive::Capsule { ends: [a, b], radius }) =
            fit_primitive(&capsule, slack(0.05))
        else {
            panic!("it is no capsule");
        };
        assert!((distance(a, b) - 4.0).abs() < 0.1 && (radius - 1.0).abs() < 0.05);
        assert_eq!(fit_primitive(&capsule, slack(0.001)), None);
    }

    #[test]
    fn other_hulls_stay_hulls() {
        let wedge = [
            [0.0; 3],
            [2.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [2.0, 0.0, 1.0],
            [0.0, 1.0, 1.0],
        ];
        assert_eq!(fit_primitive(&placed(&wedge), slack(0.05)), None);
        let cube = placed(&corners([1.0; 3]));
        for (outside, inside) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, f64::NAN)] {
            assert_eq!(fit_primitive(&cube, Slack { outside, inside }), None);
        }
    }

    /// Against many points on both surfaces.
    #[test]
    fn what_is_found_is_within_its_slack_both_ways() {
        let mut long = sphere(6);
        long.iter_mut().for_each(|point| point[2] += 1.5 * point[2].signum());
        let mut cut = corners([1.0, 0.8, 0.6]);
        cut[7] = [0.95, 0.77, 0.58];
        // The corner that is cut off is 0.0616 from what is left: no box can be nearer.
        for (points, both) in [(sphere(8), 0.05), (long, 0.12), (cut, 0.062)] {
            let hull = placed(&points);
            let found = fit_primitive(&hull, slack(both))
                .unwrap_or_else(|| panic!("no primitive within {both}"));
            let outside = |point: &Vector| match found {
                Primitive::Ball { centre, radius } => distance(*point, centre) - radius,
                Primitive::Capsule { ends: [a, b], radius } => {
                    let along = normalize(subtract(b, a));
                    let place = dot(along, subtract(*point, a)).clamp(0.0, distance(a, b));
                    distance(*point, add(a, scale(along, place))) - radius
                }
                Primitive::Cuboid { centre, axes, half } => {
                    let from_centre = subtract(*point, centre);
                    let over = [0, 1, 2]
                        .map(|axis| (dot(axes[axis], from_centre).abs() - half[axis]).max(0.0));
                    length(over)
                }
            };
            assert!(hull.points.iter().all(|point| outside(point) <= both + 1e-9));
            for direction in sphere(20) {
                let on_surface = match found {
                    Primitive::Ball { centre, radius } => {
                        vec![add(centre, scale(direction, radius))]
                    }
                    Primitive::Capsule { ends, radius } => {
                        ends.map(|end| add(end, scale(direction, radius))).to_vec()
                    }
                    Primitive::Cuboid { centre, axes, half } => {
                        let reach = [0, 1, 2]
                            .map(|axis| (1.5 * direction[axis]).clamp(-1.0, 1.0) * half[axis]);
                        vec![add(centre, in_space(reach, axes))]
                    }
                };
                assert!(
                    on_surface.iter().all(|point| distance_outside(&hull, *point) <= both + 1e-9)
                );
            }
        }
    }
}
