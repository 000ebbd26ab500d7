//! A query dispatcher for Rapier whose contacts don't depend on the unit of length, and which drops
//! contacts at the seams of a compound.
//!
//! Parry's search for the closest points of two convex shapes, GJK, compares squared lengths and
//! squared areas with constants: two points nearer than 1.1 mm count as one, and three points that
//! span less than 5.5 cm² as lying on a line. In metres that is the size of what people hold in
//! their hands: a marble is seen too late, or as being inside, and sinks into a bowl. So here the
//! search runs on enlarged shapes. The factor is a power of two, by which coordinates are
//! multiplied without rounding: what changes is how they compare with the constants.

use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::math::{Pose, Real, Vector};
use rapier3d::parry::query::details::{
    ContactManifoldsWorkspace, NormalConstraints, ShapeCastOptions, contact_manifold_pfm_pfm,
    contact_manifolds_composite_shape_composite_shape, contact_manifolds_composite_shape_shape,
};
use rapier3d::parry::query::gjk::VoronoiSimplex;
use rapier3d::parry::query::point::local_point_projection_on_support_map;
use rapier3d::parry::query::{
    ClosestPoints, Contact, ContactManifold, DefaultQueryDispatcher, NonlinearRigidMotion,
    PersistentQueryDispatcher, PointProjection, QueryDispatcher, ShapeCastHit, ShapeDistance,
    ShapeIntersection, TrackedContact, Unsupported,
};
use rapier3d::parry::shape::{
    PackedFeatureId, PolygonalFeature, PolygonalFeatureMap, Shape, ShapeType, SupportMap,
};

use super::seams::{Side, drop_inner_contacts};

/// Computes contacts of convex shapes, alone or in compounds, as well for a thimble as for a house.
///
/// Rapier's own contacts are wrong where shapes of some centimetres meet, in metres: a ball of 8 mm
/// sinks into a bowl of 10 cm, whoever made its hulls. `docs/reliability.md` has a table of sizes
/// and shapes. With this dispatcher in place of Rapier's default, it rolls. It takes effect for all
/// convex polyhedra, cuboids, cylinders, cones and capsules of a world, not only for shapes made by
/// this crate; pairs that Parry computes in closed form (two balls, two cuboids, two capsules, a
/// half space), triangle meshes, height fields and voxels stay Parry's, and so do queries other
/// than contacts. Large shapes get the very contacts that Rapier computes.
///
/// Over the seams between the parts of a compound, as hulls of a decomposition or tiles of a floor,
/// bodies go straight on: contacts with edges and faces that lie inside of the compound are
/// dropped. Put tiles into one compound for that; of colliders of their own nothing is known here.
///
/// ```
/// use hullwright_rapier::ContactDispatcher;
/// use rapier3d::prelude::*;
///
/// let mut world = PhysicsWorld::new();
/// world.narrow_phase = NarrowPhase::with_query_dispatcher(ContactDispatcher);
/// ```
///
/// In Bevy the plugin sets it by itself; a world of one's own takes it with
/// `RapierContextSimulation::set_query_dispatcher`.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactDispatcher;

impl<M, C> PersistentQueryDispatcher<M, C> for ContactDispatcher
where
    M: Default + Clone + Send + Sync,
    C: Default + Copy + Send + Sync,
{
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<ContactManifold<M, C>>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        if is_parrys(g1) || is_parrys(g2) {
            return DefaultQueryDispatcher
                .contact_manifolds(pos12, g1, g2, prediction, manifolds, workspace);
        }
        match (g1.as_composite_shape(), g2.as_composite_shape()) {
            (Some(parts1), Some(parts2)) => contact_manifolds_composite_shape_composite_shape(
                self, pos12, parts1, parts2, prediction, manifolds, workspace,
            ),
            (Some(parts1), None) => contact_manifolds_composite_shape_shape(
                self, pos12, parts1, g2, prediction, manifolds, workspace, false,
            ),
            (None, Some(parts2)) => contact_manifolds_composite_shape_shape(
                self,
                &pos12.inverse(),
                parts2,
                g1,
                prediction,
                manifolds,
                workspace,
                true,
            ),
            (None, None) => {
                manifolds.resize_with(manifolds.len().max(1), ContactManifold::new);
                if let Some(manifold) = manifolds.first_mut() {
                    return self.contact_manifold_convex_convex(
                        pos12, g1, g2, None, None, prediction, manifold,
                    );
                }
            }
        }
        for (side, shape, other) in [(Side::First, g1, g2), (Side::Second, g2, g1)] {
            if let Some(compound) = shape.as_compound() {
                drop_inner_contacts(compound, other, side, manifolds);
            }
        }
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        normal_constraints1: Option<&dyn NormalConstraints>,
        normal_constraints2: Option<&dyn NormalConstraints>,
        prediction: Real,
        manifold: &mut ContactManifold<M, C>,
    ) -> Result<(), Unsupported> {
        let pair = Pair { shape1: g1, shape2: g2, pos12: *pos12, prediction };
        let forbidden = [normal_constraints1, normal_constraints2];
        let done = match (g1.shape_type(), g2.shape_type()) {
            (ShapeType::Ball, ShapeType::Ball)
            | (ShapeType::Cuboid, ShapeType::Cuboid)
            | (ShapeType::Capsule, ShapeType::Capsule)
            | (ShapeType::HalfSpace, _)
            | (_, ShapeType::HalfSpace) => false,
            // Parry corrects a constrained normal by a ray that it casts.
            (ShapeType::Ball, _) | (_, ShapeType::Ball)
                if normal_constraints1.is_some() || normal_constraints2.is_some() =>
            {
                false
            }
            (ShapeType::Ball, _) => pair.flipped().contact_of_ball(manifold, true),
            (_, ShapeType::Ball) => pair.contact_of_ball(manifold, false),
            _ => pair.contacts_of_faces(forbidden, manifold),
        };
        if done {
            return Ok(());
        }
        DefaultQueryDispatcher.contact_manifold_convex_convex(
            pos12,
            g1,
            g2,
            normal_constraints1,
            normal_constraints2,
            prediction,
            manifold,
        )
    }
}

