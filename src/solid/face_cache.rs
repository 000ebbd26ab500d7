//! A cache of faces that fit under a bound. Hulls that grow again from almost the same patches share most of their
//! faces. Faces that do not fit are known by the nogoods that are learned from them.
//!
//! A direct-mapped table of fixed size, shared by all threads without locks. An entry repeats what
//! the fit test returned. So the result does not depend on which thread was first, nor on what
//! has been overwritten.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::geometry::vector::Vector;

/// Entries; a power of two. Half a megabyte is enough for the faces that recur in a mesh's search,
/// and fits a second-level cache.
const ENTRIES: usize = 1 << 16;

/// The lowest bit of every key, which an empty entry has not.
const OCCUPIED: u64 = 1;

/// See the module.
pub(super) struct FaceCache {
    entries: Vec<AtomicU64>,
}

/// A face under a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FaceKey(u64);

impl FaceCache {
    pub(super) fn new() -> Self {
        let mut entries = Vec::new();
        entries.resize_with(ENTRIES, || AtomicU64::new(0));
        Self { entries }
    }

    /// The key of a face under a bound, the same from whichever corner the face begins. Two faces
    /// share a key with a probability of 2⁻⁶³.
    pub(super) fn key(face: [Vector; 3], bound: f64) -> FaceKey {
        let hashes = face.map(|corner| {
            corner.to_array().into_iter().fold(HASH_START, |hash, x| mixed(hash ^ x.to_bits()))
        });
        let sum = hashes.into_iter().fold(0_u64, u64::wrapping_add);
        FaceKey(mixed(sum ^ bound.to_bits()) | OCCUPIED)
    }

    /// Whether the face is known to fit.
    pub(super) fn is_known_to_fit(&self, FaceKey(key): FaceKey) -> bool {
        self.entry(key).is_some_and(|entry| entry.load(Ordering::Relaxed) == key)
    }

    /// Remembers that a face fits.
    pub(super) fn insert(&self, FaceKey(key): FaceKey) {
        if let Some(entry) = self.entry(key) {
            entry.store(key, Ordering::Relaxed);
        }
    }

    fn entry(&self, key: u64) -> Option<&AtomicU64> {
        self.entries.get((key >> 40) as usize & (ENTRIES - 1))
    }
}

/// The golden ratio in 64 bits: any odd number with evenly spread bits would do.
const HASH_START: u64 = 0x9e37_79b9_7f4a_7c15;

/// Spreads differences over all bits (the finalizer of MurmurHash3).
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
    fn a_face_is_cached_from_each_of_its_corners_and_under_one_bound() {
        let cache = FaceCache::new();
        let key = |face| FaceCache::key(face, 0.02);
        let [a, b, c] = [[0.0, 1.0, 2.0], [0.5, -1.0, 2.0], [3.0, 0.25, 0.125]].map(Vector::from);
        assert!(!cache.is_known_to_fit(key([a, b, c])));
        cache.insert(key([a, b, c]));
        assert!(cache.is_known_to_fit(key([b, c, a])));
        assert!(!cache.is_known_to_fit(key([b, c, Vector::new(3.0, 0.25, 0.126)])));
        assert!(!cache.is_known_to_fit(FaceCache::key([a, b, c], 0.01)));
    }
}
