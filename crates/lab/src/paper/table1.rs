//! Table 1, and the same figures over all of Princeton's meshes.

use hullwright::surface::SurfaceParameters;

use super::readings::{CLOSEST, Levels, select, tree};
use super::{Figure, Found, Paper, decomposed};
use crate::report::{Table, number};
use crate::statistics::{mean, median, range};
use crate::terminal::Failure;

/// The paper's rows, those of the closest reading, and the library's.
pub fn ten(papers: &[Paper], levels: &mut Levels) -> Result<Table, Failure> {
    let header = [
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
    let note = "The paper's rows; those of its simplifier, its unit and the library's groups, under the closest \
                reading; and the library's own. Pieces are groups of more than two polygons, as the paper \
                counts them; the library's row adds all its hulls.";
    let mut table = Table::new("Table 1", note, &header);
    let parameters = SurfaceParameters::paper();
    for Paper { row, model } in papers {
        let rest = [row.p, row.r as f64, row.polygons as f64, row.initial_polygons as f64];
        let theirs = [row.pieces as f64, row.average_pieces, row.seconds, row.cost];
        let theirs = theirs.into_iter().chain(rest).map(|value| value.to_string());
        table.rows.push([row.name(), "paper".into()].into_iter().chain(theirs).collect());
        let tree = tree(model, &CLOSEST, &parameters, levels)?;
        if let Some((found, average)) = select(&tree, &CLOSEST) {
            table.rows.push(vec![
                row.name(),
                "closest".into(),
                found.pieces.to_string(),
                format!("{average:.1}"),
                String::new(),
                format!("{:.6}", found.cost),
                found.p.to_string(),
                found.r.to_string(),
                found.polygons.to_string(),
                model.mesh.triangles.len().to_string(),
            ]);
        }
        let Found { decomposition, seconds } = decomposed(&model.mesh, &parameters)?;
        let report = &decomposition.report;
        table.rows.push(vec![
            row.name(),
            "library".into(),
            format!("{} ({})", pieces(&decomposition.grouped.groups), report.pieces),
            format!("{:.1}", report.average_pieces),
            number(seconds),
            format!("{:.6}", report.cost),
            report.planar_threshold.unwrap_or_default().to_string(),
            report.resolution.to_string(),
            report.polygons.to_string(),
            report.initial_polygons.to_string(),
        ]);
    }
    Ok(table)
}

/// Groups of more than two polygons.
fn pieces(groups: &[u32]) -> usize {
    let mut groups = groups.to_vec();
    groups.sort_unstable();
    groups.chunk_by(|a, b| a == b).filter(|group| group.len() > 2).count()
}

/// The same of each Princeton mesh, by the library.
pub fn all(found: &[Found]) -> Table {
    let note = format!("The library's paper method on {} Princeton meshes.", found.len());
    let header = ["what", "least", "median", "mean", "most"];
    let mut table = Table::new("Table 1 over all Princeton meshes", &note, &header);
    let figures: [Figure; 6] = [
        ("hulls", |found| found.decomposition.hulls.len() as f64),
        ("average pieces", |found| found.decomposition.report.average_pieces),
        ("seconds", |found| found.seconds),
        ("cost", |found| found.decomposition.report.cost),
        ("p", |found| found.decomposition.report.planar_threshold.unwrap_or_default()),
        ("r", |found| found.decomposition.report.resolution as f64),
    ];
    for (name, figure) in figures {
        let values: Vec<f64> = found.iter().map(figure).collect();
        let (least, most) = range(values.iter().copied());
        let row = [least, median(values.clone()), mean(&values), most].map(number);
        table.rows.push([name.to_owned()].into_iter().chain(row).collect());
    }
    table
}
