//! Whether a triangle has an area, within rounding.

use crate::geometry::vector::{Vector, area_normal, length_squared, subtract};

/// A triangle that is less high than this over its longest side, in diagonals of the bounding
/// box, has no area. It is below the rounding of coordinates in single precision, where the
/// normal of such a triangle means nothing.
const LEAST_HEIGHT: f64 = 1e-8;

/// Whether a triangle of the normalised mesh is, within rounding, no triangle.
pub(super) fn is_degenerate(positions: &[Vector], triangle: [u32; 3]) -> bool {
    let [i, j, k] = triangle;
    if i == j || j == k || k == i {
        return true;
    }
    let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
    let longest_squared = length_squared(subtract(b, a))
        .max(length_squared(subtract(c, b)))
        .max(length_squared(subtract(a, c)));
    length_squared(area_normal(a, b, c)) < LEAST_HEIGHT * LEAST_HEIGHT * longest_squared
}
