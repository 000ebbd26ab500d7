//! A cap on the vertices of a hull: a step that provably only lets it grow.
//!
//! Edges collapse outward until few enough are left (see `collapse`); or the vertices that stand
//! out most are kept, and their hull grows about its centre: what grows less counts. What has very
//! many vertices first leaves out those that hardly stand out.

use super::builder::HullBuilder;
use super::collapse::{collapse_edges, growth};
use super::columns::Columns;
use super::convex_hull::ConvexHull;
use super::simplex::Shape;
use super::simplex::first_simplex;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, dot, scale, subtract};

/// Rounding when the vertices are moved must not let an old vertex out again.
const ROUNDING: f64 = 1e-12;

/// More vertices than this are thinned out before edges collapse, which takes time like their
/// square.
const MANY_VERTICES: usize = 512;

/// The first tolerance of thinning out, as a share of the hull's extent; it is doubled as long as it
/// is too fine.
const THINNING: f64 = 1e-4;

/// A hull of at most `cap` vertices that holds all of `hull`, and how far it grew: no point of it
/// is farther than that from the old one, in the points' units. A hull within the cap is returned
/// as it is. With a cap below 4 the hull stays as it is too.
///
/// O(n log n + cap² n) for n vertices.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn cap_vertices(
    builder: &mut HullBuilder,
    hull: ConvexHull,
    cap: usize,
    control: &Control,
) -> Result<(ConvexHull, f64), Error> {
    if hull.points.len() <= cap {
        return Ok((hull, 0.0));
    }
    let thin = match hull.points.len() {
        ..=MANY_VERTICES => None,
        _ => thinned(builder, &hull, control)?,
    };
    let mut fits = |_| control.check().map(|()| true);
    let collapsed = collapse_edges(thin.as_ref().unwrap_or(&hull), 0.0, cap, control, &mut fits)?;
    let collapsed = collapsed.map(|(collapsed, _)| collapsed);
    // For a handful of vertices the shortest way there is not the best.
    let prominent = most_prominent(builder, &hull.points, cap, control)?;
    let capped = [thin, collapsed, prominent].into_iter().flatten();
    let capped = capped.filter(|capped| capped.points.len() <= cap).filter_map(|capped| {
        let grown = grown_over(capped, &hull)?;
        let growth = growth(&grown, &hull);
        Some((grown, growth))
    });
    Ok(capped.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((hull, 0.0)))
}

/// A hull of the vertices that stand out of the rest by more than a tolerance: about the least that
/// leaves few enough.
fn thinned(
    builder: &mut HullBuilder,
    hull: &ConvexHull,
    control: &Control,
) -> Result<Option<ConvexHull>, Error> {
    let mut share = THINNING;
    while share < 1.0 {
        let mut coarse = HullBuilder::new().with_tolerance(share);
        if coarse.build(&hull.points) != Shape::Solid {
            break;
        }
        let (points, triangles) = coarse.extract();
        if points.len() <= MANY_VERTICES {
            return Ok(Some((points, triangles).into()));
        }
        control.check()?;
        share *= 2.0;
    }
    most_prominent(builder, &hull.points, MANY_VERTICES, control)
}

/// The hull of the vertices that stand out of each other by more than `tolerance`, in the points'
/// units: the others are at most that far in front of a face. `None` if none is left.
pub(crate) fn coarser(hull: &ConvexHull, tolerance: f64) -> Option<ConvexHull> {
    let mut builder = HullBuilder::new().with_least_tolerance(tolerance);
    (builder.build(&hull.points) == Shape::Solid).then(|| builder.extract().into())
}

