//! From hulls and mass properties to Parry's types, and back.
//!
//! Parry takes convex polyhedra as points and triangles in `f32`. It checks little of them, and
//! what it does not check ends in a panic or in wrong contacts later. So hulls are scaled, rounded
//! and built anew here, and everything that Parry relies on is checked before it is called.

use hullwright::hull::{
    DEFAULT_TOLERANCE, HullBuilder, Primitive, SinglePrecisionHull, Slack, fit_primitive,
    rounded_hull, single_precision,
};
use hullwright::hulls_format::HullsFile;
use hullwright::{ConvexHull, Error, Hull, MassProperties, MeshView, TriangleMesh};
use parry3d::mass_properties::MassProperties as ParryMassProperties;
use parry3d::math::{Matrix, Pose, Rotation, Vector};
use parry3d::query::PointQueryWithLocation;
use parry3d::shape::{ConvexPolyhedron, SharedShape, TriMesh, TriMeshFlags, TypedShape};

/// Why there is no collider.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ColliderError {
    /// There is nothing to make a shape of.
    #[error("there are no hulls")]
    NoHulls,
    /// A factor is zero or not finite, or takes coordinates beyond the range of `f32`.
    #[error("the scale {scale:?} leaves no body")]
    InvalidScale {
        /// The scale given.
        scale: [f32; 3],
    },
    /// A hull has no counterpart in single precision.
    #[error("hull {hull}: {reason}")]
    UnusableHull {
        /// Its number.
        hull: usize,
        /// Why not.
        reason: Error,
    },
    /// Mass, centre or inertia is not finite in single precision, or the mass is not positive.
    #[error("the mass properties can't be held in f32: mass {mass:e}")]
    UnusableMass {
        /// The mass, after scaling.
        mass: f64,
    },
    /// Parry makes no polyhedron of a hull, or one whose faces yield no contacts.
    #[error("Parry refuses the hull")]
    Refused,
    /// Parry makes no triangle mesh.
    #[error("there is no triangle mesh: {reason}")]
    TriangleMesh {
        /// Why not.
        reason: String,
    },
    /// The mesh could not be decomposed or weighed.
    #[error(transparent)]
    Mesh(#[from] Error),
}

/// The hull of points multiplied by `scale`, in single precision: convex and closed, with volume,
/// wound outward. A negative factor mirrors. O(n log n) in the points.
///
/// # Errors
/// The reason of [`ColliderError::UnusableHull`].
fn scaled_hull(
    points: &[[f64; 3]],
    scale: [f32; 3],
    builder: &mut HullBuilder,
) -> Result<SinglePrecisionHull, Error> {
    let [x, y, z] = scale.map(f64::from);
    let scaled: Vec<_> = points.iter().map(|p| [p[0] * x, p[1] * y, p[2] * z]).collect();
    single_precision(&scaled, builder)
}

/// A hull that Parry refuses is built again with these tolerances, as fractions of its extent,
/// since Parry drops faces where there are slivers. The first is the usual one, which removes what
/// rounding leaves; the last is one millimetre for a hull a metre wide.
const TOLERANCES: [f64; 4] = [DEFAULT_TOLERANCE, 1e-5, 1e-4, 1e-3];

/// The same hull with fewer and fewer slivers, for those that Parry refuses.
fn with_fewer_vertices(points: &[[f32; 3]]) -> impl Iterator<Item = SinglePrecisionHull> {
    let points: Vec<_> = points.iter().map(|point| point.map(f64::from)).collect();
    TOLERANCES.into_iter().filter_map(move |tolerance| {
        single_precision(&points, &mut HullBuilder::new().with_tolerance(tolerance)).ok()
    })
}

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
    let as_it_is = |hull: &Hull| {
        let (points, triangles) = rounded_hull(&hull.shape, scale)?;
        polyhedron(&points, &triangles)
    };
    shape_of(hulls, scale, as_it_is, |hull| &hull.shape.points)
}

/// The same as [`shape`] of bare points: one convex part per set, its convex hull.
///
/// # Errors
/// As [`shape`].
pub fn shape_from_points<P: AsRef<[[f64; 3]]>>(
    hulls: &[P],
    scale: [f32; 3],
) -> Result<SharedShape, ColliderError> {
    shape_of(hulls, scale, |_| None, AsRef::as_ref)
}

