//! Hierarchical approximate convex decomposition (HACD, Mamou and Ghorbel 2009) as section 4.2 of
//! the paper describes it: the method that the paper compares itself with.
//!
//! It replaces section 3.4 as a whole, so there is no sweep over planar thresholds.
//! Simplification [3.2], resolution selection [3.5] and group merging [3.6] stay the same: each
//! resolution has one candidate, and of those the one with the least average cost, equation (3),
//! is the result.
//!
//! Where the paper is silent:
//! - **β** isn't given; the benchmark sweeps it.
//! - **α** = β / (10 D_S) is one over a length, added to a share of a length. Here it is
//!   β ℓ / (10 D_S) with ℓ the average diagonal of the simplified mesh's triangles: α starts at
//!   about β / 10, as in the first publication of HACD, and falls while surfaces grow, as the paper
//!   says. The mesh's diagonal can't be meant: with it hardly any two triangles of a fine mesh could
//!   be joined, since a pair that is a twentieth of the mesh wide has α E_shape > 2 β, whatever β.
//! - The node with more triangles remains; of equal costs the pair with the lower numbers goes
//!   first.

mod average_cost;
mod collapse;
mod parameters;
mod selection;
mod surface;

use std::time::Instant;

use hullwright::internals::{
    LEAST_CUT_OFF_RESOLUTION, Level, Levels, MeshOrder, Pieces, merge_groups, prepare,
    with_parallelism,
};
use hullwright::{Control, Error, Hull, MeshView, Stage};

use collapse::{Threshold, collapse};
use selection::{Candidate, select};

pub use average_cost::average_cost;
pub use parameters::HacdParameters;

/// Convex hulls, and the row that they would have in the paper's Table 1.
#[derive(Debug, Clone, PartialEq)]
pub struct HacdDecomposition {
    /// The convex pieces.
    pub hulls: Vec<Hull>,
    /// The group of each triangle of the simplified mesh.
    pub groups: Vec<u32>,
    /// k: average number of pieces over the candidates of all resolutions.
    pub average_pieces: f64,
    /// Average concavity cost of the chosen candidate, equation (3).
    pub cost: f64,
    /// r of the chosen candidate.
    pub resolution: usize,
    /// Triangles before simplification.
    pub initial_polygons: usize,
    /// Wall-clock time by stage; the only part of a result that differs between runs.
    pub times: Vec<(Stage, f64)>,
}

/// Decomposes a triangle mesh.
///
/// # Errors
/// As [`hullwright::decompose`]; [`Error::DeadlineExceeded`] as soon as the deadline has passed.
pub fn decompose<'a>(
    mesh: impl Into<MeshView<'a>>,
    parameters: &HacdParameters,
    control: &Control,
) -> Result<HacdDecomposition, Error> {
    parameters.validate()?;
    let surface = &parameters.surface;
    let mut times = Vec::new();
    let mut start = Instant::now();
    let mut lap = |stage| {
        times.push((stage, start.elapsed().as_secs_f64()));
        start = Instant::now();
    };

    let prepared = prepare(mesh.into(), MeshOrder::Input, control)?;
    lap(Stage::Repair);
    let mut levels = Levels::new(surface);
    while !levels.is_complete() {
        levels.make_next(&prepared, surface, control)?;
    }
    let levels = levels.finish();
    lap(Stage::Simplify);
    let found = candidates(&levels, parameters, control)?;
    let (index, candidate, average_pieces) =
        select(&found, surface.resolution_cut_off).ok_or(Error::DeadlineExceeded)?;
    lap(Stage::Search);

    let level = &levels[index];
    let significant = surface.significant_diagonal;
    let grouping = merge_groups(&level.mesh, &level.adjacency, &candidate.grouping, significant);
    lap(Stage::Merge);
    let pieces = Pieces { mesh: &level.mesh, components: &level.components, grouping: &grouping };
    let mut hulls = pieces.hulls(&prepared.normalization, surface.max_vertices, control)?;
    lap(Stage::Hulls);
    with_parallelism(control.is_parallel(), || {
        pieces.assign_source_triangles(&prepared, &mut hulls, control)
    })?;
    lap(Stage::Assign);

    Ok(HacdDecomposition {
        hulls,
        groups: grouping.labels,
        average_pieces,
        cost: candidate.cost,
        resolution: level.resolution,
        initial_polygons: prepared.mesh.triangles.len(),
        times,
    })
}

/// The candidate of each resolution, as far as μ lets them be reached; `None` for a mesh that is
/// the same as that of the resolution before.
fn candidates(
    levels: &[Level],
    parameters: &HacdParameters,
    control: &Control,
) -> Result<Vec<Option<Candidate>>, Error> {
    let candidate_of = |level: &Level| -> Result<Option<Candidate>, Error> {
        // Nothing was searched here, so only a repeated mesh is finished.
        if level.is_finished() {
            return Ok(None);
        }
        let length = selection::mean_triangle_diagonal(&level.mesh);
        let threshold = Threshold { concavity: parameters.concavity_threshold, length };
        let grouping = collapse(&level.mesh, &level.adjacency, threshold, control)?;
        Ok(Some(Candidate::new(level, grouping)))
    };
    // As long as μ may cut off all higher resolutions, one after the other.
    let mut found = Vec::with_capacity(levels.len());
    for (index, level) in levels.iter().enumerate() {
        let candidate = candidate_of(level)?;
        let cuts_off =
            candidate.as_ref().is_some_and(|c| c.cuts_off(parameters.surface.resolution_cut_off));
        let did_not_cut_off = !cuts_off && level.resolution >= LEAST_CUT_OFF_RESOLUTION;
        found.push(candidate);
        if cuts_off {
            break;
        }
        if did_not_cut_off && control.is_parallel() && rayon::current_num_threads() > 1 {
            use rayon::prelude::*;
            let rest: Result<Vec<_>, Error> =
                levels[index + 1..].par_iter().map(&candidate_of).collect();
            found.extend(rest?);
            break;
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
