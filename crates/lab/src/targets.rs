//! `cargo lab targets`: the bounded method against CoACD and Parry's V-HACD, mesh by mesh.

use std::path::PathBuf;

use hullwright::{Control, Preset, decompose};
use hullwright_formats::read_mesh;

use crate::harness::session::limits;
use crate::harness::{FULL, Judge, Row, Session, Task};
use crate::report::{Table, number_or_nothing};
use crate::statistics::{geometric_mean, mean, median, range};
use crate::terminal::{Failure, print};
use crate::tools::data_folder::{DataFolder, ToolResult};
use crate::tools::meshes::{self, Mesh};
use crate::tools::methods::{Run, bounded};

/// Compare the bounded method with CoACD and Parry's V-HACD, mesh by mesh
///
/// V-HACD's times are taken in the same run, and ours on all threads are compared with them. A
/// promise is broken where more is sampled than was verified, or verified than was asked for.
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with peers/results.tsv, which names the meshes and what CoACD returned, and the
    /// meshes in meshes (those of glTF scenes flattened in peers/src)
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// The bound: a fraction of the diagonal; `coacd` or `vhacd` for their Hausdorff distance on
    /// each mesh; or `coacd-hulls` for the smallest one that ends with no more hulls than CoACD's
    #[arg(long, value_name = "BOUND", default_value = "0.02", value_parser = parse_bound)]
    bound: Bound,

    /// Only meshes whose name holds this
    #[arg(long, value_name = "TEXT", default_value = "")]
    filter: String,

    /// fast, balanced or fine
    #[arg(long, value_name = "NAME", default_value = "balanced")]
    preset: Preset,

    /// Compare with V-HACD alone, on the meshes below these folders
    #[arg(long, value_name = "DIR", num_args = 1..)]
    meshes: Vec<PathBuf>,

    /// Of those, only props: 50 to 2,000 triangles
    #[arg(long, requires = "meshes")]
    props: bool,

    /// Keep runs in this folder, and do not repeat those that are there
    #[arg(short, long, value_name = "REPORT")]
    output: Option<PathBuf>,
}

/// What the bounded method is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bound {
    Share(f64),
    Coacd,
    Vhacd,
    CoacdHulls,
}

fn parse_bound(text: &str) -> Result<Bound, String> {
    match text {
        "coacd" => Ok(Bound::Coacd),
        "vhacd" => Ok(Bound::Vhacd),
        "coacd-hulls" => Ok(Bound::CoacdHulls),
        share => share.parse().map(Bound::Share).map_err(|_| {
            "a fraction of the diagonal, `coacd`, `vhacd` or `coacd-hulls` is expected".into()
        }),
    }
}

/// As in the benchmark: seconds, and megabytes.
const LIMITS: (f64, u64) = (300.0, 4096);

/// Points on hulls, on the mesh, and in space: those of the evaluator that `peers/results.tsv` is
/// from.
const JUDGE: Judge = Judge { surface_samples: 20_000, volume_samples: 60_000, ..FULL };

const PROP: std::ops::RangeInclusive<usize> = 50..=2000;

/// The bounds between which CoACD's number of hulls is looked for, as fractions of the diagonal,
/// and how often the interval is halved, by its logarithm: to 3 %.
pub const BOUNDS: [f64; 2] = [0.002, 0.06];
pub const HALVINGS: usize = 7;

/// Ours and theirs on one mesh.
struct Pair {
    ours: Row,
    vhacd: Row,
    coacd: Option<ToolResult>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let limits = limits(LIMITS.0, LIMITS.1)?;
    let session = match &arguments.output {
        Some(output) => Session::open(output, limits)?,
        None => Session::temporary(limits)?,
    };
    let mut pairs = Vec::new();
    let meshes = meshes_of(arguments)?;
    for (number, (mesh, coacd)) in meshes.iter().enumerate() {
        let place = (number + 1, meshes.len());
        let Some(vhacd) = session.row(place, mesh, &Task::new(Run::VHACD_DEFAULT, JUDGE))? else {
            continue;
        };
        if arguments.props && !vhacd.triangles.is_some_and(|count| PROP.contains(&count)) {
            continue;
        }
        let error = match (arguments.bound, coacd) {
            (Bound::Share(share), _) => Some(share),
            (Bound::Vhacd, _) => vhacd.hausdorff,
            (Bound::Coacd, coacd) => coacd.as_ref().and_then(|coacd| coacd.hausdorff),
            (Bound::CoacdHulls, Some(coacd)) => Some(bound_of_hulls(mesh, coacd.hulls)?),
            (Bound::CoacdHulls, None) => None,
        };
        let Some(error) = error else {
            print(&format!("{}: nothing to compare with", mesh.name))?;
            continue;
        };
        let run = Run::Bounded { error, preset: arguments.preset };
        if let Some(ours) = session.row(place, mesh, &Task::new(run, JUDGE))? {
            pairs.push(Pair { ours, vhacd, coacd: coacd.clone() });
        }
    }
    pairs.retain(|pair| pair.ours.is_done() && pair.vhacd.is_done());
    print(&format!("\n{}", summary(&pairs).to_markdown()))
}

