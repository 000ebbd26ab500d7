//! `cargo lab volume`: volume and distance at CoACD's own number of hulls.

use std::path::PathBuf;

use hullwright::internals::terminal::{Failure, print};
use hullwright::io::{MeshFile, read_mesh};
use hullwright::measure::MeasureOptions;
use hullwright::{Control, decompose};

use crate::runs::data_folder::{DataFolder, ToolResult};
use crate::runs::judge::{Judged, judge};
use crate::runs::methods::bounded;
use crate::statistics::{geometric_mean, mean};

/// Compare volume and distance with CoACD's, at CoACD's own number of hulls
///
/// Of several bounds the one that ends with the most hulls counts that are no more than CoACD's.
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with peers/results.tsv, as for `targets`
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// Only meshes whose name holds this
    #[arg(long, value_name = "TEXT", default_value = "")]
    filter: String,
}

/// The bounds between which CoACD's number of hulls is looked for, in diagonals, and how often the
/// interval is halved, by its logarithm: to a tenth.
const BOUNDS: [f64; 2] = [0.002, 0.06];
const HALVINGS: usize = 5;

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
        let (bound, judged) = at_hulls(&file, coacd.hulls)?;
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
         {:.3}",
        pairs.len(),
        geometric_mean(ratios).unwrap_or(0.0)
    ))
}

/// The bound with the most hulls that are no more than `most`, and what its hulls are judged to be.
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
        let is_exact = found.hulls.len() == most;
        best = Some((bound, found));
        if is_exact {
            break;
        }
    }
    let (bound, found) = match best {
        Some(best) => best,
        None => (high, decompose(file, &bounded(high), &Control::new())?),
    };
    let mut options = MeasureOptions::default();
    options.hull_samples = SURFACE_SAMPLES;
    options.mesh_samples = SURFACE_SAMPLES;
    options.volume_samples = VOLUME_SAMPLES;
    Ok((bound, judge(file.mesh.view(), &found.hulls, &options)?))
}
