//! Repair, closing, and repair again: the mesh that the stages after it work on.

use super::{Opening, OpeningSettings, close};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::mesh::repair::prepare;
use crate::mesh::{CAP, PreparedMesh, TriangleMesh};
use crate::parameters::Openings;

/// Caps have the vertices of their loops, and ear clipping leaves out those in the middle of a
/// straight side: that is a crack, which the next pass zips.
const PASSES: usize = 3;

/// Repairs a mesh and closes its openings. In `source_triangles` caps stand as [`CAP`]. The counts of
/// repairs are those of the mesh as it came.
///
/// Takes as long as repair where nothing is open; otherwise some hundred rays for each flat opening, and
/// repair once more where one is closed.
///
/// # Errors
/// As [`prepare`].
pub(crate) fn prepare_closed(
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<(PreparedMesh, Vec<Opening>), Error> {
    close_prepared(prepare(source, control)?, source, settings, control)
}

/// The same for a mesh that is repaired already.
///
/// # Errors
/// As [`prepare`].
pub(crate) fn close_prepared(
    mut prepared: PreparedMesh,
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<(PreparedMesh, Vec<Opening>), Error> {
    let is_closed = |prepared: &PreparedMesh| prepared.closed.iter().all(|&closed| closed);
    if settings.openings == Openings::Keep || is_closed(&prepared) {
        return Ok((prepared, Vec::new()));
    }
    let mut openings = Vec::new();
    for pass in 0..PASSES {
        let closing = close(&prepared, source, settings, control)?;
        if pass == 0 {
            openings = closing.openings;
        }
        if closing.triangles.is_empty() {
            break;
        }
        prepared = with_caps(prepared, source, &closing.triangles, control)?;
        if is_closed(&prepared) {
            break;
        }
    }
    Ok((prepared, openings))
}

/// The repaired mesh with more triangles, repaired.
fn with_caps(
    before: PreparedMesh,
    source: MeshView<'_>,
    caps: &[[u32; 3]],
    control: &Control,
) -> Result<PreparedMesh, Error> {
    let positions = before.source_vertices.iter().map(|&vertex| source.at(vertex)).collect();
    let triangles = [before.mesh.triangles.as_slice(), caps].concat();
    let mesh = TriangleMesh::new(positions, triangles);
    let mut after = prepare(mesh.view(), control)?;
    let was_both_ways =
        |triangle: u32| before.is_both_ways.get(triangle as usize).copied().unwrap_or(false);
    for (t, &triangle) in after.source_triangles.iter().enumerate() {
        // What caps close is a solid, however it was drawn.
        let is_open = !after.closed[after.components[t] as usize];
        after.is_both_ways[t] |= is_open && was_both_ways(triangle);
    }
    for triangle in &mut after.source_triangles {
        *triangle = before.source_triangles.get(*triangle as usize).copied().unwrap_or(CAP);
    }
    for vertex in &mut after.source_vertices {
        *vertex = before.source_vertices[*vertex as usize];
    }
    after.repairs = before.repairs;
    Ok(after)
}
