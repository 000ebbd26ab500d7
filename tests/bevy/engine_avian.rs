//! What the tests say of a physics engine, in Avian's words.

use avian3d::collider_tree::ColliderTrees;
use avian3d::dynamics::solver::solver_body::{SolverBodies, SolverBodyIndex};
use avian3d::parry::shape::SharedShape;
use avian3d::prelude::*;
pub use avian3d::prelude::{
    Collider, CollisionLayers as Layers, Friction, GravityScale, LockedAxes, RigidBody, Sensor,
};
use bevy::ecs::system::RunSystemOnce;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;

pub const FIXED: RigidBody = RigidBody::Static;
pub const KINEMATIC: RigidBody = RigidBody::Kinematic;

/// Avian has one kind for both.
pub const KINEMATIC_BY_VELOCITY: RigidBody = RigidBody::Kinematic;

/// Steps with every frame.
pub fn physics() -> impl PluginGroup {
    PhysicsPlugins::new(PostUpdate)
}

/// In fixed steps of 1/60 s.
pub fn add_physics_in_fixed_steps(app: &mut App) {
    app.add_plugins(PhysicsPlugins::default());
    app.insert_resource(Time::<Fixed>::from_hz(60.0));
}

/// What the log names where it is missing.
pub const PHYSICS_PLUGIN: &str = "PhysicsPlugins are missing";

pub fn hullwright(settings: HullwrightSettings) -> HullwrightPlugin {
    HullwrightPlugin { settings, engine: PhysicsEngine::Avian }
}

/// The shape as the engine has it, scaled.
pub fn shape(collider: &Collider) -> &SharedShape {
    collider.shape_scaled()
}

pub fn ball(radius: f32) -> Collider {
    Collider::sphere(radius)
}

/// By half of its sides.
pub fn cuboid_collider(x: f32, y: f32, z: f32) -> Collider {
    Collider::cuboid(2.0 * x, 2.0 * y, 2.0 * z)
}

/// That of the game itself.
pub fn friction(coefficient: f32) -> Friction {
    Friction::new(coefficient)
}

pub fn velocity(linear: Vec3, angular: Vec3) -> impl Bundle {
    (LinearVelocity(linear), AngularVelocity(angular))
}

pub fn linear_velocity(app: &App, body: Entity) -> Vec3 {
    app.get::<LinearVelocity>(body).unwrap().0
}

/// Linear and angular.
pub fn velocities(app: &App, body: Entity) -> (Vec3, Vec3) {
    let linear = app.get::<LinearVelocity>(body).unwrap().0;
    (linear, app.get::<AngularVelocity>(body).unwrap().0)
}

pub fn set_linear_velocity(body: &mut EntityWorldMut, linear: Vec3) {
    body.insert(LinearVelocity(linear));
}

/// What the engine itself moves a body with.
pub fn velocity_in_engine(app: &App, body: Entity) -> Vec3 {
    let solver = app.world().resource::<SolverBodies>();
    let at = solver.entities().iter().position(|entity| *entity == body).expect("a body");
    solver.bodies()[at].linear_velocity
}

/// With it, a body falls without a collider.
pub fn mass_of_body(mass: f32) -> impl Bundle {
    (Mass(mass), AngularInertia::new(Vec3::splat(mass)))
}

/// Those of a collider, set by the game.
pub fn games_mass(mass: f32) -> impl Bundle {
    Mass(mass)
}

pub fn density(density: f32) -> impl Bundle {
    ColliderDensity(density)
}

pub fn has_games_mass(app: &App, entity: Entity, mass: f32) -> bool {
    app.get::<Mass>(entity) == Some(&Mass(mass))
}

pub fn has_mass(app: &App, entity: Entity) -> bool {
    app.get::<Mass>(entity).is_some()
}

/// The mass properties of an entity's collider, which come from its mesh.
pub fn mass(app: &App, entity: Entity) -> MassOf {
    MassOf {
        mass: app.get::<Mass>(entity).expect("a mass").0,
        centre: app.get::<CenterOfMass>(entity).expect("a centre").0,
        moments: app.get::<AngularInertia>(entity).expect("inertia").principal,
    }
}

/// The same of whatever kind; `None` without any.
pub fn some_mass(app: &App, entity: Entity) -> Option<f32> {
    app.get::<Mass>(entity).map(|mass| mass.0)
}

/// Mass and centre of a body, all its colliders together.
pub fn mass_of_whole(app: &mut App, body: Entity) -> (f32, Vec3) {
    let mass = app.get::<ComputedMass>(body).expect("a body").value();
    (mass, app.get::<ComputedCenterOfMass>(body).expect("a body").0)
}

pub fn locked_along_z() -> LockedAxes {
    LockedAxes::new().lock_translation_z()
}

/// What colliders inherit beside friction and layers.
pub fn surface() -> impl Bundle {
    let hooks = ActiveCollisionHooks::FILTER_PAIRS;
    (Restitution::new(0.4), CollisionEventsEnabled, hooks, CollisionMargin(0.01))
}

pub fn has_surface(app: &App, entity: Entity) -> bool {
    app.get(entity) == Some(&Restitution::new(0.4))
        && app.get::<CollisionEventsEnabled>(entity).is_some()
        && app.get(entity) == Some(&ActiveCollisionHooks::FILTER_PAIRS)
        && app.get::<CollisionMargin>(entity).is_some_and(|margin| margin.0 == 0.01)
}

