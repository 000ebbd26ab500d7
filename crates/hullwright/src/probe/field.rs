//! Samples of a distance, computed on demand: what is known at a sample bounds the distance nearby.
//!
//! A sample is filled when it is first needed, with a value that depends on its place alone. So
//! threads may fill it at the same time.

use std::sync::atomic::{AtomicU32, Ordering};

use crate::geometry::blocks::{Blocks, size_for};
use crate::geometry::vector::Vector;

/// Samples at most. Where they are not enough they are farther apart, and decide less.
const MAX_SAMPLES: f64 = 8_000_000.0;

/// Samples beyond the box on each side: hulls may be a little outside.
const MARGIN: f64 = 2.0;

/// Samples of a block along each axis.
const BLOCK: usize = 8;
const SAMPLES: usize = Blocks::<(), BLOCK>::CELLS;

/// The bits of a value that is not computed yet.
const UNKNOWN: u32 = u32::MAX;

type Block = [AtomicU32; SAMPLES];

/// Samples over a box.
pub(super) struct Field {
    origin: Vector,
    /// Distance between samples along an axis.
    pub spacing: f64,
    blocks: Blocks<Block, BLOCK>,
}

/// The sample nearest to a point.
pub(super) struct Sample<'a> {
    pub point: Vector,
    block: &'a Block,
    place: [usize; 3],
}

impl Field {
    /// Samples over a box and a bit around it, so far apart along each axis, or farther.
    pub fn new((min, max): (Vector, Vector), spacing: f64) -> Self {
        let margin = Vector::splat(MARGIN * spacing);
        let extent = max - min + margin * 2.0;
        let count = |spacing: f64| (extent / spacing + 1.0).ceil();
        let spacing = size_for(spacing, MAX_SAMPLES, count);
        let dimensions = count(spacing).to_array().map(|count| count as usize);
        Self { origin: min - margin, spacing, blocks: Blocks::new(dimensions) }
    }

    /// The sample nearest to a point; `None` outside the box.
    pub fn sample(&self, point: Vector) -> Option<Sample<'_>> {
        let place = ((point - self.origin) / self.spacing).round();
        if place.cmplt(Vector::ZERO).any() {
            return None;
        }
        let place = place.to_array().map(|x| x as usize);
        self.at(place)
    }

    fn at(&self, place: [usize; 3]) -> Option<Sample<'_>> {
        if !self.blocks.contains(place) {
            return None;
        }
        let block = self.blocks.block(place, || [const { AtomicU32::new(UNKNOWN) }; SAMPLES]);
        let point = self.origin + Vector::from_array(place.map(|x| x as f64)) * self.spacing;
        Some(Sample { point, block, place })
    }
}

impl Sample<'_> {
    fn bits(&self) -> Option<&AtomicU32> {
        self.block.get(Blocks::<Block, BLOCK>::index_in_block(self.place))
    }

    fn known(&self) -> Option<f64> {
        let bits = self.bits()?.load(Ordering::Relaxed);
        (bits != UNKNOWN).then(|| f64::from(f32::from_bits(bits)))
    }

    /// The value, rounded to single precision. It is computed once.
    pub fn value(&self, compute: impl FnOnce() -> f64) -> f64 {
        if let Some(known) = self.known() {
            return known;
        }
        let value = compute() as f32;
        if let Some(bits) = self.bits() {
            bits.store(value.to_bits(), Ordering::Relaxed);
        }
        f64::from(value)
    }
}
