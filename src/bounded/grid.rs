//! A grid over the mesh whose cells know the nearest point of the surface, and on which side of
//! it they lie: most questions of a fit test are answered here, without a look at the mesh.
//!
//! The nearest triangle is handed on from cell to cell, nearest cells first, starting from those
//! that the surface passes through: each cell asks one triangle (a vector distance transform,
//! Danielsson 1980, with triangles for points). So distances may come out too large by a small
//! share of a cell, never too small. Cells farther than a band from the surface only know that.
//! Sides are flooded through cells that the surface does not touch (see `flood`), one winding number for each
//! connected region; where the mesh is open, each cell that is asked for has its own.

mod flood;

use std::sync::atomic::{AtomicU8, Ordering};

use super::solid::is_inside;
use crate::bvh::Bvh;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, add, bounds, subtract};
use flood::{FREE, neighbours};

/// Most cells. At a bound of 2 % a hundred thousand are enough; at 0.5 % a coarser grid than this
/// leaves so much to the tree that the search takes three times as long and ends with more hulls.
const MOST_CELLS: f64 = 1_500_000.0;

/// Width of the band around the surface where distances are known, in bounds.
const BAND: f64 = 2.5;

/// Distances are handed on in this many steps of growing distance.
const STEPS: usize = 48;

/// A triangle with one side this short and another this long, in cells, is a needle.
const NEEDLE_WIDTH: f32 = 2.0;
const NEEDLE_LENGTH: f32 = 8.0;

/// Distances are too large by less than this, in cells: where two sheets pass through the same
/// cells, those beyond may have heard of the farther one only.
const SURPLUS: f64 = 1.25;

/// Triangles between two looks at the control.
const TRIANGLES_PER_CHECK: u32 = 1024;

/// Cells between two looks at the control.
const CELLS_PER_CHECK: usize = 16_384;

const UNKNOWN: u8 = 0;
const INSIDE: u8 = 1;
const OUTSIDE: u8 = 2;

/// Half the diagonal of a cell, in cells.
const HALF_DIAGONAL: f64 = 0.8660254037844387;

/// What holds for all points of a cell. One byte each, so that they stay in the processor's cache.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// In the solid, or near it.
    Near,
    /// Outside, and, as far as the grid knows, far from it.
    Far,
    /// Some are here, some there, or it is not known.
    Mixed,
}

/// What a cell knows of its centre.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// Nearest point of the surface, from the grid's origin.
    nearest: [f32; 3],
    /// Distance to it; the band's width where it is beyond.
    distance: f32,
}

/// The grid. See the module.
pub(super) struct Grid {
    origin: Vector,
    size: f32,
    inverse: f32,
    dimensions: [usize; 3],
    cells: Vec<Cell>,
    /// The triangle that holds the nearest point; `u32::MAX` beyond the band.
    owners: Vec<u32>,
    sides: Vec<AtomicU8>,
    verdicts: Vec<Verdict>,
    band: f32,
    is_flooded: bool,
}

/// What is known about a point.
pub(super) struct Probe {
    /// At least the distance to the surface; infinite where it is only known to be far.
    pub upper: f64,
    /// At most the distance to the surface (up to the handing-on); negative if nothing is known.
    pub lower: f64,
    index: usize,
}