/// One shape of all hulls, each as it is where that is something, or built of its points.
///
/// # Errors
/// As [`shape`].
fn shape_of<T>(
    hulls: &[T],
    scale: [f32; 3],
    as_it_is: impl Fn(&T) -> Option<ConvexPolyhedron>,
    points: impl Fn(&T) -> &[[f64; 3]],
) -> Result<SharedShape, ColliderError> {
    check_scale(scale)?;
    let mut builder = HullBuilder::new();
    let make = |(index, hull): (usize, &T)| {
        if let Some(polyhedron) = as_it_is(hull) {
            return Ok((Pose::IDENTITY, SharedShape::new(polyhedron)));
        }
        let unusable = |reason| ColliderError::UnusableHull { hull: index, reason };
        let built = scaled_hull(points(hull), scale, &mut builder).map_err(unusable)?;
        Ok(part(&built))
    };
    let parts: Vec<_> = hulls.iter().enumerate().map(make).collect::<Result<_, ColliderError>>()?;
    match parts.as_slice() {
        [] => Err(ColliderError::NoHulls),
        // One that is placed nowhere needs no compound.
        [(_, shape)] if shape.as_convex_polyhedron().is_some() => Ok(shape.clone()),
        _ => Ok(SharedShape::compound(parts)),
    }
}

/// The hull, or if Parry refuses it a slightly simpler one, or its bounding box.
fn part((points, triangles): &SinglePrecisionHull) -> (Pose, SharedShape) {
    let simpler = || {
        let mut all = with_fewer_vertices(points);
        all.find_map(|(points, triangles)| polyhedron(&points, &triangles))
    };
    match polyhedron(points, triangles).or_else(simpler) {
        Some(polyhedron) => (Pose::IDENTITY, SharedShape::new(polyhedron)),
        None => bounding_box(points),
    }
}

/// Converts mass properties to Parry's type, after the body's coordinates are multiplied by
/// `scale` at the same density. They are computed by the library's
/// [`mass_properties`](hullwright::mass_properties()).
///
/// # Errors
/// [`ColliderError::InvalidScale`], and [`ColliderError::UnusableMass`] where a value is beyond the
/// range of `f32`.
pub fn mass_properties(
    properties: &MassProperties,
    scale: [f32; 3],
) -> Result<ParryMassProperties, ColliderError> {
    check_scale(scale)?;
    let properties = properties.scaled(scale.map(f64::from));
    let principal = properties.principal_inertia();
    let mass = properties.mass as f32;
    let centre = Vector::from(properties.centre.map(|x| x as f32));
    let moments = principal.moments.map(|x| x as f32);
    let rotation = principal.rotation.map(|x| x as f32);
    // Parry keeps inverses, in which a subnormal number becomes infinite.
    let is_usable = mass.is_normal()
        && mass > 0.0
        && centre.is_finite()
        && rotation.iter().all(|x| x.is_finite())
        && moments.iter().all(|x| x.is_normal());
    if !is_usable {
        return Err(ColliderError::UnusableMass { mass: properties.mass });
    }
    Ok(ParryMassProperties::with_principal_inertia_frame(
        centre,
        mass,
        Vector::from(moments),
        Rotation::from_array(rotation),
    ))
}

fn check_scale(scale: [f32; 3]) -> Result<(), ColliderError> {
    let is_usable = scale.iter().all(|factor| factor.is_normal());
    is_usable.then_some(()).ok_or(ColliderError::InvalidScale { scale })
}

