//! The mesh that the stages after it work on: repaired, its openings closed, without nested shells.
//!
//! ```text
//! repair → judge the openings → cap those that are closed → repair → judge again → drop nested shells
//! ```
//!
//! A nested shell is a closed component that nothing outside can reach. One all of whose surface
//! has solid on both sides, such as a board within a wall, adds nothing. One with solid all around
//! it and nothing within is a cavity, as the inner faces of a crate are: no body gets there, so it
//! is filled. Components that overlap others in part stay as they are.

use super::decide::{Closing, OpeningSettings, judge};
use super::narrow::close_narrow;
use super::opening::Opening;
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, bounds, six_volumes};
use crate::geometry::{MeshView, TriangleMesh};
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::{prepare, prepare_again};
use crate::mesh::{CAP, HIDDEN_CAP, PreparedMesh};
use crate::parameters::{Openings, Parameters};

/// Caps have the vertices of their loops, and ear clipping leaves out those in the middle of a
/// straight side: that is a crack, which the next pass zips. Openings that no ball passes take
/// passes of their own.
const PASSES: usize = 3;

/// Points on a component's triangles that are tried, at most.
const SAMPLES: usize = 24;

/// Distance of the samples from the surface, on both sides, as a fraction of the diagonal: more
/// than welding moves a surface, less than any wall that counts.
const STEP: f64 = 1e-4;

/// Passes that look for nested shells, at most. A shell that lies loose in a cavity is only
/// inside once the cavity is filled, and found by the pass after that.
const NESTED_PASSES: usize = 4;

/// A repaired mesh with its openings closed.
pub(crate) struct Closed {
    pub prepared: PreparedMesh,
    pub openings: Vec<Opening>,
    /// Closed components within the solid, which were dropped.
    pub nested_components: usize,
    /// Whether openings or cracks were closed.
    has_caps: bool,
}

impl Closed {
    /// Whether the surface is another than repair's.
    pub(crate) fn is_changed(&self) -> bool {
        self.nested_components > 0 || self.has_caps
    }

    /// Some of its triangles, in the input's units.
    fn restored(&self, triangles: Vec<[u32; 3]>) -> TriangleMesh {
        let restore = |&point| self.prepared.normalization.restore(point).into();
        TriangleMesh::new(self.prepared.mesh.points().iter().map(restore).collect(), triangles)
    }
}

