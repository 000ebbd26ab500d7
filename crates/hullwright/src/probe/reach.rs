//! Where the centre of a ball can be: a grid of cells, flooded from outside and from given points.
//!
//! A centre is at least the radius away from the surface. Distance is 1-Lipschitz: a cell with a
//! half diagonal δ whose own centre is nearer than the radius less δ holds none. A path of centres
//! passes from cell to cell across faces, edges and corners, and never through such a cell: so the
//! flood misses none that a ball can reach. It may find more, through openings that are narrower
//! than the ball by up to 4 δ.
//!
//! So a second flood goes only where a ball certainly can: between cells whose centres are so far
//! from the surface that a ball passes from one to the other. What the first one reaches far from
//! these is in doubt, and flooded again in smaller cells.

use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::blocks::size_for;
use crate::geometry::vector::Vector;
use crate::mesh::Normalization;
use crate::parallel;
use crate::parameters::Length;

/// Cells along the radius.
const CELLS_PER_RADIUS: f64 = 2.0;

/// Maximum number of cells. Where it is not enough they are larger, and less is known to be out of
/// reach.
const MAX_CELLS: f64 = 1_000_000.0;

/// Cells along each axis beyond the radius around the mesh: the grid's border can be reached from
/// far away.
const BORDER: f64 = 2.0;

/// Cells in doubt are divided into this many along each axis: openings narrower than 0.89 diameters
/// count as closed, instead of 0.57.
const FINE: usize = 4;
const PARTS: usize = FINE * FINE * FINE;

/// Cells in doubt that are divided, at most: each takes up to [`PARTS`] queries of the tree. Where
/// there are more, all count as reached.
const MAX_DOUBTFUL: usize = 3000;

/// The parameters of the probe. Lengths are fractions of the diagonal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ProbeSettings {
    pub radius: f64,
    /// Where it starts beside the outside.
    pub from: Vec<Vector>,
}

impl ProbeSettings {
    /// Those of parameters, if there is a radius.
    pub fn new(
        radius: Option<Length>,
        from: &[[f64; 3]],
        normalization: &Normalization,
    ) -> Option<Self> {
        let diagonal = normalization.diagonal;
        let from = from.iter().map(|&point| normalization.normalize(point.into())).collect();
        radius.map(|radius| Self { radius: radius.of_diagonal(diagonal) / diagonal, from })
    }

    /// Whether a ball can start at each point, around a surface.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] names the first that is inside, or too near.
    pub fn check_starts(
        &self,
        tree: &Bvh,
        is_inside: impl Fn(Vector) -> bool,
    ) -> Result<(), Error> {
        for (index, &point) in self.from.iter().enumerate() {
            let reason = if is_inside(point) {
                "in the solid"
            } else if tree.is_within(point, self.radius) {
                "nearer to the mesh than the radius"
            } else {
                continue;
            };
            return Err(Error::parameter("probe_from", format!("point {index} is {reason}")));
        }
        Ok(())
    }
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

/// Column, row and layer of a cell.
type Place = [usize; 3];

/// The grid. See the module.
#[derive(Clone)]
pub(super) struct Reach {
    origin: Vector,
    /// Side of a cell.
    pub size: f64,
    dimensions: Place,
    pub cells: Vec<Cell>,
}

impl Reach {
    /// The cells around a surface within a box that the centre of a ball of a radius may reach
    /// which stays at least `clear` away. The size of cells follows the radius. O(cells), and a
    /// query of the tree for each cell about that far from the surface.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        tree: &Bvh,
        (min, max): (Vector, Vector),
        [radius, clear]: [f64; 2],
        from: &[Vector],
        control: &Control,
    ) -> Result<Self, Error> {
        let extent = max - min + Vector::splat(2.0 * radius);
        let count = |size: f64| (extent / size).ceil() + Vector::splat(2.0 * BORDER);
        let size = size_for(radius / CELLS_PER_RADIUS, MAX_CELLS, count);
        let origin = (min + max - count(size) * size) * 0.5;
        let dimensions = count(size).to_array().map(|count| count as usize);
        let mut reach = Self { origin, size, dimensions, cells: Vec::new() };
        let [_, height, depth] = dimensions;
        let rows = parallel::map_indices(height * depth, |row| {
            control.check()?;
            Ok(reach.row(tree, (min, max), [row % height, row / height], clear))
        });
        let mut distances = Vec::new();
        for row in rows {
            for (cell, distance) in row? {
                reach.cells.push(cell);
                distances.push(distance);
            }
        }
        let starts = reach.starts(from);
        let is_reached = reach.flooded(&starts, &reach.around(), |_, _| true);
        control.check()?;
        reach.close_unless(|index| is_reached[index]);
        let certain = |a: usize, b: usize| {
            f64::from(distances[a]) + f64::from(distances[b]) >= 2.0 * clear + size
        };
        let beside = reach.beside().map(|step| [step as isize, -(step as isize)]).concat();
        let is_certain = reach.flooded(&starts, &beside, certain);
        reach.close_doubtful(tree, clear, &is_certain, control)?;
        Ok(reach)
    }

