//! A decomposition for programs: one line of JSON.

use hullwright::{Repairs, Report, ResolutionReport, SurfaceReport, ThresholdOutcome};
use serde_json::{Map, Value, json};

use crate::decompose::Outcome;
use crate::tables::{resolution_outcome, threshold_outcome};

pub fn line(outcome: &Outcome) -> String {
    let hulls = &outcome.decomposition.hulls;
    let report = &outcome.decomposition.report;
    let surface = report.surface.as_ref();
    let bounded = report.bounded.as_ref();
    let mut line = json!({
        "mesh": outcome.mesh(),
        "method": report.method.name(),
        "triangles": report.source_triangles,
        "hulls": hulls.len(),
        "vertices": outcome.vertices(),
        "seconds": outcome.seconds,
        "bound": bounded.map(|bounded| bounded.bound),
        "protrusion_max": bounded.map(|bounded| bounded.protrusion_max),
        "uncovered_max": bounded.map(|bounded| bounded.uncovered_max),
        "patches": bounded.map(|bounded| bounded.patches),
        "cost": surface.map(|surface| surface.cost),
        "planar_threshold": surface.map(|surface| surface.planar_threshold),
        "resolution": surface.map(|surface| surface.resolution),
        "repairs": repairs(&report.repairs),
        "algorithm_version": report.algorithm_version,
        "version": env!("CARGO_PKG_VERSION"),
        "average_pieces": surface.map(|surface| surface.average_pieces),
        "pieces_before_merging": surface.map(|surface| surface.pieces_before_merging),
        "polygons": surface.map(|surface| surface.polygons).or(bounded.map(|bounded| bounded.polygons)),
        "initial_polygons": surface.map(|surface| surface.initial_polygons),
        "unit": surface.map(|surface| surface.unit),
        "source_vertices": report.source_vertices,
        "diagonal": report.diagonal,
        "components": report.components,
        "closed_components": report.closed_components,
        "volume_sum": hulls.iter().map(|hull| hull.shape.volume()).sum::<f64>(),
        "thickened_hulls": hulls.iter().filter(|hull| hull.errors.added_thickness > 0.0).count(),
        "grown_hulls": hulls.iter().filter(|hull| hull.errors.simplification_growth > 0.0).count(),
        "deadline_reached": report.deadline_reached,
        "stage_seconds": stage_seconds(report),
    });
    if let Some(surface) = surface
        && outcome.shows_search()
    {
        line["search"] = search(surface);
    }
    line.to_string()
}

fn repairs(repairs: &Repairs) -> Value {
    json!({
        "welded_vertices": repairs.welded_vertices,
        "unused_vertices": repairs.unused_vertices,
        "non_finite_triangles": repairs.non_finite_triangles,
        "degenerate_triangles": repairs.degenerate_triangles,
        "duplicate_triangles": repairs.duplicate_triangles,
        "flipped_triangles": repairs.flipped_triangles,
        "non_manifold_edges": repairs.non_manifold_edges,
        "open_edges": repairs.open_edges,
    })
}

fn stage_seconds(report: &Report) -> Map<String, Value> {
    let seconds = |time: &hullwright::StageTime| (time.stage.name().into(), time.seconds.into());
    report.times.iter().map(seconds).collect()
}

fn search(surface: &SurfaceReport) -> Value {
    surface.resolutions.iter().map(resolution).collect()
}

fn resolution(report: &ResolutionReport) -> Value {
    let thresholds = report.thresholds.iter().map(|threshold| {
        let is_tried = threshold.outcome != ThresholdOutcome::NotTried;
        json!({
            "planar_threshold": threshold.planar_threshold,
            "pieces": is_tried.then_some(threshold.pieces),
            "cost": is_tried.then_some(threshold.cost),
            "outcome": threshold_outcome(threshold.outcome)[0],
        })
    });
    json!({
        "resolution": report.resolution,
        "target": report.target,
        "polygons": report.polygons,
        "outcome": resolution_outcome(report.outcome)[0],
        "thresholds": thresholds.collect::<Value>(),
    })
}
