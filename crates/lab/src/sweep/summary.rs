//! Tables of a sweep: what became of the meshes, and the tails.

use std::collections::BTreeMap;

use crate::harness::row::Figure;
use crate::harness::{Row, Status};
use crate::report::{NOTHING, Table, count, number, number_or_nothing};
use crate::statistics::quantile;

/// Rows of a table of the worst.
const WORST: usize = 10;

pub fn tables(rows: &[Row], seconds: f64) -> Vec<Table> {
    vec![
        outcomes(rows, seconds),
        tails(rows),
        refusals(rows),
        wrong(rows, seconds),
        worst(rows, "Slowest", ("seconds", |row| row.processor_seconds)),
        worst(rows, "Most memory", ("MB", Row::megabytes)),
        worst(rows, "Most uncovered volume", ("share", |row| row.uncovered_volume)),
        worst(rows, "Most hulls", ("hulls", |row| row.hulls.map(|hulls| hulls as f64))),
    ]
}

/// Whether decomposing took more processor time than it may, though it was let go on.
pub fn is_over(row: &Row, seconds: f64) -> bool {
    row.status == Status::TimeOut || row.processor_seconds.is_some_and(|s| s > seconds)
}

/// Rows by folder, and all of them last.
fn groups(rows: &[Row]) -> Vec<(&str, Vec<&Row>)> {
    let mut folders: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in rows {
        folders.entry(row.folder()).or_default().push(row);
    }
    let mut groups = Vec::from_iter(folders);
    groups.push(("all", rows.iter().collect()));
    groups
}

fn outcomes(rows: &[Row], seconds: f64) -> Table {
    let header = [
        "folder",
        "meshes",
        "done",
        "refused",
        "crashed",
        "timed out",
        "out of memory",
        "hulls",
        "open",
        "not convex",
        "without volume",
        "beyond single precision",
        "broken promises",
    ];
    let note = "A mesh that is done but over the time counts as timed out alone.";
    let mut table = Table::new("What became of them", note, &header);
    for (folder, rows) in groups(rows) {
        let status = |status| rows.iter().filter(|row| row.status == status).count();
        let timed_out = rows.iter().filter(|row| is_over(row, seconds)).count();
        let late = timed_out - status(Status::TimeOut);
        let sum = |of: fn(&Row) -> Option<usize>| -> usize {
            rows.iter().filter_map(|row| of(row)).sum()
        };
        let counts = [
            rows.len(),
            status(Status::Done) - late,
            status(Status::Error),
            status(Status::Crash),
            timed_out,
            status(Status::OutOfMemory),
            sum(|row| row.hulls),
            sum(|row| row.open_hulls),
            sum(|row| row.non_convex_hulls),
            sum(|row| row.hulls_without_volume),
            sum(|row| row.hulls_beyond_single),
            rows.iter().filter(|row| !row.broken.is_empty()).count(),
        ];
        let cells = counts.map(|count| count.to_string());
        table.rows.push(std::iter::once(folder.to_owned()).chain(cells).collect());
    }
    table
}

const FIGURES: [Figure; 8] = [
    ("processor seconds", |row| row.processor_seconds),
    ("seconds on the wall", |row| row.seconds),
    ("peak memory, MB", Row::megabytes),
    ("hulls", |row| Some(row.hulls? as f64)),
    ("vertices of a hull, mean", |row| Some(row.vertices? as f64 / row.hulls? as f64)),
    ("sampled protrusion over the bound", |row| Some(row.protrusion_sampled? / row.bound?)),
    ("sampled uncovered distance over the bound", |row| Some(row.uncovered_sampled? / row.bound?)),
    ("uncovered volume", |row| row.uncovered_volume),
];

fn tails(rows: &[Row]) -> Table {
    let header = ["folder", "figure", "meshes", "median", "90 %", "99 %", "most"];
    let mut table = Table::new("Figures and their tails", "", &header);
    for (folder, rows) in groups(rows) {
        for (name, figure) in FIGURES {
            let values: Vec<f64> = rows.iter().filter_map(|row| figure(row)).collect();
            let mut cells = vec![folder.to_owned(), name.to_owned(), values.len().to_string()];
            cells.extend([0.5, 0.9, 0.99, 1.0].map(|share| match values.is_empty() {
                true => NOTHING.into(),
                false => number(quantile(&values, share)),
            }));
            table.rows.push(cells);
        }
    }
    table
}

fn refusals(rows: &[Row]) -> Table {
    let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.status == Status::Error) {
        reasons.entry(&row.reason).or_default().push(&row.mesh);
    }
    let mut table = Table::new("Refused", "", &["reason", "mesh", "meshes"]);
    for (reason, meshes) in reasons {
        let first = meshes.first().copied().unwrap_or_default();
        table.rows.push(vec![reason.into(), first.into(), meshes.len().to_string()]);
    }
    table
}

fn wrong(rows: &[Row], seconds: f64) -> Table {
    let mut table = Table::new("What went wrong", "Everything but refusals.", &["mesh", "what"]);
    for row in rows {
        let mut what = Vec::new();
        if !matches!(row.status, Status::Done | Status::Error) {
            what.push(format!("{}: {}", row.status.name(), row.reason));
        } else if is_over(row, seconds) {
            what.push(format!("{} s", number_or_nothing(row.processor_seconds)));
        }
        let faults = row.faults();
        if !faults.is_empty() {
            what.push(faults);
        }
        if !what.is_empty() {
            table.rows.push(vec![row.mesh.clone(), what.join("; ")]);
        }
    }
    table
}

fn worst(rows: &[Row], title: &str, (unit, figure): Figure) -> Table {
    let mut found: Vec<(f64, &Row)> =
        rows.iter().filter_map(|row| Some((figure(row)?, row))).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut table =
        Table::new(title, "", &["mesh", unit, "triangles", "hulls", "processor seconds"]);
    for (value, row) in found.into_iter().take(WORST) {
        table.rows.push(vec![
            row.mesh.clone(),
            number(value),
            count(row.triangles),
            count(row.hulls),
            number_or_nothing(row.processor_seconds),
        ]);
    }
    table
}
