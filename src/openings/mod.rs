//! Openings: the sides that a modeller leaves out since nobody sees them.
//!
//! A crate without a bottom is a shell to every decomposer, and takes many thin hulls. Here the flat
//! openings of the repaired mesh are found, and those are closed through which only the backs of
//! faces are seen. What follows works on the closed solid, and its promises are about that.
//!
//! | file | contents |
//! |---|---|
//! | `boundary` | the boundary as simple loops |
//! | `cap` | flat polygons over loops, and zips for cracks |
//! | `crossing` | whether the surface goes through a cap |
//! | `look` | what is seen through an opening |
//! | `decide` | rules 3 to 6 below, for each cap |
//! | `fragments` | rule 7 |
//! | `nested` | closed components that nothing can reach |
//! | `report` | what became of each opening |
//! | `prepare` | the repaired mesh with its caps |
//! | `closed_mesh` | the same as a public result |
//!
//! The rules, in this order:
//!
//! 1. Cracks and T-junctions within the weld distance are no openings: they are zipped.
//! 2. A loop that is not flat within the tolerance stays open.
//! 3. So does one whose cap would meet the surface around it at less than 30° in the median: a sheet;
//!    or whose cap the surface goes through.
//! 4. A loop around which most of the surface is drawn from both sides, or is there both ways round, stays
//!    open unless it lies in the lowest plane of the mesh.
//! 5. Rays go inward from the caps that are left, all of them closed. One from which more than 5 % of
//!    the rays see the front of a face, or a way out, stays open; so does one from which most see
//!    only another cap. This is repeated until no more caps fall.
//! 6. One beyond which is inside already stays open: parts of an open skin, as the planks of a chest without
//!    backs, enclose a solid together.
//! 7. The caps of a component most of whose boundary stays open are left, and all caps of a mesh nine tenths of
//!    whose boundary do.
//! 8. Where nothing else stays open, those of 6 are closed after all, as a leg's end within a table's top, but
//!    are no surface: the mesh is closed then, and nothing can touch them. One that reaches out of the solid is.
//!
//! A closed mesh whose normals all point inward is no opening's matter: repair turns it around, since
//! exporters that mirror are more common than rooms without a door.

mod boundary;
mod cap;
pub(crate) mod closed_mesh;
mod crossing;
mod decide;
mod fragments;
mod look;
mod nested;
pub(crate) mod prepare;
mod report;

use boundary::boundary_loops;
use cap::{Candidate, Cap, candidates};
use decide::{close_exposed, decide};
use fragments::leave_fragments;

use crate::control::Control;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::parameters::{Length, Openings, Parameters, UpAxis};

pub use closed_mesh::{ClosedMesh, close_openings, surface_and_solid};
pub use report::{Opening, OpeningOutcome};

/// What of [`Parameters`](crate::Parameters) openings depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OpeningSettings {
    pub openings: Openings,
    /// How far a loop's vertices may be from its plane.
    pub flatness: Length,
    pub up_axis: UpAxis,
    /// Whether closed components that nothing can reach stay.
    pub keep_cavities: bool,
    pub order: MeshOrder,
}

impl OpeningSettings {
    /// For methods that take the mesh as it is.
    pub(crate) fn as_it_is(order: MeshOrder) -> Self {
        let kept = Parameters::default().openings(Openings::Keep).keep_cavities(true);
        Self { order, ..Self::from(&kept) }
    }
}

impl From<&Parameters> for OpeningSettings {
    fn from(parameters: &Parameters) -> Self {
        let &Parameters { openings, up_axis, max_error, keep_cavities, .. } = parameters;
        Self { openings, flatness: max_error, up_axis, keep_cavities, order: MeshOrder::Place }
    }
}

/// Triangles that close openings, and what became of each.
struct Closing {
    triangles: Vec<[u32; 3]>,
    /// Those within the solid.
    hidden: Vec<[u32; 3]>,
    openings: Vec<Opening>,
}

/// Decides for each opening of a repaired mesh. `source` tells which sides of faces are drawn.
///
/// # Errors
/// [`Error::Cancelled`].
fn close(
    prepared: &PreparedMesh,
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Closing, Error> {
    let (positions, triangles) = (&prepared.mesh.positions, &prepared.mesh.triangles);
    let loops = boundary_loops(positions, triangles);
    control.check()?;
    let flatness = flatness_in_diagonals(prepared, settings);
    let mut closing = Closing { triangles: Vec::new(), hidden: Vec::new(), openings: Vec::new() };
    let mut caps: Vec<(Cap, OpeningOutcome)> = Vec::new();
    let mut is_crack = vec![false; loops.len()];
    for candidate in candidates(positions, &loops, flatness) {
        let left =
            |loop_index: usize, outcome| Opening::left(&loops[loop_index], prepared, outcome);
        match candidate {
            Candidate::Crack { loop_index, triangles } => {
                is_crack[loop_index] = true;
                closing.triangles.extend(triangles);
            }
            Candidate::NotFlat { loop_index } => {
                closing.openings.push(left(loop_index, OpeningOutcome::NotFlat));
            }
            Candidate::NotSimple { loop_index } => {
                closing.openings.push(left(loop_index, OpeningOutcome::NotSimple));
            }
            Candidate::Cap(cap) => caps.push((cap, OpeningOutcome::Closed)),
        }
    }
    control.check()?;
    if !caps.is_empty() {
        decide(prepared, source, &loops, &mut caps, settings, control)?;
    }
    leave_fragments(prepared, &loops, &is_crack, &mut caps);
    let is_left = |outcome: &OpeningOutcome| !outcome.is_closed();
    if closing.openings.iter().any(|opening| is_left(&opening.outcome))
        || caps.iter().any(|(_, outcome)| is_left(outcome))
    {
        for (_, outcome) in &mut caps {
            if *outcome == OpeningOutcome::ClosedWithin {
                *outcome = OpeningOutcome::SolidBeyond;
            }
        }
    } else {
        close_exposed(prepared, &mut caps, control)?;
    }
    for (cap, outcome) in &caps {
        match outcome {
            OpeningOutcome::Closed => closing.triangles.extend_from_slice(&cap.triangles),
            OpeningOutcome::ClosedWithin => closing.hidden.extend_from_slice(&cap.triangles),
            _ => {}
        }
        closing.openings.push(Opening::of_cap(cap, &loops, prepared, *outcome));
    }
    Ok(closing)
}

fn flatness_in_diagonals(prepared: &PreparedMesh, settings: &OpeningSettings) -> f64 {
    let diagonal = prepared.normalization.diagonal;
    settings.flatness.of_diagonal(diagonal) / diagonal
}
