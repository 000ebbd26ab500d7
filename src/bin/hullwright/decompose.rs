//! `hullwright decompose`: a mesh into convex hulls.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::{HullFormat, MeshFile, check_output, is_hulls_file, read_mesh, write_hulls};
use hullwright::{Decomposition, Error, Parameters};

use crate::arguments::ParameterArguments;
use crate::bake::{DEFAULT_DENSITY, baked};
use crate::output::{count, print};
use crate::progress::{LateBar, waiting};
use crate::{Failure, json, tables};

/// Decompose a mesh into convex hulls
///
/// Prints hulls, vertices, time, the bound, and how far hulls stand out and the surface sinks in at
/// most. With --method surface, a row like those of the paper's Table 1: pieces, their average number
/// over all resolutions (k), time, cost, planar threshold (p), maximum resolution (r), and polygon
/// counts after and before simplification.
#[derive(clap::Args)]
pub struct Arguments {
    /// The mesh: obj, off, ply, stl, gltf or glb
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

    /// Number of threads; 1 does everything one after the other. Default: all processors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,

    #[command(flatten)]
    parameters: ParameterArguments,
}

/// More threads than any machine has, and few enough to be started.
pub const MOST_THREADS: i64 = 1024;

fn parse_output(text: &str) -> Result<PathBuf, String> {
    if HullFormat::from_path(text).is_some() || is_hulls_file(text) {
        Ok(PathBuf::from(text))
    } else {
        Err("hulls are written as .obj, .glb or .hulls".into())
    }
}

/// What the outputs are made from.
pub struct Outcome<'a> {
    pub arguments: &'a Arguments,
    pub decomposition: &'a Decomposition,
    /// Wall-clock time of the decomposition, without reading and writing.
    pub seconds: f64,
}

impl Outcome<'_> {
    pub fn mesh(&self) -> String {
        self.arguments.mesh.display().to_string()
    }

    pub fn shows_search(&self) -> bool {
        self.arguments.search
    }

    pub fn vertices(&self) -> usize {
        self.decomposition.hulls.iter().map(|hull| hull.shape.points.len()).sum()
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let parameters = arguments.parameters.parameters();
    parameters.validate().map_err(|error| Failure::Usage(error.to_string()))?;
    if let Some(output) = &arguments.output {
        check_output(output).map_err(|error| Failure::Work(error.to_string()))?;
    }
    let file = waiting("reading", || read_mesh(&arguments.mesh))
        .map_err(|error| Failure::Work(error.to_string()))?;
    let (decomposition, seconds) = decompose(arguments, &file, &parameters)?;
    if let Some(output) = &arguments.output {
        write(output, arguments, &file, &decomposition)?;
    }

    let outcome = Outcome { arguments, decomposition: &decomposition, seconds };
    if arguments.json {
        return print(&json::line(&outcome));
    }
    if arguments.search {
        print(&tables::search(&outcome))?;
    }
    print(&tables::summary(&outcome))?;
    if let Some(output) = &arguments.output {
        let hulls = count(decomposition.hulls.len(), "hull", "hulls");
        let vertices = count(outcome.vertices(), "vertex", "vertices");
        print(&format!("wrote {}: {hulls}, {vertices}", output.display()))?;
    }
    Ok(())
}

fn write(
    output: &Path,
    arguments: &Arguments,
    file: &MeshFile,
    decomposition: &Decomposition,
) -> Result<(), Failure> {
    if !is_hulls_file(output) {
        return waiting("writing", || write_hulls(output, &decomposition.hulls))
            .map_err(|error| Failure::Work(error.to_string()));
    }
    let name = arguments.mesh.file_stem().unwrap_or_default().to_string_lossy();
    baked(name, file.into(), decomposition, DEFAULT_DENSITY)
        .and_then(|baked| baked.write(output).map_err(|error| error.to_string()))
        .map_err(Failure::Work)
}

/// A pool of a number of threads, or of as many as there are processors.
pub fn pool(threads: Option<u16>) -> Result<rayon::ThreadPool, Failure> {
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = threads {
        pool = pool.num_threads(usize::from(threads));
    }
    pool.build().map_err(|error| Failure::Work(format!("the threads can't be started: {error}")))
}

fn decompose(
    arguments: &Arguments,
    file: &MeshFile,
    parameters: &Parameters,
) -> Result<(Decomposition, f64), Failure> {
    let pool = pool(arguments.threads)?;
    let bar = LateBar::start();
    let control = bar.control();
    let start = Instant::now();
    let result = pool.install(|| hullwright::decompose(file, parameters, &control));
    let seconds = start.elapsed().as_secs_f64();
    bar.finish();

    let decomposition = result
        .map_err(|error: Error| Failure::Work(format!("{}: {error}", arguments.mesh.display())))?;
    Ok((decomposition, seconds))
}
