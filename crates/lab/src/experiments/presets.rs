//! `cargo lab presets`: `fast` beside `balanced`.

use std::path::PathBuf;
use std::time::Instant;

use hullwright::io::{MeshFile, read_mesh};
use hullwright::{Control, Length, Parameters, Preset, decompose};
use hullwright_cli::terminal::{Failure, print};

use crate::runs::meshes::find;
use crate::statistics::{geometric_mean, median, range};

/// Compare the times and hulls of the presets `fast` and `balanced`, mesh by mesh, on one thread
#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes, and folders of meshes
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// The bound: a share of the diagonal
    #[arg(long, value_name = "SHARE", default_value_t = 0.02)]
    bound: f64,
}

/// Runs of each preset, in turns, of which the quickest counts: noise only ever adds.
const RUNS: usize = 3;

/// The same where times differ by less than [`UNCLEAR`].
const MORE_RUNS: usize = 15;
const UNCLEAR: std::ops::RangeInclusive<f64> = 0.9..=2.0;

/// A time over the other's up to which the two are as fast.
const AS_FAST: f64 = 1.02;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (mut times, mut hull_ratios, mut hulls, mut slower) = (Vec::new(), Vec::new(), [0, 0], 0);
    for mesh in find(&arguments.folders)? {
        let Ok(file) = read_mesh(&mesh.path) else { continue };
        let mut best = [f64::INFINITY; 2];
        let Ok(mut counts) = quickest(&file, arguments.bound, RUNS, &mut best) else { continue };
        if UNCLEAR.contains(&(best[0] / best[1])) {
            counts = quickest(&file, arguments.bound, MORE_RUNS, &mut best)?;
        }
        let ratio = best[0] / best[1];
        times.push(ratio);
        hull_ratios.push(counts[0] as f64 / counts[1] as f64);
        hulls = [hulls[0] + counts[0], hulls[1] + counts[1]];
        slower += usize::from(ratio > AS_FAST);
        print(&format!(
            "{ratio:6.2} times {:8.1} of {:8.1} ms {:4} and {:4} hulls {}  {}",
            1e3 * best[0],
            1e3 * best[1],
            counts[0],
            counts[1],
            if ratio > AS_FAST { "SLOWER" } else { "" },
            mesh.path.display()
        ))?;
    }
    let worst = range(times.iter().copied()).1;
    print(&format!(
        "fast over balanced: time {:.2} at the median, {worst:.2} at worst, slower on {slower} of {} meshes; \
         {} and {} hulls, {:.3} times in the geometric mean",
        median(times.clone()),
        times.len(),
        hulls[0],
        hulls[1],
        geometric_mean(hull_ratios).unwrap_or(0.0),
    ))
}

/// Lowers the best times of `fast` and `balanced`, and returns their hulls.
fn quickest(
    file: &MeshFile,
    bound: f64,
    runs: usize,
    best: &mut [f64; 2],
) -> Result<[usize; 2], Failure> {
    let control = Control::new().with_parallel(false);
    let mut counts = [0; 2];
    for _ in 0..runs {
        for (index, preset) in [Preset::Fast, Preset::Balanced].into_iter().enumerate() {
            let parameters = Parameters::default().max_error(Length::share(bound)).preset(preset);
            let start = Instant::now();
            counts[index] = decompose(file, &parameters, &control)?.hulls.len();
            best[index] = best[index].min(start.elapsed().as_secs_f64());
        }
    }
    Ok(counts)
}
