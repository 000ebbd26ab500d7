//! `cargo lab floor`: how far decomposing is from what any method must do.

use std::path::PathBuf;
use std::time::Instant;

use hullwright::{Control, Parameters, TriangleMesh, decompose};
use hullwright_formats::read_mesh;
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};

use crate::report::{Table, number};
use crate::shapes::uv_sphere;
use crate::terminal::{Failure, print};

/// Compare the time of decomposing with a floor: welding, building a tree, and one search for the
/// closest point from each vertex of the hulls
///
/// The floor is Parry's code in single precision, on one thread as decomposing is. Of several runs
/// the quickest counts.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = crate::tools::meshes::files_help(), value_name = "MESH")]
    meshes: Vec<PathBuf>,

    /// Also a sphere with bumps of about so many triangles
    #[arg(long, value_name = "TRIANGLES")]
    sphere: Option<u32>,
}

/// Noise only ever adds.
const RUNS: usize = 5;

/// Waves around the sphere, and their height: it is not convex, and takes some hulls.
const BUMPS: (f64, f64) = (6.0, 0.15);

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut meshes: Vec<(String, TriangleMesh)> = Vec::new();
    for path in &arguments.meshes {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        meshes.push((name, read_mesh(path)?.mesh));
    }
    meshes.extend(arguments.sphere.map(|count| ("sphere with bumps".to_owned(), bumpy(count))));
    if meshes.is_empty() {
        return Err(Failure::Usage("a mesh or --sphere is needed".into()));
    }
    let header = ["mesh", "triangles", "hulls", "decomposing, ms", "floor, ms", "multiple"];
    let mut table = Table::new("Time over the floor", "", &header);
    for (name, mesh) in meshes {
        let control = Control::new().with_parallel(false);
        let (seconds, found) = quickest(|| decompose(&mesh, &Parameters::default(), &control));
        let found = found?;
        let points = found.hulls.iter().flat_map(|hull| hull.shape.points.iter().map(vector));
        let points: Vec<Vector> = points.collect();
        let (floor, _) = quickest(|| floor(&mesh, &points));
        table.rows.push(vec![
            name,
            mesh.triangles.len().to_string(),
            found.hulls.len().to_string(),
            number(1e3 * seconds),
            number(1e3 * floor),
            number(seconds / floor),
        ]);
    }
    print(&table.to_markdown())
}

fn vector(&[x, y, z]: &[f64; 3]) -> Vector {
    Vector::new(x as f32, y as f32, z as f32)
}

/// The sum of all distances, so that none can be left out.
fn floor(mesh: &TriangleMesh, points: &[Vector]) -> Option<f32> {
    let vertices = mesh.positions.iter().map(vector).collect();
    let flags = TriMeshFlags::MERGE_DUPLICATE_VERTICES;
    let tree = TriMesh::with_flags(vertices, mesh.triangles.clone(), flags).ok()?;
    let distance = |&point| tree.project_local_point(point, false).point.distance(point);
    Some(points.iter().map(distance).sum())
}

fn quickest<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let start = Instant::now();
        let result = work();
        (start.elapsed().as_secs_f64(), result)
    };
    let mut best = timed();
    for _ in 1..RUNS {
        let next = timed();
        if next.0 < best.0 {
            best = next;
        }
    }
    best
}

fn bumpy(triangles: u32) -> TriangleMesh {
    let mut mesh = uv_sphere((f64::from(triangles) / 2.0).sqrt().ceil() as u32, 1.0);
    for point in &mut mesh.positions {
        let [x, y, z] = point.map(|x| (BUMPS.0 * x).sin());
        let factor = 1.0 + BUMPS.1 * x * y * z;
        *point = point.map(|x| x * factor);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_floor_finds_the_distances_and_the_sphere_is_as_large_as_asked_for() {
        let mesh = bumpy(1000);
        assert!((900..1200).contains(&mesh.triangles.len()));
        let far = [Vector::new(3.0, 0.0, 0.0), Vector::new(0.0, 4.0, 0.0)];
        let sum = floor(&mesh, &far).unwrap();
        assert!((sum - 5.0).abs() < 0.05, "{sum}");
    }
}
