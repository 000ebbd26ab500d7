//! Which points are inside a surface.

use super::boundary::Boundary;
use crate::bvh::Bvh;
use crate::geometry::vector::Vector;

/// Where the surface is open, a winding number above this is inside. On both sides of a flat sheet
/// it is one half, so that rounding would decide.
pub(in crate::bounded) const OPEN_INSIDE: f64 = 0.52;

/// Whether a point is inside a surface. Of a closed one a ray tells.
#[inline]
pub(in crate::bounded) fn is_inside(bvh: &Bvh, point: Vector, is_closed: bool) -> bool {
    if is_closed { bvh.encloses(point) } else { bvh.winding_number(point) > OPEN_INSIDE }
}

/// All points nearer than this to a point are inside an open surface that is at least `distance`
/// away; `None` if the point itself is outside. With `needed`, a reach of less than that may be
/// returned as 0.
///
/// Where the surface is open, the inside ends without it, but gradually: over a way of length r
/// that stays within `distance` d, the winding number falls by no more than r / (1 - r / d) times the
/// gradient's bound at the point. (The distance to an edge falls by no more than the way's length, so
/// that the integral of one over its square along the way is at most that.)
pub(in crate::bounded) fn inside_reach(
    bvh: &Bvh,
    boundary: &Boundary,
    point: Vector,
    distance: f64,
    needed: f64,
) -> Option<f64> {
    let excess = bvh.winding_number(point) - OPEN_INSIDE;
    if excess <= 0.0 {
        return None;
    }
    if distance <= 0.0 || needed >= distance {
        return Some(0.0);
    }
    // No gradient above this leaves as much as is needed.
    let limit = if needed > 0.0 { excess * (1.0 / needed - 1.0 / distance) } else { f64::INFINITY };
    let gradient = boundary.gradient(point, distance, limit);
    Some(if gradient > limit { 0.0 } else { excess / (gradient + excess / distance) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{add, length, scale};

    /// Evenly spread in [-1, 1), another for each number.
    fn spread(number: u32) -> f64 {
        2.0 * (0.5 + 0.618_033_988_749_895 * f64::from(number)).fract() - 1.0
    }

    /// Loose triangles that face anyhow, so that their winding numbers add up and cancel.
    fn loose_triangles(seed: u32) -> (Vec<Vector>, Vec<[u32; 3]>) {
        let point =
            |k: u32| [0, 1, 2].map(|axis| 0.4 * spread(seed + 7 * k * k + 3 * k + 11 * axis));
        ((0..120).map(point).collect(), (0..40).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
    }

    #[test]
    fn within_its_reach_every_point_of_loose_triangles_is_inside() {
        let mut asked = 0;
        for seed in [0, 1000, 2000] {
            let (positions, triangles) = loose_triangles(seed);
            let bvh = Bvh::new(&positions, &triangles);
            let boundary = Boundary::new(&positions, &triangles);
            for number in 0..4000 {
                let at = [0, 1, 2].map(|axis| 0.4 * spread(5 * number * number + axis));
                let away = bvh.closest_point(at, f64::INFINITY).unwrap().distance;
                let Some(reach) = inside_reach(&bvh, &boundary, at, away, 0.0) else { continue };
                asked += 1;
                assert!(reach <= away);
                for k in 0..20 {
                    let way = [0, 1, 2].map(|axis| spread(17 * k + 5 * axis));
                    let point = add(at, scale(way, 0.999 * reach / length(way)));
                    // Up to the error of the expansion.
                    assert!(bvh.winding_number(point) > OPEN_INSIDE - 0.01, "{seed} {number}");
                }
            }
        }
        assert!(asked > 100, "{asked}");
    }

    #[test]
    fn sheets_that_cancel_do_not_hide_how_fast_the_number_falls() {
        // Eight sheets face up and seven down, a little smaller: around them the number is that of one
        // sheet, but near the edges it falls as fast as that of all.
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for sheet in 0..15_u32 {
            let (z, size) = (1e-3 * f64::from(sheet), if sheet % 2 == 0 { 0.5 } else { 0.45 });
            positions.extend([
                [-size, -size, z],
                [size, -size, z],
                [size, size, z],
                [-size, size, z],
            ]);
            let first = 4 * sheet;
            let corners =
                if sheet % 2 == 0 { [0, 1, 2, 3] } else { [3, 2, 1, 0] }.map(|k| first + k);
            triangles.extend([
                [corners[0], corners[1], corners[2]],
                [corners[0], corners[2], corners[3]],
            ]);
        }
        let boundary = Boundary::new(&positions, &triangles);
        let bvh = Bvh::new(&positions, &triangles);
        for x in [0.0, 0.2, 0.4, 0.46] {
            let (at, step) = ([x, 0.0, -0.05], 1e-3);
            let away = bvh.closest_point(at, f64::INFINITY).unwrap().distance;
            let slope = [0, 1, 2].map(|axis| {
                let [mut below, mut above] = [at; 2];
                below[axis] -= step;
                above[axis] += step;
                (bvh.winding_number(above) - bvh.winding_number(below)) / (2.0 * step)
            });
            let gradient = boundary.gradient(at, away, f64::INFINITY);
            assert!(length(slope) <= gradient, "{x}: {} {gradient}", length(slope));
        }
    }

    #[test]
    fn a_closed_surface_has_no_boundary() {
        let (positions, _) = loose_triangles(0);
        assert!(
            Boundary::new(&positions, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).is_empty()
        );
        assert!(!Boundary::new(&positions, &[[0, 1, 2], [0, 2, 3], [0, 3, 1]]).is_empty());
    }
}
