//! V-HACD as Parry has it and Rapier calls it: exact convex hulls of the parts.

use hullwright::{MeshView, TriangleMesh};
use hullwright_formats::NamedMesh;
use parry3d::math::Vector;
use parry3d::transformation::vhacd::VHACD;

use super::methods::Run;
pub use parry3d::transformation::vhacd::VHACDParameters;

/// What a run asks of V-HACD; `None` for other methods.
pub fn parameters(run: &Run) -> Option<VHACDParameters> {
    let Run::Vhacd { concavity, resolution } = *run else { return None };
    Some(VHACDParameters { concavity: concavity as f32, resolution, ..VHACDParameters::default() })
}

/// Hulls in the mesh's units, in single precision as Parry computes.
pub fn decompose(mesh: MeshView<'_>, parameters: &VHACDParameters) -> Vec<NamedMesh> {
    let points: Vec<Vector> =
        mesh.positions().map(|[x, y, z]| Vector::new(x as f32, y as f32, z as f32)).collect();
    let parts = VHACD::decompose(parameters, &points, mesh.triangles(), true);
    let hulls = parts.compute_exact_convex_hulls(&points, mesh.triangles()).into_iter();
    let read = |(index, (points, triangles)): (usize, (Vec<Vector>, Vec<[u32; 3]>))| NamedMesh {
        name: format!("hull_{index}"),
        mesh: TriangleMesh::from_points::<f32, _>(
            points.iter().map(|p| [p.x, p.y, p.z]),
            triangles,
        ),
    };
    hulls.enumerate().map(read).collect()
}
