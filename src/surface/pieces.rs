//! Hulls of the groups [3.6], and the source triangles that each of them stands for.

use std::borrow::Cow;

use crate::bvh::Bvh;
use crate::bvh::closest_triangles::closest_labels;
use crate::control::Control;
use crate::decomposition::{Hull, HullErrors, Provenance};
use crate::error::Error;
use crate::geometry::vector::{Vector, add, area_normal};
use crate::hull::{ConvexHull, HullBuilder, LEAST_THICKNESS, limit_vertices, solid_hull};
use crate::mesh::{Normalization, PreparedMesh, TriangleMesh};

use super::grouping::{Grouping, corners, group_vertices, members};

/// The hull of each group, in the input's units, without its source triangles.
pub fn hulls(
    mesh: &TriangleMesh,
    components: &[u32],
    grouping: &Grouping,
    normalization: &Normalization,
    max_vertices: Option<usize>,
    control: &Control,
) -> Result<Vec<Hull>, Error> {
    let mut builder = HullBuilder::new();
    let groups = members(&grouping.labels, grouping.count);
    let mut hulls = Vec::with_capacity(groups.len());
    for group in &groups {
        control.check()?;
        let vertices = group_vertices(mesh, group);
        let points: Vec<Vector> =
            vertices.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
        let outward = group.iter().fold([0.0; 3], |sum, &triangle| {
            let [a, b, c] = corners(mesh, triangle);
            add(sum, area_normal(a, b, c))
        });
        let (solid, added) = solid_hull(&mut builder, &points, outward, LEAST_THICKNESS)?;
        let (solid, growth) = match max_vertices {
            Some(cap) => limit_vertices(&mut builder, solid, cap, control)?,
            None => (solid, 0.0),
        };
        let component = group.first().map_or(0, |&triangle| components[triangle as usize]);
        let points = solid.points.iter().map(|&point| normalization.restore(point)).collect();
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
/// its centre, up to what `closest_labels` does not ask. O(n log m) for n source and m simplified
/// triangles.
pub fn assign_source_triangles(
    prepared: &PreparedMesh,
    mesh: &TriangleMesh,
    grouping: &Grouping,
    hulls: &mut [Hull],
    control: &Control,
) -> Result<(), Error> {
    let labels = if mesh.triangles == prepared.mesh.triangles {
        Cow::Borrowed(&grouping.labels)
    } else {
        let bvh = Bvh::new(&mesh.positions, &mesh.triangles);
        let TriangleMesh { positions, triangles, .. } = &prepared.mesh;
        Cow::Owned(closest_labels(positions, triangles, &bvh, &grouping.labels, control)?)
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
