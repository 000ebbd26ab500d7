//! Resolution selection [3.5]: of the candidates of all resolutions, the one with the least cost
//! that does not have far more pieces than the average.
//!
//! Where the paper is silent or says two things:
//! - The cut-off μ acts after a resolution "greater than 500" in the text, but after r = 500 in
//!   its experiments (model 72). Here it acts from 500 on.
//! - Pieces, of which k is the average, are counted as in threshold selection.
//! - R is tried in ascending order, whatever order it is given in, since the cut-off is about
//!   higher resolutions; equal values count once.
//! - Of equal costs the lower resolution is taken; costs that differ by no more than rounding are
//!   equal.
//! - The steps of simplification go on from the next finer level, since the steps from the source
//!   would be the same. A resolution whose mesh is the same as that of the one before would only
//!   repeat it.

use crate::control::Control;
use crate::error::Error;
use crate::mesh::adjacency::Adjacency;
use crate::mesh::simplify::{next_target, simplify};
use crate::mesh::{PreparedMesh, TriangleMesh};

use super::hacd;
use super::parameters::SurfaceParameters;
use super::threshold_selection::{Candidate, ThresholdReport, ThresholdSearch, Thresholds};

/// From this maximum resolution on the cut-off μ may act.
pub const LEAST_CUT_OFF_RESOLUTION: usize = 500;

/// Costs that differ by less, as fractions of a group's diagonal, are equal: that is rounding. The
/// costs of convex groups are nothing else.
const EQUAL_COSTS: f64 = 1e-9;

/// Candidates with more than this many times k pieces are eliminated.
pub const MOST_PIECES_FACTOR: f64 = 1.5;

/// One subtree of the search: a maximum resolution.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ResolutionReport {
    /// r.
    pub resolution: usize,
    /// Target triangle count of the last step.
    pub target: usize,
    /// Triangle count that simplification reached.
    pub polygons: usize,
    /// What became of it.
    pub outcome: ResolutionOutcome,
    /// Its planar thresholds, in the order of the parameters.
    pub thresholds: Vec<ThresholdReport>,
}

/// What became of a resolution (section 3.5).
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ResolutionOutcome {
    /// Least cost of all that were left.
    Selected,
    /// Another has a lower cost.
    CostlierThanSelected,
    /// More than 1.5 k pieces.
    TooManyPieces,
    /// An earlier resolution had fewer than μ pieces.
    CutOff,
    /// The same simplified mesh as the resolution before, so the same result.
    SameAsBefore,
    /// The deadline came first.
    DeadlineReached,
}

/// A subtree of the search: a simplified mesh, and the search over its thresholds.
pub struct Level {
    /// The maximum resolution r.
    pub resolution: usize,
    /// The triangle count that simplification aimed at.
    pub target: usize,
    /// The simplified mesh.
    pub mesh: TriangleMesh,
    /// For each triangle its component.
    pub components: Vec<u32>,
    /// Of the simplified mesh.
    pub adjacency: Adjacency,
    pub(crate) search: ThresholdSearch,
    same_as_before: bool,
}

/// The simplified meshes for all of R, ascending, each made from the next finer one.
pub struct Levels {
    /// R, ascending, without repetitions; those whose mesh is made are gone.
    open: Vec<usize>,
    /// Descending.
    made: Vec<Level>,
    /// On the way from the last of those to the next.
    step: Option<Step>,
}

/// A mesh after a step of simplification.
struct Step {
    mesh: TriangleMesh,
    components: Vec<u32>,
    target: usize,
}

impl Levels {
    /// No mesh is made yet.
    pub fn new(parameters: &SurfaceParameters) -> Self {
        let mut open = parameters.maximum_resolutions.clone();
        open.sort_unstable();
        open.dedup();
        Self { made: Vec::with_capacity(open.len()), open, step: None }
    }

    /// Which share of them is made.
    pub(crate) fn share_done(&self) -> f32 {
        self.made.len() as f32 / (self.made.len() + self.open.len()).max(1) as f32
    }

    /// Whether the meshes of all resolutions are made.
    pub fn is_complete(&self) -> bool {
        self.open.is_empty()
    }

