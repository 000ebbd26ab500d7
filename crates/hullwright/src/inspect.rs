//! A look at a mesh without decomposing it: what it holds, and what repair would do to it.

use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{area_normal, bounds, cubed, six_volumes, squared};
use crate::geometry::{Bounds, MeshView};
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::prepare;
use crate::mesh::{PreparedMesh, Repairs};
use crate::openings::prepare::close_prepared;
use crate::openings::{Opening, OpeningSettings};
use crate::parameters::Parameters;

/// What [`inspect`] found.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inspection {
    /// Vertices given.
    pub source_vertices: usize,
    /// Triangles given.
    pub source_triangles: usize,
    /// Vertices left after repair.
    pub vertices: usize,
    /// Triangles left after repair.
    pub triangles: usize,
    /// Bounding box of the vertices left after repair, in the input's units.
    pub bounds: Bounds,
    /// Length of the diagonal of `bounds`. Relative lengths are divided by it.
    pub diagonal: f64,
    /// Connected components (over shared edges).
    pub components: usize,
    /// Components whose every edge has exactly two triangles, in opposite directions.
    pub closed_components: usize,
    /// What repair does, and the edges that it leaves open or non-manifold.
    pub repairs: Repairs,
    /// Area of all triangles left after repair, in squared units.
    pub area: f64,
    /// Volume that the closed components enclose, in cubed units, openings closed. Cavities are
    /// taken off; where components overlap, their volumes are added.
    pub volume: f64,
    /// The openings, closed and left.
    pub openings: Vec<Opening>,
}

impl Inspection {
    /// Whether all components are closed as they come, so that the mesh has an inside.
    pub fn is_closed(&self) -> bool {
        self.closed_components == self.components
    }
}

/// Looks at a mesh as [`decompose`](crate::decompose) sees it with [`Parameters::default`]. Almost
/// linear time.
///
/// # Errors
/// As [`decompose`](crate::decompose) for a mesh that is empty, too large or without any usable
/// triangle, or has an index out of range.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// let found = hullwright::inspect::inspect(&mesh)?;
/// assert!(found.is_closed());
/// assert_eq!((found.triangles, found.components), (4, 1));
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn inspect<'a>(mesh: impl Into<MeshView<'a>>) -> Result<Inspection, Error> {
    inspect_with(mesh, &Parameters::default())
}

/// Looks at a mesh as [`decompose`](crate::decompose) sees it with these parameters: openings
/// depend on them. Almost linear time.
///
/// # Errors
/// As [`inspect`].
pub fn inspect_with<'a>(
    mesh: impl Into<MeshView<'a>>,
    parameters: &Parameters,
) -> Result<Inspection, Error> {
    let source = mesh.into();
    let control = Control::new();
    let prepared = prepare(source, MeshOrder::Place, &control)?;
    let diagonal = prepared.normalization.diagonal;
    let (area, _) = measure(&prepared);
    let settings = OpeningSettings { keep_cavities: true, ..OpeningSettings::from(parameters) };
    let closed = close_prepared(prepared.clone(), source, &settings, &control)?;
    let (_, volume) = measure(&closed.prepared);
    let (min, max) = bounds(prepared.source_vertices.iter().map(|&vertex| source.at(vertex)));
    Ok(Inspection {
        source_vertices: source.vertex_count(),
        source_triangles: source.triangles().len(),
        vertices: prepared.mesh.positions.len(),
        triangles: prepared.mesh.triangles.len(),
        bounds: Bounds { min: min.into(), max: max.into() },
        diagonal,
        components: prepared.closed.len(),
        closed_components: prepared.closed.iter().filter(|closed| **closed).count(),
        repairs: prepared.repairs,
        area: area * squared(diagonal),
        volume: volume * cubed(diagonal),
        openings: closed.openings,
    })
}

