//! What the paper's method reports: its search tree, and what it chose.

/// The paper's search tree and what it chose: a row of its Table 1.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceReport {
    /// Pieces, after group merging.
    pub pieces: usize,
    /// Pieces of the chosen candidate before group merging.
    pub pieces_before_merging: usize,
    /// k: average number of pieces over the candidates of all resolutions.
    pub average_pieces: f64,
    /// Average concavity cost of the chosen candidate, equation (3).
    pub cost: f64,
    /// p of the chosen candidate, in units of the thresholds.
    pub planar_threshold: f64,
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

/// One subtree of the search: a maximum resolution.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ResolutionReport {
    /// r.
    pub resolution: usize,
    /// Target triangle count: the initial one times powers of Q.
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

/// One leaf of the search: a planar threshold.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ThresholdReport {
    /// p.
    pub planar_threshold: f64,
    /// Number of groups.
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
