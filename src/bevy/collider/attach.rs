//! Results reach their entities: as colliders, as statuses, as events.

use bevy::ecs::system::{EntityCommands, SystemParam};
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{
    ActiveCollisionTypes, ActiveEvents, ActiveHooks, Collider, ColliderMassProperties,
    ColliderScale, CollisionGroups, ContactForceEventThreshold, ContactSkin, Friction,
    MassProperties, RapierContextEntityLink, RapierRigidBodyHandle, RapierRigidBodySet,
    Restitution, Sensor, Sleeping, SolverGroups,
};

use crate::rapier::ColliderError;

use crate::bevy::collider::placement::{Placements, map_mass};
use crate::bevy::jobs::baked::BakedDecomposition;
use crate::bevy::jobs::cache::ColliderGeometry;
use crate::bevy::jobs::queue::{Completed, Failed, WorkQueue};
use crate::bevy::jobs::request::{AttachedCollider, AttachedFallback};
use crate::bevy::tag::components::{ConvexDecomposition, DEFAULT_DENSITY};
use crate::bevy::tag::error::DecompositionError;
use crate::bevy::tag::outcomes::Outcomes;
use crate::bevy::tag::settings::HullwrightSettings;

/// The entities that colliders are attached to.
#[derive(SystemParam)]
pub(crate) struct Targets<'w, 's> {
    targets: Query<'w, 's, TargetComponents>,
    surfaces: Surfaces<'w, 's>,
    placements: Placements<'w, 's>,
}

type TargetComponents = (
    Option<&'static ConvexDecomposition>,
    Option<&'static BakedDecomposition>,
    Option<&'static AttachedCollider>,
    Option<&'static AttachedFallback>,
    Has<ColliderMassProperties>,
);

/// Attaches colliders that are ready, within the frame's budget.
pub(crate) fn attach(
    mut queue: ResMut<WorkQueue>,
    settings: Res<HullwrightSettings>,
    targets: Targets,
    mut sleepers: Sleepers,
    mut outcomes: Outcomes,
) {
    let mut budget = queue.frame_time.budget(&settings);
    for _ in 0..settings.max_attached_per_frame.max(1) {
        if queue.completed.is_empty() || !budget.allows_one() {
            break;
        }
        let Some(completed) = queue.completed.pop_front() else { break };
        let entity = completed.entity;
        match targets.attach(&mut outcomes.commands, &completed) {
            Ok(()) => {
                let Some(unfinished) = queue.unfinished.remove(&entity) else { continue };
                let present = targets.placements.stretch(entity);
                queue.detect_missed_scale(entity, &completed.request.stretch, present);
                if let Some((body, _)) = targets.placements.body(entity) {
                    sleepers.wake(body);
                }
                outcomes.ready(&completed, unfinished.since.elapsed());
            }
            Err(error) => queue.failed.push(Failed { entity, error, is_known: false }),
        }
    }
}

/// Bodies that may sleep.
#[derive(SystemParam)]
pub(crate) struct Sleepers<'w, 's> {
    components: Query<'w, 's, &'static mut Sleeping>,
    handles: Query<'w, 's, (&'static RapierRigidBodyHandle, &'static RapierContextEntityLink)>,
    bodies: Query<'w, 's, &'static mut RapierRigidBodySet>,
}

impl Sleepers<'_, '_> {
    fn wake(&mut self, body: Entity) {
        if let Ok(mut sleeping) = self.components.get_mut(body)
            && sleeping.sleeping
        {
            sleeping.sleeping = false;
        }
        // Bodies sleep without the component too.
        let Ok((handle, context)) = self.handles.get(body) else { return };
        let Ok(mut bodies) = self.bodies.get_mut(context.0) else { return };
        if let Some(body) = bodies.bodies.get_mut(handle.0)
            && body.is_sleeping()
        {
            body.wake_up(true);
        }
    }
}

