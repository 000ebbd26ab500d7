//! Rapier, by bevy_rapier3d.

#[cfg(feature = "bevy_gltf")]
mod declared;
mod hold;

use bevy::ecs::query::QueryData;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel};
use bevy::ecs::system::EntityCommands;
use bevy::prelude::*;
use bevy_rapier3d::plugin::PhysicsSet;
use bevy_rapier3d::plugin::context::RapierContextSimulation;
use bevy_rapier3d::prelude::{
    self as dynamics, ActiveCollisionTypes, ActiveEvents, ActiveHooks, Ccd, Collider,
    ColliderMassProperties, ColliderScale, CollisionEvent, CollisionGroups,
    ContactForceEventThreshold, ContactSkin, Damping, Dominance, Friction, GravityScale,
    RapierColliderHandle, RapierContextColliders, RapierContextEntityLink, RapierRigidBodyHandle,
    RapierRigidBodySet, Restitution, RigidBody, Sensor, Sleeping, SoftCcd, SolverGroups,
};
#[cfg(feature = "bevy_gltf")]
use hullwright_formats::conventions::{BodyMotion, SurfaceProperties};
use hullwright_parry::parry3d::mass_properties::MassProperties;
use hullwright_parry::parry3d::shape::SharedShape;
use hullwright_rapier::ContactDispatcher;

use super::{Engine, Item, Motion, Velocity, Weight, run_before};
use crate::tag::settings::{HullwrightSettings, HullwrightSystems};

/// bevy_rapier3d 0.37.
pub(crate) struct Rapier;

/// The mass properties that the plugin gave an entity. Other ones are the game's own, and stay. A
/// save has both.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[type_path = "hullwright"]
pub(crate) struct OwnMass(pub ColliderMassProperties);

/// What an entity has of a collider and its mass.
#[derive(QueryData)]
pub(crate) struct Made {
    collider: Option<&'static Collider>,
    scale: Option<&'static ColliderScale>,
    mass: Option<&'static ColliderMassProperties>,
    own_mass: Option<&'static OwnMass>,
}

/// Shapes are shared as they are.
#[derive(Resource, Default)]
pub(crate) struct NoCache;

surface! {
    friction: Friction,
    restitution: Restitution,
    collision_groups: CollisionGroups,
    solver_groups: SolverGroups,
    sensor: Sensor,
    active_events: ActiveEvents,
    active_hooks: ActiveHooks,
    active_collision_types: ActiveCollisionTypes,
    contact_force_threshold: ContactForceEventThreshold,
    contact_skin: ContactSkin,
}

impl Engine for Rapier {
    type Body = RigidBody;
    type Collider = Collider;
    type Sensor = Sensor;
    type Mass = ColliderMassProperties;
    type Cache = NoCache;
    type Made = Made;
    type Surface = Surface;

    /// The scale is in the points, and bevy_rapier multiplies offsets up to the body's scale.
    const SCALES_COLLIDERS: bool = false;

    const WITHOUT_BODY: Option<&str> = None;

    const BODIES_FALL_WITHOUT_MASS: bool = false;

    fn build(app: &mut App) {
        app.register_type::<OwnMass>();
        run_before(app, PhysicsSet::SyncBackend, Self::fixed_steps());
        app.add_systems(PostUpdate, set_dispatcher.in_set(HullwrightSystems::DetectChanges));
        hold::hold_in(app, PostUpdate);
        hold::hold_in(app, FixedUpdate);
    }

    /// Rapier may run in another schedule.
    fn finish(app: &mut App) {
        if !app.world().contains_resource::<Messages<CollisionEvent>>() {
            log::warn!(
                "RapierPhysicsPlugin is missing: colliders are made, but nothing moves or collides"
            );
        }
        let known = [PostUpdate.intern(), FixedUpdate.intern()];
        let all = app.world().resource::<Schedules>().iter().map(|(_, schedule)| schedule);
        let steps = |of: &&Schedule| of.graph().system_sets.contains(PhysicsSet::StepSimulation);
        let others: Vec<InternedScheduleLabel> =
            all.filter(steps).map(Schedule::label).filter(|label| !known.contains(label)).collect();
        others.into_iter().for_each(|schedule| hold::hold_in(app, schedule));
    }

    fn fixed_steps() -> InternedScheduleLabel {
        FixedUpdate.intern()
    }

