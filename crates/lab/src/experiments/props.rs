//! `cargo lab props`: time and quality on low-poly meshes, and hulls of plain shapes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::read_mesh;
use hullwright::measure::{MeasureOptions, measure};
use hullwright::{Control, Decomposition, Length, Parameters, Preset, decompose};
use hullwright_cli::terminal::{Failure, print};

use crate::runs::meshes::find;
use crate::statistics::{mean, median};

/// Show times, hulls and hollows of low-poly meshes, and whether plain shapes have the hulls that
/// their names say
///
/// A file called NAME_N is a plain shape of N pieces: it is decomposed under four bounds, and may
/// not have more hulls. Of other meshes, those of 50 to 2,000 triangles count.
#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes, and folders of meshes
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// Use one thread
    #[arg(long)]
    serial: bool,

    /// fast, balanced or fine
    #[arg(long, value_name = "NAME", default_value = "balanced")]
    preset: Preset,
}

/// Bounds for plain shapes.
const BOUNDS: [f64; 4] = [0.02, 0.005, 0.001, 0.0002];

/// Triangles of a prop.
const PROP: std::ops::RangeInclusive<usize> = 50..=2000;

/// Runs of which the quickest counts.
const RUNS: usize = 3;

#[derive(Default)]
struct Totals {
    milliseconds: Vec<f64>,
    hollow: Vec<f64>,
    hulls: usize,
    broken: usize,
    too_many: usize,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (mut plain, mut props) = (Totals::default(), Totals::default());
    for mesh in find(&arguments.folders)? {
        let path = mesh.path;
        let Ok(file) = read_mesh(&path) else { continue };
        let pieces = pieces(&path);
        if pieces.is_none() && !PROP.contains(&file.mesh.triangles.len()) {
            continue;
        }
        let (totals, bounds) = match pieces {
            Some(_) => (&mut plain, &BOUNDS[..]),
            None => (&mut props, &BOUNDS[..1]),
        };
        for &bound in bounds {
            let parameters =
                Parameters::default().max_error(Length::share(bound)).preset(arguments.preset);
            let control = Control::new().with_parallel(!arguments.serial);
            let mut least = f64::INFINITY;
            let mut result: Option<Decomposition> = None;
            for _ in 0..RUNS {
                let start = Instant::now();
                result = Some(decompose(&file, &parameters, &control)?);
                least = least.min(1e3 * start.elapsed().as_secs_f64());
            }
            let Some(result) = result else { continue };
            let hulls = result.hulls.len();
            totals.hulls += hulls;
            totals.milliseconds.push(least);
            totals.too_many += usize::from(pieces.is_some_and(|pieces| hulls > pieces));
            let report = &result.report;
            let worst = report.protrusion_max.max(report.uncovered_max);
            totals.broken += usize::from(worst > report.bound);
            let judged = measure(&file, &result.hulls, &MeasureOptions::default(), &control);
            let hollow = judged.ok().and_then(|judged| judged.uncovered_volume);
            totals.hollow.extend(hollow);
            let hollow = hollow.map_or("–".into(), |hollow| format!("{hollow:.4}"));
            print(&format!(
                "{least:9.1} ms {hulls:4} hulls {hollow:>7} hollow {:7} triangles at {bound}  {}",
                file.mesh.triangles.len(),
                path.display()
            ))?;
        }
    }
    for (name, totals) in [("plain shapes", plain), ("props", props)] {
        let Totals { milliseconds, hollow, hulls, broken, too_many } = totals;
        if milliseconds.is_empty() {
            continue;
        }
        let slowest = milliseconds.iter().copied().fold(0.0, f64::max);
        let worst = hollow.iter().copied().fold(0.0, f64::max);
        print(&format!(
            "{name}: median {:.1} ms, slowest {slowest:.1} ms, {hulls} hulls, hollow {:.4} mean \
             {worst:.4} worst, {broken} broken promises, {too_many} with too many hulls",
            median(milliseconds),
            mean(&hollow),
        ))?;
    }
    Ok(())
}

/// The number of pieces that a file's name ends with.
fn pieces(path: &Path) -> Option<usize> {
    let is_plain = path.parent()?.file_name()? == "exact";
    let number = path.file_stem()?.to_str()?.rsplit_once('_')?.1;
    is_plain.then(|| number.parse().ok())?
}