/// Nothing where Parry has nothing, or nothing that is safe to use.
fn polyhedron(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<ConvexPolyhedron> {
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

/// Whether triangles over `points` points close up: each edge has exactly two triangles, which
/// run along it in opposite directions, and no triangle names a vertex twice or one that is not
/// there.
///
/// Parry's `ConvexPolyhedron::from_convex_mesh` relies on this without looking: it indexes with
/// what it is given, asserts that neighbours are wound alike, and reads the first face of what it
/// made at every contact.
fn is_closed(points: usize, triangles: &[[u32; 3]]) -> bool {
    let exists = |&vertex: &u32| (vertex as usize) < points;
    if triangles.is_empty() || !triangles.as_flattened().iter().all(exists) {
        return false;
    }
    // Edges that run up to the vertex with the larger number, and those that run down, as one
    // number each: sorting numbers takes a quarter of the time of sorting pairs, and this is done
    // for each hull of a collider.
    let half = triangles.len() * 3 / 2;
    let (mut up, mut down) = (Vec::with_capacity(half), Vec::with_capacity(half));
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let edge = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
            let list = if from < to { &mut up } else { &mut down };
            list.push(edge);
        }
    }
    up.sort_unstable();
    down.sort_unstable();
    up == down && up.is_sorted_by(|edge, next| edge < next)
}

/// The same as [`shape`](shape()) of a file's hulls, with a box, ball or capsule for each hull that
/// is one within what the verified errors leave of the bound: neither hulls nor mesh come to be
/// farther apart than the bound says. Physics engines are faster with these.
///
/// Hulls stay as they are where no bound was verified, and where the factors of `scale` differ: a
/// scaled ball is none.
///
/// ```
/// use hullwright::hulls_format::HullsFile;
/// use hullwright::{Control, Parameters, decompose};
///
/// let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| [0, 1, 2].map(|axis| f64::from(i >> axis & 1)));
/// let cube = hullwright::convex_hull(&corners)?;
/// let made = decompose(&cube, &Parameters::default(), &Control::new())?;
/// let file = HullsFile::new("cube", &made);
/// let shape = hullwright_parry::shape_with_primitives(&file, [2.0; 3])?;
/// let parts = shape.as_compound().expect("a box that is placed");
/// assert!(parts.shapes()[0].1.as_cuboid().is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`shape`](shape()).
pub fn shape_with_primitives(
    file: &HullsFile,
    scale: [f32; 3],
) -> Result<SharedShape, ColliderError> {
    let factor = scale[0];
    let is_uniform = scale.iter().all(|other| *other == factor);
    let (Some(bound), Some(verified), true) = (file.bound, file.verified, is_uniform) else {
        return shape(&file.hulls, scale);
    };
    let primitive = |hull: &Hull| {
        let protrusion = hull.errors.protrusion_max.unwrap_or(verified.protrusion_max);
        let slack = Slack { outside: bound - protrusion, inside: bound - verified.uncovered_max };
        let part = primitive_part(fit_primitive(&hull.shape, slack)?, factor)?;
        let sizes = part.1.compute_local_aabb().half_extents();
        (sizes.is_finite() && sizes.min_element() > 0.0).then_some(part)
    };
    let primitives: Vec<_> = file.hulls.iter().map(primitive).collect();
    if primitives.iter().all(Option::is_none) {
        return shape(&file.hulls, scale);
    }
    let mut parts = Vec::with_capacity(primitives.len());
    for (hull, primitive) in file.hulls.iter().zip(primitives) {
        match primitive {
            Some(part) => parts.push(part),
            None => match shape(std::slice::from_ref(hull), scale)?.as_compound() {
                // What Parry refused, as a box that is placed.
                Some(placed) => parts.extend(placed.shapes().iter().cloned()),
                None => parts.push((Pose::IDENTITY, shape(std::slice::from_ref(hull), scale)?)),
            },
        }
    }
    Ok(SharedShape::compound(parts))
}

/// Where a primitive is in the scaled collider. A negative factor mirrors through the origin, which
/// makes no difference to a primitive about its centre. `None` for one without a shape of Parry.
fn primitive_part(primitive: Primitive, factor: f32) -> Option<(Pose, SharedShape)> {
    let place = |point: [f64; 3]| Vector::from(point.map(|x| x as f32)) * factor;
    let size = |length: f64| length as f32 * factor.abs();
    match primitive {
        Primitive::Cuboid { centre, axes, half } => {
            let [x, y, z] = axes.map(|axis| Vector::from(axis.map(|x| x as f32)));
            let rotation = Rotation::from_mat3(&Matrix::from_cols(x, y, z));
            let [a, b, c] = half.map(size);
            Some((Pose::from_parts(place(centre), rotation), SharedShape::cuboid(a, b, c)))
        }
        Primitive::Ball { centre, radius } => {
            Some((Pose::from_translation(place(centre)), SharedShape::ball(size(radius))))
        }
        Primitive::Capsule { ends: [a, b], radius } => {
            Some((Pose::IDENTITY, SharedShape::capsule(place(a), place(b), size(radius))))
        }
        _ => None,
    }
}

