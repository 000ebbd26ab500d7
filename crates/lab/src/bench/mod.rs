//! `cargo lab bench`: every mesh × every method × a sweep of each method's own setting, every run in
//! a process of its own, one at a time; then tables, curves and plots.

mod curves;
mod export;
mod pages;
mod plan;
mod plots;
mod summary;

use hullwright_cli::terminal::{Failure, print, time};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use summary::Results;

use crate::report::html_report::{self, PageLink, Report};
use crate::runs::data_folder::DataFolder;
use crate::runs::execute::{blank_row, execute};
use crate::runs::external_tools::ExternalTools;
use crate::runs::journal::{Entry, Journal};
use crate::runs::limits::Limits;
use crate::runs::machine;
use crate::runs::meshes::{self, Mesh};
use crate::runs::record::{Row, Status};

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

    /// A folder with tools/peers.py and peers/results.tsv, for CoACD and V-HACD 4
    #[arg(long, value_name = "DIR")]
    external_tools: Option<PathBuf>,

    /// The Python that has the packages coacd, vhacdx and trimesh
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,

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

    /// Copy the small plots into this folder too, under the names of the large ones: docs/pictures for
    /// the README
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,

    /// Write a page for each mesh of the folders too, with ours and V-HACD's hulls side by side
    #[arg(long, requires = "folders")]
    pages: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let time = Duration::try_from_secs_f64(arguments.time_limit)
        .map_err(|_| Failure::Usage("the time limit must be a time".into()))?;
    let limits = Limits { time, memory: arguments.memory_limit.saturating_mul(1 << 20) };
    let output = &arguments.output;
    html_report::create_folder(output)?;
    let mut journal = Journal::open(&output.join("runs.jsonl"))?;
    if !arguments.report_only {
        let mut meshes = meshes::find(&arguments.folders)?;
        if arguments.quick {
            meshes = meshes::spread_over_folders(meshes, plan::QUICK_MESHES);
        }
        let folder = arguments.external_tools.clone().map(DataFolder);
        let tools = folder.map(|folder| ExternalTools::new(folder, &arguments.python));
        for missing in tools.iter().flat_map(ExternalTools::missing) {
            eprintln!("{missing}: its runs are left out");
        }
        let start = Instant::now();
        let before = recorded_machine(output);
        // Before the work too: it may be stopped.
        record(output, &before, arguments, limits, 0.0)?;
        work(arguments, &meshes, tools.as_ref(), limits, &mut journal)?;
        let seconds = start.elapsed().as_secs_f64();
        record(output, &before, arguments, limits, seconds)?;
    }
    let links = match arguments.pages {
        true => pages::write(output, &benched(&arguments.folders, journal.rows())?)?,
        false => Vec::new(),
    };
    Ok(report(output, journal.rows(), &links, arguments.pictures.as_deref())?)
}

/// The meshes below the folders that the journal has a run of.
fn benched(folders: &[PathBuf], rows: &[Row]) -> Result<Vec<Mesh>, String> {
    let names: BTreeSet<&str> = rows.iter().map(|row| row.mesh.as_str()).collect();
    let mut meshes = meshes::find(folders)?;
    meshes.retain(|mesh| names.contains(mesh.name.as_str()));
    Ok(meshes)
}

/// The file that says on what machine the runs were done, and how long they all took.
const MACHINE: &str = "machine.json";
const SECONDS: &str = "seconds_of_the_whole_benchmark";
/// What each session ran, in words: methods, limits, version and time may differ between them.
const SESSIONS: &str = "sessions";

/// Writes what is known of this machine and session, and of the sessions `before`, where the
/// benchmark was stopped and went on.
fn record(
    output: &Path,
    before: &BTreeMap<String, Value>,
    arguments: &Arguments,
    limits: Limits,
    seconds: f64,
) -> Result<(), String> {
    let mut machine = machine::describe(limits);
    let earlier = before.get(SECONDS).and_then(Value::as_f64).unwrap_or(0.0);
    machine.insert(SECONDS.into(), json!((earlier + seconds).round()));
    let mut sessions: Vec<String> =
        before.get(SESSIONS).and_then(Value::as_str).map(str::to_owned).into_iter().collect();
    let methods =
        if arguments.only.is_empty() { "all".to_owned() } else { arguments.only.join(", ") };
    sessions.push(format!(
        "{methods}: algorithm version {}, limit of {} s, {seconds:.0} s",
        hullwright::ALGORITHM_VERSION,
        limits.time.as_secs_f64(),
    ));
    machine.insert(SESSIONS.into(), json!(sessions.join("; ")));
    let text = serde_json::to_string_pretty(&machine).unwrap_or_default();
    html_report::write(&output.join(MACHINE), &text)
}

