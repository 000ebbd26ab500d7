//! `cargo lab stability`: the same meshes turned, scaled, moved, jittered, shuffled, flipped or
//! doubled, and how much the result varies.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::harness::session::limits;
use crate::harness::{FULL, Judge, Row, Session, Status, Task};
use crate::report::{NOTHING, Report, Table, number};
use crate::statistics::{median, range};
use crate::terminal::Failure;
use crate::tools::meshes;
use crate::tools::methods::Run;
use crate::tools::variations::Variation;

/// Decompose meshes that are turned, scaled, moved, jittered, shuffled, flipped or doubled, and
/// report how much the result varies
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

    /// Only these methods, by name, separated by commas
    #[arg(long, value_name = "METHODS", value_delimiter = ',')]
    only: Vec<String>,
}

/// Longest time of a variation in seconds, several times that of the slowest mesh, and most memory
/// in megabytes, as in the benchmark.
const LIMITS: (f64, u64) = (120.0, 4096);

/// Fewer points than in the benchmark, since there are many runs: shares of the volume are known to
/// about a hundredth.
const JUDGE: Judge =
    Judge { is_timed: false, surface_samples: 20_000, volume_samples: 20_000, ..FULL };

/// A measured error may be above the promised one by this share: `measure` samples points, and
/// rounding moves them.
const ERROR_SLACK: f64 = 1e-3;

/// Errors below this are the tolerance of `measure`.
const LEAST_ERROR: f64 = 1e-6;

/// Processor times below this one, in seconds, are too short for their ratio to say anything.
const LEAST_SECONDS: f64 = 0.02;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let session = Session::open(&arguments.output, limits(LIMITS.0, LIMITS.1)?)?;
    let meshes = meshes::spread(meshes::find(&arguments.folders)?, arguments.meshes);
    let only = &arguments.only;
    let mut runs = [Run::bounded(0.02), Run::Surface].to_vec();
    runs.retain(|run| only.is_empty() || only.iter().any(|name| name == run.method()));
    let tasks: Vec<Task> = runs
        .iter()
        .flat_map(|run| Variation::all().into_iter().map(|variation| (run.clone(), variation)))
        .map(|(run, variation)| Task { run, variation, judge: JUDGE })
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
            Variation::all().len(),
        ),
        format!("The meshes: {}.", names.join(", ")),
        "The hulls of a mesh that was shuffled, flipped or doubled are measured against the mesh \
         as it is; those of one that was turned, scaled, moved or jittered against that."
            .into(),
    ];
    let all = Rows::new(&rows);
    let tables = vec![all.spread(), all.volumes(), wrong(&rows)];
    let (title, name) = ("Numerical stability", "stability");
    Ok(session.report(Report { title, name, words, tables, ..Report::default() })?)
}

/// Whether a hull is not convex or has no volume, or the error is above the bound.
fn breaks_promise(row: &Row) -> bool {
    let (Status::Done, Some(error)) = (row.status, row.hausdorff) else { return false };
    let bound = row.bound.map_or(f64::INFINITY, |bound| bound * (1.0 + ERROR_SLACK));
    let is_faulty = |count: Option<usize>| count.is_some_and(|count| count > 0);
    is_faulty(row.non_convex_hulls) || is_faulty(row.hulls_without_volume) || error > bound
}

/// A figure beside error and hulls, and how much worse it is than that of the mesh as it is.
type Comparison = (fn(&Row) -> Option<f64>, fn(f64, f64) -> f64);

/// Uncovered volume, intersection over union, and processor time.
const FIGURES: [Comparison; 3] = [
    (|row| row.uncovered_volume, |varied, base| varied - base),
    (|row| row.iou, |varied, base| base - varied),
    (
        |row| row.processor_seconds,
        |varied, base| varied.max(LEAST_SECONDS) / base.max(LEAST_SECONDS),
    ),
];

/// All rows, and those of the meshes as they are by mesh and method.
struct Rows<'a> {
    rows: &'a [Row],
    base: BTreeMap<(&'a str, &'a str), &'a Row>,
}

impl<'a> Rows<'a> {
    fn new(rows: &'a [Row]) -> Self {
        let base = rows.iter().filter(|row| row.variation.is_empty() && row.is_done());
        let base = base.map(|row| ((row.mesh.as_str(), row.method.as_str()), row)).collect();
        Self { rows, base }
    }