    fn motion(body: &RigidBody) -> Motion {
        match body {
            RigidBody::Dynamic => Motion::Dynamic,
            RigidBody::Fixed => Motion::Fixed,
            RigidBody::KinematicPositionBased | RigidBody::KinematicVelocityBased => {
                Motion::Kinematic
            }
        }
    }

    fn body(motion: Motion) -> RigidBody {
        match motion {
            Motion::Dynamic => RigidBody::Dynamic,
            Motion::Fixed => RigidBody::Fixed,
            Motion::Kinematic => RigidBody::KinematicPositionBased,
        }
    }

    fn present<'a>(made: &'a Item<'_, '_, Made>) -> Option<&'a Collider> {
        made.collider
    }

    fn is_left(made: &Item<'_, '_, Made>) -> bool {
        matches!(made.scale, Some(ColliderScale::Relative(_)))
    }

    fn owns_mass(made: &Item<'_, '_, Made>) -> bool {
        made.mass.is_none_or(|present| made.own_mass.is_some_and(|own| own.0 == *present))
    }

    fn collider(shape: &SharedShape, _: Vec3, _: &mut NoCache) -> Collider {
        Collider::from(shape.clone())
    }

    fn unscaled(collider: &Collider) -> &SharedShape {
        &collider.raw
    }

    fn attach(entity: &mut EntityCommands, collider: Collider) {
        // bevy_rapier must not apply the scale again.
        entity.try_insert((collider, ColliderScale::Absolute(Vec3::ONE)));
    }

    /// Rapier's own collider is written to: where bevy_rapier sees a change it computes the volume
    /// and the density anew, which takes twice as long as to scale.
    fn replace(
        entity: &mut EntityCommands,
        collider: Collider,
        mass: Option<ColliderMassProperties>,
    ) {
        entity
            .queue_silenced(move |mut entity: EntityWorldMut| replace(&mut entity, collider, mass));
    }

    fn remove_collider(entity: &mut EntityCommands) {
        entity.try_remove::<(Collider, ColliderScale)>();
    }

    /// bevy_rapier scales it by what comes on top of what is in the points.
    fn leave(entity: &mut EntityCommands, scale: Option<Vec3>) {
        if let Some(scale) = scale {
            entity.try_insert(ColliderScale::Relative(scale.recip()));
        }
    }

    fn mass(properties: MassProperties) -> ColliderMassProperties {
        let properties = dynamics::MassProperties::from_rapier(properties);
        ColliderMassProperties::MassProperties(properties)
    }

    fn mass_by_volume(_: &SharedShape, weight: Weight) -> ColliderMassProperties {
        match weight.mass {
            Some(mass) => ColliderMassProperties::Mass(mass),
            None => ColliderMassProperties::Density(weight.density),
        }
    }

    fn set_mass(entity: &mut EntityCommands, mass: ColliderMassProperties) {
        entity.try_insert((mass, OwnMass(mass)));
    }

    fn remove_mass(entity: &mut EntityCommands) {
        entity.try_remove::<(ColliderMassProperties, OwnMass)>();
    }

    fn inherit(
        own: &Item<'_, '_, Surface>,
        from: &[Item<'_, '_, Surface>],
        to: &mut EntityCommands,
    ) {
        inherit(own, from, to);
    }

    fn has_surface(own: &Item<'_, '_, Surface>) -> bool {
        has_surface(own)
    }

    fn copy_surface(entity: &mut EntityCommands, to: Entity) {
        copy_surface(entity, to);
    }

    fn copy_dynamics(body: &mut EntityCommands, to: Entity) {
        body.clone_with_opt_in(to, |builder| {
            builder.allow::<(Ccd, Damping, Dominance, GravityScale, SoftCcd)>();
        });
    }

    fn velocity(world: &World, body: Entity) -> Velocity {
        let in_rapier = |entity: EntityRef| {
            let handle = entity.get::<RapierRigidBodyHandle>()?.0;
            let context = entity.get::<RapierContextEntityLink>()?.0;
            let body = world.get::<RapierRigidBodySet>(context)?.bodies.get(handle)?;
            let centre = body.center_of_mass();
            Some(Velocity { linear: body.linvel(), angular: body.angvel(), centre })
        };
        world.get_entity(body).ok().and_then(in_rapier).unwrap_or_default()
    }

    fn set_velocity(entity: &mut EntityCommands, Velocity { linear, angular, .. }: Velocity) {
        entity.try_insert(dynamics::Velocity { linear, angular });
    }

    fn wake(commands: &mut Commands, body: Entity) {
        let Ok(mut body) = commands.get_entity(body) else { return };
        body.queue_silenced(|mut body: EntityWorldMut| wake(&mut body));
    }

    #[cfg(feature = "bevy_gltf")]
    fn insert_surface(entity: &mut EntityCommands, surface: &SurfaceProperties) {
        declared::insert_surface(entity, surface);
    }

    /// bevy_rapier takes the signs of a scale into sizes.
    #[cfg(feature = "bevy_gltf")]
    fn attach_declared(entity: &mut EntityCommands, shape: SharedShape, scale: Vec3) {
        entity.try_insert(Collider::from(shape));
        if scale.min_element() < 0.0 {
            entity.try_insert(ColliderScale::Absolute(scale.abs()));
        }
    }

    #[cfg(feature = "bevy_gltf")]
    fn body_of_constant_velocity() -> RigidBody {
        RigidBody::KinematicVelocityBased
    }

    #[cfg(feature = "bevy_gltf")]
    fn insert_gravity(entity: &mut EntityCommands, factor: f32) {
        entity.try_insert_if_new(GravityScale(factor));
    }

    #[cfg(feature = "bevy_gltf")]
    fn set_declared_mass(
        body: &mut EntityWorldMut,
        declared: &BodyMotion,
        colliders: &[Entity],
    ) -> bool {
        declared::set_mass(body, declared, colliders).is_some()
    }
}

