//! Cubic cells over a bounding box, and the maps between points, cells and indices.

use crate::geometry::vector::Vector;

/// Maximum number of cells. At a bound of 2 % a hundred thousand are enough. At 0.5 % a grid of
/// 200,000 cells leaves so many queries to the tree that the search takes three times as long.
const MAX_CELLS: f64 = 1_500_000.0;

/// Factor by which cells grow until they are few enough: fine steps keep the grid near its limit.
const GROWTH: f64 = 1.05;

/// Minimum extent of the box along an axis, in diagonals: a flat mesh has none along one.
const MIN_EXTENT: f64 = 1e-6;

/// Cells along each axis beyond those that cover the box: one on each side, so that the border is
/// outside the mesh, and one for rounding.
const BORDER: f64 = 3.0;

/// The cells. Points are in single precision, relative to the corner of the first cell.
pub(super) struct Lattice {
    pub origin: Vector,
    /// Side of a cell.
    pub size: f32,
    pub inverse_size: f32,
    pub dimensions: [usize; 3],
}

impl Lattice {
    /// Cells whose half diagonal is half the bound, or larger ones where those were too many.
    pub(super) fn new((min, max): (Vector, Vector), bound: f64) -> Self {
        let extent = [0, 1, 2].map(|k| (max[k] - min[k]).max(MIN_EXTENT));
        let mut size = bound / 3f64.sqrt();
        let count = |size: f64| extent.iter().map(|e| (e / size).ceil() + BORDER).product::<f64>();
        while count(size) > MAX_CELLS {
            size *= GROWTH;
        }
        let dimensions = extent.map(|e| (e / size).ceil() as usize + BORDER as usize);
        let origin = [0, 1, 2].map(|k| 0.5 * (min[k] + max[k]) - 0.5 * size * dimensions[k] as f64);
        Self { origin, size: size as f32, inverse_size: (1.0 / size) as f32, dimensions }
    }

    pub(super) fn count(&self) -> usize {
        self.dimensions.iter().product()
    }

    /// A point relative to the lattice.
    #[inline]
    pub(super) fn relative(&self, point: Vector) -> [f32; 3] {
        [0, 1, 2].map(|k| (point[k] - self.origin[k]) as f32)
    }

    /// The inverse of [`relative`](Self::relative).
    #[inline]
    pub(super) fn absolute(&self, relative: [f32; 3]) -> Vector {
        [0, 1, 2].map(|k| self.origin[k] + f64::from(relative[k]))
    }

    /// The cell of a relative point, or the nearest one.
    #[inline]
    pub(super) fn cell_at(&self, relative: [f32; 3]) -> [usize; 3] {
        [0, 1, 2].map(|k| {
            let x = (relative[k] * self.inverse_size).max(0.0) as usize;
            x.min(self.dimensions[k] - 1)
        })
    }

    #[inline]
    pub(super) fn index(&self, cell: [usize; 3]) -> usize {
        (cell[2] * self.dimensions[1] + cell[1]) * self.dimensions[0] + cell[0]
    }

    /// The inverse of [`index`](Self::index).
    pub(super) fn cell(&self, index: usize) -> [usize; 3] {
        let [x, y, _] = self.dimensions;
        [index % x, index / x % y, index / (x * y)]
    }

    /// The relative centre of a cell.
    #[inline]
    pub(super) fn centre(&self, cell: [usize; 3]) -> [f32; 3] {
        cell.map(|x| (x as f32 + 0.5) * self.size)
    }

    /// The cells that share a side with a cell; `None` beyond the border.
    pub(super) fn neighbours(&self, index: usize) -> [Option<usize>; 6] {
        let [width, height, depth] = self.dimensions;
        let [x, y, z] = self.cell(index);
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
}
