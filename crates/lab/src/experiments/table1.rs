//! `cargo lab table1`: the paper's Table 1, ours beside its own, and how far apart they are.
//!
//! The first table has the thresholds in the meshes' own units, as the paper must have had them, the
//! second in the default unit, which is relative to the diagonal; a sweep over other units follows,
//! with the score and with the pieces at the paper's own p and r, which no rule of the search can
//! disturb.
//!
//! The distance between two rows is |log2| of the ratio of their pieces and of their average
//! pieces, and half a point for each step between their p and between their r: twice the pieces
//! weigh as much as two steps. The score of a table is the mean over its rows.

use std::path::PathBuf;
use std::time::Instant;

use hullwright::io::{MeshFile, read_mesh};
use hullwright::surface::{self, SurfaceParameters, SurfaceReport};
use hullwright::{Control, Length};
use hullwright_cli::terminal::{Failure, print};

use crate::report::table::Table;
use crate::runs::data_folder::{DataFolder, PaperRow};

/// Compare the surface method with the paper's Table 1, over units of the thresholds
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with paper/table1.tsv, which names the ten meshes, and the meshes in meshes
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Weight of a step between two p or two r, in factors of two of the pieces.
const STEP: f64 = 0.5;

/// Units of the sweep, in diagonals and in the meshes' own units: from far below the best to far
/// above.
const DIAGONALS: [f64; 9] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0];
const MESH_UNITS: [f64; 7] = [0.5, 0.7, 0.85, 1.0, 1.2, 1.4, 2.0];

struct Case {
    file: MeshFile,
    paper: PaperRow,
}

/// What the surface method says of a mesh, and how long it took.
struct Ours {
    report: SurfaceReport,
    seconds: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = DataFolder(arguments.folder.clone());
    let mut cases = Vec::new();
    for paper in folder.table1()? {
        cases.push(Case { file: read_mesh(folder.mesh(&paper.mesh))?, paper });
    }
    let default = SurfaceParameters::paper().unit;
    for (title, unit) in [("1 unit of the mesh", Length::Units(1.0)), ("the default unit", default)]
    {
        let rows = rows(&cases, unit)?;
        print(&table(title, &cases, &rows).to_markdown())?;
    }
    let header = ["unit", "score", "pieces at the paper's p and r: mean log2", "mean of its size"];
    let mut sweep = Table::new("Units", "", &header);
    let diagonals = DIAGONALS.map(|unit| (format!("{unit} diagonals"), Length::Share(unit)));
    let own = MESH_UNITS.map(|unit| (format!("{unit} units of the mesh"), Length::Units(unit)));
    for (name, unit) in diagonals.into_iter().chain(own) {
        let score = score(&cases, &rows(&cases, unit)?);
        let (mean, size) = pieces_at_their_thresholds(&cases, unit)?;
        let cells = [name, format!("{score:.2}"), format!("{mean:+.2}"), format!("{size:.2}")];
        sweep.rows.push(cells.into());
    }
    print(&sweep.to_markdown())
}

fn table(unit: &str, cases: &[Case], rows: &[Ours]) -> Table {
    let title = format!("p and a in {unit}");
    let note = format!("Ours / the paper's, score {:.2}.", score(cases, rows));
    let header =
        ["model", "mesh", "pieces", "average pieces", "seconds", "cost", "p", "r", "polygons"];
    let mut table = Table::new(&title, &note, &header);
    for (Case { paper, .. }, Ours { report, seconds }) in cases.iter().zip(rows) {
        table.rows.push(vec![
            paper.model.clone(),
            paper.mesh.clone(),
            format!("{} / {}", report.pieces, paper.pieces),
            format!("{:.0} / {:.0}", report.average_pieces, paper.average_pieces),
            format!("{seconds:.3} / {}", paper.seconds),
            format!("{:.6} / {:.6}", report.cost, paper.cost),
            format!("{} / {}", report.planar_threshold, paper.p),
            format!("{} / {}", report.resolution, paper.r),
            format!("{} / {}", report.polygons, paper.polygons),
        ]);
    }
    table
}

fn surface(file: &MeshFile, parameters: &SurfaceParameters) -> Result<SurfaceReport, Failure> {
    Ok(surface::decompose(file, parameters, &Control::new().with_parallel(false))?.report)
}

fn rows(cases: &[Case], unit: Length) -> Result<Vec<Ours>, Failure> {
    let mut parameters = SurfaceParameters::paper();
    parameters.unit = unit;
    let mut rows = Vec::with_capacity(cases.len());
    for case in cases {
        let start = Instant::now();
        let report = surface(&case.file, &parameters)?;
        rows.push(Ours { report, seconds: start.elapsed().as_secs_f64() });
    }
    Ok(rows)
}

/// log2 of the ratio of our pieces to the paper's, where p and r are given: its mean, and the mean
/// of its size.
fn pieces_at_their_thresholds(cases: &[Case], unit: Length) -> Result<(f64, f64), Failure> {
    let (mut sum, mut sizes) = (0.0, 0.0);
    for Case { file, paper } in cases {
        let mut parameters = SurfaceParameters::paper();
        parameters.unit = unit;
        parameters.planar_thresholds = vec![paper.p];
        parameters.maximum_resolutions = vec![paper.r];
        let pieces = surface(file, &parameters)?.pieces;
        let factor = (pieces as f64 / paper.pieces as f64).log2();
        sum += factor;
        sizes += factor.abs();
    }
    Ok((sum / cases.len() as f64, sizes / cases.len() as f64))
}

fn score(cases: &[Case], rows: &[Ours]) -> f64 {
    let distances = cases.iter().zip(rows).map(|(case, ours)| distance(&ours.report, &case.paper));
    distances.sum::<f64>() / cases.len() as f64
}

fn distance(ours: &SurfaceReport, theirs: &PaperRow) -> f64 {
    let parameters = SurfaceParameters::paper();
    let factor = |a: f64, b: f64| (a / b).log2().abs();
    let p = |p: f64| parameters.planar_thresholds.iter().position(|other| *other == p);
    let r = |r: usize| parameters.maximum_resolutions.iter().position(|other| *other == r);
    factor(ours.pieces as f64, theirs.pieces as f64)
        + factor(ours.average_pieces, theirs.average_pieces)
        + STEP * steps(p(ours.planar_threshold), p(theirs.p))
        + STEP * steps(r(ours.resolution), r(theirs.r))
}

fn steps(a: Option<usize>, b: Option<usize>) -> f64 {
    a.zip(b).map_or(f64::NAN, |(a, b)| a.abs_diff(b) as f64)
}
