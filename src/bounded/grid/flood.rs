//! Which side of the surface cells are on: regions of cells that the surface does not touch are flooded, each from one
//! cell that is asked.

use super::{CELLS_PER_CHECK, Cell, Grid, INSIDE, OUTSIDE, SURPLUS, UNKNOWN};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, dot, length_squared, subtract};

/// A cell farther than this from the surface, in cells, is not cut off from its neighbours by it:
/// half a cell, and room for distances that are too large.
pub(super) const FREE: f32 = 0.8;

/// The same, whatever the distances.
const CERTAINLY_FREE: f32 = 0.5 + SURPLUS as f32;

/// A point on this side of its nearest triangle, by the cosine of the angle to the normal, is on that side of the
/// surface, unless another one is nearer.
const UPRIGHT: f64 = 0.99;

/// Cells of a region that look as if they were on the other side of the surface, and are asked: where triangles
/// are turned anyhow, all of them do.
const MOST_DOUBTS: usize = 1000;

impl Grid {
    /// Gives each connected region of cells that the surface does not touch its side.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(in super::super) fn flood(
        &mut self,
        bvh: &Bvh,
        mesh: (&[Vector], &[[u32; 3]]),
        control: &Control,
    ) -> Result<(), Error> {
        self.is_flooded = true;
        // Where distances are too large, a region may leak through the surface.
        if !self.flood_free(FREE, bvh, mesh, control)? {
            self.sides.iter_mut().for_each(|side| *side.get_mut() = UNKNOWN);
            self.flood_free(CERTAINLY_FREE, bvh, mesh, control)?;
        }
        Ok(())
    }

    /// The same, of cells that are farther than this from the surface. Whether no region was found to lie on both
    /// sides of it.
    fn flood_free(
        &mut self,
        free: f32,
        bvh: &Bvh,
        mesh: (&[Vector], &[[u32; 3]]),
        control: &Control,
    ) -> Result<bool, Error> {
        let is_free = |cells: &[Cell], index: usize| cells[index].distance > free * self.size;
        let mut stack: Vec<u32> = Vec::new();
        let mut flooded = 0_usize;
        for start in 0..self.cells.len() {
            if *self.sides[start].get_mut() != UNKNOWN || !is_free(&self.cells, start) {
                continue;
            }
            let inside = bvh.is_inside(self.centre_in_space(start));
            let side = if inside { INSIDE } else { OUTSIDE };
            *self.sides[start].get_mut() = side;
            stack.push(start as u32);
            control.check()?;
            let mut doubts = 0;
            while let Some(index) = stack.pop() {
                flooded += 1;
                if flooded.is_multiple_of(CELLS_PER_CHECK) {
                    control.check()?;
                }
                let is_close = self.cells[index as usize].distance <= CERTAINLY_FREE * self.size;
                if is_close
                    && doubts < MOST_DOUBTS
                    && self.is_behind(index as usize, mesh) == Some(!inside)
                {
                    doubts += 1;
                    if bvh.is_inside(self.centre_in_space(index as usize)) != inside {
                        return Ok(false);
                    }
                }
                for neighbour in neighbours(self.dimensions, index as usize).into_iter().flatten() {
                    let known = self.sides[neighbour].get_mut();
                    if *known == UNKNOWN && is_free(&self.cells, neighbour) {
                        *known = side;
                        stack.push(neighbour as u32);
                    }
                }
            }
        }
        Ok(true)
    }

    /// Whether the centre of a cell is behind the triangle that it knows as the nearest; `None` where it is beside it.
    fn is_behind(
        &self,
        index: usize,
        (positions, triangles): (&[Vector], &[[u32; 3]]),
    ) -> Option<bool> {
        let triangle = triangles.get(self.owners[index] as usize)?;
        let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
        let nearest = self.cells[index].nearest;
        let nearest = [0, 1, 2].map(|k| self.origin[k] + f64::from(nearest[k]));
        let away = subtract(self.centre_in_space(index), nearest);
        let normal = area_normal(a, b, c);
        let product = dot(normal, away);
        let upright = UPRIGHT * (length_squared(normal) * length_squared(away)).sqrt();
        (product.abs() > upright).then_some(product < 0.0)
    }
}

/// The cells that share a side with a cell; `None` at the border of the grid.
pub(super) fn neighbours([width, height, depth]: [usize; 3], index: usize) -> [Option<usize>; 6] {
    let [x, y, z] = [index % width, index / width % height, index / (width * height)];
    let layer = width * height;
    [
        (x > 0).then(|| index - 1),
        (x + 1 < width).then_some(index + 1),
        (y > 0).then(|| index - width),
        (y + 1 < height).then_some(index + width),
        (z > 0).then(|| index - layer),
        (z + 1 < depth).then_some(index + layer),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::cuboid;

    /// A knife: a box drawn to an edge, turned.
    fn knife(turn: f64) -> crate::mesh::TriangleMesh {
        let mut mesh = cuboid([-0.4, -0.1, -0.25], [0.4, 0.1, 0.25]);
        for point in &mut mesh.positions {
            let [x, mut y, z] = *point;
            if x > 0.0 {
                y *= 0.05;
            }
            let (sin, cos) = turn.sin_cos();
            let [x, y] = [cos * x - sin * y, sin * x + cos * y];
            let (sin, cos) = (1.7 * turn).sin_cos();
            *point = [cos * x - sin * z, y, sin * x + cos * z];
        }
        mesh
    }

    #[test]
    fn no_region_leaks_through_the_surface() {
        for turn in 15..25 {
            let mesh = knife(0.1 * f64::from(turn));
            let control = Control::new();
            let bvh = Bvh::new(&mesh.positions, &mesh.triangles);
            for bound in [0.01, 0.02] {
                let mut grid =
                    Grid::new(&mesh.positions, &mesh.triangles, bound, &control).unwrap();
                grid.flood(&bvh, (&mesh.positions, &mesh.triangles), &control).unwrap();
                let mut wrong = 0;
                for index in 0..grid.count() {
                    // Leaks begin near the surface.
                    if grid.cells[index].distance > 2.0 * grid.size {
                        continue;
                    }
                    let side = *grid.sides[index].get_mut();
                    let inside = bvh.is_inside(grid.centre_in_space(index));
                    wrong += usize::from(side != UNKNOWN && (side == INSIDE) != inside);
                }
                assert_eq!(wrong, 0, "turn {turn}, bound {bound}");
            }
        }
    }
}
