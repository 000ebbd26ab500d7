//! Sets of seeds, as bits.

/// A set of seeds.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct SeedSet {
    words: Vec<u64>,
}

impl SeedSet {
    /// The empty set of seeds `0..count`.
    pub(crate) fn none(count: usize) -> Self {
        Self { words: vec![0; count.div_ceil(64)] }
    }

    pub(crate) fn of(count: usize, seeds: impl IntoIterator<Item = u32>) -> Self {
        let mut set = Self::none(count);
        for seed in seeds {
            set.insert(seed);
        }
        set
    }

    #[inline]
    pub(crate) fn insert(&mut self, seed: u32) {
        if let Some(word) = self.words.get_mut(seed as usize / 64) {
            *word |= 1 << (seed % 64);
        }
    }

    #[inline]
    pub(crate) fn remove(&mut self, seed: u32) {
        if let Some(word) = self.words.get_mut(seed as usize / 64) {
            *word &= !(1 << (seed % 64));
        }
    }

    #[inline]
    pub(crate) fn contains(&self, seed: u32) -> bool {
        self.words.get(seed as usize / 64).is_some_and(|word| word >> (seed % 64) & 1 == 1)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    pub(crate) fn intersects(&self, other: &Self) -> bool {
        self.words.iter().zip(&other.words).any(|(a, b)| a & b != 0)
    }

    pub(crate) fn unite(&mut self, other: &Self) {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a |= b;
        }
    }

    pub(crate) fn subtract(&mut self, other: &Self) {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a &= !b;
        }
    }

    /// Number of its members.
    pub(crate) fn count(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Its members, ascending.
    pub(crate) fn iter(&self) -> impl Iterator<Item = u32> + '_ {
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
    fn a_set_holds_what_was_put_in() {
        let mut set = SeedSet::of(200, [3, 64, 199]);
        assert_eq!(set.iter().collect::<Vec<_>>(), [3, 64, 199]);
        assert!(set.contains(64) && !set.contains(65));
        set.remove(64);
        assert!(!set.contains(64) && !set.is_empty());
    }

    #[test]
    fn sets_unite_and_subtract() {
        let mut set = SeedSet::of(100, [1, 2, 70]);
        set.unite(&SeedSet::of(100, [5]));
        assert!(set.intersects(&SeedSet::of(100, [5, 6])));
        set.subtract(&SeedSet::of(100, [1, 5]));
        assert_eq!(set, SeedSet::of(100, [2, 70]));
        assert!(!set.intersects(&SeedSet::of(100, [1, 5])));
    }
}
