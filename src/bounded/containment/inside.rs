//! Which points are inside a surface.

use super::boundary::Boundary;
use crate::bvh::Bvh;
use crate::geometry::vector::Vector;

/// Where the surface is open, a winding number above this is inside. On both sides of a flat sheet
/// it is one half, so that rounding would decide.
pub(in crate::bounded) const OPEN_INSIDE: f64 = 0.52;

/// Whether a point is inside a surface.
#[inline]
pub(in crate::bounded) fn is_inside(bvh: &Bvh, point: Vector, is_closed: bool) -> bool {
    if is_closed { bvh.is_inside(point) } else { bvh.winding_number(point) > OPEN_INSIDE }
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
