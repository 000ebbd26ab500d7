//! What varied, over all meshes.

use std::collections::{BTreeMap, BTreeSet};

use super::Row;
use super::worker::VariationResult;
use crate::report::table::{NOTHING, Table, number};
use crate::runs::methods::Run;
use crate::statistics::{median, range};

/// A measured error may be above the promised one by this share: `measure` samples points, and
/// rounding moves them.
const ERROR_SLACK: f64 = 1e-3;

/// Whether a hull is not convex or has no volume, or the error is above the bound.
pub fn breaks_promise(row: &Row) -> bool {
    let result = &row.result;
    let bound = match Run::parse(&row.method, &row.setting) {
        Some(Run::Bounded { error }) => error * (1.0 + ERROR_SLACK),
        _ => f64::INFINITY,
    };
    result.non_convex_hulls > 0 || result.non_positive_volumes > 0 || result.error > bound
}

/// Tables by kind of variation, the worst of each figure, and everything that went wrong.
pub fn tables(rows: &[Row]) -> Vec<Table> {
    let mut tables = vec![spread(rows), volumes(rows)];
    tables.extend(FIGURES.map(|figure| worst(rows, figure)));
    tables.push(wrong(rows));
    tables
}

fn spread(rows: &[Row]) -> Table {
    let header = [
        "method",
        "variation",
        "runs",
        "failures",
        "broken promises",
        "same hull count",
        "hulls over those of the mesh as it is: least",
        "median",
        "most",
        "error over that of the mesh as it is: least",
        "median ",
        "most ",
        "largest error",
    ];
    let note = "Each run is compared with the same method on the same mesh as it is. A broken \
                promise is a hull that is not convex (1e-6 of the diagonal) or has no volume, or an \
                error above the bound that was asked for.";
    let mut table = Table::new("Spread", note, &header);
    let base = base(rows);
    for (method, kind, all) in groups(rows) {
        table.rows.push(spread_cells(method, kind, &all, &base));
    }
    table
}

type Base<'a> = BTreeMap<(&'a str, &'a str), &'a Row>;

/// The runs of the meshes as they are, by mesh and method.
fn base(rows: &[Row]) -> Base<'_> {
    rows.iter()
        .filter(|row| row.place == 0 && row.result.failure.is_empty())
        .map(|row| ((row.mesh.as_str(), row.method.as_str()), row))
        .collect()
}

/// The rows of each method and kind of variation.
fn groups(rows: &[Row]) -> Vec<(&str, String, Vec<&Row>)> {
    let methods: BTreeSet<&str> = rows.iter().map(|row| row.method.as_str()).collect();
    let mut groups = Vec::new();
    for method in methods {
        let own: Vec<&Row> = rows.iter().filter(|row| row.method == method).collect();
        for kind in kinds(&own) {
            let all = own.iter().copied().filter(|row| row.variation.kind() == kind).collect();
            groups.push((method, kind, all));
        }
    }
    groups
}

/// A figure beside error and hulls, and how much worse it is than that of the mesh as it is.
struct Figure {
    name: &'static str,
    of: fn(&VariationResult) -> Option<f64>,
    worse: fn(f64, f64) -> f64,
}

/// Processor times below this one, in seconds, are too short for their ratio to say anything.
const LEAST_SECONDS: f64 = 0.02;

const FIGURES: [Figure; 3] = [
    Figure {
        name: "uncovered volume",
        of: |result| result.uncovered_volume,
        worse: |varied, base| varied - base,
    },
    Figure { name: "IoU", of: |result| result.iou, worse: |varied, base| base - varied },
    Figure {
        name: "processor seconds",
        of: |result| Some(result.seconds),
        worse: |varied, base| varied.max(LEAST_SECONDS) / base.max(LEAST_SECONDS),
    },
];

impl Figure {
    /// How much worse a run is than that of the mesh as it is, with both figures.
    fn compared(&self, row: &Row, base: &Base<'_>) -> Option<(f64, f64, f64)> {
        let before = base.get(&(row.mesh.as_str(), row.method.as_str()))?;
        let is_done = row.result.failure.is_empty();
        let (varied, before) =
            (self.of)(&row.result).filter(|_| is_done).zip((self.of)(&before.result))?;
        Some(((self.worse)(varied, before), varied, before))
    }
}

