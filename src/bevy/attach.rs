//! Results reach their entities: as colliders, as statuses, as events.

use std::time::Duration;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{
    Collider, ColliderMassProperties, ColliderScale, CollisionGroups, Friction, MassProperties,
    RapierContextEntityLink, RapierRigidBodyHandle, RapierRigidBodySet, Restitution, Sensor,
    Sleeping, SolverGroups,
};

use crate::ColliderError;
use crate::hulls_format::HullsFile;

use super::baked::BakedDecomposition;
use super::cache::ColliderGeometry;
use super::error::DecompositionError;
use super::events::{DecompositionReady, DecompositionSkipped, VerifiedError};
use super::placement::{Placements, map_mass};
use super::queue::{Completed, Failed, WorkQueue};
use super::request::{AttachedCollider, AttachedFallback};
use super::settings::HullwrightSettings;
use super::status::{DecompositionCounters, DecompositionStatus, HullSource, SkipReason};
use super::tag::{ConvexDecomposition, DEFAULT_DENSITY};

/// The entities that colliders are attached to.
#[derive(SystemParam)]
pub(super) struct Targets<'w, 's> {
    targets: Query<'w, 's, TargetComponents>,
    surfaces: Query<'w, 's, SurfaceComponents>,
    placements: Placements<'w, 's>,
}

type TargetComponents = (
    Option<&'static ConvexDecomposition>,
    Option<&'static BakedDecomposition>,
    Option<&'static AttachedCollider>,
    Option<&'static AttachedFallback>,
    Has<ColliderMassProperties>,
);

type SurfaceComponents = (
    Option<&'static Friction>,
    Option<&'static Restitution>,
    Option<&'static CollisionGroups>,
    Option<&'static SolverGroups>,
    Option<&'static Sensor>,
);

/// Attaches colliders that are ready, within the frame's budget.
pub(super) fn attach(
    mut commands: Commands,
    mut queue: ResMut<WorkQueue>,
    mut counters: ResMut<DecompositionCounters>,
    settings: Res<HullwrightSettings>,
    targets: Targets,
    mut sleepers: Sleepers,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let mut budget = queue.frame_time.budget(&settings);
    for _ in 0..settings.max_attached_per_frame.max(1) {
        if queue.completed.is_empty() || !budget.allows_one() {
            break;
        }
        let Some(completed) = queue.completed.pop_front() else { break };
        let entity = completed.entity;
        match targets.attach(&mut commands, &completed) {
            Ok(()) => {
                let Some(unfinished) = queue.unfinished.remove(&entity) else { continue };
                let present = targets.placements.stretch(entity);
                queue.detect_missed_scale(entity, &completed.request.stretch, present);
                if let Some((body, _)) = targets.placements.body(entity) {
                    sleepers.wake(body);
                }
                let status = count(&mut counters, &completed);
                if let Ok(mut old) = statuses.get_mut(entity) {
                    *old = status.clone();
                }
                announce(&mut commands, &completed, status, unfinished.since.elapsed());
            }
            Err(error) => queue.failed.push(Failed { entity, error, is_known: false }),
        }
    }
}

/// Bodies that may sleep.
#[derive(SystemParam)]
pub(super) struct Sleepers<'w, 's> {
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

fn count(counters: &mut DecompositionCounters, completed: &Completed) -> DecompositionStatus {
    let built = &completed.built;
    match &*built.geometry {
        ColliderGeometry::Triangles(_) => {
            counters.triangle_meshes += 1;
            return DecompositionStatus::Skipped(SkipReason::FixedBody);
        }
        ColliderGeometry::Hulls(file) => counters.convex += usize::from(file.hulls.len() == 1),
    }
    match built.source {
        HullSource::Decomposed => {}
        HullSource::Shared => counters.shared += 1,
        HullSource::Disk => counters.from_disk += 1,
        HullSource::Baked => counters.baked += 1,
    }
    DecompositionStatus::Ready(built.source)
}

/// The one event that the tag ends in.
fn announce(
    commands: &mut Commands,
    completed: &Completed,
    status: DecompositionStatus,
    time: Duration,
) {
    let entity = completed.entity;
    if let DecompositionStatus::Skipped(reason) = status {
        commands.trigger(DecompositionSkipped { entity, reason });
        return;
    }
    let (hulls, error) = match &*completed.built.geometry {
        ColliderGeometry::Triangles(_) => (0, None),
        ColliderGeometry::Hulls(file) => (file.hulls.len(), verified_error(file)),
    };
    let source = completed.built.source;
    commands.trigger(DecompositionReady { entity, hulls, error, source, time });
}

fn verified_error(file: &HullsFile) -> Option<VerifiedError> {
    let errors = file.verified?;
    let share = |length: f64| (length / file.diagonal) as f32;
    let (protrusion, uncovered) = (share(errors.protrusion_max), share(errors.uncovered_max));
    Some(VerifiedError { protrusion, uncovered })
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
        let mass = match &*built.geometry {
            ColliderGeometry::Triangles(_) => None,
            ColliderGeometry::Hulls(file) => {
                let density = f64::from(tag.map_or(DEFAULT_DENSITY, |tag| tag.density));
                file.mass_properties.map(|properties| {
                    let mass = match baked {
                        Some(baked) => baked.mass.map_or(properties.mass, f64::from),
                        None => properties.mass * density,
                    };
                    map_mass(&properties.with_mass(mass), &request.map)
                })
            }
        };
        let mass = match mass.filter(|_| owns_mass) {
            Some(mass) => Some(rapier_mass(&mass)?),
            None => None,
        };
        // The scale is in the points; bevy_rapier must not apply it again.
        commands.entity(*entity).try_insert((
            Collider::from(built.shape.clone()),
            ColliderScale::Absolute(Vec3::ONE),
            AttachedCollider {
                input: request.input.clone(),
                stretch: request.stretch,
                map: request.map * request.map_before,
                is_exact: request.is_exact(),
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
        let Some((body, _)) = self.placements.body(entity) else { return };
        if body == entity {
            return;
        }
        let (Ok(own), Ok(of_body)) = (self.surfaces.get(entity), self.surfaces.get(body)) else {
            return;
        };
        let mut entity = commands.entity(entity);
        if let (None, Some(friction)) = (own.0, of_body.0) {
            entity.try_insert(*friction);
        }
        if let (None, Some(restitution)) = (own.1, of_body.1) {
            entity.try_insert(*restitution);
        }
        if let (None, Some(groups)) = (own.2, of_body.2) {
            entity.try_insert(*groups);
        }
        if let (None, Some(groups)) = (own.3, of_body.3) {
            entity.try_insert(*groups);
        }
        if let (None, Some(sensor)) = (own.4, of_body.4) {
            entity.try_insert(*sensor);
        }
    }
}

fn rapier_mass(
    properties: &crate::MassProperties,
) -> Result<ColliderMassProperties, ColliderError> {
    let properties = crate::rapier::mass_properties(properties, [1.0; 3])?;
    Ok(ColliderMassProperties::MassProperties(MassProperties::from_rapier(properties)))
}
