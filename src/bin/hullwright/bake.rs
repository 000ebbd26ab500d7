//! `hullwright bake`: meshes into `.hulls` files, which a game loads instead of decomposing.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use hullwright::io::{Format, NamedMesh, read_own_meshes};
use hullwright::{Control, Parameters};

use crate::arguments::{ParameterArguments, ThreadArguments};
use crate::hulls::{DEFAULT_DENSITY, hulls_file, wrote};
use crate::output::{Failure, print, print_error};
use crate::progress::LateBar;

/// Bake meshes into .hulls files: hulls, error bound and mass properties, ready to load
///
/// Each mesh of a glTF or GLB file gets a file of its own, named after the mesh and in the space
/// that it was modelled in (no node's transform is applied), all its primitives together. A file of
/// another format is one mesh, named after the file.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = format!("The meshes: {}", Format::suffix_list()), required = true, value_name = "MESH")]
    meshes: Vec<PathBuf>,

    /// The directory that gets the .hulls files; it is made if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Mass per cubed unit
    #[arg(long, value_name = "DENSITY", default_value_t = DEFAULT_DENSITY, allow_negative_numbers = true)]
    density: f64,

    #[command(flatten)]
    threads: ThreadArguments,

    #[command(flatten)]
    parameters: ParameterArguments,
}

/// A file name longer than this is refused by some file systems, suffix and number included.
const LONGEST_NAME: usize = 200;

struct Job<'a> {
    source: &'a Path,
    mesh: NamedMesh,
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let parameters = arguments.parameters.checked()?;
    if !(arguments.density.is_finite() && arguments.density > 0.0) {
        let reason = format!("the density must be positive, not {}", arguments.density);
        return Err(Failure::Usage(reason));
    }
    let pool = arguments.threads.pool()?;
    let jobs = jobs(arguments)?;
    std::fs::create_dir_all(&arguments.output)
        .map_err(|error| format!("{}: {error}", arguments.output.display()))?;

    let bar = LateBar::start();
    let mut lines = Vec::new();
    let mut failures = Vec::new();
    for (index, job) in jobs.iter().enumerate() {
        let control = bar.control_of_part(index, jobs.len());
        let control = control.with_parallel(arguments.threads.is_parallel());
        match pool.install(|| bake(job, arguments.density, &parameters, &control)) {
            Ok(line) => lines.push(line),
            Err(reason) => {
                let Job { source, mesh, .. } = job;
                failures.push(format!("{}, mesh `{}`: {reason}", source.display(), mesh.name));
            }
        }
    }
    bar.finish();
    if !lines.is_empty() {
        print(&lines.join("\n"))?;
    }
    // All but the last here, the last as the program's own error.
    let last = failures.pop();
    failures.iter().for_each(|reason| print_error(reason));
    last.map_or(Ok(()), |reason| Err(Failure::Work(reason)))
}

/// Reads all files, so that a misspelt name ends the work before it begins.
fn jobs(arguments: &Arguments) -> Result<Vec<Job<'_>>, Failure> {
    let mut names = HashSet::new();
    let mut jobs = Vec::new();
    for source in &arguments.meshes {
        let meshes = read_own_meshes(source)?;
        if meshes.is_empty() {
            return Err(format!("{}: it holds no triangles", source.display()).into());
        }
        for mesh in meshes {
            let name = unique(&file_name(&mesh.name), &mut names);
            let output = arguments.output.join(format!("{name}.hulls"));
            jobs.push(Job { source, mesh, output });
        }
    }
    Ok(jobs)
}

fn bake(
    job: &Job<'_>,
    density: f64,
    parameters: &Parameters,
    control: &Control,
) -> Result<String, String> {
    let NamedMesh { name, mesh } = &job.mesh;
    let decomposition =
        hullwright::decompose(mesh, parameters, control).map_err(|error| error.to_string())?;
    let file = hulls_file(name.as_str(), mesh.view(), &decomposition, parameters, density)
        .map_err(|error| error.to_string())?;
    file.write(&job.output).map_err(|error| error.to_string())?;
    Ok(wrote(&job.output, &file.hulls))
}

/// The name with what any file system may object to replaced.
fn file_name(name: &str) -> String {
    let is_harmless = |c: char| c.is_alphanumeric() || "-_. ()+".contains(c);
    let mut harmless = String::new();
    for c in name.chars() {
        let c = if is_harmless(c) { c } else { '_' };
        if harmless.len() + c.len_utf8() > LONGEST_NAME {
            break;
        }
        harmless.push(c);
    }
    let harmless = harmless.trim_matches([' ', '.']);
    if harmless.is_empty() { "mesh".into() } else { harmless.into() }
}

/// The name, with a number after it if it is taken. Upper and lower case are one to some file
/// systems.
fn unique(name: &str, taken: &mut HashSet<String>) -> String {
    let mut candidate = name.to_owned();
    let mut number = 1;
    while !taken.insert(candidate.to_lowercase()) {
        number += 1;
        candidate = format!("{name}_{number}");
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_harmless() {
        for (name, expected) in [
            ("Mug.001", "Mug.001"),
            ("../up/and\\away", "_up_and_away"),
            ("", "mesh"),
            ("..", "mesh"),
            ("Стул: 3?", "Стул_ 3_"),
        ] {
            assert_eq!(file_name(name), expected);
        }
        assert!(file_name(&"x".repeat(1000)).len() <= LONGEST_NAME);
    }

    #[test]
    fn names_are_used_once() {
        let mut taken = HashSet::new();
        let names = ["Cube", "cube", "Cube_2", "Cube"].map(|name| unique(name, &mut taken));
        assert_eq!(names, ["Cube", "cube_2", "Cube_2_2", "Cube_3"]);
    }
}
