//! `cargo lab sweep` and `corpus`: every mesh below folders, and what became of it.

mod changes;
mod summary;

use std::path::PathBuf;

use crate::harness::session::limits;
use crate::harness::{FULL, Judge, Session, Task, row};
use crate::report::Table;
use crate::report::{Report, write};
use crate::terminal::{Failure, print};
use crate::tools::meshes;
use crate::tools::methods::Run;

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

/// Fewer points than in the benchmark, since there are many meshes: shares of the volume are known to about a
/// hundredth.
const JUDGE: Judge = Judge {
    is_timed: false,
    surface_samples: 10_000,
    volume_samples: 20_000,
    by_brute_force: true,
    probe_radius: None,
};

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let limits = limits(arguments.stop_after, arguments.memory_limit)?;
    let before = arguments.compare.as_deref().map(row::from_csv).transpose()?;
    let mut session = Session::open(&arguments.output, limits)?;
    session.only_reports = arguments.report_only;
    let meshes = meshes::find(&arguments.folders)?;
    let rows = session.rows(&meshes, |_| vec![Task::new(Run::bounded(0.02), JUDGE)])?;
    if rows.is_empty() {
        return Err("there is nothing to report".into());
    }
    write(&session.output.join("sweep.csv"), &row::to_csv(&rows)?)?;
    let seconds = arguments.seconds;
    let mut tables = summary::tables(&rows, seconds);
    tables.extend(before.map(|before| changes::table(&before, &rows, seconds)));
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
    let (title, name) = ("Sweep", "sweep");
    Ok(session.report(Report { title, name, words, tables, ..Report::default() })?)
}

/// Decompose every mesh below a folder and count broken promises
///
/// A promise is broken where more was verified than was asked for, or more is sampled than was
/// verified. As `sweep`, without brute force, and nothing is kept.
#[derive(clap::Args)]
pub struct CorpusArguments {
    /// A folder that holds meshes
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Longest time, and most memory, of a mesh.
const CORPUS_LIMITS: (f64, u64) = (300.0, 8192);

pub fn corpus(arguments: &CorpusArguments) -> Result<(), Failure> {
    let mut session = Session::temporary(limits(CORPUS_LIMITS.0, CORPUS_LIMITS.1)?)?;
    let meshes = meshes::find(std::slice::from_ref(&arguments.folder))?;
    let judge = Judge { is_timed: false, ..FULL };
    let rows = session.rows(&meshes, |_| vec![Task::new(Run::bounded(0.02), judge)])?;
    let tables = summary::tables(&rows, CORPUS_LIMITS.0);
    let is_short = |table: &&Table| !table.rows.is_empty();
    let text: String =
        tables.iter().take(CORPUS_TABLES).filter(is_short).map(Table::to_markdown).collect();
    print(&format!("\n{text}"))
}

/// Outcomes, tails, refusals, and what went wrong.
const CORPUS_TABLES: usize = 4;
