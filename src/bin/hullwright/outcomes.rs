//! What became of each part of the surface method's search: names for programs, words for people.

use hullwright::surface::{ResolutionOutcome, ThresholdOutcome};

/// A name for programs and words for people.
pub struct OutcomeText {
    pub name: &'static str,
    pub words: &'static str,
}

const fn outcome(name: &'static str, words: &'static str) -> OutcomeText {
    OutcomeText { name, words }
}

pub fn of_resolution(of: ResolutionOutcome) -> OutcomeText {
    match of {
        ResolutionOutcome::Selected => outcome("selected", "selected: least cost of those left"),
        ResolutionOutcome::CostlierThanSelected => {
            outcome("costlier_than_selected", "dropped: another costs less")
        }
        ResolutionOutcome::TooManyPieces => {
            outcome("too_many_pieces", "dropped: more than 1.5 times the average pieces")
        }
        ResolutionOutcome::CutOff => {
            outcome("cut_off", "skipped: an earlier one has fewer pieces than the cut-off")
        }
        ResolutionOutcome::SameAsBefore => {
            outcome("same_as_before", "skipped: the same mesh as the one before")
        }
        ResolutionOutcome::DeadlineReached => outcome("deadline_reached", "skipped: deadline"),
        _ => outcome("other", "other"),
    }
}

pub fn of_threshold(of: ThresholdOutcome) -> OutcomeText {
    match of {
        ThresholdOutcome::Candidate => outcome("candidate", "candidate: fewest pieces under ε"),
        ThresholdOutcome::CandidateAtOnce => {
            outcome("candidate_at_once", "candidate: next to no cost, taken at once")
        }
        ThresholdOutcome::CandidateByFailSafe => {
            outcome("candidate_by_fail_safe", "candidate: least cost, since none is under ε")
        }
        ThresholdOutcome::MorePieces => {
            outcome("more_pieces", "under ε, but another has fewer pieces")
        }
        ThresholdOutcome::TooCostly => outcome("too_costly", "not under ε"),
        ThresholdOutcome::AbortedAboveThreshold => {
            outcome("aborted_above_threshold", "given up: average above 3 ε")
        }
        ThresholdOutcome::AbortedAboveLeast => {
            outcome("aborted_above_least", "given up: average above 3 times the least")
        }
        ThresholdOutcome::SingleGroup => {
            outcome("single_group", "a single group: ends this search")
        }
        ThresholdOutcome::NotTried => outcome("not_tried", "not tried"),
        _ => outcome("other", "other"),
    }
}