fn volumes(rows: &[Row]) -> Table {
    let header = [
        "method",
        "variation",
        "more uncovered volume: median",
        "most",
        "less IoU: median",
        "most ",
        "processor time over that of the mesh as it is: median",
        "most  ",
    ];
    let note =
        "Each run against the same method on the same mesh as it is. Volumes of closed meshes.";
    let mut table = Table::new("Volume and time", note, &header);
    let base = base(rows);
    for (method, kind, all) in groups(rows) {
        let mut cells = vec![method.to_owned(), kind];
        for figure in &FIGURES {
            let values: Vec<f64> = all
                .iter()
                .filter_map(|row| figure.compared(row, &base))
                .map(|(worse, ..)| worse)
                .collect();
            let [_, median, most] = least_median_most(values);
            cells.extend([median, most]);
        }
        table.rows.push(cells);
    }
    table
}

/// Rows of a table of the worst.
const WORST: usize = 10;

fn worst(rows: &[Row], figure: Figure) -> Table {
    let base = base(rows);
    let mut found: Vec<((f64, f64, f64), &Row)> =
        rows.iter().filter_map(|row| Some((figure.compared(row, &base)?, row))).collect();
    found.sort_by(|a, b| b.0.0.total_cmp(&a.0.0));
    let title = format!("Worst change of {}", figure.name);
    let header = ["mesh", "method", "variation", "as it is", "varied", "hulls"];
    let mut table = Table::new(&title, "", &header);
    for ((_, varied, before), row) in found.into_iter().take(WORST) {
        table.rows.push(vec![
            row.mesh.clone(),
            row.method.clone(),
            row.variation.kind(),
            number(before),
            number(varied),
            row.result.hulls.to_string(),
        ]);
    }
    table
}

/// The kinds of variations, in the order in which they are tried.
fn kinds(rows: &[&Row]) -> Vec<String> {
    let mut kinds: Vec<(usize, String)> = Vec::new();
    for row in rows {
        let kind = row.variation.kind();
        match kinds.iter_mut().find(|(_, other)| *other == kind) {
            Some((place, _)) => *place = (*place).min(row.place),
            None => kinds.push((row.place, kind)),
        }
    }
    kinds.sort();
    kinds.into_iter().map(|(_, kind)| kind).collect()
}

/// The rows of one method and one kind of variation against those of the meshes as they are.
fn spread_cells(method: &str, kind: String, all: &[&Row], base: &Base<'_>) -> Vec<String> {
    let good = || all.iter().filter(|row| row.result.failure.is_empty());
    let pairs: Vec<(&Row, &Row)> =
        good().filter_map(|row| Some((*row, *base.get(&(row.mesh.as_str(), method))?))).collect();
    let same = pairs.iter().filter(|(a, b)| a.result.hulls == b.result.hulls).count();
    let hulls = |(a, b): &(&Row, &Row)| a.result.hulls as f64 / b.result.hulls as f64;
    let error = |(a, b): &(&Row, &Row)| {
        (a.result.error > LEAST_ERROR || b.result.error > LEAST_ERROR)
            .then(|| a.result.error.max(LEAST_ERROR) / b.result.error.max(LEAST_ERROR))
    };
    let mut cells = vec![
        method.to_owned(),
        kind,
        all.len().to_string(),
        (all.len() - good().count()).to_string(),
        good().filter(|row| breaks_promise(row)).count().to_string(),
        format!("{:.0} %", 100.0 * same as f64 / pairs.len().max(1) as f64),
    ];
    cells.extend(least_median_most(pairs.iter().map(hulls).collect()));
    cells.extend(least_median_most(pairs.iter().filter_map(error).collect()));
    cells.push(number(good().map(|row| row.result.error).fold(0.0, f64::max)));
    cells
}

/// Errors below this are the tolerance of `measure`.
const LEAST_ERROR: f64 = 1e-6;

fn least_median_most(values: Vec<f64>) -> [String; 3] {
    if values.is_empty() {
        return [NOTHING; 3].map(String::from);
    }
    let (least, most) = range(values.iter().copied());
    [least, median(values), most].map(number)
}

fn wrong(rows: &[Row]) -> Table {
    let note = "Every failure, and every broken promise.";
    let header = ["mesh", "method", "variation", "what"];
    let mut table = Table::new("What went wrong", note, &header);
    for row in rows {
        let result = &row.result;
        let what = match (result.failure.is_empty(), breaks_promise(row)) {
            (false, _) => result.failure.clone(),
            (true, true) => format!(
                "error {}, {} hulls not convex, {} without volume",
                number(result.error),
                result.non_convex_hulls,
                result.non_positive_volumes
            ),
            (true, false) => continue,
        };
        let variation = format!("{:?}", row.variation);
        table.rows.push(vec![row.mesh.clone(), row.method.clone(), variation, what]);
    }
    table
}
