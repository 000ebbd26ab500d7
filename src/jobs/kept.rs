//! What the caches outside of memory have in common, on disk and in a browser's database: which
//! results count, and how far they shrink.

use hullwright::hulls_format::HullsFile;

/// A cache is looked at once this share of its budget has been written, so that a thousand results
/// are not looked at for each that is written. It is larger than its budget by as much.
const UNSEEN_SHARE: u64 = 16;

/// After a removal there is room for this share of the budget, so that the next result does not
/// remove again.
const FREED_SHARE: u64 = 8;

/// Bytes that may be written before a cache with this budget is looked at again.
pub(super) fn unseen(budget: u64) -> i64 {
    (budget / UNSEEN_SHARE) as i64
}

/// Bytes that a removal leaves.
pub(super) fn kept(budget: u64) -> u64 {
    budget - budget / FREED_SHARE
}

/// Whether a stored result may be used. One of another version, or without mass properties, counts
/// as missing.
pub(super) fn is_usable(file: &HullsFile) -> bool {
    file.is_current() && file.mass_properties.is_some()
}