/// The mesh of Parry's triangle mesh: what it is made of can be decomposed. O(n).
pub fn mesh_from_shape(shape: &TriMesh) -> TriangleMesh {
    let points = shape.vertices().iter().map(Vector::to_array);
    TriangleMesh::from_points::<f32, _>(points, shape.indices().to_vec())
}

/// The hull of Parry's convex polyhedron, whose faces are cut into triangles. O(n).
pub fn hull_from_shape(shape: &ConvexPolyhedron) -> ConvexHull {
    let (points, triangles) = shape.to_trimesh();
    let points = points.iter().map(|point| point.to_array().map(f64::from)).collect();
    ConvexHull { points, triangles }
}

/// Parry's triangle mesh of a mesh, for bodies that don't move. Triangles with an index out of
/// range or a corner that is not finite in `f32` are left out. O(n log n).
///
/// # Errors
/// [`ColliderError::TriangleMesh`] says why Parry refuses, [`ColliderError::Mesh`] that nothing is
/// left.
pub fn triangle_mesh<'a>(
    mesh: impl Into<MeshView<'a>>,
    flags: TriMeshFlags,
) -> Result<TriMesh, ColliderError> {
    let mesh = mesh.into();
    let points: Vec<Vector> =
        mesh.positions().map(|point| Vector::from(point.map(|x| x as f32))).collect();
    let is_usable = |vertex: &u32| points.get(*vertex as usize).is_some_and(|p| p.is_finite());
    let triangles: Vec<[u32; 3]> = mesh
        .triangles()
        .iter()
        .filter(|triangle| triangle.iter().all(is_usable))
        .copied()
        .collect();
    if triangles.is_empty() {
        let all = mesh.triangles().len();
        let nothing = Error::NothingUsable { triangles: all, degenerate: 0, non_finite: all };
        return Err(nothing.into());
    }
    // Parry's tree holds all points, used or not.
    let points = points.into_iter().map(|p| if p.is_finite() { p } else { Vector::ZERO }).collect();
    TriMesh::with_flags(points, triangles, flags)
        .map_err(|error| ColliderError::TriangleMesh { reason: error.to_string() })
}

/// The subshape of a shape whose surface is nearest to a point, in the shape's own space: the hull
/// of a compound, the triangle of a mesh; 0 of another shape. For rays and contacts that say where
/// something was hit, and not what. O(n) for n hulls, O(log n) for n triangles.
///
/// ```
/// use hullwright_parry::parry3d::math::Vector;
///
/// let cube = |x: f64| [0.0, 1.0].map(|dx| {
///     [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|[y, z]| [x + dx, y, z])
/// });
/// let hulls = [cube(0.0).concat(), cube(1.0).concat()];
/// let shape = hullwright_parry::shape_from_points(&hulls, [1.0; 3])?;
/// assert_eq!(hullwright_parry::subshape_at(&shape, Vector::new(0.5, 0.5, 1.0)), 0);
/// assert_eq!(hullwright_parry::subshape_at(&shape, Vector::new(1.5, 0.5, 1.0)), 1);
/// # Ok::<(), hullwright_parry::ColliderError>(())
/// ```
pub fn subshape_at(shape: &SharedShape, point: Vector) -> u32 {
    match shape.as_typed_shape() {
        TypedShape::Compound(compound) => {
            let distance = |(pose, part): &(Pose, SharedShape)| {
                part.distance_to_point(pose, point, false).abs()
            };
            let distances = compound.shapes().iter().map(distance).enumerate();
            let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1));
            nearest.map_or(0, |(index, _)| index as u32)
        }
        TypedShape::TriMesh(mesh) => mesh.project_local_point_and_get_location(point, false).1.0,
        _ => 0,
    }
}

