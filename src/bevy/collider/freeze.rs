//! Bodies are frozen until their colliders are ready: without one they would fall through the
//! floor.

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{Collider, LockedAxes, RigidBody, Velocity};

use crate::bevy::collider::placement::Placements;
use crate::bevy::collider::skip::FarFromFocus;
use crate::bevy::jobs::baked::BakedDecomposition;
use crate::bevy::jobs::queue::WorkQueue;
use crate::bevy::jobs::request::AttachedCollider;
use crate::bevy::tag::components::ConvexDecomposition;
use crate::bevy::tag::settings::HullwrightSettings;
use crate::bevy::tag::status::DecompositionStatus;

/// On a body that is frozen: the entities that it waits for, and what to restore.
#[derive(Component, Debug)]
pub(crate) struct Frozen {
    for_entities: EntityHashSet,
    locked: Option<LockedAxes>,
    velocity: Option<Velocity>,
    /// Whether the velocity that it has now was set when it was frozen, by another system than the one that
    /// looks at it.
    is_new: bool,
}

/// Tags of this frame, on what has no collider of its own.
type NewTag = (Or<(Added<ConvexDecomposition>, Added<BakedDecomposition>)>, Without<Collider>);

type FreeBody = (Option<&'static LockedAxes>, Option<&'static mut Velocity>);

/// The bodies of entities that wait.
#[derive(SystemParam)]
pub(crate) struct Bodies<'w, 's> {
    placements: Placements<'w, 's>,
    attached: Query<'w, 's, (), With<AttachedCollider>>,
    frozen: Query<'w, 's, (&'static mut Frozen, Option<&'static mut Velocity>)>,
    free: Query<'w, 's, FreeBody, Without<Frozen>>,
}

impl Bodies<'_, '_> {
    /// Freezes the bodies of those that have no collider yet.
    fn freeze_for(
        &mut self,
        entities: impl Iterator<Item = Entity>,
        is_new: bool,
        commands: &mut Commands,
    ) {
        let mut new: Vec<(Entity, Frozen)> = Vec::new();
        for entity in entities {
            let Some((body, RigidBody::Dynamic)) = self.placements.body(entity) else { continue };
            if self.attached.contains(entity) {
                continue;
            }
            if let Ok((mut frozen, _)) = self.frozen.get_mut(body) {
                if !frozen.for_entities.contains(&entity) {
                    frozen.for_entities.insert(entity);
                }
            } else if let Some((_, frozen)) = new.iter_mut().find(|(other, _)| *other == body) {
                frozen.for_entities.insert(entity);
            } else {
                let (locked, mut velocity) = self.free.get_mut(body).unwrap_or_default();
                let for_entities = EntityHashSet::from_iter([entity]);
                let (locked, before) = (locked.copied(), velocity.as_deref().copied());
                new.push((body, Frozen { for_entities, locked, velocity: before, is_new }));
                if let Some(velocity) = &mut velocity {
                    velocity.set_if_neq(Velocity::zero());
                }
            }
        }
        for (body, frozen) in new {
            commands.entity(body).try_insert((frozen, LockedAxes::all()));
        }
    }

    /// Keeps the velocities that are set while bodies are frozen.
    fn keep_velocities(&mut self) {
        for (mut frozen, velocity) in &mut self.frozen {
            // Rapier leaves the velocity of a body that stands still alone, and a system does not see what it
            // changed itself: another system has set it.
            let Some(mut velocity) = velocity.filter(|velocity| velocity.is_changed()) else {
                continue;
            };
            let is_own = std::mem::take(&mut frozen.is_new) && *velocity == Velocity::zero();
            if !is_own {
                frozen.velocity = Some(*velocity);
                velocity.set_if_neq(Velocity::zero());
            }
        }
    }
}

/// Freezes the bodies of entities that wait for their first collider, and keeps the velocities that are set
/// while they are frozen.
pub(crate) fn freeze(
    mut commands: Commands,
    queue: Res<WorkQueue>,
    settings: Res<HullwrightSettings>,
    far: Query<Entity, Added<FarFromFocus>>,
    mut bodies: Bodies,
) {
    bodies.keep_velocities();
    if settings.freeze_until_ready {
        let waiting = queue.unfinished.keys().copied().chain(&far);
        bodies.freeze_for(waiting, false, &mut commands);
    }
}

/// Freezes bodies in the fixed step in which they are tagged: physics may run there before the plugin does.
pub(crate) fn freeze_new(
    mut commands: Commands,
    settings: Res<HullwrightSettings>,
    tagged: Query<(Entity, &DecompositionStatus), NewTag>,
    mut bodies: Bodies,
) {
    if settings.freeze_until_ready {
        let waits = |(entity, status): (Entity, &DecompositionStatus)| {
            (!status.is_finished()).then_some(entity)
        };
        bodies.freeze_for(tagged.iter().filter_map(waits), true, &mut commands);
    }
}

/// One whose tag was removed is not waited for.
type IsFar = (With<FarFromFocus>, With<ConvexDecomposition>);

/// Releases bodies whose entities are all finished.
pub(crate) fn release(
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
        // Axes that were locked in the meantime stay locked.
        if locked == Some(&LockedAxes::all()) {
            commands.try_insert(frozen.locked.unwrap_or(LockedAxes::empty()));
        }
        if let Some(velocity) = frozen.velocity {
            commands.try_insert(velocity);
        }
    }
}