/// What is known of the sessions before; nothing at the first.
fn recorded_machine(output: &Path) -> BTreeMap<String, Value> {
    let text = std::fs::read_to_string(output.join(MACHINE)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Writes the report of what the journal holds, and copies its small plots.
fn report(
    output: &Path,
    rows: &[Row],
    pages: &[PageLink],
    pictures: Option<&Path>,
) -> Result<(), String> {
    let results = Results::new(rows);
    if results.rows.is_empty() {
        return Err("there is nothing to report".into());
    }
    let mut machine = recorded_machine(output);
    let versions: BTreeSet<&str> = results.rows.iter().map(|row| row.version.as_str()).collect();
    machine.insert("versions".into(), json!(Vec::from_iter(versions).join("; ")));
    let meshes: BTreeSet<&str> = results.rows.iter().map(|row| row.mesh.as_str()).collect();
    let folders: BTreeSet<&str> = meshes.iter().map(|mesh| meshes::folder(mesh)).collect();
    let words = vec![
        format!(
            "{} runs on {} meshes ({}), each in a process of its own, one at a time, with limits on \
             time and memory. All hulls are judged by the same `measure`. Lengths are shares of \
             the mesh's bounding-box diagonal; Hausdorff is the error that curves are drawn by.",
            results.rows.len(),
            meshes.len(),
            Vec::from_iter(folders).join(", ")
        ),
        "Seconds are the median of up to three repeats on one thread, reading and writing left \
         out. CoACD and V-HACD 4 choose their threads themselves. Rows `coacd-files` are hull \
         files that were computed on another machine, and so are their times. The memory is the \
         peak of the process while it decomposes, mesh included. The cost is the paper's, for \
         methods that group a surface."
            .into(),
    ];
    let plots = plots::plots(&results)?;
    if let Some(pictures) = pictures {
        html_report::create_folder(pictures)?;
        for plot in plots.iter().filter(|plot| plot.is_extra) {
            html_report::write(&pictures.join(plot.file.replace("-small", "")), &plot.svg)?;
        }
    }
    let tables = results.tables();
    html_report::write(&output.join("runs.csv"), &export::csv(&results)?)?;
    html_report::write(&output.join("versus.csv"), &export::versus_csv(&results)?)?;
    let title = "Time against error";
    let report = Report { title, words, machine: &machine, plots: &plots, tables: &tables, pages };
    report.write(output, "benchmark")
}

/// Runs what is not in the journal yet.
fn work(
    arguments: &Arguments,
    meshes: &[Mesh],
    tools: Option<&ExternalTools>,
    limits: Limits,
    journal: &mut Journal<Row>,
) -> Result<(), Failure> {
    let versions = tools.map_or_else(Default::default, |tools| tools.versions.clone());
    for (number, mesh) in meshes.iter().enumerate() {
        let runs = plan::runs(mesh, arguments.quick, tools, &arguments.only);
        for run in runs {
            let mut row = blank_row(mesh, &run, run.version(&versions));
            let before = journal.get(&row.key());
            if before.is_some_and(|row| row.status == Status::Done || !arguments.retry) {
                continue;
            }
            let scratch = arguments.output.join("external-hulls.obj");
            execute(&run, mesh, tools, limits, &scratch, &mut row)?;
            print(&progress(number + 1, meshes.len(), &row))?;
            journal.add(row)?;
        }
    }
    Ok(())
}

fn progress(number: usize, of: usize, row: &Row) -> String {
    let Row { mesh, method, setting, .. } = row;
    let what = match row.done() {
        Some((worked, judged)) => format!(
            "{:>4} hulls  error {:.4}  {}",
            judged.hulls,
            judged.hausdorff,
            time(worked.seconds)
        ),
        None => format!("{}: {}", row.status.name(), row.reason),
    };
    format!("{number:>3}/{of}  {mesh:<40} {method:<8} {setting:<32} {what}")
}
