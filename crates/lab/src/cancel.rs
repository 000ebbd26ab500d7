//! `cargo lab cancel`: how long a stop takes.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use hullwright::io::read_mesh;
use hullwright::{Control, Parameters, decompose};

use crate::output::Failure;

/// Show how long a stop takes
///
/// Each mesh is decomposed many times and cancelled at another moment each time.
#[derive(clap::Args)]
pub struct Arguments {
    /// The meshes: obj, off, ply, stl, gltf or glb
    #[arg(required = true, value_name = "MESH")]
    meshes: Vec<PathBuf>,
}

/// Moments at which each mesh is cancelled, spread evenly over the time that it takes.
const MOMENTS: u32 = 40;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let parameters = Parameters::default();
    let mut all = Vec::new();
    for path in &arguments.meshes {
        let file = read_mesh(path)?;
        let start = Instant::now();
        decompose(&file.positions, &file.triangles, &parameters, &Control::new())?;
        let whole = start.elapsed();
        let mut waits: Vec<Duration> = Vec::new();
        for moment in 1..=MOMENTS {
            let control = Control::new();
            let (wait, is_cancelled) = std::thread::scope(|scope| {
                let work = scope.spawn(|| {
                    decompose(&file.positions, &file.triangles, &parameters, &control)
                        .is_err_and(|error| matches!(error, hullwright::Error::Cancelled))
                });
                std::thread::sleep(whole * moment / (MOMENTS + 1));
                let stop = Instant::now();
                control.cancel();
                (work.join().map(|cancelled| (stop.elapsed(), cancelled)))
                    .unwrap_or((Duration::MAX, false))
            });
            if is_cancelled {
                waits.push(wait);
            }
        }
        waits.sort();
        let longest = waits.last().copied().unwrap_or_default();
        let median = waits.get(waits.len() / 2).copied().unwrap_or_default();
        println!(
            "{whole:>10.1?} whole, stops within {median:.1?} (median), {longest:.1?}  {}",
            path.display()
        );
        all.extend(waits);
    }
    all.sort();
    let at = |share: usize| all.get(all.len() * share / 100).copied().unwrap_or_default();
    println!("of {} stops: median {:.1?}, 95 % within {:.1?}", all.len(), at(50), at(95));
    Ok(())
}
