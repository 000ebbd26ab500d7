//! Dissolving: a piece disappears once others cover the patches that it alone covers. These may
//! leave out what is covered elsewhere. A local search for a smaller cover: O(p²) attempts for p
//! pieces, within a budget of joint hulls.

use std::collections::HashMap;
use std::sync::Mutex;

use super::coverage::{Coverage, area, drop_redundant};
use super::grow::Grower;
use super::nogoods::{Learning, Nogoods};
use crate::bounded::patch::{PatchSet, Patches, Piece};
use crate::bounded::search::Search;
use crate::error::Error;
use crate::parallel;
use crate::solid::FitTester;
use crate::sorting::{sort_by, sort_by_number};

/// Pieces that are attempted between two checks of the budget, and may be attempted in parallel: as
/// many as there are processors in a desktop machine, and few enough for the deadline. They do not
/// share their nogoods.
const AT_ONCE: usize = 16;

/// Comparing with this many pieces takes about as long as testing a joint hull.
const PIECES_PER_ATTEMPT: usize = 16;

/// Pieces of the patches that a piece must keep: while one piece after the other is to be
/// dissolved, most of the others must keep the same.
type Cores = Mutex<HashMap<PatchSet, Piece>>;

/// Cores that are remembered. Each takes about ten kilobytes, so that this limits memory to ten
/// megabytes.
const MAX_CORES: usize = 1024;

/// Dissolves pieces under a bound, those of least exclusive area first, until no piece can be
/// dissolved or `budget` joint hulls have been tested.
pub(super) fn dissolve(
    search: &Search<'_>,
    pieces: &mut Vec<Piece>,
    bound: f64,
    budget: usize,
    nogoods: &mut Nogoods<'_>,
) -> Result<(), Error> {
    let &Search { solid, patches, control, .. } = search;
    let cores = Cores::default();
    let mut spent = 0;
    'again: loop {
        let coverage = Coverage::new(patches.count(), pieces);
        let exclusive_area = |piece: &Piece| area(patches, &coverage.exclusive(&piece.patches));
        let mut order: Vec<(f64, usize)> = pieces.iter().map(exclusive_area).zip(0..).collect();
        sort_by_number(&mut order);
        for some in order.chunks(AT_ONCE) {
            control.check()?;
            if spent >= budget || control.is_past_deadline() {
                return Ok(());
            }
            let known = &*nogoods;
            let attempt = |&(_, k): &(f64, usize)| {
                let tester = FitTester::new(solid, bound);
                let grower = Grower { patches, tester, learning: Learning::after(known), control };
                let mut attempt = Attempt { patches, grower, cores: &cores };
                let dissolved = attempt.dissolve(pieces, coverage.clone(), k);
                let Grower { tester, learning, .. } = attempt.grower;
                (dissolved, tester.attempts, learning.into_refusals())
            };
            let succeeds = |(dissolved, ..): &(Result<Option<Vec<Piece>>, Error>, _, _)| {
                !matches!(dissolved, Ok(None))
            };
            for (dissolved, attempts, refusals) in parallel::map_until(some, attempt, succeeds) {
                spent += attempts + pieces.len() / PIECES_PER_ATTEMPT;
                refusals.iter().for_each(|refusal| nogoods.learn(refusal));
                if let Some(fewer) = dissolved? {
                    *pieces = fewer;
                    drop_redundant(patches, pieces);
                    continue 'again;
                }
            }
        }
        return Ok(());
    }
}

/// An attempt to dissolve a piece.
struct Attempt<'a> {
    patches: &'a Patches,
    grower: Grower<'a>,
    cores: &'a Cores,
}