    /// A row of cells by their distances from the surface alone, with a lower bound of these. The
    /// surface is in a box.
    fn row(
        &self,
        tree: &Bvh,
        (min, max): (Vector, Vector),
        [y, z]: [usize; 2],
        clear: f64,
    ) -> Vec<(Cell, f32)> {
        let half_diagonal = 0.5 * self.size * 3f64.sqrt();
        let closed = closed_within(clear, half_diagonal);
        let (mut known, mut at, mut guess) = (f64::NAN, 0, u32::MAX);
        let cell = |x: usize| {
            let way = (x - at) as f64 * self.size;
            if known - way >= clear + half_diagonal {
                return (Cell::Open, (known - way) as f32);
            }
            if known + way < clear - half_diagonal {
                return (Cell::Closed, 0.0);
            }
            let centre = self.centre([x, y, z]);
            let from_box = (min - centre).max(centre - max).max(Vector::ZERO).length();
            if from_box >= clear + half_diagonal {
                return (Cell::Open, from_box as f32);
            }
            let closest = tree.closest_point_near(centre, closed, guess);
            (known, at) = (closest.map_or(f64::INFINITY, |closest| closest.distance), x);
            guess = closest.map_or(guess, |closest| closest.triangle);
            (by_distance(known, clear, half_diagonal), known as f32)
        };
        (0..self.dimensions[0]).map(cell).collect()
    }

    /// From a cell that is not of the border to three that share a face with it; the other three
    /// are in the opposite directions.
    fn beside(&self) -> [usize; 3] {
        let [width, height, _] = self.dimensions;
        [1, width, width * height]
    }

    /// From such a cell to those that share a face, an edge or a corner with it.
    fn around(&self) -> Vec<isize> {
        let [width, height, _] = self.dimensions.map(|cells| cells as isize);
        let steps = [-1, 0, 1];
        let rows = steps.map(|z| steps.map(|y| (z * height + y) * width)).concat();
        rows.into_iter().flat_map(|row| steps.map(|x| row + x)).filter(|&step| step != 0).collect()
    }

    /// The cells of the two outermost layers, none of which is closed, and those of the given
    /// points.
    fn starts(&self, from: &[Vector]) -> Vec<Place> {
        let cells = (0..self.cells.len()).map(|index| self.place_of(index));
        let outermost = cells.filter(|&place| self.layer(place) <= 1);
        outermost.chain(from.iter().map(|&point| self.place(point))).collect()
    }

    /// The cells that are not closed and connected to the starts by some steps, where the flood may
    /// pass between two cells. It does not leave the border, beyond which there are no cells.
    fn flooded(
        &self,
        starts: &[Place],
        steps: &[isize],
        may_pass: impl Fn(usize, usize) -> bool,
    ) -> Vec<bool> {
        let mut is_reached = vec![false; self.cells.len()];
        let mut stack: Vec<usize> = Vec::new();
        for &place in starts {
            let index = self.index(place);
            let is_new = !is_reached[index] && self.cells[index] != Cell::Closed;
            is_reached[index] |= is_new;
            if is_new && self.layer(place) > 0 {
                stack.push(index);
            }
        }
        while let Some(index) = stack.pop() {
            for &step in steps {
                let other = index.wrapping_add_signed(step);
                let is_new = !is_reached[other] && self.cells[other] != Cell::Closed;
                if is_new && may_pass(index, other) {
                    is_reached[other] = true;
                    stack.push(other);
                }
            }
        }
        is_reached
    }

    /// Cells between a cell and the border.
    fn layer(&self, place: Place) -> usize {
        let layer = |axis: usize| place[axis].min(self.dimensions[axis] - 1 - place[axis]);
        layer(0).min(layer(1)).min(layer(2))
    }

    fn close_unless(&mut self, is_reached: impl Fn(usize) -> bool) {
        for (index, cell) in self.cells.iter_mut().enumerate() {
            if !is_reached(index) {
                *cell = Cell::Closed;
            }
        }
    }

