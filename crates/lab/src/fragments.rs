//! `cargo lab pictures fragments`: meshes broken apart, and what their fragments add up to.

use std::collections::HashMap;
use std::path::PathBuf;
use std::time::Instant;

use glam::DVec3;
use hullwright::{Control, Fragment, Parameters, TriangleMesh, break_apart, decompose};
use hullwright_formats::{palette, read_mesh};

use crate::render::{Panel, Part};
use crate::shapes::middle;
use crate::terminal::{Failure, print};

/// How far fragments are moved from the middle of all, as a multiple of their distance.
const APART: f64 = 0.45;

/// Of each mesh a row of panels, it, its hulls and its fragments, with what closes their cuts in
/// red; prints a row of numbers for each.
pub fn rows(meshes: &[PathBuf]) -> Result<Vec<Vec<Panel>>, Failure> {
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
    Ok(rows)
}

fn exploded(mesh: &TriangleMesh, fragments: &[Fragment]) -> Panel {
    let whole = middle(&mesh.positions);
    let mut parts = Vec::new();
    for (index, fragment) in fragments.iter().enumerate() {
        let away = APART * (middle(&surface(fragment).positions) - whole);
        let moved = |mut mesh: TriangleMesh| {
            for point in &mut mesh.positions {
                *point = (DVec3::from(*point) + away).to_array();
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

fn corners(mesh: &TriangleMesh) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    let corner = |at: u32| DVec3::from(mesh.positions[at as usize]);
    mesh.triangles.iter().map(move |triangle| triangle.map(corner))
}

fn area(mesh: &TriangleMesh) -> f64 {
    corners(mesh).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

fn volume(mesh: &TriangleMesh) -> f64 {
    corners(mesh).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
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