impl Attempt<'_> {
    /// The pieces without piece `k`, if the others can take what only it covers.
    fn dissolve(
        &mut self,
        pieces: &[Piece],
        mut coverage: Coverage,
        k: usize,
    ) -> Result<Option<Vec<Piece>>, Error> {
        let mut left = coverage.exclusive(&pieces[k].patches);
        coverage.remove(&pieces[k].patches);
        let mut takers: Vec<usize> = (0..pieces.len()).filter(|&j| j != k).collect();
        match self.possible_takes(pieces, &takers, &left, &coverage) {
            None => return Ok(None),
            Some(counts) => {
                let mut order: Vec<(usize, usize)> = counts.into_iter().zip(takers).collect();
                order.retain(|&(count, _)| count > 0);
                sort_by(&mut order, |a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
                takers = order.into_iter().map(|(_, j)| j).collect();
            }
        }
        let mut changed: Vec<(usize, Piece)> = Vec::new();
        // Where the first taker of each patch is; at first nothing is known.
        let mut possible = vec![0; self.patches.count()];
        for (place, &j) in takers.iter().enumerate() {
            // What only j covers, given what the others have become.
            let core = coverage.exclusive(&pieces[j].patches);
            if !left.iter().any(|patch| self.grower.may_take(&core, patch)) {
                continue;
            }
            let mut piece = self.core(&core);
            self.grower.grow(&mut piece, &left)?;
            if piece.patches != core {
                left.difference_with(&piece.patches);
                coverage.remove(&pieces[j].patches);
                coverage.add(&piece.patches);
                changed.push((j, piece));
            }
            if left.is_empty() {
                break;
            }
            let may_take = |taker: usize, patch: u32| {
                self.grower.may_take(&coverage.exclusive(&pieces[taker].patches), patch)
            };
            if !all_have_takers(&left, &takers, place + 1, &mut possible, may_take) {
                return Ok(None);
            }
        }
        if !left.is_empty() {
            return Ok(None);
        }
        let mut pieces = pieces.to_vec();
        let all = self.patches.all();
        for (j, mut piece) in changed {
            self.grower.grow(&mut piece, &all)?;
            pieces[j] = piece;
        }
        pieces.remove(k);
        Ok(Some(pieces))
    }

    /// The piece of some patches, built or remembered.
    fn core(&self, core: &PatchSet) -> Piece {
        if let Some(piece) = parallel::lock(self.cores).get(core) {
            return piece.clone();
        }
        let piece = Piece::new(self.patches, core);
        let mut cores = parallel::lock(self.cores);
        if cores.len() >= MAX_CORES {
            cores.clear();
        }
        cores.insert(core.clone(), piece.clone());
        piece
    }

    /// For each of the pieces `takers` how many patches of `left` it could take, by conflicts and
    /// nogoods alone, with what only it covers. `None` if there is a patch that none could take.
    fn possible_takes(
        &self,
        pieces: &[Piece],
        takers: &[usize],
        left: &PatchSet,
        coverage: &Coverage,
    ) -> Option<Vec<usize>> {
        // What each piece must keep.
        let core = |&j: &usize| coverage.exclusive(&pieces[j].patches);
        let cores: Vec<PatchSet> = takers.iter().map(core).collect();
        let mut counts = vec![0; takers.len()];
        for patch in left.iter() {
            let mut is_taken = false;
            for (count, core) in counts.iter_mut().zip(&cores) {
                if self.grower.may_take(core, patch) {
                    *count += 1;
                    is_taken = true;
                }
            }
            if !is_taken {
                return None;
            }
        }
        Some(counts)
    }
}