    /// Takes a step of simplification towards the finest that is missing, if there is one.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn advance(
        &mut self,
        prepared: &PreparedMesh,
        parameters: &SurfaceParameters,
        control: &Control,
    ) -> Result<(), Error> {
        control.check()?;
        let Some(&resolution) = self.open.last() else { return Ok(()) };
        let Step { mut mesh, mut components, mut target } = self.step.take().unwrap_or_else(|| {
            let (mesh, components) = match self.made.last() {
                Some(level) => (&level.mesh, &level.components),
                None => (&prepared.mesh, &prepared.components),
            };
            let (mesh, components) = (mesh.clone(), components.clone());
            Step { target: mesh.triangles.len(), mesh, components }
        });
        let count = mesh.triangles.len();
        if count > resolution {
            target = next_target(count, parameters.simplification_quality);
            let found = simplify(&mesh, &components, target, control)?;
            let gone = count.saturating_sub(found.mesh.triangles.len());
            if gone > 0 {
                (mesh, components) = (found.mesh, found.components);
            }
            // Where not half of the way can be gone more steps go hardly farther. That leaves more
            // triangles than r.
            if gone > 0 && 2 * gone >= count - target {
                self.step = Some(Step { mesh, components, target });
                return Ok(());
            }
        }
        self.open.pop();
        if let Some(finer) = self.made.last_mut() {
            finer.same_as_before = finer.mesh == mesh;
        }
        let adjacency = Adjacency::new(&mesh);
        self.made.push(Level {
            resolution,
            target,
            mesh,
            components,
            adjacency,
            search: ThresholdSearch::default(),
            same_as_before: false,
        });
        Ok(())
    }

    /// Those that are made, ascending.
    pub fn finish(mut self) -> Vec<Level> {
        self.made.reverse();
        self.made
    }
}

impl Level {
    /// Whether there is nothing left to search.
    pub fn is_finished(&self) -> bool {
        self.same_as_before || self.search.is_finished()
    }

    pub(crate) fn advance(
        &mut self,
        thresholds: Thresholds<'_>,
        control: &Control,
    ) -> Result<(), Error> {
        let Some(threshold) = thresholds.parameters.concavity_threshold else {
            return self.search.advance(&self.mesh, &self.adjacency, thresholds, control);
        };
        let grouping = hacd::group(&self.mesh, &self.adjacency, threshold, control)?;
        self.search.take(&self.mesh, grouping, control)
    }
}

/// The first level after which higher resolutions are not worth trying, as far as levels are
/// searched. A level that repeats the one before has its candidate.
pub(crate) fn first_cut_off(levels: &[Level], cut_off: usize) -> Option<usize> {
    let mut pieces = None;
    levels.iter().position(|level| {
        if !level.same_as_before {
            let candidate = level.search.candidate().filter(|_| level.search.is_finished());
            pieces = candidate.map(|candidate| candidate.pieces);
        }
        level.resolution >= LEAST_CUT_OFF_RESOLUTION && pieces.is_some_and(|count| count < cut_off)
    })
}

/// What was chosen among the resolutions.
pub(crate) struct Selection {
    /// Its place in the list of levels.
    pub level: usize,
    pub candidate: Candidate,
    /// k.
    pub average_pieces: f64,
    pub reports: Vec<ResolutionReport>,
}

