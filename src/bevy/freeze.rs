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
use super::tag::ConvexDecomposition;

/// On a body that is frozen: for whom, and what to restore.
#[derive(Component, Debug)]
pub(super) struct Frozen {
    for_entities: EntityHashSet,
    locked: Option<LockedAxes>,
    velocity: Option<Velocity>,
}

type FreeBody = (Option<&'static LockedAxes>, Option<&'static mut Velocity>);

/// Freezes the bodies of entities that wait for their first collider, and keeps the velocities that are set
/// while they are frozen.
#[expect(clippy::too_many_arguments, reason = "a system's are what it reads and writes")]
pub(super) fn freeze(
    mut commands: Commands,
    queue: Res<WorkQueue>,
    settings: Res<HullwrightSettings>,
    placements: Placements,
    attached: Query<(), With<AttachedCollider>>,
    far: Query<Entity, Added<FarFromFocus>>,
    mut frozen: Query<(&mut Frozen, Option<&mut Velocity>)>,
    mut bodies: Query<FreeBody, Without<Frozen>>,
) {
    for (mut frozen, velocity) in &mut frozen {
        // Rapier leaves the velocity of a body that stands still alone, and a system does not see what it
        // changed itself: somebody else has set it.
        if let Some(mut velocity) = velocity.filter(|velocity| velocity.is_changed()) {
            frozen.velocity = Some(*velocity);
            velocity.set_if_neq(Velocity::zero());
        }
    }
    if !settings.freeze_until_ready {
        return;
    }
    let mut new: Vec<(Entity, Frozen)> = Vec::new();
    for entity in queue.unfinished.keys().copied().chain(&far) {
        let Some((body, RigidBody::Dynamic)) = placements.body(entity) else { continue };
        if attached.contains(entity) {
            continue;
        }
        if let Ok((mut frozen, _)) = frozen.get_mut(body) {
            if !frozen.for_entities.contains(&entity) {
                frozen.for_entities.insert(entity);
            }
        } else if let Some((_, frozen)) = new.iter_mut().find(|(other, _)| *other == body) {
            frozen.for_entities.insert(entity);
        } else {
            let (locked, mut velocity) = bodies.get_mut(body).unwrap_or_default();
            let for_entities = EntityHashSet::from_iter([entity]);
            let before = velocity.as_deref().copied();
            new.push((body, Frozen { for_entities, locked: locked.copied(), velocity: before }));
            if let Some(velocity) = &mut velocity {
                velocity.set_if_neq(Velocity::zero());
            }
        }
    }
    for (body, frozen) in new {
        commands.entity(body).try_insert((frozen, LockedAxes::all()));
    }
}

/// One whose tag was removed is not waited for.
type IsFar = (With<FarFromFocus>, With<ConvexDecomposition>);

/// Releases bodies that nobody waits for any more.
pub(super) fn release(
    mut commands: Commands,
    queue: Res<WorkQueue>,
    far: Query<(), IsFar>,
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