impl Targets<'_, '_> {
    fn attach(
        &self,
        commands: &mut Commands,
        completed: &Completed,
    ) -> Result<(), DecompositionError> {
        let Completed { entity, request, built } = completed;
        let Ok((tag, baked, attached, fallback, has_mass)) = self.targets.get(*entity) else {
            return Ok(());
        };
        let owned = attached.map(|attached| attached.owns_mass);
        let owned = owned.or_else(|| fallback.map(|fallback| fallback.owns_mass));
        let owns_mass = owned.unwrap_or(!has_mass);
        let mass = match owns_mass {
            true => mass_of(&built.geometry, tag, baked, &request.map)?,
            false => None,
        };
        // The scale is in the points; bevy_rapier must not apply it again.
        commands.entity(*entity).try_insert((
            Collider::from(built.shape.clone()),
            ColliderScale::Absolute(Vec3::ONE),
            AttachedCollider {
                input: request.input.clone(),
                stretch: request.stretch,
                map: request.map * request.map_before,
                why_triangles: request.why_triangles(),
                owns_mass,
            },
        ));
        if fallback.is_some() {
            commands.entity(*entity).try_remove::<AttachedFallback>();
        }
        if let Some(mass) = mass {
            commands.entity(*entity).try_insert(mass);
        }
        self.inherit_surface(commands, *entity);
        Ok(())
    }

    /// A collider below a body inherits the components of its surface that it does not have itself.
    fn inherit_surface(&self, commands: &mut Commands, entity: Entity) {
        if let Some((body, _)) = self.placements.body(entity)
            && body != entity
        {
            self.surfaces.inherit(&mut commands.entity(entity), body);
        }
    }
}

/// What bevy_rapier reads from the entity of a collider, and people put on its body.
#[derive(SystemParam)]
struct Surfaces<'w, 's> {
    friction: Query<'w, 's, &'static Friction>,
    restitution: Query<'w, 's, &'static Restitution>,
    collision_groups: Query<'w, 's, &'static CollisionGroups>,
    solver_groups: Query<'w, 's, &'static SolverGroups>,
    sensor: Query<'w, 's, &'static Sensor>,
    active_events: Query<'w, 's, &'static ActiveEvents>,
    active_hooks: Query<'w, 's, &'static ActiveHooks>,
    active_collision_types: Query<'w, 's, &'static ActiveCollisionTypes>,
    contact_force_threshold: Query<'w, 's, &'static ContactForceEventThreshold>,
    contact_skin: Query<'w, 's, &'static ContactSkin>,
}

impl Surfaces<'_, '_> {
    fn inherit(&self, to: &mut EntityCommands, from: Entity) {
        inherit(&self.friction, to, from);
        inherit(&self.restitution, to, from);
        inherit(&self.collision_groups, to, from);
        inherit(&self.solver_groups, to, from);
        inherit(&self.sensor, to, from);
        inherit(&self.active_events, to, from);
        inherit(&self.active_hooks, to, from);
        inherit(&self.active_collision_types, to, from);
        inherit(&self.contact_force_threshold, to, from);
        inherit(&self.contact_skin, to, from);
    }
}

fn inherit<C: Component + Copy>(all: &Query<&C>, to: &mut EntityCommands, from: Entity) {
    if let Ok(component) = all.get(from)
        && !all.contains(to.id())
    {
        to.try_insert(*component);
    }
}

/// The mass of a collider; `None` for what has none, as triangles.
fn mass_of(
    geometry: &ColliderGeometry,
    tag: Option<&ConvexDecomposition>,
    baked: Option<&BakedDecomposition>,
    map: &Affine3A,
) -> Result<Option<ColliderMassProperties>, ColliderError> {
    let density = tag.map_or(DEFAULT_DENSITY, |tag| tag.density);
    // Of the whole collider in the world.
    let given = match baked {
        Some(baked) => baked.mass,
        None => tag.and_then(|tag| tag.mass),
    };
    match geometry {
        ColliderGeometry::Triangles(_) => Ok(None),
        ColliderGeometry::Primitive(..) => {
            let number = given.unwrap_or(density);
            if !(number.is_finite() && number > 0.0) {
                return Err(ColliderError::UnusableMass { mass: number.into() });
            }
            Ok(Some(match given {
                Some(mass) => ColliderMassProperties::Mass(mass),
                None => ColliderMassProperties::Density(density),
            }))
        }
        ColliderGeometry::Hulls(file) => {
            let Some(properties) = file.mass_properties else { return Ok(None) };
            // Baked hulls know their density, all others have one of 1.
            let density = if baked.is_some() { 1.0 } else { f64::from(density) };
            let mapped = map_mass(&properties.with_mass(properties.mass * density), map);
            let mapped = given.map_or(mapped, |mass| mapped.with_mass(mass.into()));
            rapier_mass(&mapped).map(Some)
        }
    }
}

fn rapier_mass(
    properties: &crate::MassProperties,
) -> Result<ColliderMassProperties, ColliderError> {
    let properties = crate::rapier::mass_properties(properties, [1.0; 3])?;
    Ok(ColliderMassProperties::MassProperties(MassProperties::from_rapier(properties)))
}
