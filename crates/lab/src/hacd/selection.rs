//! Resolution selection [3.5] for one candidate per resolution: the same rules as in the paper's
//! own method.

use hullwright::internals::vector::diagonal;
use hullwright::internals::{
    Grouping, LEAST_CUT_OFF_RESOLUTION, Level, MOST_PIECES_FACTOR, TriangleMesh, corners,
};

use super::average_cost::average;

/// The grouping of one resolution.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    pub resolution: usize,
    pub grouping: Grouping,
    /// Average of equation (3).
    pub cost: f64,
}

impl Candidate {
    pub(super) fn new(level: &Level, grouping: Grouping) -> Self {
        let Level { mesh, resolution, .. } = level;
        let cost = average(mesh, &grouping.labels, grouping.count);
        Self { resolution: *resolution, grouping, cost }
    }

    /// Whether higher resolutions are not worth trying.
    pub(super) fn cuts_off(&self, cut_off: usize) -> bool {
        self.resolution >= LEAST_CUT_OFF_RESOLUTION && self.grouping.count < cut_off
    }
}

/// Chooses among candidates in ascending order of resolution: its place, itself, and k.
pub(super) fn select(
    candidates: &[Option<Candidate>],
    cut_off: usize,
) -> Option<(usize, &Candidate, f64)> {
    let last = candidates
        .iter()
        .position(|candidate| candidate.as_ref().is_some_and(|c| c.cuts_off(cut_off)))
        .map_or(candidates.len(), |place| place + 1);
    let reached: Vec<(usize, &Candidate)> = candidates
        .iter()
        .take(last)
        .enumerate()
        .filter_map(|(place, candidate)| Some((place, candidate.as_ref()?)))
        .collect();
    let pieces: usize = reached.iter().map(|(_, candidate)| candidate.grouping.count).sum();
    let average_pieces = pieces as f64 / reached.len().max(1) as f64;
    let most = MOST_PIECES_FACTOR * average_pieces;
    let (place, candidate) = reached
        .into_iter()
        .filter(|(_, candidate)| candidate.grouping.count as f64 <= most)
        .min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost))?;
    Some((place, candidate, average_pieces))
}

/// Average diagonal of the triangles' bounding boxes.
pub(super) fn mean_triangle_diagonal(mesh: &TriangleMesh) -> f64 {
    let count = mesh.triangles.len() as u32;
    let sum: f64 = (0..count).map(|t| diagonal(corners(mesh, t))).sum();
    sum / f64::from(count.max(1))
}
