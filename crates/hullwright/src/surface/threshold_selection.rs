//! Threshold selection [3.4.2]: of the groupings for all planar thresholds of one resolution, the
//! one with the fewest pieces whose average concavity cost is below ε.
//!
//! Where the paper is silent:
//! - If all groups have one or two polygons the average is 0/0. It counts as 0: two polygons
//!   that share a side are convex or nearly so.
//! - A single group ends the search of the resolution. It may still be the candidate if its cost
//!   is below ε: a convex mesh needs it.
//! - The two abort rules: a running average is given up once it is above *both* limits, three
//!   times ε and three times the least average so far. Read as "above either", the second rule
//!   forbids what Table 1 reports: p = 0.01 leaves nearly convex groups, so that larger p would
//!   have to stay below a third of what their rows cost
//!   (`crates/lab/reports/paper/paper-experiments.md`).
//!   The first threshold has nothing before it and is always computed to its end, so the
//!   fail-safe never lacks a candidate; aborted thresholds can't enter it.
//! - Groups of one or two polygons, which are left out of the average and expected to merge, are no
//!   pieces when pieces are counted: so Table 1 has them.
//! - Of equal counts the earlier threshold stays, as "fewer than" says.

use std::collections::HashMap;

use crate::control::Control;
use crate::error::Error;
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::Adjacency;
use crate::mesh::grouping::{Grouping, Grown, grow, members};

use super::cost::{CostScratch, TOO_SMALL_TO_COUNT, cost};
use super::parameters::SurfaceParameters;

/// A running average above this many times ε and times the least average so far is given up.
const ABORT_FACTOR: f64 = 3.0;

/// Below this average cost a threshold is taken at once.
const SUFFICIENTLY_CONVEX: f64 = 1e-6;

/// One leaf of the search: a planar threshold.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ThresholdReport {
    /// p; none for HACD, which has one leaf.
    pub planar_threshold: Option<f64>,
    /// Number of groups of more than two polygons.
    pub pieces: usize,
    /// Average cost, as far as it was computed.
    pub cost: f64,
    /// What became of it.
    pub outcome: ThresholdOutcome,
}

/// What became of a threshold (section 3.4.2).
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ThresholdOutcome {
    /// The resolution's candidate: fewest pieces under ε.
    Candidate,
    /// The resolution's candidate, taken at once for a cost below 1e-6.
    CandidateAtOnce,
    /// The resolution's candidate by the fail-safe: least cost, since none was under ε.
    CandidateByFailSafe,
    /// Under ε, but another has fewer pieces.
    MorePieces,
    /// Its cost is not under ε.
    TooCostly,
    /// Given up as its running average was above 3 ε; an earlier one had an average below ε.
    AbortedAboveThreshold,
    /// Given up as its running average was above three times the least so far, itself above ε.
    AbortedAboveLeast,
    /// A single group: the search of this resolution ends here.
    SingleGroup,
    /// Not tried, since an earlier threshold ended the search of this resolution.
    NotTried,
}

/// What all resolutions are searched by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Thresholds<'a> {
    pub parameters: &'a SurfaceParameters,
    /// The length that counts as 1 for p and a, in the mesh's space.
    pub unit: f64,
}

/// A resolution's best grouping so far.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidate {
    pub grouping: Grouping,
    /// Groups of more than two polygons.
    pub pieces: usize,
    pub cost: f64,
    /// `None` for HACD.
    pub planar_threshold: Option<f64>,
    /// Its place in the list of thresholds.
    index: usize,
}

/// The search over the thresholds of one resolution, one threshold per call of `advance`.
#[derive(Debug, Clone, Default)]
pub(crate) struct ThresholdSearch {
    next: usize,
    finished: bool,
    candidate: Option<Candidate>,
    /// Least average of the thresholds that were not aborted.
    cheapest: Option<Candidate>,
    scratch: CostScratch,
    /// The grouping tried last, and its planar threshold in the mesh's space.
    last: Option<(f64, Grown)>,
    /// The cost of each group so far, by its polygons: other thresholds often find it again.
    costs: HashMap<Vec<u32>, f64>,
    pub reports: Vec<ThresholdReport>,
}

/// How far the average cost of a grouping was computed.
enum Average {
    Complete(f64),
    AboveThreshold(f64),
    AboveLeast(f64),
}

/// The polygons of each group that counts as a piece.
fn counted_groups(grouping: &Grouping) -> Vec<Vec<u32>> {
    let mut groups = members(&grouping.labels, grouping.count);
    groups.retain(|group| group.len() > TOO_SMALL_TO_COUNT);
    groups
}

impl ThresholdSearch {
    pub(crate) fn is_finished(&self) -> bool {
        self.finished
    }

