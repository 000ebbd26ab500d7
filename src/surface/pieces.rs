//! From groups to hulls: the hull of each group, and the source triangles that it stands for.

use std::borrow::Cow;

use crate::bvh::{Bvh, closest_labels};
use crate::control::{Control, Stage};
use crate::decomposition::{GroupedMesh, Hull, HullErrors, Provenance};
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, as_arrays, as_vectors};
use crate::hull::{ConvexHull, HullBuilder, LEAST_THICKNESS, limit_vertices, solid_hull};
use crate::mesh::grouping::{Grouping, corners, group_vertices, members};
use crate::mesh::{Normalization, PreparedMesh, TriangleMesh};
use crate::stages::Stages;

/// A mesh whose triangles are grouped: each group is a piece, and becomes a hull.
#[derive(Debug, Clone, Copy)]
pub struct Pieces<'a> {
    /// The prepared mesh, or a simplified one, in normalised coordinates.
    pub mesh: &'a TriangleMesh,
    /// For each triangle its component.
    pub components: &'a [u32],
    /// For each triangle its group.
    pub grouping: &'a Grouping,
}

impl Pieces<'_> {
    /// The hull of each group, in the input's units, without its source triangles.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn hulls(
        &self,
        normalization: &Normalization,
        max_vertices: Option<usize>,
        control: &Control,
    ) -> Result<Vec<Hull>, Error> {
        let mesh = self.mesh;
        let mut builder = HullBuilder::new();
        let groups = members(&self.grouping.labels, self.grouping.count);
        let mut hulls = Vec::with_capacity(groups.len());
        for group in &groups {
            control.check()?;
            let vertices = group_vertices(mesh, group);
            let points: Vec<Vector> =
                vertices.iter().map(|&vertex| mesh.points()[vertex as usize]).collect();
            let outward = group.iter().fold(Vector::ZERO, |sum, &triangle| {
                let [a, b, c] = corners(mesh, triangle);
                sum + area_normal(a, b, c)
            });
            let (solid, added) =
                solid_hull(&mut builder, as_arrays(&points), outward.to_array(), LEAST_THICKNESS)?;
            let (solid, growth) = match max_vertices {
                Some(most) => limit_vertices(&mut builder, solid, most, control)?,
                None => (solid, 0.0),
            };
            let component = group.first().map_or(0, |&triangle| self.components[triangle as usize]);
            let points =
                solid.points().iter().map(|&point| normalization.restore(point).into()).collect();
            hulls.push(Hull {
                shape: ConvexHull { points, triangles: solid.triangles },
                provenance: Provenance { component, source_triangles: Vec::new() },
                errors: HullErrors {
                    added_thickness: added * normalization.diagonal,
                    simplification_growth: growth * normalization.diagonal,
                    protrusion_max: None,
                },
            });
        }
        Ok(hulls)
    }

    /// Gives each source triangle to the hull whose group holds the simplified triangle nearest to
    /// its centre, for no more triangles than `closest_labels` compares. O(n log m) for n source and m simplified
    /// triangles.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn assign_source_triangles(
        &self,
        prepared: &PreparedMesh,
        hulls: &mut [Hull],
        control: &Control,
    ) -> Result<(), Error> {
        let labels = if self.mesh.triangles == prepared.mesh.triangles {
            Cow::Borrowed(&self.grouping.labels)
        } else {
            let bvh = Bvh::new(self.mesh.points(), &self.mesh.triangles);
            let TriangleMesh { positions, triangles, .. } = &prepared.mesh;
            let grouped = &self.grouping.labels;
            Cow::Owned(closest_labels(as_vectors(positions), triangles, &bvh, grouped, control)?)
        };
        for (&label, &source) in labels.iter().zip(&prepared.source_triangles) {
            if let Some(hull) = hulls.get_mut(label as usize) {
                hull.provenance.source_triangles.push(source);
            }
        }
        for hull in hulls {
            hull.provenance.source_triangles.sort_unstable();
            // A triangle that repair split in two is still one of the source.
            hull.provenance.source_triangles.dedup();
        }
        Ok(())
    }

    /// Both of the above, as the last stages of a method.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) async fn finish(
        &self,
        prepared: &PreparedMesh,
        max_vertices: Option<usize>,
        stages: &mut Stages,
    ) -> Result<Vec<Hull>, Error> {
        let control = &stages.control();
        let make = || self.hulls(&prepared.normalization, max_vertices, control);
        let mut hulls = stages.run(Stage::Hulls, make).await?;
        let assign = || self.assign_source_triangles(prepared, &mut hulls, control);
        stages.run(Stage::Assign, assign).await?;
        Ok(hulls)
    }

    /// The mesh and its groups, in the input's units.
    pub(crate) fn grouped_mesh(&self, normalization: &Normalization) -> GroupedMesh {
        let positions = self.mesh.points().iter();
        GroupedMesh {
            positions: positions.map(|&point| normalization.restore(point).into()).collect(),
            triangles: self.mesh.triangles.clone(),
            groups: self.grouping.labels.clone(),
        }
    }
}
