//! The points of a hull before it grows: their extent, the frame that brings them near 1, and the
//! first simplex.

use crate::geometry::vector::{Vector, area_normal};

/// In how many dimensions points extend, up to the hull's tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// They span a volume and have a hull.
    Solid,
    /// They lie in a plane.
    Flat,
    /// They lie on a line.
    Linear,
    /// They lie on one spot, or there are none.
    Point,
}

/// Moves points to their centre and scales them by a power of two, which rounds nothing, so that
/// their extent is between 1 and 2.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Frame {
    pub centre: Vector,
    pub factor: f64,
}

impl Frame {
    /// The frame of points within bounds, which are inside out without points.
    pub(super) fn around([low, high]: [Vector; 2]) -> Self {
        const MANTISSA: u64 = (1 << (f64::MANTISSA_DIGITS - 1)) - 1;
        /// 2 to the powers -1000 and 1000, clear of the ends of the range.
        const LIMITS: [f64; 2] = [f64::from_bits(23 << 52), f64::from_bits(2023 << 52)];
        let mut frame = Self { centre: Vector::ZERO, factor: 1.0 };
        let centre = low * 0.5 + high * 0.5;
        if is_finite(&centre) {
            frame.centre = centre;
        }
        let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        if extent > 0.0 && extent.is_finite() {
            let extent = extent.clamp(LIMITS[0], LIMITS[1]);
            frame.factor = 1.0 / f64::from_bits(extent.to_bits() & !MANTISSA);
        }
        frame
    }

    /// A point in the frame.
    #[inline]
    pub(super) fn inward(&self, point: Vector) -> Vector {
        (point - self.centre) * self.factor
    }

    /// A point of the frame in the points' units.
    pub(super) fn outward(&self, point: Vector) -> Vector {
        point * (1.0 / self.factor) + self.centre
    }
}

pub(super) fn is_finite(point: &Vector) -> bool {
    point.is_finite()
}

/// Bounds of points, inside out without any; `None` if a coordinate is not finite.
pub(super) fn finite_bounds(points: &[Vector]) -> Option<[Vector; 2]> {
    let [mut low, mut high, mut zero] = [Vector::INFINITY, Vector::NEG_INFINITY, Vector::ZERO];
    for point in points {
        for (axis, &x) in point.to_array().iter().enumerate() {
            low[axis] = if x < low[axis] { x } else { low[axis] };
            high[axis] = if x > high[axis] { x } else { high[axis] };
            // Becomes NaN where a coordinate is not finite.
            zero[axis] += 0.0 * x;
        }
    }
    (zero == Vector::ZERO).then_some([low, high])
}

/// The first point for which `measure` is greatest.
#[inline]
fn farthest(points: &[Vector], measure: impl Fn(Vector) -> f64) -> (u32, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, &point) in (0..).zip(points) {
        let value = measure(point);
        if value > best.1 {
            best = (index, value);
        }
    }
    best
}

/// Four points, far apart, that span a tetrahedron. For a lesser shape only as many of them count
/// as it has dimensions, and one more. O(n).
pub(super) fn first_simplex(points: &[Vector], tolerance: f64) -> (Shape, [u32; 4]) {
    let [a, b] = farthest_extremes(points);
    let corner = |index: u32| points[index as usize];
    if points.is_empty() || corner(a).distance(corner(b)) <= tolerance {
        return (Shape::Point, [a; 4]);
    }
    let direction = (corner(b) - corner(a)).normalize_or_zero();
    let (c, from_line) =
        farthest(points, |point| direction.cross(point - corner(a)).length_squared());
    if from_line.sqrt() <= tolerance {
        return (Shape::Linear, [a, b, a, a]);
    }
    let normal = area_normal(corner(a), corner(b), corner(c)).normalize_or_zero();
    let (d, from_plane) = farthest(points, |point| normal.dot(point - corner(a)).abs());
    if from_plane <= tolerance {
        return (Shape::Flat, [a, b, c, a]);
    }
    (Shape::Solid, [a, b, c, d])
}

/// Of the six extreme points along the axes the two that are farthest apart.
fn farthest_extremes(points: &[Vector]) -> [u32; 2] {
    let extremes = [0, 1, 2].map(|axis| {
        [farthest(points, |point| -point[axis]), farthest(points, |point| point[axis])]
    });
    let extremes = extremes.as_flattened();
    let mut best = (0.0, [0, 0]);
    for (place, &(first, _)) in extremes.iter().enumerate() {
        for &(second, _) in &extremes[place + 1..] {
            let Some((p, q)) = points.get(first as usize).zip(points.get(second as usize)) else {
                continue;
            };
            let apart = p.distance_squared(*q);
            if apart > best.0 {
                best = (apart, [first, second]);
            }
        }
    }
    best.1
}

/// Height of a tetrahedron over its first three corners.
pub(super) fn height_of([a, b, c, d]: [Vector; 4]) -> f64 {
    area_normal(a, b, c).normalize_or_zero().dot(d - a).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_as_high_as_its_last_corner_is_above_the_others() {
        for height in [0.0, 0.25, 1.0, 7.0] {
            for side in [1.0, -1.0] {
                let last = Vector::new(0.4, 0.9, side * height);
                let corners =
                    [Vector::ZERO, Vector::new(2.0, 0.0, 0.0), Vector::new(0.0, 3.0, 0.0), last];
                assert!((height_of(corners) - height).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn one_coordinate_that_is_not_finite_is_noticed_wherever_it_is() {
        for count in 1..8 {
            let points: Vec<Vector> =
                (0..count).map(|k| Vector::new(f64::from(k), 2.0, -3.0)).collect();
            let last = f64::from(count - 1);
            assert_eq!(
                finite_bounds(&points),
                Some([Vector::new(0.0, 2.0, -3.0), Vector::new(last, 2.0, -3.0)])
            );
            for place in 0..3 * points.len() {
                for strange in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let mut points = points.clone();
                    points[place / 3][place % 3] = strange;
                    assert_eq!(finite_bounds(&points), None, "{strange} at {place}");
                }
            }
        }
    }

    #[test]
    fn of_equals_the_first_is_farthest() {
        let points = [0.0, 1.0, 1.0, 0.5].map(|x| Vector::new(x, 0.0, 1.0));
        assert_eq!(farthest(&points, |point| point.x), (1, 1.0));
        assert_eq!(farthest(&points, |point| -point.x), (0, 0.0));
    }
}
