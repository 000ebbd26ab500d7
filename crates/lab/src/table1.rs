//! `cargo lab table1`: the paper's Table 1, ours beside its own, and how far apart they are.
//!
//! The first table has the thresholds in the meshes' own units, as the paper must have
//! had them, the second in the default unit, which is relative to the diagonal; a sweep over
//! other units follows, with the score and with the pieces at the paper's own p and r, which no
//! rule of the search can disturb.
//!
//! The distance between two rows is |log2| of the ratio of their pieces and of their average
//! pieces, and half a point for each step between their p and between their r: twice the pieces
//! weigh as much as two steps. The score of a table is the mean over its rows.

use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::read_mesh;
use hullwright::{Control, Parameters, SurfaceParameters, Unit, decompose};

use crate::output::Failure;

/// Compare the surface method with the paper's Table 1, over units of the thresholds
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with paper/table1.tsv, which names the ten meshes, and the meshes in meshes
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Weight of a step between two p or two r, in factors of two of the pieces.
const STEP: f64 = 0.5;

/// Units of the sweep, in diagonals and in the meshes' own units.
const DIAGONALS: [f64; 9] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0];
const MESH_UNITS: [f64; 7] = [0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 2.0];

/// The columns of Table 1.
struct Row {
    pieces: usize,
    average_pieces: f64,
    seconds: f64,
    cost: f64,
    p: f64,
    r: usize,
    polygons: usize,
}

struct Mesh {
    model: String,
    name: String,
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    paper: Row,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let meshes = read(&arguments.folder)?;
    let default = SurfaceParameters::paper().unit;
    for (title, unit) in
        [("1 unit of the mesh", Unit::Absolute(1.0)), ("the default unit", default)]
    {
        let rows = rows(&meshes, unit)?;
        println!("p and a in {title}, ours / the paper's, score {:.2}:\n", score(&meshes, &rows));
        println!("| model | mesh | pieces | average pieces | seconds | cost | p | r | polygons |");
        println!("|---|---|---|---|---|---|---|---|---|");
        for (mesh, ours) in meshes.iter().zip(&rows) {
            let theirs = &mesh.paper;
            println!(
                "| {} | {} | {} / {} | {:.0} / {:.0} | {:.3} / {} | {:.6} / {:.6} | {} / {} \
                 | {} / {} | {} / {} |",
                mesh.model,
                mesh.name,
                ours.pieces,
                theirs.pieces,
                ours.average_pieces,
                theirs.average_pieces,
                ours.seconds,
                theirs.seconds,
                ours.cost,
                theirs.cost,
                ours.p,
                theirs.p,
                ours.r,
                theirs.r,
                ours.polygons,
                theirs.polygons
            );
        }
        println!();
    }
    println!("| unit | score | pieces at the paper's p and r: mean log2 | mean of its size |");
    println!("|---|---|---|---|");
    let diagonals = DIAGONALS.map(|unit| (format!("{unit} diagonals"), Unit::Diagonals(unit)));
    let own = MESH_UNITS.map(|unit| (format!("{unit} units of the mesh"), Unit::Absolute(unit)));
    for (name, unit) in diagonals.into_iter().chain(own) {
        let rows = rows(&meshes, unit)?;
        let (mean, size) = pieces_at_their_thresholds(&meshes, unit)?;
        println!("| {name} | {:.2} | {mean:+.2} | {size:.2} |", score(&meshes, &rows));
    }
    Ok(())
}

fn rows(meshes: &[Mesh], unit: Unit) -> Result<Vec<Row>, Box<dyn Error>> {
    let mut parameters = Parameters::paper();
    parameters.surface.unit = unit;
    parameters.parallel = false;
    let mut rows = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        let start = Instant::now();
        let found = decompose(&mesh.positions, &mesh.triangles, &parameters, &Control::new())?;
        let seconds = start.elapsed().as_secs_f64();
        let report = found.report.surface.ok_or("no report of the search")?;
        rows.push(Row {
            pieces: report.pieces,
            average_pieces: report.average_pieces,
            seconds,
            cost: report.cost,
            p: report.planar_threshold,
            r: report.resolution,
            polygons: report.polygons,
        });
    }
    Ok(rows)
}

/// log2 of the ratio of our pieces to the paper's, where p and r are given: its mean, and the mean
/// of its size.
fn pieces_at_their_thresholds(meshes: &[Mesh], unit: Unit) -> Result<(f64, f64), Box<dyn Error>> {
    let (mut sum, mut sizes) = (0.0, 0.0);
    for mesh in meshes {
        let mut parameters = Parameters::paper();
        parameters.surface.unit = unit;
        parameters.surface.planar_thresholds = vec![mesh.paper.p];
        parameters.surface.maximum_resolutions = vec![mesh.paper.r];
        let found = decompose(&mesh.positions, &mesh.triangles, &parameters, &Control::new())?;
        let pieces = found.report.surface.map_or(0, |report| report.pieces);
        let factor = (pieces as f64 / mesh.paper.pieces as f64).log2();
        sum += factor;
        sizes += factor.abs();
    }
    Ok((sum / meshes.len() as f64, sizes / meshes.len() as f64))
}

fn score(meshes: &[Mesh], rows: &[Row]) -> f64 {
    let total: f64 = meshes.iter().zip(rows).map(|(mesh, ours)| distance(ours, &mesh.paper)).sum();
    total / meshes.len() as f64
}

fn distance(ours: &Row, theirs: &Row) -> f64 {
    let parameters = SurfaceParameters::paper();
    let factor = |a: f64, b: f64| (a / b).log2().abs();
    let p = |p: f64| parameters.planar_thresholds.iter().position(|other| *other == p);
    let r = |r: usize| parameters.maximum_resolutions.iter().position(|other| *other == r);
    factor(ours.pieces as f64, theirs.pieces as f64)
        + factor(ours.average_pieces, theirs.average_pieces)
        + STEP * steps(p(ours.p), p(theirs.p))
        + STEP * steps(r(ours.r), r(theirs.r))
}

fn steps(a: Option<usize>, b: Option<usize>) -> f64 {
    a.zip(b).map_or(f64::NAN, |(a, b)| a.abs_diff(b) as f64)
}

/// The ten meshes and the paper's rows.
fn read(folder: &Path) -> Result<Vec<Mesh>, Box<dyn Error>> {
    let path = folder.join("paper/table1.tsv");
    let table = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut meshes = Vec::new();
    for line in table.lines().skip(1) {
        let fields: Vec<&str> = line.split('\t').collect();
        let [model, mesh, _, pieces, average, seconds, cost, p, r, polygons, _] = fields[..] else {
            return Err(format!("{}: {} columns, not 11", path.display(), fields.len()).into());
        };
        let input = read_mesh(folder.join("meshes").join(mesh))?;
        meshes.push(Mesh {
            model: model.into(),
            name: mesh.into(),
            positions: input.positions,
            triangles: input.triangles,
            paper: Row {
                pieces: number(pieces)?,
                average_pieces: number(average)?,
                seconds: number(seconds)?,
                cost: number(cost)?,
                p: number(p)?,
                r: number(r)?,
                polygons: number(polygons)?,
            },
        });
    }
    Ok(meshes)
}

fn number<T: std::str::FromStr<Err: fmt::Display>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|error| format!("{text}: {error}"))
}
