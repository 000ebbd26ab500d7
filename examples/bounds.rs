//! Draws what a bound means, a row each for a mug, a building and a terrain: the mesh and its hulls within
//! three bounds, moved apart: `cargo run --release --package hullwright-cli --example bounds -- OUT.png`.

use std::error::Error;

use hullwright::io::read_mesh;
use hullwright::{Control, Length, Parameters, TriangleMesh, decompose};
use hullwright_cli::render::{Layout, Panel, render_with};

/// Size of a panel in pixels.
const PANEL: (usize, usize) = (300, 230);

/// How far hulls move away from the centre, as a share of their distance.
const EXPLOSION: f64 = 0.25;

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).ok_or("usage: bounds OUT.png")?;
    let mug = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/mug.glb");
    let (five, two, one) = (Length::share(0.05), Length::share(0.02), Length::share(0.01));
    let rows = [
        ("mug", read_mesh(mug)?.mesh, [five, two, one]),
        ("building", building(), [five, two, Length::units(0.05)]),
        ("terrain", terrain(), [five, two, one]),
    ];
    let mut panels = Vec::new();
    for (name, mesh, bounds) in rows {
        panels.push(Panel::mesh(&mesh));
        for bound in bounds {
            let parameters = Parameters::default().max_error(bound);
            let hulls = decompose(&mesh, &parameters, &Control::new())?.hulls;
            println!("{name} within {bound}: {} hulls", hulls.len());
            panels.push(Panel::hulls(&hulls).exploded(EXPLOSION));
        }
    }
    let mut layout = Layout::default();
    layout.columns = Some(4);
    layout.separate_frames = true;
    render_with(&panels, 4 * PANEL.0, 3 * PANEL.1, &layout)?.write_png(&output)?;
    println!("wrote {output}");
    Ok(())
}

/// A bungalow of two rooms, 8 by 6 metres, with walls of 20 cm and doors of 1 by 2 metres, in metres. The
/// roof is left out, so that one sees the rooms.
fn building() -> TriangleMesh {
    let walls = [
        ([0.0, -0.2, 0.0], [8.0, 0.0, 6.0]),
        ([0.0, 0.0, 0.0], [8.0, 2.6, 0.2]),
        ([0.0, 0.0, 0.2], [0.2, 2.6, 5.8]),
        ([7.8, 0.0, 0.2], [8.0, 2.6, 5.8]),
        // The front, with a door.
        ([0.0, 0.0, 5.8], [2.0, 2.6, 6.0]),
        ([3.0, 0.0, 5.8], [8.0, 2.6, 6.0]),
        ([2.0, 2.0, 5.8], [3.0, 2.6, 6.0]),
        // Between the rooms, with a door.
        ([4.9, 0.0, 0.2], [5.1, 2.6, 3.0]),
        ([4.9, 0.0, 4.0], [5.1, 2.6, 5.8]),
        ([4.9, 2.0, 3.0], [5.1, 2.6, 4.0]),
    ];
    let mut mesh = TriangleMesh::new(Vec::new(), Vec::new());
    for (low, high) in walls {
        add_box(&mut mesh, low, high);
    }
    mesh
}

fn add_box(mesh: &mut TriangleMesh, low: [f64; 3], high: [f64; 3]) {
    let first = mesh.positions.len() as u32;
    let side = |corner: usize, axis: usize| match corner >> axis & 1 {
        0 => low[axis],
        _ => high[axis],
    };
    mesh.positions.extend((0..8).map(|corner| [side(corner, 0), side(corner, 1), side(corner, 2)]));
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for [a, b, c, d] in quads.map(|quad: [u32; 4]| quad.map(|corner| first + corner)) {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
}

/// Hills of 100 by 100 metres, a sheet without an underside, in metres.
fn terrain() -> TriangleMesh {
    const SIDE: u32 = 28;
    const STEP: f64 = 100.0 / (SIDE - 1) as f64;
    let place = |i: u32| {
        let (x, z) = (f64::from(i % SIDE) * STEP, f64::from(i / SIDE) * STEP);
        let height = 9.0 * (x / 15.0).sin() * (z / 19.0).cos() + 3.0 * (x / 5.0 + z / 7.0).sin();
        [x, height, z]
    };
    let squares = (0..SIDE - 1).flat_map(|z| (0..SIDE - 1).map(move |x| z * SIDE + x));
    let triangles = squares.flat_map(|a| {
        let (b, c, d) = (a + SIDE, a + 1, a + SIDE + 1);
        [[a, b, c], [c, b, d]]
    });
    TriangleMesh::new((0..SIDE * SIDE).map(place).collect(), triangles.collect())
}
