//! The space around a solid that is far from it, and where a ball of that radius gets to from
//! outside; with a probe, where the probe gets to.
//!
//! A grid of cells is flooded from its border. A ball passes from one cell to the next if the
//! solid is farther from both centres than its radius and half a cell: so what is flooded is in the
//! open for certain. Passages that are hardly wider than the ball are missed, which only makes the
//! bound lower.

use crate::control::Control;
use crate::error::Error;
use crate::geometry::blocks::size_for;
use crate::geometry::vector::Vector;
use crate::parallel;
use crate::probe::ProbeSettings;
use crate::solid::Solid;

/// Cells along the radius of the ball.
const CELLS_PER_RADIUS: f64 = 2.0;

/// Maximum number of cells: where it is not enough they are larger, and more passages are missed.
const MAX_CELLS: f64 = 400_000.0;

/// Cells beyond the mesh on each side, beside the radius.
const BORDER: f64 = 2.0;

type Place = [usize; 3];

/// See the module. Lengths are fractions of the diagonal.
pub(super) struct OpenSpace<'a> {
    solid: &'a Solid,
    probe: Option<&'a ProbeSettings>,
    /// A point that is farther than this from the solid, and in the open, is in no hull.
    far: f64,
    /// Of the ball that is in the open: as large as that, or the probe.
    radius: f64,
    origin: Vector,
    size: f64,
    dimensions: Place,
    is_open: Vec<bool>,
}

impl<'a> OpenSpace<'a> {
    /// O(cells) queries.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn new(
        solid: &'a Solid,
        probe: Option<&'a ProbeSettings>,
        far: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let radius = probe.map_or(far, |probe| probe.radius);
        let (min, max) = solid.bounds();
        let extent = max - min + Vector::splat(2.0 * radius);
        let count = |size: f64| (extent / size).ceil() + Vector::splat(2.0 * BORDER);
        let size = size_for(radius / CELLS_PER_RADIUS, MAX_CELLS, count);
        let origin = (min + max - count(size) * size) * 0.5;
        let dimensions = count(size).to_array().map(|count| count as usize);
        let is_open = Vec::new();
        let mut space = Self { solid, probe, far, radius, origin, size, dimensions, is_open };
        if radius < far {
            // A probe so small shows nothing: hulls may be anywhere.
            return Ok(space);
        }
        let [_, height, depth] = dimensions;
        let rows = parallel::map_indices(height * depth, |row| {
            control.check()?;
            Ok(space.row([row % height, row / height]))
        });
        let mut is_free = Vec::new();
        for row in rows {
            is_free.extend(row?);
        }
        space.is_open = space.flooded(&is_free);
        Ok(space)
    }

    /// For each cell of a row whether a ball about its centre, and half a cell larger, is free.
    fn row(&self, [y, z]: [usize; 2]) -> Vec<bool> {
        let needed = self.radius + 0.5 * self.size;
        let (mut known, mut at) = (f64::NAN, 0);
        let cell = |x: usize| {
            let way = (x - at) as f64 * self.size;
            // The clearance changes no faster than the place; where it is 0 it says nothing.
            if known - way >= needed || (known > 0.0 && known + way < needed) {
                return known - way >= needed;
            }
            (known, at) = (self.solid.clearance(self.centre([x, y, z]), 0.0), x);
            known >= needed
        };
        (0..self.dimensions[0]).map(cell).collect()
    }

    fn centre(&self, place: Place) -> Vector {
        self.origin + Vector::from_array(place.map(|x| x as f64 + 0.5)) * self.size
    }

    fn index(&self, [x, y, z]: Place) -> usize {
        (z * self.dimensions[1] + y) * self.dimensions[0] + x
    }

    /// The free cells that are connected to the border.
    fn flooded(&self, is_free: &[bool]) -> Vec<bool> {
        let mut is_open = vec![false; is_free.len()];
        let mut stack: Vec<Place> = vec![[0; 3]];
        let starts = self.probe.iter().flat_map(|probe| &probe.from);
        stack.extend(starts.filter_map(|&point| self.place(point)));
        for &place in &stack {
            let index = self.index(place);
            is_open[index] = is_free[index];
        }
        stack.retain(|&place| is_open[self.index(place)]);
        while let Some(place) = stack.pop() {
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut next = place;
                    let Some(x) = place[axis].checked_add_signed(step) else { continue };
                    if x >= self.dimensions[axis] {
                        continue;
                    }
                    next[axis] = x;
                    let index = self.index(next);
                    if is_free[index] && !is_open[index] {
                        is_open[index] = true;
                        stack.push(next);
                    }
                }
            }
        }
        is_open
    }

    /// The cell of a point; `None` outside the grid.
    fn place(&self, point: Vector) -> Option<Place> {
        let relative = ((point - self.origin) / self.size).to_array();
        let place = relative.map(|x| x.max(0.0) as usize);
        let is_in = (0..3).all(|axis| relative[axis] >= 0.0 && place[axis] < self.dimensions[axis]);
        is_in.then_some(place)
    }

    /// Whether no hull that keeps the bound contains the point.
    pub fn excludes(&self, point: Vector) -> bool {
        let clearance = self.solid.clearance(point, self.far);
        // Without a probe the ball goes straight from an open cell to the point. With one the
        // point is so deep in a ball that is in the open.
        let way = match self.probe {
            None => clearance - self.far + 0.5 * self.size,
            Some(_) => self.radius - self.far,
        };
        clearance > self.far && self.is_near_open(point, way)
    }

    /// Whether the centre of an open cell around a point is no farther than this from it.
    fn is_near_open(&self, point: Vector, way: f64) -> bool {
        let Some(place) = self.place(point).filter(|_| !self.is_open.is_empty()) else {
            return false;
        };
        let cells = (way / self.size).ceil().clamp(1.0, 3.0) as usize;
        let range = |axis: usize| {
            let from = place[axis].saturating_sub(cells);
            from..(place[axis] + cells + 1).min(self.dimensions[axis])
        };
        range(2).any(|z| {
            range(1).any(|y| {
                range(0).any(|x| {
                    self.is_open[self.index([x, y, z])]
                        && self.centre([x, y, z]).distance(point) <= way
                })
            })
        })
    }
}
