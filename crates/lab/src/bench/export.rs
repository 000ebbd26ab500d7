//! Rows and comparisons as CSV, for whoever wants to look at them in their own way.

use super::curves::versus;
use super::summary::Results;
use crate::runs::judge::Judged;
use crate::runs::record::{Row, Worked};

/// All rows, one line each, with a line of names above.
pub fn csv(results: &Results<'_>) -> Result<String, String> {
    let header = COLUMNS.iter().map(|(name, _)| (*name).to_owned()).collect();
    let rows = results.rows.iter().map(|row| COLUMNS.iter().map(|(_, cell)| cell(row)).collect());
    records(std::iter::once(header).chain(rows))
}

/// Wins and losses mesh by mesh: our hulls over another method's at equal error, our error over
/// its at equal hulls; empty where the curves don't meet.
pub fn versus_csv(results: &Results<'_>) -> Result<String, String> {
    let curves = results.curves();
    let name = if curves.contains_key("bounded") { "bounded" } else { "surface" };
    let header = ["mesh", "other method"].map(String::from).into_iter();
    let ratios = ["hulls", "error"].map(|what| format!("{name} {what} over theirs"));
    let mut rows = vec![header.chain(ratios).collect::<Vec<_>>()];
    let cell = |ratio: Option<f64>| ratio.map_or_else(String::new, |ratio| ratio.to_string());
    let own = curves.get(name);
    for (other, meshes) in curves.iter().filter(|(method, _)| **method != name) {
        for (mesh, theirs) in meshes {
            let Some(own) = own.and_then(|own| own.get(mesh)) else { continue };
            let found = versus(own, theirs);
            let names = [*mesh, *other].map(String::from).into_iter();
            rows.push(names.chain([found.hulls, found.error].map(cell)).collect());
        }
    }
    records(rows)
}

/// Records as CSV.
fn records(records: impl IntoIterator<Item = Vec<String>>) -> Result<String, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in records {
        writer.write_record(record).map_err(|error| format!("a table: {error}"))?;
    }
    let bytes = writer.into_inner().map_err(|error| format!("a table: {error}"))?;
    String::from_utf8(bytes).map_err(|error| format!("a table: {error}"))
}

type Column = (&'static str, fn(&Row) -> String);

/// A cell of what decomposing gave; empty where it gave nothing.
fn worked<T: ToString>(row: &Row, cell: impl Fn(&Worked) -> Option<T>) -> String {
    row.worked.as_ref().and_then(cell).map_or_else(String::new, |value| value.to_string())
}

/// A cell of what `measure` said; empty where nothing was measured.
fn judged<T: ToString>(row: &Row, cell: impl Fn(&Judged) -> Option<T>) -> String {
    row.judged.as_ref().and_then(cell).map_or_else(String::new, |value| value.to_string())
}

const COLUMNS: [Column; 32] = [
    ("mesh", |row| row.mesh.clone()),
    ("method", |row| row.method.clone()),
    ("setting", |row| row.setting.clone()),
    ("version", |row| row.version.clone()),
    ("status", |row| row.status.name().into()),
    ("reason", |row| row.reason.clone()),
    ("triangles", |row| worked(row, |w| Some(w.triangles))),
    ("seconds", |row| worked(row, |w| Some(w.seconds))),
    ("seconds_all_threads", |row| worked(row, |w| w.seconds_all_threads)),
    ("taken_elsewhere", |row| row.taken_elsewhere.to_string()),
    ("peak_memory_bytes", |row| worked(row, |w| w.peak_memory)),
    ("cost", |row| worked(row, |w| w.cost)),
    ("hulls", |row| judged(row, |j| Some(j.hulls))),
    ("vertices", |row| judged(row, |j| Some(j.vertices))),
    ("unusable_hulls", |row| judged(row, |j| Some(j.unusable_hulls))),
    ("non_convex_hulls", |row| judged(row, |j| Some(j.non_convex_hulls))),
    ("worst_concavity", |row| judged(row, |j| Some(j.worst_concavity))),
    ("non_positive_volumes", |row| judged(row, |j| Some(j.non_positive_volumes))),
    ("protrusion_mean", |row| judged(row, |j| Some(j.protrusion_mean))),
    ("protrusion_p99", |row| judged(row, |j| Some(j.protrusion_p99))),
    ("protrusion_max", |row| judged(row, |j| Some(j.protrusion_max))),
    ("uncovered_mean", |row| judged(row, |j| Some(j.uncovered_mean))),
    ("uncovered_p99", |row| judged(row, |j| Some(j.uncovered_p99))),
    ("uncovered_max", |row| judged(row, |j| Some(j.uncovered_max))),
    ("hausdorff", |row| judged(row, |j| Some(j.hausdorff))),
    ("uncovered_volume", |row| judged(row, |j| j.uncovered_volume)),
    ("iou", |row| judged(row, |j| j.iou)),
    ("overlap", |row| judged(row, |j| j.overlap)),
    ("samples_hulls", |row| judged(row, |j| Some(j.samples.hulls))),
    ("samples_boundary", |row| judged(row, |j| Some(j.samples.boundary))),
    ("samples_mesh", |row| judged(row, |j| Some(j.samples.mesh))),
    ("samples_space", |row| judged(row, |j| Some(j.samples.space))),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_are_quoted() {
        let record = ["a, b", "say \"x\"", "plain"].map(String::from).to_vec();
        assert_eq!(records([record]).unwrap(), "\"a, b\",\"say \"\"x\"\"\",plain\n");
    }
}
