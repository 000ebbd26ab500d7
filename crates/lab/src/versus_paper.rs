//! `cargo lab versus-paper`: where the paper's own hulls keep a bound, and whether ours are more.

use std::path::PathBuf;

use hullwright::io::read_mesh;
use hullwright::surface::{self, SurfaceParameters};
use hullwright::{Control, Length, MergeTree, Method};

use crate::harness::session::limits;
use crate::harness::{Judge, Session, Task};
use crate::report::{Table, number};
use crate::terminal::{Failure, print};
use crate::tools::meshes::{Mesh, find};
use crate::tools::methods::Run;

/// Compare hulls with those of the paper's method at its defaults, where these keep the bound
///
/// What keeps the bound by samples is verified.
#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes, and folders of meshes
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// Bounds: fractions of the diagonal
    #[arg(long, value_name = "SHARE", default_values_t = [0.02, 0.01])]
    bound: Vec<f64>,
}

/// Longest time of a run in seconds, and most memory in megabytes: as in the benchmark.
const LIMITS: (f64, u64) = (300.0, 4096);

/// Samples only choose what is verified.
const JUDGE: Judge = Judge {
    is_timed: false,
    surface_samples: 5000,
    volume_samples: 1,
    by_brute_force: false,
    probe_radius: None,
};

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let session = Session::temporary(limits(LIMITS.0, LIMITS.1)?)?;
    let header = [
        "bound",
        "meshes",
        "the paper's keep it",
        "ours are more on",
        "hulls",
        "seconds",
        "paper's",
    ];
    let mut table = Table::new("Against the paper's hulls", "", &header);
    let meshes = find(&arguments.folders)?;
    for &bound in &arguments.bound {
        let runs = || [Run::bounded(bound), Run::Surface].map(|run| Task::new(run, JUDGE)).to_vec();
        let rows = session.rows(&meshes, |_| runs())?;
        let mut more = Vec::new();
        let (mut kept, mut done, mut hulls, mut seconds) = (0, 0, 0, [0.0; 2]);
        for (pair, mesh) in rows.chunks_exact(2).zip(&meshes) {
            let [ours, paper] = [&pair[0], &pair[1]];
            let (Some(own), Some(theirs)) = (ours.hulls, paper.hulls) else { continue };
            done += 1;
            hulls += own;
            let of = [ours, paper].map(|row| row.seconds.unwrap_or(0.0));
            seconds = [seconds[0] + of[0], seconds[1] + of[1]];
            if paper.hausdorff.is_some_and(|found| found <= bound) && keeps_bound(mesh, bound)? {
                kept += 1;
                if own > theirs {
                    more.push(format!("{} ({own}, {theirs})", mesh.name));
                }
            }
        }
        let mut cells = [done, kept].map(|count: usize| count.to_string()).to_vec();
        cells.insert(0, bound.to_string());
        cells.push(if more.is_empty() { "none".into() } else { more.join(", ") });
        cells.push(hulls.to_string());
        cells.extend(seconds.map(number));
        table.rows.push(cells);
    }
    print(&format!("\n{}", table.to_markdown()))
}

/// Whether the paper's hulls keep the bound, verified.
fn keeps_bound(mesh: &Mesh, bound: f64) -> Result<bool, Failure> {
    let file = read_mesh(&mesh.path)?;
    let parameters = SurfaceParameters::paper();
    let found = surface::decompose(&file, &parameters, &Control::new())?;
    let solid = Method::from(parameters).solid().max_error(Length::Share(bound));
    let tree = MergeTree::from_hulls(&file, &found.hulls, &solid, &Control::new())?;
    let error = tree.curve().first().map_or(f64::INFINITY, |point| point.error);
    Ok(error <= bound * found.run.diagonal)
}