/// Chooses among the levels that have a candidate. `None` if there is none.
pub(crate) fn select(levels: &[Level], cut_off: usize) -> Option<Selection> {
    let mut outcomes = vec![ResolutionOutcome::DeadlineReached; levels.len()];
    let last = first_cut_off(levels, cut_off).unwrap_or(levels.len());
    for (index, (level, outcome)) in levels.iter().zip(&mut outcomes).enumerate() {
        *outcome = if index > last {
            ResolutionOutcome::CutOff
        } else if level.same_as_before {
            ResolutionOutcome::SameAsBefore
        } else if level.search.candidate().is_some() {
            ResolutionOutcome::CostlierThanSelected
        } else {
            ResolutionOutcome::DeadlineReached
        };
    }
    let candidates: Vec<(usize, &Candidate)> = levels
        .iter()
        .enumerate()
        .filter(|&(index, _)| outcomes[index] == ResolutionOutcome::CostlierThanSelected)
        .filter_map(|(index, level)| Some((index, level.search.candidate()?)))
        .collect();
    if candidates.is_empty() {
        return None;
    }
    let pieces: usize = candidates.iter().map(|(_, candidate)| candidate.pieces).sum();
    let average_pieces = pieces as f64 / candidates.len() as f64;
    let most = MOST_PIECES_FACTOR * average_pieces;
    let mut selected: Option<(usize, &Candidate)> = None;
    for (index, candidate) in candidates {
        if candidate.pieces as f64 > most {
            outcomes[index] = ResolutionOutcome::TooManyPieces;
        } else if selected.is_none_or(|(_, best)| candidate.cost < best.cost - EQUAL_COSTS) {
            selected = Some((index, candidate));
        }
    }
    let (level, candidate) = selected?;
    outcomes[level] = ResolutionOutcome::Selected;
    let reports = levels.iter().zip(outcomes).map(|(level, outcome)| ResolutionReport {
        resolution: level.resolution,
        target: level.target,
        polygons: level.mesh.triangles.len(),
        outcome,
        thresholds: match outcome {
            // In parallel they may have been tried all the same, and that depends on time.
            ResolutionOutcome::CutOff | ResolutionOutcome::SameAsBefore => Vec::new(),
            _ => level.search.reports.clone(),
        },
    });
    let reports = reports.collect();
    Some(Selection { level, candidate: candidate.clone(), average_pieces, reports })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::torus;

    /// Levels with a finished search each: resolution, pieces and cost of its candidate.
    fn searched(candidates: &[(usize, usize, f64)]) -> Vec<Level> {
        let mesh = torus(8, 6);
        let level = |&(resolution, count, cost): &(usize, usize, f64)| Level {
            resolution,
            target: resolution,
            mesh: mesh.clone(),
            components: Vec::new(),
            adjacency: Adjacency::new(&mesh),
            search: ThresholdSearch::found(count, cost),
            same_as_before: false,
        };
        candidates.iter().map(level).collect()
    }

    fn outcomes(levels: &[Level]) -> Vec<ResolutionOutcome> {
        select(levels, 5).unwrap().reports.iter().map(|report| report.outcome).collect()
    }

    use ResolutionOutcome::{CostlierThanSelected, CutOff, SameAsBefore, Selected, TooManyPieces};

    #[test]
    fn the_least_cost_wins_and_of_equals_the_lower_resolution() {
        let levels = searched(&[(250, 9, 0.03), (500, 9, 0.02), (1000, 9, 0.02 - 1e-16)]);
        assert_eq!(outcomes(&levels), [CostlierThanSelected, Selected, CostlierThanSelected]);
    }

    #[test]
    fn more_pieces_than_one_and_a_half_times_the_average_are_too_many() {
        // k = 12: 18 pieces are just not too many, 19 would be.
        let levels = searched(&[(250, 9, 0.03), (500, 9, 0.03), (1000, 18, 0.01)]);
        assert_eq!(outcomes(&levels)[2], Selected);
        let levels = searched(&[(250, 9, 0.03), (500, 9, 0.03), (1000, 20, 0.01)]);
        assert_eq!(outcomes(&levels), [Selected, CostlierThanSelected, TooManyPieces]);
    }

    #[test]
    fn fewer_pieces_than_the_cut_off_end_the_search_from_500_on() {
        let levels = searched(&[(250, 4, 0.03), (500, 4, 0.02), (1000, 4, 0.01)]);
        assert_eq!(outcomes(&levels), [CostlierThanSelected, Selected, CutOff]);
        assert_eq!(first_cut_off(&levels, 5), Some(1));
        assert_eq!(first_cut_off(&searched(&[(250, 4, 0.03), (500, 5, 0.02)]), 5), None);
    }

    #[test]
    fn a_level_that_repeats_the_one_before_cuts_off_as_that_would() {
        let mut levels = searched(&[(495, 4, 0.03), (500, 9, 0.02), (1000, 9, 0.01)]);
        levels[1].same_as_before = true;
        assert_eq!(outcomes(&levels), [Selected, SameAsBefore, CutOff]);
    }
}
