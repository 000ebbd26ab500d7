//! For each cell near the surface its closest point, and the triangle that contains it.
//!
//! A vector distance transform (Danielsson, "Euclidean Distance Mapping", 1980) with triangles in
//! place of points: starting from the cells that the surface passes through, the closest triangle
//! propagates from cell to cell in order of distance, and each cell evaluates one triangle. So a
//! distance may be too large by a fraction of a cell, never too small. O(cells + samples of the
//! triangles).

use super::lattice::Lattice;
use super::vector_f32::{length, subtract};
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{self, Vector, bounds};

/// Width of the band around the surface where distances are known, in bounds: the fit test compares
/// distances with up to 1.5 bounds, from points up to half a bound beside a cell's centre.
const BAND: f64 = 2.5;

/// Minimum width of the band, in cells: a band within single cells would propagate nowhere.
const MIN_BAND: f64 = 2.0;

/// Buckets of the priority queue, by distance. The finer they are, the closer is the order of
/// propagation to that of distance, and the smaller the excess of distances; one is a twentieth of
/// a bound.
const BUCKETS: usize = 48;

/// A triangle with one side at most this short and another longer than this, in cells, is a needle.
/// Needles are sampled in rows along their shortest side: in rows along all sides, most samples of
/// a mesh of needles would fall into the same cells.
const NEEDLE_WIDTH: f32 = 2.0;
const NEEDLE_LENGTH: f32 = 8.0;

/// Distances are too large by less than this, in cells: where two sheets pass through the same
/// cells, those beyond may know only the farther one. The largest excess in 147 models is 0.96.
pub(super) const MAX_EXCESS: f64 = 1.25;

/// Triangles between two checks for cancellation: a large triangle has thousands of samples.
const TRIANGLES_PER_CHECK: u32 = 1024;

/// Cells between two checks for cancellation: about a millisecond.
pub(super) const CELLS_PER_CHECK: usize = 16_384;

/// What a cell knows about its centre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Closest point of the surface, relative to the lattice; NaN beyond the band.
    pub nearest: [f32; 3],
    /// Distance to it; the band's width beyond the band.
    pub distance: f32,
}

/// The field. See the module.
pub(super) struct DistanceField {
    pub lattice: Lattice,
    pub cells: Vec<Cell>,
    /// For each cell the triangle that contains the closest point; `u32::MAX` beyond the band.
    pub triangles: Vec<u32>,
}

/// Cells by distance, nearest bucket first.
struct Buckets {
    cells: Vec<Vec<u32>>,
    band: f32,
}

impl Buckets {
    fn bucket(&self, distance: f32) -> usize {
        ((distance / self.band * BUCKETS as f32) as usize).min(BUCKETS - 1)
    }
}

impl DistanceField {
    /// # Errors
    /// [`Error::Cancelled`].
    pub(super) fn new(
        positions: &[Vector],
        triangles: &[[u32; 3]],
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let lattice = Lattice::new(bounds(positions.iter().copied()), bound);
        let band = (BAND * bound).max(MIN_BAND * f64::from(lattice.size)) as f32;
        let count = lattice.count();
        let mut field = Self {
            cells: vec![Cell { nearest: [f32::NAN; 3], distance: band }; count],
            triangles: vec![u32::MAX; count],
            lattice,
        };
        let origin = field.lattice.origin;
        let relative: Vec<Vector> =
            positions.iter().map(|&point| vector::subtract(point, origin)).collect();
        let corners = |t: u32| triangles[t as usize].map(|v| relative[v as usize]);
        let mut buckets = Buckets { cells: vec![Vec::new(); BUCKETS], band };
        for triangle in 0..triangles.len() as u32 {
            if triangle.is_multiple_of(TRIANGLES_PER_CHECK) {
                control.check()?;
            }
            field.insert(triangle, corners(triangle), &mut buckets);
        }
        field.propagate(buckets, corners, control)?;
        Ok(field)
    }

