//! `cargo lab targets`: the bounded method against CoACD and Parry's V-HACD, mesh by mesh.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::read_mesh;
use hullwright::measure::{HullShape, MeasureOptions, measure};
use hullwright::{Control, Parameters, Preset, Unit, decompose};
use meshoptimizer_rs::{Positions, SimplifyOptions, SimplifySettings, Workspace};
use parry3d::math::Vec3;
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};

use crate::output::Failure;

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
    #[arg(long, value_name = "NAME", default_value = "balanced", value_parser = parse_preset)]
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

fn parse_preset(text: &str) -> Result<Preset, String> {
    [Preset::Fast, Preset::Balanced, Preset::Fine]
        .into_iter()
        .find(|preset| preset.name() == text)
        .ok_or_else(|| "the presets are `fast`, `balanced` and `fine`".into())
}

/// Triangles that meshoptimizer is asked for, to compare times.
const SIMPLIFIED: usize = 1000;

/// Rounding of what was verified and of what is sampled.
const ROUNDING: f64 = 1e-6;

/// A row of the peers' table.
struct Peer {
    mesh: String,
    hulls: f64,
    hausdorff: f64,
}

/// What came of a mesh. Lengths are shares of the diagonal.
struct Row {
    hulls: f64,
    vertices_per_hull: f64,
    hausdorff: f64,
    exposed: f64,
    hollow: Option<f64>,
    iou: Option<f64>,
    ratio: f64,
    is_broken: bool,
    seconds: f64,
    vhacd_seconds: f64,
    meshopt_seconds: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { folder, bound, filter, preset } = arguments;
    let mut rows = Vec::new();
    println!(
        "{:<46} {:>6} {:>6} {:>5} {:>7} {:>7} {:>6} {:>6} {:>5} {:>8} {:>8} {:>8}",
        "mesh",
        "hulls",
        "CoACD",
        "v/h",
        "haus.",
        "exposed",
        "hollow",
        "IoU",
        "",
        "ms",
        "V-HACD",
        "meshopt"
    );
    for peer in peers(folder)?.into_iter().filter(|peer| peer.mesh.contains(filter.as_str())) {
        let bound = match *bound {
            Bound::Share(share) => share,
            Bound::Coacd => peer.hausdorff,
        };
        let row = compare(&path(folder, &peer.mesh), &peer, bound, *preset)?;
        let share = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.3}"));
        println!(
            "{:<46} {:>6} {:>6} {:>5.1} {:>7.4} {:>7.4} {:>6} {:>6} {:>5} {:>8.1} {:>8.1} {:>8.1}",
            peer.mesh,
            row.hulls,
            peer.hulls,
            row.vertices_per_hull,
            row.hausdorff,
            row.exposed,
            share(row.hollow),
            share(row.iou),
            if row.is_broken { "BROKE" } else { "" },
            1e3 * row.seconds,
            1e3 * row.vhacd_seconds,
            1e3 * row.meshopt_seconds,
        );
        rows.push(row);
    }
    summary(&rows);
    Ok(())
}

fn peers(folder: &Path) -> Result<Vec<Peer>, Box<dyn Error>> {
    let table = std::fs::read_to_string(folder.join("peers/results.tsv"))?;
    let rows = table.lines().skip(1).map(|line| line.split('\t').collect::<Vec<_>>());
    let coacd = rows.filter(|row| row.get(1).is_some_and(|method| method.starts_with("coacd")));
    coacd
        .map(|row| {
            Ok(Peer { mesh: row[0].into(), hulls: row[3].parse()?, hausdorff: row[5].parse()? })
        })
        .collect()
}

fn path(folder: &Path, mesh: &str) -> PathBuf {
    let flat = Path::new(&mesh.replace('/', "_")).with_extension("obj");
    let flat = folder.join("peers/src").join(flat);
    if flat.exists() { flat } else { folder.join("meshes").join(mesh) }
}