/// Parry's convex polyhedron of a hull, whose points are rounded to `f32`. O(n log n).
///
/// # Errors
/// [`ColliderError::UnusableHull`] where nothing is left of it in `f32`, and
/// [`ColliderError::Refused`] where Parry refuses it; [`shape`](shape()) then takes a slightly
/// simpler one.
pub fn convex_polyhedron(hull: &ConvexHull) -> Result<ConvexPolyhedron, ColliderError> {
    let (points, triangles) = hull
        .to_single_precision()
        .map_err(|reason| ColliderError::UnusableHull { hull: 0, reason })?;
    polyhedron(&points, &triangles).ok_or(ColliderError::Refused)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hullwright::MassSource;
    use hullwright::hull::ConvexHull;

    fn unit_cube() -> Vec<[f64; 3]> {
        (0..8_u8).map(|corner| [0, 1, 2].map(|axis| f64::from(corner >> axis & 1))).collect()
    }

    #[test]
    fn a_mirrored_hull_is_still_wound_outward() {
        let builder = &mut HullBuilder::new();
        let (points, triangles) = scaled_hull(&unit_cube(), [-2.0, 1.0, 3.0], builder).unwrap();
        let points: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
        let hull = ConvexHull { points, triangles };
        assert!((hull.volume() - 6.0).abs() < 1e-6);
        for (found, expected) in hull.bounds().unwrap().min.into_iter().zip([-2.0, 0.0, 0.0]) {
            assert!((found - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn a_mass_that_single_precision_can_not_hold_is_an_error() {
        let cube = hullwright::hull::convex_hull(&unit_cube()).unwrap();
        let of = |density| hullwright::mass_properties(&cube, &[], density).unwrap();
        assert_eq!(of(1.0).source, MassSource::Mesh);
        assert!(mass_properties(&of(1.0), [1.0; 3]).is_ok());
        for density in [1e-40, 1e60] {
            let result = mass_properties(&of(density), [1.0; 3]);
            assert!(matches!(result, Err(ColliderError::UnusableMass { .. })));
        }
    }

    #[test]
    fn a_hull_without_points_or_whose_triangles_do_not_close_is_built_or_refused() {
        let hull = |points: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>| {
            let shape = ConvexHull { points, triangles };
            Hull::from(shape)
        };
        let empty = shape(&[hull(vec![], vec![])], [1.0; 3]);
        assert!(matches!(empty, Err(ColliderError::UnusableHull { hull: 0, .. })));
        // Each triangle has its own corners.
        let solid = hullwright::hull::convex_hull(&unit_cube()).unwrap();
        let corners = solid.triangles.as_flattened().iter();
        let split: Vec<[f64; 3]> = corners.map(|&v| solid.points[v as usize]).collect();
        let triangles = (0..solid.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
        let built = shape(&[hull(split, triangles.collect())], [1.0; 3]).unwrap();
        let built = built.as_convex_polyhedron().unwrap();
        assert_eq!(built.points().len(), solid.points.len());
        for point in built.points() {
            let is_same = |p: &[f64; 3]| p.map(|x| x as f32) == point.to_array();
            assert!(solid.points.iter().any(is_same), "{point}");
        }
    }

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn a_tetrahedron_is_closed() {
        assert!(is_closed(4, &TETRAHEDRON));
    }

    #[test]
    fn holes_turned_triangles_and_wrong_indices_are_not() {
        assert!(!is_closed(4, &TETRAHEDRON[..3]));
        assert!(!is_closed(3, &TETRAHEDRON));
        assert!(!is_closed(0, &[]));
        let mut turned = TETRAHEDRON;
        turned[0].swap(0, 1);
        assert!(!is_closed(4, &turned));
        let mut twice = TETRAHEDRON.to_vec();
        twice.push(twice[0]);
        assert!(!is_closed(4, &twice));
        assert!(!is_closed(4, &[[0, 0, 1]]));
        // Two of them at the edge between vertices 0 and 1, which has four triangles.
        let other = TETRAHEDRON.map(|triangle| triangle.map(|v| if v < 2 { v } else { v + 2 }));
        assert!(is_closed(6, &other));
        assert!(!is_closed(6, &[TETRAHEDRON, other].concat()));
    }
}
