//! The points of a hull before it grows: their extent, the frame that brings them near 1, and the
//! first simplex.

use crate::geometry::vector::{
    Vector, add, area_normal, cross, distance, dot, length_squared, normalize, scale, subtract,
};

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
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub centre: Vector,
    pub factor: f64,
}

impl Default for Frame {
    fn default() -> Self {
        Self { centre: [0.0; 3], factor: 1.0 }
    }
}

impl Frame {
    /// The frame of points within bounds, which are inside out without points.
    pub(super) fn around([low, high]: [Vector; 2]) -> Self {
        let mut frame = Self::default();
        let centre = [0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis]);
        if is_finite(&centre) {
            frame.centre = centre;
        }
        let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        if extent > 0.0 && extent.is_finite() {
            frame.factor = one_over_power_of_two(extent);
        }
        frame
    }

    /// A point in the frame.
    #[inline]
    pub(super) fn inward(&self, point: Vector) -> Vector {
        scale(subtract(point, self.centre), self.factor)
    }

    /// A point of the frame in the points' units.
    pub(super) fn outward(&self, point: Vector) -> Vector {
        add(scale(point, 1.0 / self.factor), self.centre)
    }
}

/// One over the greatest power of two that is at most a positive number.
fn one_over_power_of_two(number: f64) -> f64 {
    const MANTISSA_BITS: u32 = f64::MANTISSA_DIGITS - 1;
    const EXPONENT_BIAS: i64 = f64::MAX_EXP as i64 - 1;
    /// Keeps clear of the ends of the range.
    const MAX_EXPONENT: i64 = 1000;
    let exponent = (number.to_bits() >> MANTISSA_BITS) as i64 - EXPONENT_BIAS;
    let biased = EXPONENT_BIAS - exponent.clamp(-MAX_EXPONENT, MAX_EXPONENT);
    f64::from_bits((biased as u64) << MANTISSA_BITS)
}

pub(super) fn is_finite(point: &Vector) -> bool {
    point.iter().all(|x| x.is_finite())
}

/// Bounds of points, inside out without any; `None` if a coordinate is not finite.
pub(super) fn finite_bounds(points: &[Vector]) -> Option<[Vector; 2]> {
    /// The coordinates of two points, so that the loop vectorises.
    const PAIR: usize = 6;
    let (mut low, mut high) = ([f64::INFINITY; PAIR], [f64::NEG_INFINITY; PAIR]);
    // Becomes NaN where a coordinate is not finite.
    let mut zero = [0.0; PAIR];
    let (pairs, rest) = points.as_flattened().as_chunks::<PAIR>();
    let mut include = |lane: usize, x: f64| {
        low[lane] = smaller(x, low[lane]);
        high[lane] = larger(x, high[lane]);
        zero[lane] += 0.0 * x;
    };
    for pair in pairs {
        for (lane, &x) in pair.iter().enumerate() {
            include(lane, x);
        }
    }
    for (lane, &x) in rest.iter().enumerate() {
        include(lane, x);
    }
    let bounds = [
        [0, 1, 2].map(|axis| smaller(low[axis], low[axis + 3])),
        [0, 1, 2].map(|axis| larger(high[axis], high[axis + 3])),
    ];
    zero.iter().all(|&sum| sum == 0.0).then_some(bounds)
}

/// Points in a [`Block`].
pub(super) const LANES: usize = 4;

/// The x, y and z coordinates of `LANES` points.
pub(super) type Block = [[f64; LANES]; 3];

/// Points as a structure of arrays, in blocks of `LANES`, so that loops over them vectorise. The
/// rest of the last block repeats the first point.
#[derive(Debug, Default)]
pub(super) struct Blocks(pub Vec<Block>);

impl Blocks {
    pub(super) fn new(points: &[Vector]) -> Self {
        let mut blocks = Self::default();
        blocks.fill(points);
        blocks
    }

    /// Replaces the points.
    pub(super) fn fill(&mut self, points: &[Vector]) {
        let (full, rest) = points.as_chunks::<LANES>();
        let transposed = |points: &[Vector; LANES]| -> Block {
            std::array::from_fn(|axis| std::array::from_fn(|lane| points[lane][axis]))
        };
        self.0.clear();
        self.0.extend(full.iter().map(transposed));
        if let (Some(&first), false) = (points.first(), rest.is_empty()) {
            let mut last = [first; LANES];
            last[..rest.len()].copy_from_slice(rest);
            self.0.push(transposed(&last));
        }
    }

    /// The points with the least and the greatest x, then y, then z; of equals the first.
    fn extremes(&self) -> [u32; 6] {
        let [mut low, mut high] = [[[f64::INFINITY; LANES]; 3], [[f64::NEG_INFINITY; LANES]; 3]];
        for block in &self.0 {
            for axis in 0..3 {
                for lane in 0..LANES {
                    low[axis][lane] = smaller(block[axis][lane], low[axis][lane]);
                    high[axis][lane] = larger(block[axis][lane], high[axis][lane]);
                }
            }
        }
        let low = low.map(|lanes| lanes.into_iter().fold(f64::INFINITY, smaller));
        let high = high.map(|lanes| lanes.into_iter().fold(f64::NEG_INFINITY, larger));
        let [x, y, z] = [0, 1, 2].map(|axis| [low[axis], high[axis]].map(|x| self.find(axis, x)));
        [x[0], x[1], y[0], y[1], z[0], z[1]]
    }

