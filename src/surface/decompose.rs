//! The paper's method, stage by stage: simplify (3.2), search (3.4 and 3.5), merge (3.6), hulls.

use super::group_merging::merge_groups;
use super::grouping::Grouping;
use super::pieces::{assign_source_triangles, hulls};
use super::resolution_selection::{Level, Levels, first_cut_off, select};
use crate::control::{Control, Stage};
use crate::decomposition::{GroupedMesh, Hull, SurfaceReport};
use crate::error::Error;
use crate::mesh::{Normalization, PreparedMesh, TriangleMesh};
use crate::parameters::{Length, Parameters, SurfaceParameters};
use crate::stages::Stages;

/// Hulls in the input's units, and how they were found.
pub(crate) struct SurfaceResult {
    pub hulls: Vec<Hull>,
    pub grouped: GroupedMesh,
    pub report: SurfaceReport,
    /// Whether the search ended at the deadline.
    pub is_cut_short: bool,
}

/// The stages of the paper's method, of which each resolution and each threshold is a slice.
///
/// # Errors
/// [`Error::Cancelled`], [`Error::Simplification`], and [`Error::DeadlineExceeded`] where the deadline
/// comes before the first threshold.
pub(crate) async fn decompose(
    prepared: &PreparedMesh,
    parameters: &Parameters,
    stages: &mut Stages,
) -> Result<SurfaceResult, Error> {
    let (surface, control) = (&parameters.surface, &stages.control());
    let normalization = &prepared.normalization;
    let unit = match surface.unit {
        Length::Share(unit) => unit,
        Length::Units(unit) => unit / normalization.diagonal,
    };
    let mut levels = Levels::new(surface);
    while !levels.is_complete() {
        let share = levels.share_done();
        let simplify = || levels.make_next(prepared, surface, control);
        stages.run_slice(Stage::Simplify, share, simplify).await?;
    }
    let mut levels = levels.finish();
    let mut is_cut_short = false;
    while !is_cut_short && next_level(&levels, surface).is_some() {
        let share = share_done(&levels, surface);
        let search = || search(&mut levels, surface, unit, control);
        stages.run_slice(Stage::Search, share, search).await?;
        is_cut_short = control.is_past_deadline() && next_level(&levels, surface).is_some();
    }
    let selection = select(&levels, surface.resolution_cut_off).ok_or(Error::DeadlineExceeded)?;
    let level = levels.get(selection.level).ok_or(Error::DeadlineExceeded)?;
    let found = &selection.candidate;
    let significant = surface.significant_diagonal;
    let merge = || Ok(merge_groups(&level.mesh, &level.adjacency, &found.grouping, significant));
    let grouping = stages.run(Stage::Merge, merge).await?;
    let hulls = hulls_of_groups(prepared, level.into(), &grouping, parameters, stages).await?;
    let report = SurfaceReport {
        pieces: grouping.count,
        pieces_before_merging: found.grouping.count,
        average_pieces: selection.average_pieces,
        cost: found.cost,
        planar_threshold: found.planar_threshold,
        resolution: level.resolution,
        polygons: level.mesh.triangles.len(),
        initial_polygons: prepared.mesh.triangles.len(),
        unit: unit * normalization.diagonal,
        resolutions: selection.reports,
    };
    let grouped = grouped(&level.mesh, grouping, normalization);
    Ok(SurfaceResult { hulls, grouped, report, is_cut_short })
}

/// The hull of all points, in the input's units, and the mesh as its one group. O(n log n).
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) async fn one_hull(
    prepared: &PreparedMesh,
    parameters: &Parameters,
    stages: &mut Stages,
) -> Result<(Vec<Hull>, GroupedMesh), Error> {
    let PreparedMesh { mesh, components, normalization, .. } = prepared;
    let grouping = Grouping { labels: vec![0; mesh.triangles.len()], count: 1 };
    let whole = GroupableMesh { mesh, components };
    let hulls = hulls_of_groups(prepared, whole, &grouping, parameters, stages).await?;
    Ok((hulls, grouped(mesh, grouping, normalization)))
}

/// A mesh, and for each of its triangles its component.
#[derive(Clone, Copy)]
struct GroupableMesh<'a> {
    mesh: &'a TriangleMesh,
    components: &'a [u32],
}

impl<'a> From<&'a Level> for GroupableMesh<'a> {
    fn from(Level { mesh, components, .. }: &'a Level) -> Self {
        Self { mesh, components }
    }
}

/// The hull of each group, and the source triangles that it stands for.
async fn hulls_of_groups(
    prepared: &PreparedMesh,
    GroupableMesh { mesh, components }: GroupableMesh<'_>,
    grouping: &Grouping,
    parameters: &Parameters,
    stages: &mut Stages,
) -> Result<Vec<Hull>, Error> {
    let (normalization, most) = (&prepared.normalization, parameters.max_vertices);
    let control = &stages.control();
    let make = || hulls(mesh, components, grouping, normalization, most, control);
    let mut hulls = stages.run(Stage::Hulls, make).await?;
    let assign = || assign_source_triangles(prepared, mesh, grouping, &mut hulls, control);
    stages.run(Stage::Assign, assign).await?;
    Ok(hulls)
}

fn grouped(mesh: &TriangleMesh, grouping: Grouping, normalization: &Normalization) -> GroupedMesh {
    GroupedMesh {
        positions: mesh.positions.iter().map(|&point| normalization.restore(point)).collect(),
        triangles: mesh.triangles.clone(),
        groups: grouping.labels,
    }
}

/// The first level with thresholds left to try. A level that is cut off has no more to do, nor have those
/// above it.
fn next_level(levels: &[Level], surface: &SurfaceParameters) -> Option<usize> {
    let open =
        first_cut_off(levels, surface.resolution_cut_off).map_or(levels.len(), |last| last + 1);
    levels[..open].iter().position(|level| !level.is_finished())
}

/// Tries the next threshold, or on several threads all that are left.
fn search(
    levels: &mut [Level],
    surface: &SurfaceParameters,
    unit: f64,
    control: &Control,
) -> Result<(), Error> {
    #[cfg(feature = "parallel")]
    if control.is_parallel() && rayon::current_num_threads() > 1 {
        use rayon::prelude::*;
        return levels.par_iter_mut().try_for_each(|level| {
            while !level.is_finished() && !control.is_past_deadline() {
                level.advance(surface, unit, control)?;
            }
            Ok(())
        });
    }
    match next_level(levels, surface) {
        Some(next) => levels[next].advance(surface, unit, control),
        None => Ok(()),
    }
}

/// The share of the thresholds that were tried.
fn share_done(levels: &[Level], surface: &SurfaceParameters) -> f32 {
    let all = levels.len() * surface.planar_thresholds.len();
    let done: usize = levels.iter().map(|level| level.search.reports.len()).sum();
    done as f32 / all.max(1) as f32
}
