//! `cargo lab reach`: whether hulls stay out of the way of balls, by a path finder that shares no
//! code with the crate.

use std::path::PathBuf;

use hullwright::openings::close_openings;
use hullwright::{Control, Length, Parameters, decompose};

use crate::independent::oracle::{Convex, Triangle};
use crate::independent::paths::deepest_entry;
use crate::terminal::{Failure, print};
use crate::tools::meshes;

/// Decompose every mesh below folders with a probe, move a ball through all places that it can
/// reach from outside, and say how far hulls enter it
///
/// Ends with exit code 1 where that is more than the bound. In an open mesh, what its winding
/// number takes for the inside counts as solid although a ball may get there: such meshes are only
/// listed.
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = meshes::folders_help(), required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// Of the ball: 6% of the diagonal or 0.1m
    #[arg(long, value_name = "RADIUS", default_value = "6%")]
    probe_radius: Length,

    /// The ball moves in steps of the radius over this: the crate's cells are half the radius
    #[arg(long, value_name = "N", default_value_t = 6.0)]
    steps: f64,
}

/// More than the rounding of hulls, as a fraction of the diagonal.
const ROUNDING: f64 = 1e-6;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let &Arguments { ref folders, probe_radius, steps } = arguments;
    let (parameters, control) =
        (Parameters::default().with_probe_radius(probe_radius), Control::new());
    let (mut kept, mut failed, mut open) = (0, 0, 0);
    for mesh in meshes::find(folders)? {
        let Ok(file) = hullwright_formats::read_mesh(&mesh.path) else { continue };
        let found = decompose(&file, &parameters, &control);
        let (Ok(found), Ok(closed)) = (found, close_openings(&file, &parameters, &control)) else {
            continue;
        };
        let (run, report) = (&found.run, &found.report);
        let radius = probe_radius.of_diagonal(run.diagonal);
        let surface = Triangle::all(&closed.mesh.positions, &closed.mesh.triangles);
        let hull = |hull: &hullwright::Hull| Convex::new(&hull.shape.points, &hull.shape.triangles);
        let hulls: Vec<Convex> = found.hulls.iter().map(hull).collect();
        let (deepest, places) = deepest_entry(&surface, &hulls, radius, radius / steps, &[]);
        let is_open = run.closed_components < run.components;
        let outcome = if deepest <= report.bound + ROUNDING * run.diagonal {
            kept += 1;
            "kept"
        } else if is_open {
            open += 1;
            "open"
        } else {
            failed += 1;
            "FAILED"
        };
        let percent = |length: f64| 100.0 * length / run.diagonal;
        print(&format!(
            "{outcome} {}: {} hulls, {places} places, entered by {:.3} % of {:.3} %",
            mesh.name,
            hulls.len(),
            percent(deepest),
            percent(report.bound)
        ))?;
    }
    print(&format!("{kept} keep the bound, {open} open meshes and {failed} others do not"))?;
    match failed {
        0 => Ok(()),
        _ => Err("hulls are in the way".into()),
    }
}
