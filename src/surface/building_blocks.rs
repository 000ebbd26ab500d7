//! The paper's method in parts, for those who group a surface in another way: simplified meshes [3.2, 3.5], the
//! cost of Table 1 [3.4.2, 3.4.3], and from groups to hulls [3.6].

use super::cost::{CostScratch, cost};
use super::group_merging::merge_groups;
use super::parameters::SurfaceParameters;
use super::pieces::Pieces;
use super::resolution_selection::{Level, Levels};
use super::threshold_selection::TOO_SMALL_TO_COUNT;
use crate::control::Control;
use crate::decomposer::admit;
use crate::decomposition::{GroupedMesh, Hull};
use crate::error::Error;
use crate::geometry::{MeshView, TriangleMesh};
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::grouping::{Grouping, members};
use crate::mesh::repair::prepare;
use crate::parallel;

/// A mesh simplified to each maximum resolution r (sections 3.2 and 3.5), to be grouped by a method of one's
/// own.
pub struct SimplifiedMeshes {
    prepared: PreparedMesh,
    levels: Vec<Level>,
}

impl SimplifiedMeshes {
    /// Repairs a mesh and simplifies it, each resolution from the next finer one. O(n log n).
    ///
    /// # Errors
    /// As [`decompose`](super::decompose()).
    pub fn new<'a>(
        mesh: impl Into<MeshView<'a>>,
        parameters: &SurfaceParameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let mesh = mesh.into();
        parameters.validate()?;
        admit(mesh, control)?;
        let prepared = prepare(mesh, MeshOrder::Input, control)?;
        let mut levels = Levels::new(parameters);
        while !levels.is_complete() {
            levels.make_next(&prepared, parameters, control)?;
        }
        Ok(Self { prepared, levels: levels.finish() })
    }

    /// Triangles before simplification.
    pub fn initial_polygons(&self) -> usize {
        self.prepared.mesh.triangles.len()
    }

    /// Each r with its mesh, ascending. The unit is the diagonal of the source. Where nothing is left to
    /// simplify, a mesh is that of the resolution before.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &TriangleMesh)> {
        self.levels.iter().map(|level| (level.resolution, &level.mesh))
    }

    /// Merges small groups (section 3.6), and returns the hulls of the groups that are left, and the mesh with
    /// these groups; both in the source's units.
    ///
    /// `groups` gives each triangle of the mesh at this place of [`iter`](Self::iter) a group.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] where there is no such mesh, or a number of groups that is not that of its
    /// triangles, or a group of a number that is no triangle's; [`Error::Cancelled`].
    pub fn hulls(
        &self,
        place: usize,
        groups: &[u32],
        parameters: &SurfaceParameters,
        control: &Control,
    ) -> Result<(Vec<Hull>, GroupedMesh), Error> {
        let invalid = |name, reason: &str| Error::InvalidParameter { name, reason: reason.into() };
        let level = self.levels.get(place).ok_or_else(|| invalid("place", "no such mesh"))?;
        let grouping = grouping(groups, level.mesh.triangles.len())?;
        let significant = parameters.significant_diagonal;
        let grouping = merge_groups(&level.mesh, &level.adjacency, &grouping, significant);
        let pieces =
            Pieces { mesh: &level.mesh, components: &level.components, grouping: &grouping };
        let normalization = &self.prepared.normalization;
        let mut hulls = pieces.hulls(normalization, parameters.max_vertices, control)?;
        parallel::with(control.is_parallel(), || {
            pieces.assign_source_triangles(&self.prepared, &mut hulls, control)
        })?;
        Ok((hulls, pieces.grouped_mesh(normalization)))
    }
}

/// The cost of Table 1 for any grouped mesh: the average of equation (3) over the groups of more than two
/// triangles; 0 without any. O(vertices · hull faces) per group.
///
/// # Errors
/// [`Error::IndexOutOfRange`]; [`Error::InvalidParameter`] where the number of groups is not that of the
/// triangles, or a group has a number that is no triangle's.
pub fn average_cost(grouped: &GroupedMesh) -> Result<f64, Error> {
    let GroupedMesh { positions, triangles, groups } = grouped;
    let vertices = positions.len();
    for (triangle, &index) in
        triangles.iter().enumerate().flat_map(|(place, t)| t.iter().map(move |i| (place, i)))
    {
        if index as usize >= vertices {
            return Err(Error::IndexOutOfRange { triangle, index, vertices });
        }
    }
    let Grouping { labels, count } = grouping(groups, triangles.len())?;
    let mesh = TriangleMesh::new(positions.clone(), triangles.clone());
    let mut scratch = CostScratch::default();
    let (mut sum, mut counted) = (0.0, 0_u32);
    for group in members(&labels, count).iter().filter(|group| group.len() > TOO_SMALL_TO_COUNT) {
        sum += cost(&mesh, group, &mut scratch);
        counted += 1;
    }
    Ok(sum / f64::from(counted.max(1)))
}

/// Labels that are checked.
fn grouping(groups: &[u32], triangles: usize) -> Result<Grouping, Error> {
    let invalid = |reason: String| Error::InvalidParameter { name: "groups", reason };
    if groups.len() != triangles {
        return Err(invalid(format!("{} groups for {triangles} triangles", groups.len())));
    }
    let count = groups.iter().max().map_or(0, |&label| label as usize + 1);
    if count > triangles {
        return Err(invalid(format!("group {} of {triangles} triangles", count - 1)));
    }
    Ok(Grouping { labels: groups.to_vec(), count })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, join};

    #[test]
    fn groups_become_hulls_and_what_is_no_group_is_refused() {
        let mesh = join(&[cuboid([0.0; 3], [1.0; 3]), cuboid([3.0; 3], [4.0; 3])]);
        let (parameters, control) = (SurfaceParameters::paper(), Control::new());
        let simplified = SimplifiedMeshes::new(&mesh, &parameters, &control).unwrap();
        assert_eq!(simplified.initial_polygons(), 24);
        let resolutions: Vec<(usize, usize)> =
            simplified.iter().map(|(r, mesh)| (r, mesh.triangles.len())).collect();
        assert_eq!(resolutions, [250, 500, 1000, 2000, 3000].map(|r| (r, 24)));
        let groups: Vec<u32> = (0..24).map(|triangle| triangle / 12).collect();
        let (hulls, grouped) = simplified.hulls(0, &groups, &parameters, &control).unwrap();
        let volumes: Vec<f64> = hulls.iter().map(|hull| hull.shape.volume().round()).collect();
        assert_eq!((volumes, &grouped.groups), (vec![1.0, 1.0], &groups));
        assert!(average_cost(&grouped).unwrap() < 1e-9);

        let refused = |place: usize, groups: &[u32]| {
            let result = simplified.hulls(place, groups, &parameters, &control);
            matches!(result, Err(Error::InvalidParameter { .. }))
        };
        assert!(refused(5, &groups) && refused(0, &groups[1..]) && refused(0, &[u32::MAX; 24]));
        let mut broken = grouped.clone();
        broken.triangles[3][1] = 99;
        let expected = Error::IndexOutOfRange { triangle: 3, index: 99, vertices: 16 };
        assert_eq!(average_cost(&broken), Err(expected));
    }
}
