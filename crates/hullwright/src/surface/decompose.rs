//! The paper's method, stage by stage: simplify (3.2), search (3.4 and 3.5), merge (3.6), hulls.

use super::parameters::SurfaceParameters;
use super::pieces::{Pieces, merge_groups};
use super::resolution_selection::{Level, Levels, ResolutionReport, first_cut_off, select};
use super::threshold_selection::Thresholds;
use crate::control::{Control, Stage};
use crate::decomposer::{Input, admit, run_to_end};
use crate::decomposition::Decomposition;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::prepare as repair;
use crate::parameters::Length;
use crate::stages::{PREPARED, SURFACE, Stages};

/// The paper's search tree and what it chose: a row of its Table 1.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceReport {
    /// Pieces, after group merging.
    pub pieces: usize,
    /// Groups of the chosen candidate before group merging.
    pub pieces_before_merging: usize,
    /// k: average number of pieces over the candidates of all resolutions. Groups of one or two
    /// polygons are not counted.
    pub average_pieces: f64,
    /// Average concavity cost of the chosen candidate, equation (3).
    pub cost: f64,
    /// p of the chosen candidate, in units of the thresholds; none for HACD.
    pub planar_threshold: Option<f64>,
    /// β, where HACD has grouped the surface.
    pub concavity_threshold: Option<f64>,
    /// r of the chosen candidate.
    pub resolution: usize,
    /// Triangles of the simplified mesh.
    pub polygons: usize,
    /// Triangles before simplification.
    pub initial_polygons: usize,
    /// The length that counted as 1 for p and a, in the input's units.
    pub unit: f64,
    /// The whole tree, in the order of R.
    pub resolutions: Vec<ResolutionReport>,
}

/// Decomposes a triangle mesh by the paper's method, or by HACD within its frame
/// ([`SurfaceParameters::concavity_threshold`]). Openings stay as they are, and nothing is
/// verified.
///
/// # Errors
/// As [`decompose`](crate::decompose()). On several threads [`Error::DeadlineExceeded`] also where
/// the deadline comes before the first threshold.
pub fn decompose<'a>(
    mesh: impl Into<MeshView<'a>>,
    parameters: &SurfaceParameters,
    control: &Control,
) -> Result<Decomposition<SurfaceReport>, Error> {
    let mesh = mesh.into();
    parameters.validate()?;
    admit(mesh, control)?;
    run_to_end(pipeline(mesh, parameters, control))
}

/// The whole of a decomposition. Each resolution and each threshold is a slice; for HACD the
/// search of each resolution.
pub(crate) async fn pipeline(
    mesh: MeshView<'_>,
    parameters: &SurfaceParameters,
    control: &Control,
) -> Result<Decomposition<SurfaceReport>, Error> {
    let mut stages = Stages::new(control);
    let repaired = stages.run(Stage::Repair, || repair(mesh, MeshOrder::Input, control)).await?;
    let input = Input::as_it_is(mesh, repaired);
    let prepared = &input.prepared;
    let normalization = &prepared.normalization;
    let unit = match parameters.unit {
        Length::Share(unit) => unit,
        Length::Units(unit) => unit / normalization.diagonal,
    };
    stages.begin(SURFACE, PREPARED..1.0);
    let mut levels = simplify(prepared, parameters, &mut stages).await?;
    let mut is_cut_short = false;
    while !is_cut_short && next_level(&levels, parameters).is_some() {
        let share = share_done(&levels, parameters);
        let thresholds = Thresholds { parameters, unit };
        let search = || search(&mut levels, thresholds, control);
        stages.run_slice(Stage::Search, share, search).await?;
        is_cut_short = control.is_past_deadline() && next_level(&levels, parameters).is_some();
    }
    let selection =
        select(&levels, parameters.resolution_cut_off).ok_or(Error::DeadlineExceeded)?;
    let level = levels.get(selection.level).ok_or(Error::DeadlineExceeded)?;
    let found = &selection.candidate;
    let significant = parameters.significant_diagonal;
    let merge = || Ok(merge_groups(&level.mesh, &level.adjacency, &found.grouping, significant));
    let grouping = stages.run(Stage::Merge, merge).await?;
    let pieces = Pieces { mesh: &level.mesh, components: &level.components, grouping: &grouping };
    let hulls = pieces.finish(prepared, parameters.max_vertices, &mut stages).await?;
    let grouped = pieces.grouped_mesh(normalization);
    let report = SurfaceReport {
        pieces: grouping.count,
        pieces_before_merging: found.grouping.count,
        average_pieces: selection.average_pieces,
        cost: found.cost,
        planar_threshold: found.planar_threshold,
        concavity_threshold: parameters.concavity_threshold,
        resolution: level.resolution,
        polygons: level.mesh.triangles.len(),
        initial_polygons: prepared.mesh.triangles.len(),
        unit: unit * normalization.diagonal,
        resolutions: selection.reports,
    };
    Ok(Decomposition { hulls, grouped, run: input.report(stages, is_cut_short), report })
}

/// The simplified meshes of all resolutions.
async fn simplify(
    prepared: &PreparedMesh,
    parameters: &SurfaceParameters,
    stages: &mut Stages,
) -> Result<Vec<Level>, Error> {
    let control = &stages.control();
    let mut levels = Levels::new(parameters);
    while !levels.is_complete() {
        let share = levels.share_done();
        let simplify = || levels.advance(prepared, parameters, control);
        stages.run_slice(Stage::Simplify, share, simplify).await?;
    }
    Ok(levels.finish())
}

/// The first level with thresholds left to try. A level that is cut off has no more to do, nor have
/// those above it.
fn next_level(levels: &[Level], parameters: &SurfaceParameters) -> Option<usize> {
    let open =
        first_cut_off(levels, parameters.resolution_cut_off).map_or(levels.len(), |last| last + 1);
    levels[..open].iter().position(|level| !level.is_finished())
}

/// Tries the next threshold, or on several threads all that are left.
fn search(
    levels: &mut [Level],
    thresholds: Thresholds<'_>,
    control: &Control,
) -> Result<(), Error> {
    #[cfg(feature = "parallel")]
    if control.is_parallel() && rayon::current_num_threads() > 1 {
        use rayon::prelude::*;
        return levels.par_iter_mut().try_for_each(|level| {
            while !level.is_finished() && !control.is_past_deadline() {
                level.advance(thresholds, control)?;
            }
            Ok(())
        });
    }
    match next_level(levels, thresholds.parameters) {
        Some(next) => levels[next].advance(thresholds, control),
        None => Ok(()),
    }
}

/// The share of the thresholds that were tried.
fn share_done(levels: &[Level], parameters: &SurfaceParameters) -> f32 {
    let leaves = parameters.concavity_threshold.map_or(parameters.planar_thresholds.len(), |_| 1);
    let all = levels.len() * leaves;
    let done: usize = levels.iter().map(|level| level.search.reports.len()).sum();
    done as f32 / all.max(1) as f32
}