/// The meshes, and what CoACD returned for them.
fn meshes_of(arguments: &Arguments) -> Result<Vec<(Mesh, Option<ToolResult>)>, Failure> {
    if !arguments.meshes.is_empty() {
        let mut meshes = meshes::find(&arguments.meshes)?;
        meshes.retain(|mesh| mesh.name.contains(&arguments.filter));
        return Ok(meshes.into_iter().map(|mesh| (mesh, None)).collect());
    }
    let folder = DataFolder(arguments.folder.clone());
    let mut found = Vec::new();
    for result in folder.tool_results()? {
        if result.method.starts_with("coacd") && result.mesh.contains(&arguments.filter) {
            let mesh = meshes::find(&[folder.flat_mesh(&result.mesh)])?.into_iter().next();
            let named = mesh.map(|mesh| Mesh { name: result.mesh.clone(), ..mesh });
            found.extend(named.map(|mesh| (mesh, Some(result))));
        }
    }
    Ok(found)
}

/// The smallest bound found that ends with no more hulls than `most`.
pub fn bound_of_hulls(mesh: &Mesh, most: usize) -> Result<f64, Failure> {
    let file = read_mesh(&mesh.path)?;
    let [mut low, mut high] = BOUNDS;
    for _ in 0..=HALVINGS {
        let bound = (low * high).sqrt();
        let found = decompose(&file, &bounded(bound), &Control::new())?;
        if found.hulls.len() > most {
            low = bound;
        } else {
            high = bound;
        }
    }
    Ok(high)
}

impl Pair {
    /// Hulls over CoACD's, or where CoACD did not run over V-HACD's.
    fn hulls(&self) -> Option<f64> {
        let theirs = self.coacd.as_ref().map_or(self.vhacd.hulls, |coacd| Some(coacd.hulls));
        Some(self.ours.hulls? as f64 / theirs? as f64)
    }

    /// Time over V-HACD's.
    fn time(&self) -> Option<f64> {
        Some(self.ours.seconds_all_threads? / self.vhacd.seconds?)
    }

    fn ious(&self) -> Option<(f64, f64)> {
        self.ours.iou.zip(self.coacd.as_ref().and_then(|coacd| coacd.iou))
    }

    fn distance(&self) -> Option<f64> {
        Some(self.ours.hausdorff? / self.coacd.as_ref()?.hausdorff?)
    }
}

fn summary(pairs: &[Pair]) -> Table {
    let of =
        |value: fn(&Pair) -> Option<f64>| -> Vec<f64> { pairs.iter().filter_map(value).collect() };
    let some = |values: &[f64], of: fn(&[f64]) -> f64| {
        number_or_nothing((!values.is_empty()).then(|| of(values)))
    };
    let middle = |values: &[f64]| median(values.to_vec());
    let most = |values: &[f64]| range(values.iter().copied()).1;
    let share = |part: usize, all: usize| {
        let percent = 100.0 * part as f64 / all.max(1) as f64;
        format!("{percent:.0} % of {all}")
    };
    let hulls = of(Pair::hulls);
    let no_more = hulls.iter().filter(|ratio| **ratio <= 1.0).count();
    let ious: Vec<(f64, f64)> = pairs.iter().filter_map(Pair::ious).collect();
    let better = ious.iter().filter(|(ours, theirs)| ours > theirs).count();
    let time = of(Pair::time);
    let seconds = of(|pair| pair.ours.seconds_all_threads);
    let volume = of(|pair| pair.ours.uncovered_volume);
    let broken = pairs.iter().filter(|pair| !pair.ours.broken.is_empty()).count();
    let lines = [
        ("meshes", pairs.len().to_string()),
        ("broken promises", broken.to_string()),
        ("hulls, mean", some(&of(|pair| Some(pair.ours.hulls? as f64)), mean)),
        ("hulls over theirs, geometric mean", number_or_nothing(geometric_mean(hulls.clone()))),
        ("no more hulls than theirs", share(no_more, hulls.len())),
        ("Hausdorff, mean", some(&of(|pair| pair.ours.hausdorff), mean)),
        ("Hausdorff over CoACD's, median", some(&of(Pair::distance), middle)),
        ("uncovered distance, mean of the worst", some(&of(|pair| pair.ours.uncovered_max), mean)),
        ("uncovered volume, mean", some(&volume, mean)),
        ("uncovered volume, worst", some(&volume, most)),
        ("IoU, mean", some(&of(|pair| pair.ours.iou), mean)),
        ("IoU better than CoACD's", share(better, ious.len())),
        ("vertices per hull, mean", {
            some(&of(|pair| Some(pair.ours.vertices? as f64 / pair.ours.hulls? as f64)), mean)
        }),
        ("seconds, median", some(&seconds, middle)),
        ("seconds, slowest", some(&seconds, most)),
        ("time over V-HACD's, median", some(&time, middle)),
        ("time over V-HACD's, slowest", some(&time, most)),
    ];
    let mut table = Table::new("All", "", &["what", "value"]);
    table.rows = lines.map(|(name, value)| vec![name.into(), value]).to_vec();
    table
}