    /// The first point with a coordinate of this value; 0 if there is none.
    fn find(&self, axis: usize, value: f64) -> u32 {
        for (first, block) in (0..).step_by(LANES).zip(&self.0) {
            let mut any = false;
            for x in block[axis] {
                any |= x == value;
            }
            if any {
                let lane = block[axis].iter().position(|&x| x == value);
                return first + lane.unwrap_or_default() as u32;
            }
        }
        0
    }

    /// The first point for which `measure` is greatest.
    #[inline]
    fn farthest(&self, measure: impl Fn(Vector) -> f64) -> (u32, f64) {
        let mut best = (0, f64::NEG_INFINITY);
        for (first, [x, y, z]) in (0..).step_by(LANES).zip(&self.0) {
            let values: [f64; LANES] =
                std::array::from_fn(|lane| measure([x[lane], y[lane], z[lane]]));
            let mut any = false;
            for value in values {
                any |= value > best.1;
            }
            if any {
                for (point, value) in (first..).zip(values) {
                    if value > best.1 {
                        best = (point, value);
                    }
                }
            }
        }
        best
    }
}

#[inline]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Four points, far apart, that span a tetrahedron. For a lesser shape only as many of them count
/// as it has dimensions, and one more. `blocks` holds the same points. O(n).
pub(super) fn first_simplex(
    points: &[Vector],
    blocks: &Blocks,
    tolerance: f64,
) -> (Shape, [u32; 4]) {
    let [a, b] = farthest_extremes(points, blocks);
    let corner = |index: u32| points[index as usize];
    if points.is_empty() || distance(corner(a), corner(b)) <= tolerance {
        return (Shape::Point, [a; 4]);
    }
    let direction = normalize(subtract(corner(b), corner(a)));
    let (c, from_line) =
        blocks.farthest(|point| length_squared(cross(direction, subtract(point, corner(a)))));
    if from_line.sqrt() <= tolerance {
        return (Shape::Linear, [a, b, a, a]);
    }
    let normal = normalize(area_normal(corner(a), corner(b), corner(c)));
    let (d, from_plane) = blocks.farthest(|point| dot(normal, subtract(point, corner(a))).abs());
    if from_plane <= tolerance {
        return (Shape::Flat, [a, b, c, a]);
    }
    (Shape::Solid, [a, b, c, d])
}

/// Of the six extreme points along the axes the two that are farthest apart.
fn farthest_extremes(points: &[Vector], blocks: &Blocks) -> [u32; 2] {
    let extremes = blocks.extremes();
    let mut best = (0.0, [0, 0]);
    for (place, &first) in extremes.iter().enumerate() {
        for &second in &extremes[place + 1..] {
            let Some((p, q)) = points.get(first as usize).zip(points.get(second as usize)) else {
                continue;
            };
            let apart = length_squared(subtract(*p, *q));
            if apart > best.0 {
                best = (apart, [first, second]);
            }
        }
    }
    best.1
}

/// Height of a tetrahedron over its first three corners.
pub(super) fn height_of([a, b, c, d]: [Vector; 4]) -> f64 {
    dot(normalize(area_normal(a, b, c)), subtract(d, a)).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tetrahedron_is_as_high_as_its_last_corner_is_above_the_others() {
        for height in [0.0, 0.25, 1.0, 7.0] {
            for side in [1.0, -1.0] {
                let last = [0.4, 0.9, side * height];
                let corners = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], last];
                assert!((height_of(corners) - height).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn one_coordinate_that_is_not_finite_is_noticed_wherever_it_is() {
        for count in 1..8 {
            let points: Vec<Vector> = (0..count).map(|k| [f64::from(k), 2.0, -3.0]).collect();
            let last = f64::from(count - 1);
            assert_eq!(finite_bounds(&points), Some([[0.0, 2.0, -3.0], [last, 2.0, -3.0]]));
            for place in 0..3 * points.len() {
                for strange in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let mut points = points.clone();
                    points.as_flattened_mut()[place] = strange;
                    assert_eq!(finite_bounds(&points), None, "{strange} at {place}");
                }
            }
        }
    }

    #[test]
    fn the_rest_of_a_block_adds_nothing() {
        for count in 1..10 {
            let points: Vec<Vector> = (0..count).map(|i| [f64::from(i), 0.0, 1.0]).collect();
            let blocks = Blocks::new(&points);
            assert_eq!(blocks.extremes(), [0, count as u32 - 1, 0, 0, 0, 0]);
            assert_eq!(blocks.farthest(|[x, ..]| x), (count as u32 - 1, f64::from(count - 1)));
        }
    }

    #[test]
    fn of_equals_the_first_counts() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0; 3]];
        let blocks = Blocks::new(&points);
        assert_eq!(blocks.extremes(), [0, 1, 0, 2, 0, 4]);
        assert_eq!(blocks.farthest(|[x, ..]| x), (1, 1.0));
    }
}
