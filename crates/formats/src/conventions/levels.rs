//! Cells of a level: which small things that never move share a collider.

/// Beyond this many cells from the origin single precision has no place for things within a cell.
const FARTHEST: f32 = 1e6;

/// The cell of a cubic grid that a thing belongs to: the one in which the middle of its box is.
/// `None` for what is larger than a cell along any axis, or has no place. The box is in units of
/// the world, in the space of the scene's root. O(1).
///
/// ```
/// use hullwright_formats::conventions::level_cell;
///
/// assert_eq!(level_cell([11.0, -1.0, 0.0], [12.0, 0.0, 1.0], 10.0), Some([1, -1, 0]));
/// assert_eq!(level_cell([11.0, -1.0, 0.0], [22.0, 0.0, 1.0], 10.0), None);
/// ```
pub fn level_cell(low: [f32; 3], high: [f32; 3], size: f32) -> Option<[i32; 3]> {
    let mut cell = [0; 3];
    for axis in 0..3 {
        let index = (f32::midpoint(low[axis], high[axis]) / size).floor();
        let is_small = high[axis] - low[axis] <= size;
        if !(is_small && index.abs() <= FARTHEST) {
            return None;
        }
        cell[axis] = index as i32;
    }
    Some(cell)
}
