//! Which points are inside a surface.

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

/// Where the surface is open, the inside ends without it, but gradually. Per open sheet, the
/// winding number falls by less than this over a distance equal to that from the surface.
const MAX_GRADIENT: f64 = 0.5;

/// The winding number just below an open sheet.
const BELOW_A_SHEET: f64 = 0.5;

/// All points nearer than this to a point are inside an open surface that is at least `distance`
/// away; `None` if the point itself is outside.
pub(in crate::bounded) fn inside_reach(bvh: &Bvh, point: Vector, distance: f64) -> Option<f64> {
    let number = bvh.winding_number(point);
    let excess = number - OPEN_INSIDE;
    // Each sheet above the point increases the gradient.
    let sheets = (number / BELOW_A_SHEET).max(1.0);
    (excess > 0.0).then(|| distance * (excess / (sheets * MAX_GRADIENT)).min(1.0))
}
