//! Cells over a box: how large they are, and blocks of them that are allocated when they are
//! needed.

use std::sync::OnceLock;

use super::vector::Vector;

/// Factor by which cells grow until they are few enough: fine steps keep grids near their limit.
const GROWTH: f64 = 1.05;

/// The least size of cells, from `size` on, with which there are no more than `most`. `count` gives
/// the number of cells along each axis.
pub(crate) fn size_for(mut size: f64, most: f64, count: impl Fn(f64) -> Vector) -> f64 {
    while count(size).element_product() > most {
        size *= GROWTH;
    }
    size
}

/// A column, a row and a layer.
type Place = [usize; 3];

/// Blocks of `SIDE` cells along each axis, each allocated as a whole when it is first needed. What
/// a cell holds must depend on its place alone: then threads may fill it at the same time.
pub(crate) struct Blocks<B, const SIDE: usize> {
    /// Cells along each axis.
    pub dimensions: Place,
    /// Blocks along the first two axes.
    stride: [usize; 2],
    blocks: Vec<OnceLock<Box<B>>>,
}

impl<B, const SIDE: usize> Blocks<B, SIDE> {
    /// Cells in a block.
    pub const CELLS: usize = SIDE * SIDE * SIDE;

    pub fn new(dimensions: Place) -> Self {
        let [x, y, z] = dimensions.map(|cells| cells.div_ceil(SIDE));
        let mut blocks = Vec::new();
        blocks.resize_with(x * y * z, OnceLock::new);
        Self { dimensions, stride: [x, y], blocks }
    }

    /// Whether there is a cell.
    pub fn contains(&self, place: Place) -> bool {
        (0..3).all(|axis| place[axis] < self.dimensions[axis])
    }

    /// The block of a cell that there is, made if it is missing.
    #[inline]
    pub fn block(&self, place: Place, make: impl FnOnce() -> B) -> &B {
        self.blocks[self.index(place)].get_or_init(|| Box::new(make()))
    }

    /// The block of a cell, if both exist.
    pub fn known(&self, place: Place) -> Option<&B> {
        let block = self.contains(place).then(|| self.index(place))?;
        self.blocks.get(block)?.get().map(Box::as_ref)
    }

    #[inline]
    fn index(&self, place: Place) -> usize {
        let [width, depth] = self.stride;
        let [i, j, k] = place.map(|place| place / SIDE);
        (k * depth + j) * width + i
    }

    /// The index of a cell in its block.
    #[inline]
    pub fn index_in_block(place: Place) -> usize {
        let [i, j, k] = place.map(|place| place % SIDE);
        (k * SIDE + j) * SIDE + i
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_grow_until_they_are_few_enough_and_no_further() {
        let count = |size: f64| (Vector::new(4.0, 2.0, 1.0) / size).ceil();
        assert_eq!(size_for(1.0, 8.0, count), 1.0);
        let size = size_for(0.1, 8.0, count);
        assert!(count(size).element_product() <= 8.0);
        assert!(count(size / GROWTH).element_product() > 8.0);
    }

    #[test]
    fn every_cell_has_a_place_of_its_own() {
        let cells = Blocks::<usize, 4>::new([5, 9, 3]);
        let mut places = std::collections::HashSet::new();
        for index in 0..5 * 9 * 3 {
            let place = [index % 5, index / 5 % 9, index / 45];
            assert!(cells.contains(place) && cells.index(place) < cells.blocks.len());
            let in_block = Blocks::<usize, 4>::index_in_block(place);
            assert!(in_block < Blocks::<usize, 4>::CELLS);
            assert!(places.insert((cells.index(place), in_block)), "{place:?}");
        }
        assert!(!cells.contains([5, 0, 0]) && cells.known([0, 0, 3]).is_none());
    }

    #[test]
    fn a_block_is_made_once() {
        let cells = Blocks::<usize, 4>::new([8, 8, 8]);
        assert_eq!(cells.known([1, 2, 3]), None);
        assert_eq!(cells.block([1, 2, 3], || 7), &7);
        assert_eq!(cells.block([3, 0, 0], || 8), &7);
        assert_eq!(cells.known([0, 3, 2]), Some(&7));
    }
}
