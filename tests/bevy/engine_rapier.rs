//! What the tests say of a physics engine, in Rapier's words.

use bevy::ecs::system::RunSystemOnce;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;
pub use bevy_rapier3d::prelude::{
    Collider, CollisionGroups as Layers, Friction, GravityScale, LockedAxes, RigidBody, Sensor,
};
use bevy_rapier3d::rapier::geometry::SharedShape;

use crate::app::*;

pub const FIXED: RigidBody = RigidBody::Fixed;
pub const KINEMATIC: RigidBody = RigidBody::KinematicPositionBased;

pub const KINEMATIC_BY_VELOCITY: RigidBody = RigidBody::KinematicVelocityBased;

/// Steps with every frame.
pub fn physics() -> impl Plugin {
    RapierPhysicsPlugin::<NoUserData>::default()
}

/// In fixed steps of 1/60 s.
pub fn add_physics_in_fixed_steps(app: &mut App) {
    app.add_plugins(RapierPhysicsPlugin::<NoUserData>::default().in_fixed_schedule());
    app.insert_resource(TimestepMode::Fixed { dt: 1.0 / 60.0, substeps: 1 });
}

/// What the log names where it is missing.
pub const PHYSICS_PLUGIN: &str = "RapierPhysicsPlugin is missing";

pub fn hullwright(settings: HullwrightSettings) -> HullwrightPlugin {
    HullwrightPlugin { settings, engine: PhysicsEngine::Rapier }
}

/// The shape as the engine has it, scaled.
pub fn shape(collider: &Collider) -> &SharedShape {
    &collider.raw
}

pub fn ball(radius: f32) -> Collider {
    Collider::ball(radius)
}

/// By half of its sides.
pub fn cuboid_collider(x: f32, y: f32, z: f32) -> Collider {
    Collider::cuboid(x, y, z)
}

/// That of the game itself.
pub fn friction(coefficient: f32) -> Friction {
    Friction::coefficient(coefficient)
}

pub fn velocity(linear: Vec3, angular: Vec3) -> impl Bundle {
    Velocity { linear, angular }
}

pub fn linear_velocity(app: &App, body: Entity) -> Vec3 {
    app.get::<Velocity>(body).unwrap().linear
}

/// Linear and angular.
pub fn velocities(app: &App, body: Entity) -> (Vec3, Vec3) {
    let Velocity { linear, angular } = app.get::<Velocity>(body).unwrap();
    (*linear, *angular)
}

pub fn set_linear_velocity(body: &mut EntityWorldMut, linear: Vec3) {
    match body.get_mut::<Velocity>() {
        Some(mut velocity) => velocity.linear = linear,
        None => _ = body.insert(Velocity::linear(linear)),
    }
}

/// What the engine itself moves a body with.
pub fn velocity_in_engine(app: &App, body: Entity) -> Vec3 {
    let handle = app.get::<RapierRigidBodyHandle>(body).expect("a body").0;
    let context = app.get::<RapierContextEntityLink>(body).expect("a body").0;
    let set = app.get::<RapierRigidBodySet>(context).expect("a world");
    set.bodies.get(handle).expect("a body").linvel()
}

/// Without any, a body does not fall.
pub fn mass_of_body(mass: f32) -> impl Bundle {
    AdditionalMassProperties::Mass(mass)
}

/// Those of a collider, set by the game.
pub fn games_mass(mass: f32) -> impl Bundle {
    ColliderMassProperties::Mass(mass)
}

pub fn density(density: f32) -> impl Bundle {
    ColliderMassProperties::Density(density)
}

pub fn has_games_mass(app: &App, entity: Entity, mass: f32) -> bool {
    app.get::<ColliderMassProperties>(entity) == Some(&ColliderMassProperties::Mass(mass))
}

pub fn has_mass(app: &App, entity: Entity) -> bool {
    app.get::<ColliderMassProperties>(entity).is_some()
}

/// The mass properties of an entity's collider, which come from its mesh.
pub fn mass(app: &App, entity: Entity) -> MassOf {
    match app.get::<ColliderMassProperties>(entity) {
        Some(ColliderMassProperties::MassProperties(of)) => {
            MassOf { mass: of.mass, centre: of.local_center_of_mass, moments: of.principal_inertia }
        }
        other => panic!("no mass properties: {other:?}"),
    }
}

/// The same of whatever kind; `None` without any.
pub fn some_mass(app: &App, entity: Entity) -> Option<f32> {
    Some(match app.get::<ColliderMassProperties>(entity)? {
        ColliderMassProperties::MassProperties(of) => of.mass,
        ColliderMassProperties::Mass(number) | ColliderMassProperties::Density(number) => *number,
    })
}

/// Mass and centre of a body, all its colliders together.
pub fn mass_of_whole(app: &mut App, body: Entity) -> (f32, Vec3) {
    let world = app.world_mut();
    let handle = world.get::<RapierRigidBodyHandle>(body).unwrap().0;
    let set = world.query::<&RapierRigidBodySet>().single(world).unwrap();
    let body = &set.bodies[handle];
    (body.mass(), body.mass_properties().local_mprops.local_com)
}

pub fn locked_along_z() -> LockedAxes {
    LockedAxes::TRANSLATION_LOCKED_Z
}

/// What colliders inherit beside friction and layers.
pub fn surface() -> impl Bundle {
    (
        Restitution::coefficient(0.4),
        SolverGroups::new(Group::GROUP_4, Group::GROUP_5),
        ActiveEvents::COLLISION_EVENTS,
        ActiveHooks::FILTER_CONTACT_PAIRS,
        ActiveCollisionTypes::all(),
        ContactForceEventThreshold(7.0),
        ContactSkin(0.01),
    )
}

