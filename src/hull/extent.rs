//! How large a set of points is: the questions that `builder` asks before it begins.

use super::columns::{larger, smaller};
use crate::geometry::vector::{Vector, area_normal, dot, normalize, subtract};

/// Over the power of two that is next below a positive number.
pub(super) fn one_over_power_of_two(number: f64) -> f64 {
    /// Bits of the mantissa.
    const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
    /// Added to the exponent as it is stored.
    const BIAS: i64 = f64::MAX_EXP as i64 - 1;
    /// Far enough from the ends of the range.
    const MOST: i64 = 1000;
    let exponent = (number.to_bits() >> MANTISSA) as i64 - BIAS;
    f64::from_bits(((BIAS - exponent.clamp(-MOST, MOST)) as u64) << MANTISSA)
}

/// Height of a tetrahedron over the first three of its corners.
pub(super) fn height_of([a, b, c, d]: [Vector; 4]) -> f64 {
    dot(normalize(area_normal(a, b, c)), subtract(d, a)).abs()
}

/// Bounds of points, inside out without any, and whether all are finite; if not, the bounds don't
/// count.
pub(super) fn bounds(points: &[Vector]) -> (Vector, Vector, bool) {
    /// Coordinates of two points, so that wide registers are used.
    const PAIR: usize = 6;
    let (mut low, mut high) = ([f64::INFINITY; PAIR], [f64::NEG_INFINITY; PAIR]);
    // Zero, or not a number where a coordinate is infinite or none.
    let mut strange = [0.0; PAIR];
    let (pairs, rest) = points.as_flattened().as_chunks::<PAIR>();
    let mut take = |lane: usize, x: f64| {
        low[lane] = smaller(x, low[lane]);
        high[lane] = larger(x, high[lane]);
        strange[lane] += 0.0 * x;
    };
    for pair in pairs {
        for (lane, &x) in pair.iter().enumerate() {
            take(lane, x);
        }
    }
    for (lane, &x) in rest.iter().enumerate() {
        take(lane, x);
    }
    (
        [0, 1, 2].map(|axis| smaller(low[axis], low[axis + 3])),
        [0, 1, 2].map(|axis| larger(high[axis], high[axis + 3])),
        strange.iter().all(|&sum| sum == 0.0),
    )
}

pub(super) fn is_finite(point: &Vector) -> bool {
    point.iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_as_high_as_its_last_corner_is_above_the_others() {
        let base = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
        for height in [0.0, 0.25, 1.0, 7.0] {
            for side in [1.0, -1.0] {
                let corners = [base[0], base[1], base[2], [0.4, 0.9, side * height]];
                assert!((height_of(corners) - height).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn one_coordinate_that_is_no_number_is_noticed_wherever_it_is() {
        for count in 1..8 {
            let points: Vec<Vector> = (0..count).map(|k| [f64::from(k), 2.0, -3.0]).collect();
            let last = f64::from(count - 1);
            assert_eq!(bounds(&points), ([0.0, 2.0, -3.0], [last, 2.0, -3.0], true));
            for index in 0..points.len() {
                for axis in 0..3 {
                    for strange in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                        let mut points = points.clone();
                        points[index][axis] = strange;
                        assert!(!bounds(&points).2, "{strange} at {index}, {axis}");
                    }
                }
            }
        }
    }
}
