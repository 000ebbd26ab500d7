//! What has changed since an earlier sweep.

use std::collections::BTreeMap;

use super::summary::is_over;
use crate::harness::{Row, Status};
use crate::report::{NOTHING, Table, count, number_or_nothing};

/// A share of the uncovered volume that is seen.
const VOLUME: f64 = 0.005;

/// Times and memory scatter by less than this factor,
const SCATTER: f64 = 1.5;

/// and of times below this one, in seconds, more than that is the clock's.
const LEAST_SECONDS: f64 = 0.02;

/// Every mesh whose outcome is another, with what it was and what it is.
pub fn table(before: &[Row], after: &[Row], seconds: f64) -> Table {
    let old: BTreeMap<String, &Row> = before.iter().map(|row| (row.name(), row)).collect();
    let note = format!(
        "Against {} meshes of version {}. Uncovered volume by more than {VOLUME}, time and memory \
         by more than a factor of {SCATTER}.",
        before.len(),
        before.first().map_or(NOTHING, |row| row.version.as_str()),
    );
    let mut table = Table::new("What has changed", &note, &["mesh", "what", "before", "now"]);
    for row in after {
        let changes = match old.get(&row.name()) {
            None => vec![["mesh", "not there", row.status.name()].map(str::to_owned)],
            Some(old) => changes(old, row, seconds),
        };
        for change in changes {
            table.rows.push(std::iter::once(row.name()).chain(change).collect());
        }
    }
    let new: BTreeMap<String, &Row> = after.iter().map(|row| (row.name(), row)).collect();
    for row in before.iter().filter(|row| !new.contains_key(&row.name())) {
        let change = ["mesh", row.status.name(), "not there"].map(str::to_owned);
        table.rows.push(std::iter::once(row.name()).chain(change).collect());
    }
    table
}

fn changes(old: &Row, new: &Row, seconds: f64) -> Vec<[String; 3]> {
    let outcome = |row: &Row| match (row.status, is_over(row, seconds)) {
        (Status::Done, true) => "over the time".to_owned(),
        (status, _) => format!("{} {}", status.name(), row.reason).trim().to_owned(),
    };
    let ratio = |pair: Option<(f64, f64)>| {
        pair.is_some_and(|(a, b)| a.max(b) > SCATTER * a.min(b).max(f64::MIN_POSITIVE))
    };
    let times = old.processor_seconds.zip(new.processor_seconds);
    let volumes = old.uncovered_volume.zip(new.uncovered_volume);
    let has_other_volume = volumes.is_some_and(|(a, b)| (a - b).abs() > VOLUME)
        || old.uncovered_volume.is_some() != new.uncovered_volume.is_some();
    let rows = [
        ("file", old.mesh_hash != new.mesh_hash, [old, new].map(|row| row.mesh_hash.clone())),
        ("outcome", outcome(old) != outcome(new), [old, new].map(outcome)),
        ("faults", old.faults() != new.faults(), [old, new].map(Row::faults)),
        ("hulls", old.hulls != new.hulls, [old, new].map(|row| count(row.hulls))),
        (
            "uncovered volume",
            has_other_volume,
            [old, new].map(|row| number_or_nothing(row.uncovered_volume)),
        ),
        (
            "processor seconds",
            ratio(times.map(|(a, b)| (a.max(LEAST_SECONDS), b.max(LEAST_SECONDS)))),
            [old, new].map(|row| number_or_nothing(row.processor_seconds)),
        ),
        (
            "MB",
            ratio(old.megabytes().zip(new.megabytes())),
            [old, new].map(|row| number_or_nothing(row.megabytes())),
        ),
    ];
    let changed = rows.into_iter().filter(|(_, is_changed, _)| *is_changed);
    changed.map(|(what, _, [before, now])| [what.to_owned(), before, now]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str) -> Row {
        let (hulls, processor_seconds) = (Some(3), Some(0.1));
        Row { mesh: mesh.into(), hulls, processor_seconds, ..Row::default() }
    }

    #[test]
    fn only_what_is_another_is_listed() {
        let old = [row("a"), row("b"), row("c"), row("gone")];
        let slower = Row { processor_seconds: Some(0.2), hulls: Some(4), ..row("b") };
        let crashed = Row { status: Status::Crash, reason: "signal".into(), ..row("c") };
        let noisy = Row { processor_seconds: Some(0.13), ..row("a") };
        let table = table(&old, &[noisy, slower, crashed, row("new")], 2.0);
        let whats: Vec<String> = table.rows.iter().map(|row| row[..2].join(" ")).collect();
        assert_eq!(whats, ["b hulls", "b processor seconds", "c outcome", "new mesh", "gone mesh"]);
        assert_eq!(table.rows[2][2..], ["done", "crash signal"]);
    }
}
