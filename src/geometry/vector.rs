//! Vectors of three `f64`: the few operations that the pipeline needs.

/// A point or a direction.
pub type Vector = [f64; 3];

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

/// `a + b`.
#[inline]
pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline]
pub fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a` times a factor.
#[inline]
pub fn scale(a: Vector, factor: f64) -> Vector {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}

/// The scalar product.
#[inline]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
#[inline]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The square of the length.
#[inline]
pub fn length_squared(a: Vector) -> f64 {
    dot(a, a)
}

/// The length.
#[inline]
pub fn length(a: Vector) -> f64 {
    length_squared(a).sqrt()
}

/// The distance between two points.
#[inline]
pub fn distance(a: Vector, b: Vector) -> f64 {
    length(subtract(a, b))
}

/// The unit vector along `a`, or zero where `a` has no direction.
#[inline]
pub fn normalize(a: Vector) -> Vector {
    let length = length(a);
    if length > 0.0 && length.is_finite() { scale(a, 1.0 / length) } else { [0.0; 3] }
}

/// The lesser of each coordinate.
#[inline]
pub fn minimum(a: Vector, b: Vector) -> Vector {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].min(b[2])]
}

/// The greater of each coordinate.
#[inline]
pub fn maximum(a: Vector, b: Vector) -> Vector {
    [a[0].max(b[0]), a[1].max(b[1]), a[2].max(b[2])]
}

/// The least and the greatest corner of points' bounding box; inside out without any.
#[inline]
pub fn bounds(points: impl IntoIterator<Item = Vector>) -> (Vector, Vector) {
    let nothing = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let with = |(min, max), point| (minimum(min, point), maximum(max, point));
    points.into_iter().fold(nothing, with)
}

/// Diagonal of points' bounding box; 0 where that is not finite.
pub fn diagonal(points: impl IntoIterator<Item = Vector>) -> f64 {
    let (min, max) = bounds(points);
    let diagonal = distance(min, max);
    if diagonal.is_finite() { diagonal } else { 0.0 }
}

/// Twice the area of a triangle times its unit normal.
#[inline]
pub fn area_normal(a: Vector, b: Vector, c: Vector) -> Vector {
    cross(subtract(b, a), subtract(c, a))
}
