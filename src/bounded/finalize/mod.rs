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
pub(crate) mod final_hull;
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

/// The last round of dissolving is doubted where verification divides its pieces into this many times as many as
/// there were before it. With 1, lattices and noisy spheres of a hundred hulls have 2 % more, and others as many.
const DOUBTFUL: f64 = 1.25;

/// The hulls of a cover. Of the cover before the last round of dissolving where that serves better:
/// verification may divide what the round has won, or the round may leave surface uncovered, which
/// counts more than hulls.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn finalize(
    patches: &Patches,
    SetCover { pieces, before_last_round }: SetCover,
    solid: &Solid,
    settings: &Settings,
    control: &Control,
) -> Result<FinalHulls, Error> {
    let verified =
        |pieces: &[Piece]| VerifiedPieces::new(patches, pieces, solid, settings, control);
    let last = verified(&pieces)?;
    let Some(before) = before_last_round else { return last.joined() };
    let verified_before = || verified(&assign_owners(patches, &before, control)?);
    if last.hulls.len() as f64 > DOUBTFUL * before.len() as f64 && !control.is_past_deadline() {
        let before = verified_before()?;
        let is_better = before.hulls.len() <= last.hulls.len();
        return if is_better { before.joined() } else { last.joined() };
    }
    let last = last.joined()?;
    let is_uncovered = last.uncovered > MAX_UNCOVERED * settings.bound.uncovered();
    if !is_uncovered || control.is_past_deadline() {
        return Ok(last);
    }
    let before = verified_before()?.joined()?;
    Ok(if before.uncovered < last.uncovered { before } else { last })
}

/// The hulls of pieces, each of which keeps the bound.
struct VerifiedPieces<'a> {
    context: FinalizeContext<'a>,
    hulls: Vec<FinalHull>,
    is_divided: bool,
}

impl<'a> VerifiedPieces<'a> {
    fn new(
        patches: &'a Patches,
        pieces: &[Piece],
        solid: &'a Solid,
        settings: &'a Settings,
        control: &'a Control,
    ) -> Result<Self, Error> {
        let volume =
            pieces.iter().map(|piece| piece.hull.volume).sum::<f64>() / pieces.len().max(1) as f64;
        let volume_per_vertex = VOLUME_PER_VERTEX * volume;
        let context = FinalizeContext { patches, solid, settings, volume_per_vertex, control };
        let size = |piece: &Piece| piece.patches.count();
        let parts =
            parallel::map_largest_first(pieces, size, |piece| hulls_of_piece(&context, piece));
        let parts = parts.into_iter().collect::<Result<Vec<Vec<FinalHull>>, Error>>()?;
        let is_divided = parts.iter().any(|part| part.len() > 1);
        Ok(Self { context, hulls: parts.into_iter().flatten().collect(), is_divided })
    }

    /// The same, joined again where they were divided.
    fn joined(self) -> Result<FinalHulls, Error> {
        let Self { context, mut hulls, is_divided } = self;
        if is_divided {
            hulls = remerge(&context, hulls)?;
        }
        let uncovered = uncovered(&context, &hulls)?;
        Ok(FinalHulls { hulls, uncovered })
    }
}

/// No point of the surface is farther than this outside all hulls.
fn uncovered(context: &FinalizeContext<'_>, hulls: &[FinalHull]) -> Result<f64, Error> {
    let &FinalizeContext { patches, settings, control, .. } = context;
    let allowed = MAX_UNCOVERED * settings.bound.uncovered();
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
            let own = surface_points(patches, &PatchSet::of(patches.count(), [patch]), None);
            let groups = PointGroups::new(&own);
            let distance = distance_outside(&hull.hull, &groups, f64::INFINITY, control)?;
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
    let tolerance = uncovered.max(settings.bound.tolerance());
    uncovered_distance(&patches.surface, &owners, &distances, tolerance, control)
}
