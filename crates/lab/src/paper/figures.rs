//! Table 1, and Figure 5's failure case.

use hullwright::surface::SurfaceParameters;

use super::work::{Found, Shared, judge_default, surface};
use crate::report::table::{NOTHING, Table, number};
use crate::runs::data_folder::PaperRow;
use crate::statistics::{mean, median, range};

const COLUMNS: [&str; 10] = [
    "model",
    "whose",
    "pieces",
    "average pieces",
    "seconds",
    "cost",
    "p",
    "r",
    "polygons",
    "initial polygons",
];

fn cells(found: &Found) -> Vec<String> {
    vec![
        found.pieces.to_string(),
        number(found.average_pieces),
        number(found.seconds),
        number(found.cost),
        found.planar_threshold.map_or_else(|| NOTHING.into(), |p| p.to_string()),
        found.resolution.to_string(),
        found.polygons.to_string(),
        found.initial_polygons.to_string(),
    ]
}

fn paper_cells(row: &PaperRow) -> [String; 8] {
    [
        row.pieces.to_string(),
        row.average_pieces.to_string(),
        row.seconds.to_string(),
        row.cost.to_string(),
        row.p.to_string(),
        row.r.to_string(),
        row.polygons.to_string(),
        row.initial_polygons.to_string(),
    ]
}

/// Table 1 on its own ten meshes, and the method over all Princeton meshes.
pub fn table1(shared: &Shared) -> Result<Vec<Table>, String> {
    let paper = SurfaceParameters::paper();
    let note = "The paper's rows beside ours on the same meshes.";
    let mut ten = Table::new("Table 1", note, &COLUMNS);
    for row in &shared.table1 {
        let mut theirs = vec![row.name(), "paper".into()];
        theirs.extend(paper_cells(row));
        ten.rows.push(theirs);
        let mut ours = vec![row.name(), "here".into()];
        ours.extend(cells(&surface(&shared.read(&row.mesh)?, &paper)?));
        ten.rows.push(ours);
    }
    let mut all = Vec::new();
    for mesh in &shared.princeton {
        all.push(surface(&shared.read(&mesh.name)?, &paper)?);
    }
    let note = format!("The paper's method on {} Princeton meshes.", all.len());
    let header = ["what", "least", "median", "mean", "most"];
    let mut table = Table::new("Table 1 over all Princeton meshes", &note, &header);
    type Figure = fn(&Found) -> f64;
    let figures: [(&str, Figure); 4] = [
        ("pieces", |found| found.pieces as f64),
        ("average pieces", |found| found.average_pieces),
        ("seconds", |found| found.seconds),
        ("cost", |found| found.cost),
    ];
    for (name, figure) in figures {
        let values: Vec<f64> = all.iter().map(figure).collect();
        let (least, most) = range(values.iter().copied());
        let row = [least, median(values.clone()), mean(&values), most].map(number);
        table.rows.push([name.to_owned()].into_iter().chain(row).collect());
    }
    for p in paper.planar_thresholds {
        let count = all.iter().filter(|found| found.planar_threshold == Some(p)).count();
        let row = [format!("p = {p} chosen"), count.to_string()];
        table.rows.push(row.into_iter().chain([NOTHING; 3].map(String::from)).collect());
    }
    Ok(vec![ten, table])
}

/// β for HACD in Figure 5, which gives none: the ε of the paper's own method.
const THRESHOLD: f64 = 0.05;

/// Spot without simplification, and with r = 900.
pub fn spot(shared: &Shared) -> Result<Vec<Table>, String> {
    let mesh = shared.read("common/spot.obj")?;
    let mut whole = SurfaceParameters::paper();
    whole.simplification_quality = 1.0;
    whole.maximum_resolutions = vec![mesh.mesh.triangles.len()];
    let mut simplified = SurfaceParameters::paper();
    simplified.maximum_resolutions = vec![900];

    let header =
        ["method", "resolution", "paper's seconds", "seconds", "pieces", "cost", "Hausdorff"];
    let note = format!(
        "Figure 5: spot.obj without simplification, and with r = 900. HACD with β = {THRESHOLD}, \
         for the paper gives none, limited to {} s; a time at the limit is a lower bound.",
        shared.limits.time.as_secs()
    );
    let mut table = Table::new("Figure 5", &note, &header);
    let mut add = |method: &str, resolution: &str, theirs: &str, found: Option<Found>| {
        let ours = match &found {
            Some(found) => vec![
                number(found.seconds),
                found.pieces.to_string(),
                number(found.cost),
                number(judge_default(&mesh, &found.hulls)?.hausdorff),
            ],
            None => {
                let limit = format!("over {}", shared.limits.time.as_secs());
                vec![limit, NOTHING.into(), NOTHING.into(), NOTHING.into()]
            }
        };
        let names = [method, resolution, theirs].map(String::from);
        table.rows.push(names.into_iter().chain(ours).collect());
        Ok::<(), String>(())
    };
    add("surface", "whole", "about 60", Some(surface(&mesh, &whole)?))?;
    add("hacd", "whole", "over 52,200 (14.5 h)", shared.hacd(&mesh, THRESHOLD, &whole)?)?;
    add("surface", "r = 900", "1.75", Some(surface(&mesh, &simplified)?))?;
    add("hacd", "r = 900", NOTHING, shared.hacd(&mesh, THRESHOLD, &simplified)?)?;
    Ok(vec![table])
}