    /// A row's mesh as it is, by the same method.
    fn base_of(&self, row: &Row) -> Option<&'a Row> {
        self.base.get(&(row.mesh.as_str(), row.method.as_str())).copied()
    }

    /// How much worse a row is than that of the mesh as it is.
    fn compared(&self, (figure, worse): Comparison, row: &Row) -> Option<f64> {
        Some(worse(figure(row).filter(|_| row.is_done())?, figure(self.base_of(row)?)?))
    }

    /// The rows of each method and kind of variation, kinds in the order in which they are tried.
    fn groups(&self) -> Vec<(&'static str, String, Vec<&'a Row>)> {
        let mut groups: Vec<(&str, String, Vec<&Row>)> = Vec::new();
        for method in ["bounded", "surface"] {
            for variation in Variation::all() {
                let (name, kind) = (variation.name(), variation.kind());
                let is_own = |row: &&Row| row.method == method && row.variation == name;
                let own = self.rows.iter().filter(is_own);
                match groups.last_mut().filter(|last| (last.0, &last.1) == (method, &kind)) {
                    Some((.., rows)) => rows.extend(own),
                    None => groups.push((method, kind, own.collect())),
                }
            }
        }
        groups.retain(|(.., rows)| !rows.is_empty());
        groups
    }

    fn spread(&self) -> Table {
        let header = [
            "method",
            "variation",
            "runs",
            "failures",
            "broken promises",
            "same hull count",
            "hulls over those of the mesh as it is: least",
            "median",
            "most",
            "error over that of the mesh as it is: least",
            "median ",
            "most ",
            "largest error",
        ];
        let note = "Each run is compared with the same method on the same mesh as it is. A broken \
                    promise is a hull that is not convex (1e-6 of the diagonal) or has no volume, or an \
                    error above the bound that was asked for.";
        let mut table = Table::new("Spread", note, &header);
        for (method, kind, all) in self.groups() {
            let good: Vec<&Row> = all.iter().copied().filter(|row| row.is_done()).collect();
            let pairs: Vec<(&Row, &Row)> =
                good.iter().filter_map(|row| Some((*row, self.base_of(row)?))).collect();
            let same = pairs.iter().filter(|(a, b)| a.hulls == b.hulls).count();
            let hulls = |(a, b): &(&Row, &Row)| Some(a.hulls? as f64 / b.hulls? as f64);
            let error = |(a, b): &(&Row, &Row)| {
                let (a, b) = a.hausdorff.zip(b.hausdorff)?;
                let is_seen = a > LEAST_ERROR || b > LEAST_ERROR;
                is_seen.then(|| a.max(LEAST_ERROR) / b.max(LEAST_ERROR))
            };
            let mut cells = vec![
                method.to_owned(),
                kind,
                all.len().to_string(),
                (all.len() - good.len()).to_string(),
                good.iter().filter(|row| breaks_promise(row)).count().to_string(),
                format!("{:.0} %", 100.0 * same as f64 / pairs.len().max(1) as f64),
            ];
            cells.extend(least_median_most(pairs.iter().filter_map(hulls).collect()));
            cells.extend(least_median_most(pairs.iter().filter_map(error).collect()));
            cells.push(number(good.iter().filter_map(|row| row.hausdorff).fold(0.0, f64::max)));
            table.rows.push(cells);
        }
        table
    }

    fn volumes(&self) -> Table {
        let header = [
            "method",
            "variation",
            "more uncovered volume: median",
            "most",
            "less IoU: median",
            "most ",
            "processor time over that of the mesh as it is: median",
            "most  ",
        ];
        let note =
            "Each run against the same method on the same mesh as it is. Volumes of closed meshes.";
        let mut table = Table::new("Volume and time", note, &header);
        for (method, kind, all) in self.groups() {
            let mut cells = vec![method.to_owned(), kind];
            for figure in FIGURES {
                let values = all.iter().filter_map(|row| self.compared(figure, row)).collect();
                let [_, median, most] = least_median_most(values);
                cells.extend([median, most]);
            }
            table.rows.push(cells);
        }
        table
    }
}

fn least_median_most(values: Vec<f64>) -> [String; 3] {
    if values.is_empty() {
        return [NOTHING; 3].map(String::from);
    }
    let (least, most) = range(values.iter().copied());
    [least, median(values), most].map(number)
}

fn wrong(rows: &[Row]) -> Table {
    let note = "Every failure, and every broken promise.";
    let mut table = Table::new("What went wrong", note, &["mesh", "method", "variation", "what"]);
    for row in rows {
        let what = match row.hausdorff {
            _ if row.status != Status::Done => format!("{}: {}", row.status.name(), row.reason),
            Some(error) if breaks_promise(row) => {
                format!("error {}; {}", number(error), row.faults())
            }
            _ => continue,
        };
        let names = [&row.mesh, &row.method, &row.variation].map(String::clone);
        table.rows.push(names.into_iter().chain([what]).collect());
    }
    table
}
