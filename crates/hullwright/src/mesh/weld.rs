//! Vertices at the same place become one.
//!
//! A hash grid whose cells are much larger than the tolerance: nearly every vertex is compared with
//! those of its own cell alone, and only one whose tolerance ball touches another cell with those
//! there too.

use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;

/// Vertices that are no farther apart are one, as a fraction of the bounding-box diagonal.
/// Coordinates in single precision are rounded by up to 3e-8 of a box that is centred at the
/// origin, a rotated or moved copy by several times that. The smallest triangle of an even mesh of
/// a hundred million is a hundred times larger than this.
pub(crate) const WELD_TOLERANCE: f64 = 1e-6;

/// Side of a cell over the tolerance: at 32 one vertex in six is near a second cell, and a cell
/// still holds few vertices where the mesh is finest.
const CELL_SIDE: f64 = 32.0;

/// Slots of the hash table per vertex.
const SLOTS_PER_VERTEX: usize = 2;

/// Vertices between two checks of the control.
const VERTICES_PER_CHECK: usize = 16_384;

const NONE: u32 = u32::MAX;

/// For each vertex the vertex that stands for it: itself, or an earlier one within
/// [`WELD_TOLERANCE`]. The first vertex at a place stands for the others.
///
/// Positions are normalised. Linear time, unless more vertices than usual lie in one cell.
pub(crate) fn weld(positions: &[Vector], control: &Control) -> Result<Vec<u32>, Error> {
    let slots = (positions.len() * SLOTS_PER_VERTEX).next_power_of_two().max(2);
    let shift = 64 - slots.trailing_zeros();
    let mut heads = vec![NONE; slots];
    let mut next = vec![NONE; positions.len()];
    let mut representatives: Vec<u32> = (0..positions.len() as u32).collect();

    let cell_size = CELL_SIDE * WELD_TOLERANCE;
    let tolerance_squared = WELD_TOLERANCE * WELD_TOLERANCE;
    let slot_of = |cell: [i64; 3]| (hash(cell) >> shift) as usize;

    for (vertex, &position) in positions.iter().enumerate() {
        if vertex.is_multiple_of(VERTICES_PER_CHECK) {
            control.check()?;
        }
        let low = position.to_array().map(|x| floor((x - WELD_TOLERANCE) / cell_size));
        let high = position.to_array().map(|x| floor((x + WELD_TOLERANCE) / cell_size));
        let mut found = NONE;
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let mut candidate = heads[slot_of([x, y, z])];
                    while candidate != NONE {
                        let offset = positions[candidate as usize] - position;
                        if candidate < found && offset.length_squared() <= tolerance_squared {
                            found = candidate;
                        }
                        candidate = next[candidate as usize];
                    }
                }
            }
        }
        if found == NONE {
            let slot = slot_of(position.to_array().map(|x| floor(x / cell_size)));
            next[vertex] = heads[slot];
            heads[slot] = vertex as u32;
        } else {
            representatives[vertex] = found;
        }
    }
    Ok(representatives)
}

/// Rounds down: without newer processors' instructions a call for each number takes a tenth of the
/// time.
#[inline]
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(towards_zero as f64 > x)
}

/// Multiplies each coordinate by a large odd number: neighbouring cells end up far apart in the
/// high bits, which choose the slot.
fn hash(cell: [i64; 3]) -> u64 {
    let mixed = (cell[0] as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (cell[1] as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
        ^ (cell[2] as u64).wrapping_mul(0x1656_67B1_9E37_79F9);
    (mixed ^ (mixed >> 32)).wrapping_mul(0xD6E8_FEB8_6659_FD93)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weld_all(positions: &[Vector]) -> Vec<u32> {
        weld(positions, &Control::new()).unwrap()
    }

    #[test]
    fn the_first_vertex_stands_for_the_others() {
        let a = Vector::new(0.1, 0.2, 0.3);
        let near = Vector::new(0.1 + 0.9 * WELD_TOLERANCE, 0.2, 0.3);
        let far = Vector::new(0.1 + 1.1 * WELD_TOLERANCE, 0.2, 0.3);
        assert_eq!(weld_all(&[a, near, far, a]), [0, 0, 2, 0]);
    }

    #[test]
    fn vertices_exactly_the_tolerance_apart_are_one() {
        assert_eq!(weld_all(&[Vector::ZERO, Vector::new(WELD_TOLERANCE, 0.0, 0.0)]), [0, 0]);
    }

    #[test]
    fn a_border_between_cells_does_not_separate() {
        let border = 5.0 * CELL_SIDE * WELD_TOLERANCE;
        for sign in [-1.0, 1.0] {
            let epsilon = 0.4 * WELD_TOLERANCE;
            let below = Vector::splat(sign * border - epsilon);
            let above = Vector::new(sign * border + epsilon, sign * border, sign * border);
            assert_eq!(weld_all(&[below, above]), [0, 0]);
        }
        assert_eq!(weld_all(&[Vector::ZERO, Vector::splat(-0.0)]), [0, 0]);
    }

    #[test]
    fn agrees_with_comparing_all_pairs() {
        // A lattice finer than the tolerance, so that chains of near vertices occur.
        let mut positions = Vec::new();
        for i in 0..9_i32 {
            for j in 0..9 {
                for k in 0..9 {
                    let step = 7.3 * WELD_TOLERANCE;
                    let jitter = f64::from((i * 31 + j * 17 + k * 7) % 5) * 0.35 * WELD_TOLERANCE;
                    let point = Vector::new(f64::from(i), f64::from(j), f64::from(k)) * step;
                    positions.push(point);
                    positions.push(point + Vector::new(jitter, -jitter, 0.0));
                }
            }
        }
        let mut expected: Vec<u32> = Vec::new();
        for (vertex, &position) in positions.iter().enumerate() {
            let first = (0..vertex).find(|&other| {
                expected[other] == other as u32
                    && positions[other].distance_squared(position)
                        <= WELD_TOLERANCE * WELD_TOLERANCE
            });
            expected.push(first.unwrap_or(vertex) as u32);
        }
        assert_eq!(weld_all(&positions), expected);
    }
}
