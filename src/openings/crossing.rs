//! Whether the surface goes through a cap.

use super::cap::Cap;
use crate::bvh::Bvh;
use crate::geometry::vector::{Vector, add, bounds, scale, subtract};

/// Corners nearer to the plane than this lie in it, in diagonals: the rounding of single precision and
/// welding stay below.
const IN_PLANE: f64 = 1e-5;

/// Points that are tried along the line in which a triangle cuts the plane.
const POINTS: u32 = 5;

/// Whether a triangle for which `counts` holds goes through the cap, farther than `margin` from its
/// rim.
pub(super) fn is_cut(
    cap: &Cap,
    (positions, triangles): (&[Vector], &[[u32; 3]]),
    bvh: &Bvh,
    margin: f64,
    counts: impl Fn(u32) -> bool,
) -> bool {
    let corners = cap.triangles.as_flattened().iter().map(|&vertex| positions[vertex as usize]);
    let (low, high) = bounds(corners);
    let near = bvh.triangles_near_box(low, high, IN_PLANE);
    near.into_iter().filter(|&triangle| counts(triangle)).any(|triangle| {
        // The tree may hold caps too, which are not in `triangles`.
        let Some(corners) = triangles.get(triangle as usize) else { return false };
        let corners = corners.map(|vertex| positions[vertex as usize]);
        let Some([from, to]) = line_in_plane(cap, corners) else { return false };
        (0..POINTS).any(|number| {
            let share = (f64::from(number) + 0.5) / f64::from(POINTS);
            let point = add(from, scale(subtract(to, from), share));
            cap.holds(cap.flatten(point), margin)
        })
    })
}

/// Where a triangle that has corners on both sides of the plane cuts it.
fn line_in_plane(cap: &Cap, corners: [Vector; 3]) -> Option<[Vector; 2]> {
    let heights = corners.map(|corner| cap.height(corner));
    let is_above = heights.iter().any(|&height| height > IN_PLANE);
    let is_below = heights.iter().any(|&height| height < -IN_PLANE);
    if !is_above || !is_below {
        return None;
    }
    let mut points = (0..3).filter_map(|side| {
        let (a, b) = (side, (side + 1) % 3);
        let crosses = (heights[a] > 0.0) != (heights[b] > 0.0);
        let share = heights[a] / (heights[a] - heights[b]);
        crosses.then(|| add(corners[a], scale(subtract(corners[b], corners[a]), share)))
    });
    Some([points.next()?, points.next()?])
}
