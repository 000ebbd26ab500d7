//! Conflicts between patches: a point between two of them is outside the solid by more than the
//! bound, so that no hull that fits contains both.

use super::patch::Patch;
use crate::bounded::containment::solid::Solid;
use crate::bounded::patch_set::PatchSet;
use crate::control::Control;
use crate::error::Error;
use crate::parallel;

/// For each patch those that it conflicts with. O(n²) segments between representatives.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn conflicts(
    patches: &[Patch],
    solid: &Solid,
    bound: f64,
    control: &Control,
) -> Result<Vec<PatchSet>, Error> {
    let indices: Vec<usize> = (0..patches.len()).collect();
    let rows = parallel::map(&indices, |&index| {
        control.check()?;
        let mut row = PatchSet::empty(patches.len());
        let first = &patches[index];
        for (other, second) in patches.iter().enumerate().skip(index + 1) {
            let is_separated = first
                .representatives
                .iter()
                .any(|&p| second.representatives.iter().any(|&q| solid.separates(p, q, bound)));
            if is_separated {
                row.insert(other as u32);
            }
        }
        Ok(row)
    });
    let mut conflicts: Vec<PatchSet> = rows.into_iter().collect::<Result<_, Error>>()?;
    for index in 0..patches.len() {
        let row: Vec<u32> = conflicts[index].iter().filter(|&o| o as usize > index).collect();
        for other in row {
            conflicts[other as usize].insert(index as u32);
        }
    }
    Ok(conflicts)
}
