//! Avian, by avian3d.

#[cfg(feature = "bevy_gltf")]
mod declared;
mod hold;

use std::sync::Arc;

use avian3d::prelude::*;
use bevy::ecs::query::QueryData;
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel};
use bevy::ecs::system::EntityCommands;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
#[cfg(feature = "bevy_gltf")]
use hullwright_formats::conventions::{BodyMotion, SurfaceProperties};
use hullwright_parry::parry3d::mass_properties::MassProperties;
use hullwright_parry::parry3d::math::Pose;
use hullwright_parry::parry3d::shape::{SharedShape, TypedShape};

use super::{Engine, Item, Motion, Velocity, Weight, run_before};

/// avian3d 0.8.
pub(crate) struct Avian;

/// The mass properties that the plugin gave an entity. Other ones are the game's own, and stay. A
/// save has both.
#[derive(Component, Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Component, Clone, PartialEq)]
#[type_path = "hullwright::avian"]
pub(crate) struct OwnMass {
    mass: Mass,
    inertia: AngularInertia,
    centre: CenterOfMass,
}

impl OwnMass {
    /// Of a body that waits for its mass.
    const LENT: Self = Self {
        mass: Mass(1.0),
        inertia: AngularInertia { principal: Vec3::ONE, local_frame: Quat::IDENTITY },
        centre: CenterOfMass(Vec3::ZERO),
    };
}

/// What an entity has of a collider and its mass.
#[derive(QueryData)]
pub(crate) struct Made {
    collider: Option<&'static Collider>,
    mass: Option<&'static Mass>,
    inertia: Option<&'static AngularInertia>,
    centre: Option<&'static CenterOfMass>,
    own_mass: Option<&'static OwnMass>,
}

/// Scaled colliders by the address of their shape, which is kept so that no other has it, and their
/// scale.
#[derive(Resource, Default)]
pub(crate) struct Colliders(HashMap<(usize, [u32; 3]), (SharedShape, Collider)>);

/// Scaled colliders that are kept: a level's kinds of props.
const MOST_KEPT: usize = 256;

surface! {
    layers: CollisionLayers,
    friction: Friction,
    restitution: Restitution,
    sensor: Sensor,
    events: CollisionEventsEnabled,
    hooks: ActiveCollisionHooks,
    margin: CollisionMargin,
}

impl Engine for Avian {
    type Body = RigidBody;
    type Collider = Collider;
    type Sensor = Sensor;
    type Mass = OwnMass;
    type Cache = Colliders;
    type Made = Made;
    type Surface = Surface;

    const SCALES_COLLIDERS: bool = true;

    const WITHOUT_BODY: Option<&str> = Some(
        "there is no RigidBody on it or above it, so nothing bumps into its collider: insert \
         RigidBody::Static there, or on the scene",
    );

    const BODIES_FALL_WITHOUT_MASS: bool = true;

    fn build(app: &mut App) {
        app.register_type::<OwnMass>();
        run_before(app, PhysicsSystems::First, Self::fixed_steps());
        hold::hold(app);
    }

    fn finish(app: &mut App) {
        if !app.world().contains_resource::<Time<Physics>>() {
            log::warn!(
                "Avian's PhysicsPlugins are missing: colliders are made, but nothing moves or \
                 collides"
            );
        }
    }

    fn fixed_steps() -> InternedScheduleLabel {
        FixedPostUpdate.intern()
    }

    fn motion(body: &RigidBody) -> Motion {
        match body {
            RigidBody::Dynamic => Motion::Dynamic,
            RigidBody::Static => Motion::Fixed,
            RigidBody::Kinematic => Motion::Kinematic,
        }
    }

    fn body(motion: Motion) -> RigidBody {
        match motion {
            Motion::Dynamic => RigidBody::Dynamic,
            Motion::Fixed => RigidBody::Static,
            Motion::Kinematic => RigidBody::Kinematic,
        }
    }

