//! The cells of a lazy grid, in blocks.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::bounded::containment::boundary::Slope;
use crate::bounded::containment::inside::OPEN_INSIDE;

/// Cells of a block along each axis, as a power of two: blocks are allocated whole, and a face
/// passes through several cells of one.
pub(super) const BLOCK_BITS: usize = 2;
pub(super) const BLOCK: usize = 1 << BLOCK_BITS;

/// The distance of an empty cell, as bits. A cell on the surface has the smallest distance above.
pub(super) const EMPTY: u32 = 0;

/// The reach of a cell whose side is unknown, and of one outside, as bits of single precision.
pub(super) const UNKNOWN: u32 = u32::MAX;
pub(super) const OUTSIDE: f32 = -1.0;

/// The reach of a cell that is known to be inside, and no more.
pub(super) const UNKNOWN_INSIDE: f32 = f32::INFINITY;

/// What is known about a cell's centre. Single precision numbers as bits.
pub(super) struct Cell {
    pub(super) nearest: [AtomicU32; 3],
    pub(super) triangle: AtomicU32,
    /// Written last.
    pub(super) distance: AtomicU32,
    /// All points nearer than this to the centre are inside; [`OUTSIDE`] if the centre is not.
    pub(super) reach: AtomicU32,
    /// In an open solid, by how many whole turns the winding number differs from that about the
    /// block's centre, as bits; or [`UNKNOWN`].
    pub(super) turns: AtomicU32,
    /// In an open solid, the winding number, where it was computed; or [`UNKNOWN`].
    pub(super) number: AtomicU32,
}

impl Cell {
    pub(super) fn empty() -> Self {
        Self {
            nearest: [const { AtomicU32::new(0) }; 3],
            triangle: AtomicU32::new(u32::MAX),
            distance: AtomicU32::new(EMPTY),
            reach: AtomicU32::new(UNKNOWN),
            turns: AtomicU32::new(UNKNOWN),
            number: AtomicU32::new(UNKNOWN),
        }
    }

    pub(super) fn nearest(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| f32::from_bits(self.nearest[k].load(Ordering::Relaxed)))
    }

    pub(super) fn distance(&self) -> f32 {
        f32::from_bits(self.distance.load(Ordering::Relaxed))
    }
}

/// A ball that is on one side as a whole. Single precision numbers as bits.
pub(super) struct Ball {
    /// The distance of its centre from the surface, or [`EMPTY`].
    pub(super) distance: AtomicU32,
    /// Its radius, negative if it is outside; or [`UNKNOWN`].
    pub(super) radius: AtomicU32,
}

impl Ball {
    pub(super) fn empty() -> Self {
        Self { distance: AtomicU32::new(EMPTY), radius: AtomicU32::new(UNKNOWN) }
    }
}

/// The winding number about a block's centre.
pub(super) struct BlockWinding {
    pub(super) number: f64,
    pub(super) slope: Slope,
}

impl BlockWinding {
    /// The radius of a ball around the centre that is on one side as a whole, negative outside, if the surface is
    /// `distance` away.
    pub(super) fn radius(&self, distance: f32) -> f32 {
        let excess = self.number - OPEN_INSIDE;
        let reach = (self.slope.reach(excess.abs()) as f32).min(distance);
        if excess > 0.0 { reach } else { -reach }
    }
}

/// Cells that are near each other, and what the last of them to be filled tells the next.
pub(super) struct Block {
    pub(super) cells: [Cell; BLOCK * BLOCK * BLOCK],
    /// The ball around the block's centre.
    pub(super) ball: Ball,
    /// A triangle that is near.
    pub(super) triangle: AtomicU32,
    /// The number of a cell whose side is known.
    pub(super) sided: AtomicU32,
    /// In an open solid, the winding number about the block's centre.
    pub(super) winding: OnceLock<BlockWinding>,
}

impl Block {
    pub(super) fn empty() -> Self {
        Self {
            cells: std::array::from_fn(|_| Cell::empty()),
            ball: Ball::empty(),
            triangle: AtomicU32::new(u32::MAX),
            sided: AtomicU32::new(u32::MAX),
            winding: OnceLock::new(),
        }
    }
}

/// The number of a cell in its block.
#[inline]
pub(super) fn number([x, y, z]: [usize; 3]) -> usize {
    let [i, j, k] = [x, y, z].map(|place| place & (BLOCK - 1));
    (k << BLOCK_BITS | j) << BLOCK_BITS | i
}
