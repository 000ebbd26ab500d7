//! What is to be run: every mesh × every method × every setting.

use crate::runs::external_tools::ExternalTools;
use crate::runs::meshes::Mesh;
use crate::runs::methods::Run;

/// How many meshes `--quick` takes, at least one of each folder: with about a second for each of its
/// runs it stays below two minutes.
pub const QUICK_MESHES: usize = 12;

/// The runs for a mesh, those of `only` (methods by name; empty for all).
pub fn runs(mesh: &Mesh, quick: bool, tools: Option<&ExternalTools>, only: &[String]) -> Vec<Run> {
    let mut runs = if quick { Run::quick() } else { Run::own() };
    if !quick && let Some(tools) = tools {
        runs.extend(tools.runs(&mesh.name));
    }
    runs.retain(|run| only.is_empty() || only.iter().any(|method| method == run.method()));
    runs
}