    fn present<'a>(made: &'a Item<'_, '_, Made>) -> Option<&'a Collider> {
        made.collider
    }

    fn owns_mass(made: &Item<'_, '_, Made>) -> bool {
        let own = made.own_mass;
        made.mass.is_none_or(|mass| own.is_some_and(|own| own.mass == *mass))
            && made.inertia.is_none_or(|inertia| own.is_some_and(|own| own.inertia == *inertia))
            && made.centre.is_none_or(|centre| own.is_some_and(|own| own.centre == *centre))
    }

    fn collider(shape: &SharedShape, scale: Vec3, cache: &mut Colliders) -> Collider {
        if scale.abs() == Vec3::ONE {
            return Collider::from(shape.clone());
        }
        let key = (Arc::as_ptr(&shape.0).addr(), scale.to_array().map(f32::to_bits));
        if let Some((_, collider)) = cache.0.get(&key) {
            return collider.clone();
        }
        let unscaled = multiplied(shape, scale.abs().recip()).unwrap_or_else(|| shape.clone());
        let mut collider = Collider::from(unscaled);
        collider.set_scale(scale, SUBDIVISIONS);
        if cache.0.len() >= MOST_KEPT {
            cache.0.clear();
        }
        cache.0.insert(key, (shape.clone(), collider.clone()));
        collider
    }

    fn unscaled(collider: &Collider) -> &SharedShape {
        collider.shape()
    }

    fn attach(entity: &mut EntityCommands, collider: Collider) {
        entity.queue_silenced(move |mut entity: EntityWorldMut| {
            // The place that an earlier collider has left would move the entity there.
            if !entity.contains::<Collider>() && !entity.contains::<RigidBody>() {
                entity.remove::<(Position, Rotation)>();
            }
            entity.insert(collider.clone());
            // Avian has taken a scale that Bevy may not have propagated yet, and would keep it
            // below no body.
            if let Some(mut present) = entity.get_mut::<Collider>()
                && present.scale() != collider.scale()
            {
                *present = collider;
            }
        });
    }

    fn remove_collider(entity: &mut EntityCommands) {
        entity.try_remove::<Collider>();
    }

    fn mass(properties: MassProperties) -> OwnMass {
        OwnMass {
            mass: Mass(properties.mass()),
            inertia: AngularInertia::new_with_local_frame(
                properties.principal_inertia(),
                properties.principal_inertia_local_frame,
            ),
            centre: CenterOfMass(properties.local_com),
        }
    }

    fn mass_by_volume(shape: &SharedShape, weight: Weight) -> OwnMass {
        let density = match weight.mass {
            Some(mass) => mass / shape.mass_properties(1.0).mass(),
            None => weight.density,
        };
        Self::mass(shape.mass_properties(density))
    }

    fn set_mass(entity: &mut EntityCommands, mass: OwnMass) {
        entity.try_insert((mass.mass, mass.inertia, mass.centre, mass));
    }

    fn remove_mass(entity: &mut EntityCommands) {
        entity.try_remove::<(Mass, AngularInertia, CenterOfMass, OwnMass)>();
    }

    fn inherit(
        own: &Item<'_, '_, Surface>,
        from: &[Item<'_, '_, Surface>],
        to: &mut EntityCommands,
    ) {
        inherit(own, from, to);
        // Avian gives each collider these, so the default of one is no choice.
        if own.layers == Some(&CollisionLayers::default())
            && let Some(layers) = from.iter().find_map(|giver| giver.layers)
        {
            to.try_insert(*layers);
        }
    }

    fn has_surface(own: &Item<'_, '_, Surface>) -> bool {
        let layers = own.layers.filter(|layers| **layers != CollisionLayers::default());
        has_surface(&SurfaceItem { layers, ..*own })
    }

    fn copy_surface(entity: &mut EntityCommands, to: Entity) {
        copy_surface(entity, to);
    }

    fn copy_dynamics(body: &mut EntityCommands, to: Entity) {
        body.clone_with_opt_in(to, |builder| {
            builder.allow::<(AngularDamping, Dominance, GravityScale, LinearDamping)>();
            builder.allow::<(MaxAngularSpeed, MaxLinearSpeed, SweptCcd)>();
        });
    }

    fn velocity(world: &World, body: Entity) -> Velocity {
        let of = |entity: EntityRef| {
            let centre = entity.get::<ComputedCenterOfMass>()?.0;
            let (position, rotation) = (entity.get::<Position>()?, entity.get::<Rotation>()?);
            let linear = entity.get::<LinearVelocity>()?.0;
            let angular = entity.get::<AngularVelocity>()?.0;
            Some(Velocity { linear, angular, centre: position.0 + rotation.0 * centre })
        };
        world.get_entity(body).ok().and_then(of).unwrap_or_default()
    }

    fn set_velocity(entity: &mut EntityCommands, Velocity { linear, angular, .. }: Velocity) {
        entity.try_insert((LinearVelocity(linear), AngularVelocity(angular)));
    }

    fn wake(commands: &mut Commands, body: Entity) {
        let Ok(mut body) = commands.get_entity(body) else { return };
        body.queue_silenced(|mut body: EntityWorldMut| {
            if let Some(mut timer) = body.get_mut::<SleepTimer>() {
                timer.0 = 0.0;
            }
            // All that touches it wakes too.
            body.remove::<Sleeping>();
        });
    }

    #[cfg(feature = "bevy_gltf")]
    fn insert_surface(entity: &mut EntityCommands, surface: &SurfaceProperties) {
        declared::insert_surface(entity, surface);
    }

    #[cfg(feature = "bevy_gltf")]
    fn attach_declared(entity: &mut EntityCommands, shape: SharedShape, scale: Vec3) {
        let mut collider = Collider::from(shape);
        collider.set_scale(scale, SUBDIVISIONS);
        Self::attach(entity, collider);
    }

    /// All kinematic bodies do.
    #[cfg(feature = "bevy_gltf")]
    fn body_of_constant_velocity() -> RigidBody {
        RigidBody::Kinematic
    }

    #[cfg(feature = "bevy_gltf")]
    fn insert_gravity(entity: &mut EntityCommands, factor: f32) {
        entity.try_insert_if_new(GravityScale(factor));
    }

    #[cfg(feature = "bevy_gltf")]
    fn set_declared_mass(body: &mut EntityWorldMut, declared: &BodyMotion, _: &[Entity]) -> bool {
        declared::set_mass(body, declared).is_some()
    }
}

