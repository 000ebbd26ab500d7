//! Affine transforms of glTF nodes.

use crate::geometry::vector::{Vector, add, cross, dot, scale};

/// A 3×3 matrix, by columns, and a translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transform {
    pub columns: [Vector; 3],
    pub translation: Vector,
}

impl Transform {
    pub(super) const IDENTITY: Self = Self {
        columns: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// From a 4×4 matrix by columns, whose last row is taken as (0, 0, 0, 1).
    pub(super) fn from_matrix(matrix: [f32; 16]) -> Self {
        let (columns, _) = matrix.as_chunks::<4>();
        let column = |index: usize| {
            let [x, y, z, _] = columns[index];
            [x, y, z].map(f64::from)
        };
        Self { columns: [column(0), column(1), column(2)], translation: column(3) }
    }

    /// First scaled, then rotated by a quaternion (x, y, z, w), then moved.
    pub(super) fn from_parts(translation: [f32; 3], rotation: [f32; 4], size: [f32; 3]) -> Self {
        let [x, y, z, w] = rotation.map(f64::from);
        let length_squared = x * x + y * y + z * z + w * w;
        // A quaternion of length 0 or infinite turns nothing.
        let s = if length_squared.is_normal() { 2.0 / length_squared } else { 0.0 };
        let rotated = [
            [1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)],
            [s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)],
            [s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)],
        ];
        let mut columns = rotated;
        for (column, factor) in columns.iter_mut().zip(size) {
            *column = scale(*column, f64::from(factor));
        }
        Self { columns, translation: translation.map(f64::from) }
    }

    /// First `inner`, then this one.
    pub(super) fn after(&self, inner: &Self) -> Self {
        Self {
            columns: inner.columns.map(|column| self.turn(column)),
            translation: self.apply(inner.translation),
        }
    }

    pub(super) fn apply(&self, point: Vector) -> Vector {
        add(self.turn(point), self.translation)
    }

    /// Whether left and right change places.
    pub(super) fn is_mirroring(&self) -> bool {
        let [a, b, c] = self.columns;
        dot(cross(a, b), c) < 0.0
    }

    fn turn(&self, direction: Vector) -> Vector {
        let [a, b, c] = self.columns;
        let [x, y, z] = direction;
        add(add(scale(a, x), scale(b, y)), scale(c, z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::distance;

    #[test]
    fn scale_comes_before_rotation_and_translation() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let quarter_turn_about_z = [0.0, 0.0, half, half];
        let transform =
            Transform::from_parts([10.0, 0.0, 0.0], quarter_turn_about_z, [2.0, 1.0, -1.0]);
        assert!(distance(transform.apply([1.0, 0.0, 5.0]), [10.0, 2.0, -5.0]) < 1e-6);
        assert!(transform.is_mirroring());
        assert!(!transform.after(&transform).is_mirroring());
    }

    #[test]
    fn a_child_is_placed_before_its_parent() {
        let parent = Transform::from_parts([1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [2.0; 3]);
        let mut matrix = [0.0; 16];
        for diagonal in [0, 5, 10, 15] {
            matrix[diagonal] = 1.0;
        }
        matrix[13] = 3.0;
        let child = Transform::from_matrix(matrix);
        assert_eq!(parent.after(&child).apply([0.0; 3]), [1.0, 6.0, 0.0]);
    }

    #[test]
    fn an_unnormalised_quaternion_only_turns() {
        let transform = Transform::from_parts([0.0; 3], [0.0, 0.0, 3.0, 0.0], [1.0; 3]);
        assert_eq!(transform.apply([1.0, 2.0, 3.0]), [-1.0, -2.0, 3.0]);
        let broken = Transform::from_parts([0.0; 3], [0.0; 4], [1.0; 3]);
        assert_eq!(broken, Transform::IDENTITY);
    }
}
