//! `cargo lab paper`: the paper's Table 1, on the meshes that its triangle counts name.

use std::path::PathBuf;

use crate::harness::row::Figure;
use crate::harness::session::limits;
use crate::harness::{FULL, Row, Session, Task};
use crate::report::{Report, Table, count, number, number_or_nothing};
use crate::statistics::{mean, median, range};
use crate::terminal::Failure;
use crate::tools::data_folder::DataFolder;
use crate::tools::meshes::{self, Mesh};
use crate::tools::methods::Run;

/// Repeat the paper's Table 1, and its method on all Princeton meshes
///
/// Can be stopped, and goes on where it was.
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with paper/table1.tsv and meshes/princeton
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// Longest time of one run, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0)]
    time_limit: f64,
}

/// Most memory of a run, in megabytes: as in the benchmark.
const MEMORY_LIMIT: u64 = 4096;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = DataFolder(arguments.folder.clone());
    let table1 = folder.table1()?;
    let princeton = meshes::find(&[folder.mesh("princeton")])?;
    let session = Session::open(&arguments.output, limits(arguments.time_limit, MEMORY_LIMIT)?)?;
    let task = || Task::new(Run::Surface, FULL);

    let header = [
        "model",
        "whose",
        "pieces",
        "average pieces",
        "seconds",
        "cost",
        "p",
        "r",
        "polygons",
        "initial polygons",
    ];
    let note = "The paper's rows beside ours on the same meshes.";
    let mut ten = Table::new("Table 1", note, &header);
    for paper in table1 {
        let theirs = [paper.pieces as f64, paper.average_pieces, paper.seconds, paper.cost];
        let rest = [paper.p, paper.r as f64, paper.polygons as f64, paper.initial_polygons as f64];
        let theirs = theirs.into_iter().chain(rest).map(|value| value.to_string());
        ten.rows.push([paper.name(), "paper".into()].into_iter().chain(theirs).collect());
        let Some(mesh) = meshes::find(&[folder.mesh(&paper.mesh)])?.into_iter().next() else {
            continue;
        };
        let mesh = Mesh { name: paper.mesh.clone(), ..mesh };
        let row = session.row((1, 1), &mesh, &task())?;
        let Some(row) = row.filter(Row::is_done) else { continue };
        let detail = |name| number_or_nothing(row.details.get(name).copied());
        ten.rows.push(vec![
            paper.name(),
            "here".into(),
            count(row.hulls),
            detail("average_pieces"),
            number_or_nothing(row.seconds),
            number_or_nothing(row.cost),
            detail("planar_threshold"),
            detail("resolution"),
            detail("polygons"),
            detail("initial_polygons"),
        ]);
    }

    let all = session.rows(&princeton, |_| vec![task()])?;
    let note = format!("The paper's method on {} Princeton meshes.", all.len());
    let header = ["what", "least", "median", "mean", "most"];
    let mut table = Table::new("Table 1 over all Princeton meshes", &note, &header);
    let figures: [Figure; 4] = [
        ("pieces", |row| Some(row.hulls? as f64)),
        ("average pieces", |row| row.details.get("average_pieces").copied()),
        ("seconds", |row| row.seconds),
        ("cost", |row| row.cost),
    ];
    for (name, figure) in figures {
        let values: Vec<f64> = all.iter().filter_map(figure).collect();
        let (least, most) = range(values.iter().copied());
        let row = [least, median(values.clone()), mean(&values), most].map(number);
        table.rows.push([name.to_owned()].into_iter().chain(row).collect());
    }
    let words = vec![
        "Times are of one thread, in seconds, without reading files. Costs are averages of the \
         paper's equation (3)."
            .into(),
    ];
    let (title, name, tables) = ("The paper's experiments", "paper-experiments", vec![ten, table]);
    Ok(session.report(Report { title, name, words, tables, ..Report::default() })?)
}
