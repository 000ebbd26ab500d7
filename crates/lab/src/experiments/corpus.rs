//! `cargo lab corpus`: every mesh below a folder, and whether the promises hold.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::read_mesh;
use hullwright::measure::MeasureOptions;
use hullwright::{Control, Error, Parameters, decompose};
use hullwright_cli::terminal::{Failure, print};

use crate::runs::judge::{Verified, judge};
use crate::runs::meshes::collect;
use crate::statistics::median;

/// Decompose every mesh below a folder and count broken promises
///
/// A promise is broken where more was verified than was asked for, or more is sampled than was
/// verified.
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder that holds meshes
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Rounding of what was verified and of what is sampled, in bounds.
const ROUNDING: f64 = 1e-3;

/// What came of a folder's meshes.
#[derive(Default)]
struct Summary {
    done: usize,
    refused: usize,
    panicked: usize,
    broken: usize,
    not_convex: usize,
    without_volume: usize,
    seconds: Vec<f64>,
}

/// What came of one mesh.
struct Row {
    triangles: usize,
    hulls: usize,
    /// Largest of what was verified and what was sampled, over the bound.
    error: f64,
    is_broken: bool,
    not_convex: usize,
    without_volume: usize,
    seconds: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    let mut files = Vec::new();
    collect(folder, &mut files)?;
    files.sort();
    let mut summaries: BTreeMap<String, Summary> = BTreeMap::new();
    for file in &files {
        let name = file.strip_prefix(folder).unwrap_or(file).display().to_string();
        let group = Path::new(&name).parent().map(|p| p.display().to_string()).unwrap_or_default();
        let path = file.clone();
        // In a thread of its own, so that a panic is a row and not the end.
        let row = std::thread::spawn(move || decompose_and_judge(&path)).join();
        let line = summaries.entry(group).or_default().add(row);
        print(&format!("{name:<60} {line}"))?;
    }
    print(&format!(
        "\n{:<12} {:>5} {:>8} {:>7} {:>7} {:>11} {:>10} {:>9} {:>9}",
        "folder",
        "done",
        "refused",
        "panics",
        "broken",
        "not convex",
        "no volume",
        "median s",
        "worst s"
    ))?;
    for (folder, summary) in summaries {
        print(&summary.line(&folder))?;
    }
    Ok(())
}

impl Summary {
    /// Counts what came of a mesh, and says it in a line.
    fn add(&mut self, row: std::thread::Result<Result<Row, Error>>) -> String {
        match row {
            Ok(Ok(row)) => {
                self.done += 1;
                self.not_convex += row.not_convex;
                self.without_volume += row.without_volume;
                self.seconds.push(row.seconds);
                self.broken += usize::from(row.is_broken);
                let Row { triangles, hulls, error, is_broken, seconds, .. } = row;
                format!(
                    "{triangles:>8} triangles {hulls:>4} hulls {error:>6.3} of the bound \
                     {seconds:>8.4} s{}",
                    if is_broken { "  BROKEN" } else { "" }
                )
            }
            Ok(Err(error)) => {
                self.refused += 1;
                error.to_string()
            }
            Err(_) => {
                self.panicked += 1;
                "PANIC".into()
            }
        }
    }

    fn line(self, folder: &str) -> String {
        let Self { done, refused, panicked, broken, not_convex, without_volume, seconds } = self;
        let worst = seconds.iter().copied().fold(0.0, f64::max);
        let median = median(seconds);
        format!(
            "{folder:<12} {done:>5} {refused:>8} {panicked:>7} {broken:>7} {not_convex:>11} \
             {without_volume:>10} {median:>9.4} {worst:>9.4}"
        )
    }
}

fn decompose_and_judge(path: &Path) -> Result<Row, Error> {
    let file = read_mesh(path)?;
    let parameters = Parameters::default();
    let control = Control::new().with_parallel(false);
    let start = Instant::now();
    let result = decompose(&file, &parameters, &control)?;
    let seconds = start.elapsed().as_secs_f64();
    let options = MeasureOptions::default();
    let judged = judge(file.mesh.view(), &result.hulls, &options)?;
    let verified = Verified::of(&result);
    let Verified { bound, protrusion_max, uncovered_max } = verified;
    let lengths = [protrusion_max, uncovered_max, judged.protrusion_max, judged.uncovered_max];
    let largest = lengths.into_iter().fold(0.0, f64::max);
    Ok(Row {
        error: largest / bound,
        is_broken: verified.is_broken(&judged, ROUNDING * bound),
        triangles: file.mesh.triangles.len(),
        hulls: result.hulls.len(),
        not_convex: judged.non_convex_hulls,
        without_volume: judged.non_positive_volumes,
        seconds,
    })
}
