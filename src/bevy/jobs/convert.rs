//! From Bevy's meshes to ours, and from hulls to Bevy's.

use bevy::asset::RenderAssetUsages;
use bevy::math::Affine3A;
use bevy::mesh::{Mesh, PrimitiveTopology};

use crate::bevy::jobs::mesh_data::{MeshData, append};
use crate::bevy::tag::error::DecompositionError;
use crate::{ConvexHull, TriangleMesh};

impl TryFrom<&Mesh> for TriangleMesh {
    type Error = DecompositionError;

    /// The triangles of a list or a strip, with or without indices. O(size).
    ///
    /// # Errors
    /// [`DecompositionError`] says what keeps the mesh from being read: points or lines, positions in
    /// another format, data that is in the render world alone.
    fn try_from(mesh: &Mesh) -> Result<Self, DecompositionError> {
        let mut data = MeshData::default();
        append(&mut data, mesh, &Affine3A::IDENTITY)?;
        Ok(Self::from_points::<f32, _>(data.positions, data.triangles))
    }
}

impl From<&ConvexHull> for Mesh {
    /// Flat-shaded triangles, with normals, in single precision. O(triangles).
    ///
    /// ```
    /// use bevy::prelude::*;
    ///
    /// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let mesh = Mesh::from(&hullwright::convex_hull(&points)?);
    /// assert_eq!(mesh.count_vertices(), 12);
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    fn from(hull: &ConvexHull) -> Self {
        let corners: Vec<[f32; 3]> =
            hull.corners().flatten().map(|point| point.map(|x| x as f32)).collect();
        let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners);
        mesh.compute_flat_normals();
        mesh
    }
}