/// Repairs a mesh, closes its openings, and drops what is within the solid. In `source_triangles`
/// caps stand as [`CAP`]. The counts of repairs are those of the mesh as it came.
///
/// Takes as long as repair where nothing is open; otherwise some hundred rays for each flat
/// opening, and repair once more where one is closed.
pub(crate) fn prepare_closed(
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Closed, Error> {
    close_prepared(prepare(source, MeshOrder::Place, control)?, source, settings, control)
}

/// The same for a mesh that is repaired.
pub(crate) fn close_prepared(
    mut prepared: PreparedMesh,
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Closed, Error> {
    let is_closed = |prepared: &PreparedMesh| prepared.closed.iter().all(|&closed| closed);
    let mut openings: Vec<Opening> = Vec::new();
    let mut is_on_seen_rim = vec![false; source.vertex_count()];
    let mut has_caps = false;
    for _ in 0..PASSES {
        if settings.openings == Openings::Keep || is_closed(&prepared) {
            break;
        }
        let mut closing = match close_narrow(&prepared, settings, control)? {
            Some(closing) => closing,
            None => judge(&prepared, source, settings, &mut is_on_seen_rim, control)?,
        };
        // The next pass judges again what this one leaves.
        openings.retain(|opening| opening.outcome.is_closed());
        openings.append(&mut closing.openings);
        if closing.triangles.is_empty() && closing.hidden.is_empty() {
            break;
        }
        prepared = cap_and_repair(prepared, source, &closing, control)?;
        has_caps = true;
    }
    hide(&mut prepared);
    let nested_components = match settings.keep_cavities {
        true => 0,
        false => drop_nested(&mut prepared, control)?,
    };
    Ok(Closed { prepared, openings, nested_components, has_caps })
}

/// Adds the triangles that close openings, and repairs the whole.
fn cap_and_repair(
    before: PreparedMesh,
    source: MeshView<'_>,
    closing: &Closing,
    control: &Control,
) -> Result<PreparedMesh, Error> {
    let positions = before.source_vertices.iter().map(|&vertex| source.at(vertex).into()).collect();
    let surface = before.mesh.triangles.len() + closing.triangles.len();
    let triangles =
        [before.mesh.triangles.as_slice(), &closing.triangles, &closing.hidden].concat();
    let mut is_both_ways = before.is_both_ways;
    is_both_ways.resize(triangles.len(), closing.are_both_ways);
    let mesh = TriangleMesh::new(positions, triangles);
    let mut after = prepare_again(mesh.view(), &is_both_ways, MeshOrder::Place, control)?;
    for triangle in &mut after.source_triangles {
        let is_hidden = *triangle as usize >= surface;
        let of_cap = if is_hidden { HIDDEN_CAP } else { CAP };
        *triangle = before.source_triangles.get(*triangle as usize).copied().unwrap_or(of_cap);
    }
    for vertex in &mut after.source_vertices {
        *vertex = before.source_vertices[*vertex as usize];
    }
    after.repairs = before.repairs;
    Ok(after)
}

/// Takes caps within the solid out of the surface.
fn hide(prepared: &mut PreparedMesh) {
    let all = prepared.mesh.triangles.iter().zip(&prepared.source_triangles);
    let hidden = all.filter(|&(_, &source)| source == HIDDEN_CAP);
    prepared.hidden_caps = hidden.map(|(&triangle, _)| triangle).collect();
    if !prepared.hidden_caps.is_empty() {
        prepared.retain(|source, _| source != HIDDEN_CAP);
    }
}

/// Drops the closed components that are within the solid. Returns how many.
///
/// Components whose box lies in no other's are passed over, and most others end with the first
/// sample.
fn drop_nested(prepared: &mut PreparedMesh, control: &Control) -> Result<usize, Error> {
    let mut dropped = 0;
    for _ in 0..NESTED_PASSES {
        if prepared.closed.len() < 2 {
            break;
        }
        let candidates = boxed_in(prepared);
        if candidates.is_empty() {
            break;
        }
        let bvh =
            Bvh::with_control(prepared.mesh.points(), &prepared.triangles_of_solid(), control)?;
        bvh.expect_winding_numbers(control)?;
        let mut is_dropped = vec![false; prepared.closed.len()];
        for (component, triangles) in candidates {
            control.check()?;
            is_dropped[component] = is_nested(prepared, &triangles, &bvh);
        }
        let found = is_dropped.iter().filter(|&&is_dropped| is_dropped).count();
        if found == 0 {
            break;
        }
        dropped += found;
        prepared.retain(|_, component| !is_dropped[component as usize]);
    }
    Ok(dropped)
}

/// Closed components whose box lies in that of another component, with their triangles.
fn boxed_in(prepared: &PreparedMesh) -> Vec<(usize, Vec<u32>)> {
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); prepared.closed.len()];
    for (triangle, &component) in (0_u32..).zip(&prepared.components) {
        members[component as usize].push(triangle);
    }
    let corners = |&t: &u32| prepared.mesh.corners(prepared.mesh.triangles[t as usize]);
    let boxes: Vec<(Vector, Vector)> =
        members.iter().map(|own| bounds(own.iter().flat_map(corners))).collect();
    // A tree of diagonals is one of boxes. A box around another contains its lowest corner.
    let ends: Vec<Vector> = boxes.iter().flat_map(|&(low, high)| [low, high]).collect();
    let diagonals: Vec<[u32; 3]> =
        (0..boxes.len() as u32).map(|own| [2 * own, 2 * own + 1, 2 * own]).collect();
    let bvh = Bvh::new(&ends, &diagonals);
    let is_boxed_in = |own: usize| {
        let (low, high) = boxes[own];
        bvh.triangles_near_box(low, low, 0.0).into_iter().any(|other| {
            let (other_low, other_high) = boxes[other as usize];
            other as usize != own
                && (0..3).all(|i| other_low[i] <= low[i] && high[i] <= other_high[i])
        })
    };
    let is_candidate =
        |own: &usize| prepared.closed[*own] && !members[*own].is_empty() && is_boxed_in(*own);
    let found: Vec<usize> = (0..members.len()).filter(is_candidate).collect();
    found.into_iter().map(|own| (own, std::mem::take(&mut members[own]))).collect()
}

