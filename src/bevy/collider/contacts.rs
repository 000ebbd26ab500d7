//! The worlds of bevy_rapier get contacts that don't depend on the unit of length.

use bevy::prelude::*;
use bevy_rapier3d::plugin::context::RapierContextSimulation;

use crate::bevy::tag::settings::HullwrightSettings;
use crate::rapier::ContactDispatcher;

/// Sets the dispatcher of each new world. Before the first step a world has no contacts to lose.
pub(crate) fn set_dispatcher(
    settings: Res<HullwrightSettings>,
    mut worlds: Query<&mut RapierContextSimulation, Added<RapierContextSimulation>>,
) {
    if !settings.contact_dispatcher {
        return;
    }
    for mut world in &mut worlds {
        world.narrow_phase.set_query_dispatcher(ContactDispatcher);
    }
}
