//! `cargo lab targets`: the bounded method against CoACD and Parry's V-HACD, mesh by mesh.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::read_mesh;
use hullwright::measure::MeasureOptions;
use hullwright::{Control, Preset, decompose};
use hullwright_cli::terminal::{Failure, print};
use meshoptimizer_rs::{Positions, SimplifyOptions, SimplifySettings, Workspace};

use crate::runs::data_folder::{DataFolder, ToolResult};
use crate::runs::judge::{Judged, Verified, judge};
use crate::runs::methods::bounded;
use crate::runs::vhacd;
use crate::statistics::{geometric_mean, mean, median, range};

/// Compare the bounded method with CoACD and Parry's V-HACD, mesh by mesh
///
/// V-HACD's and meshoptimizer's times are taken in the same run. A promise is broken where more is
/// sampled than was verified, or verified than was asked for.
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with peers/results.tsv, which names the meshes and what CoACD returned, and the
    /// meshes in meshes (those of glTF scenes flattened in peers/src)
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// The bound: a share of the diagonal, or `coacd` for CoACD's own Hausdorff distance on each
    /// mesh
    #[arg(long, value_name = "SHARE", default_value = "0.02", value_parser = parse_bound)]
    bound: Bound,

    /// Only meshes whose name holds this
    #[arg(long, value_name = "TEXT", default_value = "")]
    filter: String,

    /// fast, balanced or fine
    #[arg(long, value_name = "NAME", default_value = "balanced")]
    preset: Preset,
}

/// What the bounded method is asked for.
#[derive(Debug, Clone, Copy)]
enum Bound {
    /// This share of the diagonal.
    Share(f64),
    /// CoACD's own Hausdorff distance.
    Coacd,
}

fn parse_bound(text: &str) -> Result<Bound, String> {
    if text == "coacd" {
        return Ok(Bound::Coacd);
    }
    let share = text.parse().map_err(|_| "a share of the diagonal or `coacd` is expected")?;
    Ok(Bound::Share(share))
}

/// Triangles that meshoptimizer is asked for, to compare times: about as many as the search of the
/// bounded method works on.
const SIMPLIFIED: usize = 1000;

/// Rounding of what was verified and of what is sampled, in diagonals.
const ROUNDING: f64 = 1e-6;

/// Points on hulls, on the mesh, and in space: those of the evaluator that `peers/results.tsv` is
/// from.
const SURFACE_SAMPLES: usize = 20_000;
const VOLUME_SAMPLES: usize = 60_000;

/// What came of a mesh.
struct Row {
    judged: Judged,
    coacd_hulls: f64,
    is_broken: bool,
    seconds: f64,
    vhacd_seconds: f64,
    meshopt_seconds: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = DataFolder(arguments.folder.clone());
    let mut rows = Vec::new();
    print(&format!(
        "{:<46} {:>6} {:>6} {:>5} {:>7} {:>9} {:>9} {:>6} {:>5} {:>8} {:>8} {:>8}",
        "mesh",
        "hulls",
        "CoACD",
        "v/h",
        "haus.",
        "uncovered",
        "unc. vol.",
        "IoU",
        "",
        "ms",
        "V-HACD",
        "meshopt"
    ))?;
    let results = folder.tool_results()?.into_iter();
    let is_asked_for = |result: &ToolResult| {
        result.method.starts_with("coacd") && result.mesh.contains(&arguments.filter)
    };
    for coacd in results.filter(is_asked_for) {
        let bound = match arguments.bound {
            Bound::Share(share) => share,
            Bound::Coacd => {
                coacd.hausdorff.ok_or_else(|| format!("{}: no distance", coacd.mesh))?
            }
        };
        let path = folder.flat_mesh(&coacd.mesh);
        let row = compare(&path, coacd.hulls as f64, bound, arguments.preset)?;
        print(&row.line(&coacd.mesh))?;
        rows.push(row);
    }
    print(&summary(&rows))
}

impl Row {
    fn line(&self, mesh: &str) -> String {
        let Self { judged, coacd_hulls, is_broken, .. } = self;
        let share = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.3}"));
        format!(
            "{mesh:<46} {:>6} {coacd_hulls:>6} {:>5.1} {:>7.4} {:>9.4} {:>9} {:>6} {:>5} {:>8.1} \
             {:>8.1} {:>8.1}",
            judged.hulls,
            self.vertices_per_hull(),
            judged.hausdorff,
            judged.uncovered_max,
            share(judged.uncovered_volume),
            share(judged.iou),
            if *is_broken { "BROKE" } else { "" },
            1e3 * self.seconds,
            1e3 * self.vhacd_seconds,
            1e3 * self.meshopt_seconds,
        )
    }

    fn vertices_per_hull(&self) -> f64 {
        self.judged.vertices as f64 / self.judged.hulls as f64
    }

    /// Hulls over CoACD's.
    fn ratio(&self) -> f64 {
        self.judged.hulls as f64 / self.coacd_hulls
    }
}

