//! The bounded method: the paper's groups, then merged, grown and dissolved into few hulls under
//! a bound on the error that is verified against the source.
//!
//! | file | stage |
//! |---|---|
//! | `solid` | the fit test: whether a hull stands out of the solid; `grid` answers most of it |
//! | `refine`, `seeds` | a simplified or refined mesh, the paper's groups (3.4.1), halved until each fits; who conflicts with whom |
//! | `merge` | pieces join best-first |
//! | `cover` | each piece grows over all seeds that it can take; pieces are dissolved into the rest; each seed stays with one |
//! | `finish` | thickness, few vertices; `certify` verifies the result |

mod certify;
mod cover;
mod finish;
mod grid;
mod merge;
mod parallel;
mod piece;
mod refine;
mod seed_set;
mod seeds;
mod solid;

use crate::mesh::PreparedMesh;
use crate::{BoundedParameters, BoundedReport, Control, Error, GroupedMesh, Hull, Parameters, Preset, Stage, Unit};
use finish::Finished;
use piece::{Piece, Workshop};
use seeds::{Seeds, Working};
use solid::Solid;

/// The search leaves this much of the bound unused: room for a cap on vertices, and for what the
/// search overlooks.
const SEARCH_SHARE: f64 = 0.95;

/// What the stages go by, in diagonals.
pub(crate) struct Tuning {
    /// The bound that is promised.
    pub bound: f64,
    /// What the search goes by, so that verification has room.
    pub search_bound: f64,
    /// Triangles of the mesh that is grouped.
    pub triangles: usize,
    /// Longest edge of that mesh.
    pub longest_edge: f64,
    /// Planar and angular threshold of the grouping.
    pub grouping_threshold: f64,
    /// Largest diagonal of a seed, as a share of the root of the mesh's area.
    pub seed_size: f64,
    /// Points of a seed that stand out of its hull less than this are left out.
    pub reduction: f64,
    /// Joint hulls that dissolving may try.
    pub dissolving_tries: usize,
    pub max_vertices: Option<usize>,
}

impl Tuning {
    fn new(parameters: &Parameters, diagonal: f64) -> Self {
        let BoundedParameters { max_error, preset, .. } = parameters.bounded;
        let bound = match max_error {
            Unit::Diagonals(share) => share,
            Unit::Absolute(length) => length / diagonal,
        };
        // Half a diagonal is more than any hull of the mesh can stand out.
        let bound = bound.min(0.5);
        let (seed_size, dissolving_tries, triangles) = match preset {
            Preset::Fast => (0.35, 0, 1000),
            Preset::Balanced => (0.15, 6000, 1600),
            Preset::Fine => (0.11, 60_000, 3000),
        };
        Self {
            bound,
            search_bound: SEARCH_SHARE * bound,
            triangles,
            longest_edge: (4.0 * bound).clamp(0.04, 0.16),
            grouping_threshold: 0.1 * bound,
            seed_size,
            reduction: 0.025 * bound,
            dissolving_tries,
            max_vertices: parameters.max_vertices,
        }
    }
}

/// The method at work, stage by stage.
pub(crate) struct Run {
    prepared: PreparedMesh,
    tuning: Tuning,
    state: State,
}

enum State {
    Start,
    Working(Box<(Solid, Working)>),
    Seeds(Box<(Solid, Seeds)>),
    Merged(Box<(Solid, Seeds, Vec<Piece>)>),
    Covered(Box<(Solid, Seeds, Vec<Piece>)>),
    Done,
}

/// Hulls in the input's units, and what was verified.
pub(crate) struct Outcome {
    pub prepared: PreparedMesh,
    pub hulls: Vec<Hull>,
    pub grouped: GroupedMesh,
    pub report: BoundedReport,
}

impl Run {
    pub(crate) fn new(prepared: PreparedMesh, parameters: &Parameters) -> Self {
        let tuning = Tuning::new(parameters, prepared.normalization.diagonal);
        Self { prepared, tuning, state: State::Start }
    }

    /// The stage that the next step belongs to, and the share of the work before it.
    pub(crate) fn stage(&self) -> (Stage, f32) {
        match self.state {
            State::Start => (Stage::Simplify, 0.1),
            State::Working(_) => (Stage::Seeds, 0.3),
            State::Seeds(_) => (Stage::Merge, 0.45),
            State::Merged(_) => (Stage::Dissolve, 0.6),
            State::Covered(_) | State::Done => (Stage::Hulls, 0.9),
        }
    }

    pub(crate) fn step(&mut self, parallel: bool, control: &Control) -> Result<Option<Outcome>, Error> {
        parallel::with(parallel, || self.next(control))
    }

