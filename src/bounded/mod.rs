//! The bounded method: the paper's groups, then merged, grown and dissolved into few hulls under
//! a bound on the error that is verified against the source.
//!
//! | file | stage |
//! |---|---|
//! | `cluster` | of very many triangles fewer, for the search |
//! | `solid` | the fit test: whether a hull stands out of the solid; `grid` answers most of it, `verdicts` remembers, `cavities` finds what hulls may not swallow |
//! | `refine`, `seeds` | a simplified or refined mesh, the paper's groups (3.4.1), halved until they fit; who conflicts with whom |
//! | `merge` | pieces join best-first |
//! | `cover` | each piece grows over all seeds that it can take; pieces are dissolved into the rest, at last by nearly all of the bound; each seed stays with one |
//! | `finish` | thickness; `few_vertices` saves vertices, `certify` verifies the result, `rejoin` joins what it divided |
//! | `fewer`, `tree` | a cap on hulls; on demand: joins down to one hull |

mod cavities;
mod certify;
mod cluster;
mod cover;
mod few_vertices;
mod fewer;
mod finish;
mod grid;
mod merge;
mod piece;
mod refine;
mod rejoin;
mod seed_set;
mod seeds;
mod solid;
mod tree;
mod verdicts;

use std::ops::RangeInclusive;
use std::sync::Arc;

pub(crate) use fewer::Merging;

use crate::control::{Control, Stage};
use crate::decomposition::{BoundedReport, GroupedMesh, Hull, HullErrors, Provenance};
use crate::error::Error;
use crate::hull::ConvexHull;
use crate::mesh::PreparedMesh;
use crate::parallel;
use crate::parameters::{BoundedParameters, Length, Parameters, Preset};
use cluster::Clustered;
use cover::Covered;
use finish::Finished;
use piece::{Piece, Workshop};
use seeds::{Seeds, Working};
use solid::Solid;

/// The search goes by this share of the bound: the rest is room for what it overlooks, and is spent only
/// where that saves a hull.
const SEARCH_SHARE: f64 = 0.9;

/// The same where pieces are not dissolved, so that nothing will be spent.
const ONLY_SHARE: f64 = 0.92;

/// At last pieces may be dissolved by this share of the bound. With more, so many hulls stand out when they
/// are verified, and are divided, that nothing is gained.
const LAST_SHARE: f64 = 0.985;
const _: () = assert!(solid::LEAST_SEARCH_SHARE <= SEARCH_SHARE && LAST_SHARE <= 1.0);

/// What the stages go by, in diagonals.
pub(crate) struct Tuning {
    /// The bound that is promised.
    pub bound: f64,
    /// What the search goes by, so that verification has room.
    pub search_bound: f64,
    /// What the last of it goes by.
    pub last_bound: f64,
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
    /// Surface that lies less far outside of all hulls is not told apart.
    pub enough: f64,
    /// Joint hulls that dissolving may try, and looks at other pieces by their cost.
    pub dissolving_tries: usize,
    pub max_vertices: Option<usize>,
    pub max_hulls: Option<usize>,
    pub keep_cavities: bool,
}

/// How finely a preset divides the surface, and how long it searches.
struct Fineness {
    seed_size: f64,
    dissolving_tries: usize,
    triangles: usize,
}

const FAST: Fineness = Fineness { seed_size: 0.35, dissolving_tries: 0, triangles: 1000 };
const BALANCED: Fineness = Fineness { seed_size: 0.12, dissolving_tries: 20_000, triangles: 2400 };

/// No division suits every mesh: of these the one that ends with the fewest hulls counts.
const FINE: [Fineness; 3] = [
    BALANCED,
    Fineness { seed_size: 0.09, dissolving_tries: 60_000, triangles: 3000 },
    Fineness { seed_size: 0.15, dissolving_tries: 60_000, triangles: 1600 },
];

/// A finer bound than this, in diagonals, is below what single precision and hulls' least thickness
/// leave of a shape.
const LEAST_BOUND: f64 = 1e-5;

/// Half a diagonal is more than any hull of the mesh can stand out.
const MOST_BOUND: f64 = 0.5;

/// Longest edge of the mesh that is grouped, in bounds: longer ones would spoil the division.
const LONGEST_EDGE: f64 = 4.0;

/// The same in diagonals: under small bounds that many more triangles would only take time, and under large
/// ones shapes are not larger.
const LONGEST_EDGES: RangeInclusive<f64> = 0.04..=0.16;

