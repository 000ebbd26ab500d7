//! What varied, over all meshes.

use std::collections::{BTreeMap, BTreeSet};

use super::Row;
use crate::bench::methods::Run;
use crate::bench::table::{NOTHING, Table, number};
use crate::bench::worker::median;

/// A measured error may be above the promised one by this share: `measure` samples points, and
/// rounding moves them.
const ERROR_SLACK: f64 = 1e-3;

/// Whether a hull is not convex or has no volume, or the error is above the bound.
pub fn breaks_promise(row: &Row) -> bool {
    let outcome = &row.outcome;
    let bound = match Run::parse(&row.method, &row.setting) {
        Some(Run::Bounded { error }) => error * (1.0 + ERROR_SLACK),
        _ => f64::INFINITY,
    };
    outcome.non_convex_hulls > 0 || outcome.non_positive_volumes > 0 || outcome.error > bound
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
        .filter(|row| row.place == 0 && row.outcome.failure.is_empty())
        .map(|row| ((row.mesh.as_str(), row.method.as_str()), row))
        .collect();
    let methods: BTreeSet<&str> = rows.iter().map(|row| row.method.as_str()).collect();
    for method in methods {
        let mut kinds: Vec<(usize, String)> = Vec::new();
        for row in rows.iter().filter(|row| row.method == method) {
            let kind = row.variation.kind();
            match kinds.iter_mut().find(|(_, other)| *other == kind) {
                Some((place, _)) => *place = (*place).min(row.place),
                None => kinds.push((row.place, kind)),
            }
        }
        kinds.sort();
        for (_, kind) in kinds {
            let all: Vec<&Row> = rows
                .iter()
                .filter(|row| row.method == method && row.variation.kind() == kind)
                .collect();
            let good = || all.iter().filter(|row| row.outcome.failure.is_empty());
            let pairs: Vec<(&Row, &Row)> = good()
                .filter_map(|row| Some((*row, *base.get(&(row.mesh.as_str(), method))?)))
                .collect();
            let same = pairs.iter().filter(|(a, b)| a.outcome.hulls == b.outcome.hulls).count();
            let hulls = |(a, b): &(&Row, &Row)| a.outcome.hulls as f64 / b.outcome.hulls as f64;
            let error = |(a, b): &(&Row, &Row)| {
                (a.outcome.error > LEAST_ERROR || b.outcome.error > LEAST_ERROR)
                    .then(|| a.outcome.error.max(LEAST_ERROR) / b.outcome.error.max(LEAST_ERROR))
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
            cells.push(number(good().map(|row| row.outcome.error).fold(0.0, f64::max)));
            table.rows.push(cells);
        }
    }
    table
}

/// Errors below this are the tolerance of `measure`.
const LEAST_ERROR: f64 = 1e-6;

fn least_median_most(values: Vec<f64>) -> [String; 3] {
    if values.is_empty() {
        return [NOTHING; 3].map(String::from);
    }
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    [least, median(values), most].map(number)
}

fn wrong(rows: &[Row]) -> Table {
    let note = "Every failure, and every broken promise.";
    let header = ["mesh", "method", "variation", "what"];
    let mut table = Table::new("What went wrong", note, &header);
    for row in rows {
        let outcome = &row.outcome;
        let what = match (outcome.failure.is_empty(), breaks_promise(row)) {
            (false, _) => outcome.failure.clone(),
            (true, true) => format!(
                "error {}, {} hulls not convex, {} without volume",
                number(outcome.error),
                outcome.non_convex_hulls,
                outcome.non_positive_volumes
            ),
            (true, false) => continue,
        };
        let variation = format!("{:?}", row.variation);
        table.rows.push(vec![row.mesh.clone(), row.method.clone(), variation, what]);
    }
    table
}