/// Whether each patch of `left` has one of the takers from `first` on that may take it. `known` is
/// where the last call found it: most patches need no other look.
fn all_have_takers(
    left: &PatchSet,
    takers: &[usize],
    first: usize,
    known: &mut [usize],
    may_take: impl Fn(usize, u32) -> bool,
) -> bool {
    left.iter().all(|patch| {
        let is_taker = |&place: &usize| takers.get(place).is_some_and(|&j| may_take(j, patch));
        let known = &mut known[patch as usize];
        if *known < first || !is_taker(known) {
            *known = (first..takers.len()).find(is_taker).unwrap_or(takers.len());
        }
        *known < takers.len()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounded::cover::nogoods::PointsOfPatches;
    use crate::bounded::fixture::{Fixture, cubes, l_prism, times_in};
    use crate::bounded::merge::merge;

    /// The pieces that are left of some.
    fn dissolved(fixture: &Fixture, pieces: &[Piece], budget: usize) -> Vec<Piece> {
        let points = PointsOfPatches::new(&fixture.patches);
        let mut nogoods = Nogoods::new(&points, fixture.patches.count());
        let (mut pieces, bound) = (pieces.to_vec(), fixture.settings.bound.search());
        dissolve(&fixture.search(), &mut pieces, bound, budget, &mut nogoods).unwrap();
        pieces
    }

    /// The two parts of a prism, a patch of the larger of which is a piece of its own.
    fn with_a_part_of_its_own(fixture: &Fixture) -> Vec<Piece> {
        let mut pieces = merge(&fixture.search()).unwrap();
        pieces.sort_by_key(|piece| piece.patches.count());
        let mut rest = pieces.pop().unwrap().patches;
        let single = rest.iter().next().unwrap();
        rest.remove(single);
        pieces.extend([fixture.piece(rest.iter()), fixture.piece([single])]);
        pieces
    }

    #[test]
    fn a_piece_that_another_can_take_over_disappears() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        let pieces = with_a_part_of_its_own(&fixture);
        assert_eq!(pieces.len(), 3);
        let left = dissolved(&fixture, &pieces, usize::MAX);
        assert_eq!(left.len(), 2);
        let times = times_in(fixture.patches.count(), left.iter().map(|piece| &piece.patches));
        assert!(times.iter().all(|&times| times > 0), "{times:?}");
    }

    #[test]
    fn without_a_budget_all_pieces_stay() {
        let fixture = Fixture::new(&l_prism(), 0.02);
        let pieces = with_a_part_of_its_own(&fixture);
        assert_eq!(dissolved(&fixture, &pieces, 0).len(), 3);
    }

    #[test]
    fn pieces_that_nothing_else_can_cover_stay() {
        let fixture = Fixture::new(&cubes([0.0, 2.0, 4.0]), 0.02);
        let pieces = [0, 1, 2].map(|patch| fixture.piece([patch]));
        assert_eq!(dissolved(&fixture, &pieces, usize::MAX).len(), 3);
    }

    #[test]
    fn a_piece_may_leave_what_is_covered_elsewhere_to_take_what_is_not() {
        // Over the crack in the middle two pieces overlap. The middle ones are covered twice.
        let fixture = Fixture::new(&cubes([0.0, 1.02, 2.04, 3.06]), 0.02);
        let pieces = [vec![0, 1], vec![1, 2], vec![2, 3]].map(|patches| fixture.piece(patches));
        let left = dissolved(&fixture, &pieces, usize::MAX);
        assert_eq!(left.len(), 1);
        assert_eq!(left[0].patches, fixture.patches.all());
    }

    #[test]
    fn what_could_be_taken_is_counted_by_conflicts_and_is_nothing_where_one_patch_has_no_taker() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 3.0]), 0.02);
        let points = PointsOfPatches::new(&fixture.patches);
        let nogoods = Nogoods::new(&points, 3);
        let attempt = Attempt {
            patches: &fixture.patches,
            grower: Grower {
                patches: &fixture.patches,
                tester: FitTester::new(&fixture.solids.coarse, 0.02),
                learning: Learning::after(&nogoods),
                control: &fixture.control,
            },
            cores: &Cores::default(),
        };
        let pieces = [0, 1, 2].map(|patch| fixture.piece([patch]));
        let counts = |k: usize, takers: &[usize]| {
            let mut coverage = Coverage::new(3, &pieces);
            coverage.remove(&pieces[k].patches);
            attempt.possible_takes(&pieces, takers, &pieces[k].patches, &coverage)
        };
        assert_eq!(counts(0, &[1, 2]), Some(vec![1, 0]));
        assert_eq!(counts(2, &[0, 1]), None);
    }
}
