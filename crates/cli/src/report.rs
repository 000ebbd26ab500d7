//! A decomposition for people, as tables, and for programs, as one line of JSON; the surface
//! method's search, and the curve of hulls against error.

use std::path::Path;

use comfy_table::{CellAlignment, Table, presets};
use hullwright::merge_tree::CurvePoint;
use hullwright::surface::{ResolutionOutcome, SurfaceReport, ThresholdOutcome};
use hullwright::{Decomposition, Error, Hull, MethodReport, ProbeReport, Report};
use hullwright_cli::terminal::time;
use hullwright_formats::{MeshFile, Note};
use serde_json::{Map, Value, json};

use crate::notes::lines;

/// The columns of the paper's Table 1.
const SUMMARY_HEADER: [&str; 8] =
    ["pieces", "average pieces", "time", "cost", "p", "r", "final polygons", "initial polygons"];

/// Lengths are percentages of the mesh's diagonal. What is called at most is verified, not sampled.
const BOUNDED_HEADER: [&str; 7] =
    ["hulls", "vertices", "time", "bound", "protrusion at most", "uncovered at most", "triangles"];

const SEARCH_HEADER: [&str; 7] =
    ["r", "target", "polygons", "p", "pieces", "cost", "what became of it"];

/// Spaces before and after each column.
const PADDING: (u16, u16) = (0, 2);

/// Stands where there is no number.
const NOTHING: &str = "–";

/// Vertices of all hulls.
pub fn vertices(hulls: &[Hull]) -> usize {
    hulls.iter().map(|hull| hull.shape.points.len()).sum()
}

