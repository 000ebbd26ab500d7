//! Triangles that tests halve until each part is decided.

use crate::geometry::vector::{Vector, add, area_normal, dot, length_squared, scale, subtract};

#[inline]
pub(in crate::bounded) fn centre([a, b, c]: [Vector; 3]) -> Vector {
    scale(add(add(a, b), c), 1.0 / 3.0)
}

/// The halves of a triangle across its longest side.
#[inline]
pub(in crate::bounded) fn halves([a, b, c]: [Vector; 3]) -> [[Vector; 3]; 2] {
    let squared = |a: Vector, b: Vector| length_squared(subtract(a, b));
    let (ab, bc, ca) = (squared(a, b), squared(b, c), squared(c, a));
    if ab >= bc && ab >= ca {
        let middle = scale(add(a, b), 0.5);
        [[a, middle, c], [middle, b, c]]
    } else if bc >= ca {
        let middle = scale(add(b, c), 0.5);
        [[a, b, middle], [a, middle, c]]
    } else {
        let middle = scale(add(c, a), 0.5);
        [[a, b, middle], [middle, b, c]]
    }
}

/// Whether a point of a triangle's plane is in the triangle.
#[inline]
pub(in crate::bounded) fn is_within_sides([a, b, c]: [Vector; 3], point: Vector) -> bool {
    let normal = area_normal(a, b, c);
    [area_normal(a, b, point), area_normal(b, c, point), area_normal(c, a, point)]
        .into_iter()
        .all(|part| dot(part, normal) >= 0.0)
}
