//! Frozen bodies, held in Rapier's own set during its steps.

use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::schedule::ScheduleLabel;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_rapier3d::plugin::PhysicsSet;
use bevy_rapier3d::prelude::{RapierContextEntityLink, RapierRigidBodyHandle, RapierRigidBodySet};
use bevy_rapier3d::rapier::dynamics;
use bevy_rapier3d::rapier::math::Vector;

use crate::engine::Frozen;

/// What bodies are to have again after the step.
#[derive(Resource, Default)]
struct Held(EntityHashMap<HeldBody>);

#[derive(Debug, Clone, Copy)]
struct HeldBody {
    velocity: [Vector; 2],
    locked: dynamics::LockedAxes,
}

/// Holds frozen bodies during the steps of a schedule.
pub(super) fn hold_in(app: &mut App, schedule: impl ScheduleLabel) {
    app.init_resource::<Held>();
    app.add_systems(
        schedule,
        (
            hold.after(PhysicsSet::SyncBackend).before(PhysicsSet::StepSimulation),
            let_go.after(PhysicsSet::StepSimulation).before(PhysicsSet::Writeback),
        )
            .chain()
            .run_if(any_with_component::<Frozen>),
    );
}

/// Frozen bodies, as Rapier has them.
#[derive(SystemParam)]
struct FrozenBodies<'w, 's> {
    frozen: Query<'w, 's, (Entity, BodyHandle), With<Frozen>>,
    sets: Query<'w, 's, &'static mut RapierRigidBodySet>,
}

type BodyHandle = (&'static RapierRigidBodyHandle, &'static RapierContextEntityLink);

impl FrozenBodies<'_, '_> {
    fn for_each(&mut self, mut run: impl FnMut(Entity, &mut dynamics::RigidBody)) {
        for (entity, (handle, context)) in &self.frozen {
            if let Ok(mut set) = self.sets.get_mut(context.0)
                && let Some(body) = set.bodies.get_mut(handle.0)
            {
                run(entity, body);
            }
        }
    }
}

/// Rapier moves by its velocity also what is locked. A clone may share its body with the original,
/// and what is held by one of them is not held again.
fn hold(mut bodies: FrozenBodies, mut all_held: ResMut<Held>) {
    bodies.for_each(|entity, body| {
        let (velocity, locked) = ([body.linvel(), body.angvel()], body.locked_axes());
        let is_held = locked == dynamics::LockedAxes::all() && velocity == [Vector::ZERO; 2];
        if body.is_dynamic() && !is_held {
            all_held.0.insert(entity, HeldBody { velocity, locked });
            body.set_linvel(Vector::ZERO, false);
            body.set_angvel(Vector::ZERO, false);
            body.set_locked_axes(dynamics::LockedAxes::all(), false);
        }
    });
}

/// Awake, since it is to fall as soon as it is released.
fn let_go(mut bodies: FrozenBodies, mut all_held: ResMut<Held>) {
    let mut all_held = std::mem::take(&mut all_held.0);
    bodies.for_each(|entity, body| {
        if let Some(HeldBody { velocity: [linear, angular], locked }) = all_held.remove(&entity) {
            body.set_locked_axes(locked, true);
            body.wake_up(true);
            body.set_linvel(linear, true);
            body.set_angvel(angular, true);
        }
    });
}