/// A table with one row, and a line for each remark on the file and on the work.
///
/// `seconds` is the wall-clock time of the decomposition, without reading and writing.
pub fn summary(
    notes: &[Note],
    decomposition: &Decomposition<MethodReport>,
    seconds: f64,
) -> String {
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
                surface.planar_threshold.map_or(NOTHING.into(), |p| p.to_string()),
                surface.resolution.to_string(),
                surface.polygons.to_string(),
                surface.initial_polygons.to_string(),
            ];
            right_aligned(&SUMMARY_HEADER, [row]).trim_fmt()
        }
        (None, bounded) => {
            let percent = |length: fn(&Report) -> f64| match bounded {
                Some(bounded) => percent_of(length(bounded), run.diagonal),
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
    if let Some(probe) = report.bounded().and_then(|bounded| bounded.probe) {
        text += &format!("\n{}", of_probe(&probe, run.diagonal));
    }
    for line in lines(notes).into_iter().chain(decomposition.remarks()) {
        text += &format!("\n{line}");
    }
    text
}

/// What a probe found.
fn of_probe(probe: &ProbeReport, diagonal: f64) -> String {
    let radius = percent_of(probe.radius, diagonal);
    let volume = probe.unreachable_volume;
    let mut text = format!("probe: a ball of radius {radius} can't reach {volume:.3e} cubic units");
    if probe.cell > probe.radius {
        text += ", and may reach more than is known: the mesh is too large for so small a ball";
    }
    text
}

/// A length as a percentage of the diagonal.
fn percent_of(length: f64, diagonal: f64) -> String {
    format!("{:.3} %", 100.0 * length / diagonal)
}

/// Hulls against error.
pub fn curve(curve: &[CurvePoint], diagonal: f64) -> String {
    let percent = |length| percent_of(length, diagonal);
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

/// Every resolution, and below it its thresholds.
pub fn search(surface: &SurfaceReport) -> String {
    let mut rows = Vec::new();
    for resolution in &surface.resolutions {
        let mut row = [""; 7].map(String::from);
        row[0] = resolution.resolution.to_string();
        row[1] = resolution.target.to_string();
        row[2] = resolution.polygons.to_string();
        row[6] = of_resolution(resolution.outcome).1.into();
        rows.push(row);
        for threshold in &resolution.thresholds {
            let mut row = [""; 7].map(String::from);
            row[3] = threshold.planar_threshold.map_or(NOTHING.into(), |p| p.to_string());
            if threshold.outcome != ThresholdOutcome::NotTried {
                row[4] = threshold.pieces.to_string();
                row[5] = cost(threshold.cost);
            }
            row[6] = of_threshold(threshold.outcome).1.into();
            rows.push(row);
        }
    }
    let mut table = right_aligned(&SEARCH_HEADER, rows);
    if let Some(words) = table.column_mut(SEARCH_HEADER.len() - 1) {
        words.set_cell_alignment(CellAlignment::Left);
    }
    table.trim_fmt() + "\n"
}

fn right_aligned<const N: usize>(
    header: &[&str; N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(*header).add_rows(rows);
    for column in table.column_iter_mut() {
        column.set_padding(PADDING);
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn cost(cost: f64) -> String {
    format!("{cost:.4}")
}

/// One line of JSON: `docs/command.md` lists its keys. Lengths are in the mesh's units. What
/// belongs to another method is null.
///
/// `seconds` is the wall-clock time of the decomposition, without reading and writing.
///
/// # Errors
/// None for a mesh that was decomposed.
pub fn json(
    mesh: &Path,
    file: &MeshFile,
    decomposition: &Decomposition<MethodReport>,
    seconds: f64,
    with_search: bool,
) -> Result<Value, Error> {
    let Decomposition { hulls, run, report, .. } = decomposition;
    let (bounded, surface) = (report.bounded(), report.surface());
    let closed = |is_closed: bool| {
        run.openings.iter().filter(move |opening| opening.outcome.is_closed() == is_closed)
    };
    let area =
        |is_closed| closed(is_closed).map(|opening| opening.area).fold(0.0, |sum, area| sum + area);
    let notes = file.notes.iter().map(
        |note| json!({ "kind": note.kind.name(), "count": note.count, "text": note.to_string() }),
    );
    let stages = run.times.iter().map(|time| (time.stage.name().into(), time.seconds.into()));
    let mut line = json!({
        "mesh": mesh.display().to_string(),
        "method": report.name(),
        "notes": notes.collect::<Value>(),
        "triangles": run.source_triangles,
        "hulls": hulls.len(),
        "vertices": vertices(hulls),
        "seconds": seconds,
        "bound": bounded.map(|bounded| bounded.bound),
        "protrusion_max": bounded.map(|bounded| bounded.protrusion_max),
        "uncovered_max": bounded.map(|bounded| bounded.uncovered_max),
        "hulls_without_vertex_limit": bounded.map(|bounded| bounded.hulls_without_vertex_limit),
        "patches": bounded.map(|bounded| bounded.patches),
        "patches_across_folds": bounded.map(|bounded| bounded.patches_across_folds),
        "probe": bounded.and_then(|bounded| bounded.probe),
        "cost": surface.map(|surface| surface.cost),
        "planar_threshold": surface.and_then(|surface| surface.planar_threshold),
        "concavity_threshold": surface.and_then(|surface| surface.concavity_threshold),
        "resolution": surface.map(|surface| surface.resolution),
        "repairs": run.repairs,
        // Areas are in squared units.
        "openings": {
            "closed": closed(true).count(),
            "left": closed(false).count(),
            "closed_area": area(true),
            "left_area": area(false),
            "list": run.openings,
        },
        "algorithm_version": run.algorithm_version,
        "version": env!("CARGO_PKG_VERSION"),
        "average_pieces": surface.map(|surface| surface.average_pieces),
        "pieces_before_merging": surface.map(|surface| surface.pieces_before_merging),
        "polygons": surface.map(|found| found.polygons).or(bounded.map(|found| found.polygons)),
        "initial_polygons": surface.map(|surface| surface.initial_polygons),
        "unit": surface.map(|surface| surface.unit),
        "source_vertices": run.source_vertices,
        "diagonal": run.diagonal,
        "components": run.components,
        "closed_components": run.closed_components,
        // What several hulls hold counts several times.
        "volume_sum": hulls.iter().map(|hull| hull.shape.volume()).sum::<f64>(),
        "thickened_hulls": hulls.iter().filter(|hull| hull.errors.added_thickness > 0.0).count(),
        "grown_hulls":
            hulls.iter().filter(|hull| hull.errors.simplification_growth > 0.0).count(),
        "deadline_reached": run.deadline_reached,
        // In the order of the work.
        "stage_seconds": stages.collect::<Map<String, Value>>(),
        "parts": file.parts.list,
        "part_shares": file.parts.shares(file, hulls)?,
    });
    if let (Some(surface), true, Some(line)) = (surface, with_search, line.as_object_mut()) {
        line.insert("search".into(), search_json(surface));
    }
    Ok(line)
}

/// Without pieces and cost where a threshold was not tried.
fn search_json(surface: &SurfaceReport) -> Value {
    let resolutions = surface.resolutions.iter().map(|resolution| {
        let thresholds = resolution.thresholds.iter().map(|threshold| {
            let is_tried = threshold.outcome != ThresholdOutcome::NotTried;
            json!({
                "planar_threshold": threshold.planar_threshold,
                "pieces": is_tried.then_some(threshold.pieces),
                "cost": is_tried.then_some(threshold.cost),
                "outcome": of_threshold(threshold.outcome).0,
            })
        });
        json!({
            "resolution": resolution.resolution,
            "target": resolution.target,
            "polygons": resolution.polygons,
            "outcome": of_resolution(resolution.outcome).0,
            "thresholds": thresholds.collect::<Value>(),
        })
    });
    resolutions.collect()
}

/// What became of a resolution: a name for programs, and words for people.
fn of_resolution(of: ResolutionOutcome) -> (&'static str, &'static str) {
    use ResolutionOutcome::*;
    match of {
        Selected => ("selected", "selected: least cost of those left"),
        CostlierThanSelected => ("costlier_than_selected", "dropped: another costs less"),
        TooManyPieces => ("too_many_pieces", "dropped: more than 1.5 times the average pieces"),
        CutOff => ("cut_off", "skipped: an earlier one has fewer pieces than the cut-off"),
        SameAsBefore => ("same_as_before", "skipped: the same mesh as the one before"),
        DeadlineReached => ("deadline_reached", "skipped: deadline"),
        _ => ("other", "other"),
    }
}

/// What became of a threshold, likewise.
fn of_threshold(of: ThresholdOutcome) -> (&'static str, &'static str) {
    use ThresholdOutcome::*;
    match of {
        Candidate => ("candidate", "candidate: fewest pieces under ε"),
        CandidateAtOnce => ("candidate_at_once", "candidate: next to no cost, taken at once"),
        CandidateByFailSafe => {
            ("candidate_by_fail_safe", "candidate: least cost, since none is under ε")
        }
        MorePieces => ("more_pieces", "under ε, but another has fewer pieces"),
        TooCostly => ("too_costly", "not under ε"),
        AbortedAboveThreshold => ("aborted_above_threshold", "given up: average above 3 ε"),
        AbortedAboveLeast => ("aborted_above_least", "given up: average above 3 times the least"),
        SingleGroup => ("single_group", "a single group: ends this search"),
        NotTried => ("not_tried", "not tried"),
        _ => ("other", "other"),
    }
}
