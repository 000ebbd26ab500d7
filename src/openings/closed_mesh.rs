//! The mesh with its openings closed, for who wants to see it or to go on with it.

use super::prepare::{Closed, prepare_closed};
use super::{Opening, OpeningSettings};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::{MeshView, TriangleMesh};
use crate::mesh::{CAP, PreparedMesh};
use crate::parameters::Parameters;

/// A mesh with its openings closed: what the promises of a decomposition are about.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedMesh {
    /// The repaired surface, then the caps; in the input's units.
    pub mesh: TriangleMesh,
    /// How many of the triangles, the last ones, are caps. Those within the solid are left out.
    pub caps: usize,
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
    let positions = prepared.mesh.positions.iter().map(restore).collect();
    let (triangles, caps) = caps_last(&prepared);
    let mesh = TriangleMesh::new(positions, triangles);
    Ok(ClosedMesh { mesh, caps, openings, nested_components })
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

/// The surface that the promises are about, and the triangles by whose winding number a point is in the
/// solid; over the same vertices, in the input's units.
///
/// # Errors
/// As [`close_openings`].
pub fn surface_and_solid(
    mesh: MeshView<'_>,
    parameters: &Parameters,
    control: &Control,
) -> Result<(TriangleMesh, Vec<[u32; 3]>), Error> {
    let settings = OpeningSettings::from(parameters);
    let Closed { prepared, .. } = prepare_closed(mesh, &settings, control)?;
    let solid = prepared.triangles_of_solid().into_owned();
    let restore = |&point| prepared.normalization.restore(point);
    let positions = prepared.mesh.positions.iter().map(restore).collect();
    Ok((TriangleMesh::new(positions, prepared.mesh.triangles), solid))
}
