//! `cargo lab bench`: every mesh × every method × a sweep of each method's own setting; then
//! tables, curves and plots.

mod curves;
mod elsewhere;
mod plot;
mod summary;
mod worst_cases;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use serde_json::json;

use summary::Results;

use crate::harness::session::limits;
use crate::harness::{FULL, Judge, Session, Task, row};
use crate::report::{Report, write};
use crate::terminal::Failure;
use crate::tools::data_folder::{DataFolder, ToolResult};
use crate::tools::meshes;
use crate::tools::methods::Run;

/// Compare methods on every mesh below folders: time against error
///
/// Runs are kept in REPORT/runs.jsonl as they end; a run that is there is not repeated, so that a
/// benchmark that was stopped goes on where it was. Then the report is written anew.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(
        help = meshes::folders_help(),
        required_unless_present = "report_only",
        value_name = "DIR"
    )]
    folders: Vec<PathBuf>,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// Twelve meshes, at least one of each folder, and the methods surface, bounded and V-HACD
    #[arg(long)]
    quick: bool,

    /// Only these methods, by name, separated by commas
    #[arg(long, value_name = "METHODS", value_delimiter = ',')]
    only: Vec<String>,

    /// A folder with peers/results.tsv and cuacd.tsv, and hulls in peers/coacd and cuacd, to judge
    /// them too
    #[arg(long, value_name = "DIR")]
    external_tools: Option<PathBuf>,

    /// Judge protrusion where a ball of this radius comes, and fill the rest: a fraction of the
    /// diagonal. Into a report of its own
    #[arg(long, value_name = "RADIUS")]
    probe_radius: Option<f64>,

    /// Longest time of a run, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0)]
    time_limit: f64,

    /// Most memory of a run, in megabytes
    #[arg(long, value_name = "MB", default_value_t = 4096)]
    memory_limit: u64,

    /// Repeat runs that ended in an error, a crash or at a limit
    #[arg(long)]
    retry: bool,

    /// Run nothing, only write the report of what is in REPORT/runs.jsonl, with its plots
    #[arg(long)]
    report_only: bool,
}

/// How many meshes `--quick` takes, at least one of each folder: with about a second for each of
/// its runs it stays below two minutes.
const QUICK_MESHES: usize = 12;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let limits = limits(arguments.time_limit, arguments.memory_limit)?;
    let folder = arguments.external_tools.clone().map(DataFolder).filter(|_| !arguments.quick);
    let files = folder.as_ref().map_or_else(|| Ok(BTreeMap::new()), DataFolder::file_runs)?;
    let mut session = Session::open(&arguments.output, limits)?;
    session.retries = arguments.retry;
    if !arguments.report_only {
        let mut meshes = meshes::find(&arguments.folders)?;
        if arguments.quick {
            meshes = meshes::spread_over_folders(meshes, QUICK_MESHES);
        }
        session.rows(&meshes, |mesh| {
            tasks(arguments, files.get(&mesh.name).map_or(&[], Vec::as_slice))
        })?;
    }
    let beside = folder.map_or_else(|| Ok(Vec::new()), |folder| folder.beside_cuacd())?;
    Ok(report(&session, &beside)?)
}

/// Every setting of the requested methods.
fn tasks(arguments: &Arguments, files: &[Run]) -> Vec<Task> {
    let mut runs = if arguments.quick { Run::quick() } else { Run::own() };
    runs.extend_from_slice(files);
    let only = &arguments.only;
    runs.retain(|run| only.is_empty() || only.iter().any(|method| method == run.method()));
    let judge = Judge { probe_radius: arguments.probe_radius, ..FULL };
    let task = |run: Run| {
        let verifies = Run::is_default(run.method(), &run.setting());
        Task::new(run, Judge { verifies, ..judge })
    };
    runs.into_iter().map(task).collect()
}

/// Writes the report of what the journal holds.
fn report(session: &Session, beside_cuacd: &[ToolResult]) -> Result<(), String> {
    let rows = session.journal();
    let results = Results::new(&rows);
    if results.rows.is_empty() {
        return Err("there is nothing to report".into());
    }
    let meshes = results.meshes();
    let folders: BTreeSet<&str> = meshes.iter().map(|mesh| meshes::folder(mesh)).collect();
    let versions: BTreeSet<&str> = results.rows.iter().map(|row| row.version.as_str()).collect();
    let words = vec![
        format!(
            "{} runs on {} meshes ({}) of {}, each in a process of its own, one at a time, with limits on \
             time and memory. All hulls are judged by the same `measure`. Lengths are fractions of \
             the mesh's bounding-box diagonal; Hausdorff is the error that curves are drawn by.",
            results.rows.len(),
            meshes.len(),
            Vec::from_iter(folders).join(", "),
            Vec::from_iter(versions).join("; "),
        ),
        "Seconds are the median of up to three repeats on one thread, reading and writing left \
         out. Rows `coacd-files` and `cuacd-files` are hull files that were computed on another \
         machine, on as many threads as CoACD chose and on an H100, and so are their times. The memory is the peak of the process \
         while it decomposes, mesh included. The cost is the paper's, for methods that group a \
         surface."
            .into(),
    ];
    let plots = vec![plot::plot(&results)?];
    write(&session.output.join("runs.csv"), &row::to_csv(&results.rows)?)?;
    write(&session.output.join("versus.csv"), &versus_csv(&results)?)?;
    let mut tables = results.tables();
    tables.push(worst_cases::table(&results));
    tables.extend(elsewhere::table(beside_cuacd));
    let (title, name) = ("Time against error", "benchmark");
    session.report(Report { title, name, words, plots, tables, ..Report::default() })
}

/// Wins and losses mesh by mesh: our hulls over another method's at equal error, our error over
/// its at equal hulls; empty where the curves don't meet.
fn versus_csv(results: &Results<'_>) -> Result<String, String> {
    let (name, versus) = results.versus();
    let rows: Vec<_> = versus
        .into_iter()
        .map(|(mesh, method, found)| {
            json!({
                "mesh": mesh,
                "other method": method,
                format!("{name} hulls over theirs"): found.hulls,
                format!("{name} error over theirs"): found.error,
            })
        })
        .collect();
    row::to_csv(&rows)
}
