//! `hullwright bake`: scenes and meshes into files that a game loads instead of decomposing.

mod per_mesh;
mod scenes;

use std::path::{Path, PathBuf};

use hullwright::io::Format;

use crate::arguments::{ParameterArguments, ThreadArguments};
use crate::output::{Failure, print, print_error};

/// Bake scenes into .hullscene files: the hulls of every mesh with error bound and mass properties
///
/// One file per scene, named after it: each mesh in the space that it was modelled in (no node's transform is
/// applied), all its primitives together, known by its content. Names and extras are followed as the Bevy
/// plugin's `ConvexDecompositionHierarchy` follows them. What an earlier file holds of the same content and
/// parameters is kept. Of a folder, all glTF and GLB files in it and below it.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = format!("The scenes: {}, or folders", Format::suffix_list()), required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,

    /// The directory that gets the files; it is made if it does not exist. Default: beside each scene
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// A .hulls file for each mesh, named after it, instead of one file per scene. Names and extras count
    /// for nothing
    #[arg(long)]
    per_mesh: bool,

    /// Only what an artist's name or extra asks for, as `ConvexDecompositionHierarchy::tagged_only`
    #[arg(long, conflicts_with = "per_mesh")]
    tagged_only: bool,

    /// Mass per cubed unit; in a scene the plugin's tags say it. Default: 1
    #[arg(long, value_name = "DENSITY", requires = "per_mesh", allow_negative_numbers = true)]
    density: Option<f64>,

    #[command(flatten)]
    threads: ThreadArguments,

    #[command(flatten)]
    parameters: ParameterArguments,
}

/// A file to be baked.
struct Source {
    path: PathBuf,
    /// From the folder that was named to the one that the file is in.
    below: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let method = arguments.parameters.checked()?.method;
    let mut sources = Vec::new();
    for path in &arguments.scenes {
        if path.is_dir() {
            let before = sources.len();
            add_folder(path, Path::new(""), &mut sources)?;
            if sources.len() == before {
                return Err(
                    format!("{}: there is no glTF or GLB file in it", path.display()).into()
                );
            }
        } else {
            sources.push(Source { path: path.clone(), below: PathBuf::new() });
        }
    }
    if arguments.per_mesh {
        per_mesh::run(arguments, &sources, &method)
    } else {
        scenes::run(arguments, &sources, &method)
    }
}

/// In the order of names, so that the same folder gives the same lines everywhere.
fn add_folder(folder: &Path, below: &Path, sources: &mut Vec<Source>) -> Result<(), Failure> {
    let failure = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(failure)?;
    let mut paths =
        entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, _>>().map_err(failure)?;
    paths.sort();
    for path in paths {
        // A link to a folder above would never end.
        if path.is_dir() && !path.is_symlink() {
            let name = path.file_name().unwrap_or_default();
            add_folder(&path, &below.join(name), sources)?;
        } else if Format::from_path(&path) == Some(Format::Gltf) {
            sources.push(Source { path, below: below.to_owned() });
        }
    }
    Ok(())
}

/// Where a file made of a source goes: beside it, or into the directory that was named, where folders
/// keep their structure.
fn output_of(arguments: &Arguments, source: &Source, name: &str) -> PathBuf {
    match &arguments.output {
        Some(directory) => directory.join(&source.below).join(name),
        None => source.path.with_file_name(name),
    }
}

fn make_directory(output: &Path) -> Result<(), String> {
    let Some(directory) = output.parent() else { return Ok(()) };
    std::fs::create_dir_all(directory).map_err(|error| format!("{}: {error}", directory.display()))
}

/// Lines to standard output, then failures: all but the last here, the last as the program's own error.
fn report(lines: &[String], mut failures: Vec<String>) -> Result<(), Failure> {
    if !lines.is_empty() {
        print(&lines.join("\n"))?;
    }
    let last = failures.pop();
    failures.iter().for_each(|reason| print_error(reason));
    last.map_or(Ok(()), |reason| Err(Failure::Work(reason)))
}
