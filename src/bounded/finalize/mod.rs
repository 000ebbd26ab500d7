//! Finalizing: pieces become hulls with thickness and few vertices, each verified against the
//! source and divided where it does not keep the bound.
//!
//! | file | contents |
//! |---|---|
//! | `verify/` | protrusion and uncovered distance, as upper bounds |
//! | `context` | what the other files share |
//! | `final_hull` | a hull of the result |
//! | `hull_simplification` | vertices are saved |
//! | `make_hull` | the final hull of some patches |
//! | `division` | pieces whose hull does not keep the bound are halved |
//! | `remerge` | divided hulls join again |

mod context;
mod division;
pub(super) mod final_hull;
mod hull_simplification;
mod make_hull;
mod remerge;
pub(super) mod verify;

use super::containment::solid::Solid;
use super::patch_set::PatchSet;
use super::patches::patch::Patches;
use super::piece::Piece;
use super::set_cover::SetCover;
use super::set_cover::assign_owners::assign_owners;
use super::settings::{MAX_UNCOVERED, Settings};
use crate::control::Control;
use crate::error::Error;
use crate::parallel;
use context::FinalizeContext;
use division::hulls_of_piece;
use final_hull::{FinalHull, FinalHulls};
use make_hull::surface_points;
use remerge::remerge;
use verify::hull_distance::HullDistance;
use verify::point_groups::{PointGroups, distance_outside};
use verify::uncovered::uncovered_distance;

/// Volume that saving a vertex may add, as a share of the mean volume of all pieces. With it, hulls
/// have about 27 vertices, at an intersection over union with the solid of 0.871 instead of 0.875
/// with all vertices (means over 38 models).
const VOLUME_PER_VERTEX: f64 = 1.2e-3;

/// The hulls of a cover. Of the cover before the last round of dissolving where that serves better:
/// verification may divide what the round has won, or the round may leave surface uncovered, which
/// counts more than hulls.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn finalize(
    patches: &Patches,
    SetCover { pieces, before_last_round }: SetCover,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<FinalHulls, Error> {
    let count = pieces.len();
    let last = finalize_pieces(patches, &pieces, solid, settings, control)?;
    let is_uncovered = last.uncovered > MAX_UNCOVERED * settings.uncovered_bound;
    let is_divided = last.hulls.len() > count;
    let Some(before) = before_last_round else { return Ok(last) };
    if !(is_uncovered || is_divided) || control.is_past_deadline() {
        return Ok(last);
    }
    let before = assign_owners(patches, &before, control)?;
    let before = finalize_pieces(patches, &before, solid, settings, control)?;
    let is_better =
        before.hulls.len() <= last.hulls.len() || is_uncovered && before.uncovered < last.uncovered;
    Ok(if is_better { before } else { last })
}

fn finalize_pieces(
    patches: &Patches,
    pieces: &[Piece],
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<FinalHulls, Error> {
    let volume =
        pieces.iter().map(|piece| piece.hull.volume).sum::<f64>() / pieces.len().max(1) as f64;
    let volume_per_vertex = VOLUME_PER_VERTEX * volume;
    let context = FinalizeContext { patches, solid, settings, volume_per_vertex, control };
    let size = |piece: &Piece| piece.patches.count();
    let parts = parallel::map_largest_first(pieces, size, |piece| hulls_of_piece(&context, piece));
    let parts = parts.into_iter().collect::<Result<Vec<Vec<FinalHull>>, Error>>()?;
    let is_divided = parts.iter().any(|part| part.len() > 1);
    let mut hulls: Vec<FinalHull> = parts.into_iter().flatten().collect();
    if is_divided {
        hulls = remerge(&context, hulls)?;
    }
    let uncovered = uncovered(&context, &hulls)?;
    Ok(FinalHulls { hulls, uncovered })
}

/// No point of the surface is farther than this outside all hulls.
fn uncovered(context: &FinalizeContext<'_>, hulls: &[FinalHull]) -> Result<f64, Error> {
    let &FinalizeContext { patches, settings, control, .. } = context;
    let allowed = MAX_UNCOVERED * settings.uncovered_bound;
    let (settled, open): (Vec<_>, Vec<_>) =
        (0..).zip(hulls).partition(|(_, hull)| hull.uncovered <= allowed);
    let mut uncovered = settled.iter().map(|(_, hull)| hull.uncovered).fold(0.0, f64::max);
    if open.is_empty() {
        return Ok(uncovered);
    }
    control.check()?;
    // Other hulls may contain what one has left out.
    let mut owners = vec![u32::MAX; patches.surface.triangles.len()];
    for (index, hull) in open {
        if hull.part.is_some() {
            hull.triangles(patches).for_each(|triangle| owners[triangle as usize] = index);
            continue;
        }
        for patch in hull.patches.iter() {
            control.check()?;
            let own = surface_points(patches, &PatchSet::of(patches.count(), [patch]), None);
            let distance = distance_outside(&hull.hull, &PointGroups::new(&own), f64::INFINITY);
            if distance <= allowed {
                uncovered = uncovered.max(distance);
            } else {
                for &triangle in &patches[patch].triangles {
                    owners[triangle as usize] = index;
                }
            }
        }
    }
    let distances: Vec<HullDistance> =
        hulls.iter().map(|hull| HullDistance::new(&hull.hull)).collect();
    let tolerance = uncovered.max(settings.cover_tolerance);
    uncovered_distance(&patches.surface, &owners, &distances, tolerance, control)
}
