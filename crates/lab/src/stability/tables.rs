//! Runs against those of the same mesh as it is, by disturbance and size.

use std::collections::BTreeMap;

use crate::harness::{Row, Status};
use crate::report::{NOTHING, Table, number};
use crate::statistics::{median, range};
use crate::tools::variations::Variation;

/// A measured error may be above the promised one by this share: `measure` samples points, and
/// rounding moves them.
const ERROR_SLACK: f64 = 1e-3;

/// Processor times below this one, in seconds, are too short for their ratio to say anything.
const LEAST_SECONDS: f64 = 0.02;

/// Whether a hull is not convex or has no volume, or the error is above the bound.
pub fn breaks_promise(row: &Row) -> bool {
    let is_faulty = |count: Option<usize>| count.is_some_and(|count| count > 0);
    row.is_done()
        && (is_faulty(row.non_convex_hulls)
            || is_faulty(row.hulls_without_volume)
            || error(row).is_some_and(|error| error > 1.0 + ERROR_SLACK))
}

/// Over the bound, where there is one.
pub fn error(row: &Row) -> Option<f64> {
    Some(row.hausdorff? / row.bound?)
}

/// All rows, and those of the meshes as they are by mesh and method.
pub struct Rows<'a> {
    rows: &'a [Row],
    base: BTreeMap<(&'a str, &'a str), &'a Row>,
}

impl<'a> Rows<'a> {
    pub fn new(rows: &'a [Row]) -> Self {
        let base = rows.iter().filter(|row| row.variation.is_empty() && row.is_done());
        let base = base.map(|row| ((row.mesh.as_str(), row.method.as_str()), row)).collect();
        Self { rows, base }
    }

    /// The runs of a variation.
    pub fn of(&self, method: &str, variation: Variation) -> Vec<&'a Row> {
        let name = variation.name();
        let is_own = |row: &&Row| row.method == method && row.variation == name;
        self.rows.iter().filter(is_own).collect()
    }

    /// A figure of a run over that of the same mesh as it is.
    fn over_base(&self, row: &Row, figure: impl Fn(&Row) -> Option<f64>) -> Option<f64> {
        let base = self.base.get(&(row.mesh.as_str(), row.method.as_str()))?;
        Some(figure(row).filter(|_| row.is_done())? / figure(base)?)
    }

    pub fn hulls(&self, row: &Row) -> Option<f64> {
        self.over_base(row, |row| Some(row.hulls? as f64))
    }

    pub fn time(&self, row: &Row) -> Option<f64> {
        self.over_base(row, |row| Some(row.processor_seconds?.max(LEAST_SECONDS)))
    }

    pub fn spread(&self, method: &str) -> Table {
        let header = [
            "variation",
            "runs",
            "failures",
            "broken promises",
            "same hull count",
            "hulls over those of the mesh as it is: least",
            "median",
            "most",
            "error over the bound: median",
            "most ",
            "processor time over that of the mesh as it is: median",
            "most  ",
        ];
        let note = "A failure is a crash, an error or a limit. A broken promise is a hull that is \
                    not convex (1e-6 of the diagonal) or has no volume, or an error above the bound \
                    that was asked for.";
        let mut table = Table::new(&format!("By disturbance: {method}"), note, &header);
        let mut groups: Vec<(String, Vec<&Row>)> = Vec::new();
        for variation in Variation::all() {
            let (kind, own) = (variation.kind(), self.of(method, variation));
            match groups.last_mut().filter(|last| last.0 == kind) {
                Some((_, rows)) => rows.extend(own),
                None => groups.push((kind, own)),
            }
        }
        for (kind, all) in groups {
            let good: Vec<&Row> = all.iter().copied().filter(|row| row.is_done()).collect();
            let hulls: Vec<f64> = good.iter().filter_map(|row| self.hulls(row)).collect();
            let same = hulls.iter().filter(|&&ratio| ratio == 1.0).count();
            let broken = good.iter().filter(|row| breaks_promise(row)).count();
            let mut cells = vec![
                kind,
                all.len().to_string(),
                (all.len() - good.len()).to_string(),
                broken.to_string(),
                format!("{:.0} %", 100.0 * same as f64 / hulls.len().max(1) as f64),
            ];
            cells.extend(least_median_most(hulls));
            for figure in [
                good.iter().filter_map(|row| error(row)).collect(),
                good.iter().filter_map(|row| self.time(row)).collect(),
            ] {
                let [_, median, most] = least_median_most(figure);
                cells.extend([median, most]);
            }
            table.rows.push(cells);
        }
        table
    }
}

fn least_median_most(values: Vec<f64>) -> [String; 3] {
    if values.is_empty() {
        return [NOTHING; 3].map(String::from);
    }
    let (least, most) = range(values.iter().copied());
    [least, median(values), most].map(number)
}

pub fn wrong(rows: &[Row]) -> Table {
    let note = "Every failure, every broken promise, and whatever else a judge found.";
    let mut table = Table::new("What went wrong", note, &["mesh", "method", "variation", "what"]);
    for row in rows {
        let faults = row.faults();
        let what = match error(row) {
            _ if row.status != Status::Done => format!("{}: {}", row.status.name(), row.reason),
            Some(error) if breaks_promise(row) => {
                format!("error {} of the bound; {faults}", number(error))
            }
            _ if faults.is_empty() => continue,
            _ => faults,
        };
        let names = [&row.mesh, &row.method, &row.variation].map(String::clone);
        table.rows.push(names.into_iter().chain([what]).collect());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(variation: Variation, hulls: usize, error: f64) -> Row {
        Row {
            mesh: "a".into(),
            method: "bounded".into(),
            variation: variation.name(),
            hulls: Some(hulls),
            hausdorff: Some(0.02 * error),
            bound: Some(0.02),
            processor_seconds: Some(1.0),
            ..Row::default()
        }
    }

    #[test]
    fn a_run_is_compared_with_the_mesh_as_it_is_and_judged_by_its_bound() {
        let turned = [0, 1, 2].map(Variation::Rotation);
        let rows = [
            row(Variation::None, 4, 0.5),
            row(turned[0], 4, 0.9),
            row(turned[1], 8, 1.01),
            Row { status: Status::Crash, hausdorff: None, ..row(turned[2], 0, 0.0) },
        ];
        let table = Rows::new(&rows).spread("bounded");
        let found = table.rows.iter().find(|cells| cells[0] == "rotated").unwrap();
        assert_eq!(found[1..8], ["3", "1", "1", "50 %", "1.00", "1.50", "2.00"]);
        assert_eq!(found[8..], ["0.955", "1.01", "1.00", "1.00"]);
        assert_eq!(wrong(&rows).rows.len(), 2, "the broken promise and the crash");
    }
}
