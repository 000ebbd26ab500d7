//! What sampling misses: the sampled errors of each method beside upper bounds of the true ones.

use super::summary::{METHODS, Results};
use crate::harness::Row;
use crate::report::{NOTHING, Table, number};
use crate::statistics::{median, quantile};

/// Protrusions below this fraction of the diagonal are left out of ratios.
const LEAST: f64 = 1e-3;

/// A row for each method, with its default setting.
pub fn table(results: &Results<'_>) -> Table {
    let header = [
        "method",
        "meshes",
        "protrusion, sampled: median",
        "verified: median",
        "verified over sampled: median",
        "99 %",
        "most",
        "sampling misses it",
        "largest, sampled",
        "largest, verified",
        "uncovered: largest, sampled",
        "largest, verified ",
    ];
    let note = "Sampled are 50,000 points on hulls and as many on the mesh, verified are upper bounds for whole \
                faces and triangles. Sampling misses a worst case where some point is certain to be more than a tenth \
                farther than all samples. `measure` samples the boundary of all hulls, \
                verification judges each hull whole. Fractions of the diagonal.";
    let mut table = Table::new("True worst cases", note, &header);
    for method in METHODS {
        let is_own = |row: &&&Row| row.method == method && row.is_default() && row.is_done();
        let rows: Vec<&Row> = results.rows.iter().filter(is_own).copied().collect();
        let found: Vec<[f64; 4]> = rows
            .iter()
            .filter_map(|row| {
                let protrusion = [row.protrusion_max?, row.protrusion_verified?];
                let uncovered = [row.uncovered_max?, row.uncovered_verified?];
                Some([protrusion[0], protrusion[1], uncovered[0], uncovered[1]])
            })
            .collect();
        if found.is_empty() {
            continue;
        }
        let column = |index: usize| -> Vec<f64> { found.iter().map(|row| row[index]).collect() };
        let most = |index: usize| column(index).into_iter().fold(0.0, f64::max);
        let mut ratios: Vec<f64> = found
            .iter()
            .filter(|row| row[0] > LEAST)
            .map(|[sampled, verified, ..]| verified / sampled)
            .collect();
        ratios.sort_unstable_by(f64::total_cmp);
        let missed = rows.iter().filter(|row| is_missed(row)).count();
        let mut cells = vec![method.to_owned(), found.len().to_string()];
        cells.extend([median(column(0)), median(column(1))].map(number));
        // The bounded method says what it has verified itself, and does not resolve what is far
        // below its bound.
        if method == "bounded" || ratios.is_empty() {
            cells.extend([NOTHING; 4].map(String::from));
        } else {
            cells.extend([0.5, 0.99, 1.0].map(|share| number(quantile(&ratios, share))));
            cells.push(missed.to_string());
        }
        cells.extend([0, 1, 2, 3].map(|index| number(most(index))));
        table.rows.push(cells);
    }
    table
}

/// Whether some point is certain to protrude by more than a tenth more than all samples.
fn is_missed(row: &Row) -> bool {
    let figures = (row.protrusion_max, row.protrusion_verified, row.verified_resolution);
    let (Some(sampled), Some(verified), Some(resolution)) = figures else { return false };
    sampled > LEAST && verified - resolution > 1.1 * sampled
}
