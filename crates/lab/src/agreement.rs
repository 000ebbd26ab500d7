//! `cargo lab agreement`: `hullwright::measure` against another evaluator.
//!
//! The other evaluator samples at random, 20,000 points on surfaces and 60,000 in space, so that
//! its figures have an error of their own. Where one is farther from ours than agreed:
//! - `^`: a maximum above theirs. Ours is a point that sticks out so far, and theirs missed it.
//! - `~`: no farther than such samples scatter: within the range of 100 measurements of ours with as
//!   many random points; for IoU within three standard deviations of a share of so many points.
//! - `!`: neither.

use std::collections::HashMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::{read_hulls, read_mesh};
use hullwright::measure::{HullShape, MeasureOptions, Measurement, measure};

use crate::output::Failure;

/// Compare `measure` with another evaluator, figure by figure, on hull files of other tools
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with peers/results.tsv, the hulls in peers/coacd and peers/vhacd_parry, and the
    /// meshes in meshes (those of glTF scenes flattened in peers/src)
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Agreed deviation of lengths, relative to the other evaluator's.
const RELATIVE: f64 = 0.05;

/// Agreed deviation of exposed distances, hollow, and IoU.
const ABSOLUTE: f64 = 0.005;

const THEIR_SURFACE_POINTS: usize = 20_000;
const THEIR_VOLUME_POINTS: f64 = 60_000.0;

/// Samples that show how much such samples scatter.
const REPEATS: u64 = 100;

/// A figure that both evaluators give.
struct Figure {
    column: &'static str,
    is_relative: bool,
    is_maximum: bool,
    of: fn(&Measurement) -> Option<f64>,
}

const FIGURES: [Figure; 8] = [
    Figure { column: "haus", is_relative: true, is_maximum: true, of: |m| Some(m.hausdorff) },
    Figure {
        column: "out_mean",
        is_relative: true,
        is_maximum: false,
        of: |m| Some(m.phantom.mean),
    },
    Figure { column: "out_p99", is_relative: true, is_maximum: false, of: |m| Some(m.phantom.p99) },
    Figure { column: "out_max", is_relative: true, is_maximum: true, of: |m| Some(m.phantom.max) },
    Figure {
        column: "in_mean",
        is_relative: false,
        is_maximum: false,
        of: |m| Some(m.exposed.mean),
    },
    Figure { column: "in_max", is_relative: false, is_maximum: true, of: |m| Some(m.exposed.max) },
    Figure { column: "hollow", is_relative: false, is_maximum: false, of: |m| m.hollow },
    Figure { column: "iou", is_relative: false, is_maximum: false, of: |m| m.iou },
];

/// How often a figure agrees.
#[derive(Clone, Copy, Default)]
struct Tally {
    compared: usize,
    agreed: usize,
    missed: usize,
    scattered: usize,
    deviations: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = &arguments.folder;
    if !folder.join("peers/results.tsv").is_file() {
        return Err(format!("{}: there is no peers/results.tsv", folder.display()).into());
    }
    Ok(compare(folder)?)
}

