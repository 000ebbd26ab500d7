//! Where the centre of a ball can be: a grid of cells, flooded from outside and from given points.
//!
//! A centre is at least the radius away from the surface. Distance is 1-Lipschitz: a cell with a half diagonal δ whose
//! own centre is nearer than the radius less δ holds none. A path of centres passes from cell to cell across faces,
//! edges and corners, and never through such a cell: so the flood misses none that a ball can reach. It may find more,
//! through openings that are narrower than the ball by up to 4 δ.
//!
//! Most cells are settled by the distance at another cell of their row.

use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::Vector;
use crate::parallel;

/// Cells along the radius. The flood takes narrow openings for wide ones by a share of the radius: with 4 cells those
/// wider than 1.6 radii.
const CELLS_PER_RADIUS: f64 = 4.0;

/// Maximum number of cells. Where it is not enough they are larger, and less is known to be out of reach.
const MAX_CELLS: f64 = 2_000_000.0;

/// Factor by which cells grow until they are few enough.
const GROWTH: f64 = 1.05;

/// Cells along each axis beyond the radius around the mesh: the grid's border can be reached from far away.
const BORDER: f64 = 2.0;

/// The parameters of the probe. Lengths are fractions of the diagonal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ProbeSettings {
    pub radius: f64,
    /// Where it starts beside the outside.
    pub from: Vec<Vector>,
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cell {
    /// No centre of a ball that can be reached is in it.
    Closed,
    /// Some may be.
    Partial,
    /// All of it is at least the radius away from the surface, and may be reached.
    Open,
}

/// The grid. See the module.
pub(super) struct Reach {
    pub origin: Vector,
    /// Side of a cell.
    pub size: f64,
    pub dimensions: [usize; 3],
    pub cells: Vec<Cell>,
}

impl Reach {
    /// The cells around a surface within a box that the centre of a ball may reach which stays at least `clear` away.
    /// The size of cells follows the radius.
    /// O(cells), and a query of the tree for each cell about that far from the surface.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        tree: &Bvh,
        (min, max): (Vector, Vector),
        radius: f64,
        clear: f64,
        from: &[Vector],
        control: &Control,
    ) -> Result<Self, Error> {
        let extent = max - min;
        let count = |size: f64| {
            let cells = |extent: f64| ((extent + 2.0 * radius) / size).ceil() + 2.0 * BORDER;
            extent.to_array().into_iter().map(cells).product::<f64>()
        };
        let mut size = radius / CELLS_PER_RADIUS;
        while count(size) > MAX_CELLS {
            size *= GROWTH;
        }
        let dimensions = extent
            .to_array()
            .map(|extent| ((extent + 2.0 * radius) / size).ceil() as usize + 2 * BORDER as usize);
        let whole = Vector::from_array(dimensions.map(|cells| cells as f64)) * size;
        let origin = (min + max - whole) * 0.5;
        let mut reach = Self { origin, size, dimensions, cells: Vec::new() };
        let [_, height, depth] = dimensions;
        let rows = parallel::map_indices(height * depth, |row| {
            control.check()?;
            Ok(reach.row(tree, row % height, row / height, clear))
        });
        for row in rows {
            reach.cells.extend(row?);
        }
        reach.flood(from, control)?;
        Ok(reach)
    }

    /// A row of cells by their distances from the surface alone.
    fn row(&self, tree: &Bvh, y: usize, z: usize, clear: f64) -> Vec<Cell> {
        let half_diagonal = 0.5 * self.size * 3f64.sqrt();
        let (free, closed) = (clear + half_diagonal, clear - half_diagonal);
        let (mut known, mut at, mut guess) = (f64::NAN, 0, u32::MAX);
        let cell = |x: usize| {
            let way = (x - at) as f64 * self.size;
            if known - way >= free {
                return Cell::Open;
            }
            if known + way < closed {
                return Cell::Closed;
            }
            let centre = self.centre([x, y, z]);
            let closest = tree.closest_point_near(centre, f64::INFINITY, guess);
            (known, at) = (closest.map_or(f64::INFINITY, |closest| closest.distance), x);
            guess = closest.map_or(guess, |closest| closest.triangle);
            match known {
                far if far >= free => Cell::Open,
                near if near < closed => Cell::Closed,
                _ => Cell::Partial,
            }
        };
        (0..self.dimensions[0]).map(cell).collect()
    }

    /// Closes the cells that are connected neither to the border nor to the given points.
    fn flood(&mut self, from: &[Vector], control: &Control) -> Result<(), Error> {
        let [width, height, depth] = self.dimensions;
        let mut is_reached = vec![false; self.cells.len()];
        let mut stack: Vec<[usize; 3]> = Vec::new();
        let mut visit = |place: [usize; 3], stack: &mut Vec<[usize; 3]>| {
            let index = self.index(place);
            if self.cells[index] != Cell::Closed && !std::mem::replace(&mut is_reached[index], true)
            {
                stack.push(place);
            }
        };
        for z in 0..depth {
            for y in 0..height {
                let is_border = z == 0 || z + 1 == depth || y == 0 || y + 1 == height;
                let step = if is_border { 1 } else { width - 1 };
                (0..width).step_by(step).for_each(|x| visit([x, y, z], &mut stack));
            }
        }
        from.iter().for_each(|&point| visit(self.place(point), &mut stack));
        let range = |x: usize, most: usize| x.saturating_sub(1)..(x + 2).min(most);
        while let Some([x, y, z]) = stack.pop() {
            for k in range(z, depth) {
                for j in range(y, height) {
                    range(x, width).for_each(|i| visit([i, j, k], &mut stack));
                }
            }
        }
        control.check()?;
        for (cell, is_reached) in self.cells.iter_mut().zip(is_reached) {
            if !is_reached {
                *cell = Cell::Closed;
            }
        }
        Ok(())
    }

    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.dimensions[1] + y) * self.dimensions[0] + x
    }

    pub fn centre(&self, place: [usize; 3]) -> Vector {
        self.origin + Vector::from_array(place.map(|x| x as f64 + 0.5)) * self.size
    }

    /// The cell of a point, or the nearest one.
    pub fn place(&self, point: Vector) -> [usize; 3] {
        let relative = ((point - self.origin) / self.size).to_array();
        [0, 1, 2].map(|k| (relative[k].max(0.0) as usize).min(self.dimensions[k] - 1))
    }
}
