//! What each piece of a cover contributes, and which pieces can be dropped.

use crate::bounded::patch_set::PatchSet;
use crate::bounded::patches::patch::Patches;
use crate::bounded::piece::Piece;

/// The patches that only piece `k` of those that are `alive` covers.
pub(super) fn exclusive(pieces: &[Piece], alive: &[bool], k: usize) -> PatchSet {
    let mut exclusive = pieces[k].patches.clone();
    for (j, piece) in pieces.iter().enumerate() {
        if j != k && alive[j] {
            exclusive.difference_with(&piece.patches);
        }
    }
    exclusive
}

/// The area of a set of patches.
pub(super) fn area(patches: &Patches, set: &PatchSet) -> f64 {
    set.iter().map(|patch| patches[patch].area).sum()
}

/// Drops pieces all of whose patches are covered by others, smallest first.
pub(super) fn drop_redundant(patches: &Patches, pieces: &mut Vec<Piece>) {
    pieces.sort_by(|a, b| area(patches, &a.patches).total_cmp(&area(patches, &b.patches)));
    let mut alive = vec![true; pieces.len()];
    for k in 0..pieces.len() {
        if exclusive(pieces, &alive, k).is_empty() {
            alive[k] = false;
        }
    }
    let mut alive = alive.into_iter();
    pieces.retain(|_| alive.next().unwrap_or(true));
}
