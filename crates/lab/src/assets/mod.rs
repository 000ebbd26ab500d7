//! `cargo lab assets`: the models in `assets/`, from formulas and a few measures.
//!
//! The same code gives the same bytes; tests compare them with the committed files.

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

use std::path::PathBuf;

use hullwright::TriangleMesh;

use crate::pictures;
use crate::render::{Layout, Panel, Part};
use crate::terminal::{Failure, print};
use model::Model;

/// Make the bundled models and their picture, and print the table that assets/README.md holds
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder that they go to
    #[arg(default_value = "assets")]
    folder: PathBuf,
}

/// Panels per row and pixels per panel of the picture.
const COLUMNS: usize = 5;
const PANEL: (usize, usize) = (230, 210);

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

/// The model in the colours of its materials.
fn panel(model: &Model) -> Panel {
    let shape = model.flattened();
    let part = |material: usize| {
        let triangles = shape.triangles.iter().zip(&shape.materials);
        let of_material = triangles.filter(|(_, other)| **other == material);
        Part {
            mesh: TriangleMesh::new(
                shape.positions.iter().map(|place| place.to_array()).collect(),
                of_material.map(|(triangle, _)| *triangle).collect(),
            ),
            colour: model.materials[material].colour,
        }
    };
    Panel { parts: (0..model.materials.len()).map(part).collect(), explosion: 0.0 }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    let models = models();
    for model in &models {
        let path = folder.join(model.name).with_extension("glb");
        std::fs::write(&path, glb::glb(model)).map_err(|e| format!("{}: {e}", path.display()))?;
        print(&table_row(model))?;
    }
    let panels: Vec<Panel> = models.iter().map(panel).collect();
    let rows = panels.chunks(COLUMNS).map(<[Panel]>::to_vec).collect();
    pictures::write(&folder.join("models.png"), rows, PANEL, Layout::default().view.elevation)
}
