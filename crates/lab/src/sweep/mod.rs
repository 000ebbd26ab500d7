//! `cargo lab sweep`: every mesh below folders, the same damaged, and random ones, and what became
//! of them.

mod changes;
mod corpora;
mod summary;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::harness::session::limits;
use crate::harness::{FULL, Judge, Row, Session, Status, Task, row};
use crate::report::{Report, create_folder, write};
use crate::terminal::{Failure, print};
use crate::tools::meshes::{self, Mesh};
use crate::tools::methods::Run;
use crate::tools::soup::{self, soup, to_obj};
use crate::tools::variations::Variation;

/// Decompose every mesh below folders, eleven damaged copies of each, and random ones, and count
/// what became of them
///
/// Each in a process with limits, on one thread. Hulls are judged by exact predicates in single
/// precision, the bound by a sampling that shares no code with the library. Can be stopped, and
/// goes on where it was.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(
        required_unless_present = "corpora",
        value_name = "DIR",
        help = meshes::folders_help()
    )]
    folders: Vec<PathBuf>,

    /// A folder with checkouts of public sets, such as Thingi10K: nothing of them is damaged. Where
    /// none is there, the message has the commands that bring them
    #[arg(long, value_name = "DIR")]
    corpora: Option<PathBuf>,

    /// How many meshes of each public set, evenly spread
    #[arg(long, value_name = "N", default_value_t = 2000)]
    most: usize,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// How many random meshes: soups, lattices, boxes, noisy spheres
    #[arg(long, value_name = "N", default_value_t = 4500)]
    random: u64,

    /// Leave out the damaged copies
    #[arg(long)]
    undamaged: bool,

    /// How many meshes at once
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64))]
    jobs: u16,

    /// Processor time above which a mesh is listed as slow, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0)]
    seconds: f64,

    /// Time on the wall after which a process is stopped, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
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

/// Fewer points than in the benchmark, since there are many meshes: shares of the volume are known
/// to about a hundredth.
const JUDGE: Judge = Judge {
    is_timed: false,
    surface_samples: 10_000,
    volume_samples: 20_000,
    by_brute_force: true,
    ..FULL
};

/// Of meshes that are damaged or random, of which there are most. Corners and middles come on top.
const QUICK_JUDGE: Judge = Judge { surface_samples: 2000, volume_samples: 2000, ..JUDGE };

/// Damaged copies of larger meshes would take most of the time, and show nothing that small ones do
/// not.
const MOST_DAMAGED: usize = 100_000;

/// The folder of random meshes in a report, and in the names of meshes.
const RANDOM: &str = "random";

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let limits = limits(arguments.stop_after, arguments.memory_limit)?;
    let before = arguments.compare.as_deref().map(row::from_csv).transpose()?;
    let mut session = Session::open(&arguments.output, limits)?;
    (session.only_reports, session.jobs) = (arguments.report_only, arguments.jobs.into());
    let run = Run::bounded(0.02);
    let meshes = match arguments.folders.is_empty() {
        true => Vec::new(),
        false => meshes::find(&arguments.folders)?,
    };
    let task = |_: &Mesh| vec![Task::new(run.clone(), JUDGE)];
    let mut rows = session.rows(&meshes, task)?;
    let corpora = arguments.corpora.as_deref().map(|dir| corpora::find(dir, arguments.most));
    let (corpora, of_corpora) = corpora.transpose()?.unwrap_or_default();
    rows.extend(session.rows(&of_corpora, task)?);
    if !arguments.undamaged {
        let damaged = damaged(&meshes, &rows);
        let task = |variation| Task { run: run.clone(), variation, judge: QUICK_JUDGE };
        rows.extend(session.rows(&damaged, |_| Variation::damages().map(task).to_vec())?);
    }
    let random = random(arguments.random, &arguments.output.join(RANDOM))?;
    rows.extend(session.rows(&random, |_| vec![Task::new(run.clone(), QUICK_JUDGE)])?);
    if rows.is_empty() {
        return Err("there is nothing to report".into());
    }
    write(&session.output.join("sweep.csv"), &row::to_csv(&rows)?)?;
    let seconds = arguments.seconds;
    let mut tables = summary::tables(&rows, seconds);
    if !corpora.is_empty() {
        tables.insert(0, corpora::table(&corpora, &rows));
    }
    tables.extend(before.map(|before| changes::table(&before, &rows, seconds)));
    let samples = |of: fn(&Row) -> Option<usize>| rows.iter().filter_map(of).sum::<usize>();
    let words = vec![
        format!(
            "{} meshes, each in a process of its own, with the default parameters, on one thread; those above \
             {MOST_DAMAGED} triangles are not damaged. Times are processor time of decomposing alone. A process \
             is stopped {} s after it last reported, or above {} MB.",
            rows.len(),
            limits.time.as_secs_f64(),
            limits.memory >> 20,
        ),
        format!(
            "A hull is sound if it is closed, convex and has volume, in single precision, as a physics engine gets it, \
             by exact predicates. A mesh is beyond the bound if more was verified than the bound, or more is found than \
             was verified: by samples with distances and winding numbers that share no code with the library's, hull \
             by hull, or by `measure`. Of {} samples, whether {} are inside was not decided in time.",
            samples(|row| row.samples),
            samples(|row| row.undecided_samples),
        ),
    ];
    for table in tables.iter().filter(|table| !table.rows.is_empty()) {
        print(&format!("\n{}", table.to_markdown()))?;
    }
    let (title, name) = ("Sweep", "sweep");
    Ok(session.report(Report { title, name, words, tables, ..Report::default() })?)
}

/// The meshes whose damaged copies say something.
fn damaged(meshes: &[Mesh], rows: &[Row]) -> Vec<Mesh> {
    let is_taken = |mesh: &&Mesh| {
        rows.iter().any(|row| {
            row.mesh == mesh.name
                && row.status == Status::Done
                && row.triangles.is_some_and(|count| count <= MOST_DAMAGED)
        })
    };
    meshes.iter().filter(is_taken).cloned().collect()
}

/// So many random meshes, as files.
fn random(count: u64, folder: &Path) -> Result<Vec<Mesh>, Failure> {
    create_folder(folder)?;
    let files: Vec<PathBuf> = (0..count)
        .into_par_iter()
        .map(|number| {
            let kind = soup::KINDS[number as usize % soup::KINDS.len()];
            let path = folder.join(format!("{number}_{}.obj", kind.replace(' ', "_")));
            write(&path, &to_obj(&soup(number)))?;
            Ok(path)
        })
        .collect::<Result<_, String>>()?;
    if files.is_empty() { Ok(Vec::new()) } else { Ok(meshes::find(&files)?) }
}
