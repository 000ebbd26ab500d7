//! What files declare, in Rapier's components.

use bevy::ecs::system::EntityCommands;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{
    ActiveEvents, AdditionalMassProperties, CoefficientCombineRule, ColliderMassProperties,
    CollisionGroups, ContactForceEventThreshold, ContactSkin, Friction, Group, MassProperties,
    ReadMassProperties, Restitution, Sensor, SolverGroups,
};
use hullwright_formats::conventions::{BodyMotion, CombineRule, SurfaceProperties};

use crate::engine::DeclaredMass;

pub(super) fn insert_surface(entity: &mut EntityCommands, surface: &SurfaceProperties) {
    if surface.friction.is_some() || surface.friction_combine_rule.is_some() {
        let default = Friction::default();
        entity.try_insert_if_new(Friction {
            coefficient: surface.friction.unwrap_or(default.coefficient),
            combine_rule: surface.friction_combine_rule.map_or(default.combine_rule, rule),
        });
    }
    if surface.restitution.is_some() || surface.restitution_combine_rule.is_some() {
        let default = Restitution::default();
        entity.try_insert_if_new(Restitution {
            coefficient: surface.restitution.unwrap_or(default.coefficient),
            combine_rule: surface.restitution_combine_rule.map_or(default.combine_rule, rule),
        });
    }
    if surface.sensor == Some(true) {
        entity.try_insert_if_new(Sensor);
    }
    let group = Group::from_bits_retain;
    if let Some(of) = surface.collision_groups {
        entity.try_insert_if_new(CollisionGroups::new(group(of.memberships), group(of.filters)));
    }
    if let Some(of) = surface.solver_groups {
        entity.try_insert_if_new(SolverGroups::new(group(of.memberships), group(of.filters)));
    }
    if let Some(of) = surface.active_events {
        let mut events = ActiveEvents::empty();
        events.set(ActiveEvents::COLLISION_EVENTS, of.collision);
        events.set(ActiveEvents::CONTACT_FORCE_EVENTS, of.contact_force);
        entity.try_insert_if_new(events);
    }
    if let Some(threshold) = surface.contact_force_event_threshold {
        entity.try_insert_if_new(ContactForceEventThreshold(threshold));
    }
    if let Some(skin) = surface.contact_skin {
        entity.try_insert_if_new(ContactSkin(skin));
    }
}

fn rule(rule: CombineRule) -> CoefficientCombineRule {
    match rule {
        CombineRule::Average => CoefficientCombineRule::Average,
        CombineRule::Min => CoefficientCombineRule::Min,
        CombineRule::Multiply => CoefficientCombineRule::Multiply,
        CombineRule::Max => CoefficientCombineRule::Max,
    }
}

pub(super) fn set_mass(
    body: &mut EntityWorldMut,
    declared: &BodyMotion,
    colliders: &[Entity],
) -> Option<()> {
    let weighed = body.get::<ReadMassProperties>().filter(|of| of.mass > 0.0)?.get();
    let DeclaredMass { mass, centre, inertia, rotation } = DeclaredMass::new(
        declared,
        DeclaredMass {
            mass: weighed.mass,
            centre: weighed.local_center_of_mass,
            inertia: weighed.principal_inertia,
            rotation: weighed.principal_inertia_local_frame,
        },
    );
    body.insert(AdditionalMassProperties::MassProperties(MassProperties {
        local_center_of_mass: centre,
        mass,
        principal_inertia_local_frame: rotation,
        principal_inertia: inertia,
    }));
    // Rapier adds what colliders weigh.
    body.world_scope(|world| {
        for &collider in colliders {
            if let Ok(mut collider) = world.get_entity_mut(collider) {
                collider.insert(ColliderMassProperties::Density(0.0));
            }
        }
    });
    Some(())
}
