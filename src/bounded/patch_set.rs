//! Sets of patches, as bits: conflicts and covers are tested word by word.

/// A set of patches.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct PatchSet {
    words: Vec<u64>,
}

impl PatchSet {
    /// The empty set, for patches `0..count`.
    pub(super) fn empty(count: usize) -> Self {
        Self { words: vec![0; count.div_ceil(64)] }
    }

    pub(super) fn of(count: usize, patches: impl IntoIterator<Item = u32>) -> Self {
        let mut set = Self::empty(count);
        for patch in patches {
            set.insert(patch);
        }
        set
    }

    #[inline]
    pub(super) fn insert(&mut self, patch: u32) {
        if let Some(word) = self.words.get_mut(patch as usize / 64) {
            *word |= 1 << (patch % 64);
        }
    }

    #[inline]
    pub(super) fn remove(&mut self, patch: u32) {
        if let Some(word) = self.words.get_mut(patch as usize / 64) {
            *word &= !(1 << (patch % 64));
        }
    }

    #[inline]
    pub(super) fn contains(&self, patch: u32) -> bool {
        self.words.get(patch as usize / 64).is_some_and(|word| word >> (patch % 64) & 1 == 1)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    pub(super) fn intersects(&self, other: &Self) -> bool {
        self.words.iter().zip(&other.words).any(|(a, b)| a & b != 0)
    }

    pub(super) fn union_with(&mut self, other: &Self) {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a |= b;
        }
    }

    pub(super) fn difference_with(&mut self, other: &Self) {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a &= !b;
        }
    }

    /// Number of members.
    pub(super) fn count(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// The members, ascending.
    pub(super) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        (0_u32..).zip(&self.words).flat_map(|(index, &word)| {
            let mut rest = word;
            std::iter::from_fn(move || {
                if rest == 0 {
                    return None;
                }
                let bit = rest.trailing_zeros();
                rest &= rest - 1;
                Some(64 * index + bit)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_contains_what_was_inserted() {
        let mut set = PatchSet::of(200, [3, 64, 199]);
        assert_eq!(set.iter().collect::<Vec<_>>(), [3, 64, 199]);
        assert!(set.contains(64) && !set.contains(65));
        set.remove(64);
        assert!(!set.contains(64) && !set.is_empty());
    }

    #[test]
    fn unions_and_differences() {
        let mut set = PatchSet::of(100, [1, 2, 70]);
        set.union_with(&PatchSet::of(100, [5]));
        assert!(set.intersects(&PatchSet::of(100, [5, 6])));
        set.difference_with(&PatchSet::of(100, [1, 5]));
        assert_eq!(set, PatchSet::of(100, [2, 70]));
        assert!(!set.intersects(&PatchSet::of(100, [1, 5])));
    }
}