    /// Tries the next threshold.
    pub(crate) fn advance(
        &mut self,
        mesh: &TriangleMesh,
        adjacency: &Adjacency,
        Thresholds { parameters, unit }: Thresholds<'_>,
        control: &Control,
    ) -> Result<(), Error> {
        let index = self.next;
        let Some(&planar_threshold) = parameters.planar_thresholds.get(index) else {
            self.finish(parameters);
            return Ok(());
        };
        self.next += 1;
        let length = planar_threshold * unit;
        let (grown_at, grown) = match self.last.take() {
            Some((at, grown)) if at <= length && length < grown.same_below => (at, grown),
            _ => {
                let a = parameters.angular_threshold * unit;
                (length, grow(mesh, adjacency, length, a, control)?)
            }
        };
        let grouping = grown.grouping.clone();
        self.last = Some((grown_at, grown));
        let groups = counted_groups(&grouping);
        let pieces = groups.len();
        let planar_threshold = Some(planar_threshold);
        let epsilon = parameters.concavity_cost_threshold;
        let average = self.average_cost(mesh, groups, epsilon, control)?;
        let (Average::Complete(cost) | Average::AboveThreshold(cost) | Average::AboveLeast(cost)) =
            average;
        let is_single = grouping.count == 1;
        let tried = Candidate { grouping, pieces, cost, planar_threshold, index };
        let outcome = match average {
            Average::AboveThreshold(_) => ThresholdOutcome::AbortedAboveThreshold,
            Average::AboveLeast(_) => ThresholdOutcome::AbortedAboveLeast,
            Average::Complete(_) if cost < SUFFICIENTLY_CONVEX => ThresholdOutcome::CandidateAtOnce,
            Average::Complete(_) if cost >= epsilon => ThresholdOutcome::TooCostly,
            Average::Complete(_) => ThresholdOutcome::MorePieces,
        };
        self.reports.push(ThresholdReport { planar_threshold, pieces, cost, outcome });
        let is_aborted = matches!(average, Average::AboveThreshold(_) | Average::AboveLeast(_));
        if !is_aborted {
            let fewer = self.candidate.as_ref().is_none_or(|best| pieces < best.pieces);
            if outcome == ThresholdOutcome::CandidateAtOnce || (cost < epsilon && fewer) {
                self.candidate = Some(tried.clone());
            }
            if self.cheapest.as_ref().is_none_or(|best| cost < best.cost) {
                self.cheapest = Some(tried);
            }
        }
        if is_single {
            if outcome != ThresholdOutcome::CandidateAtOnce
                && let Some(report) = self.reports.last_mut()
            {
                report.outcome = ThresholdOutcome::SingleGroup;
            }
            self.finish(parameters);
        } else if outcome == ThresholdOutcome::CandidateAtOnce
            || self.next == parameters.planar_thresholds.len()
        {
            self.finish(parameters);
        }
        Ok(())
    }

    /// Ends with the only grouping that there is.
    pub(crate) fn take(
        &mut self,
        mesh: &TriangleMesh,
        grouping: Grouping,
        control: &Control,
    ) -> Result<(), Error> {
        let groups = counted_groups(&grouping);
        let (planar_threshold, pieces) = (None, groups.len());
        let average = self.average_cost(mesh, groups, f64::INFINITY, control)?;
        let (Average::Complete(cost) | Average::AboveThreshold(cost) | Average::AboveLeast(cost)) =
            average;
        let outcome = ThresholdOutcome::Candidate;
        self.reports.push(ThresholdReport { planar_threshold, pieces, cost, outcome });
        self.candidate = Some(Candidate { grouping, pieces, cost, planar_threshold, index: 0 });
        self.finished = true;
        Ok(())
    }

    /// The candidate, once finished; before, the best so far.
    pub(crate) fn candidate(&self) -> Option<&Candidate> {
        self.candidate.as_ref().or(self.cheapest.as_ref())
    }

    /// A search that has ended with this.
    #[cfg(test)]
    pub(super) fn found(pieces: usize, cost: f64) -> Self {
        let grouping = Grouping::default();
        let candidate =
            Some(Candidate { grouping, pieces, cost, planar_threshold: Some(0.2), index: 0 });
        Self { finished: true, candidate, ..Self::default() }
    }

    fn finish(&mut self, parameters: &SurfaceParameters) {
        self.finished = true;
        let by_fail_safe = self.candidate.is_none();
        let chosen = self.candidate().map(|candidate| candidate.index);
        if let Some(report) = chosen.and_then(|index| self.reports.get_mut(index)) {
            report.outcome = match report.outcome {
                ThresholdOutcome::CandidateAtOnce => ThresholdOutcome::CandidateAtOnce,
                _ if by_fail_safe => ThresholdOutcome::CandidateByFailSafe,
                _ => ThresholdOutcome::Candidate,
            };
        }
        for &planar_threshold in parameters.planar_thresholds.iter().skip(self.reports.len()) {
            let (planar_threshold, outcome) = (Some(planar_threshold), ThresholdOutcome::NotTried);
            self.reports.push(ThresholdReport { planar_threshold, pieces: 0, cost: 0.0, outcome });
        }
    }