/// Avian's own, for shapes that become polyhedra when their factors differ.
const SUBDIVISIONS: u32 = 10;

/// A shape multiplied by positive factors, as Avian does it; `None` for one that Avian can't scale.
///
/// Avian multiplies points by the scale, and normals too, as Parry does, which turns them where
/// factors differ. After this by the inverse factors, both come out right.
fn multiplied(shape: &SharedShape, factors: Vec3) -> Option<SharedShape> {
    let is_uniform = factors.x == factors.y && factors.y == factors.z;
    Some(match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(hull) => SharedShape::new(hull.clone().scaled(factors)?),
        TypedShape::TriMesh(mesh) => SharedShape::new(mesh.clone().scaled(factors)),
        TypedShape::Cuboid(cuboid) => SharedShape::new(cuboid.scaled(factors)),
        TypedShape::Ball(ball) if is_uniform => SharedShape::ball(ball.radius * factors.x),
        TypedShape::Capsule(capsule) if is_uniform => {
            let [a, b] = [capsule.segment.a, capsule.segment.b].map(|end| end * factors);
            SharedShape::capsule(a, b, capsule.radius * factors.x)
        }
        // Under factors that differ Avian would make an ellipsoid of another size.
        TypedShape::Ball(ball) => polyhedron(ball.to_trimesh(SUBDIVISIONS, SUBDIVISIONS), factors)?,
        TypedShape::Capsule(capsule) => {
            polyhedron(capsule.to_trimesh(SUBDIVISIONS, SUBDIVISIONS), factors)?
        }
        TypedShape::Compound(parts) => {
            let part = |(pose, part): &(Pose, SharedShape)| {
                // What is turned is sheared, and no such shape: its hull is.
                if is_uniform || pose.rotation == Pose::IDENTITY.rotation {
                    let pose = Pose { translation: pose.translation * factors, ..*pose };
                    return Some((pose, multiplied(part, factors)?));
                }
                let (mut points, triangles) = mesh_of(part)?;
                points.iter_mut().for_each(|point| *point = pose.transform_point(*point));
                Some((Pose::IDENTITY, polyhedron((points, triangles), factors)?))
            };
            SharedShape::compound(parts.shapes().iter().map(part).collect::<Option<_>>()?)
        }
        _ => return None,
    })
}

type PointsAndTriangles = (Vec<Vec3>, Vec<[u32; 3]>);

fn mesh_of(shape: &SharedShape) -> Option<PointsAndTriangles> {
    Some(match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(hull) => hull.to_trimesh(),
        TypedShape::Cuboid(cuboid) => cuboid.to_trimesh(),
        TypedShape::Ball(ball) => ball.to_trimesh(SUBDIVISIONS, SUBDIVISIONS),
        TypedShape::Capsule(capsule) => capsule.to_trimesh(SUBDIVISIONS, SUBDIVISIONS),
        _ => return None,
    })
}

fn polyhedron((points, _): PointsAndTriangles, factors: Vec3) -> Option<SharedShape> {
    let points: Vec<[f64; 3]> =
        points.iter().map(|point| point.to_array().map(f64::from)).collect();
    let shape = hullwright_parry::shape_from_points(&[points], [1.0; 3]).ok()?;
    multiplied(&shape, factors)
}