    /// Closes cells that are neither certain, nor beside such a cell, nor connected to these
    /// through smaller cells.
    fn close_doubtful(
        &mut self,
        tree: &Bvh,
        clear: f64,
        is_certain: &[bool],
        control: &Control,
    ) -> Result<(), Error> {
        // Cells of the border are certain: it does not matter what is beside them.
        let mut is_known = is_certain.to_vec();
        for step in self.beside() {
            let before = is_known.clone();
            for (index, is_known) in is_known.iter_mut().enumerate().skip(step) {
                *is_known |= before[index - step] || before.get(index + step) == Some(&true);
            }
        }
        let is_doubtful = |&index: &usize| !is_known[index] && self.cells[index] != Cell::Closed;
        let doubtful: Vec<usize> = (0..self.cells.len()).filter(is_doubtful).collect();
        let is_partial = |&&index: &&usize| self.cells[index] == Cell::Partial;
        if doubtful.is_empty() || doubtful.iter().filter(is_partial).count() > MAX_DOUBTFUL {
            return Ok(());
        }
        let parts = parallel::map(&doubtful, |&index| {
            control.check()?;
            Ok(self.parts(tree, index, clear))
        });
        let mut parts = parts.into_iter().collect::<Result<Vec<[bool; PARTS]>, Error>>()?;
        let mut reached = vec![false; doubtful.len()];
        // From each part, what is beside it: a part that is reached is closed, so that it is
        // visited once.
        let fine_place = |rank: usize, part: usize| {
            let inner = [part % FINE, part / FINE % FINE, part / FINE / FINE];
            let place = self.place_of(doubtful[rank]);
            [0, 1, 2].map(|axis| place[axis] * FINE + inner[axis])
        };
        let around = |place: Place| {
            let range = |x: usize| x.saturating_sub(1)..x + 2;
            range(place[2]).flat_map(move |z| {
                range(place[1]).flat_map(move |y| range(place[0]).map(move |x| [x, y, z]))
            })
        };
        let cell_of = |place: Place| {
            let place = place.map(|x| x / FINE);
            let is_in = (0..3).all(|axis| place[axis] < self.dimensions[axis]);
            is_in.then(|| self.index(place))
        };
        let starts_at = |place: Place| {
            let is_known_cell = |index: usize| is_known[index] && self.cells[index] != Cell::Closed;
            around(place).filter_map(cell_of).any(is_known_cell)
        };
        let mut stack: Vec<(usize, usize)> = Vec::new();
        for (rank, own) in parts.iter_mut().enumerate() {
            for (part, is_open) in own.iter_mut().enumerate() {
                if *is_open && starts_at(fine_place(rank, part)) {
                    *is_open = false;
                    reached[rank] = true;
                    stack.push((rank, part));
                }
            }
        }
        while let Some((rank, part)) = stack.pop() {
            for place in around(fine_place(rank, part)) {
                let Some(other) = cell_of(place) else { continue };
                let Ok(other) = doubtful.binary_search(&other) else { continue };
                let [x, y, z] = place.map(|x| x % FINE);
                let inner = (z * FINE + y) * FINE + x;
                if std::mem::replace(&mut parts[other][inner], false) {
                    reached[other] = true;
                    stack.push((other, inner));
                }
            }
        }
        for (&index, is_reached) in doubtful.iter().zip(reached) {
            if !is_reached {
                self.cells[index] = Cell::Closed;
            }
        }
        Ok(())
    }

    /// For each part of a cell whether it may hold centres.
    fn parts(&self, tree: &Bvh, index: usize, clear: f64) -> [bool; PARTS] {
        if self.cells[index] == Cell::Open {
            return [true; PARTS];
        }
        let middle = self.centre(self.place_of(index));
        let step = self.size / FINE as f64;
        let half_diagonal = 0.5 * step * 3f64.sqrt();
        let closed = closed_within(clear, half_diagonal);
        let mut guess = u32::MAX;
        std::array::from_fn(|part| {
            let inner = [part % FINE, part / FINE % FINE, part / FINE / FINE];
            let offset = inner.map(|x| (x as f64 - 0.5 * (FINE - 1) as f64) * step);
            let closest = tree.closest_point_near(middle + Vector::from(offset), closed, guess);
            guess = closest.as_ref().map_or(guess, |closest| closest.triangle);
            let distance = closest.map_or(f64::INFINITY, |closest| closest.distance);
            by_distance(distance, clear, half_diagonal) != Cell::Closed
        })
    }

    pub fn index(&self, [x, y, z]: Place) -> usize {
        (z * self.dimensions[1] + y) * self.dimensions[0] + x
    }

    fn place_of(&self, index: usize) -> Place {
        let [x, y, _] = self.dimensions;
        [index % x, index / x % y, index / (x * y)]
    }

    pub fn centre(&self, place: Place) -> Vector {
        self.origin + Vector::from_array(place.map(|x| x as f64 + 0.5)) * self.size
    }

    /// The cell of a point, or the nearest one.
    pub fn place(&self, point: Vector) -> Place {
        let relative = ((point - self.origin) / self.size).to_array();
        [0, 1, 2].map(|k| (relative[k].max(0.0) as usize).min(self.dimensions[k] - 1))
    }
}

/// A part of that radius holds no centre if its middle is so near to the surface, however the
/// square is rounded.
fn closed_within(clear: f64, radius: f64) -> f64 {
    (clear - radius) * (1.0 - 1e-12)
}

/// A cell by the distance of its centre from the surface.
fn by_distance(distance: f64, clear: f64, half_diagonal: f64) -> Cell {
    match distance {
        far if far >= clear + half_diagonal => Cell::Open,
        near if near < clear - half_diagonal => Cell::Closed,
        _ => Cell::Partial,
    }
}
