//! Dissolving: the patches that only one piece covers are handed to other pieces, which may let go
//! of what is covered elsewhere. A local search for a smaller cover.

use super::grow::grow;
use super::redundancy::{area, drop_redundant, exclusive};
use crate::bounded::containment::fit_tester::FitTester;
use crate::bounded::containment::solid::Solid;
use crate::bounded::patch_set::PatchSet;
use crate::bounded::patches::patch::Patches;
use crate::bounded::piece::Piece;
use crate::control::Control;
use crate::error::Error;
use crate::parallel;

/// Pieces that are attempted between two checks of the budget, and may be attempted in parallel.
const AT_ONCE: usize = 4;

/// Comparing with this many pieces takes about as long as testing a joint hull.
const PIECES_PER_ATTEMPT: usize = 16;

/// Dissolves pieces under a bound, those of least exclusive area first, until no piece can be
/// dissolved or `budget` joint hulls have been tested.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn dissolve(
    patches: &Patches,
    pieces: &mut Vec<Piece>,
    solid: &Solid,
    bound: f64,
    budget: usize,
    control: &Control,
) -> Result<(), Error> {
    let mut spent = 0;
    'again: loop {
        let alive = vec![true; pieces.len()];
        let mut order: Vec<(f64, usize)> =
            (0..pieces.len()).map(|k| (area(patches, &exclusive(pieces, &alive, k)), k)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for some in order.chunks(AT_ONCE) {
            control.check()?;
            if spent >= budget || control.is_past_deadline() {
                return Ok(());
            }
            let attempt = |&(_, k): &(f64, usize)| {
                let mut tester = FitTester::new(solid, bound);
                let dissolved = dissolve_one(patches, pieces, k, &mut tester, control);
                (dissolved, tester.attempts)
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

/// The pieces without piece `k`, if the others can take what only it covers.
fn dissolve_one(
    patches: &Patches,
    pieces: &[Piece],
    k: usize,
    tester: &mut FitTester<'_>,
    control: &Control,
) -> Result<Option<Vec<Piece>>, Error> {
    let alive = vec![true; pieces.len()];
    let mut left = exclusive(pieces, &alive, k);
    let Some(takers) = takers(patches, pieces, k, &left) else { return Ok(None) };
    let mut changed: Vec<(usize, Piece)> = Vec::new();
    let mut sets: Vec<PatchSet> = pieces.iter().map(|piece| piece.patches.clone()).collect();
    for j in takers {
        // What only j covers, given what the others have become.
        let mut core = sets[j].clone();
        for (i, set) in sets.iter().enumerate() {
            if i != j && i != k {
                core.difference_with(set);
            }
        }
        let mut piece = Piece::new(patches, &core);
        grow(patches, &mut piece, &left, tester, control)?;
        let mut taken = piece.patches.clone();
        taken.difference_with(&core);
        if taken.is_empty() {
            continue;
        }
        left.difference_with(&piece.patches);
        sets[j] = piece.patches.clone();
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
        grow(patches, &mut piece, &all, tester, control)?;
        pieces[j] = piece;
    }
    pieces.remove(k);
    Ok(Some(pieces))
}

/// The pieces that could take patches of `left`, which only piece `k` covers, by conflicts alone:
/// those that could take most first. `None` if there is a patch that none could take.
fn takers(patches: &Patches, pieces: &[Piece], k: usize, left: &PatchSet) -> Option<Vec<usize>> {
    let mut alive = vec![true; pieces.len()];
    alive[k] = false;
    // What each piece must keep.
    let cores: Vec<PatchSet> = (0..pieces.len())
        .map(|j| {
            if j == k {
                PatchSet::empty(patches.count())
            } else {
                let mut core = exclusive(pieces, &alive, j);
                core.difference_with(left);
                core
            }
        })
        .collect();
    let is_compatible =
        |patch: u32, core: &PatchSet| !patches.conflicts[patch as usize].intersects(core);
    let others = || (0..pieces.len()).filter(|&j| j != k);
    if left.iter().any(|patch| !others().any(|j| is_compatible(patch, &cores[j]))) {
        return None;
    }
    let mut order: Vec<(usize, usize)> = others()
        .map(|j| (left.iter().filter(|&patch| is_compatible(patch, &cores[j])).count(), j))
        .filter(|&(count, _)| count > 0)
        .collect();
    order.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    Some(order.into_iter().map(|(_, j)| j).collect())
}
