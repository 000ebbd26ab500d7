//! `cargo lab cancel`: how long a stop takes.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use hullwright::io::{MeshFile, read_mesh};
use hullwright::{Control, Error, Parameters, Stage, decompose};
use hullwright_cli::terminal::{Failure, print};

use crate::runs::meshes;

/// Show how long a stop takes
///
/// Each mesh is decomposed many times and cancelled at another moment each time.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = meshes::files_help(), required = true, value_name = "MESH")]
    meshes: Vec<PathBuf>,
}

/// Moments at which each mesh is cancelled, spread evenly over the time that it takes.
const MOMENTS: u32 = 40;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut all = Vec::new();
    for path in &arguments.meshes {
        let file = read_mesh(path)?;
        let start = Instant::now();
        decompose(&file, &Parameters::default(), &Control::new())?;
        let whole = start.elapsed();
        let moments = (1..=MOMENTS).map(|moment| whole * moment / (MOMENTS + 1));
        let mut waits: Vec<(Duration, Stage)> =
            moments.filter_map(|moment| stop_after(&file, moment)).collect();
        waits.sort_by_key(|&(wait, _)| wait);
        let (longest, stage) = waits.last().copied().unwrap_or((Duration::ZERO, Stage::Repair));
        let (median, _) = waits.get(waits.len() / 2).copied().unwrap_or((longest, stage));
        print(&format!(
            "{whole:>10.1?} whole, stops within {median:.1?} (median), {longest:.1?} ({stage})  {}",
            path.display()
        ))?;
        all.extend(waits.into_iter().map(|(wait, _)| wait));
    }
    all.sort();
    let at = |share: usize| all.get(all.len() * share / 100).copied().unwrap_or_default();
    print(&format!("of {} stops: median {:.1?}, 95 % within {:.1?}", all.len(), at(50), at(95)))
}

/// From the call of `cancel` to the end of the work, and the stage it came in; `None` where the work was done
/// before.
fn stop_after(file: &MeshFile, moment: Duration) -> Option<(Duration, Stage)> {
    let stage = Arc::new(Mutex::new(Stage::Repair));
    let current = Arc::clone(&stage);
    let control = Control::new().with_progress(move |progress| {
        if let Ok(mut current) = current.lock() {
            *current = progress.stage;
        }
    });
    std::thread::scope(|scope| {
        let work = scope.spawn(|| {
            let parameters = Parameters::default();
            decompose(file, &parameters, &control)
        });
        std::thread::sleep(moment);
        let stage = *stage.lock().ok()?;
        let stop = Instant::now();
        control.cancel();
        let result = work.join().ok()?;
        matches!(result, Err(Error::Cancelled)).then(|| (stop.elapsed(), stage))
    })
}
