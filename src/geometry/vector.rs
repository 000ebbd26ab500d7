//! Vectors: glam's inside, arrays at the public surface.

/// A point or a direction.
pub type Vector = glam::DVec3;

/// `x * x`. Unlike `powi`, whose rounding is left to the compiler, the same everywhere.
#[inline]
pub fn squared(x: f64) -> f64 {
    x * x
}

/// `x * x * x`, likewise.
#[inline]
pub fn cubed(x: f64) -> f64 {
    x * x * x
}

/// Arrays of coordinates as vectors, in place.
#[inline]
pub fn as_vectors(points: &[[f64; 3]]) -> &[Vector] {
    bytemuck::cast_slice(points)
}

/// Vectors as arrays of coordinates, in place.
#[inline]
pub fn as_arrays(points: &[Vector]) -> &[[f64; 3]] {
    bytemuck::cast_slice(points)
}

/// Arrays of coordinates as vectors, in the same memory.
#[inline]
pub fn into_vectors(points: Vec<[f64; 3]>) -> Vec<Vector> {
    bytemuck::cast_vec(points)
}

/// Vectors as arrays of coordinates, in the same memory.
#[inline]
pub fn into_arrays(points: Vec<Vector>) -> Vec<[f64; 3]> {
    bytemuck::cast_vec(points)
}

/// The least and the greatest corner of points' bounding box; inside out without any.
#[inline]
pub fn bounds(points: impl IntoIterator<Item = Vector>) -> (Vector, Vector) {
    let nothing = (Vector::INFINITY, Vector::NEG_INFINITY);
    // In this order, coordinates that are not numbers are passed over.
    let with = |(min, max), point: Vector| (point.min(min), point.max(max));
    points.into_iter().fold(nothing, with)
}

/// Diagonal of points' bounding box; 0 where that is not finite.
pub fn diagonal(points: impl IntoIterator<Item = Vector>) -> f64 {
    let (min, max) = bounds(points);
    let diagonal = min.distance(max);
    if diagonal.is_finite() { diagonal } else { 0.0 }
}

/// Twice the area of a triangle times its unit normal.
#[inline]
pub fn area_normal(a: Vector, b: Vector, c: Vector) -> Vector {
    (b - a).cross(c - a)
}
