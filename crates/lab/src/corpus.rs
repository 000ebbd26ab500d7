//! `cargo lab corpus`: every mesh below a folder, and whether the promises hold.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::{Format, read_mesh};
use hullwright::measure::{HullShape, MeasureOptions, measure};
use hullwright::{Control, Error, Parameters, decompose};

use crate::output::Failure;

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
    if !folder.is_dir() {
        return Err(format!("{}: there is no such folder", folder.display()).into());
    }
    let mut files = Vec::new();
    collect(folder, &mut files);
    files.sort();
    let mut summaries: BTreeMap<String, Summary> = BTreeMap::new();
    for file in &files {
        let name = file.strip_prefix(folder).unwrap_or(file).display().to_string();
        let group = Path::new(&name).parent().map(|p| p.display().to_string()).unwrap_or_default();
        let summary = summaries.entry(group).or_default();
        let path = file.clone();
        // In a thread of its own, so that a panic is a row and not the end.
        match std::thread::spawn(move || judge(&path)).join() {
            Ok(Ok(row)) => {
                summary.done += 1;
                summary.not_convex += row.not_convex;
                summary.without_volume += row.without_volume;
                summary.seconds.push(row.seconds);
                summary.broken += usize::from(row.is_broken);
                let Row { triangles, hulls, error, is_broken, seconds, .. } = row;
                println!(
                    "{name:<60} {triangles:>8} triangles {hulls:>4} hulls {error:>6.3} of the \
                     bound {seconds:>8.4} s{}",
                    if is_broken { "  BROKEN" } else { "" }
                );
            }
            Ok(Err(error)) => {
                summary.refused += 1;
                println!("{name:<60} {error}");
            }
            Err(_) => {
                summary.panicked += 1;
                println!("{name:<60} PANIC");
            }
        }
    }
    println!(
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
    );
    for (folder, summary) in &mut summaries {
        summary.seconds.sort_by(f64::total_cmp);
        let at = |place: usize| summary.seconds.get(place).copied().unwrap_or_default();
        let (median, worst) = (at(summary.seconds.len() / 2), at(summary.seconds.len().max(1) - 1));
        let Summary { done, refused, panicked, broken, not_convex, without_volume, .. } = summary;
        println!(
            "{folder:<12} {done:>5} {refused:>8} {panicked:>7} {broken:>7} {not_convex:>11} \
             {without_volume:>10} {median:>9.4} {worst:>9.4}"
        );
    }
    Ok(())
}

fn judge(path: &Path) -> Result<Row, Error> {
    let file = read_mesh(path)?;
    let mut parameters = Parameters::default();
    parameters.parallel = false;
    let start = Instant::now();
    let result = decompose(&file.positions, &file.triangles, &parameters, &Control::new())?;
    let seconds = start.elapsed().as_secs_f64();
    let shapes: Vec<HullShape> = result.hulls.iter().map(HullShape::from).collect();
    let judged = measure(&file.positions, &file.triangles, &shapes, &MeasureOptions::default())?;
    let (error, is_broken) = match &result.report.bounded {
        Some(report) => {
            let sampled = result.report.diagonal * judged.phantom.max;
            let exposed = result.report.diagonal * judged.exposed.max;
            let most = |bounds: [f64; 2]| bounds[0] > bounds[1] + ROUNDING * report.bound;
            let is_broken = most([report.phantom_max, report.bound])
                || most([report.exposed_max, report.bound])
                || most([sampled, report.phantom_max])
                || most([exposed, report.exposed_max]);
            let values = [report.phantom_max, report.exposed_max, sampled, exposed];
            (values.into_iter().fold(0.0, f64::max) / report.bound, is_broken)
        }
        None => (0.0, false),
    };
    Ok(Row {
        error,
        is_broken,
        triangles: file.triangles.len(),
        hulls: result.hulls.len(),
        not_convex: judged.non_convex_hulls,
        without_volume: judged.non_positive_volumes,
        seconds,
    })
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        if path.is_dir() {
            collect(&path, files);
        } else if Format::from_path(&path).is_some() {
            files.push(path);
        }
    }
}
