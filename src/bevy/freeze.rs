//! Bodies are frozen until their colliders are ready: without one they would fall through the
//! floor.

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{LockedAxes, RigidBody, Velocity};

use super::placement::Placements;
use super::queue::WorkQueue;
use super::request::AttachedCollider;
use super::settings::HullwrightSettings;
use super::skip::FarFromFocus;

/// On a body that is frozen: for whom, and what to restore.
#[derive(Component, Debug)]
pub(super) struct Frozen {
    for_entities: EntityHashSet,
    locked: Option<LockedAxes>,
    velocity: Option<Velocity>,
}

/// Freezes the bodies of entities that wait for their first collider.
pub(super) fn freeze(
    mut commands: Commands,
    queue: Res<WorkQueue>,
    settings: Res<HullwrightSettings>,
    placements: Placements,
    attached: Query<(), With<AttachedCollider>>,
    far: Query<Entity, Added<FarFromFocus>>,
    mut frozen: Query<&mut Frozen>,
    bodies: Query<(Option<&LockedAxes>, Option<&Velocity>)>,
) {
    if !settings.freeze_until_ready {
        return;
    }
    let mut new: Vec<(Entity, Frozen)> = Vec::new();
    for entity in queue.unfinished.keys().copied().chain(&far) {
        let Some((body, RigidBody::Dynamic)) = placements.body(entity) else { continue };
        if attached.contains(entity) {
            continue;
        }
        if let Ok(mut frozen) = frozen.get_mut(body) {
            if !frozen.for_entities.contains(&entity) {
                frozen.for_entities.insert(entity);
            }
        } else if let Some((_, frozen)) = new.iter_mut().find(|(other, _)| *other == body) {
            frozen.for_entities.insert(entity);
        } else {
            let (locked, velocity) = bodies.get(body).unwrap_or_default();
            let (locked, velocity) = (locked.copied(), velocity.copied());
            let for_entities = EntityHashSet::from_iter([entity]);
            new.push((body, Frozen { for_entities, locked, velocity }));
        }
    }
    for (body, frozen) in new {
        let has_velocity = frozen.velocity.is_some();
        let mut body = commands.entity(body);
        body.try_insert((frozen, LockedAxes::all()));
        if has_velocity {
            body.try_insert(Velocity::zero());
        }
    }
}

/// Releases bodies that nobody waits for any more.
pub(super) fn release(
    mut commands: Commands,
    queue: Res<WorkQueue>,
    far: Query<(), With<FarFromFocus>>,
    mut frozen: Query<(Entity, &mut Frozen, Option<&LockedAxes>)>,
) {
    let waits = |entity: &Entity| queue.unfinished.contains_key(entity) || far.contains(*entity);
    for (body, mut frozen, locked) in &mut frozen {
        frozen.for_entities.retain(waits);
        if !frozen.for_entities.is_empty() {
            continue;
        }
        let mut commands = commands.entity(body);
        commands.try_remove::<Frozen>();
        // Axes that somebody else has locked in the meantime stay locked.
        if locked == Some(&LockedAxes::all()) {
            commands.try_insert(frozen.locked.unwrap_or(LockedAxes::empty()));
        }
        if let Some(velocity) = frozen.velocity {
            commands.try_insert(velocity);
        }
    }
}
