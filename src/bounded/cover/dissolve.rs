//! Dissolving: a piece disappears once others cover the patches that it alone covers. These may leave out what is
//! covered elsewhere. A local search for a smaller cover: O(p²) attempts for p pieces, within a budget of joint hulls.

use std::collections::HashMap;
use std::sync::Mutex;

use super::coverage::{Coverage, area, drop_redundant};
use super::grow::grow;
use crate::bounded::patch::{PatchSet, Patches, Piece};
use crate::bounded::search::Search;
use crate::control::Control;
use crate::error::Error;
use crate::parallel;
use crate::solid::FitTester;

/// Pieces that are attempted between two checks of the budget, and may be attempted in parallel: as many as there are
/// processors in a desktop machine, and few enough for the deadline. Only where the budget ends the search does the
/// result depend on it: with 4 or 64 no shared mesh has other hulls.
const AT_ONCE: usize = 16;

/// Comparing with this many pieces takes about as long as testing a joint hull.
const PIECES_PER_ATTEMPT: usize = 16;

/// Attempts in vain: the patches that a piece must keep, those of which it can take none, and how many joint
/// hulls were tested. Most pieces are attempted again and again, in covers that have changed elsewhere.
type Refusals = Mutex<HashMap<(PatchSet, PatchSet), usize>>;

/// Pieces of the patches that a piece must keep: while one piece after the other is to be dissolved, most of the
/// others must keep the same.
type Cores = Mutex<HashMap<PatchSet, Piece>>;

/// Cores that are remembered: a limit on memory, of which each takes some ten kilobytes.
const MAX_CORES: usize = 1024;

/// Dissolves pieces under a bound, those of least exclusive area first, until no piece can be
/// dissolved or `budget` joint hulls have been tested.
pub(super) fn dissolve(
    search: &Search<'_>,
    pieces: &mut Vec<Piece>,
    bound: f64,
    budget: usize,
) -> Result<(), Error> {
    let &Search { solid, patches, control, .. } = search;
    let (refusals, cores) = (Refusals::default(), Cores::default());
    let mut spent = 0;
    'again: loop {
        let coverage = Coverage::new(patches.count(), pieces);
        let exclusive_area = |piece: &Piece| area(patches, &coverage.exclusive(&piece.patches));
        let mut order: Vec<(f64, usize)> = pieces.iter().map(exclusive_area).zip(0..).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for some in order.chunks(AT_ONCE) {
            control.check()?;
            if spent >= budget || control.is_past_deadline() {
                return Ok(());
            }
            let attempt = |&(_, k): &(f64, usize)| {
                let tester = FitTester::new(solid, bound);
                let (refusals, cores) = (&refusals, &cores);
                let mut attempt = Attempt { patches, tester, refusals, cores, known: 0, control };
                let dissolved = attempt.dissolve(pieces, coverage.clone(), k);
                (dissolved, attempt.tester.attempts + attempt.known)
            };
            let succeeds = |(dissolved, _): &(Result<Option<Vec<Piece>>, Error>, usize)| {
                !matches!(dissolved, Ok(None))
            };
            for (dissolved, attempts) in parallel::map_until(some, attempt, succeeds) {
                spent += attempts + pieces.len() / PIECES_PER_ATTEMPT;
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
    tester: FitTester<'a>,
    refusals: &'a Refusals,
    cores: &'a Cores,
    /// Joint hulls that were tested by earlier attempts, and would have been again.
    known: usize,
    control: &'a Control,
}

impl Attempt<'_> {
    /// The pieces without piece `k`, if the others can take what only it covers.
    fn dissolve(
        &mut self,
        pieces: &[Piece],
        mut coverage: Coverage,
        k: usize,
    ) -> Result<Option<Vec<Piece>>, Error> {
        let patches = self.patches;
        let mut left = coverage.exclusive(&pieces[k].patches);
        coverage.remove(&pieces[k].patches);
        let Some(takers) = takers(patches, pieces, k, &left, &coverage) else { return Ok(None) };
        let mut changed: Vec<(usize, Piece)> = Vec::new();
        for j in takers {
            // What only j covers, given what the others have become.
            let core = coverage.exclusive(&pieces[j].patches);
            let Some(piece) = self.grown(&core, &left)? else { continue };
            left.difference_with(&piece.patches);
            coverage.remove(&pieces[j].patches);
            coverage.add(&piece.patches);
            changed.push((j, piece));
            if left.is_empty() {
                break;
            }
        }
        if !left.is_empty() {
            return Ok(None);
        }
        let mut pieces = pieces.to_vec();
        let all = patches.all();
        for (j, mut piece) in changed {
            grow(patches, &mut piece, &all, &mut self.tester, self.control)?;
            pieces[j] = piece;
        }
        pieces.remove(k);
        Ok(Some(pieces))
    }

    /// The piece of some patches once it has taken what it can of others; `None` if that is nothing.
    fn grown(&mut self, core: &PatchSet, left: &PatchSet) -> Result<Option<Piece>, Error> {
        let key = (core.clone(), left.clone());
        if let Some(attempts) = parallel::lock(self.refusals).get(&key) {
            self.known += attempts;
            return Ok(None);
        }
        let before = self.tester.attempts;
        let mut piece = self.core(core);
        grow(self.patches, &mut piece, left, &mut self.tester, self.control)?;
        if piece.patches != *core {
            return Ok(Some(piece));
        }
        parallel::lock(self.refusals).insert(key, self.tester.attempts - before);
        Ok(None)
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
}

/// The pieces that could take patches of `left`, which only piece `k` covers, by conflicts alone:
/// those that could take most first. `None` if there is a patch that none could take. `coverage` is that without
/// piece `k`.
fn takers(
    patches: &Patches,
    pieces: &[Piece],
    k: usize,
    left: &PatchSet,
    coverage: &Coverage,
) -> Option<Vec<usize>> {
    // What each piece must keep.
    let mut others: Vec<(usize, usize, PatchSet)> = pieces
        .iter()
        .enumerate()
        .filter(|&(j, _)| j != k)
        .map(|(j, piece)| (0, j, coverage.exclusive(&piece.patches)))
        .collect();
    for patch in left.iter() {
        let conflicts = &patches.conflicts[patch as usize];
        let mut is_taken = false;
        for (count, _, core) in &mut others {
            if !conflicts.intersects(core) {
                *count += 1;
                is_taken = true;
            }
        }
        if !is_taken {
            return None;
        }
    }
    others.retain(|&(count, ..)| count > 0);
    others.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    Some(others.into_iter().map(|(_, j, _)| j).collect())
}
