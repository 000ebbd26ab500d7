//! Bodies sleep, and wake when a collider of theirs comes or changes.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{
    RapierContextEntityLink, RapierRigidBodyHandle, RapierRigidBodySet, Sleeping,
};

use super::placement::Placements;

/// Bodies that may sleep.
#[derive(SystemParam)]
pub(super) struct Sleepers<'w, 's> {
    components: Query<'w, 's, &'static mut Sleeping>,
    handles: Query<'w, 's, (&'static RapierRigidBodyHandle, &'static RapierContextEntityLink)>,
    bodies: Query<'w, 's, &'static mut RapierRigidBodySet>,
}

impl Sleepers<'_, '_> {
    /// Wakes the body that moves an entity.
    pub(super) fn wake(&mut self, placements: &Placements, entity: Entity) {
        let Some((body, _)) = placements.body(entity) else { return };
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
