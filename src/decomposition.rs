//! The result: hulls, the groups that they come from, and the report.

use crate::geometry::MeshView;
use crate::hull::ConvexHull;
use crate::mesh::Repairs;
use crate::openings::Opening;
use crate::parameters::Method;

/// Changes whenever the same input and parameters may give another result.
pub const ALGORITHM_VERSION: u32 = 20;

/// One convex piece: its shape, where it comes from, and how far it is from the mesh.
///
/// A hull of any tool becomes one with `Hull::from`; it has no provenance, and no errors are known.
///
/// ```
/// use hullwright::{Hull, convex_hull};
///
/// # fn main() -> Result<(), hullwright::Error> {
/// let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let hull = Hull::from(convex_hull(&points)?);
/// assert_eq!(hull.shape.points.len(), 4);
/// assert_eq!(hull.errors.protrusion_max, None);
/// # Ok(())
/// # }
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hull {
    /// Vertices and triangles, in the input's units.
    pub shape: ConvexHull,
    /// What of the mesh it stands for.
    pub provenance: Provenance,
    /// How far it is from what it stands for.
    pub errors: HullErrors,
}

/// What of the source mesh a hull stands for.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// The connected component of the input that the hull belongs to.
    pub component: u32,
    /// The input's triangles that the hull stands for, ascending; empty where that is not known.
    pub source_triangles: Vec<u32>,
}

/// How far a hull is from what it stands for. Lengths are in the input's units.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HullErrors {
    /// Thickness that was given to a flat, linear or point-like group so that the hull has
    /// volume; 0 for all others.
    pub added_thickness: f64,
    /// How far hull simplification, or the cap on vertices, made the hull grow: no point of it is
    /// farther than this from the hull before.
    pub simplification_growth: f64,
    /// Protrusion: no point of the hull's surface is farther than this outside the solid. It is
    /// verified against the source. An upper bound: of closed meshes never below 0.29 of the bound that
    /// was asked for and too large by at most 4 % of it, of open and of very dense ones never below 0.79;
    /// where a closer look would take long it may be as large as the bound. `None` for methods that verify nothing.
    pub protrusion_max: Option<f64>,
}

impl From<ConvexHull> for Hull {
    fn from(shape: ConvexHull) -> Self {
        Self { shape, ..Self::default() }
    }
}

impl<'a> From<&'a Hull> for MeshView<'a> {
    fn from(hull: &'a Hull) -> Self {
        (&hull.shape).into()
    }
}

/// The simplified, refined or cut mesh that was grouped, in the input's units.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GroupedMesh {
    /// Vertices.
    pub positions: Vec<[f64; 3]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the index of its hull in [`Decomposition::hulls`].
    pub groups: Vec<u32>,
}

/// Convex hulls and how they came about.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// use hullwright::{Control, Parameters, decompose};
///
/// let result = decompose(&mesh, &Parameters::default(), &Control::new())?;
/// assert_eq!(result.hulls[0].provenance.source_triangles, [0, 1, 2, 3]);
/// assert_eq!(result.grouped.groups.len(), result.grouped.triangles.len());
/// assert_eq!(result.report.triangles, 4);
/// # Ok::<(), hullwright::Error>(())
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct Decomposition {
    /// The convex pieces.
    pub hulls: Vec<Hull>,
    /// The mesh that was grouped, with a label per triangle.
    pub grouped: GroupedMesh,
    /// What was done, and how well it went.
    pub report: Report,
}

/// Wall-clock time of a stage.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StageTime {
    /// The stage.
    pub stage: crate::control::Stage,
    /// Seconds that it took.
    pub seconds: f64,
}

/// What was done, and how well it went.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Report {
    /// [`ALGORITHM_VERSION`](crate::ALGORITHM_VERSION) of the library that did it.
    pub algorithm_version: u32,
    /// The method.
    pub method: Method,
    /// Vertices given.
    pub source_vertices: usize,
    /// Triangles given.
    pub source_triangles: usize,
    /// Triangles left after repair, with those that close openings.
    pub triangles: usize,
    /// Diagonal of the bounding box of the vertices that triangles use, in units. Relative
    /// lengths are divided by it.
    pub diagonal: f64,
    /// Connected components.
    pub components: usize,
    /// Components without open or non-manifold edges.
    pub closed_components: usize,
    /// What was repaired.
    pub repairs: Repairs,
    /// The openings of the mesh, closed and left; empty where the method keeps them all.
    pub openings: Vec<Opening>,
    /// Closed components within the solid, which nothing can reach and which were left out.
    pub nested_components: usize,
    /// What the bounded method promised and verified.
    pub bounded: Option<BoundedReport>,
    /// The search of the paper's method.
    pub surface: Option<SurfaceReport>,
    /// Whether the deadline cut the work short.
    pub deadline_reached: bool,
    /// Wall-clock time by stage; the only part of a result that differs between runs.
    pub times: Vec<StageTime>,
}

/// What the bounded method promised, and what it verified against the source. Lengths are in the
/// input's units.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoundedReport {
    /// The bound that was asked for, in units, kept between 0.001 % and 50 % of the diagonal.
    pub bound: f64,
    /// Protrusion: no point of a hull's surface is farther than this outside the solid. An upper
    /// bound: see [`HullErrors::protrusion_max`]. Above `bound` only where a cap on hulls
    /// forces it, or where a flat sheet has to be thicker to be a hull.
    pub protrusion_max: f64,
    /// Uncovered distance: no point of the input's surface is farther than this outside every hull. What is
    /// thinner than 1e-6 of the diagonal in two directions is a line, and no surface:
    /// [`Repairs::degenerate_triangles`] counts it.
    pub uncovered_max: f64,
    /// Patches of the surface that the search started from.
    pub patches: usize,
    /// Triangles of the simplified or refined mesh that was grouped.
    pub polygons: usize,
}

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
