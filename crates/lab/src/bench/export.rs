//! The rows as CSV, for whoever wants to look at them in their own way.

use super::record::Row;
use super::summary::Results;

/// All rows, one line each, with a line of names above.
pub fn csv(results: &Results<'_>) -> String {
    let mut text = COLUMNS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",") + "\n";
    for row in &results.rows {
        let cells: Vec<String> = COLUMNS.iter().map(|(_, cell)| quoted(&cell(row))).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

type Column = (&'static str, fn(&Row) -> String);

fn optional<T: ToString>(value: Option<T>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

const COLUMNS: [Column; 32] = [
    ("mesh", |row| row.mesh.clone()),
    ("method", |row| row.method.clone()),
    ("setting", |row| row.setting.clone()),
    ("version", |row| row.version.clone()),
    ("status", |row| row.status.name().into()),
    ("reason", |row| row.reason.clone()),
    ("triangles", |row| optional(row.worked.as_ref().map(|w| w.triangles))),
    ("seconds", |row| optional(row.worked.as_ref().map(|w| w.seconds))),
    ("seconds_all_threads", |row| {
        optional(row.worked.as_ref().and_then(|w| w.seconds_all_threads))
    }),
    ("taken_elsewhere", |row| row.taken_elsewhere.to_string()),
    ("peak_memory_bytes", |row| optional(row.worked.as_ref().and_then(|w| w.peak_memory))),
    ("cost", |row| optional(row.worked.as_ref().and_then(|w| w.cost))),
    ("hulls", |row| optional(row.judged.as_ref().map(|j| j.hulls))),
    ("vertices", |row| optional(row.judged.as_ref().map(|j| j.vertices))),
    ("unusable_hulls", |row| optional(row.judged.as_ref().map(|j| j.unusable_hulls))),
    ("non_convex_hulls", |row| optional(row.judged.as_ref().map(|j| j.non_convex_hulls))),
    ("worst_concavity", |row| optional(row.judged.as_ref().map(|j| j.worst_concavity))),
    ("non_positive_volumes", |row| optional(row.judged.as_ref().map(|j| j.non_positive_volumes))),
    ("phantom_mean", |row| optional(row.judged.as_ref().map(|j| j.phantom_mean))),
    ("phantom_p99", |row| optional(row.judged.as_ref().map(|j| j.phantom_p99))),
    ("phantom_max", |row| optional(row.judged.as_ref().map(|j| j.phantom_max))),
    ("exposed_mean", |row| optional(row.judged.as_ref().map(|j| j.exposed_mean))),
    ("exposed_p99", |row| optional(row.judged.as_ref().map(|j| j.exposed_p99))),
    ("exposed_max", |row| optional(row.judged.as_ref().map(|j| j.exposed_max))),
    ("hausdorff", |row| optional(row.judged.as_ref().map(|j| j.hausdorff))),
    ("hollow", |row| optional(row.judged.as_ref().and_then(|j| j.hollow))),
    ("iou", |row| optional(row.judged.as_ref().and_then(|j| j.iou))),
    ("overlap", |row| optional(row.judged.as_ref().and_then(|j| j.overlap))),
    ("samples_hulls", |row| optional(row.judged.as_ref().map(|j| j.samples[0]))),
    ("samples_boundary", |row| optional(row.judged.as_ref().map(|j| j.samples[1]))),
    ("samples_mesh", |row| optional(row.judged.as_ref().map(|j| j.samples[2]))),
    ("samples_space", |row| optional(row.judged.as_ref().map(|j| j.samples[3]))),
];

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) {
        format!("\"{}\"", cell.replace('"', "\"\"").replace('\n', " "))
    } else {
        cell.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_are_quoted() {
        assert_eq!(quoted("a, b"), "\"a, b\"");
        assert_eq!(quoted("say \"x\""), "\"say \"\"x\"\"\"");
        assert_eq!(quoted("plain"), "plain");
    }
}
