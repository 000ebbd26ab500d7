//! A cap on the vertices of a hull: a certified step that only lets it grow.
//!
//! The vertices that stand out most are kept, one after the other. Then each face of their hull
//! that others still lie in front of takes its corners outward until it holds them; what little
//! is left after some rounds is made up for by scaling about the centre, whose factor is exact:
//! the largest, over the kept hull's planes, of the reach of the old hull over that of the new one.

use super::columns::Columns;
use super::simplex::first_simplex;
use super::{ConvexHull, HullBuilder, Shape};
use crate::vector::{Vector, add, distance, dot, scale, subtract};

/// Rounding when the vertices are moved must not let an old vertex out again.
const ROUNDING: f64 = 1e-12;

/// Rounds of moving corners outward. After three, next to nothing is left to do.
const ROUNDS: usize = 4;

/// Steps in which a corner is moved beyond all of its faces.
const PROJECTIONS: usize = 4;

/// A hull of at most `cap` vertices that holds all of `hull`, and how far it grew: no point of it
/// is farther than that from the old one, in the points' units. A hull within the cap is returned
/// as it is. With a cap below 4 the hull stays as it is too.
///
/// O(cap · vertices · faces of the new hull).
pub fn cap_vertices(builder: &mut HullBuilder, hull: ConvexHull, cap: usize) -> (ConvexHull, f64) {
    if hull.points.len() <= cap {
        return (hull, 0.0);
    }
    match cap_vertices_within(builder, &hull, cap, 0.0) {
        Some(capped) => capped,
        None => (hull, 0.0),
    }
}

/// The same, but vertices may stay outside by up to `slack` in front of a face, in the points'
/// units: less growth, and none where the most prominent vertices leave no more than that.
pub(crate) fn cap_vertices_within(
    builder: &mut HullBuilder,
    hull: &ConvexHull,
    cap: usize,
    slack: f64,
) -> Option<(ConvexHull, f64)> {
    let kept = most_prominent(builder, &hull.points, cap, slack)?;
    grown_over(builder, kept, hull, slack)
}

/// A hull of fewer vertices: those that stand out of the rest by more than `tolerance`, moved
/// outward until no other is more than `slack` in front of a face. How far it grew comes with it.
/// O(n log n) expected for n vertices.
pub(crate) fn fewer_vertices(
    builder: &mut HullBuilder,
    hull: &ConvexHull,
    tolerance: f64,
    slack: f64,
) -> Option<(ConvexHull, f64)> {
    let mut coarse = HullBuilder::new().with_least_tolerance(tolerance);
    if coarse.build(&hull.points) != Shape::Solid {
        return None;
    }
    grown_over(builder, coarse.extract().into(), hull, slack)
}

/// Moves the vertices of `kept` outward until no vertex of `hull` is more than `slack` in front
/// of a face.
fn grown_over(
    builder: &mut HullBuilder,
    mut kept: ConvexHull,
    hull: &ConvexHull,
    slack: f64,
) -> Option<(ConvexHull, f64)> {
    let inner = kept.points.clone();
    for _ in 0..ROUNDS {
        let Some(moved) = moved_outward(&kept, &hull.points, slack) else { break };
        if builder.build(&moved) != Shape::Solid {
            return None;
        }
        kept = builder.extract().into();
    }
    let sum = kept.points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
    let centre = scale(sum, 1.0 / kept.points.len() as f64);
    let mut factor: f64 = 1.0;
    for (normal, offset) in kept.planes() {
        let own = offset - dot(normal, centre);
        let wanted = reach(&hull.points, normal, centre) - slack;
        if own > 0.0 {
            factor = factor.max(wanted / own);
        } else if normal != [0.0; 3] {
            return None;
        }
    }
    if factor > 1.0 {
        let factor = factor * (1.0 + ROUNDING);
        for point in &mut kept.points {
            *point = add(centre, scale(subtract(*point, centre), factor));
        }
    }
    // Each new vertex comes from one of the old hull, the nearest of which is at least as near.
    let from_old = |&point: &Vector| {
        inner.iter().map(|&old| distance(point, old)).fold(f64::INFINITY, f64::min)
    };
    let growth = kept.points.iter().map(from_old).fold(0.0, f64::max);
    Some((kept, growth))
}

/// The hull of the `cap` most prominent vertices, which does not grow, and how far in front of
/// its faces the others lie.
pub(crate) fn inner_hull(
    builder: &mut HullBuilder,
    hull: &ConvexHull,
    cap: usize,
) -> Option<(ConvexHull, f64)> {
    let kept = most_prominent(builder, &hull.points, cap, 0.0)?;
    let beyond = kept
        .planes()
        .iter()
        .map(|&(normal, offset)| reach(&hull.points, normal, [0.0; 3]) - offset)
        .fold(0.0, f64::max);
    Some((kept, beyond))
}

