//! Evenly spread points on a surface and in a box, the same on every run.
//!
//! Both are Kronecker sequences: multiples of irrational numbers, of which only the fraction is
//! kept. They fill space more evenly than random points, so that averages converge faster, and
//! each point follows from its index alone, so that points can be computed in any order.
//!
//! With a seed, points are independent random ones instead, by index too.

use crate::geometry::vector::{Vector, area_normal};

/// 1/φ and 1/φ² for the root φ of x³ = x + 1, the best known choice in two dimensions
/// (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
const PLANE_STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

/// 1/φ, 1/φ² and 1/φ³ for the root φ of x⁴ = x + 1: the same in three dimensions.
const SPACE_STEPS: [f64; 3] =
    [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];

fn fraction(index: usize, step: f64) -> f64 {
    (0.5 + index as f64 * step).fract()
}

/// Point `index` of the random ones: SplitMix64 (Steele, Lea, Flood 2014), three numbers each.
fn random(seed: u64, index: usize) -> Vector {
    const INCREMENT: u64 = 0x9e37_79b9_7f4a_7c15;
    const MANTISSA_BITS: u32 = 53;

    Vector::from_array([1, 2, 3].map(|axis| {
        let count = (index as u64).wrapping_mul(3).wrapping_add(axis);
        let mut bits = seed.wrapping_add(count.wrapping_mul(INCREMENT));
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> (u64::BITS - MANTISSA_BITS)) as f64 / (1_u64 << MANTISSA_BITS) as f64
    }))
}

/// A point of the unit cube.
pub(super) fn in_unit_cube(index: usize, seed: Option<u64>) -> Vector {
    match seed {
        Some(seed) => random(seed, index),
        None => Vector::from(SPACE_STEPS.map(|step| fraction(index, step))),
    }
}

/// A triangle surface that can be sampled by area.
pub(super) struct SampledSurface<'a> {
    positions: &'a [Vector],
    triangles: &'a [[u32; 3]],
    /// Area of all triangles up to and including this one.
    cumulative_area: Vec<f64>,
}

impl<'a> SampledSurface<'a> {
    /// All indices must exist. O(n).
    pub(super) fn new(positions: &'a [Vector], triangles: &'a [[u32; 3]]) -> Self {
        let mut area = 0.0;
        let cumulative_area = triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|index| positions[index as usize]);
                area += 0.5 * area_normal(a, b, c).length();
                area
            })
            .collect();
        Self { positions, triangles, cumulative_area }
    }

    pub(super) fn area(&self) -> f64 {
        self.cumulative_area.last().copied().unwrap_or(0.0)
    }

    /// The point `index` of `count` on the surface, and its triangle. Without a seed, each share of
    /// the area of 1 / `count`, in the order of the triangles, has one point. O(log n).
    pub(super) fn point(&self, index: usize, count: usize, seed: Option<u64>) -> (Vector, usize) {
        let [mut u, mut v, share] = (match seed {
            Some(seed) => random(seed, index),
            None => {
                let [u, v] = PLANE_STEPS.map(|step| fraction(index, step));
                Vector::new(u, v, (index as f64 + 0.5) / count as f64)
            }
        })
        .to_array();
        let area = self.area() * share;
        let triangle =
            self.cumulative_area.partition_point(|&upto| upto < area).min(self.triangles.len() - 1);
        let [a, b, c] = self.triangles[triangle].map(|index| self.positions[index as usize]);
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let along = (b - a) * u + (c - a) * v;
        (a + along, triangle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Areas 0.5, 0, and 1.5, in different planes.
    const POSITIONS: [Vector; 5] = [
        Vector::ZERO,
        Vector::X,
        Vector::Y,
        Vector::new(0.0, 0.0, 3.0),
        Vector::new(0.0, 0.0, 1.5),
    ];
    const TRIANGLES: [[u32; 3]; 3] = [[0, 1, 2], [0, 4, 3], [0, 2, 3]];

    #[test]
    fn each_triangle_has_points_by_its_area() {
        let surface = SampledSurface::new(&POSITIONS, &TRIANGLES);
        assert_eq!(surface.area(), 2.0);
        let mut counts = [0; 3];
        for index in 0..1000 {
            let (point, triangle) = surface.point(index, 1000, None);
            counts[triangle] += 1;
            match triangle {
                0 => assert!(point[2] == 0.0 && point[0] + point[1] <= 1.0),
                _ => assert!(point[0] == 0.0 && point[1] + point[2] / 3.0 <= 1.0),
            }
            assert!(point.to_array().iter().all(|&x| x >= 0.0));
        }
        assert_eq!(counts, [250, 0, 750]);
    }

    #[test]
    fn points_of_a_triangle_average_to_its_centre() {
        let surface = SampledSurface::new(&POSITIONS, &TRIANGLES[..1]);
        let sum = (0..999).fold(Vector::ZERO, |sum, index| sum + surface.point(index, 999, None).0);
        for coordinate in [sum[0], sum[1]] {
            assert!((coordinate / 999.0 - 1.0 / 3.0).abs() < 3e-3);
        }
    }

    #[test]
    fn without_area_there_still_is_a_point() {
        let surface = SampledSurface::new(&POSITIONS, &[[1, 1, 1]]);
        assert_eq!(surface.point(5, 10, None), (Vector::X, 0));
    }

    #[test]
    fn random_points_are_the_same_for_a_seed_and_spread_by_area() {
        let surface = SampledSurface::new(&POSITIONS, &TRIANGLES);
        let mut in_first = 0;
        for index in 0..10_000 {
            let (point, triangle) = surface.point(index, 10_000, Some(7));
            assert_eq!(surface.point(index, 20, Some(7)), (point, triangle));
            assert!(point.to_array().iter().all(|&x| x >= 0.0));
            in_first += usize::from(triangle == 0);
        }
        // 2,500 are expected; five standard deviations of chance are 217.
        assert!((2283..=2717).contains(&in_first), "{in_first}");
        assert_ne!(surface.point(0, 10, Some(7)), surface.point(0, 10, Some(8)));
    }

    #[test]
    fn the_unit_cube_is_filled_evenly() {
        let points: Vec<Vector> = (0..4096).map(|index| in_unit_cube(index, None)).collect();
        let min = points.iter().copied().fold(Vector::ONE, Vector::min);
        let max = points.iter().copied().fold(Vector::ZERO, Vector::max);
        assert!(min.to_array().iter().all(|&x| (0.0..0.001).contains(&x)));
        assert!(max.to_array().iter().all(|&x| (0.999..1.0).contains(&x)));
        let below = points.iter().filter(|&&point| point.dot(Vector::ONE) < 1.0).count();
        assert!((below as f64 / 4096.0 - 1.0 / 6.0).abs() < 5e-3);
    }
}
