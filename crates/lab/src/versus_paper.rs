//! `cargo lab versus-paper`: where the paper's own hulls keep a bound, and whether ours are more.

use std::path::PathBuf;
use std::time::Instant;

use hullwright::io::{MeshFile, read_mesh};
use hullwright::measure::{MeasureOptions, measure};
use hullwright::surface::{self, SurfaceParameters, SurfaceReport};
use hullwright::{Control, Decomposition, Length, MergeTree, Method, decompose};

use crate::terminal::{Failure, print};
use crate::tools::meshes::find;
use crate::tools::methods::bounded;

/// Compare hulls with those of the paper's method at its defaults, where these keep the bound
///
/// What keeps the bound by samples is verified. Only meshes where the bounded method has more hulls
/// are shown.
#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes, and folders of meshes
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// Bounds: shares of the diagonal
    #[arg(long, value_name = "SHARE", default_values_t = [0.02, 0.01])]
    bound: Vec<f64>,
}

#[derive(Default)]
struct Totals {
    meshes: usize,
    /// Where the paper's hulls keep the bound.
    kept: usize,
    more: usize,
    hulls: usize,
    seconds: f64,
    paper_seconds: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut totals: Vec<Totals> = arguments.bound.iter().map(|_| Totals::default()).collect();
    let control = Control::new();
    for mesh in find(&arguments.folders)? {
        let Ok(file) = read_mesh(&mesh.path) else { continue };
        for (&bound, totals) in arguments.bound.iter().zip(&mut totals) {
            let start = Instant::now();
            let Ok(ours) = decompose(&file, &bounded(bound), &control) else { continue };
            totals.meshes += 1;
            totals.seconds += start.elapsed().as_secs_f64();
            totals.hulls += ours.hulls.len();
            let start = Instant::now();
            let paper = surface::decompose(&file, &SurfaceParameters::paper(), &control);
            let Ok(paper) = paper else { continue };
            totals.paper_seconds += start.elapsed().as_secs_f64();
            if !keeps_bound(&file, &paper, bound)? {
                continue;
            }
            totals.kept += 1;
            if ours.hulls.len() > paper.hulls.len() {
                totals.more += 1;
                print(&format!(
                    "{:4} hulls, the paper's {:4}, at {bound}  {}",
                    ours.hulls.len(),
                    paper.hulls.len(),
                    mesh.name
                ))?;
            }
        }
    }
    for (bound, totals) in arguments.bound.iter().zip(totals) {
        let Totals { meshes, kept, more, hulls, seconds, paper_seconds } = totals;
        print(&format!(
            "at {bound}: the paper's hulls keep the bound on {kept} of {meshes} meshes, ours are \
             more on {more}; {hulls} hulls, {seconds:.1} s, the paper's search {paper_seconds:.1} s"
        ))?;
    }
    Ok(())
}

/// Whether hulls keep the bound, by samples first.
fn keeps_bound(
    file: &MeshFile,
    found: &Decomposition<SurfaceReport>,
    bound: f64,
) -> Result<bool, Failure> {
    const SAMPLES: usize = 5000;

    let mut options = MeasureOptions::default();
    options.hull_samples = SAMPLES;
    options.mesh_samples = SAMPLES;
    options.volume_samples = 1;
    options.flatness = Length::Share(bound);
    let Ok(judged) = measure(file, &found.hulls, &options, &Control::new()) else {
        return Ok(false);
    };
    if judged.hausdorff > bound {
        return Ok(false);
    }
    let solid = Method::from(SurfaceParameters::paper()).solid().max_error(Length::Share(bound));
    let tree = MergeTree::from_hulls(file, &found.hulls, &solid, &Control::new())?;
    let error = tree.curve().first().map_or(f64::INFINITY, |point| point.error);
    Ok(error <= bound * found.run.diagonal)
}