fn compare(folder: &Path) -> Result<(), Box<dyn Error>> {
    let table = std::fs::read_to_string(folder.join("peers/results.tsv"))?;
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().unwrap_or_default().split('\t').collect();
    let columns: Vec<String> =
        FIGURES.iter().map(|figure| format!("{:>9}", figure.column)).collect();
    println!("{:51} {:6} {:>5} {}  seconds", "mesh", "method", "hulls", columns.join(""));
    let mut tallies = [Tally::default(); FIGURES.len()];
    let (mut rows, mut equal_counts, mut seconds) = (0, 0, 0.0);
    for line in lines {
        let row: HashMap<&str, &str> = header.iter().copied().zip(line.split('\t')).collect();
        let cell = |name: &str| row.get(name).copied().unwrap_or_default();
        let (positions, triangles, hulls) = read(folder, cell("mesh"), cell("method"))?;
        let hulls: Vec<HullShape<'_>> = hulls.iter().map(HullShape::from).collect();
        let judge = |options: &MeasureOptions| measure(&positions, &triangles, &hulls, options);
        let start = Instant::now();
        let ours = judge(&MeasureOptions::default())?;
        let elapsed = start.elapsed().as_secs_f64();
        seconds += elapsed;
        rows += 1;
        let more_hulls = ours.hulls as i64 - cell("hulls").parse::<i64>()?;
        equal_counts += usize::from(more_hulls == 0);

        let method = cell("method").split('-').next().unwrap_or_default();
        let mut text = format!("{:51} {method:6} {more_hulls:>+5} ", cell("mesh"));
        let mut repeats = None;
        for (figure, tally) in FIGURES.iter().zip(&mut tallies) {
            let (Some(value), Ok(theirs)) = ((figure.of)(&ours), cell(figure.column).parse())
            else {
                let given = [(figure.of)(&ours).is_some(), !cell(figure.column).is_empty()];
                text += if given[0] == given[1] { "        –" } else { "   given?" };
                continue;
            };
            let deviation = deviation(figure, value, theirs);
            let limit = if figure.is_relative { RELATIVE } else { ABSOLUTE };
            tally.compared += 1;
            tally.deviations += deviation.abs();
            let mark = if deviation.abs() <= limit {
                tally.agreed += 1;
                ' '
            } else if figure.is_maximum && deviation > 0.0 {
                tally.missed += 1;
                '^'
            } else if is_scatter(figure, theirs, &ours, &mut repeats, &judge)? {
                tally.scattered += 1;
                '~'
            } else {
                '!'
            };
            text += &match figure.is_relative {
                true => format!("{:>+7.1}%{mark}", 100.0 * deviation),
                false => format!("{deviation:>+8.4}{mark}"),
            };
        }
        println!("{text}  {elapsed:.2}");
    }

    println!(
        "\n^ theirs missed a point that is farther out; ~ theirs is within scatter; ! neither"
    );
    println!(
        "hulls: {equal_counts} of {rows} counts equal; {:.2} s each",
        seconds / f64::from(rows)
    );
    for (figure, tally) in FIGURES.iter().zip(tallies) {
        let average = tally.deviations / tally.compared.max(1) as f64;
        let (limit, average) = match figure.is_relative {
            true => ("5 %", format!("{:.2} %", 100.0 * average)),
            false => ("0.005", format!("{average:.5}")),
        };
        println!(
            "{:9} {} of {} within {limit} (and {} ^, {} ~), average deviation {average}",
            figure.column, tally.agreed, tally.compared, tally.missed, tally.scattered
        );
    }
    Ok(())
}

type Case = (Vec<[f64; 3]>, Vec<[u32; 3]>, Vec<hullwright::io::HullMesh>);

fn read(folder: &Path, mesh: &str, method: &str) -> Result<Case, Box<dyn Error>> {
    let name = mesh.replace('/', "_");
    let object = format!("{}.obj", name.rsplit_once('.').map_or(&name[..], |(stem, _)| stem));
    let flattened = folder.join("peers/src").join(&object);
    let source = if flattened.is_file() { flattened } else { folder.join("meshes").join(mesh) };
    let tool = if method.starts_with("vhacd") { "vhacd_parry" } else { "coacd" };
    let file = read_mesh(source)?;
    let hulls = read_hulls(folder.join("peers").join(tool).join(object))?;
    Ok((file.positions, file.triangles, hulls))
}

fn deviation(figure: &Figure, ours: f64, theirs: f64) -> f64 {
    if figure.is_relative { (ours - theirs) / theirs } else { ours - theirs }
}

/// Whether samples as small as theirs scatter as far as their figure.
fn is_scatter(
    figure: &Figure,
    theirs: f64,
    ours: &Measurement,
    repeats: &mut Option<Vec<Measurement>>,
    judge: &impl Fn(&MeasureOptions) -> Result<Measurement, hullwright::Error>,
) -> Result<bool, hullwright::Error> {
    if !figure.is_relative {
        let share = ours.iou.unwrap_or(0.0);
        let samples = &ours.samples;
        let points = THEIR_VOLUME_POINTS * samples.union as f64 / samples.volume as f64;
        let sigma = (share * (1.0 - share) / points).sqrt();
        return Ok(figure.column == "iou" && (share - theirs).abs() <= 3.0 * sigma);
    }
    if repeats.is_none() {
        let measurements = (0..REPEATS).map(|repeat| {
            let mut options = MeasureOptions::default();
            options.hull_samples = THEIR_SURFACE_POINTS;
            options.mesh_samples = THEIR_SURFACE_POINTS;
            options.random_seed = Some(repeat);
            options.volume_samples = 0;
            judge(&options)
        });
        *repeats = Some(measurements.collect::<Result<_, _>>()?);
    }
    let values = || repeats.iter().flatten().filter_map(figure.of);
    let lowest = values().fold(f64::INFINITY, f64::min);
    let highest = values().fold(f64::NEG_INFINITY, f64::max);
    Ok(theirs >= lowest && theirs <= highest)
}
