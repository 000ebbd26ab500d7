//! What every method begins with: checks, the prepared mesh, and the report on it.

use crate::control::Control;
use crate::decomposition::{ALGORITHM_VERSION, RunReport};
use crate::error::Error;
use crate::geometry::MeshView;
use crate::mesh::PreparedMesh;
use crate::openings::Opening;
use crate::openings::prepare::Closed;
use crate::stages::Stages;

/// What is checked before the mesh is copied or looked at.
///
/// # Errors
/// [`Error::TooLarge`] and [`Error::EmptyMesh`].
pub(crate) fn admit(mesh: MeshView<'_>, control: &Control) -> Result<(), Error> {
    let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles().len());
    control.admit(triangles)?;
    if vertices == 0 || triangles == 0 {
        return Err(Error::EmptyMesh { vertices, triangles });
    }
    Ok(())
}

/// A mesh that is repaired, its openings closed or kept.
pub(crate) struct Input {
    pub prepared: PreparedMesh,
    source_vertices: usize,
    source_triangles: usize,
    openings: Vec<Opening>,
    nested_components: usize,
}

impl Input {
    /// A repaired mesh whose openings are closed.
    pub(crate) fn closed(source: MeshView<'_>, closed: Closed) -> Self {
        let Closed { prepared, openings, nested_components, .. } = closed;
        Self { openings, nested_components, ..Self::as_it_is(source, prepared) }
    }

    /// A repaired mesh whose openings stay.
    pub(crate) fn as_it_is(source: MeshView<'_>, prepared: PreparedMesh) -> Self {
        Self {
            prepared,
            source_vertices: source.vertex_count(),
            source_triangles: source.triangles().len(),
            openings: Vec::new(),
            nested_components: 0,
        }
    }

    /// What is reported once all stages are done.
    pub(crate) fn report(self, stages: Stages, deadline_reached: bool) -> RunReport {
        let prepared = self.prepared;
        RunReport {
            algorithm_version: ALGORITHM_VERSION,
            source_vertices: self.source_vertices,
            source_triangles: self.source_triangles,
            triangles: prepared.mesh.triangles.len(),
            diagonal: prepared.normalization.diagonal,
            components: prepared.closed.len(),
            closed_components: prepared.closed.iter().filter(|&&closed| closed).count(),
            repairs: prepared.repairs,
            openings: self.openings,
            nested_components: self.nested_components,
            deadline_reached,
            times: stages.finish(),
        }
    }
}