fn compare(path: &Path, peer: &Peer, bound: f64, preset: Preset) -> Result<Row, Box<dyn Error>> {
    let file = read_mesh(path)?;
    let mut parameters = Parameters::default();
    parameters.bounded.max_error = Unit::Diagonals(bound);
    parameters.bounded.preset = preset;
    let start = Instant::now();
    let result = decompose(&file.positions, &file.triangles, &parameters, &Control::new())?;
    let seconds = start.elapsed().as_secs_f64();
    let verified = result.report.bounded.as_ref().ok_or("the default is not the bounded method")?;
    let shapes: Vec<HullShape<'_>> = result.hulls.iter().map(HullShape::from).collect();
    let mut options = MeasureOptions::default();
    options.hull_samples = 20_000;
    options.mesh_samples = 20_000;
    options.volume_samples = 60_000;
    let measured = measure(&file.positions, &file.triangles, &shapes, &options)?;
    let relative = |length: f64| length / result.report.diagonal;
    let is_broken = verified.phantom_max > verified.bound * (1.0 + ROUNDING)
        || verified.exposed_max > verified.bound * (1.0 + ROUNDING)
        || measured.phantom.max > relative(verified.phantom_max) + ROUNDING
        || measured.exposed.max > relative(verified.exposed_max) + ROUNDING;
    Ok(Row {
        hulls: measured.hulls as f64,
        vertices_per_hull: measured.vertices as f64 / measured.hulls as f64,
        hausdorff: measured.hausdorff,
        exposed: measured.exposed.max,
        hollow: measured.hollow,
        iou: measured.iou,
        ratio: measured.hulls as f64 / peer.hulls,
        is_broken,
        seconds,
        vhacd_seconds: vhacd(&file.positions, &file.triangles),
        meshopt_seconds: meshopt_time(&file.positions, &file.triangles),
    })
}

/// Parry's V-HACD with its defaults, hulls included.
fn vhacd(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let points: Vec<Vec3> =
        positions.iter().map(|p| Vec3::new(p[0] as f32, p[1] as f32, p[2] as f32)).collect();
    let start = Instant::now();
    let parts = VHACD::decompose(&VHACDParameters::default(), &points, triangles, true);
    std::hint::black_box(parts.compute_exact_convex_hulls(&points, triangles));
    start.elapsed().as_secs_f64()
}

fn meshopt_time(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
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

fn summary(rows: &[Row]) {
    let of = |value: &dyn Fn(&Row) -> Option<f64>| {
        let mut values: Vec<f64> = rows.iter().filter_map(value).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let median = |values: &[f64]| values.get(values.len() / 2).copied().unwrap_or(0.0);
    let worst = |values: &[f64]| values.last().copied().unwrap_or(0.0);
    let hollow = of(&|row| row.hollow);
    let logarithms = of(&|row| Some(row.ratio.ln()));
    let at_most =
        rows.iter().filter(|row| row.ratio <= 1.0).count() as f64 / rows.len().max(1) as f64;
    let broken = rows.iter().filter(|row| row.is_broken).count();
    println!("\nmeshes {}, broken promises {broken}", rows.len());
    println!("hulls, mean                     {:.2}", mean(&of(&|row| Some(row.hulls))));
    println!("Hausdorff, mean                 {:.4}", mean(&of(&|row| Some(row.hausdorff))));
    println!("exposed, mean of the worst      {:.5}", mean(&of(&|row| Some(row.exposed))));
    println!("hollow, mean and worst          {:.4} {:.3}", mean(&hollow), worst(&hollow));
    println!("IoU, mean                       {:.3}", mean(&of(&|row| row.iou)));
    println!(
        "vertices per hull, mean         {:.1}",
        mean(&of(&|row| Some(row.vertices_per_hull)))
    );
    println!("hulls over CoACD's, geom. mean  {:.3}", mean(&logarithms).exp());
    println!("meshes with no more than CoACD  {:.0} %", 100.0 * at_most);
    println!("milliseconds, median            {:.1}", 1e3 * median(&of(&|row| Some(row.seconds))));
    println!(
        "time over V-HACD's, median      {:.2}",
        median(&of(&|row| Some(row.seconds / row.vhacd_seconds)))
    );
    println!(
        "time over meshopt's, median     {:.1}",
        median(&of(&|row| Some(row.seconds / row.meshopt_seconds)))
    );
}
