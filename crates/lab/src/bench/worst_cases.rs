//! What sampling misses: the sampled errors of each method beside upper bounds of the true ones.

use super::summary::{METHODS, Results};
use crate::harness::Row;
use crate::report::{Table, number};
use crate::statistics::{median, quantile};

/// What upper bounds may be above the true distance, as a share of it.
const RESOLUTION: f64 = 0.04;

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
                faces and triangles, at most 1 to 4 % too large. Sampling misses the worst case where the upper bound \
                is farther above what was sampled than that. `measure` samples the boundary of all hulls, \
                verification judges each hull whole. Fractions of the diagonal.";
    let mut table = Table::new("True worst cases", note, &header);
    for method in METHODS {
        let is_own = |row: &&&Row| row.method == method && row.is_default() && row.is_done();
        let found: Vec<[f64; 4]> = results
            .rows
            .iter()
            .filter(is_own)
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
            .filter(|row| row[0] > 0.0)
            .map(|[sampled, verified, ..]| verified / sampled)
            .collect();
        ratios.sort_unstable_by(f64::total_cmp);
        let missed = ratios.iter().filter(|&&ratio| ratio > 1.0 + RESOLUTION).count();
        let mut cells = vec![method.to_owned(), found.len().to_string()];
        cells.extend([median(column(0)), median(column(1))].map(number));
        cells.extend([quantile(&ratios, 0.5), quantile(&ratios, 0.99)].map(number));
        cells.push(number(ratios.last().copied().unwrap_or(1.0)));
        cells.push(missed.to_string());
        cells.extend([0, 1, 2, 3].map(|index| number(most(index))));
        table.rows.push(cells);
    }
    table
}
