//! Tables of a sweep: what became of the meshes, and the worst of them.

use std::collections::BTreeMap;

use super::RANDOM;
use crate::harness::row::Figure;
use crate::harness::{Row, Status};
use crate::report::{NOTHING, Table, count, number, number_or_nothing};
use crate::statistics::quantile;
use crate::tools::kinds;
use crate::tools::soup;
use crate::tools::variations::Variation;

/// Rows of a table of the worst.
const WORST: usize = 10;

pub fn tables(rows: &[Row], seconds: f64) -> Vec<Table> {
    let note = "What is wrong with the meshes as they are given. A mesh may be in several rows; one of several \
                components may be solid.";
    vec![
        outcomes(("By kind", "kind", note), by_kind(rows), seconds),
        outcomes(("By origin", "meshes", ""), by_origin(rows), seconds),
        tails(rows),
        refusals(rows),
        wrong(rows, seconds),
        slowest(rows),
    ]
}

/// Whether decomposing took more processor time than it may, though it was let go on.
pub fn is_over(row: &Row, seconds: f64) -> bool {
    row.status == Status::TimeOut || row.processor_seconds.is_some_and(|s| s > seconds)
}

type Groups<'a> = Vec<(String, Vec<&'a Row>)>;

fn those(rows: &[Row], is: impl Fn(&Row) -> bool) -> Vec<&Row> {
    rows.iter().filter(|row| is(row)).collect()
}

fn by_kind(rows: &[Row]) -> Groups<'_> {
    let is_read = |row: &Row| row.triangles.is_some();
    let is_of = |row: &Row, kind: &str| row.kinds.split(", ").any(|one| one == kind);
    let mut groups = vec![
        ("all".into(), those(rows, |_| true)),
        ("solid".into(), those(rows, |row| is_read(row) && !is_of(row, kinds::NOT_SOLID))),
    ];
    for kind in kinds::ALL {
        groups.push((kind.into(), those(rows, |row| is_of(row, kind))));
    }
    groups.push(("no mesh in the file".into(), those(rows, |row| !is_read(row))));
    groups
}

fn by_origin(rows: &[Row]) -> Groups<'_> {
    let is_random = |row: &Row| row.folder() == RANDOM;
    let is_given = |row: &Row| !is_random(row) && row.variation.is_empty();
    let mut groups = vec![("as they are".into(), those(rows, is_given))];
    for damage in Variation::damages().map(Variation::name) {
        let those = those(rows, |row| row.variation == damage);
        groups.push((damage, those));
    }
    for kind in soup::KINDS {
        let suffix = format!("_{}.obj", kind.replace(' ', "_"));
        let is_it = |row: &Row| {
            let file = row.mesh.rsplit('/').next().unwrap_or_default();
            is_random(row) && file.trim_start_matches(char::is_numeric) == suffix
        };
        groups.push((format!("random: {kind}"), those(rows, is_it)));
    }
    groups
}

fn outcomes((title, first, note): (&str, &str, &str), groups: Groups<'_>, seconds: f64) -> Table {
    let over = format!("above {seconds} s");
    let header = [
        first,
        "meshes",
        "done",
        "refused with a reason",
        "crashed",
        "stopped",
        "hulls",
        "not sound",
        "beyond the bound",
        "median s",
        "99 %",
        "slowest",
        &over,
    ];
    let mut table = Table::new(title, note, &header);
    for (name, rows) in groups.into_iter().filter(|group| !group.1.is_empty()) {
        let status = |status| rows.iter().filter(|row| row.status == status).count();
        let sum = |of: fn(&Row) -> Option<usize>| -> usize {
            rows.iter().filter_map(|row| of(row)).sum()
        };
        let counts = [
            rows.len(),
            status(Status::Done),
            status(Status::Error),
            status(Status::Crash),
            status(Status::TimeOut) + status(Status::OutOfMemory),
            sum(|row| row.hulls),
            rows.iter().map(|row| row.unsound_hulls()).sum(),
            rows.iter().filter(|row| !row.broken.is_empty()).count(),
        ];
        let times: Vec<f64> = rows.iter().filter_map(|row| row.processor_seconds).collect();
        let mut cells = vec![name];
        cells.extend(counts.map(|count| count.to_string()));
        cells.extend(quantiles(&times, &[0.5, 0.99, 1.0]));
        cells.push(rows.iter().filter(|row| is_over(row, seconds)).count().to_string());
        table.rows.push(cells);
    }
    table
}

fn quantiles<'a>(values: &'a [f64], shares: &'a [f64]) -> impl Iterator<Item = String> + 'a {
    shares.iter().map(|&share| match values.is_empty() {
        true => NOTHING.into(),
        false => number(quantile(values, share)),
    })
}

const FIGURES: [Figure; 6] = [
    ("peak memory, MB", Row::megabytes),
    ("hulls", |row| Some(row.hulls? as f64)),
    ("vertices of a hull, mean", |row| Some(row.vertices? as f64 / row.hulls? as f64)),
    ("sampled protrusion over the bound", |row| Some(row.protrusion_sampled? / row.bound?)),
    ("sampled uncovered distance over the bound", |row| Some(row.uncovered_sampled? / row.bound?)),
    ("uncovered volume", |row| row.uncovered_volume),
];

fn tails(rows: &[Row]) -> Table {
    let header = ["meshes", "figure", "number", "median", "90 %", "99 %", "most"];
    let mut table = Table::new("Figures and their tails", "", &header);
    let is_random = |row: &Row| row.folder() == RANDOM;
    let groups = [
        ("as they are", those(rows, |row| !is_random(row) && row.variation.is_empty())),
        ("damaged", those(rows, |row| !row.variation.is_empty())),
        ("random", those(rows, is_random)),
    ];
    for (group, rows) in groups.iter().filter(|group| !group.1.is_empty()) {
        for (name, figure) in FIGURES {
            let values: Vec<f64> = rows.iter().filter_map(|row| figure(row)).collect();
            let mut cells = vec![(*group).into(), name.into(), values.len().to_string()];
            cells.extend(quantiles(&values, &[0.5, 0.9, 0.99, 1.0]));
            table.rows.push(cells);
        }
    }
    table
}

fn refusals(rows: &[Row]) -> Table {
    let mut reasons: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.status == Status::Error) {
        reasons.entry(&row.reason).or_default().push(row.name());
    }
    let mut table = Table::new("Refused", "", &["reason", "the first", "meshes"]);
    for (reason, meshes) in reasons {
        table.rows.push(vec![reason.into(), meshes[0].clone(), meshes.len().to_string()]);
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
            table.rows.push(vec![row.name(), what.join("; ")]);
        }
    }
    table
}

fn slowest(rows: &[Row]) -> Table {
    let mut found: Vec<(f64, &Row)> =
        rows.iter().filter_map(|row| Some((row.processor_seconds?, row))).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let header = ["mesh", "processor seconds", "triangles", "hulls", "kinds"];
    let mut table = Table::new("Slowest", "", &header);
    for (seconds, row) in found.into_iter().take(WORST) {
        let (triangles, hulls) = (count(row.triangles), count(row.hulls));
        table.rows.push(vec![row.name(), number(seconds), triangles, hulls, row.kinds.clone()]);
    }
    table
}
