//! Section 4.3.1: HACD in the paper's frame, hollow shapes, and V-HACD.

use std::time::Instant;

use hullwright::measure::{MeasureOptions, Measurement, measure};
use hullwright::surface::SurfaceParameters;
use hullwright::{Control, MeshView, TriangleMesh};
use hullwright_formats::NamedMesh;

use super::{Found, Model, Paper, all_of, decomposed, hacd_of};
use crate::report::{NOTHING, Table, number, number_or_nothing};
use crate::statistics::median;
use crate::terminal::Failure;
use crate::tools::vhacd::{self, VHACDParameters};

/// β, which the paper does not give: around its ε.
const THRESHOLDS: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// The largest limit that V-HACD is given.
const MOST_HULLS: u32 = 128;

/// What is compared, and whether the paper's method should have less of it.
type Claim = (&'static str, fn(&Found) -> f64, bool);

const CLAIMS: [Claim; 4] = [
    ("cost", |found| found.decomposition.report.cost, true),
    ("seconds", |found| found.seconds, true),
    ("r", |found| found.decomposition.report.resolution as f64, false),
    ("pieces", |found| found.decomposition.hulls.len() as f64, false),
];

/// Cost, time, resolution and pieces of the paper's method and of HACD (Figure 3).
pub fn hacd(princeton: &[Model], ours: &[Found]) -> Result<Table, Failure> {
    let note = format!(
        "Medians over {} Princeton meshes, and on what share of them a claim of the paper holds: its method \
         costs less and takes less time in each case, HACD has a smaller r and fewer pieces in some cases.",
        princeton.len()
    );
    let mut table = Table::new("4.3.1: HACD (Figure 3)", &note, &["β"]);
    for (name, _, is_ours) in CLAIMS {
        let whose = if is_ours { "surface" } else { "HACD" };
        table.header.extend([
            format!("{name}: surface"),
            "HACD".to_owned(),
            format!("less with {whose}"),
        ]);
    }
    for threshold in THRESHOLDS {
        let theirs = all_of(princeton, &hacd_of(threshold))?;
        let mut cells = vec![threshold.to_string()];
        for (_, figure, is_ours) in CLAIMS {
            let [ours, theirs] =
                [ours, &theirs].map(|found| found.iter().map(figure).collect::<Vec<f64>>());
            let holds = |(ours, theirs): &(&f64, &f64)| {
                if is_ours { ours < theirs } else { theirs < ours }
            };
            let count = ours.iter().zip(&theirs).filter(holds).count();
            let share = 100.0 * count as f64 / ours.len().max(1) as f64;
            cells.extend([number(median(ours)), number(median(theirs)), format!("{share:.0} %")]);
        }
        table.rows.push(cells);
    }
    Ok(table)
}

fn measured<'h, H>(mesh: &'h TriangleMesh, hulls: &'h [H]) -> Result<Measurement, Failure>
where
    &'h H: Into<MeshView<'h>>,
{
    Ok(measure(mesh, hulls, &MeasureOptions::default(), &Control::new())?)
}

/// The volume of all hulls together over that of the mesh, where the mesh is closed.
fn volume(found: &Measurement) -> Option<f64> {
    let covered = 1.0 - found.uncovered_volume?;
    Some(covered / found.iou? - 1.0 + covered)
}

/// Figure 4, left: hollow meshes.
pub fn hollow(cups: &[Model]) -> Result<Table, Failure> {
    let note = "Princeton's cups: the volume of all hulls together over that of the mesh, 1 where the hollow is \
                as it was, and the hulls. HACD with β = 0.05; V-HACD in Parry with its defaults.";
    let header = ["mesh", "surface", "HACD", "V-HACD"];
    let mut table = Table::new("4.3.1: hollow shapes (Figure 4, left)", note, &header);
    for Model { name, mesh, .. } in cups {
        let mut cells = vec![name.clone()];
        for parameters in [SurfaceParameters::paper(), hacd_of(0.05)] {
            let hulls = decomposed(mesh, &parameters)?.decomposition.hulls;
            cells.push(cell(volume(&measured(mesh, &hulls)?), hulls.len()));
        }
        let hulls = vhacd::decompose(mesh.view(), &VHACDParameters::default());
        cells.push(cell(volume(&measured(mesh, &hulls)?), hulls.len()));
        table.rows.push(cells);
    }
    Ok(table)
}

fn cell(volume: Option<f64>, hulls: usize) -> String {
    format!("{} ({hulls})", number_or_nothing(volume))
}

/// Figure 4, right: V-HACD with as many pieces, and with more until the features are there.
pub fn more_pieces(papers: &[Paper]) -> Result<Table, Failure> {
    let note = "Hausdorff distance over the diagonal, hulls, seconds: the paper's method; V-HACD in Parry with \
                a limit of as many pieces, and of twice as many again and again until it is as near to the \
                mesh, up to 128. Parry returns fewer than the limit.";
    let header = ["model", "surface", "V-HACD, as many", "V-HACD, as near"];
    let mut table = Table::new("4.3.1: V-HACD (Figure 4, right)", note, &header);
    for Paper { row, model } in papers {
        let mesh = &model.mesh;
        let Found { decomposition, seconds } = decomposed(mesh, &SurfaceParameters::paper())?;
        let own = measured(mesh, &decomposition.hulls)?;
        let cell = |found: &Measurement, seconds: f64| {
            let [distance, seconds] = [found.hausdorff / found.diagonal, seconds].map(number);
            format!("{distance}, {}, {seconds} s", found.hulls)
        };
        let mut cells = vec![row.name(), cell(&own, seconds)];
        let mut asked = decomposition.hulls.len() as u32;
        let mut nearest = NOTHING.to_owned();
        loop {
            let (hulls, seconds) = vhacd_of(mesh, asked);
            let found = measured(mesh, &hulls)?;
            if cells.len() == 2 {
                cells.push(cell(&found, seconds));
            }
            if found.hausdorff <= own.hausdorff {
                nearest = cell(&found, seconds);
                break;
            }
            asked *= 2;
            if asked > MOST_HULLS {
                break;
            }
        }
        cells.push(nearest);
        table.rows.push(cells);
    }
    Ok(table)
}

pub fn vhacd_of(mesh: &TriangleMesh, max_convex_hulls: u32) -> (Vec<NamedMesh>, f64) {
    let start = Instant::now();
    let parameters = VHACDParameters { max_convex_hulls, ..VHACDParameters::default() };
    (vhacd::decompose(mesh.view(), &parameters), start.elapsed().as_secs_f64())
}
