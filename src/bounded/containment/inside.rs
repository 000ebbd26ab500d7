//! Which points are inside a surface.

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
