//! What files declare, in Avian's components. It has no groups of the solver, and no threshold of
//! forces.

use avian3d::prelude::*;
use bevy::ecs::system::EntityCommands;
use bevy::prelude::*;
use hullwright_formats::conventions::{BodyMotion, CombineRule, SurfaceProperties};

use crate::engine::DeclaredMass;

pub(super) fn insert_surface(entity: &mut EntityCommands, surface: &SurfaceProperties) {
    if surface.friction.is_some() || surface.friction_combine_rule.is_some() {
        let default = Friction::default();
        let friction = surface.friction.unwrap_or(default.dynamic_coefficient);
        entity.try_insert_if_new(Friction {
            dynamic_coefficient: friction,
            static_coefficient: surface.static_friction.unwrap_or(friction),
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
    if let Some(of) = surface.collision_groups {
        let layers = CollisionLayers::new(LayerMask(of.memberships), LayerMask(of.filters));
        // Avian gives each collider these, so the default of one is no choice.
        entity.queue_silenced(move |mut entity: EntityWorldMut| {
            let present = entity.get::<CollisionLayers>();
            if present.is_none_or(|present| *present == CollisionLayers::default()) {
                entity.insert(layers);
            }
        });
    }
    if surface.active_events.is_some_and(|events| events.collision) {
        entity.try_insert_if_new(CollisionEventsEnabled);
    }
    if let Some(skin) = surface.contact_skin {
        entity.try_insert_if_new(CollisionMargin(skin));
    }
}

fn rule(rule: CombineRule) -> CoefficientCombine {
    match rule {
        CombineRule::Average => CoefficientCombine::Average,
        CombineRule::Min => CoefficientCombine::Min,
        CombineRule::Multiply => CoefficientCombine::Multiply,
        CombineRule::Max => CoefficientCombine::Max,
    }
}

pub(super) fn set_mass(body: &mut EntityWorldMut, declared: &BodyMotion) -> Option<()> {
    let mass = body.get::<ComputedMass>().map(|mass| mass.value()).filter(|mass| *mass > 0.0)?;
    let (inertia, rotation) =
        body.get::<ComputedAngularInertia>()?.principal_angular_inertia_with_local_frame();
    let centre = body.get::<ComputedCenterOfMass>()?.0;
    let DeclaredMass { mass, centre, inertia, rotation } =
        DeclaredMass::new(declared, DeclaredMass { mass, centre, inertia, rotation });
    body.insert((
        (Mass(mass), NoAutoMass),
        (CenterOfMass(centre), NoAutoCenterOfMass),
        (AngularInertia { principal: inertia, local_frame: rotation }, NoAutoAngularInertia),
    ));
    Some(())
}
