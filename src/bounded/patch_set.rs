//! Sets of patches as bits: conflicts and covers are compared word by word.

use fixedbitset::FixedBitSet;

/// A set of patches, given by their indices.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub(crate) struct PatchSet(FixedBitSet);

impl PatchSet {
    /// The empty set, for patches `0..count`.
    pub(super) fn empty(count: usize) -> Self {
        Self(FixedBitSet::with_capacity(count))
    }

    /// A set of some of the patches `0..count`.
    pub(super) fn of(count: usize, patches: impl IntoIterator<Item = u32>) -> Self {
        let mut set = Self::empty(count);
        patches.into_iter().for_each(|patch| set.insert(patch));
        set
    }

    #[inline]
    pub(super) fn insert(&mut self, patch: u32) {
        self.0.insert(patch as usize);
    }

    #[inline]
    pub(super) fn remove(&mut self, patch: u32) {
        self.0.remove(patch as usize);
    }

    #[inline]
    pub(super) fn contains(&self, patch: u32) -> bool {
        self.0.contains(patch as usize)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_clear()
    }

    pub(super) fn intersects(&self, other: &Self) -> bool {
        !self.0.is_disjoint(&other.0)
    }

    pub(super) fn union_with(&mut self, other: &Self) {
        self.0.union_with(&other.0);
    }

    pub(super) fn intersect_with(&mut self, other: &Self) {
        self.0.intersect_with(&other.0);
    }

    pub(super) fn difference_with(&mut self, other: &Self) {
        self.0.difference_with(&other.0);
    }

    /// Number of members.
    pub(super) fn count(&self) -> usize {
        self.0.count_ones(..)
    }

    /// The members, ascending.
    pub(super) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        self.0.ones().map(|patch| patch as u32)
    }
}
