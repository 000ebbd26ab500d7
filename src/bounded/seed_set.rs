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

    pub(crate) fn len(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
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

    pub(crate) fn is_subset(&self, other: &Self) -> bool {
        self.words.iter().zip(&other.words).all(|(a, b)| a & !b == 0)
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