/// Whether Parry computes all contacts of a shape by means of its own.
fn is_parrys(shape: &dyn Shape) -> bool {
    matches!(shape.shape_type(), ShapeType::TriMesh | ShapeType::HeightField | ShapeType::Voxels)
}

/// All but contacts is left to Parry.
impl QueryDispatcher for ContactDispatcher {
    fn intersection_test(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        DefaultQueryDispatcher.intersection_test(pos12, g1, g2)
    }

    fn distance(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
    ) -> Result<ShapeDistance, Unsupported> {
        DefaultQueryDispatcher.distance(pos12, g1, g2)
    }

    fn contact(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        DefaultQueryDispatcher.contact(pos12, g1, g2, prediction)
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        max_dist: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        DefaultQueryDispatcher.closest_points(pos12, g1, g2, max_dist)
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        local_vel12: Vector,
        g1: &dyn Shape,
        g2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        DefaultQueryDispatcher.cast_shapes(pos12, local_vel12, g1, g2, options)
    }

    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        g1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        g2: &dyn Shape,
        start_time: Real,
        end_time: Real,
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        DefaultQueryDispatcher.cast_shapes_nonlinear(
            motion1,
            g1,
            motion2,
            g2,
            start_time,
            end_time,
            stop_at_penetration,
        )
    }
}

/// Two convex shapes whose contacts are computed.
#[derive(Clone, Copy)]
struct Pair<'a> {
    pub shape1: &'a dyn Shape,
    pub shape2: &'a dyn Shape,
    /// The pose of the second in the frame of the first.
    pub pos12: Pose,
    /// Contacts this far apart count.
    pub prediction: Real,
}

impl Pair<'_> {
    fn flipped(self) -> Self {
        Self {
            shape1: self.shape2,
            shape2: self.shape1,
            pos12: self.pos12.inverse(),
            prediction: self.prediction,
        }
    }

    /// Finds the contacts of shapes with faces, where directions of the normal may be forbidden on
    /// either side. False where a shape has no faces, or is large enough for Parry.
    fn contacts_of_faces<M: Default, C: Default + Copy>(
        &self,
        forbidden: [Option<&dyn NormalConstraints>; 2],
        manifold: &mut ContactManifold<M, C>,
    ) -> bool {
        let (Some((map1, border1)), Some((map2, border2))) =
            (self.shape1.as_polygonal_feature_map(), self.shape2.as_polygonal_feature_map())
        else {
            return false;
        };
        // What is searched is the difference of both shapes, as large as the larger one.
        let [factor1, factor2] =
            [self.shape1, self.shape2].map(|shape| factor(&shape.compute_local_aabb()));
        let factor = factor1.min(factor2);
        if factor <= 1.0 {
            return false;
        }
        // The contacts of the last step are updated where they still hold.
        scale_manifold(manifold, factor);
        contact_manifold_pfm_pfm(
            &Pose { translation: self.pos12.translation * factor, ..self.pos12 },
            &Scaled { shape: map1, factor },
            border1 * factor,
            forbidden[0],
            &Scaled { shape: map2, factor },
            border2 * factor,
            forbidden[1],
            self.prediction * factor,
            manifold,
        );
        scale_manifold(manifold, factor.recip());
        true
    }

    /// Finds the contact of a polyhedron with a ball, the second shape; `flipped` where the
    /// manifold names the ball first. False for other shapes, or where the polyhedron is large
    /// enough for Parry.
    fn contact_of_ball<M, C: Default + Copy>(
        &self,
        manifold: &mut ContactManifold<M, C>,
        flipped: bool,
    ) -> bool {
        let (Some(polyhedron), Some(ball)) =
            (self.shape1.as_convex_polyhedron(), self.shape2.as_ball())
        else {
            return false;
        };
        let factor = factor(&polyhedron.local_aabb());
        if factor <= 1.0 {
            return false;
        }
        let centre = self.pos12.translation;
        let projection = local_point_projection_on_support_map(
            &Scaled { shape: polyhedron, factor },
            &mut VoronoiSimplex::new(),
            centre * factor,
            false,
        );
        let (outward, distance) = outward_and_distance(centre * factor, &projection);
        let distance = distance / factor - ball.radius;
        if distance > self.prediction {
            manifold.clear();
            return true;
        }
        let inward2 = self.pos12.rotation.inverse() * -outward;
        let contact = TrackedContact::flipped(
            projection.point / factor,
            inward2 * ball.radius,
            polyhedron.support_feature_id_toward(outward).into(),
            PackedFeatureId::face(0),
            distance,
            flipped,
        );
        // Where there is one contact as before, its impulse is where the solver starts.
        if let [point] = manifold.points.as_mut_slice() {
            point.copy_geometry_from(contact);
        } else {
            manifold.clear();
            manifold.points.push(contact);
        }
        let normals = if flipped { (inward2, outward) } else { (outward, inward2) };
        (manifold.local_n1, manifold.local_n2) = normals;
        true
    }
}