/// Threshold of the grouping, in bounds: what is a group should fit a hull with room to spare.
const GROUPING_THRESHOLD: f64 = 0.1;

/// What seeds may leave out, and what of the surface is not told apart, in bounds: half of what a hull may
/// leave out in the end.
const SLACK: f64 = 0.5 * finish::LEFT_OUT;

impl Tuning {
    /// One for each division of the surface that the preset tries.
    fn all(parameters: &Parameters, diagonal: f64) -> Vec<Self> {
        let finenesses: &[Fineness] = match parameters.bounded.preset {
            Preset::Fast => &[FAST],
            Preset::Balanced => &[BALANCED],
            Preset::Fine => &FINE,
        };
        finenesses.iter().map(|fineness| Self::new(parameters, diagonal, fineness)).collect()
    }

    fn new(parameters: &Parameters, diagonal: f64, fineness: &Fineness) -> Self {
        let BoundedParameters { max_error, .. } = parameters.bounded;
        let &Fineness { seed_size, dissolving_tries, triangles } = fineness;
        let bound = match max_error {
            Length::Share(share) => share,
            Length::Units(length) => length / diagonal,
        };
        let bound = bound.clamp(LEAST_BOUND, MOST_BOUND);
        let share = if dissolving_tries > 0 { SEARCH_SHARE } else { ONLY_SHARE };
        Self {
            bound,
            search_bound: share * bound,
            last_bound: LAST_SHARE * bound,
            triangles,
            longest_edge: (LONGEST_EDGE * bound)
                .clamp(*LONGEST_EDGES.start(), *LONGEST_EDGES.end()),
            grouping_threshold: GROUPING_THRESHOLD * bound,
            seed_size,
            reduction: SLACK * bound,
            enough: SLACK * bound,
            dissolving_tries,
            max_vertices: parameters.max_vertices,
            max_hulls: parameters.bounded.max_hulls,
            keep_cavities: parameters.bounded.keep_cavities,
        }
    }
}

/// Coordinates are rounded to 2^-38 diagonals, so that a mesh in other units, which differs in its
/// last bits, does not break ties of symmetric shapes another way.
const SNAP: f64 = (1_u64 << 38) as f64;

/// The method at work, stage by stage.
pub(crate) struct Run {
    prepared: PreparedMesh,
    tunings: Vec<Tuning>,
    /// The tuning at work.
    place: usize,
    /// The fewest hulls so far.
    best: Option<Box<(Seeds, finish::Outcome)>>,
    state: State,
}

enum State {
    /// With the solid, if an earlier division has needed it.
    Start(Option<Box<Solid>>),
    Working(Box<(Solid, Working)>),
    Seeds(Box<(Solid, Seeds)>),
    Merged(Box<(Solid, Seeds, Vec<Piece>)>),
    Covered(Box<(Solid, Seeds, Covered)>),
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
    pub(crate) fn new(mut prepared: PreparedMesh, parameters: &Parameters) -> Self {
        for coordinate in prepared.mesh.positions.as_flattened_mut() {
            *coordinate = (*coordinate * SNAP).round() / SNAP;
        }
        let tunings = Tuning::all(parameters, prepared.normalization.diagonal);
        Self { prepared, tunings, place: 0, best: None, state: State::Start(None) }
    }

    /// The stage that the next step belongs to, and the share of the work before it.
    pub(crate) fn stage(&self) -> (Stage, f32) {
        let (stage, share) = match self.state {
            State::Start(_) => (Stage::Simplify, 0.1),
            State::Working(_) => (Stage::Patches, 0.3),
            State::Seeds(_) => (Stage::Merge, 0.45),
            State::Merged(_) => (Stage::SetCover, 0.6),
            State::Covered(_) | State::Done => (Stage::Hulls, 0.9),
        };
        (stage, (self.place as f32 + share) / self.tunings.len() as f32)
    }

    pub(crate) fn step(&mut self, control: &Control) -> Result<Option<Outcome>, Error> {
        parallel::with(control.is_parallel(), || self.next(control))
    }