    fn next(&mut self, control: &Control) -> Result<Option<Outcome>, Error> {
        let tuning = &self.tuning;
        self.state = match std::mem::replace(&mut self.state, State::Done) {
            State::Start => {
                let mesh = &self.prepared.mesh;
                let is_closed = self.prepared.closed.iter().all(|&closed| closed)
                    || is_balanced(&mesh.triangles);
                let (solid, working) = parallel::join(
                    || Solid::new(&mesh.positions, &mesh.triangles, is_closed, tuning.bound),
                    || seeds::working_mesh(&self.prepared, tuning, control),
                );
                State::Working(Box::new((solid, working?)))
            }
            State::Working(state) => {
                let (solid, working) = *state;
                let seeds = seeds::seeds(working, &solid, tuning, control)?;
                State::Seeds(Box::new((solid, seeds)))
            }
            State::Seeds(state) => {
                let (solid, seeds) = *state;
                let mut shop = Workshop::new(&solid, tuning.search_bound);
                let pieces = merge::merge(&seeds, &mut shop, control)?;
                drop(shop);
                State::Merged(Box::new((solid, seeds, pieces)))
            }
            State::Merged(state) => {
                let (solid, seeds, pieces) = *state;
                let pieces = cover::cover(&seeds, pieces, &solid, tuning, control)?;
                State::Covered(Box::new((solid, seeds, pieces)))
            }
            State::Covered(state) => {
                let (solid, seeds, pieces) = *state;
                let finished = finish::finish(&seeds, pieces, &solid, tuning, control)?;
                return Ok(Some(self.outcome(&seeds, finished)));
            }
            State::Done => return Err(Error::Finished),
        };
        Ok(None)
    }

    fn outcome(&mut self, seeds: &Seeds, finished: finish::Outcome) -> Outcome {
        let prepared = std::mem::take(&mut self.prepared);
        let normalization = prepared.normalization;
        let diagonal = normalization.diagonal;
        let mut groups = vec![0; seeds.count()];
        for (index, hull) in (0_u32..).zip(&finished.hulls) {
            for seed in hull.seeds.iter() {
                groups[seed as usize] = index;
            }
        }
        let phantom = finished.hulls.iter().map(|hull| hull.phantom).fold(0.0, f64::max);
        let report = BoundedReport {
            bound: self.tuning.bound * diagonal,
            phantom_max: phantom * diagonal,
            exposed_max: finished.exposed * diagonal,
            seeds: seeds.count(),
            polygons: seeds.grouped.triangles.len(),
        };
        let grouped = GroupedMesh {
            positions: seeds.grouped.positions.iter().map(|&p| normalization.restore(p)).collect(),
            triangles: seeds.grouped.triangles.clone(),
            groups: seeds.labels.iter().map(|&seed| groups[seed as usize]).collect(),
        };
        let hulls = finished
            .hulls
            .into_iter()
            .map(|finished| restored(&prepared, seeds, finished))
            .collect();
        Outcome { prepared, hulls, grouped, report }
    }
}

/// Whether triangles run along each edge as often one way as the other. Then the winding number
/// changes only across the surface, also where more than two triangles meet.
fn is_balanced(triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<(u32, u32, bool)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .map(|(a, b)| (a.min(b), a.max(b), a < b))
        .collect();
    edges.sort_unstable();
    edges
        .chunk_by(|first, second| (first.0, first.1) == (second.0, second.1))
        .all(|edge| 2 * edge.iter().filter(|half| half.2).count() == edge.len())
}

/// A hull in the input's units.
fn restored(prepared: &PreparedMesh, seeds: &Seeds, finished: Finished) -> Hull {
    let normalization = &prepared.normalization;
    let points: Vec<[f64; 3]> =
        finished.hull.points.iter().map(|&point| normalization.restore(point)).collect();
    let hull = crate::hull::ConvexHull { points, triangles: finished.hull.triangles };
    let mut source_triangles: Vec<u32> = finished
        .seeds
        .iter()
        .flat_map(|seed| &seeds.seeds[seed as usize].triangles)
        .map(|&triangle| prepared.source_triangles[seeds.parents[triangle as usize] as usize])
        .collect();
    source_triangles.sort_unstable();
    source_triangles.dedup();
    let zero = crate::Bounds { min: [0.0; 3], max: [0.0; 3] };
    Hull {
        volume: hull.volume(),
        bounds: hull.bounds().unwrap_or(zero),
        points: hull.points,
        triangles: hull.triangles,
        component: finished.component,
        source_triangles,
        added_thickness: finished.added_thickness * normalization.diagonal,
        cap_growth: finished.cap_growth * normalization.diagonal,
        phantom_max: Some(finished.phantom * normalization.diagonal),
    }
}
