//! `cargo lab paper`: the paper's own experiments (its section 4), on the meshes that can be told.
//!
//! The paper numbers its models within a set of its own; only those of its Table 1 can be told by
//! their triangle counts. Figures that show other models are done on the meshes of their kind.

use std::path::PathBuf;

use crate::harness::session::{FULL, limits};
use crate::harness::{Row, Session, Task};
use crate::report::html_report::Report;
use crate::report::table::{NOTHING, Table, count, number, number_or_nothing};
use crate::statistics::{mean, median, range};
use crate::terminal::Failure;
use crate::tools::data_folder::{DataFolder, PaperRow};
use crate::tools::external_tools::ExternalTools;
use crate::tools::meshes::{self, Mesh};
use crate::tools::methods::Run;

/// Repeat the experiments of the paper that the surface method comes from
///
/// Can be stopped, and goes on where it was.
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with paper/table1.tsv, meshes/princeton and meshes/SOURCES.tsv
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// The Python that has the packages vhacdx and trimesh
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,

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

/// Numbers of hulls to try until features appear.
const HULLS: [u32; 6] = [4, 8, 16, 32, 64, 128];

/// What is run, each in a process of its own.
struct Experiments<'a> {
    session: Session<'a>,
    folder: DataFolder,
    table1: Vec<PaperRow>,
    princeton: Vec<Mesh>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = DataFolder(arguments.folder.clone());
    let tools = ExternalTools::new(folder.clone(), &arguments.python);
    let table1 = folder.table1()?;
    let princeton = meshes::find(&[folder.mesh("princeton")])?;
    let limits = limits(arguments.time_limit, MEMORY_LIMIT)?;
    let mut session = Session::open(&arguments.output, limits)?;
    session.tools = Some(&tools);
    let mut all = Experiments { session, folder, table1, princeton };
    let count = (all.princeton.len() / arguments.every.max(1)).max(1);
    let mut tables = all.table1()?;
    tables.push(all.hacd(count)?);
    tables.push(all.vhacd(!tools.versions[1].is_empty())?);
    tables.push(all.hollow_shapes()?);
    let words = vec![
        "Times are of one thread, in seconds, without reading files. Costs are averages of the \
         paper's equation (3)."
            .into(),
    ];
    let (title, name) = ("The paper's experiments", "paper-experiments");
    Ok(all.session.report(Report { title, name, words, tables, ..Report::default() })?)
}

impl Experiments<'_> {
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
        let figures: [(&str, fn(&Row) -> Option<f64>); 4] = [
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

    /// V-HACD at the same number of pieces, and at the least at which its error is no larger.
    fn vhacd(&mut self, has_library: bool) -> Result<Table, Failure> {
        let header = [
            "model",
            "method",
            "asked for",
            "hulls",
            "Hausdorff",
            "protrusion, mean",
            "IoU",
            "seconds",
        ];
        let library = match has_library {
            true => {
                "V-HACD 4 is that of the package vhacdx, with its default fill mode, flood fill."
            }
            false => "V-HACD 4 was not there.",
        };
        let note = format!(
            "V-HACD asked for as many hulls as the paper's method has, and for the fewest of {HULLS:?} \
             whose Hausdorff error is no larger than its: that is when features are there (*). Parry \
             turns the number into a depth of cuts, a power of two, and has no merging. {library}"
        );
        let mut table = Table::new("4.3.1: V-HACD", &note, &header);
        let parry: (&str, fn(u32) -> Run) = ("V-HACD in Parry", |hulls| Run::VhacdHulls { hulls });
        let four: (&str, fn(u32) -> Run) = ("V-HACD 4", |hulls| Run::Vhacd4 { hulls });
        for paper in self.table1.clone() {
            let Some(ours) = self.row(&paper.mesh, Run::Surface)? else { continue };
            let mut add = |method: &str, asked: String, row: Option<&Row>| {
                let figure = |of: fn(&Row) -> Option<f64>| number_or_nothing(row.and_then(of));
                let figures = [
                    figure(|row| row.hausdorff),
                    figure(|row| row.protrusion_mean),
                    figure(|row| row.iou),
                    figure(|row| row.seconds),
                ];
                let hulls = count(row.and_then(|row| row.hulls));
                let names = [paper.name(), method.into(), asked, hulls];
                table.rows.push(names.into_iter().chain(figures).collect());
            };
            add("surface", NOTHING.into(), Some(&ours));
            for (name, run) in [Some(parry), has_library.then_some(four)].into_iter().flatten() {
                let pieces = ours.hulls.unwrap_or(1);
                let equal = self.row(&paper.mesh, run(pieces as u32))?;
                add(name, pieces.to_string(), equal.as_ref());
                let mut last = None;
                for hulls in HULLS {
                    let Some(row) = self.row(&paper.mesh, run(hulls))? else { continue };
                    let is_enough = row.hausdorff <= ours.hausdorff;
                    last = Some((hulls, is_enough, row));
                    if is_enough {
                        break;
                    }
                }
                if let Some((hulls, is_enough, row)) = last {
                    let never = if is_enough { "" } else { " never" };
                    add(name, format!("{hulls} *{never}"), Some(&row));
                }
            }
        }
        Ok(table)
    }

    /// Figure 4's hollow shapes: does their inside stay open?
    fn hollow_shapes(&mut self) -> Result<Table, Failure> {
        let header =
            ["mesh", "method", "hulls", "IoU", "protrusion, mean", "Hausdorff", "volume ratio"];
        let note = "Princeton's cups. An inside that is filled shows as a volume of the hulls' union far \
                    above that of the solid (volume ratio), and as a low IoU.";
        let mut table = Table::new("Figure 4: hollow shapes", note, &header);
        let hacd = [0.05, 0.1].map(|threshold| Run::Hacd { threshold });
        for mesh in self.folder.meshes_of_kind("cup")? {
            for run in [Run::Surface].into_iter().chain(hacd.clone()).chain([Run::VHACD_DEFAULT]) {
                let name = format!("{}, {}", run.method(), run.setting());
                let Some(row) = self.row(&mesh, run)? else { continue };
                // Of the joint volume the share s is in both: union / solid follows from IoU and from
                // the share u of the solid in no hull, since (1 − u) solid = IoU (solid + union − both).
                let ratio = row.iou.zip(row.uncovered_volume).map(|(iou, uncovered)| {
                    let both = 1.0 - uncovered;
                    both / iou - 1.0 + both
                });
                table.rows.push(vec![
                    mesh.clone(),
                    name,
                    count(row.hulls),
                    number_or_nothing(row.iou),
                    number_or_nothing(row.protrusion_mean),
                    number_or_nothing(row.hausdorff),
                    number_or_nothing(ratio),
                ]);
            }
        }
        Ok(table)
    }
}