/// The direction out of the shape at the projection of a point, and the point's distance, negative
/// inside.
fn outward_and_distance(point: Vector, projection: &PointProjection) -> (Vector, Real) {
    let off = point - projection.point;
    let length = off.length();
    let direction = if length > 0.0 { off / length } else { point.normalize_or(Vector::Y) };
    if projection.is_inside { (-direction, -length) } else { (direction, length) }
}

/// Shapes are enlarged to an extent of 2 to this power, in Parry's unit: 16. Its tolerances are 1
/// mm and 5 cm² there; beyond this size the rounding of `f32` exceeds them.
const EXTENT_EXPONENT: i32 = 4;

/// No extent is multiplied by more than 2 to this power, so that nothing overflows.
const LARGEST_EXPONENT: i32 = 60;

/// The power of two that enlarges a box to the extent above, give or take a factor of two. Large
/// shapes are not made smaller: details that are far above the tolerances would fall below.
fn factor(bounds: &Aabb) -> Real {
    let extent = (bounds.maxs - bounds.mins).max_element();
    if !(extent.is_normal() && extent > 0.0) {
        return 1.0;
    }
    let exponent = EXTENT_EXPONENT - exponent(extent);
    Real::from_bits(((exponent.clamp(0, LARGEST_EXPONENT) + BIAS) as u32) << MANTISSA_BITS)
}

/// The logarithm to base 2, rounded down. Read off the bits, since `log2` may differ between
/// platforms.
fn exponent(positive: Real) -> i32 {
    (positive.to_bits() >> MANTISSA_BITS) as i32 - BIAS
}

/// The format of `f32`.
const MANTISSA_BITS: u32 = Real::MANTISSA_DIGITS - 1;
const BIAS: i32 = Real::MAX_EXP - 1;

/// A shape, larger by a factor.
struct Scaled<'a, S: ?Sized> {
    shape: &'a S,
    factor: Real,
}

impl<S: ?Sized + SupportMap> SupportMap for Scaled<'_, S> {
    fn local_support_point(&self, dir: Vector) -> Vector {
        self.shape.local_support_point(dir) * self.factor
    }

    fn local_support_point_toward(&self, dir: Vector) -> Vector {
        self.shape.local_support_point_toward(dir) * self.factor
    }
}

impl<S: ?Sized + PolygonalFeatureMap> PolygonalFeatureMap for Scaled<'_, S> {
    fn local_support_feature(&self, dir: Vector, out_feature: &mut PolygonalFeature) {
        self.shape.local_support_feature(dir, out_feature);
        out_feature.vertices = out_feature.vertices.map(|vertex| vertex * self.factor);
    }

    fn local_support_feature_toward(
        &self,
        dir: Vector,
        hint: Vector,
        out_feature: &mut PolygonalFeature,
    ) {
        self.shape.local_support_feature_toward(dir, hint / self.factor, out_feature);
        out_feature.vertices = out_feature.vertices.map(|vertex| vertex * self.factor);
    }

    fn is_convex_polyhedron(&self) -> bool {
        self.shape.is_convex_polyhedron()
    }
}

/// Multiplies the lengths in a manifold.
fn scale_manifold<M, C>(manifold: &mut ContactManifold<M, C>, factor: Real) {
    for point in &mut manifold.points {
        point.local_p1 *= factor;
        point.local_p2 *= factor;
        point.dist *= factor;
    }
}
