//! `hullwright inspect`: what a mesh holds, without decomposing it, or a file of hulls.

use std::path::PathBuf;

use hullwright::hulls_format::{HullScene, HullsFile};
use hullwright_cli::terminal::{Failure, count, print};
use hullwright_formats::{is_hulls_file, read_mesh};

use crate::arguments::{SolidArguments, is_scene_file, mesh_help};
use crate::notes;
use crate::progress::waiting;

/// Show counts, bounds, components, open and non-manifold edges, and what would be repaired
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = format!("{}; or a .hulls or .hullscene file", mesh_help()))]
    mesh: PathBuf,

    #[command(flatten)]
    solid: SolidArguments,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = &arguments.mesh;
    if is_hulls_file(path) || is_scene_file(path) {
        arguments.solid.refuse(&format!("{} holds hulls, not a mesh", path.display()))?;
        return print(&match is_scene_file(path) {
            true => HullScene::read(path)?.to_string(),
            false => HullsFile::read(path)?.to_string(),
        });
    }
    let parameters = arguments.solid.parameters()?;
    let file = waiting("reading", || read_mesh(path))?;
    let found = waiting("inspecting", || hullwright::inspect::inspect_with(&file, &parameters))
        .map_err(|error| format!("{}: {error}", path.display()))?;
    let objects = count(file.objects.len(), "object", "objects");
    let mut lines = vec![format!("{}: {objects}", path.display())];
    lines.extend(notes::lines(&file.notes));
    lines.push(found.to_string());
    print(&lines.join("\n"))
}