/// Whether all samples have solid on both sides, or all on the side behind the surface with nothing
/// in front of it while the component is wound inward.
fn is_nested(prepared: &PreparedMesh, triangles: &[u32], bvh: &Bvh) -> bool {
    let step = triangles.len().div_ceil(SAMPLES).max(1);
    let sides = |&triangle: &u32| {
        let [a, b, c] = prepared.mesh.corners(prepared.mesh.triangles[triangle as usize]);
        let centre = (a + (b + c)) * (1.0 / 3.0);
        let normal = area_normal(a, b, c).normalize_or_zero() * STEP;
        let behind = bvh.is_inside(centre + -normal);
        behind.then(|| bvh.is_inside(centre + normal))
    };
    let mut samples = triangles.iter().step_by(step);
    let Some(Some(first)) = samples.next().map(sides) else { return false };
    let is_cavity = !first;
    let corners = |&t: &u32| prepared.mesh.corners(prepared.mesh.triangles[t as usize]);
    if is_cavity && six_volumes(triangles.iter().map(corners)) > 0.0 {
        return false;
    }
    samples.all(|triangle| sides(triangle) == Some(first))
}

/// A mesh with its openings closed: what the promises of a decomposition are about.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedMesh {
    /// The repaired surface, then the caps; in the input's units.
    pub mesh: TriangleMesh,
    /// How many of the triangles, the last ones, are caps. Those within the solid are left out.
    pub caps: usize,
    /// The triangles by whose winding number a point is inside, over the vertices of `mesh`: the
    /// surface, sheets both ways round, and the caps within the solid.
    pub solid: Vec<[u32; 3]>,
    /// The openings, closed and left.
    pub openings: Vec<Opening>,
    /// Closed components within the solid, which nothing can reach and which are left out.
    pub nested_components: usize,
}

/// Repairs a mesh and closes its openings as [`decompose`](crate::decompose) does with these
/// parameters. Almost linear time.
///
/// # Errors
/// As [`inspect`](crate::inspect::inspect()), and [`Error::Cancelled`].
///
/// ```
/// use hullwright::openings::close_openings;
/// use hullwright::{Control, MeshView, Parameters};
///
/// // Three sides of a tetrahedron: the fourth is a flat opening.
/// let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let triangles = [[0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let mesh = MeshView::new(&positions, &triangles);
/// let closed = close_openings(mesh, &Parameters::default(), &Control::new())?;
/// assert_eq!((closed.mesh.triangles.len(), closed.caps), (4, 1));
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn close_openings<'a>(
    mesh: impl Into<MeshView<'a>>,
    parameters: &Parameters,
    control: &Control,
) -> Result<ClosedMesh, Error> {
    parameters.validate()?;
    let settings = OpeningSettings::from(parameters);
    prepare_closed(mesh.into(), &settings, control).map(ClosedMesh::from)
}

impl From<Closed> for ClosedMesh {
    fn from(closed: Closed) -> Self {
        let (triangles, caps) = caps_last(&closed.prepared);
        let mesh = closed.restored(triangles);
        let solid = closed.prepared.triangles_of_solid().into_owned();
        let Closed { openings, nested_components, .. } = closed;
        Self { mesh, caps, solid, openings, nested_components }
    }
}

/// The triangles of the surface, caps last, and the number of those.
fn caps_last(prepared: &PreparedMesh) -> (Vec<[u32; 3]>, usize) {
    let all = prepared.mesh.triangles.iter().copied().zip(&prepared.source_triangles);
    let (caps, surface): (Vec<_>, Vec<_>) = all.partition(|&(_, &source)| source == CAP);
    (
        surface.into_iter().chain(caps.iter().copied()).map(|(triangle, _)| triangle).collect(),
        caps.len(),
    )
}
