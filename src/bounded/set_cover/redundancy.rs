//! Pieces that can be dropped from a cover.

use super::coverage::Coverage;
use crate::bounded::patch_set::PatchSet;
use crate::bounded::patches::patch::Patches;
use crate::bounded::piece::Piece;

/// The area of a set of patches.
pub(super) fn area(patches: &Patches, set: &PatchSet) -> f64 {
    set.iter().map(|patch| patches[patch].area).sum()
}

/// Drops pieces all of whose patches are covered by others, smallest first.
pub(super) fn drop_redundant(patches: &Patches, pieces: &mut Vec<Piece>) {
    let mut by_area: Vec<(f64, Piece)> =
        pieces.drain(..).map(|piece| (area(patches, &piece.patches), piece)).collect();
    by_area.sort_by(|a, b| a.0.total_cmp(&b.0));
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
