//! `hullwright decompose`: a mesh into convex hulls.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::{HullFormat, MeshFile, check_output, is_hulls_file, read_mesh, write_hulls};
use hullwright::{Decomposition, Method, MethodReport};

use crate::arguments::{ParameterArguments, ThreadArguments, mesh_help};
use crate::hulls::{DEFAULT_DENSITY, hulls_file, wrote};
use crate::json::DecompositionLine;
use crate::output::{Failure, print, print_json};
use crate::progress::{LateBar, waiting};
use crate::tables;

/// Decompose a mesh into convex hulls
///
/// Prints hulls, vertices, time, the bound, the protrusion at most (how far hulls reach outside of the
/// solid) and the uncovered distance at most (how far the surface reaches outside of the hulls). With --method surface, a row like those of the paper's Table 1: pieces, their average number
/// over all resolutions (k), time, cost, planar threshold (p), maximum resolution (r), and polygon
/// counts after and before simplification.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = mesh_help())]
    mesh: PathBuf,

    /// Write the hulls to this file: .obj (one object per hull), .glb (one colour per hull) or
    /// .hulls (for a game, see `bake`)
    #[arg(short, long, value_name = "OUT", value_parser = parse_output)]
    output: Option<PathBuf>,

    /// Print one line of JSON instead of a table
    #[arg(long)]
    json: bool,

    /// Show the whole search: every resolution and threshold, and what became of it
    #[arg(long)]
    search: bool,

    #[command(flatten)]
    threads: ThreadArguments,

    #[command(flatten)]
    parameters: ParameterArguments,
}

fn parse_output(text: &str) -> Result<PathBuf, String> {
    if HullFormat::from_path(text).is_some() || is_hulls_file(text) {
        Ok(PathBuf::from(text))
    } else {
        Err(format!("hulls are written as {}, or as .hulls", HullFormat::suffix_list()))
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let method = arguments.parameters.checked()?.method;
    if let Some(output) = &arguments.output {
        check_output(output)?;
    }
    let file = waiting("reading", || read_mesh(&arguments.mesh))?;
    let (decomposition, seconds) = decompose(arguments, &file, &method)?;
    if let Some(output) = &arguments.output {
        write(output, arguments, &file, &decomposition, &method)?;
    }
    if arguments.json {
        let Arguments { mesh, search, .. } = arguments;
        return print_json(&DecompositionLine::new(mesh, &decomposition, seconds, *search));
    }
    if arguments.search {
        print(&tables::search(&decomposition.report))?;
    }
    print(&tables::summary(&decomposition, seconds))?;
    match &arguments.output {
        Some(output) => print(&wrote(output, &decomposition.hulls)),
        None => Ok(()),
    }
}

/// The decomposition, and its wall-clock time in seconds.
fn decompose(
    arguments: &Arguments,
    file: &MeshFile,
    method: &Method,
) -> Result<(Decomposition<MethodReport>, f64), Failure> {
    let pool = arguments.threads.pool()?;
    let bar = LateBar::start();
    let control = bar.control().with_parallel(arguments.threads.is_parallel());
    let start = Instant::now();
    let result = pool.install(|| method.decompose(file, &control));
    let seconds = start.elapsed().as_secs_f64();
    bar.finish();
    let decomposition = result.map_err(|error| format!("{}: {error}", arguments.mesh.display()))?;
    Ok((decomposition, seconds))
}

fn write(
    output: &Path,
    arguments: &Arguments,
    file: &MeshFile,
    decomposition: &Decomposition<MethodReport>,
    method: &Method,
) -> Result<(), Failure> {
    if !is_hulls_file(output) {
        return Ok(waiting("writing", || write_hulls(output, &decomposition.hulls))?);
    }
    let name = arguments.mesh.file_stem().unwrap_or_default().to_string_lossy();
    let file = hulls_file(name, file.into(), decomposition, &method.solid(), DEFAULT_DENSITY)?;
    Ok(file.write(output)?)
}
