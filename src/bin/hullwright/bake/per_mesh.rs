//! `hullwright bake --per-mesh`: each mesh into a `.hulls` file of its own.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use hullwright::io::{NamedMesh, read_own_meshes};
use hullwright::{Control, Method};

use super::{Arguments, Source, output_of, report};
use crate::hulls::{DEFAULT_DENSITY, hulls_file, wrote};
use crate::output::Failure;
use crate::progress::LateBar;

/// A file name longer than this is refused by some file systems, suffix and number included.
const LONGEST_NAME: usize = 200;

struct Job<'a> {
    source: &'a Path,
    mesh: NamedMesh,
    output: PathBuf,
}

pub fn run(arguments: &Arguments, sources: &[Source], method: &Method) -> Result<(), Failure> {
    let density = arguments.density.unwrap_or(DEFAULT_DENSITY);
    if !(density.is_finite() && density > 0.0) {
        return Err(Failure::Usage(format!("the density must be positive, not {density}")));
    }
    let pool = arguments.threads.pool()?;
    let jobs = jobs(arguments, sources)?;
    let bar = LateBar::start();
    let mut lines = Vec::new();
    let mut failures = Vec::new();
    for (index, job) in jobs.iter().enumerate() {
        let control = bar.control_of_part(index, jobs.len());
        let control = control.with_parallel(arguments.threads.is_parallel());
        match pool.install(|| bake(job, density, method, &control)) {
            Ok(line) => lines.push(line),
            Err(reason) => {
                let Job { source, mesh, .. } = job;
                failures.push(format!("{}, mesh `{}`: {reason}", source.display(), mesh.name));
            }
        }
    }
    bar.finish();
    report(&lines, failures)
}

/// Reads all files, so that a misspelt name ends the work before it begins.
fn jobs<'a>(arguments: &Arguments, sources: &'a [Source]) -> Result<Vec<Job<'a>>, Failure> {
    let mut names = HashSet::new();
    let mut jobs = Vec::new();
    for source in sources {
        let meshes = read_own_meshes(&source.path)?;
        if meshes.is_empty() {
            return Err(format!("{}: it holds no triangles", source.path.display()).into());
        }
        for mesh in meshes {
            let name = unique(&file_name(&mesh.name), &mut names);
            let output = output_of(arguments, source, &format!("{name}.hulls"));
            jobs.push(Job { source: &source.path, mesh, output });
        }
    }
    Ok(jobs)
}

fn bake(job: &Job<'_>, density: f64, method: &Method, control: &Control) -> Result<String, String> {
    let NamedMesh { name, mesh } = &job.mesh;
    let decomposition = method.decompose(mesh, control).map_err(|error| error.to_string())?;
    let file = hulls_file(name.as_str(), mesh.view(), &decomposition, &method.solid(), density)
        .map_err(|error| error.to_string())?;
    super::make_directory(&job.output)?;
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