/// The sets of the engine's systems before and after its step.
pub const BEFORE: PhysicsSystems = PhysicsSystems::First;
pub const AFTER: PhysicsSystems = PhysicsSystems::Writeback;

pub fn is_locked_along_z(app: &App, body: Entity) -> bool {
    app.get::<LockedAxes>(body).map(LockedAxes::to_bits) == Some(locked_along_z().to_bits())
}

/// Avian clones the number of a body in its solver, and then moves both by one.
pub fn clone_of(app: &mut App, entity: Entity) -> Entity {
    app.edit(entity).clone_and_spawn_with_opt_out(|cloner| {
        cloner.deny::<SolverBodyIndex>();
    })
}

/// Without Bevy's feature `reflect_auto_register` Avian's types are not registered.
pub fn register_for_saves(app: &mut App) {
    app.register_type::<Transform>()
        .register_type::<ChildOf>()
        .register_type::<Name>()
        .register_type::<RigidBody>()
        .register_type::<GravityScale>()
        .register_type::<CollisionLayers>()
        .register_type::<LinearVelocity>()
        .register_type::<AngularVelocity>()
        .register_type::<LockedAxes>();
}

/// Avian loses track of which entities are above a collider when parents change, and the collider
/// keeps its place and scale in its body from before.
pub const ALLOWS_OTHER_PARENTS: bool = false;

/// Avian's solver loses count of its bodies where some are disabled, and panics.
pub const ALLOWS_DISABLING: bool = false;

/// Avian takes no rotation from such a transform, and writes that into it.
pub const ALLOWS_SCALE_ZERO: bool = false;

/// How fast contacts of small things push what does not touch, in metres per second.
pub const PUSHES: f32 = 0.035;

/// Meets nothing.
pub fn alone() -> Layers {
    CollisionLayers::NONE
}

/// No default.
pub fn layers() -> Layers {
    CollisionLayers::from_bits(2, 3)
}

pub fn asleep() -> impl Bundle {
    Sleeping
}

pub fn is_asleep(app: &App, body: Entity) -> bool {
    app.get::<Sleeping>(body).is_some()
}

/// A collider's place in the world and its shape, as the engine has them after a step.
pub fn in_engine(app: &mut App, entity: Entity) -> (Affine3A, SharedShape) {
    let place = app.get::<Position>(entity).expect("a place").0;
    let rotation = app.get::<Rotation>(entity).expect("a rotation").0;
    let shape = app.get::<Collider>(entity).expect("a collider").shape_scaled().clone();
    (Affine3A::from_rotation_translation(rotation, place), shape)
}

/// The collider that a ray downward meets, and which of its subshapes.
pub fn below(app: &mut App, from: Vec3) -> Option<(Entity, u32)> {
    let cast = move |space: SpatialQuery| {
        space.cast_ray(from, Dir3::NEG_Y, 100.0, true, &SpatialQueryFilter::default())
    };
    let hit = app.world_mut().run_system_once(cast).unwrap()?;
    let (place, shape) = in_engine(app, hit.entity);
    let point = place.inverse().transform_point3(from + Vec3::NEG_Y * hit.distance);
    Some((hit.entity, bevy_hullwright::subshape_at(&shape, point)))
}

/// The body that an entity's collider belongs to.
pub fn body_in_engine(app: &mut App, entity: Entity) -> Option<Entity> {
    app.get::<ColliderOf>(entity).map(|of| of.body)
}

/// Bodies and colliders that the engine holds.
pub fn held_by_engine(app: &mut App) -> (usize, usize) {
    let world = app.world();
    let trees = world.resource::<ColliderTrees>();
    let colliders = trees.iter_trees().map(|tree| tree.proxies.len()).sum();
    (world.resource::<SolverBodies>().len(), colliders)
}

fn rule_name(rule: CoefficientCombine) -> String {
    format!("{rule:?}").to_lowercase()
}

/// The coefficient of sliding, and the rule's name.
pub fn friction_of(app: &App, entity: Entity) -> Option<(f32, String)> {
    let friction = app.get::<Friction>(entity)?;
    Some((friction.dynamic_coefficient, rule_name(friction.combine_rule)))
}

pub fn restitution_of(app: &App, entity: Entity) -> Option<(f32, String)> {
    let restitution = app.get::<Restitution>(entity)?;
    Some((restitution.coefficient, rule_name(restitution.combine_rule)))
}

/// Memberships and filters.
pub fn groups_of(app: &App, entity: Entity) -> Option<(u32, u32)> {
    let layers = app.get::<CollisionLayers>(entity).filter(|of| **of != CollisionLayers::default());
    layers.map(|layers| (layers.memberships.0, layers.filters.0))
}

pub fn sends_collisions(app: &App, entity: Entity) -> bool {
    app.get::<CollisionEventsEnabled>(entity).is_some()
}

/// The distance by which it counts as larger.
pub fn skin_of(app: &App, entity: Entity) -> Option<f32> {
    app.get::<CollisionMargin>(entity).map(|margin| margin.0)
}

/// The angular velocity of a body in the engine.
pub fn angular_velocity(app: &App, body: Entity) -> Vec3 {
    app.get::<AngularVelocity>(body).unwrap().0
}
