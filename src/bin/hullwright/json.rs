//! A decomposition for programs: one line of JSON.

use std::path::Path;

use hullwright::surface::{ResolutionReport, SurfaceReport, ThresholdOutcome, ThresholdReport};
use hullwright::{Decomposition, MethodReport, Opening, Repairs, Report, RunReport};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::hulls::vertices;
use crate::outcomes::{of_resolution, of_threshold};

/// Lengths are in the mesh's units. What belongs to another method is null.
#[derive(Serialize)]
pub struct DecompositionLine {
    mesh: String,
    method: &'static str,
    /// Of the input.
    triangles: usize,
    hulls: usize,
    vertices: usize,
    seconds: f64,
    bound: Option<f64>,
    protrusion_max: Option<f64>,
    uncovered_max: Option<f64>,
    patches: Option<usize>,
    cost: Option<f64>,
    planar_threshold: Option<f64>,
    resolution: Option<usize>,
    repairs: RepairsLine,
    openings: OpeningsLine,
    algorithm_version: u32,
    version: &'static str,
    average_pieces: Option<f64>,
    pieces_before_merging: Option<usize>,
    polygons: Option<usize>,
    initial_polygons: Option<usize>,
    unit: Option<f64>,
    source_vertices: usize,
    diagonal: f64,
    components: usize,
    closed_components: usize,
    /// Of all hulls, so that what several hold counts several times.
    volume_sum: f64,
    thickened_hulls: usize,
    grown_hulls: usize,
    deadline_reached: bool,
    /// By stage, in the order of the work.
    stage_seconds: Map<String, Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    search: Option<Vec<ResolutionLine>>,
}

#[derive(Serialize)]
struct RepairsLine {
    welded_vertices: usize,
    unused_vertices: usize,
    non_finite_triangles: usize,
    degenerate_triangles: usize,
    duplicate_triangles: usize,
    flipped_triangles: usize,
    non_manifold_edges: usize,
    open_edges: usize,
}

/// Areas are in squared units.
#[derive(Serialize)]
struct OpeningsLine {
    closed: usize,
    left: usize,
    closed_area: f64,
    left_area: f64,
    list: Vec<Opening>,
}

impl From<&[Opening]> for OpeningsLine {
    fn from(openings: &[Opening]) -> Self {
        let is_closed = |opening: &&Opening| opening.outcome.is_closed();
        let (closed, left): (Vec<&Opening>, Vec<&Opening>) = openings.iter().partition(is_closed);
        let area = |of: &[&Opening]| of.iter().map(|opening| opening.area).sum();
        Self {
            closed: closed.len(),
            left: left.len(),
            closed_area: area(&closed),
            left_area: area(&left),
            list: openings.to_vec(),
        }
    }
}

#[derive(Serialize)]
struct ResolutionLine {
    resolution: usize,
    target: usize,
    polygons: usize,
    outcome: &'static str,
    thresholds: Vec<ThresholdLine>,
}

/// Without pieces and cost where it was not tried.
#[derive(Serialize)]
struct ThresholdLine {
    planar_threshold: f64,
    pieces: Option<usize>,
    cost: Option<f64>,
    outcome: &'static str,
}

impl DecompositionLine {
    /// `seconds` is the wall-clock time of the decomposition, without reading and writing.
    pub fn new(
        mesh: &Path,
        decomposition: &Decomposition<MethodReport>,
        seconds: f64,
        search: bool,
    ) -> Self {
        let Decomposition { hulls, run, report, .. } = decomposition;
        let (bounded, surface) = (report.bounded(), report.surface());
        let of_bounded = |of: fn(&Report) -> f64| bounded.map(of);
        let of_surface = |of: fn(&SurfaceReport) -> f64| surface.map(of);
        let polygons = surface.map(|surface| surface.polygons);
        Self {
            mesh: mesh.display().to_string(),
            method: report.name(),
            triangles: run.source_triangles,
            hulls: hulls.len(),
            vertices: vertices(hulls),
            seconds,
            bound: of_bounded(|bounded| bounded.bound),
            protrusion_max: of_bounded(|bounded| bounded.protrusion_max),
            uncovered_max: of_bounded(|bounded| bounded.uncovered_max),
            patches: bounded.map(|bounded| bounded.patches),
            cost: of_surface(|surface| surface.cost),
            planar_threshold: of_surface(|surface| surface.planar_threshold),
            resolution: surface.map(|surface| surface.resolution),
            repairs: RepairsLine::from(&run.repairs),
            openings: OpeningsLine::from(run.openings.as_slice()),
            algorithm_version: run.algorithm_version,
            version: env!("CARGO_PKG_VERSION"),
            average_pieces: of_surface(|surface| surface.average_pieces),
            pieces_before_merging: surface.map(|surface| surface.pieces_before_merging),
            polygons: polygons.or(bounded.map(|bounded| bounded.polygons)),
            initial_polygons: surface.map(|surface| surface.initial_polygons),
            unit: of_surface(|surface| surface.unit),
            source_vertices: run.source_vertices,
            diagonal: run.diagonal,
            components: run.components,
            closed_components: run.closed_components,
            volume_sum: hulls.iter().map(|hull| hull.shape.volume()).sum(),
            thickened_hulls: hulls.iter().filter(|hull| hull.errors.added_thickness > 0.0).count(),
            grown_hulls: hulls
                .iter()
                .filter(|hull| hull.errors.simplification_growth > 0.0)
                .count(),
            deadline_reached: run.deadline_reached,
            stage_seconds: stage_seconds(run),
            search: surface
                .filter(|_| search)
                .map(|surface| surface.resolutions.iter().map(ResolutionLine::from).collect()),
        }
    }
}

fn stage_seconds(run: &RunReport) -> Map<String, Value> {
    run.times.iter().map(|time| (time.stage.name().into(), time.seconds.into())).collect()
}

impl From<&Repairs> for RepairsLine {
    fn from(repairs: &Repairs) -> Self {
        Self {
            welded_vertices: repairs.welded_vertices,
            unused_vertices: repairs.unused_vertices,
            non_finite_triangles: repairs.non_finite_triangles,
            degenerate_triangles: repairs.degenerate_triangles,
            duplicate_triangles: repairs.duplicate_triangles,
            flipped_triangles: repairs.flipped_triangles,
            non_manifold_edges: repairs.non_manifold_edges,
            open_edges: repairs.open_edges,
        }
    }
}

impl From<&ResolutionReport> for ResolutionLine {
    fn from(report: &ResolutionReport) -> Self {
        Self {
            resolution: report.resolution,
            target: report.target,
            polygons: report.polygons,
            outcome: of_resolution(report.outcome).name,
            thresholds: report.thresholds.iter().map(ThresholdLine::from).collect(),
        }
    }
}

impl From<&ThresholdReport> for ThresholdLine {
    fn from(report: &ThresholdReport) -> Self {
        let is_tried = report.outcome != ThresholdOutcome::NotTried;
        Self {
            planar_threshold: report.planar_threshold,
            pieces: is_tried.then_some(report.pieces),
            cost: is_tried.then_some(report.cost),
            outcome: of_threshold(report.outcome).name,
        }
    }
}
