//! What varied, over all meshes.

use std::collections::{BTreeMap, BTreeSet};

use super::Row;
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

/// One table by kind of variation, one of everything that went wrong.
pub fn tables(rows: &[Row]) -> Vec<Table> {
    vec![spread(rows), wrong(rows)]
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
    let base: BTreeMap<(&str, &str), &Row> = rows
        .iter()
        .filter(|row| row.place == 0 && row.result.failure.is_empty())
        .map(|row| ((row.mesh.as_str(), row.method.as_str()), row))
        .collect();
    let methods: BTreeSet<&str> = rows.iter().map(|row| row.method.as_str()).collect();
    for method in methods {
        let own: Vec<&Row> = rows.iter().filter(|row| row.method == method).collect();
        for kind in kinds(&own) {
            let all: Vec<&Row> =
                own.iter().copied().filter(|row| row.variation.kind() == kind).collect();
            table.rows.push(spread_cells(method, kind, &all, &base));
        }
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
fn spread_cells(
    method: &str,
    kind: String,
    all: &[&Row],
    base: &BTreeMap<(&str, &str), &Row>,
) -> Vec<String> {
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
