//! The mesh that the stages after it work on: repaired, its openings closed, without nested shells.
//!
//! ```text
//! repair → judge the openings → cap those that are closed → repair → judge again
//! ```

use super::decide::{Closing, OpeningSettings, judge};
use super::nested::drop_nested;
use super::report::Opening;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::{MeshView, TriangleMesh};
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::prepare;
use crate::mesh::{CAP, HIDDEN_CAP, PreparedMesh};
use crate::parameters::{Openings, Parameters};

/// Caps have the vertices of their loops, and ear clipping leaves out those in the middle of a
/// straight side: that is a crack, which the next pass zips.
const PASSES: usize = 3;

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
}

/// Repairs a mesh, closes its openings, and drops what is within the solid. In `source_triangles` caps
/// stand as [`CAP`]. The counts of repairs are those of the mesh as it came.
///
/// Takes as long as repair where nothing is open; otherwise some hundred rays for each flat opening, and
/// repair once more where one is closed.
pub(crate) fn prepare_closed(
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Closed, Error> {
    close_prepared(prepare(source, settings.order, control)?, source, settings, control)
}

/// The same for a mesh that is repaired already.
pub(crate) fn close_prepared(
    mut prepared: PreparedMesh,
    source: MeshView<'_>,
    settings: &OpeningSettings,
    control: &Control,
) -> Result<Closed, Error> {
    let is_closed = |prepared: &PreparedMesh| prepared.closed.iter().all(|&closed| closed);
    let mut openings: Vec<Opening> = Vec::new();
    let mut has_caps = false;
    for _ in 0..PASSES {
        if settings.openings == Openings::Keep || is_closed(&prepared) {
            break;
        }
        let mut closing = judge(&prepared, source, settings, control)?;
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
    let mesh = TriangleMesh::new(positions, triangles);
    let mut after = prepare(mesh.view(), MeshOrder::Place, control)?;
    let was_both_ways =
        |triangle: u32| before.is_both_ways.get(triangle as usize).copied().unwrap_or(false);
    for (t, &triangle) in after.source_triangles.iter().enumerate() {
        // What caps close is a solid, however it was drawn.
        let is_open = !after.closed[after.components[t] as usize];
        after.is_both_ways[t] |= is_open && was_both_ways(triangle);
    }
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
    let sources = prepared.source_triangles.iter();
    let hidden = prepared.mesh.triangles.iter().zip(sources);
    let hidden = hidden.filter(|&(_, &source)| source == HIDDEN_CAP);
    prepared.hidden_caps = hidden.map(|(&triangle, _)| triangle).collect();
    if !prepared.hidden_caps.is_empty() {
        prepared.retain(|source, _| source != HIDDEN_CAP);
    }
}

/// A mesh with its openings closed: what the promises of a decomposition are about.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedMesh {
    /// The repaired surface, then the caps; in the input's units.
    pub mesh: TriangleMesh,
    /// How many of the triangles, the last ones, are caps. Those within the solid are left out.
    pub caps: usize,
    /// The triangles by whose winding number a point is inside, over the vertices of `mesh`: the surface, sheets
    /// both ways round, and the caps within the solid.
    pub solid: Vec<[u32; 3]>,
    /// The openings, closed and left.
    pub openings: Vec<Opening>,
    /// Closed components within the solid, which nothing can reach and which are left out.
    pub nested_components: usize,
}

/// Repairs a mesh and closes its openings as [`decompose`](crate::decompose) does with these parameters.
/// Almost linear time.
///
/// # Errors
/// As [`inspect`](crate::inspect()), and [`Error::Cancelled`].
///
/// ```
/// use hullwright::{Control, MeshView, Parameters, close_openings};
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
    let closed = prepare_closed(mesh.into(), &settings, control)?;
    let Closed { prepared, openings, nested_components, .. } = closed;
    let restore = |&point| prepared.normalization.restore(point);
    let positions = prepared.mesh.points().iter().map(restore).map(Into::into).collect();
    let (triangles, caps) = caps_last(&prepared);
    let mesh = TriangleMesh::new(positions, triangles);
    let solid = prepared.triangles_of_solid().into_owned();
    Ok(ClosedMesh { mesh, caps, solid, openings, nested_components })
}

/// The triangles of the surface, caps last, and the number of those.
pub(crate) fn caps_last(prepared: &PreparedMesh) -> (Vec<[u32; 3]>, usize) {
    let sources = prepared.source_triangles.iter();
    let (caps, mut triangles): (Vec<_>, Vec<_>) =
        sources.zip(&prepared.mesh.triangles).partition(|&(&source, _)| source == CAP);
    let count = caps.len();
    triangles.extend(caps);
    (triangles.into_iter().map(|(_, &triangle)| triangle).collect(), count)
}
