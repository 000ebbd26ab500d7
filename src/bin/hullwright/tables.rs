//! Tables for people: a decomposition as one row, the surface method's search, the curve of hulls
//! against error.

use comfy_table::{CellAlignment, Table, presets};
use hullwright::surface::{SurfaceReport, ThresholdOutcome};
use hullwright::{
    CurvePoint, Decomposition, MethodReport, Opening, OpeningOutcome, Repairs, Report,
};

use crate::hulls::vertices;
use crate::outcomes::{of_resolution, of_threshold};
use crate::output::{count, time};

/// The columns of the paper's Table 1.
const SUMMARY_HEADER: [&str; 8] =
    ["pieces", "average pieces", "time", "cost", "p", "r", "final polygons", "initial polygons"];

/// Lengths are shares of the mesh's diagonal. What is called at most is verified, not sampled.
const BOUNDED_HEADER: [&str; 7] =
    ["hulls", "vertices", "time", "bound", "protrusion at most", "uncovered at most", "triangles"];

const SEARCH_HEADER: [&str; 7] =
    ["r", "target", "polygons", "p", "pieces", "cost", "what became of it"];

/// Spaces before and after each column.
const PADDING: (u16, u16) = (0, 2);

/// Stands where there is no number.
pub const NOTHING: &str = "–";

/// A table with one row, and a line about repairs if there were any.
///
/// `seconds` is the wall-clock time of the decomposition, without reading and writing.
pub fn summary(decomposition: &Decomposition<MethodReport>, seconds: f64) -> String {
    let Decomposition { hulls, run, report, .. } = decomposition;
    let pieces = hulls.len().to_string();
    let seconds = time(seconds);
    let mut text = match (report.surface(), report.bounded()) {
        (Some(surface), _) => {
            let row = [
                pieces,
                format!("{:.1}", surface.average_pieces),
                seconds,
                cost(surface.cost),
                surface.planar_threshold.to_string(),
                surface.resolution.to_string(),
                surface.polygons.to_string(),
                surface.initial_polygons.to_string(),
            ];
            right_aligned(&SUMMARY_HEADER, [row]).trim_fmt()
        }
        (None, bounded) => {
            let percent = |length: fn(&Report) -> f64| match bounded {
                Some(bounded) => format!("{:.3} %", 100.0 * length(bounded) / run.diagonal),
                None => NOTHING.into(),
            };
            let row = [
                pieces,
                vertices(hulls).to_string(),
                seconds,
                percent(|bounded| bounded.bound),
                percent(|bounded| bounded.protrusion_max),
                percent(|bounded| bounded.uncovered_max),
                run.source_triangles.to_string(),
            ];
            right_aligned(&BOUNDED_HEADER, [row]).trim_fmt()
        }
    };
    let repairs = repairs(&run.repairs);
    if !repairs.is_empty() {
        text += &format!("\nrepaired: {}", repairs.join(", "));
    }
    if let Some(openings) = openings(&run.openings) {
        text += &format!("\nopenings: {openings}");
    }
    if run.deadline_reached {
        text += "\nthe deadline cut the search short";
    }
    text
}

/// Hulls against error. Lengths are shares of the diagonal.
pub fn curve(curve: &[CurvePoint], diagonal: f64) -> String {
    let percent = |length: f64| format!("{:.3} %", 100.0 * length / diagonal);
    let rows = curve.iter().map(|point| {
        [
            point.hulls.to_string(),
            percent(point.error),
            percent(point.protrusion_max),
            percent(point.uncovered_max),
        ]
    });
    let header = ["hulls", "error", "protrusion at most", "uncovered at most"];
    right_aligned(&header, rows).trim_fmt()
}

/// What was changed in the input. Open and non-manifold edges stay, so they are no repair.
pub fn repairs(repairs: &Repairs) -> Vec<String> {
    [
        (repairs.welded_vertices, "vertex welded", "vertices welded"),
        (repairs.unused_vertices, "unused vertex dropped", "unused vertices dropped"),
        (
            repairs.non_finite_triangles,
            "triangle that is not finite dropped",
            "triangles that are not finite dropped",
        ),
        (
            repairs.degenerate_triangles,
            "triangle without area dropped",
            "triangles without area dropped",
        ),
        (repairs.duplicate_triangles, "duplicate triangle dropped", "duplicate triangles dropped"),
        (repairs.flipped_triangles, "triangle turned around", "triangles turned around"),
    ]
    .into_iter()
    .filter(|(number, ..)| *number > 0)
    .map(|(number, singular, plural)| count(number, singular, plural))
    .collect()
}

/// How many openings were closed and left, and why, if there are any.
pub fn openings(openings: &[Opening]) -> Option<String> {
    let mut counts: Vec<(OpeningOutcome, usize)> = Vec::new();
    for opening in openings {
        match counts.iter_mut().find(|(outcome, _)| *outcome == opening.outcome) {
            Some((_, count)) => *count += 1,
            None => counts.push((opening.outcome, 1)),
        }
    }
    counts.sort_by_key(|&(outcome, count)| (!outcome.is_closed(), std::cmp::Reverse(count)));
    let texts: Vec<String> =
        counts.iter().map(|(outcome, count)| format!("{count} {}", outcome.describe())).collect();
    (!texts.is_empty()).then(|| texts.join(", "))
}

/// Every resolution, and below it its thresholds.
pub fn search(report: &MethodReport) -> String {
    match report.surface() {
        Some(surface) => search_table(surface).trim_fmt() + "\n",
        None => "this method does not search\n".into(),
    }
}

fn search_table(surface: &SurfaceReport) -> Table {
    let mut rows = Vec::new();
    for resolution in &surface.resolutions {
        let mut row = [""; 7].map(String::from);
        row[0] = resolution.resolution.to_string();
        row[1] = resolution.target.to_string();
        row[2] = resolution.polygons.to_string();
        row[6] = of_resolution(resolution.outcome).words.into();
        rows.push(row);
        for threshold in &resolution.thresholds {
            let mut row = [""; 7].map(String::from);
            row[3] = threshold.planar_threshold.to_string();
            if threshold.outcome != ThresholdOutcome::NotTried {
                row[4] = threshold.pieces.to_string();
                row[5] = cost(threshold.cost);
            }
            row[6] = of_threshold(threshold.outcome).words.into();
            rows.push(row);
        }
    }
    let mut table = right_aligned(&SEARCH_HEADER, rows);
    if let Some(words) = table.column_mut(SEARCH_HEADER.len() - 1) {
        words.set_cell_alignment(CellAlignment::Left);
    }
    table
}

/// Text under a header.
pub fn columns<const N: usize>(
    header: &[&str; N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(*header).add_rows(rows);
    aligned(table, CellAlignment::Left).trim_fmt()
}

/// Names and values, one pair a line.
pub fn pairs(rows: impl IntoIterator<Item = (&'static str, String)>) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.add_rows(rows.into_iter().map(|(name, value)| [name.to_owned(), value]));
    aligned(table, CellAlignment::Left).trim_fmt()
}

fn right_aligned<const N: usize>(
    header: &[&str; N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(*header).add_rows(rows);
    aligned(table, CellAlignment::Right)
}

fn aligned(mut table: Table, alignment: CellAlignment) -> Table {
    for column in table.column_iter_mut() {
        column.set_padding(PADDING);
        column.set_cell_alignment(alignment);
    }
    table
}

fn cost(cost: f64) -> String {
    format!("{cost:.4}")
}
