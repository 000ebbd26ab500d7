//! From hulls and mass properties to Rapier's types.

use rapier3d::dynamics::MassProperties as RapierMassProperties;
use rapier3d::geometry::{ColliderBuilder, SharedShape};
use rapier3d::parry::math::{Pose, Rotation, Vector};
use rapier3d::parry::shape::ConvexPolyhedron;

use super::check::is_closed;
use super::prepare::{ColliderError, RigidMass, coarser, scaled_hulls};
use crate::{Hull, MassProperties};

/// One shape of all hulls, their points multiplied by `scale`: a single convex polyhedron,
/// or a compound of them. O(n log n) in the vertices.
///
/// Scale is baked into the points, since Parry's own scaling of polyhedra is wrong where
/// its factors differ; a negative factor mirrors. If Parry refuses a hull, a hull simplified by at
/// most 1e-3 of its extent replaces it, and if Parry refuses that too, its bounding box.
///
/// # Errors
/// [`ColliderError`] says which hull or factor can't be used. It never panics.
pub fn shape(hulls: &[Hull], scale: [f32; 3]) -> Result<SharedShape, ColliderError> {
    let points: Vec<_> = hulls.iter().map(|hull| hull.shape.points.as_slice()).collect();
    shape_from_points(&points, scale)
}

/// The same as [`shape`] of bare points: one convex part per set, its convex hull.
///
/// # Errors
/// As [`shape`].
pub fn shape_from_points<P: AsRef<[[f64; 3]]>>(
    hulls: &[P],
    scale: [f32; 3],
) -> Result<SharedShape, ColliderError> {
    let hulls = scaled_hulls(hulls, scale)?;
    if let [(points, triangles)] = hulls.as_slice()
        && let Some(shape) = part(points, triangles)
    {
        return Ok(shape);
    }
    let parts = hulls.iter().map(|(points, triangles)| match part(points, triangles) {
        Some(shape) => (Pose::IDENTITY, shape),
        None => bounding_box(points),
    });
    Ok(SharedShape::compound(parts.collect()))
}

/// The hull, or if Parry refuses it a slightly simpler one.
fn part(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<SharedShape> {
    polyhedron(points, triangles)
        .or_else(|| coarser(points).find_map(|(points, triangles)| polyhedron(&points, &triangles)))
        .map(SharedShape::new)
}

/// A collider of all hulls with the mass properties of the source mesh, both scaled: see
/// [`shape`] and [`mass_properties`].
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// # let parameters = hullwright::Parameters::default();
/// # let hulls = hullwright::decompose(&mesh, &parameters, &hullwright::Control::new())?.hulls;
/// let properties = hullwright::mass_properties(&mesh, &hulls, 600.0)?;
/// let collider = hullwright::rapier::collider(&hulls, &properties, [1.0; 3])?.build();
/// assert!((collider.mass() - 100.0).abs() < 1e-3);
/// # Ok::<(), hullwright::rapier::ColliderError>(())
/// ```
///
/// # Errors
/// As [`shape`] and [`mass_properties`].
pub fn collider(
    hulls: &[Hull],
    properties: &MassProperties,
    scale: [f32; 3],
) -> Result<ColliderBuilder, ColliderError> {
    let properties = mass_properties(properties, scale)?;
    Ok(ColliderBuilder::new(shape(hulls, scale)?).mass_properties(properties))
}

/// Converts mass properties to Rapier's type, after the body's coordinates are multiplied by
/// `scale` at the same density. They are computed by the crate's own
/// [`mass_properties`](crate::mass_properties()).
///
/// # Errors
/// [`ColliderError::InvalidScale`], and [`ColliderError::UnusableMass`] where a value is beyond the
/// range of `f32`.
pub fn mass_properties(
    properties: &MassProperties,
    scale: [f32; 3],
) -> Result<RapierMassProperties, ColliderError> {
    let body = RigidMass::new(properties, scale)?;
    Ok(RapierMassProperties::with_principal_inertia_frame(
        Vector::from(body.centre),
        body.mass,
        Vector::from(body.moments),
        Rotation::from_array(body.rotation),
    ))
}

/// Nothing where Parry has nothing, or nothing that is safe to use.
pub(super) fn polyhedron(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<ConvexPolyhedron> {
    if !is_closed(points.len(), triangles) {
        return None;
    }
    let points = points.iter().map(|point| Vector::from(*point)).collect();
    let polyhedron = ConvexPolyhedron::from_convex_mesh(points, triangles)?;
    is_sound(&polyhedron).then_some(polyhedron)
}

/// Whether the faces that Parry made yield contacts. They are built from
/// normals in `f32`, by which slivers may be lost and leave edges without a face.
fn is_sound(polyhedron: &ConvexPolyhedron) -> bool {
    let faces = polyhedron.faces();
    let edges = polyhedron.edges();
    let has_faces = |edge: &u32| {
        edges
            .get(*edge as usize)
            .is_some_and(|edge| edge.faces.iter().all(|face| (*face as usize) < faces.len()))
    };
    !faces.is_empty()
        && faces.iter().any(|face| face.normal != Vector::ZERO)
        && faces.iter().all(|face| face.normal.is_finite())
        && polyhedron.edges_adj_to_face().iter().all(has_faces)
}

fn bounding_box(points: &[[f32; 3]]) -> (Pose, SharedShape) {
    let points = || points.iter().map(|point| Vector::from(*point));
    let low = points().fold(Vector::INFINITY, Vector::min);
    let high = points().fold(Vector::NEG_INFINITY, Vector::max);
    let [x, y, z] = ((high - low) / 2.0).to_array();
    (Pose::from_translation((low + high) / 2.0), SharedShape::cuboid(x, y, z))
}
