//! Cavities: empty space that is cut off from the outside, or joined to it only by mouths narrower
//! than the bound.
//!
//! A hull's surface can't pass through such a space without standing out of the solid, and is
//! refused there. But it can swallow the space whole. One point of each cavity tells.

use super::grid::Grid;
use crate::bvh::Bvh;
use crate::geometry::vector::Vector;

/// One point of each cavity, where it is deepest: outside the solid, farther than `bound` from
/// the surface, and without a way to infinity through points of that kind, as far as the grid
/// tells. O(cells).
pub(super) fn cavities(grid: &Grid, bvh: &Bvh, bound: f64) -> Vec<Vector> {
    let mut is_reached: Vec<bool> =
        (0..grid.count()).map(|cell| !grid.is_free(cell, bound)).collect();
    // The grid's border is outside, wherever the surface leaves room.
    for cell in 0..grid.count() {
        if grid.neighbours(cell).contains(&None) {
            reach(grid, cell, &mut is_reached);
        }
    }
    let mut cavities = Vec::new();
    for cell in 0..grid.count() {
        if is_reached[cell] {
            continue;
        }
        let parts = reach(grid, cell, &mut is_reached);
        let deepest = parts
            .into_iter()
            .max_by(|&a, &b| grid.distance(a).total_cmp(&grid.distance(b)).then(b.cmp(&a)));
        let point = grid.centre_in_space(deepest.unwrap_or(cell));
        if !bvh.is_inside(point) {
            cavities.push(point);
        }
    }
    cavities
}

/// All cells that can be reached from one, itself included.
fn reach(grid: &Grid, start: usize, is_reached: &mut [bool]) -> Vec<usize> {
    let mut reached = Vec::new();
    if !std::mem::replace(&mut is_reached[start], true) {
        reached.push(start);
    }
    let mut next = 0;
    while let Some(&cell) = reached.get(next) {
        next += 1;
        for neighbour in grid.neighbours(cell).into_iter().flatten() {
            if !std::mem::replace(&mut is_reached[neighbour], true) {
                reached.push(neighbour);
            }
        }
    }
    reached
}
