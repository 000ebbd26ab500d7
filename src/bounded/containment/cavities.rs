//! Cavities: empty space that is cut off from the outside, or connected to it only through mouths
//! narrower than twice the bound.
//!
//! A hull whose surface passes through a cavity protrudes from the solid and is refused. But a hull
//! may swallow a cavity whole. One point of each cavity is enough to detect that.

use super::distance_grid::FilledGrid;
use crate::bvh::Bvh;
use crate::geometry::vector::Vector;

/// The deepest point of each cavity: outside the solid, farther than `bound` from the surface, and
/// without a path to infinity through such points, at the grid's resolution. O(cells).
pub(super) fn cavities(grid: &FilledGrid, bvh: &Bvh, bound: f64) -> Vec<Vector> {
    let mut is_reached: Vec<bool> =
        (0..grid.count()).map(|cell| !grid.is_free(cell, bound)).collect();
    // The grid's border is outside the mesh.
    for cell in 0..grid.count() {
        if grid.neighbours(cell).contains(&None) {
            flood(grid, cell, &mut is_reached);
        }
    }
    let mut cavities = Vec::new();
    for cell in 0..grid.count() {
        if is_reached[cell] {
            continue;
        }
        let cells = flood(grid, cell, &mut is_reached);
        let deepest = cells
            .into_iter()
            .max_by(|&a, &b| grid.distance(a).total_cmp(&grid.distance(b)).then(b.cmp(&a)));
        let point = grid.centre(deepest.unwrap_or(cell));
        if !bvh.is_inside(point) {
            cavities.push(point);
        }
    }
    cavities
}

/// All cells that can be reached from one, including itself.
fn flood(grid: &FilledGrid, start: usize, is_reached: &mut [bool]) -> Vec<usize> {
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
