//! `cargo lab pictures fragments`: meshes broken apart, and what their fragments add up to.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::{Control, Fragment, Parameters, TriangleMesh, break_apart, decompose};
use hullwright_formats::{palette, read_mesh};

use crate::pictures;
use crate::render::{Layout, Panel, Part};
use crate::terminal::{Failure, print};

/// How far fragments are moved from the middle of all, as a multiple of their distance.
const APART: f64 = 0.45;

const PANEL: (usize, usize) = (310, 270);

/// Draws each mesh, its hulls and its fragments, with what closes their cuts in red, and prints a row
/// of numbers for each.
pub fn draw(output: &Path, meshes: &[PathBuf]) -> Result<(), Failure> {
    print(
        "| mesh | hulls | fragments | area | volume | open edges, of the mesh and of fragments | time |",
    )?;
    print("|---|---|---|---|---|---|---|")?;
    let mut rows = Vec::new();
    for path in meshes {
        let mesh = read_mesh(path)?.mesh;
        let (control, name) = (Control::new(), path.file_stem().unwrap_or_default());
        let hulls = decompose(&mesh, &Parameters::default(), &control)?.hulls;
        let each_alone: Vec<u32> = (0..hulls.len() as u32).collect();
        let start = Instant::now();
        let fragments = break_apart(&mesh, &hulls, &each_alone, &control)?;
        let time = start.elapsed();
        let area_of = |fragment: &Fragment| area(&surface(fragment));
        let outer: f64 = fragments.iter().map(area_of).sum();
        let enclosed: f64 = fragments.iter().map(|fragment| fragment.volume).sum();
        print(&format!(
            "| {} | {} | {} | {:.5} | {:.5} | {}, {} | {:.1} ms |",
            name.display(),
            hulls.len(),
            fragments.len(),
            outer / area(&mesh),
            enclosed / volume(&mesh).abs(),
            open_edges(&mesh),
            fragments.iter().map(|fragment| open_edges(&whole(fragment))).sum::<usize>(),
            time.as_secs_f64() * 1e3,
        ))?;
        rows.push(vec![
            Panel::mesh(&mesh),
            Panel::hulls(&hulls).exploded(APART),
            exploded(&mesh, &fragments),
        ]);
    }
    pictures::write(output, rows, PANEL, Layout::default().view.elevation)
}

fn exploded(mesh: &TriangleMesh, fragments: &[Fragment]) -> Panel {
    let middle = middle(&mesh.positions);
    let mut parts = Vec::new();
    for (index, fragment) in fragments.iter().enumerate() {
        let own = self::middle(&surface(fragment).positions);
        let away = [0, 1, 2].map(|axis| APART * (own[axis] - middle[axis]));
        let moved = |mut mesh: TriangleMesh| {
            for point in &mut mesh.positions {
                *point = [0, 1, 2].map(|axis| point[axis] + away[axis]);
            }
            mesh
        };
        let colour = palette::colour(index);
        parts.push(Part { mesh: moved(surface(fragment)), colour });
        parts.push(Part { mesh: moved(fragment.cut_faces.clone()), colour: palette::CAP });
    }
    Panel { parts, explosion: 0.0 }
}

fn surface(fragment: &Fragment) -> TriangleMesh {
    let positions = fragment.vertices.iter().map(|vertex| vertex.position).collect();
    TriangleMesh::new(positions, fragment.triangles.clone())
}

/// Surface and cuts as one mesh.
fn whole(fragment: &Fragment) -> TriangleMesh {
    let mut mesh = surface(fragment);
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(&fragment.cut_faces.positions);
    let cuts = fragment.cut_faces.triangles.iter().map(|triangle| triangle.map(|at| at + first));
    mesh.triangles.extend(cuts);
    mesh
}

fn middle(points: &[[f64; 3]]) -> [f64; 3] {
    let sum = points.iter().fold([0.0; 3], |sum: [f64; 3], point| {
        [sum[0] + point[0], sum[1] + point[1], sum[2] + point[2]]
    });
    sum.map(|x| x / points.len().max(1) as f64)
}

fn corners(mesh: &TriangleMesh) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
    mesh.triangles.iter().map(|triangle| triangle.map(|at| mesh.positions[at as usize]))
}

fn cross([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|end| [0, 1, 2].map(|axis| end[axis] - a[axis]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn area(mesh: &TriangleMesh) -> f64 {
    corners(mesh).map(cross).map(|normal| dot(normal, normal).sqrt() / 2.0).sum()
}

fn volume(mesh: &TriangleMesh) -> f64 {
    corners(mesh).map(|of| dot(of[0], cross(of)) / 6.0).sum()
}

/// Edges with more triangles on one side than on the other, where vertices at one place in single
/// precision are one.
fn open_edges(mesh: &TriangleMesh) -> usize {
    let place = |at: u32| mesh.positions[at as usize].map(|x| (x as f32 + 0.0).to_bits());
    let mut counts: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(place);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *counts.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    counts.iter().filter(|([a, b], count)| a != b && **count != 0).count()
}
