//! `cargo lab sweep`: every mesh below folders, each in a process of its own, and what became of it.

mod changes;
mod row;
mod summary;
pub mod worker;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use hullwright_cli::terminal::{Failure, print, time};
use serde_json::json;

use row::Row;

use crate::report::html_report::{Report, create_folder, write};
use crate::runs::journal::{Entry, Journal};
use crate::runs::limits::{self, Limits};
use crate::runs::machine;
use crate::runs::meshes::{self, Mesh};
use crate::runs::methods::Run;
use crate::runs::record::Status;

/// Decompose every mesh below folders, each in a process with limits, and report what became of it
///
/// Hulls are judged by exact predicates in single precision, the bound by a dense sampling that shares no
/// code with the library. Can be stopped, and goes on where it was.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(required = true, value_name = "DIR", help = meshes::folders_help())]
    folders: Vec<PathBuf>,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// Processor time that decomposing may take, in seconds: more counts as a time-out
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0)]
    seconds: f64,

    /// Time on the wall after which a process is stopped, in seconds. Until then it goes on, so that the
    /// table says by how much a time-out was one
    #[arg(long, value_name = "SECONDS", default_value_t = 120.0)]
    stop_after: f64,

    /// Most memory of a process, in megabytes
    #[arg(long, value_name = "MB", default_value_t = 4096)]
    memory_limit: u64,

    /// The sweep.csv of an earlier run, to say what has changed
    #[arg(long, value_name = "CSV")]
    compare: Option<PathBuf>,

    /// Run nothing, only write the report of what is there
    #[arg(long)]
    report_only: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let time = Duration::try_from_secs_f64(arguments.stop_after)
        .map_err(|_| Failure::Usage("the time to stop after must be a time".into()))?;
    let limits = Limits { time, memory: arguments.memory_limit.saturating_mul(1 << 20) };
    let before = arguments.compare.as_deref().map(row::from_csv).transpose()?;
    let output = &arguments.output;
    create_folder(output)?;
    let mut journal = Journal::open(&output.join("runs.jsonl"))?;
    let meshes = meshes::find(&arguments.folders)?;
    let version = Run::Bounded { error: 0.02 }.version(&Default::default());
    let mut rows = Vec::new();
    for (number, mesh) in meshes.iter().enumerate() {
        let blank = Row::blank(mesh, &version);
        if journal.get(&blank.key()).is_none() && !arguments.report_only {
            let row = sweep(mesh, blank.clone(), limits)?;
            print(&progress(number + 1, meshes.len(), &row))?;
            journal.add(row)?;
        }
        rows.extend(journal.get(&blank.key()).cloned());
    }
    if rows.is_empty() {
        return Err("there is nothing to report".into());
    }
    Ok(report(arguments, limits, &rows, before.as_deref())?)
}

/// Runs one mesh, and says what became of it.
fn sweep(mesh: &Mesh, mut row: Row, limits: Limits) -> Result<Row, String> {
    let program = std::env::current_exe().map_err(|error| format!("this program: {error}"))?;
    let mut command = Command::new(program);
    command.arg("sweep-run").arg(&mesh.path);
    let ended = limits::run(command, limits)?;
    for line in &ended.lines {
        let line = serde_json::from_str(line).map_err(|error| format!("a worker said: {error}"))?;
        worker::take(line, &mut row);
    }
    // What it refuses it says itself, and ends well.
    match ended.status {
        Status::Done => {}
        status if row.hulls.is_none() => (row.status, row.reason) = (status, ended.reason),
        // It was decomposed, and a judge went wrong: that shows, but not as the method's failure.
        status => row.broken = format!("judge: {}: {}", status.name(), ended.reason),
    }
    Ok(row)
}

fn progress(number: usize, of: usize, row: &Row) -> String {
    let what = match (row.status, row.hulls, row.processor_seconds) {
        (Status::Done, Some(hulls), Some(seconds)) => {
            format!("{hulls:>4} hulls  {:>9}  {}", time(seconds), row.faults())
        }
        (status, ..) => format!("{}: {}", status.name(), row.reason),
    };
    format!("{number:>4}/{of}  {:<48} {what}", row.mesh)
}

fn report(
    arguments: &Arguments,
    limits: Limits,
    rows: &[Row],
    before: Option<&[Row]>,
) -> Result<(), String> {
    let output: &Path = &arguments.output;
    write(&output.join("sweep.csv"), &row::to_csv(rows)?)?;
    let seconds = arguments.seconds;
    let mut tables = summary::tables(rows, seconds);
    tables.extend(before.map(|before| changes::table(before, rows, seconds)));
    let words = vec![
        format!(
            "{} meshes, each in a process of its own, with the default parameters, on one thread. A \
             time-out is more than {seconds} s of processor time for decomposing, reading left out: \
             time on the wall depends on what else a machine does. A process is stopped after {} s \
             on the wall, or above {} MB.",
            rows.len(),
            limits.time.as_secs_f64(),
            limits.memory >> 20,
        ),
        "Hulls are judged as a physics engine gets them, in single precision, and by exact \
         predicates: closed, no vertex in front of any face by however little, and with volume. The \
         bound is judged by dense sampling with distances and winding numbers by brute force, which \
         share no code with the library's, hull by hull against what was verified of it; and again \
         by `measure`. Uncovered volume and IoU are those of `measure`."
            .into(),
    ];
    let mut machine = machine::describe(limits);
    machine.insert("processor_seconds_of_a_time_out".into(), json!(seconds));
    let report = Report {
        title: "Sweep",
        words,
        machine: &machine,
        plots: &[],
        tables: &tables,
        pages: &[],
    };
    report.write(output, "sweep")
}
