//! The order of the queue: by priority, then by distance.

use std::cmp::{Ordering, Reverse};

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::bevy::tag::components::DecompositionFocus;
use crate::bevy::tag::decomposition_priority::DecompositionPriority;

/// Sorts entities by their priority and their distance to the nearest focus.
#[derive(SystemParam)]
pub struct Priority<'w, 's> {
    focuses: Query<'w, 's, Entity, With<DecompositionFocus>>,
    priorities: Query<'w, 's, &'static DecompositionPriority>,
    transforms: TransformHelper<'w, 's>,
}

impl Priority<'_, '_> {
    /// Stable, so that without a focus those that came first go first. Entities without a
    /// transform go last among those of their priority.
    pub fn sort(&self, entities: &mut [Entity]) {
        // Also in the frame in which they are spawned, when `GlobalTransform` is not known yet.
        let place =
            |entity| Some(self.transforms.compute_global_transform(entity).ok()?.translation());
        let focuses: Vec<Vec3> = self.focuses.iter().filter_map(place).collect();
        if focuses.is_empty() && self.priorities.is_empty() {
            return;
        }
        let distance = |place: Vec3| {
            focuses.iter().map(|focus| focus.distance_squared(place)).fold(f32::INFINITY, f32::min)
        };
        entities.sort_by_cached_key(|entity| {
            let priority = self.priorities.get(*entity).copied().unwrap_or_default();
            let nearest = place(*entity).map_or(f32::INFINITY, distance);
            (Reverse(priority), SquaredDistance(nearest))
        });
    }
}

#[derive(PartialEq)]
struct SquaredDistance(f32);

impl Eq for SquaredDistance {}

impl PartialOrd for SquaredDistance {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for SquaredDistance {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}
