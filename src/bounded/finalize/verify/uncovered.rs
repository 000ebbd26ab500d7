//! The uncovered distance: how far the surface lies outside all hulls. An upper bound.

use super::hull_distance::HullDistance;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, scale};
use crate::mesh::TriangleMesh;

/// Maximum number of times that a triangle whose corners are in different hulls is divided in four:
/// parts are then 256 times as short, and what remains is an upper bound. A side of a plain shape may be
/// one triangle.
const MAX_DIVISIONS: u32 = 8;

/// Triangles between two checks for cancellation. A divided one may take a millisecond, and has its own.
const TRIANGLES_PER_CHECK: usize = 64;

/// No point of the surface is farther than this outside all hulls. `owners` names for each triangle
/// the hull that should contain it; those without a valid one count as covered. The result is at
/// least `tolerance`: less counts as covered.
///
/// # Errors
/// [`Error::Cancelled`].
pub(in crate::bounded) fn uncovered_distance(
    surface: &TriangleMesh,
    owners: &[u32],
    hulls: &[HullDistance<'_>],
    tolerance: f64,
    control: &Control,
) -> Result<f64, Error> {
    // For each vertex its distances to the hulls that own triangles around it. The distance to a
    // convex set is a convex function: on a triangle it is largest at a corner.
    let mut known: Vec<Vec<(u32, f64)>> = vec![Vec::new(); surface.positions.len()];
    let mut worst = tolerance;
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
            control.check()?;
            let corners = triangle.map(|vertex| surface.positions[vertex as usize]);
            worst = worst.max(outside_all(corners, hulls, worst, outside, MAX_DIVISIONS));
        }
    }
    Ok(worst)
}

/// The same for a triangle that its owner does not contain: other hulls may contain parts of it.
/// `known` bounds its distance outside its owner.
fn outside_all(
    corners: [Vector; 3],
    hulls: &[HullDistance<'_>],
    worst: f64,
    known: f64,
    divisions: u32,
) -> f64 {
    let least = hulls.iter().fold(known, |least: f64, hull| {
        let outside = corners.iter().map(|&corner| hull.distance(corner, least));
        least.min(outside.fold(0.0, f64::max))
    });
    if least <= worst || divisions == 0 {
        return least;
    }
    let [a, b, c] = corners;
    let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| scale(add(p, q), 0.5));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        .into_iter()
        .fold(0.0, |most: f64, part| {
            most.max(outside_all(part, hulls, worst.max(most), least, divisions - 1))
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::{ConvexHull, convex_hull};
    use crate::mesh::shapes::cuboid;

    const TOLERANCE: f64 = 1e-4;

    fn boxes(ranges: &[[f64; 2]]) -> Vec<ConvexHull> {
        let hull = |&[low, high]: &[f64; 2]| cuboid([low, 0.0, 0.0], [high, 1.0, 1.0]).positions;
        ranges.iter().map(|range| convex_hull(&hull(range)).unwrap()).collect()
    }

    fn uncovered(positions: &[Vector], owners: &[u32], hulls: &[ConvexHull]) -> f64 {
        let triangles = [[0, 1, 2], [0, 3, 1]];
        let surface = TriangleMesh {
            positions: positions.to_vec(),
            triangles: triangles[..owners.len()].to_vec(),
            ..TriangleMesh::default()
        };
        let hulls: Vec<HullDistance<'_>> = hulls.iter().map(HullDistance::new).collect();
        uncovered_distance(&surface, owners, &hulls, TOLERANCE, &Control::new()).unwrap()
    }

    #[test]
    fn a_triangle_is_as_far_outside_as_its_farthest_corner() {
        let hulls = boxes(&[[0.0, 1.0]]);
        let inside = [[0.1, 0.2, 0.3], [0.9, 0.2, 0.3], [0.5, 0.8, 1.0]];
        assert_eq!(uncovered(&inside, &[0], &hulls), TOLERANCE);
        for corner in 0..3 {
            let mut positions = inside;
            positions[corner] = [1.3, 1.4, 0.5];
            let found = uncovered(&positions, &[0], &hulls);
            // An upper bound, and no more than a part's size too large.
            assert!((0.5 - 1e-12..0.51).contains(&found), "{corner}: {found}");
        }
    }

    #[test]
    fn a_vertex_counts_for_each_hull_that_owns_a_triangle_there() {
        // The first triangle is in the first box, and both share two vertices.
        let positions = [[0.9, 0.5, 0.5], [0.9, 0.6, 0.5], [0.2, 0.5, 0.5], [1.6, 0.5, 0.5]];
        let near = boxes(&[[0.0, 1.0], [0.95, 2.0]]);
        let found = uncovered(&positions, &[0, 1], &near);
        assert!(found <= 0.01, "{found}");
        let far = boxes(&[[0.0, 1.0], [1.4, 2.0]]);
        let found = uncovered(&positions, &[0, 1], &far);
        // From the middle of the gap.
        assert!((0.2..0.21).contains(&found), "{found}");
    }

    #[test]
    fn a_triangle_that_hulls_cover_together_is_covered_up_to_the_gap_between_them() {
        let positions = [[0.1, 0.1, 0.5], [1.9, 0.1, 0.5], [1.9, 0.9, 0.5]];
        for owner in [0, 1] {
            let found = uncovered(&positions, &[owner], &boxes(&[[0.0, 1.0], [1.0, 2.0]]));
            assert!(found < 0.01, "{found}");
            let found = uncovered(&positions, &[owner], &boxes(&[[0.0, 1.0], [1.2, 2.0]]));
            assert!((0.1..0.11).contains(&found), "{found}");
            let outside = [[0.1, 0.1, 0.5], [2.5, 0.1, 0.5], [1.9, 0.9, 0.5]];
            let found = uncovered(&outside, &[owner], &boxes(&[[0.0, 1.0], [1.2, 2.0]]));
            assert!((0.5 - 1e-12..0.51).contains(&found), "{found}");
        }
    }

    #[test]
    fn a_triangle_without_a_hull_counts_as_covered() {
        let positions = [[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]];
        assert_eq!(uncovered(&positions, &[u32::MAX], &boxes(&[[0.0, 1.0]])), TOLERANCE);
    }

    #[test]
    fn a_cancelled_measurement_is_an_error() {
        let control = Control::new();
        control.cancel();
        let surface = cuboid([0.0; 3], [1.0; 3]);
        let owners = vec![0; surface.triangles.len()];
        let result = uncovered_distance(&surface, &owners, &[], TOLERANCE, &control);
        assert_eq!(result, Err(Error::Cancelled));
    }
}
