//! An order of vertices and triangles that depends on their places alone, so that whatever order a
//! file has them in, the stages after it see the same mesh.
//!
//! Vertices are sorted along a space-filling curve, triangles by the set of their vertices; each
//! triangle begins with its least vertex. O(n log n).

use crate::geometry::vector::Vector;
use crate::sorting::{sort_by, sort_by_key};

/// Places are compared in steps of 2^-20 of the diagonal first, about the weld distance: what
/// differs by rounding alone, as a copy in other units, is in the same order.
const STEPS: f64 = (1_u64 << 20) as f64;

/// Bits of a coordinate in a key: normalised ones are from -0.5 to 0.5.
const BITS: u32 = 21;

/// In which order repair leaves vertices and triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshOrder {
    /// That of the input, for the paper's method: its groups depend on where they begin.
    Input,
    /// By place.
    Place,
}

/// The vertices in use, in the order of the input.
pub(super) fn used_vertices(used: &[bool]) -> Vec<u32> {
    (0_u32..).zip(used).filter(|&(_, &used)| used).map(|(vertex, _)| vertex).collect()
}

/// The vertices in use, sorted by place: along a Z-order curve (Morton, 1966), so that neighbours
/// in the order are mostly neighbours in space.
pub(super) fn vertices_by_place(positions: &[Vector], used: &[bool]) -> Vec<u32> {
    let half = 1_i64 << (BITS - 1);
    let part = |x: f64| ((x * STEPS).round() as i64 + half).clamp(0, 2 * half - 1) as u64;
    let key =
        |Vector { x, y, z }: Vector| spread(part(x)) << 2 | spread(part(y)) << 1 | spread(part(z));
    let in_use = (0_u32..).zip(used).filter(|&(_, &used)| used);
    let mut keyed: Vec<(u64, u32)> =
        in_use.map(|(vertex, _)| (key(positions[vertex as usize]), vertex)).collect();
    keyed.sort_unstable();
    for close in keyed.chunk_by_mut(|a, b| a.0 == b.0).filter(|close| close.len() > 1) {
        sort_by(close, |a, b| {
            let [a, b] = [a.1, b.1].map(|vertex| positions[vertex as usize]);
            let by_axis = |axis: usize| a[axis].total_cmp(&b[axis]);
            by_axis(0).then(by_axis(1)).then(by_axis(2))
        });
    }
    keyed.into_iter().map(|(_, vertex)| vertex).collect()
}

/// The lowest 21 bits, each with two free bits above it.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// The triangle with its least vertex first, wound as it is.
pub(crate) fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Triangles in that order: by their keys, equal ones as they are numbered.
pub(super) fn triangles_by_place(triangles: &[u32], corners: impl Fn(u32) -> [u32; 3]) -> Vec<u32> {
    let key = |t: u32| triangle_key(corners(t));
    let mut keyed: Vec<([u32; 3], u32)> = triangles.iter().map(|&t| (key(t).0, t)).collect();
    keyed.sort_unstable();
    // Few have the same vertices, and the winding makes each key longer by a quarter.
    for same in keyed.chunk_by_mut(|a, b| a.0 == b.0).filter(|same| same.len() > 1) {
        sort_by_key(same, |&(_, t)| key(t).1);
    }
    keyed.into_iter().map(|(_, t)| t).collect()
}

/// By the set of vertices, then by the winding.
pub(super) fn triangle_key(triangle: [u32; 3]) -> ([u32; 3], bool) {
    let [a, b, c] = rotated(triangle);
    ([a, b.min(c), b.max(c)], b > c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_are_sorted_by_place_and_not_by_rounding() {
        let noise = 1e-12;
        let mut positions =
            [[0.25, 0.1, 0.0], [0.25, -0.1, 0.0], [-0.5, 0.5, 0.5], [0.0; 3]].map(Vector::from);
        let expected = vertices_by_place(&positions, &[true; 4]);
        positions[0][0] += noise;
        positions[1][0] -= noise;
        assert_eq!(vertices_by_place(&positions, &[true; 4]), expected);
        assert_eq!(vertices_by_place(&positions, &[false, false, true, false]), [2]);
    }

    #[test]
    fn vertices_closer_than_a_step_are_sorted_exactly() {
        let positions = [[2e-9, 0.0, 0.0], [1e-9, 0.0, 0.0], [1e-9, -1e-9, 0.0]].map(Vector::from);
        assert_eq!(vertices_by_place(&positions, &[true; 3]), [2, 1, 0]);
    }

    #[test]
    fn a_triangle_keeps_its_winding() {
        for triangle in [[5, 7, 9], [7, 9, 5], [9, 5, 7]] {
            assert_eq!(rotated(triangle), [5, 7, 9]);
        }
        assert_eq!(rotated([9, 7, 5]), [5, 9, 7]);
        assert!(triangle_key([9, 7, 5]) > triangle_key([5, 7, 9]));
        assert_eq!(triangle_key([9, 7, 5]).0, triangle_key([5, 7, 9]).0);
    }
}