fn compare(path: &Path, coacd_hulls: f64, bound: f64, preset: Preset) -> Result<Row, Failure> {
    let file = read_mesh(path)?;
    let parameters = bounded(bound).preset(preset);
    let start = Instant::now();
    let result = decompose(&file, &parameters, &Control::new())?;
    let seconds = start.elapsed().as_secs_f64();
    let verified = Verified::of(&result);
    let mut options = MeasureOptions::default();
    options.hull_samples = SURFACE_SAMPLES;
    options.mesh_samples = SURFACE_SAMPLES;
    options.volume_samples = VOLUME_SAMPLES;
    let judged = judge(file.mesh.view(), &result.hulls, &options)?;
    let start = Instant::now();
    let default = vhacd::VHACDParameters::default();
    std::hint::black_box(vhacd::decompose((&file).into(), &default));
    let vhacd_seconds = start.elapsed().as_secs_f64();
    Ok(Row {
        is_broken: verified.is_broken(&judged, ROUNDING),
        judged,
        coacd_hulls,
        seconds,
        vhacd_seconds,
        meshopt_seconds: meshopt_seconds(&file.mesh.positions, &file.mesh.triangles),
    })
}

fn meshopt_seconds(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let points: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let start = Instant::now();
    let settings = SimplifySettings {
        target_index_count: 3 * SIMPLIFIED.min(triangles.len()),
        target_error: f32::MAX,
        options: SimplifyOptions::EMPTY,
    };
    let positions = Positions::from_packed(&points);
    let mut workspace = Workspace::default();
    let simplified =
        meshoptimizer_rs::simplify(triangles.as_flattened(), positions, settings, &mut workspace);
    std::hint::black_box(simplified.ok());
    start.elapsed().as_secs_f64()
}

fn summary(rows: &[Row]) -> String {
    let of = |value: &dyn Fn(&Row) -> Option<f64>| -> Vec<f64> {
        rows.iter().filter_map(value).collect()
    };
    let all = |value: fn(&Row) -> f64| -> Vec<f64> { rows.iter().map(value).collect() };
    let uncovered = of(&|row| row.judged.uncovered_volume);
    let (_, worst) = range(uncovered.iter().copied());
    let at_most = rows.iter().filter(|row| row.ratio() <= 1.0).count() as f64;
    let lines = [
        ("hulls, mean", format!("{:.2}", mean(&all(|row| row.judged.hulls as f64)))),
        ("Hausdorff, mean", format!("{:.4}", mean(&all(|row| row.judged.hausdorff)))),
        (
            "uncovered distance, mean of the worst",
            format!("{:.5}", mean(&all(|row| row.judged.uncovered_max))),
        ),
        ("uncovered volume, mean and worst", format!("{:.4} {worst:.3}", mean(&uncovered))),
        ("IoU, mean", format!("{:.3}", mean(&of(&|row| row.judged.iou)))),
        ("vertices per hull, mean", format!("{:.1}", mean(&all(Row::vertices_per_hull)))),
        (
            "hulls over CoACD's, geometric mean",
            format!("{:.3}", geometric_mean(all(Row::ratio)).unwrap_or(f64::NAN)),
        ),
        (
            "meshes with no more hulls than CoACD",
            format!("{:.0} %", 100.0 * at_most / rows.len().max(1) as f64),
        ),
        ("milliseconds, median", format!("{:.1}", 1e3 * median(all(|row| row.seconds)))),
        (
            "time over V-HACD's, median",
            format!("{:.2}", median(all(|row| row.seconds / row.vhacd_seconds))),
        ),
        (
            "time over meshoptimizer's, median",
            format!("{:.1}", median(all(|row| row.seconds / row.meshopt_seconds))),
        ),
    ];
    let broken = rows.iter().filter(|row| row.is_broken).count();
    let lines: String = lines.iter().map(|(name, value)| format!("\n{name:<38} {value}")).collect();
    format!("\nmeshes {}, broken promises {broken}{lines}", rows.len())
}
