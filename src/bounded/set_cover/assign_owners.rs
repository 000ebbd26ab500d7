//! Ownership: each patch is assigned to one of the pieces that cover it, and pieces shrink to the
//! hulls of what they own.

use super::coverage::Coverage;
use crate::bounded::growing_hull::{GrowingHull, SEARCH_TOLERANCE};
use crate::bounded::patches::patch::Patches;
use crate::bounded::piece::Piece;
use crate::control::Control;
use crate::error::Error;

/// Assigns shared patches, largest first, to the piece that grows least. O(patches · pieces) hulls
/// at worst.
///
/// # Errors
/// [`Error::Cancelled`].
pub(in crate::bounded) fn assign_owners(
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
    let mut order: Vec<u32> = shared.iter().collect();
    order.sort_by(|&a, &b| patches[b].area.total_cmp(&patches[a].area));
    let (mut trial, mut grown) = (GrowingHull::default(), GrowingHull::default());
    for index in order {
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
