//! What every method begins with, checks, repair and openings, and the report on that.

use crate::control::{Control, Stage};
use crate::decomposition::{ALGORITHM_VERSION, RunReport};
use crate::error::Error;
use crate::geometry::MeshView;
use crate::mesh::PreparedMesh;
use crate::mesh::repair::prepare as repair;
use crate::openings::prepare::close_prepared as close_openings;
use crate::openings::{Opening, OpeningSettings};
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
    /// The first two stages.
    ///
    /// # Errors
    /// As [`repair`], and [`Error::Cancelled`].
    pub(crate) async fn repaired_and_closed(
        mesh: MeshView<'_>,
        settings: &OpeningSettings,
        stages: &mut Stages,
    ) -> Result<Self, Error> {
        let control = &stages.control();
        let repaired = stages.run(Stage::Repair, || repair(mesh, settings.order, control)).await?;
        let closed = stages
            .run(Stage::Openings, || close_openings(repaired, mesh, settings, control))
            .await?;
        Ok(Self {
            prepared: closed.prepared,
            source_vertices: mesh.vertex_count(),
            source_triangles: mesh.triangles().len(),
            openings: closed.openings,
            nested_components: closed.nested_components,
        })
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
