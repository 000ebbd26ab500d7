//! `cargo lab volume`: volume and distance at CoACD's own number of hulls.

use std::path::PathBuf;

use hullwright::io::{MeshFile, read_mesh};
use hullwright::measure::MeasureOptions;
use hullwright::{Control, Decomposition, decompose};
use hullwright_cli::terminal::{Failure, print};

use crate::runs::data_folder::{DataFolder, ToolResult};
use crate::runs::judge::{Judged, judge};
use crate::runs::methods::bounded;
use crate::statistics::{mean, median};

/// Compare volume and distance with CoACD's, at CoACD's own number of hulls
///
/// The smallest bound counts that ends with no more hulls than CoACD's; or what the cap on hulls finds.
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with peers/results.tsv, as for `targets`
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// Only meshes whose name holds this
    #[arg(long, value_name = "TEXT", default_value = "")]
    filter: String,

    /// Ask for CoACD's number of hulls by the cap on hulls
    #[arg(long)]
    cap: bool,
}

/// The bounds between which CoACD's number of hulls is looked for, in diagonals, and how often the
/// interval is halved, by its logarithm: to 3 %.
const BOUNDS: [f64; 2] = [0.002, 0.06];
const HALVINGS: usize = 7;

/// Points on hulls, on the mesh, and in space, as in `targets`.
const SURFACE_SAMPLES: usize = 20_000;
const VOLUME_SAMPLES: usize = 60_000;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = DataFolder(arguments.folder.clone());
    let is_asked_for = |result: &ToolResult| {
        result.method.starts_with("coacd") && result.mesh.contains(&arguments.filter)
    };
    let (mut ratios, mut pairs) = (Vec::new(), Vec::new());
    for coacd in folder.tool_results()?.into_iter().filter(is_asked_for) {
        let Ok(file) = read_mesh(folder.flat_mesh(&coacd.mesh)) else { continue };
        let (bound, judged) = match arguments.cap {
            true => under_cap(&file, coacd.hulls)?,
            false => at_hulls(&file, coacd.hulls)?,
        };
        let ratio = coacd.hausdorff.map(|theirs| judged.hausdorff / theirs);
        ratios.extend(ratio);
        let pair = judged.iou.zip(coacd.iou);
        pairs.extend(pair);
        let [ours, theirs] = pair.map_or(["–".into(), "–".into()], |(ours, theirs)| {
            [ours, theirs].map(|iou| format!("{iou:.3}"))
        });
        print(&format!(
            "{:<46} {:4} of {:4} hulls at {bound:.4}  IoU {ours:>5} {theirs:>5} {:<6} Hausdorff {:.4} {:.2} \
             overlap {:.2} uncovered volume {:.3} protrusion {:.5} {:.5}",
            coacd.mesh,
            judged.hulls,
            coacd.hulls,
            if pair.is_some_and(|(ours, theirs)| ours > theirs) { "better" } else { "" },
            judged.hausdorff,
            ratio.unwrap_or(0.0),
            judged.overlap.unwrap_or(0.0),
            judged.uncovered_volume.unwrap_or(0.0),
            judged.protrusion_mean,
            coacd.protrusion_mean.unwrap_or(0.0),
        ))?;
    }
    let better = pairs.iter().filter(|(ours, theirs)| ours > theirs).count();
    let [ours, theirs] = [0, 1]
        .map(|side| mean(&pairs.iter().map(|pair| [pair.0, pair.1][side]).collect::<Vec<f64>>()));
    print(&format!(
        "IoU better on {better} of {} closed meshes, {ours:.4} and {theirs:.4} in the mean; Hausdorff over CoACD's \
         {:.3} in the median",
        pairs.len(),
        median(ratios)
    ))
}

/// The smallest bound found that ends with no more hulls than `most`, and what its hulls are judged to be.
fn at_hulls(file: &MeshFile, most: usize) -> Result<(f64, Judged), Failure> {
    let [mut low, mut high] = BOUNDS;
    let mut best = None;
    for _ in 0..=HALVINGS {
        let bound = (low * high).sqrt();
        let found = decompose(file, &bounded(bound), &Control::new())?;
        if found.hulls.len() > most {
            low = bound;
            continue;
        }
        high = bound;
        best = Some((bound, found));
    }
    let (bound, found) = match best {
        Some(best) => best,
        None => (high, decompose(file, &bounded(high), &Control::new())?),
    };
    Ok((bound, judge_samples(file, &found)?))
}

/// The error with the cap on hulls, and what its hulls are judged to be.
fn under_cap(file: &MeshFile, most: usize) -> Result<(f64, Judged), Failure> {
    let parameters = bounded(BOUNDS[0]).max_hulls(most);
    let found = decompose(file, &parameters, &Control::new())?;
    let error = found.report.protrusion_max / found.run.diagonal;
    Ok((error, judge_samples(file, &found)?))
}

fn judge_samples(file: &MeshFile, found: &Decomposition) -> Result<Judged, Failure> {
    let mut options = MeasureOptions::default();
    options.hull_samples = SURFACE_SAMPLES;
    options.mesh_samples = SURFACE_SAMPLES;
    options.volume_samples = VOLUME_SAMPLES;
    Ok(judge(file.mesh.view(), &found.hulls, &options)?)
}
