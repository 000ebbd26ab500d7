//! A query dispatcher for Rapier whose contacts don't depend on the unit of length, and which drops contacts at
//! the seams of a compound.
//!
//! Parry's search for the closest points of two convex shapes, GJK, compares squared lengths and
//! squared areas with constants: two points nearer than 1.1 mm count as one, and three points that
//! span less than 5.5 cm² as lying on a line. In metres that is the size of what people hold in
//! their hands: a marble is seen too late, or as being inside, and sinks into a bowl. So here the
//! search runs on enlarged shapes. The factor is a power of two, by which coordinates are
//! multiplied without rounding: what changes is how they compare with the constants.

mod scaled;
mod seams;

use rapier3d::parry::math::{Pose, Real, Vector};
use rapier3d::parry::query::details::{
    ContactManifoldsWorkspace, NormalConstraints, ShapeCastOptions,
    contact_manifolds_composite_shape_composite_shape, contact_manifolds_composite_shape_shape,
};
use rapier3d::parry::query::{
    ClosestPoints, Contact, ContactManifold, DefaultQueryDispatcher, NonlinearRigidMotion,
    PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit, ShapeDistance, ShapeIntersection,
    Unsupported,
};
use rapier3d::parry::shape::{Shape, ShapeType};

use self::scaled::Pair;
use self::seams::{Side, drop_inner_contacts};

/// Computes contacts of convex shapes, alone or in compounds, as well for a thimble as for a house.
///
/// Rapier's own contacts are wrong where shapes of some centimetres meet, in metres: a ball of
/// 8 mm sinks into a bowl of 10 cm, whoever made its hulls. `docs/reliability.md` has a table of sizes
/// and shapes. With this dispatcher in place of Rapier's default, it rolls. It takes effect for all
/// convex polyhedra, cuboids, cylinders, cones and capsules of a world, not only for shapes made by this
/// crate; pairs that Parry computes in closed form (two balls, two cuboids, two capsules, a half
/// space), triangle meshes, height fields and voxels stay Parry's, and so do queries other than
/// contacts. Large shapes get the very contacts that Rapier computes.
///
/// Over the seams between the parts of a compound, as hulls of a decomposition or tiles of a floor, bodies
/// go straight on: contacts with edges and faces that lie inside of the compound are dropped. Put tiles
/// into one compound for that; of colliders of their own nothing is known here.
///
/// ```
/// use hullwright::rapier::ContactDispatcher;
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