fn replace(
    entity: &mut EntityWorldMut,
    replacement: Collider,
    mass: Option<ColliderMassProperties>,
) {
    let id = entity.id();
    let in_rapier = entity.get_components::<(&RapierColliderHandle, &RapierContextEntityLink)>();
    let in_rapier = in_rapier.ok().map(|(handle, context)| (handle.0, context.0));
    let is_written = in_rapier.is_some_and(|(handle, context)| {
        entity
            .world_scope(|world| {
                let mut set = world.get_mut::<RapierContextColliders>(context)?;
                // A clone may have the handle of the original.
                set.collider_entity(handle).filter(|of| *of == id)?;
                let collider = set.colliders.get_mut(handle)?;
                collider.set_shape(replacement.raw.clone());
                if let Some(ColliderMassProperties::MassProperties(properties)) = mass {
                    collider.set_mass_properties(properties.into_rapier());
                }
                Some(())
            })
            .is_some()
    });
    if let Some(mut collider) = entity.get_mut::<Collider>() {
        match is_written {
            true => *collider.bypass_change_detection() = replacement,
            false => *collider = replacement,
        }
    }
    if let Some(mass) = mass {
        if let Some(mut own) = entity.get_mut::<OwnMass>() {
            own.0 = mass;
        }
        if let Some(mut present) = entity.get_mut::<ColliderMassProperties>() {
            match is_written {
                true => *present.bypass_change_detection() = mass,
                false => *present = mass,
            }
        }
    }
}

/// Bodies sleep with and without the component.
fn wake(body: &mut EntityWorldMut) {
    if let Some(mut sleeping) = body.get_mut::<Sleeping>()
        && sleeping.sleeping
    {
        sleeping.sleeping = false;
    }
    let in_rapier = body.get_components::<(&RapierRigidBodyHandle, &RapierContextEntityLink)>();
    let Ok((handle, context)) = in_rapier.map(|(handle, context)| (handle.0, context.0)) else {
        return;
    };
    body.world_scope(|world| {
        if let Some(mut set) = world.get_mut::<RapierRigidBodySet>(context)
            && let Some(body) = set.bodies.get_mut(handle)
            && body.is_sleeping()
        {
            body.wake_up(true);
        }
    });
}

/// Sets the dispatcher of each new world, for contacts that don't depend on the unit of length.
/// Before the first step a world has no contacts to lose.
fn set_dispatcher(
    settings: Res<HullwrightSettings>,
    mut worlds: Query<&mut RapierContextSimulation, Added<RapierContextSimulation>>,
) {
    if settings.contact_dispatcher {
        for mut world in &mut worlds {
            world.narrow_phase.set_query_dispatcher(ContactDispatcher);
        }
    }
}