impl Grid {
    /// # Errors
    /// [`Error::Cancelled`].
    pub(super) fn new(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let (min, max) = bounds(positions.iter().copied());
        let extent = [0, 1, 2].map(|k| (max[k] - min[k]).max(1e-6));
        // Half the diagonal of a cell is half the bound.
        let mut size = bound / 3f64.sqrt();
        let count = |size: f64| extent.iter().map(|e| (e / size).ceil() + 3.0).product::<f64>();
        while count(size) > MOST_CELLS {
            size *= 1.05;
        }
        let dimensions = extent.map(|e| (e / size).ceil() as usize + 3);
        let origin = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]) - 0.5 * size * dimensions[k] as f64);
        let total = dimensions.iter().product();
        let band = (BAND * bound).max(2.0 * size) as f32;
        let mut grid = Self {
            origin,
            size: size as f32,
            inverse: (1.0 / size) as f32,
            dimensions,
            cells: vec![Cell { nearest: [f32::NAN; 3], distance: band }; total],
            owners: vec![u32::MAX; total],
            sides: Vec::new(),
            verdicts: Vec::new(),
            band,
            is_flooded: false,
        };
        grid.spread(positions, triangles, control)?;
        grid.sides.resize_with(total, || AtomicU8::new(UNKNOWN));
        Ok(grid)
    }

    #[inline]
    fn relative(&self, point: Vector) -> [f32; 3] {
        [0, 1, 2].map(|k| (point[k] - self.origin[k]) as f32)
    }

    #[inline]
    fn place(&self, relative: [f32; 3]) -> [usize; 3] {
        [0, 1, 2].map(|k| {
            let x = (relative[k] * self.inverse).max(0.0) as usize;
            x.min(self.dimensions[k] - 1)
        })
    }

    #[inline]
    fn index(&self, place: [usize; 3]) -> usize {
        (place[2] * self.dimensions[1] + place[1]) * self.dimensions[0] + place[0]
    }

    fn place_of(&self, index: usize) -> [usize; 3] {
        let [x, y, _] = self.dimensions;
        [index % x, index / x % y, index / (x * y)]
    }

    #[inline]
    fn centre(&self, place: [usize; 3]) -> [f32; 3] {
        place.map(|x| (x as f32 + 0.5) * self.size)
    }

    pub(super) fn centre_in_space(&self, index: usize) -> Vector {
        let centre = self.centre(self.place_of(index));
        [0, 1, 2].map(|k| self.origin[k] + f64::from(centre[k]))
    }

    /// Hands nearest triangles on from cell to cell.
    fn spread(
        &mut self,
        positions: &[Vector],
        triangles: &[[u32; 3]],
        control: &Control,
    ) -> Result<(), Error> {
        let relative: Vec<Vector> =
            positions.iter().map(|&point| subtract(point, self.origin)).collect();
        let corners = |t: u32| triangles[t as usize].map(|v| relative[v as usize]);
        let mut steps: Vec<Vec<u32>> = vec![Vec::new(); STEPS];
        let step = |d: f32, band: f32| ((d / band * STEPS as f32) as usize).min(STEPS - 1);
        for t in 0..triangles.len() as u32 {
            if t.is_multiple_of(TRIANGLES_PER_CHECK) {
                control.check()?;
            }
            let triangle = corners(t);
            let [mut a, mut b, mut c] = triangle.map(|corner| corner.map(|x| x as f32));
            let side = |from: [f32; 3], to: [f32; 3]| length(sub(to, from)) * self.inverse;
            let longest = side(a, b).max(side(b, c)).max(side(c, a));
            let cuts = longest.ceil().max(1.0) as usize;
            // Across a needle a few rows are enough: along its shortest side.
            let shortest = side(a, b).min(side(b, c)).min(side(c, a));
            let is_needle = shortest <= NEEDLE_WIDTH && longest > NEEDLE_LENGTH;
            while is_needle && side(a, b) > shortest {
                (a, b, c) = (b, c, a);
            }
            let rows = if is_needle { shortest.ceil().max(1.0) as usize } else { cuts };
            let (u, v) = (sub(b, a), sub(c, a));
            let mut last = usize::MAX;
            for i in 0..=rows {
                let x = i as f32 / rows as f32;
                let (most, share) = if is_needle { (cuts, 1.0 - x) } else { (cuts - i, 1.0) };
                for j in 0..=most {
                    let y = share * (j as f32 / cuts as f32);
                    let point = [0, 1, 2].map(|k| a[k] + x * u[k] + y * v[k]);
                    let place = self.place(point);
                    let index = self.index(place);
                    if index == last {
                        continue;
                    }
                    last = index;
                    let (nearest, d) = nearest_of(self.centre(place), triangle);
                    let cell = &mut self.cells[index];
                    if d < cell.distance {
                        *cell = Cell { nearest, distance: d };
                        self.owners[index] = t;
                        steps[step(d, self.band)].push(index as u32);
                    }
                }
            }
        }
        let [width, height, depth] = self.dimensions;
        let strides = [1, width, width * height];
        let mut done = vec![false; self.cells.len()];
        for current in 0..STEPS {
            let mut next = 0;
            while let Some(&index) = steps[current].get(next) {
                if next.is_multiple_of(CELLS_PER_CHECK) {
                    control.check()?;
                }
                next += 1;
                let index = index as usize;
                if done[index] {
                    continue;
                }
                done[index] = true;
                let place = self.place_of(index);
                let triangle = self.owners[index];
                let (nearest, d) = nearest_of(self.centre(place), corners(triangle));
                self.cells[index] = Cell { nearest, distance: d };
                for axis in 0..3 {
                    for forward in [false, true] {
                        let at_end = if forward {
                            place[axis] + 1 >= [width, height, depth][axis]
                        } else {
                            place[axis] == 0
                        };
                        if at_end {
                            continue;
                        }
                        let neighbour =
                            if forward { index + strides[axis] } else { index - strides[axis] };
                        if done[neighbour] {
                            continue;
                        }
                        let mut other = place;
                        other[axis] = if forward { other[axis] + 1 } else { other[axis] - 1 };
                        let d = length(sub(self.centre(other), nearest));
                        if d < self.cells[neighbour].distance {
                            self.cells[neighbour] = Cell { nearest, distance: d };
                            self.owners[neighbour] = triangle;
                            let step = step(d, self.band).max(current);
                            steps[step].push(neighbour as u32);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Finds out which cells are near as a whole, at most the distance `near` away, and which far, by
    /// more than `far`, once the sides are flooded.
    pub(super) fn judge_cells(&mut self, near: f64, far: f64) {
        let half = HALF_DIAGONAL * f64::from(self.size);
        let is_flooded = self.is_flooded;
        let verdict = |(cell, side): (&Cell, &mut AtomicU8)| {
            let distance = f64::from(cell.distance);
            match *side.get_mut() {
                _ if distance + half <= near => Verdict::Near,
                INSIDE if is_flooded && distance > half => Verdict::Near,
                OUTSIDE if is_flooded && distance - half > far => Verdict::Far,
                _ => Verdict::Mixed,
            }
        };
        self.verdicts = self.cells.iter().zip(&mut self.sides).map(verdict).collect();
    }

    /// What the cell says about all of its points.
    #[inline]
    pub(super) fn verdict(&self, point: Vector) -> Verdict {
        self.verdicts[self.index(self.place(self.relative(point)))]
    }

    pub(super) fn count(&self) -> usize {
        self.cells.len()
    }

    /// How far the centre of a cell is from the surface, up to the band.
    pub(super) fn distance(&self, index: usize) -> f32 {
        self.cells[index].distance
    }

    /// Whether a cell is so far from the surface that ways through such cells don't cross it.
    pub(super) fn is_free(&self, index: usize, bound: f64) -> bool {
        self.cells[index].distance > (bound as f32).max(FREE * self.size)
    }

    /// The cells that share a side with a cell; `None` at the border of the grid.
    pub(super) fn neighbours(&self, index: usize) -> [Option<usize>; 6] {
        neighbours(self.dimensions, index)
    }

    /// What the grid knows about a point.
    #[inline]
    pub(super) fn probe(&self, point: Vector) -> Probe {
        let relative = self.relative(point);
        let place = self.place(relative);
        let index = self.index(place);
        let cell = &self.cells[index];
        let away = length(sub(relative, self.centre(place)));
        let upper = length(sub(relative, cell.nearest));
        Probe {
            upper: if upper.is_nan() { f64::INFINITY } else { f64::from(upper) },
            lower: f64::from(cell.distance - away),
            index,
        }
    }

    /// The distance to the surface, if that is a plane near the point; infinite where nothing is
    /// near.
    #[inline]
    pub(super) fn estimate(&self, point: Vector) -> f64 {
        let relative = self.relative(point);
        let place = self.place(relative);
        let nearest = self.cells[self.index(place)].nearest;
        let normal = sub(self.centre(place), nearest);
        let height = dot(sub(relative, nearest), normal) / length(normal);
        if height.is_nan() { f64::INFINITY } else { f64::from(height) }
    }

    /// The point of the surface nearest to the centre of a point's cell, if that is near.
    #[inline]
    pub(super) fn nearest(&self, point: Vector) -> Option<Vector> {
        let index = self.index(self.place(self.relative(point)));
        let nearest = self.cells[index].nearest;
        (!nearest[0].is_nan()).then(|| [0, 1, 2].map(|k| self.origin[k] + f64::from(nearest[k])))
    }

    /// The triangle nearest to the centre of a point's cell; `u32::MAX` if that is far away.
    #[inline]
    pub(super) fn owner(&self, point: Vector) -> u32 {
        self.owners[self.index(self.place(self.relative(point)))]
    }

    /// Whether the probe's point is inside; `None` if it may be on the other side than its cell.
    #[inline]
    pub(super) fn is_inside(&self, probe: &Probe, bvh: &Bvh) -> Option<bool> {
        if probe.lower <= 0.0 {
            return None;
        }
        match self.sides[probe.index].load(Ordering::Relaxed) {
            INSIDE => Some(true),
            OUTSIDE => Some(false),
            _ => self.ask_side(probe.index, bvh),
        }
    }

    /// A lower bound on the depth of a point inside; `None` if it may be outside. Only for closed surfaces.
    #[inline]
    pub(super) fn depth(&self, point: Vector) -> Option<f64> {
        let probe = self.probe(point);
        let depth = probe.lower - SURPLUS * f64::from(self.size);
        let is_inside = depth > 0.0
            && self.is_flooded
            && self.sides[probe.index].load(Ordering::Relaxed) == INSIDE;
        is_inside.then_some(depth)
    }

    /// Whether a point is inside that is `distance` from the surface, if its cell tells. Only for
    /// closed surfaces: where one is open, being inside may end without it.
    #[inline]
    pub(super) fn side(&self, point: Vector, distance: f64) -> Option<bool> {
        let relative = self.relative(point);
        let place = self.place(relative);
        if f64::from(length(sub(relative, self.centre(place)))) >= distance || !self.is_flooded {
            return None;
        }
        match self.sides[self.index(place)].load(Ordering::Relaxed) {
            INSIDE => Some(true),
            OUTSIDE => Some(false),
            _ => None,
        }
    }

    #[cold]
    fn ask_side(&self, index: usize, bvh: &Bvh) -> Option<bool> {
        let inside = is_inside(bvh, self.centre_in_space(index), self.is_flooded);
        self.sides[index].store(if inside { INSIDE } else { OUTSIDE }, Ordering::Relaxed);
        Some(inside)
    }
}

#[inline]
fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn length(a: [f32; 3]) -> f32 {
    dot(a, a).sqrt()
}

/// The nearest point of a triangle, and how far it is. In double precision, for needles.
#[inline]
fn nearest_of(p: [f32; 3], [a, b, c]: [Vector; 3]) -> ([f32; 3], f32) {
    let point = p.map(f64::from);
    let [a, b, c] = [a, b, c].map(|corner| subtract(corner, point));
    let nearest = closest_point_on_triangle(a, b, c);
    (add(point, nearest).map(|x| x as f32), crate::geometry::vector::length(nearest) as f32)
}
