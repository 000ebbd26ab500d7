//! Which colliders are triangle meshes: those of what never moves.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{RigidBody, Sensor};

use crate::bevy::collider::placement::Placements;
use crate::bevy::tag::components::DecompositionShape;
use crate::bevy::tag::settings::HullwrightSettings;
use crate::bevy::tag::status::SkipReason;

/// What determines whether a collider ever moves.
#[derive(SystemParam)]
pub(crate) struct StaticGeometry<'w, 's> {
    sensors: Query<'w, 's, (), With<Sensor>>,
    settings: Res<'w, HullwrightSettings>,
    placements: Placements<'w, 's>,
}

impl StaticGeometry<'_, '_> {
    /// Why an entity gets its triangles; `None` for what its tag says.
    pub(crate) fn why_triangles(
        &self,
        entity: Entity,
        shape: DecompositionShape,
    ) -> Option<SkipReason> {
        match shape {
            DecompositionShape::Triangles => return Some(SkipReason::TrianglesRequested),
            DecompositionShape::Auto if self.settings.exact_static_colliders => {}
            _ => return None,
        }
        let body = self.placements.body(entity);
        let is_sensor = |entity| self.sensors.contains(entity);
        if is_sensor(entity) || body.is_some_and(|(body, _)| is_sensor(body)) {
            return None;
        }
        match body {
            None => Some(SkipReason::NoBody),
            Some((_, RigidBody::Fixed)) => Some(SkipReason::FixedBody),
            Some(_) => None,
        }
    }
}
