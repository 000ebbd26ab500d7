//! From hulls to the types of one version of Rapier.

/// Writes the conversions for the Rapier at a path of identifiers, such as `rapier3d` or
/// `bevy_rapier3d::rapier`, into the module where it is called. Every version of Rapier from 0.32
/// on speaks glam, so one text serves; but its types are other types in each version.
macro_rules! colliders {
    ($($rapier:ident)::+) => {
        use $($rapier)::+::dynamics::MassProperties as RapierMassProperties;
        use $($rapier)::+::geometry::{ColliderBuilder, SharedShape};
        use $($rapier)::+::parry::math::{Pose, Rotation, Vector};
        use $($rapier)::+::parry::shape::ConvexPolyhedron;

        /// One shape of all hulls, their points multiplied by `scale`: a single convex polyhedron,
        /// or a compound of them. O(n log n) in the vertices.
        ///
        /// Scale is baked into the points, since Parry's own scaling of polyhedra is wrong where
        /// its factors differ; a negative factor mirrors. Should Parry refuse a hull, one without
        /// what stands out by less than 1e-3 of its extent stands in for it, at the last its
        /// bounding box.
        ///
        /// # Errors
        /// [`ColliderError`](crate::ColliderError) says which hull or factor can't be used. It
        /// never panics.
        pub fn shape(
            hulls: &[$crate::Hull],
            scale: [f32; 3],
        ) -> Result<SharedShape, $crate::ColliderError> {
            let hulls = $crate::collider::scaled_hulls(hulls, scale)?;
            if let [(points, triangles)] = hulls.as_slice()
                && let Some(shape) = part(points, triangles)
            {
                return Ok(shape);
            }
            let parts = hulls.iter().map(|(points, triangles)| {
                match part(points, triangles) {
                    Some(shape) => (Pose::IDENTITY, shape),
                    None => bounding_box(points),
                }
            });
            Ok(SharedShape::compound(parts.collect()))
        }

        /// The hull, or if Parry refuses it a slightly simpler one.
        fn part(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<SharedShape> {
            polyhedron(points, triangles).or_else(|| {
                $crate::collider::coarser(points)
                    .find_map(|(points, triangles)| polyhedron(&points, &triangles))
            })
        }

        /// A collider of all hulls with the mass properties of the source mesh, both scaled: see
        /// [`shape`] and [`mass_properties`].
        ///
        /// # Errors
        /// As [`shape`] and [`mass_properties`].
        pub fn collider(
            hulls: &[$crate::Hull],
            properties: &$crate::MassProperties,
            scale: [f32; 3],
        ) -> Result<ColliderBuilder, $crate::ColliderError> {
            let properties = mass_properties(properties, scale)?;
            Ok(ColliderBuilder::new(shape(hulls, scale)?).mass_properties(properties))
        }

        /// The mass properties in Rapier's type, after the body's coordinates are multiplied by
        /// `scale` at the same density.
        ///
        /// # Errors
        /// [`ColliderError::InvalidScale`](crate::ColliderError::InvalidScale), and
        /// [`ColliderError::UnusableMass`](crate::ColliderError::UnusableMass) where a value is
        /// beyond the range of `f32`.
        pub fn mass_properties(
            properties: &$crate::MassProperties,
            scale: [f32; 3],
        ) -> Result<RapierMassProperties, $crate::ColliderError> {
            let body = $crate::collider::RigidMass::new(properties, scale)?;
            Ok(RapierMassProperties::with_principal_inertia_frame(
                Vector::from(body.centre),
                body.mass,
                Vector::from(body.moments),
                Rotation::from_array(body.rotation),
            ))
        }

        /// Nothing where Parry has nothing, or nothing that is safe to use.
        fn polyhedron(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<SharedShape> {
            if !$crate::collider::is_closed(points.len(), triangles) {
                return None;
            }
            let points = points.iter().map(|point| Vector::from(*point)).collect();
            let polyhedron = ConvexPolyhedron::from_convex_mesh(points, triangles)?;
            is_sound(&polyhedron).then(|| SharedShape::new(polyhedron))
        }

        /// Whether the faces that Parry made can be asked for contacts. They are built from
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
    };
}
pub(crate) use colliders;
