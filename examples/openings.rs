//! Draws what becomes of openings, a row for each mesh: the mesh with its caps in red, the hulls with all
//! openings kept, and those with openings closed, moved apart:
//! `cargo run --release --package hullwright-cli --example openings -- OUT.png MESH…`.

use std::error::Error;
use std::path::Path;

use hullwright::io::read_mesh;
use hullwright::{Control, Openings, Parameters, close_openings, decompose};
use hullwright_cli::render::{Layout, Panel, render_with};

/// Size of a panel in pixels.
const PANEL: (usize, usize) = (460, 340);

/// How far hulls move away from the centre, as a share of their distance.
const EXPLOSION: f64 = 0.4;

/// From below, where openings are.
const ELEVATION: f64 = -25.0;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let Some(output) = arguments.next() else {
        return Err("usage: openings OUT.png MESH…".into());
    };
    let control = Control::new();
    let (auto, keep) = (Parameters::default(), Parameters::default().openings(Openings::Keep));
    let mut panels = Vec::new();
    for path in arguments {
        let file = read_mesh(&path)?;
        let closed = close_openings(&file, &auto, &control)?;
        let [before, after] =
            [decompose(&file, &keep, &control)?, decompose(&file, &auto, &control)?];
        let name = Path::new(&path).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        println!(
            "{name}: {} hulls, {} with openings closed",
            before.hulls.len(),
            after.hulls.len()
        );
        panels.push(Panel::closed_mesh(&closed));
        panels.push(Panel::hulls(&before.hulls).exploded(EXPLOSION));
        panels.push(Panel::hulls(&after.hulls).exploded(EXPLOSION));
    }
    let mut layout = Layout::default();
    layout.columns = Some(3);
    layout.separate_frames = true;
    layout.view.elevation = ELEVATION;
    let rows = panels.len().div_ceil(3);
    render_with(&panels, 3 * PANEL.0, rows * PANEL.1, &layout)?.write_png(&output)?;
    println!("wrote {output}");
    Ok(())
}
