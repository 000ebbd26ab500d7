//! `cargo lab paper`: the paper's Table 1, on the meshes that its triangle counts name, and its comparison with
//! HACD (section 4.3.1).

use std::path::PathBuf;

use crate::harness::row::Figure;
use crate::harness::session::limits;
use crate::harness::{FULL, Row, Session, Task};
use crate::report::Report;
use crate::report::{Table, count, number, number_or_nothing};
use crate::statistics::{mean, median, range};
use crate::terminal::Failure;
use crate::tools::data_folder::{DataFolder, PaperRow};
use crate::tools::meshes::{self, Mesh};
use crate::tools::methods::Run;

/// Repeat the paper's Table 1 and its comparison with HACD
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

    /// Run HACD only on every so manyth of the Princeton meshes
    #[arg(long, value_name = "N", default_value_t = 1)]
    every: usize,

    /// Longest time of one run, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0)]
    time_limit: f64,
}

/// Most memory of a run, in megabytes: as in the benchmark.
const MEMORY_LIMIT: u64 = 4096;

/// β, which the paper doesn't give: around its ε.
const THRESHOLDS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// What is run, each in a process of its own.
struct Experiments {
    session: Session<'static>,
    folder: DataFolder,
    table1: Vec<PaperRow>,
    princeton: Vec<Mesh>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = DataFolder(arguments.folder.clone());
    let table1 = folder.table1()?;
    let princeton = meshes::find(&[folder.mesh("princeton")])?;
    let limits = limits(arguments.time_limit, MEMORY_LIMIT)?;
    let session = Session::open(&arguments.output, limits)?;
    let mut all = Experiments { session, folder, table1, princeton };
    let count = (all.princeton.len() / arguments.every.max(1)).max(1);
    let mut tables = all.table1()?;
    tables.push(all.hacd(count)?);
    let words = vec![
        "Times are of one thread, in seconds, without reading files. Costs are averages of the \
         paper's equation (3)."
            .into(),
    ];
    let (title, name) = ("The paper's experiments", "paper-experiments");
    Ok(all.session.report(Report { title, name, words, tables, ..Report::default() })?)
}

impl Experiments {
    /// The row of a run that was done.
    fn row(&mut self, name: &str, run: Run) -> Result<Option<Row>, Failure> {
        let found = meshes::find(&[self.folder.mesh(name)])?.into_iter().next();
        let Some(mesh) = found else { return Ok(None) };
        let mesh = Mesh { name: name.to_owned(), ..mesh };
        let row = self.session.row((1, 1), &mesh, &Task::new(run, FULL))?;
        Ok(row.filter(Row::is_done))
    }

    /// Table 1 on its own ten meshes, and the method over all Princeton meshes.
    fn table1(&mut self) -> Result<Vec<Table>, Failure> {
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
        for paper in self.table1.clone() {
            let theirs = [paper.pieces as f64, paper.average_pieces, paper.seconds, paper.cost];
            let rest = [paper.p, paper.r as f64, paper.polygons as f64];
            let theirs = theirs.into_iter().chain(rest).chain([paper.initial_polygons as f64]);
            let names = [paper.name(), "paper".into()].into_iter();
            ten.rows.push(names.chain(theirs.map(|value| value.to_string())).collect());
            let Some(row) = self.row(&paper.mesh, Run::Surface)? else { continue };
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
        let tasks = |_: &Mesh| vec![Task::new(Run::Surface, FULL)];
        let all = self.session.rows(&self.princeton, tasks)?;
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
        Ok(vec![ten, table])
    }

    /// Cost, time, resolution and pieces of the paper's method and of HACD, on so many meshes.
    fn hacd(&mut self, meshes: usize) -> Result<Table, Failure> {
        let meshes = meshes::spread(self.princeton.clone(), meshes);
        let header = [
            "beta",
            "meshes",
            "over the limit",
            "surface: cost",
            "hacd: cost",
            "surface costs less",
            "surface: seconds",
            "hacd: seconds",
            "surface is faster",
            "surface: r",
            "hacd: r",
            "hacd's r is smaller",
            "surface: pieces",
            "hacd: pieces",
            "hacd has fewer",
        ];
        let note = "Medians over Princeton meshes, and on what share of them a claim of the paper \
                    holds: its method has the lower cost and takes less time in each case, HACD has \
                    smaller resolutions and fewer pieces in some cases. β is not given in the paper, so \
                    it is swept; the unit of α is the average diagonal of a triangle.";
        let mut table = Table::new("4.3.1: HACD", note, &header);
        let figures: [fn(&Row) -> Option<f64>; 4] = [
            |row| row.cost,
            |row| row.seconds,
            |row| row.details.get("resolution").copied(),
            |row| Some(row.hulls? as f64),
        ];
        for threshold in THRESHOLDS {
            let tasks = |_: &Mesh| {
                [Run::Surface, Run::Hacd { threshold }].map(|run| Task::new(run, FULL)).to_vec()
            };
            let rows = self.session.rows(&meshes, tasks)?;
            let pairs: Vec<(&Row, &Row)> = rows
                .chunks_exact(2)
                .map(|pair| (&pair[0], &pair[1]))
                .filter(|(ours, theirs)| ours.is_done() && theirs.is_done())
                .collect();
            let over_limit = meshes.len() - pairs.len();
            let counts = [pairs.len(), over_limit].map(|count| count.to_string());
            let mut cells: Vec<String> =
                [threshold.to_string()].into_iter().chain(counts).collect();
            for (place, figure) in figures.into_iter().enumerate() {
                let both: Vec<(f64, f64)> = pairs
                    .iter()
                    .filter_map(|(ours, theirs)| figure(ours).zip(figure(theirs)))
                    .collect();
                // The paper claims lower cost and time for its own, and less of the rest for HACD.
                let holds = |(ours, theirs): &&(f64, f64)| {
                    if place < 2 { ours < theirs } else { theirs < ours }
                };
                let share =
                    100.0 * both.iter().filter(holds).count() as f64 / both.len().max(1) as f64;
                cells.push(number(median(both.iter().map(|pair| pair.0).collect())));
                cells.push(number(median(both.iter().map(|pair| pair.1).collect())));
                cells.push(format!("{share:.0} %"));
            }
            table.rows.push(cells);
        }
        Ok(table)
    }
}