/// Lets `kept` grow about its centre until it holds `hull`. The factor is exact: the largest, over
/// the kept hull's planes, of the reach of the old hull over that of the new one.
fn grown_over(mut kept: ConvexHull, hull: &ConvexHull) -> Option<ConvexHull> {
    let sum = kept.points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
    let centre = scale(sum, 1.0 / kept.points.len() as f64);
    let mut factor: f64 = 1.0;
    for (normal, offset) in kept.planes() {
        let own = offset - dot(normal, centre);
        let wanted = reach(&hull.points, normal, centre);
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
    Some(kept)
}

/// How far points reach along a direction, seen from `centre`.
fn reach(points: &[Vector], direction: Vector, centre: Vector) -> f64 {
    let along = points.iter().map(|&point| dot(direction, subtract(point, centre)));
    along.fold(f64::NEG_INFINITY, f64::max)
}

/// The hull of up to `cap` points, each chosen for being farthest outside the hull of those
/// before.
pub(crate) fn most_prominent(
    builder: &mut HullBuilder,
    points: &[Vector],
    cap: usize,
    control: &Control,
) -> Result<Option<ConvexHull>, Error> {
    let mut chosen = first_points(points);
    if builder.build(&chosen) != Shape::Solid || chosen.len() > cap {
        return Ok(None);
    }
    while chosen.len() < cap {
        control.check()?;
        let planes = ConvexHull::from(builder.extract()).planes();
        let outside = |point: Vector| {
            let distances = planes.iter().map(|&(normal, offset)| dot(normal, point) - offset);
            distances.fold(f64::NEG_INFINITY, f64::max)
        };
        let farthest =
            points.iter().map(|&point| (outside(point), point)).max_by(|a, b| a.0.total_cmp(&b.0));
        let Some(farthest) = farthest.filter(|farthest| farthest.0 > 0.0) else { break };
        chosen.push(farthest.1);
        builder.insert(&[farthest.1]);
        if builder.new_faces().next().is_none() {
            // It is nearer to the hull than the tolerance, and so are all others.
            break;
        }
    }
    Ok(Some(builder.extract().into()))
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
    use crate::geometry::vector::distance;
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

    fn capped(hull: &ConvexHull, cap: usize) -> (ConvexHull, f64) {
        cap_vertices(&mut HullBuilder::new(), hull.clone(), cap, &Control::new()).unwrap()
    }

    #[test]
    fn a_cancelled_cap_is_an_error() {
        let control = Control::new();
        control.cancel();
        let result = cap_vertices(&mut HullBuilder::new(), sphere(300), 64, &control);
        assert_eq!(result, Err(Error::Cancelled));
    }

    #[test]
    fn the_most_prominent_points_are_as_many_as_asked_for() {
        let full = sphere(300);
        for cap in [6, 7, 20, 64] {
            let mut builder = HullBuilder::new();
            let found =
                most_prominent(&mut builder, &full.points, cap, &Control::new()).unwrap().unwrap();
            assert_eq!(found.points.len(), cap);
            assert!(full.holds(&found));
        }
    }

    #[test]
    fn a_capped_hull_holds_the_old_one_and_says_how_far_it_grew() {
        let full = sphere(300);
        for (cap, most) in [(64, 0.12), (32, 0.25), (8, 1.5)] {
            let (capped, growth) = capped(&full, cap);
            assert!(capped.points.len() <= cap);
            assert!(capped.holds(&full), "{cap}");
            assert!(capped.holds(&capped), "{cap} is convex");
            let farthest = capped.points.iter().map(|&p| distance(p, [0.0; 3])).fold(0.0, f64::max);
            assert!(farthest - 1.0 <= growth + 1e-9);
            assert!(growth < most, "{cap}: {growth}");
        }
    }

    #[test]
    fn very_many_vertices_and_very_large_units_are_capped_too() {
        for factor in [1.0, 1e200, 1e-170] {
            let mut full = sphere(1500);
            full.points.iter_mut().for_each(|point| *point = scale(*point, factor));
            for cap in [64, 600] {
                let (capped, _) = capped(&full, cap);
                assert!(capped.points.len() <= cap, "{factor:e}");
            }
        }
        let full = sphere(1500);
        let (capped, growth) = capped(&full, 600);
        assert!(capped.holds(&full));
        assert!(growth < 0.02, "{growth}");
    }

    #[test]
    fn a_hull_within_the_cap_is_left_alone() {
        let full = sphere(30);
        assert_eq!(capped(&full, 30), (full, 0.0));
    }

    #[test]
    fn a_thin_plate_stays_thin() {
        let rim = (0..100).flat_map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 100.0;
            [0.0, 0.02].map(|z| [angle.cos(), angle.sin(), z])
        });
        let plate = convex_hull(&rim.collect::<Vec<_>>()).unwrap();
        let (capped, _) = capped(&plate, 64);
        let bounds = capped.bounds().unwrap();
        assert!(capped.holds(&plate));
        assert!(bounds.max[2] - bounds.min[2] < 0.03, "{bounds:?}");
    }
}
