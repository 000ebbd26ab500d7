//! How many pieces cover each patch: which pieces can be dropped, and which piece owns a patch that
//! several cover.
//!
//! Counts are kept up to date as pieces change, so that what a piece alone covers takes one
//! comparison of sets.

use crate::bounded::patch::{PatchSet, Patches, Piece};
use crate::control::Control;
use crate::error::Error;
use crate::hull::growing_hull::{GrowingHull, SEARCH_TOLERANCE};
use crate::sorting::{sort_by, sort_by_number};

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

/// The area of a set of patches.
pub(super) fn area(patches: &Patches, set: &PatchSet) -> f64 {
    set.iter().map(|patch| patches[patch].area).sum()
}

/// Drops pieces that others cover entirely, smallest first.
pub(super) fn drop_redundant(patches: &Patches, pieces: &mut Vec<Piece>) {
    let mut by_area: Vec<(f64, Piece)> =
        pieces.drain(..).map(|piece| (area(patches, &piece.patches), piece)).collect();
    sort_by(&mut by_area, |a, b| a.0.total_cmp(&b.0));
    pieces.extend(by_area.into_iter().map(|(_, piece)| piece));
    let mut coverage = Coverage::new(patches.count(), pieces);
    pieces.retain(|piece| {
        let is_redundant = coverage.exclusive(&piece.patches).is_empty();
        if is_redundant {
            coverage.remove(&piece.patches);
        }
        !is_redundant
    });
}

/// Assigns shared patches, largest first, to the piece that grows least, and shrinks pieces to the
/// hulls of what they own. O(patches · pieces) hulls at worst.
pub(crate) fn assign_owners(
    patches: &Patches,
    pieces: &[Piece],
    control: &Control,
) -> Result<Vec<Piece>, Error> {
    let coverage = Coverage::new(patches.count(), pieces);
    let mut owned: Vec<Piece> = pieces
        .iter()
        .map(|piece| Piece::new(patches, &coverage.exclusive(&piece.patches)))
        .collect();
    let mut shared = patches.all();
    for piece in &owned {
        shared.difference_with(&piece.patches);
    }
    let least = |patch: u32| (-patches[patch].area, patch as usize);
    let mut order: Vec<(f64, usize)> = shared.iter().map(least).collect();
    sort_by_number(&mut order);
    let (mut trial, mut grown) = (GrowingHull::default(), GrowingHull::default());
    for index in order.into_iter().map(|(_, index)| index as u32) {
        control.check()?;
        let patch = &patches[index];
        let mut best: Option<(f64, usize)> = None;
        for (k, piece) in pieces.iter().enumerate() {
            if !piece.patches.contains(index) {
                continue;
            }
            trial.copy_from(&owned[k].hull);
            let is_contained = trial.contains(&patch.points, SEARCH_TOLERANCE);
            if !is_contained {
                trial.insert(&patch.points, patch.outward);
                trial.volume = trial.current_volume();
            }
            let growth = trial.volume - owned[k].hull.volume;
            if best.is_none_or(|best| growth < best.0) {
                best = Some((growth, k));
                std::mem::swap(&mut trial, &mut grown);
            }
            // No other can grow less.
            if is_contained {
                break;
            }
        }
        if let Some((_, k)) = best {
            let owner = &mut owned[k];
            owner.patches.insert(index);
            std::mem::swap(&mut owner.hull, &mut grown);
        }
    }
    owned.retain(|piece| !piece.patches.is_empty());
    Ok(owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, times_in};

    #[test]
    fn what_a_set_alone_covers_is_what_is_in_no_other() {
        const PATCHES: usize = 70;
        let mut sets: Vec<PatchSet> = (2..7_u32)
            .map(|step| PatchSet::new(PATCHES, (0..70).filter(|patch| patch % step == 0)))
            .collect();
        let mut coverage = Coverage::new(PATCHES, &[]);
        sets.iter().for_each(|set| coverage.add(set));
        for change in [None, Some(PatchSet::new(PATCHES, 3..40)), Some(PatchSet::empty(PATCHES))] {
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

    #[test]
    fn of_pieces_that_cover_each_other_the_smallest_are_dropped_first() {
        let fixture = Fixture::new(&cubes([0.0, 2.0, 4.0, 6.0]), 0.02);
        let sets = [vec![0, 1, 2], vec![2, 3], vec![2], vec![3]];
        let mut pieces = sets.map(|set| fixture.piece(set)).to_vec();
        drop_redundant(&fixture.patches, &mut pieces);
        let left: Vec<Vec<u32>> =
            pieces.iter().map(|piece| piece.patches.iter().collect()).collect();
        assert_eq!(left, [vec![2, 3], vec![0, 1, 2]]);
    }

    #[test]
    fn a_shared_patch_stays_with_the_piece_that_grows_least_by_it() {
        let fixture = Fixture::new(&cubes([0.0, 2.0, 3.5, 6.0]), 0.02);
        let pieces = [vec![0, 1], vec![1, 2, 3]].map(|set| fixture.piece(set));
        let owned = assign_owners(&fixture.patches, &pieces, &Control::new()).unwrap();
        let sets: Vec<Vec<u32>> =
            owned.iter().map(|piece| piece.patches.iter().collect()).collect();
        // The first would grow by two cubes, the second by one and a half.
        assert_eq!(sets, [vec![0], vec![1, 2, 3]]);
        assert!((owned[0].hull.volume - fixture.piece([0]).hull.volume).abs() < 1e-9);
    }

    #[test]
    fn a_shared_patch_within_the_hull_of_a_piece_stays_there() {
        let fixture = Fixture::new(&cubes([0.0, 2.0, 4.0, 5.1]), 0.02);
        let pieces = [vec![1, 3], vec![0, 1, 2]].map(|set| fixture.piece(set));
        let owned = assign_owners(&fixture.patches, &pieces, &Control::new()).unwrap();
        assert_eq!(owned[0].patches, fixture.set([3]));
        assert_eq!(owned[1].patches, fixture.set([0, 1, 2]));
    }

    #[test]
    fn a_piece_without_a_patch_of_its_own_that_gets_none_is_gone() {
        let fixture = Fixture::new(&cubes([0.0, 2.0]), 0.02);
        let pieces = [vec![0, 1], vec![1]].map(|set| fixture.piece(set));
        let owned = assign_owners(&fixture.patches, &pieces, &Control::new()).unwrap();
        let times = times_in(2, owned.iter().map(|piece| &piece.patches));
        assert_eq!(times, [1, 1]);
        assert!(owned.iter().all(|piece| !piece.patches.is_empty()));
    }
}