    /// Samples a triangle densely enough to find every cell that it passes through.
    fn insert(&mut self, triangle: u32, corners: [Vector; 3], buckets: &mut Buckets) {
        let [mut a, mut b, mut c] = corners.map(|corner| corner.map(|x| x as f32));
        let inverse_size = self.lattice.inverse_size;
        let side = |from: [f32; 3], to: [f32; 3]| length(subtract(to, from)) * inverse_size;
        let longest = side(a, b).max(side(b, c)).max(side(c, a));
        let samples = longest.ceil().max(1.0) as usize;
        let shortest = side(a, b).min(side(b, c)).min(side(c, a));
        let is_needle = shortest <= NEEDLE_WIDTH && longest > NEEDLE_LENGTH;
        while is_needle && side(a, b) > shortest {
            (a, b, c) = (b, c, a);
        }
        let rows = if is_needle { shortest.ceil().max(1.0) as usize } else { samples };
        let (u, v) = (subtract(b, a), subtract(c, a));
        let mut last = usize::MAX;
        for i in 0..=rows {
            let x = i as f32 / rows as f32;
            let (most, share) = if is_needle { (samples, 1.0 - x) } else { (samples - i, 1.0) };
            for j in 0..=most {
                let y = share * (j as f32 / samples as f32);
                let point = [0, 1, 2].map(|k| a[k] + x * u[k] + y * v[k]);
                let cell = self.lattice.cell_at(point);
                let index = self.lattice.index(cell);
                if index == last {
                    continue;
                }
                last = index;
                let (nearest, distance) = closest_point(self.lattice.centre(cell), corners);
                let cell = &mut self.cells[index];
                if distance < cell.distance {
                    *cell = Cell { nearest, distance };
                    self.triangles[index] = triangle;
                    let bucket = buckets.bucket(distance);
                    buckets.cells[bucket].push(index as u32);
                }
            }
        }
    }

    /// Propagates closest triangles from cell to cell, in order of distance.
    fn propagate(
        &mut self,
        mut buckets: Buckets,
        corners: impl Fn(u32) -> [Vector; 3],
        control: &Control,
    ) -> Result<(), Error> {
        let [width, height, depth] = self.lattice.dimensions;
        let strides = [1, width, width * height];
        let mut is_done = vec![false; self.cells.len()];
        for current in 0..BUCKETS {
            let mut next = 0;
            while let Some(&index) = buckets.cells[current].get(next) {
                if next.is_multiple_of(CELLS_PER_CHECK) {
                    control.check()?;
                }
                next += 1;
                let index = index as usize;
                if is_done[index] {
                    continue;
                }
                is_done[index] = true;
                let cell = self.lattice.cell(index);
                let triangle = self.triangles[index];
                let (nearest, distance) =
                    closest_point(self.lattice.centre(cell), corners(triangle));
                self.cells[index] = Cell { nearest, distance };
                for axis in 0..3 {
                    for forward in [false, true] {
                        let is_at_border = if forward {
                            cell[axis] + 1 >= [width, height, depth][axis]
                        } else {
                            cell[axis] == 0
                        };
                        if is_at_border {
                            continue;
                        }
                        let neighbour =
                            if forward { index + strides[axis] } else { index - strides[axis] };
                        if is_done[neighbour] {
                            continue;
                        }
                        let mut other = cell;
                        other[axis] = if forward { other[axis] + 1 } else { other[axis] - 1 };
                        let distance = length(subtract(self.lattice.centre(other), nearest));
                        if distance < self.cells[neighbour].distance {
                            self.cells[neighbour] = Cell { nearest, distance };
                            self.triangles[neighbour] = triangle;
                            let bucket = buckets.bucket(distance).max(current);
                            buckets.cells[bucket].push(neighbour as u32);
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// The point of a triangle closest to another, and its distance. In double precision, since single
/// precision fails for needles.
#[inline]
fn closest_point(p: [f32; 3], [a, b, c]: [Vector; 3]) -> ([f32; 3], f32) {
    let point = p.map(f64::from);
    let [a, b, c] = [a, b, c].map(|corner| vector::subtract(corner, point));
    let nearest = closest_point_on_triangle(a, b, c);
    (vector::add(point, nearest).map(|x| x as f32), vector::length(nearest) as f32)
}
