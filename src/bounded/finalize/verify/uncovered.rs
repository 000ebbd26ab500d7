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
const TRIANGLES_PER_CHECK: usize = 256;

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
