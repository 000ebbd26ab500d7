//! Makes the models in `assets/`: `cargo run --package hullwright-cli --example make_assets [FOLDER]`.
//!
//! Writes a GLB for each model and a picture of all of them, and prints the table that
//! `assets/README.md` holds. The same code gives the same bytes; the example's tests compare them
//! with the committed files.

mod blob;
mod glb;
mod household;
mod model;
mod nature;
mod scene;
mod shape;
mod simple;
#[cfg(test)]
mod tests;

use std::error::Error;
use std::path::PathBuf;

use hullwright::TriangleMesh;
use hullwright_cli::render::{Layout, Panel, Part, render_with};
use model::Model;

/// Panels per row and pixels per panel of the picture.
const COLUMNS: usize = 5;
const PANEL: [usize; 2] = [230, 210];

fn models() -> Vec<Model> {
    vec![
        household::mug(),
        household::chair(),
        household::table(),
        household::teapot(),
        household::lamp(),
        household::bowl(),
        nature::dog(),
        nature::leaf(),
        simple::torus(),
        simple::gear(),
        simple::spring(),
        simple::l_prism(),
        simple::u_prism(),
        simple::plus(),
        scene::props(),
    ]
}

/// The model's line in the table of `assets/README.md`.
fn table_row(model: &Model) -> String {
    let shape = model.flattened();
    let (min, max) = shape.bounds();
    let centimetres = [0, 1, 2].map(|axis| format!("{:.1}", 100.0 * (max[axis] - min[axis])));
    format!(
        "| `{}.glb` | {} | {} | {} | {} | {} |",
        model.name,
        shape.triangles.len(),
        shape.positions.len(),
        centimetres.join(" × "),
        if model.closed { "yes" } else { "no" },
        model.purpose,
    )
}

fn draw(models: &[Model]) -> Result<hullwright_cli::render::Picture, hullwright::Error> {
    let shapes: Vec<shape::Shape> = models.iter().map(Model::flattened).collect();
    let panel = |(model, shape): (&Model, _)| {
        let shape: &shape::Shape = shape;
        let part = |material: usize| {
            let triangles = shape.triangles.iter().zip(&shape.materials);
            let of_material = triangles.filter(|(_, other)| **other == material);
            Part {
                mesh: TriangleMesh::new(
                    shape.positions.clone(),
                    of_material.map(|(triangle, _)| *triangle).collect(),
                ),
                colour: model.materials[material].colour,
            }
        };
        Panel { parts: (0..model.materials.len()).map(part).collect(), explosion: 0.0 }
    };
    let panels: Vec<Panel> = models.iter().zip(&shapes).map(panel).collect();
    let mut layout = Layout::default();
    layout.columns = Some(COLUMNS);
    layout.separate_frames = true;
    let rows = panels.len().div_ceil(COLUMNS);
    render_with(&panels, PANEL[0] * COLUMNS, PANEL[1] * rows, &layout)
}

fn main() -> Result<(), Box<dyn Error>> {
    let bundled = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let folder = std::env::args_os().nth(1).map_or(bundled, PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let models = models();
    for model in &models {
        std::fs::write(folder.join(model.name).with_extension("glb"), glb::glb(model))?;
        println!("{}", table_row(model));
    }
    draw(&models)?.write_png(folder.join("models.png"))?;
    Ok(())
}
