//! Bodies are held still until their colliders are ready: without one they would fall through the
//! floor.

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{LockedAxes, RigidBody, Velocity};

use super::HullwrightSettings;
use super::attach::Attached;
use super::placement::Placements;
use super::work::Work;

/// On a body that is held: for whom, and what to give back.
#[derive(Component, Debug)]
pub(super) struct Held {
    by: EntityHashSet,
    locked: Option<LockedAxes>,
    velocity: Option<Velocity>,
}

/// Holds the bodies of entities that wait for their first collider.
pub(super) fn hold(
    mut commands: Commands,
    work: Res<Work>,
    settings: Res<HullwrightSettings>,
    placements: Placements,
    attached: Query<(), With<Attached>>,
    mut held: Query<&mut Held>,
    bodies: Query<(Option<&LockedAxes>, Option<&Velocity>)>,
) {
    if !settings.hold_still {
        return;
    }
    let mut new: Vec<(Entity, Held)> = Vec::new();
    for &entity in work.requests.keys() {
        let Some((body, RigidBody::Dynamic)) = placements.body(entity) else { continue };
        if attached.contains(entity) {
            continue;
        }
        if let Ok(mut held) = held.get_mut(body) {
            if !held.by.contains(&entity) {
                held.by.insert(entity);
            }
        } else if let Some((_, held)) = new.iter_mut().find(|(other, _)| *other == body) {
            held.by.insert(entity);
        } else {
            let (locked, velocity) = bodies.get(body).unwrap_or_default();
            let by = EntityHashSet::from_iter([entity]);
            new.push((body, Held { by, locked: locked.copied(), velocity: velocity.copied() }));
        }
    }
    for (body, held) in new {
        let has_velocity = held.velocity.is_some();
        let mut body = commands.entity(body);
        body.try_insert((held, LockedAxes::all()));
        if has_velocity {
            body.try_insert(Velocity::zero());
        }
    }
}

/// Lets go of bodies for which nobody waits any more.
pub(super) fn release(
    mut commands: Commands,
    work: Res<Work>,
    mut held: Query<(Entity, &mut Held, Option<&LockedAxes>)>,
) {
    for (body, mut held, locked) in &mut held {
        held.by.retain(|entity| work.requests.contains_key(entity));
        if !held.by.is_empty() {
            continue;
        }
        let mut commands = commands.entity(body);
        commands.try_remove::<Held>();
        // Whoever locked other axes in the meantime means it.
        if locked == Some(&LockedAxes::all()) {
            commands.try_insert(held.locked.unwrap_or(LockedAxes::empty()));
        }
        if let Some(velocity) = held.velocity {
            commands.try_insert(velocity);
        }
    }
}
