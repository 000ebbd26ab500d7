//! Vectors, and boxes around them.

/// A point or a direction.
pub type Vector = glam::DVec3;

/// The least and the greatest corner of points' bounding box; inside out without any.
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