    fn next(&mut self, control: &Control) -> Result<Option<Outcome>, Error> {
        let Some(tuning) = self.tunings.get(self.place) else { return Err(Error::Finished) };
        self.state = match std::mem::replace(&mut self.state, State::Done) {
            State::Start(known) => {
                let clustered = match &known {
                    Some(solid) => solid.clustered.clone(),
                    None => clustered(&self.prepared, tuning, control)?,
                };
                let (solid, working) = parallel::join(
                    || match known {
                        Some(solid) => Ok(*solid),
                        None => solid(&self.prepared, clustered.clone(), tuning, control),
                    },
                    || seeds::working_mesh(&self.prepared, clustered.as_deref(), tuning, control),
                );
                State::Working(Box::new((solid?, working?)))
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
                let covered = cover::cover(&seeds, pieces, &solid, tuning, control)?;
                State::Covered(Box::new((solid, seeds, covered)))
            }
            State::Covered(state) => {
                let (solid, seeds, covered) = *state;
                let finished = finish::finish_covered(&seeds, covered, &solid, tuning, control)?;
                let is_better =
                    self.best.as_ref().is_none_or(|best| finished.hulls.len() < best.1.hulls.len());
                if is_better {
                    self.best = Some(Box::new((seeds, finished)));
                }
                if self.place + 1 < self.tunings.len() && !control.is_past_deadline() {
                    self.place += 1;
                    self.state = State::Start(Some(Box::new(solid)));
                    return Ok(None);
                }
                let Some(best) = self.best.take() else { return Err(Error::Finished) };
                let (seeds, mut finished) = *best;
                if let Some(most) = tuning.max_hulls
                    && finished.hulls.len() > most
                {
                    finished.hulls =
                        fewer::fewer(&finished.hulls, most, &seeds, &solid, tuning, control)?;
                }
                let bound = tuning.bound;
                return Ok(Some(self.outcome(&seeds, finished, bound)));
            }
            State::Done => return Err(Error::Finished),
        };
        Ok(None)
    }

    fn outcome(&mut self, seeds: &Seeds, finished: finish::Outcome, bound: f64) -> Outcome {
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
            bound: bound * diagonal,
            protrusion_max: phantom * diagonal,
            uncovered_max: finished.exposed * diagonal,
            patches: seeds.count(),
            polygons: seeds.grouped.triangles.len(),
        };
        let grouped = GroupedMesh {
            positions: seeds.grouped.positions.iter().map(|&p| normalization.restore(p)).collect(),
            triangles: seeds.grouped.triangles.clone(),
            groups: seeds.labels.iter().map(|&seed| groups[seed as usize]).collect(),
        };
        let hulls = parallel::map(&finished.hulls, |finished| restored(&prepared, seeds, finished));
        Outcome { prepared, hulls, grouped, report }
    }
}

/// A mesh of fewer triangles, where there are very many.
fn clustered(
    prepared: &PreparedMesh,
    tuning: &Tuning,
    control: &Control,
) -> Result<Option<Arc<Clustered>>, Error> {
    // A narrow cavity may close.
    if tuning.keep_cavities {
        return Ok(None);
    }
    let clustered = Clustered::new(prepared, tuning.bound, tuning.longest_edge, control)?;
    Ok(clustered.map(Arc::new))
}

fn solid(
    prepared: &PreparedMesh,
    clustered: Option<Arc<Clustered>>,
    tuning: &Tuning,
    control: &Control,
) -> Result<Solid, Error> {
    if let Some(clustered) = clustered {
        return Solid::of_clustered(clustered, tuning.bound, control);
    }
    let mesh = &prepared.mesh;
    let triangles = prepared.triangles_of_solid();
    // Sheets that are there both ways can close what was open.
    let is_closed = prepared.closed.iter().all(|&closed| closed)
        || is_balanced(&mesh.triangles)
        || triangles.len() > mesh.triangles.len() && is_balanced(&triangles);
    let mut solid = Solid::new(&mesh.positions, &triangles, is_closed, tuning.bound, control)?;
    if tuning.keep_cavities {
        solid.keep_cavities(tuning.bound);
    }
    Ok(solid)
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
fn restored(prepared: &PreparedMesh, seeds: &Seeds, finished: &Finished) -> Hull {
    let normalization = &prepared.normalization;
    let points: Vec<[f64; 3]> =
        finished.hull.points.iter().map(|&point| normalization.restore(point)).collect();
    let mut source_triangles: Vec<u32> = finished
        .triangles(seeds)
        .map(|triangle| prepared.source_triangles[seeds.parents[triangle as usize] as usize])
        .collect();
    source_triangles.sort_unstable();
    source_triangles.dedup();
    Hull {
        shape: ConvexHull { points, triangles: finished.hull.triangles.clone() },
        provenance: Provenance { component: finished.component, source_triangles },
        errors: HullErrors {
            added_thickness: finished.added_thickness * normalization.diagonal,
            simplification_growth: finished.cap_growth * normalization.diagonal,
            protrusion_max: Some(finished.phantom * normalization.diagonal),
        },
    }
}
