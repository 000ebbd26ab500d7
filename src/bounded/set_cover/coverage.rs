//! How many pieces cover each patch, kept up to date as they change: what a piece alone covers is told by one
//! comparison of sets.

use crate::bounded::patch_set::PatchSet;
use crate::bounded::piece::Piece;

#[derive(Clone)]
pub(super) struct Coverage {
    counts: Vec<u32>,
    /// The patches that one piece covers.
    once: PatchSet,
}

impl Coverage {
    pub(super) fn new(patch_count: usize, pieces: &[Piece]) -> Self {
        let mut coverage =
            Self { counts: vec![0; patch_count], once: PatchSet::empty(patch_count) };
        pieces.iter().for_each(|piece| coverage.add(&piece.patches));
        coverage
    }

    pub(super) fn add(&mut self, set: &PatchSet) {
        self.change(set, |count| count + 1);
    }

    /// Takes away a set that was added.
    pub(super) fn remove(&mut self, set: &PatchSet) {
        self.change(set, |count| count.saturating_sub(1));
    }

    fn change(&mut self, set: &PatchSet, changed: impl Fn(u32) -> u32) {
        for patch in set.iter() {
            let count = &mut self.counts[patch as usize];
            *count = changed(*count);
            match *count {
                1 => self.once.insert(patch),
                _ => self.once.remove(patch),
            }
        }
    }

    /// The patches of one of the sets that no other covers.
    pub(super) fn exclusive(&self, set: &PatchSet) -> PatchSet {
        let mut exclusive = set.clone();
        exclusive.intersect_with(&self.once);
        exclusive
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_set_alone_covers_is_what_is_in_no_other() {
        const PATCHES: usize = 70;
        let mut sets: Vec<PatchSet> = (2..7_u32)
            .map(|step| PatchSet::of(PATCHES, (0..70).filter(|patch| patch % step == 0)))
            .collect();
        let mut coverage = Coverage::new(PATCHES, &[]);
        sets.iter().for_each(|set| coverage.add(set));
        for change in [None, Some(PatchSet::of(PATCHES, 3..40)), Some(PatchSet::empty(PATCHES))] {
            if let Some(set) = change {
                coverage.remove(&sets[1]);
                coverage.add(&set);
                sets[1] = set;
            }
            for (k, set) in sets.iter().enumerate() {
                let mut expected = set.clone();
                for (_, other) in sets.iter().enumerate().filter(|&(j, _)| j != k) {
                    expected.difference_with(other);
                }
                assert_eq!(coverage.exclusive(set), expected, "{k}");
            }
        }
    }
}
