//! The result: hulls, the groups that they come from, and the report.

use crate::geometry::MeshView;
use crate::hull::ConvexHull;
use crate::mesh::Repairs;
use crate::openings::Opening;

/// Changes whenever the same input and parameters may give another result.
pub const ALGORITHM_VERSION: u32 = 34;

/// One convex piece: its shape, where it comes from, and how far it is from the mesh.
///
/// A hull of any tool becomes one with `Hull::from`; it has no provenance, and no errors are known.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    /// How far hull simplification, or the limit on vertices, made the hull grow: no point of it is
    /// farther than this from the hull before.
    pub simplification_growth: f64,
    /// Protrusion: no point of the hull's surface is farther than this outside the solid. `None`
    /// for methods that verify nothing.
    ///
    /// An upper bound, verified against the source. It exceeds the true protrusion by at most 4 %
    /// of the requested bound, or by 4 % of itself where it is above that bound, with two
    /// exceptions: smaller protrusions are not resolved, so that it is at least 0.29 of the bound
    /// for a closed mesh and 0.79 for an open one; and where resolving it would take too long, it
    /// may be as large as the bound.
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
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GroupedMesh {
    /// Vertices.
    pub positions: Vec<[f64; 3]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the index of its hull in [`Decomposition::hulls`].
    pub groups: Vec<u32>,
}

/// Convex hulls and how they came about. `R` is what the method reports: [`Report`] from
/// [`decompose`](crate::decompose()), [`SurfaceReport`](crate::surface::SurfaceReport) from
/// [`surface::decompose`](crate::surface::decompose()).
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
/// assert!(result.report.protrusion_max <= result.report.bound);
/// assert_eq!(result.run.triangles, 4);
/// # Ok::<(), hullwright::Error>(())
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Decomposition<R = Report> {
    /// The convex pieces.
    pub hulls: Vec<Hull>,
    /// The mesh that was grouped, with a label per triangle.
    pub grouped: GroupedMesh,
    /// The input, its repair, and the time taken, whatever the method.
    pub run: RunReport,
    /// What the method promised, searched and verified.
    pub report: R,
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

/// The input of a decomposition, its repair, and the time taken, whatever the method.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RunReport {
    /// [`ALGORITHM_VERSION`](crate::ALGORITHM_VERSION) of the library that did it.
    pub algorithm_version: u32,
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
    /// Whether the deadline cut the work short.
    pub deadline_reached: bool,
    /// Wall-clock time by stage; the only part of a result that differs between runs.
    pub times: Vec<StageTime>,
}

/// What [`decompose`](crate::decompose()) promises, and what it verified against the source.
/// Lengths are in the input's units.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Report {
    /// The requested bound, in units, kept between 0.001 % and 50 % of the diagonal.
    pub bound: f64,
    /// Protrusion: no point of a hull's surface is farther than this outside the solid. With a
    /// probe, that or how far balls are entered there, whichever is less. An upper bound: see
    /// [`HullErrors::protrusion_max`]. Above `bound` only where a limit on hulls forces it, or
    /// where a flat sheet has to be thicker to be a hull.
    pub protrusion_max: f64,
    /// Uncovered distance: no point of the input's surface is farther than this outside every hull.
    /// What is thinner than 1e-6 of the diagonal in two directions is a line, and no surface:
    /// [`Repairs::degenerate_triangles`] counts it.
    pub uncovered_max: f64,
    /// As many hulls would keep the bound without the limit on vertices: fewer than there are where
    /// that limit divides some that keep it. An upper bound.
    pub hulls_without_vertex_limit: usize,
    /// Patches of the surface that the search started from.
    pub patches: usize,
    /// Whether patches are larger, since there would be too many: across the folds of a surface
    /// that folds everywhere, as that of a tangle, or of several components near each other where
    /// there are more than 1,200. There may be a few more hulls.
    pub patches_across_folds: bool,
    /// Triangles of the simplified, refined or cut mesh that was grouped.
    pub polygons: usize,
    /// What a probe found, if there was one.
    pub probe: Option<ProbeReport>,
}

/// What a probe found: see [`Parameters::probe_radius`](crate::Parameters::probe_radius).
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ProbeReport {
    /// Its radius, in units.
    pub radius: f64,
    /// Side of the cells that were flooded, in units. Where it is above half the radius, memory was
    /// short of what the mesh needs, and less is known to be out of reach.
    pub cell: f64,
    /// Volume in the bounding box that is outside the solid and that no ball can reach, in cubed
    /// units. An estimate by 1,000 points.
    pub unreachable_volume: f64,
}
