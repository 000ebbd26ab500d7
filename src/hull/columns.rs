//! Points by coordinate, a few side by side, so that a question to all of them uses wide registers.

use crate::geometry::vector::Vector;

/// Points that are looked at in one go.
pub(super) const LANES: usize = 4;

/// The coordinates of a few points: x, y, z.
pub(super) type Block = [[f64; LANES]; 3];

/// Points in blocks. The rest of the last block is filled up with the first point.
#[derive(Debug, Default)]
pub(super) struct Columns {
    pub blocks: Vec<Block>,
}

impl Columns {
    pub(super) fn new(points: &[Vector]) -> Self {
        let mut columns = Self::default();
        columns.fill(points);
        columns
    }

    /// Holds these points instead of others.
    pub(super) fn fill(&mut self, points: &[Vector]) {
        let (full, rest) = points.as_chunks::<LANES>();
        let transposed = |points: &[Vector; LANES]| -> Block {
            std::array::from_fn(|axis| std::array::from_fn(|lane| points[lane][axis]))
        };
        self.blocks.clear();
        self.blocks.extend(full.iter().map(transposed));
        if let (Some(&first), false) = (points.first(), rest.is_empty()) {
            let mut last = [first; LANES];
            last[..rest.len()].copy_from_slice(rest);
            self.blocks.push(transposed(&last));
        }
    }

    /// The points that reach farthest along the axes: the least and the greatest x, then y, then
    /// z; of equals the first.
    pub(super) fn extremes(&self) -> [u32; 6] {
        let [mut low, mut high] = [[[f64::INFINITY; LANES]; 3], [[f64::NEG_INFINITY; LANES]; 3]];
        for block in &self.blocks {
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
        for (first, block) in (0..).step_by(LANES).zip(&self.blocks) {
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
    pub(super) fn farthest(&self, measure: impl Fn(Vector) -> f64) -> (u32, f64) {
        let mut best = (0, f64::NEG_INFINITY);
        for (first, [x, y, z]) in (0..).step_by(LANES).zip(&self.blocks) {
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
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_of_a_block_adds_nothing() {
        for count in 1..10 {
            let points: Vec<Vector> = (0..count).map(|i| [f64::from(i), 0.0, 1.0]).collect();
            let columns = Columns::new(&points);
            assert_eq!(columns.extremes(), [0, count as u32 - 1, 0, 0, 0, 0]);
            assert_eq!(columns.farthest(|[x, ..]| x), (count as u32 - 1, f64::from(count - 1)));
        }
    }

    #[test]
    fn of_equals_the_first_counts() {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0; 3]];
        let columns = Columns::new(&points);
        assert_eq!(columns.extremes(), [0, 1, 0, 2, 0, 4]);
        assert_eq!(columns.farthest(|[x, ..]| x), (1, 1.0));
    }
}