/// The vertices, moved so that no point is more than `slack` in front of a face as it was. `None`
/// if none is anyway.
fn moved_outward(kept: &ConvexHull, points: &[Vector], slack: f64) -> Option<Vec<Vector>> {
    let planes = kept.planes();
    let mut wishes: Vec<Vec<(Vector, f64)>> = vec![Vec::new(); kept.points.len()];
    let mut is_any = false;
    for (&(normal, offset), triangle) in planes.iter().zip(&kept.triangles) {
        let missing = reach(points, normal, [0.0; 3]) - offset - slack;
        if missing > ROUNDING && normal != [0.0; 3] {
            is_any = true;
            for &vertex in triangle {
                wishes[vertex as usize].push((normal, missing));
            }
        }
    }
    let moved = kept.points.iter().zip(&wishes).map(|(&point, wishes)| {
        let mut by = [0.0; 3];
        for _ in 0..PROJECTIONS {
            for &(normal, missing) in wishes {
                let left = missing - dot(normal, by);
                if left > 0.0 {
                    by = add(by, scale(normal, left));
                }
            }
        }
        add(point, by)
    });
    is_any.then(|| moved.collect())
}

/// How far points reach along a direction, seen from `centre`.
fn reach(points: &[Vector], direction: Vector, centre: Vector) -> f64 {
    let along = points.iter().map(|&point| dot(direction, subtract(point, centre)));
    along.fold(f64::NEG_INFINITY, f64::max)
}

/// The hull of up to `cap` points, each chosen for being farthest outside the hull of those
/// before, until none is farther out than `slack`.
fn most_prominent(
    builder: &mut HullBuilder,
    points: &[Vector],
    cap: usize,
    slack: f64,
) -> Option<ConvexHull> {
    let mut chosen = first_points(points);
    if builder.build(&chosen) != Shape::Solid || chosen.len() > cap {
        return None;
    }
    while chosen.len() < cap {
        let planes = ConvexHull::from(builder.extract()).planes();
        let outside = |point: Vector| {
            let distances = planes.iter().map(|&(normal, offset)| dot(normal, point) - offset);
            distances.fold(f64::NEG_INFINITY, f64::max)
        };
        let farthest = points
            .iter()
            .map(|&point| (outside(point), point))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        if farthest.0 <= slack {
            break;
        }
        chosen.push(farthest.1);
        builder.insert(&[farthest.1]);
    }
    Some(builder.extract().into())
}

/// Four points that span a tetrahedron: two far apart, one far from their line, one far from
/// their plane.
fn first_points(points: &[Vector]) -> Vec<Vector> {
    let (_, simplex) = first_simplex(points, &Columns::new(points), 0.0);
    simplex.iter().filter_map(|&index| points.get(index as usize).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;

    fn sphere(count: u32) -> ConvexHull {
        // Fibonacci's lattice.
        let points: Vec<Vector> = (0..count)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
                let angle = f64::from(i) * std::f64::consts::PI * (3.0 - 5f64.sqrt());
                let ring = (1.0 - z * z).sqrt();
                [ring * angle.cos(), ring * angle.sin(), z]
            })
            .collect();
        convex_hull(&points).unwrap()
    }

    fn holds(outer: &ConvexHull, inner: &ConvexHull) -> bool {
        outer.planes().iter().all(|&(normal, offset)| {
            inner.points.iter().all(|&point| dot(normal, point) - offset <= 1e-9)
        })
    }

    #[test]
    fn a_capped_hull_holds_the_old_one_and_says_how_far_it_grew() {
        let full = sphere(300);
        for (cap, most) in [(64, 0.15), (32, 0.3), (8, 1.5)] {
            let (capped, growth) = cap_vertices(&mut HullBuilder::new(), full.clone(), cap);
            assert!(capped.points.len() <= cap);
            assert!(holds(&capped, &full), "{cap}");
            assert!(holds(&capped, &capped), "{cap} is convex");
            let farthest = capped.points.iter().map(|&p| distance(p, [0.0; 3])).fold(0.0, f64::max);
            assert!(farthest - 1.0 <= growth + 1e-9);
            assert!(growth < most, "{cap}: {growth}");
        }
    }

    #[test]
    fn a_hull_within_the_cap_is_left_alone() {
        let full = sphere(30);
        assert_eq!(cap_vertices(&mut HullBuilder::new(), full.clone(), 30), (full, 0.0));
    }

    #[test]
    fn a_thin_plate_stays_thin() {
        let rim = (0..100).flat_map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 100.0;
            [0.0, 0.02].map(|z| [angle.cos(), angle.sin(), z])
        });
        let plate = convex_hull(&rim.collect::<Vec<_>>()).unwrap();
        let (capped, _) = cap_vertices(&mut HullBuilder::new(), plate.clone(), 64);
        let bounds = capped.bounds().unwrap();
        assert!(holds(&capped, &plate));
        assert!(bounds.max[2] - bounds.min[2] < 0.03, "{bounds:?}");
    }
}
