//! Arrays of numbers one after the other, compressed, as text.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;

use crate::geometry::vector::{Vector, bounds};

/// Where an array begins in the bytes, and how many numbers it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Array {
    pub offset: usize,
    pub count: usize,
}

/// Points as 16-bit shares of their bounding box: off by less than a hundred-thousandth of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Points {
    pub min: Vector,
    pub size: Vector,
    pub shares: Array,
}

/// Typed arrays have to begin at a multiple of the size of their numbers.
const ALIGNMENT: usize = 4;

/// The arrays of a page.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    bytes: Vec<u8>,
}

impl Geometry {
    fn push<const N: usize>(&mut self, numbers: impl Iterator<Item = [u8; N]>) -> Array {
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
        let offset = self.bytes.len();
        numbers.for_each(|number| self.bytes.extend(number));
        Array { offset, count: (self.bytes.len() - offset) / N }
    }

    pub(super) fn push_u8(&mut self, numbers: impl IntoIterator<Item = u8>) -> Array {
        self.push(numbers.into_iter().map(|number| [number]))
    }

    pub(super) fn push_u16(&mut self, numbers: impl IntoIterator<Item = u16>) -> Array {
        self.push(numbers.into_iter().map(u16::to_le_bytes))
    }

    pub(super) fn push_u32(&mut self, numbers: impl IntoIterator<Item = u32>) -> Array {
        self.push(numbers.into_iter().map(u32::to_le_bytes))
    }

    pub(super) fn push_points(&mut self, points: &[Vector]) -> Points {
        let (mut min, max) = bounds(points.iter().copied());
        if points.is_empty() {
            min = [0.0; 3];
        }
        let size = [0, 1, 2].map(|axis| (max[axis] - min[axis]).max(f64::MIN_POSITIVE));
        let share = |point: &Vector| {
            [0, 1, 2].map(|axis| {
                (f64::from(u16::MAX) * (point[axis] - min[axis]) / size[axis]).round() as u16
            })
        };
        let shares = self.push_u16(points.iter().flat_map(share));
        Points { min, size, shares }
    }

    /// Deflated in zlib's format, in base64.
    pub(super) fn to_text(&self) -> std::io::Result<String> {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&self.bytes)?;
        Ok(STANDARD.encode(encoder.finish()?))
    }
}
