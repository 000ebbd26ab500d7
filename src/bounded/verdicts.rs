//! Remembers which faces fit under which bound. Hulls that are grown again and again from almost the same seeds
//! share most of their faces.
//!
//! A table of fixed size, shared by all threads without locks. What it says is what the fit test
//! said, so the result does not depend on who asked first, nor on what has been overwritten.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::geometry::vector::Vector;

/// Entries; a power of two. Half a megabyte holds the faces that a mesh's search comes back to.
const ENTRIES: usize = 1 << 16;

/// The lowest bit of an entry: whether the face fits. The others are its key.
const FITS: u64 = 1;

/// The table. See the module.
pub(super) struct Verdicts {
    entries: Vec<AtomicU64>,
}

/// A face in the table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Key(u64);

impl Verdicts {
    pub(super) fn new() -> Self {
        let mut entries = Vec::new();
        entries.resize_with(ENTRIES, || AtomicU64::new(0));
        Self { entries }
    }

    /// The key of a face under a bound, the same from whichever corner it begins. Two share one with a
    /// probability of 2⁻⁶³.
    pub(super) fn key(face: [Vector; 3], bound: f64) -> Key {
        let hashes =
            face.map(|corner| corner.into_iter().fold(SEED, |hash, x| mixed(hash ^ x.to_bits())));
        let sum = hashes.into_iter().fold(0_u64, u64::wrapping_add);
        Key(mixed(sum ^ bound.to_bits()) & !FITS)
    }

    /// Whether the face fits, if that is known.
    pub(super) fn get(&self, Key(key): Key) -> Option<bool> {
        let entry = self.entry(key)?.load(Ordering::Relaxed);
        (entry & !FITS == key && entry != 0).then_some(entry & FITS != 0)
    }

    pub(super) fn set(&self, Key(key): Key, fits: bool) {
        if let Some(entry) = self.entry(key) {
            entry.store(key | u64::from(fits), Ordering::Relaxed);
        }
    }

    fn entry(&self, key: u64) -> Option<&AtomicU64> {
        self.entries.get((key >> 40) as usize & (ENTRIES - 1))
    }
}

/// Any odd number with bits all over.
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// Spreads what differs over all bits (the end of MurmurHash3).
fn mixed(mut bits: u64) -> u64 {
    bits ^= bits >> 33;
    bits = bits.wrapping_mul(0xff51_afd7_ed55_8ccd);
    bits ^= bits >> 33;
    bits = bits.wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    bits ^ bits >> 33
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_is_known_from_each_of_its_corners_and_others_and_other_bounds_are_not() {
        let verdicts = Verdicts::new();
        let key = |face| Verdicts::key(face, 0.02);
        let [a, b, c] = [[0.0, 1.0, 2.0], [0.5, -1.0, 2.0], [3.0, 0.25, 0.125]];
        assert_eq!(verdicts.get(key([a, b, c])), None);
        verdicts.set(key([a, b, c]), true);
        assert_eq!(verdicts.get(key([b, c, a])), Some(true));
        assert_eq!(verdicts.get(key([b, c, [3.0, 0.25, 0.126]])), None);
        assert_eq!(verdicts.get(Verdicts::key([a, b, c], 0.01)), None);
        verdicts.set(key([b, c, a]), false);
        assert_eq!(verdicts.get(key([a, b, c])), Some(false));
    }
}
