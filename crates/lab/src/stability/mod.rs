//! `cargo lab stability`: the same meshes disturbed in many ways and sizes (see [`Variation`]), and
//! what becomes of hulls, error and time.

mod curves;
mod tables;

use std::path::PathBuf;

use self::tables::{Rows, breaks_promise, wrong};
use crate::harness::session::limits;
use crate::harness::{FULL, Judge, Session, Status, Task};
use crate::report::Report;
use crate::terminal::Failure;
use crate::tools::meshes;
use crate::tools::methods::Run;
use crate::tools::variations::Variation;

/// Decompose meshes that are turned, scaled, moved, mirrored, jittered, shuffled, doubled, cut into
/// slivers or given a second wall, and report how much the result varies with the size of that
///
/// Takes meshes evenly from those below the folders. Can be stopped and goes on where it was.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folders with meshes
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// How many meshes
    #[arg(long, value_name = "N", default_value_t = 60)]
    meshes: usize,

    /// The methods, by name, separated by commas: bounded, surface
    #[arg(long, value_name = "METHODS", value_delimiter = ',', default_value = "bounded")]
    only: Vec<String>,
}

/// Longest time of a variation in seconds, several times that of the slowest mesh, and most memory
/// in megabytes, as in the benchmark.
const LIMITS: (f64, u64) = (120.0, 4096);

/// Fewer points than in the benchmark, since there are many runs: shares of the volume are known to
/// about a hundredth.
const JUDGE: Judge =
    Judge { is_timed: false, surface_samples: 20_000, volume_samples: 20_000, ..FULL };

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let session = Session::open(&arguments.output, limits(LIMITS.0, LIMITS.1)?)?;
    let meshes = meshes::spread(meshes::find(&arguments.folders)?, arguments.meshes);
    let mut runs = [Run::bounded(0.02), Run::Surface].to_vec();
    runs.retain(|run| arguments.only.iter().any(|name| name == run.method()));
    let variations = Variation::all();
    let task = |run: &Run, variation| Task { run: run.clone(), variation, judge: JUDGE };
    let tasks: Vec<Task> = runs
        .iter()
        .flat_map(|run| variations.iter().map(|&variation| task(run, variation)))
        .collect();
    let rows = session.rows(&meshes, |_| tasks.clone())?;
    let failures = rows.iter().filter(|row| row.status != Status::Done).count();
    let broken = rows.iter().filter(|row| breaks_promise(row)).count();
    let names: Vec<&str> = meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    let words = vec![
        format!(
            "{} runs: {} meshes, taken evenly from the list of all, in {} variations each. \
             Failures: {failures}. Broken promises: {broken}.",
            rows.len(),
            meshes.len(),
            variations.len(),
        ),
        format!("The meshes: {}.", names.join(", ")),
        "Hulls are measured against the mesh that was given, disturbed as it is.".into(),
    ];
    let all = Rows::new(&rows);
    let mut tables: Vec<_> = runs.iter().map(|run| all.spread(run.method())).collect();
    tables.extend(Some(wrong(&rows)).filter(|table| !table.rows.is_empty()));
    let plots = runs.first().map_or(Ok(Vec::new()), |run| all.plots(run.method()))?;
    let (title, name) = ("Numerical stability", "stability");
    Ok(session.report(Report { title, name, words, plots, tables, ..Report::default() })?)
}
