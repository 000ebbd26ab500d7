//! V-HACD as Parry has it and Rapier calls it: exact convex hulls of the parts.

use hullwright::io::HullMesh;
use parry3d::math::Vector;
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};

/// Hulls in the mesh's units, in single precision as Parry computes.
pub fn decompose(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    concavity: f64,
    resolution: u32,
) -> Vec<HullMesh> {
    let points: Vec<Vector> =
        positions.iter().map(|&[x, y, z]| Vector::new(x as f32, y as f32, z as f32)).collect();
    let parameters =
        VHACDParameters { concavity: concavity as f32, resolution, ..VHACDParameters::default() };
    let parts = VHACD::decompose(&parameters, &points, triangles, true);
    let hulls = parts.compute_exact_convex_hulls(&points, triangles).into_iter();
    let read = |(index, (points, triangles)): (usize, (Vec<Vector>, Vec<[u32; 3]>))| HullMesh {
        name: format!("hull_{index}"),
        positions: points.iter().map(|p| [p.x, p.y, p.z].map(f64::from)).collect(),
        triangles,
    };
    hulls.enumerate().map(read).collect()
}