    /// The average cost over groups, given up as soon as the running average is too high.
    fn average_cost(
        &mut self,
        mesh: &TriangleMesh,
        groups: Vec<Vec<u32>>,
        epsilon: f64,
        control: &Control,
    ) -> Result<Average, Error> {
        let least = self.cheapest.as_ref().map_or(f64::INFINITY, |cheapest| cheapest.cost);
        let (mut sum, mut average, mut counted) = (0.0, 0.0, 0);
        for group in groups {
            sum += match self.costs.get(&group) {
                Some(known) => *known,
                None => {
                    control.check()?;
                    let cost = cost(mesh, &group, &mut self.scratch);
                    *self.costs.entry(group).or_insert(cost)
                }
            };
            counted += 1;
            average = sum / f64::from(counted);
            if average > ABORT_FACTOR * epsilon.max(least) {
                return Ok(if least > epsilon {
                    Average::AboveLeast(average)
                } else {
                    Average::AboveThreshold(average)
                });
            }
        }
        Ok(Average::Complete(average))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, torus};

    fn search(mesh: &TriangleMesh, parameters: &SurfaceParameters) -> ThresholdSearch {
        let adjacency = Adjacency::new(mesh);
        let mut search = ThresholdSearch::default();
        while !search.is_finished() {
            let thresholds = Thresholds { parameters, unit: 0.4 };
            search.advance(mesh, &adjacency, thresholds, &Control::new()).unwrap();
        }
        search
    }

    #[test]
    fn a_cube_is_taken_at_once_as_a_single_group() {
        let found = search(&cuboid([0.0; 3], [1.0; 3]), &SurfaceParameters::paper());
        assert_eq!(found.candidate().unwrap().grouping.count, 1);
        assert_eq!(found.reports[0].outcome, ThresholdOutcome::CandidateAtOnce);
        assert!(found.reports[1..].iter().all(|r| r.outcome == ThresholdOutcome::NotTried));
        assert_eq!(found.reports.len(), 6);
    }

    #[test]
    fn the_fewest_pieces_under_epsilon_win() {
        let found = search(&torus(24, 12), &SurfaceParameters::paper());
        let candidate = found.candidate().unwrap();
        let under = found.reports.iter().filter(|report| {
            matches!(report.outcome, ThresholdOutcome::Candidate | ThresholdOutcome::MorePieces)
        });
        assert!(candidate.cost < 0.05);
        assert_eq!(candidate.pieces, under.map(|report| report.pieces).min().unwrap());
    }

    #[test]
    fn a_single_group_ends_the_search_whatever_it_costs() {
        let mut parameters = SurfaceParameters::paper();
        // The second refuses nothing; a torus is far from convex.
        parameters.planar_thresholds = vec![0.05, 50.0, 60.0];
        parameters.angular_threshold = 50.0;
        let found = search(&torus(24, 12), &parameters);
        assert_eq!(found.reports[1].outcome, ThresholdOutcome::SingleGroup);
        assert_eq!(found.reports[2].outcome, ThresholdOutcome::NotTried);
    }

    #[test]
    fn if_nothing_is_under_epsilon_the_cheapest_wins() {
        let mut parameters = SurfaceParameters::paper();
        parameters.concavity_cost_threshold = 1e-5;
        // The cheapest is not the first that is tried, and not the last: that is given up.
        parameters.planar_thresholds = vec![1.0, 0.1, 0.05];
        let found = search(&torus(24, 12), &parameters);
        let costs: Vec<f64> = found.reports.iter().map(|report| report.cost).collect();
        assert!(costs[1] < costs[0] && costs[1] < costs[2], "{costs:?}");
        let outcomes: Vec<ThresholdOutcome> =
            found.reports.iter().map(|report| report.outcome).collect();
        let expected = [
            ThresholdOutcome::TooCostly,
            ThresholdOutcome::CandidateByFailSafe,
            ThresholdOutcome::AbortedAboveLeast,
        ];
        assert_eq!(outcomes, expected);
        let candidate = found.candidate().unwrap();
        assert_eq!((candidate.planar_threshold, candidate.cost), (Some(0.1), costs[1]));
    }

    /// The outcomes on a torus; the first two p cost 0.004 and 0.005, the running average of the
    /// last reaches 0.17.
    fn outcomes(epsilon: f64) -> Vec<ThresholdOutcome> {
        let mut parameters = SurfaceParameters::paper();
        parameters.concavity_cost_threshold = epsilon;
        parameters.planar_thresholds = vec![0.05, 0.1, 1.0];
        search(&torus(24, 12), &parameters).reports.iter().map(|report| report.outcome).collect()
    }

    #[test]
    fn a_running_average_above_three_epsilon_is_given_up() {
        assert_eq!(outcomes(0.05)[2], ThresholdOutcome::AbortedAboveThreshold);
        assert_eq!(outcomes(0.1)[2], ThresholdOutcome::Candidate);
    }

    #[test]
    fn where_nothing_is_under_epsilon_the_limit_is_three_times_the_least() {
        assert_eq!(outcomes(1e-5)[2], ThresholdOutcome::AbortedAboveLeast);
    }

    #[test]
    fn the_first_threshold_is_never_given_up() {
        assert_eq!(outcomes(1e-5)[0], ThresholdOutcome::CandidateByFailSafe);
    }
}