pub fn has_surface(app: &App, entity: Entity) -> bool {
    app.get(entity) == Some(&Restitution::coefficient(0.4))
        && app.get(entity) == Some(&SolverGroups::new(Group::GROUP_4, Group::GROUP_5))
        && app.get(entity) == Some(&ActiveEvents::COLLISION_EVENTS)
        && app.get(entity) == Some(&ActiveHooks::FILTER_CONTACT_PAIRS)
        && app.get(entity) == Some(&ActiveCollisionTypes::all())
        && app.get::<ContactForceEventThreshold>(entity).is_some_and(|least| least.0 == 7.0)
        && app.get::<ContactSkin>(entity).is_some_and(|skin| skin.0 == 0.01)
}

/// The sets of the engine's systems before and after its step.
pub const BEFORE: PhysicsSet = PhysicsSet::SyncBackend;
pub const AFTER: PhysicsSet = PhysicsSet::Writeback;

pub fn is_locked_along_z(app: &App, body: Entity) -> bool {
    app.get::<LockedAxes>(body) == Some(&locked_along_z())
}

pub fn clone_of(app: &mut App, entity: Entity) -> Entity {
    app.edit(entity).clone_and_spawn()
}

/// Rapier's plugin has registered all that a save needs.
pub fn register_for_saves(_: &mut App) {}

/// Whether a collider may come below another entity without harm.
pub const ALLOWS_OTHER_PARENTS: bool = true;

/// Whether entities may be disabled without harm.
pub const ALLOWS_DISABLING: bool = true;

/// Whether a fixed body may have a scale of zero for a while.
pub const ALLOWS_SCALE_ZERO: bool = true;

/// How fast contacts of small things push what does not touch, in metres per second.
pub const PUSHES: f32 = 0.0;

/// Meets nothing.
pub fn alone() -> Layers {
    CollisionGroups::new(Group::NONE, Group::NONE)
}

/// No default.
pub fn layers() -> Layers {
    CollisionGroups::new(Group::GROUP_2, Group::GROUP_3)
}

pub fn asleep() -> impl Bundle {
    Sleeping { sleeping: true, ..default() }
}

pub fn is_asleep(app: &App, body: Entity) -> bool {
    app.get::<Sleeping>(body).unwrap().sleeping
}

/// A collider's place in the world and its shape, as the engine has them after a step.
pub fn in_engine(app: &mut App, entity: Entity) -> (Affine3A, SharedShape) {
    let world = app.world_mut();
    let handle = world.get::<RapierColliderHandle>(entity).unwrap().0;
    let set = world.query::<&RapierContextColliders>().single(world).unwrap();
    let collider = &set.colliders[handle];
    let pose = collider.position();
    let place = Affine3A::from_rotation_translation(pose.rotation, pose.translation);
    (place, collider.shared_shape().clone())
}

/// The collider that a ray downward meets, and which of its subshapes.
pub fn below(app: &mut App, from: Vec3) -> Option<(Entity, u32)> {
    let cast = move |context: ReadRapierContext| {
        let context = context.single().unwrap();
        let solid = QueryFilter::default();
        let hit = context.cast_ray_and_get_normal(from, Vec3::NEG_Y, 100.0, true, solid);
        hit.map(|(entity, hit)| (entity, hit.subshape))
    };
    app.world_mut().run_system_once(cast).unwrap()
}

/// The body that an entity's collider belongs to.
pub fn body_in_engine(app: &mut App, entity: Entity) -> Option<Entity> {
    let world = app.world_mut();
    let collider = world.get::<RapierColliderHandle>(entity)?.0;
    let set = world.query::<&RapierContextColliders>().single(world).unwrap();
    let parent = set.colliders[collider].parent()?;
    let mut bodies = world.query::<(Entity, &RapierRigidBodyHandle)>();
    bodies.iter(world).find(|(_, handle)| handle.0 == parent).map(|(entity, _)| entity)
}

/// Bodies and colliders that the engine holds.
pub fn held_by_engine(app: &mut App) -> (usize, usize) {
    let world = app.world_mut();
    let (bodies, colliders) =
        world.query::<(&RapierRigidBodySet, &RapierContextColliders)>().single(world).unwrap();
    (bodies.bodies.len(), colliders.colliders.len())
}

fn rule_name(rule: CoefficientCombineRule) -> String {
    format!("{rule:?}").to_lowercase()
}

/// The coefficient of sliding, and the rule's name.
pub fn friction_of(app: &App, entity: Entity) -> Option<(f32, String)> {
    let friction = app.get::<Friction>(entity)?;
    Some((friction.coefficient, rule_name(friction.combine_rule)))
}

pub fn restitution_of(app: &App, entity: Entity) -> Option<(f32, String)> {
    let restitution = app.get::<Restitution>(entity)?;
    Some((restitution.coefficient, rule_name(restitution.combine_rule)))
}

/// Memberships and filters.
pub fn groups_of(app: &App, entity: Entity) -> Option<(u32, u32)> {
    app.get::<CollisionGroups>(entity).map(|of| (of.memberships.bits(), of.filters.bits()))
}

pub fn sends_collisions(app: &App, entity: Entity) -> bool {
    app.get::<ActiveEvents>(entity) == Some(&ActiveEvents::COLLISION_EVENTS)
}

/// The distance by which it counts as larger.
pub fn skin_of(app: &App, entity: Entity) -> Option<f32> {
    app.get::<ContactSkin>(entity).map(|skin| skin.0)
}

/// The angular velocity of a body in the engine.
pub fn angular_velocity(app: &App, body: Entity) -> Vec3 {
    app.get::<Velocity>(body).unwrap().angular
}