/// Area and enclosed volume of the normalised mesh.
fn measure(prepared: &PreparedMesh) -> (f64, f64) {
    let PreparedMesh { mesh, components, closed, hidden_caps, .. } = prepared;
    let all = || mesh.triangles.iter().map(|&triangle| mesh.corners(triangle));
    let twice_area: f64 = all().map(|[a, b, c]| area_normal(a, b, c).length()).sum();
    let is_closed = |component: &u32| closed[*component as usize];
    let of_closed = all().zip(components).filter(|(_, component)| is_closed(component));
    let hidden = hidden_caps.iter().map(|&triangle| mesh.corners(triangle));
    let volume = six_volumes(of_closed.map(|(corners, _)| corners).chain(hidden)) / 6.0;
    // A sum of nothing is a negative zero.
    (twice_area / 2.0, volume + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, hemisphere, join, turn};
    use crate::parameters::Openings;

    fn inspect_mesh(mesh: &TriangleMesh) -> Inspection {
        inspect(mesh).unwrap()
    }

    fn assert_close(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found}, {expected}");
    }

    #[test]
    fn a_box_has_the_measures_of_a_box() {
        let found = inspect_mesh(&cuboid([10.0, 10.0, 10.0], [11.0, 12.0, 13.0]));
        assert_eq!(found.bounds, Bounds { min: [10.0; 3], max: [11.0, 12.0, 13.0] });
        assert_close(found.diagonal, 14_f64.sqrt());
        assert_close(found.area, 22.0);
        assert_close(found.volume, 6.0);
        assert!(found.is_closed());
        assert_eq!((found.components, found.triangles), (1, 12));
    }

    #[test]
    fn a_cavity_is_taken_off_and_an_open_sheet_has_no_volume() {
        let hollow = join(&[cuboid([0.0; 3], [4.0; 3]), turn(cuboid([1.0; 3], [2.0; 3]))]);
        assert_close(inspect_mesh(&hollow).volume, 63.0);

        let mut with_sheet = hollow;
        let first = with_sheet.positions.len() as u32;
        with_sheet.positions.extend([[9.0; 3], [9.0, 8.0, 9.0], [8.0, 9.0, 9.0]]);
        with_sheet.triangles.push([first, first + 1, first + 2]);
        let found = inspect_mesh(&with_sheet);
        assert_close(found.volume, 63.0);
        assert_eq!((found.components, found.closed_components), (3, 2));
        assert!(!found.is_closed());
        assert_eq!(found.repairs.open_edges, 3);
        let keep = Parameters::default().with_openings(Openings::Keep);
        assert_eq!(inspect_with(&hemisphere(8), &keep).unwrap().volume, 0.0);
        let closed = inspect_mesh(&hemisphere(8));
        assert!(closed.volume > 1.5, "without its flat side it is a solid");
        assert_eq!(closed.openings.len(), 1);
    }

    #[test]
    fn repairs_are_counted_against_what_was_given() {
        let mut mesh = cuboid([0.0; 3], [1.0; 3]);
        mesh.positions.push([5.0; 3]);
        mesh.triangles.push(mesh.triangles[0]);
        mesh.triangles.push([0, 0, 1]);
        let found = inspect_mesh(&mesh);
        assert_eq!((found.source_triangles, found.triangles), (14, 12));
        assert_eq!((found.source_vertices, found.vertices), (9, 8));
        assert_eq!(found.bounds.max, [1.0; 3]);
        assert_eq!(found.repairs.unused_vertices, 1);
        assert_eq!(found.repairs.duplicate_triangles, 1);
        assert_eq!(found.repairs.degenerate_triangles, 1);
    }

    #[test]
    fn what_can_not_be_decomposed_can_not_be_inspected() {
        assert!(matches!(inspect(&TriangleMesh::default()), Err(Error::EmptyMesh { .. })));
        let out_of_range = inspect(MeshView::new(&[[0.0_f32; 3]], &[[0, 0, 1]]));
        assert!(matches!(out_of_range, Err(Error::IndexOutOfRange { index: 1, .. })));
    }
}
