//! From Parry's shapes to ours, and back.

use rapier3d::parry::math::Vector;
use rapier3d::parry::shape::{ConvexPolyhedron, TriMesh, TriMeshFlags};

use super::prepare::ColliderError;
use super::shape::polyhedron;
use crate::{ConvexHull, Error, MeshView, TriangleMesh};

impl From<&TriMesh> for TriangleMesh {
    fn from(mesh: &TriMesh) -> Self {
        let points = mesh.vertices().iter().map(Vector::to_array);
        Self::from_points::<f32, _>(points, mesh.indices().to_vec())
    }
}

impl From<&ConvexPolyhedron> for ConvexHull {
    /// The polyhedron's faces are cut into triangles.
    fn from(polyhedron: &ConvexPolyhedron) -> Self {
        let (points, triangles) = polyhedron.to_trimesh();
        let points = points.iter().map(|point| point.to_array().map(f64::from)).collect();
        Self { points, triangles }
    }
}

/// Parry's triangle mesh of a mesh, for bodies that don't move. Triangles with an index out of range or
/// a corner that is not finite in `f32` are left out. O(n log n).
///
/// # Errors
/// [`ColliderError::TriangleMesh`] says why Parry refuses, [`ColliderError::Mesh`] that nothing is left.
pub fn triangle_mesh<'a>(
    mesh: impl Into<MeshView<'a>>,
    flags: TriMeshFlags,
) -> Result<TriMesh, ColliderError> {
    let mesh = mesh.into();
    let points: Vec<Vector> =
        mesh.positions().map(|point| Vector::from(point.map(|x| x as f32))).collect();
    let is_usable = |vertex: &u32| points.get(*vertex as usize).is_some_and(|p| p.is_finite());
    let triangles: Vec<[u32; 3]> = mesh
        .triangles()
        .iter()
        .filter(|triangle| triangle.iter().all(is_usable))
        .copied()
        .collect();
    if triangles.is_empty() {
        let all = mesh.triangles().len();
        let nothing = Error::NothingUsable { triangles: all, degenerate: 0, non_finite: all };
        return Err(nothing.into());
    }
    // Parry's tree holds all points, used or not.
    let points = points.into_iter().map(|p| if p.is_finite() { p } else { Vector::ZERO }).collect();
    TriMesh::with_flags(points, triangles, flags)
        .map_err(|error| ColliderError::TriangleMesh { reason: error.to_string() })
}

/// Parry's convex polyhedron of a hull, whose points are rounded to `f32`. O(n log n).
///
/// # Errors
/// [`ColliderError::UnusableHull`] where nothing is left of it in `f32`, and
/// [`ColliderError::Refused`] where Parry refuses it; [`shape`](super::shape) then takes a slightly
/// simpler one.
pub fn convex_polyhedron(hull: &ConvexHull) -> Result<ConvexPolyhedron, ColliderError> {
    let (points, triangles) = hull
        .to_single_precision()
        .map_err(|reason| ColliderError::UnusableHull { hull: 0, reason })?;
    polyhedron(&points, &triangles).ok_or(ColliderError::Refused)
}
