//! Fallback colliders for entities that wait: the convex hull or the bounding box.

use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy::tasks::{block_on, poll_once};
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties, ColliderScale};
use bevy_rapier3d::rapier::geometry::SharedShape;

use crate::hull::{HullBuilder, solid_hull};

use crate::bevy::jobs::mesh_data::{MeshData, read_parts};
use crate::bevy::jobs::pool::pool;
use crate::bevy::jobs::primitive::{PrimitiveKind, primitive_around, used_points};
use crate::bevy::jobs::queue::WorkQueue;
use crate::bevy::jobs::request::AttachedFallback;
use crate::bevy::tag::components::ConvexDecomposition;
use crate::bevy::tag::settings::{Execution, FallbackCollider, HullwrightSettings};
use crate::bevy::tag::status::DecompositionStatus;

/// Makes fallback colliders for entities in the queue, within the frame's budget.
pub(crate) fn attach_fallbacks(
    mut commands: Commands,
    mut queue: ResMut<WorkQueue>,
    settings: Res<HullwrightSettings>,
    meshes: Res<Assets<Mesh>>,
    tags: Query<(&ConvexDecomposition, Has<Collider>, Has<ColliderMassProperties>)>,
) {
    let queue = &mut *queue;
    let mut attach = |entity: Entity, shape: SharedShape| {
        let Ok((tag, false, has_mass)) = tags.get(entity) else { return };
        let mut commands = commands.entity(entity);
        commands.try_insert((
            Collider::from(shape),
            ColliderScale::Absolute(Vec3::ONE),
            AttachedFallback { owns_mass: !has_mass },
        ));
        if !has_mass {
            commands.try_insert(ColliderMassProperties::Density(tag.density));
        }
    };
    let mut budget = queue.frame_time.budget(&settings);
    while !queue.fallbacks.waiting.is_empty() && budget.allows_one() {
        let Some(entity) = queue.fallbacks.waiting.pop_front() else { break };
        let (Ok((tag, ..)), Some(request)) = (tags.get(entity), queue.request(entity)) else {
            continue;
        };
        let map = request.map * request.map_before;
        let Ok(data) = read_parts(&request.parts, &map, &meshes) else { continue };
        let kind = tag.fallback_collider.unwrap_or(settings.fallback_collider);
        let shape = match (kind, settings.execution) {
            (FallbackCollider::None, _) => None,
            (FallbackCollider::BoundingBox, _) => bounding_box(&data),
            (FallbackCollider::ConvexHull, Execution::Slices) => convex_hull(&data),
            (FallbackCollider::ConvexHull, Execution::Background) => {
                let task = pool().spawn(async move { convex_hull(&data) });
                queue.fallbacks.jobs.push((entity, task));
                None
            }
        };
        if let Some(shape) = shape {
            attach(entity, shape);
        }
    }
    queue.fallbacks.jobs.retain_mut(|(entity, task)| {
        if !task.is_finished() {
            return true;
        }
        if let Some(Some(shape)) = block_on(poll_once(task)) {
            attach(*entity, shape);
        }
        false
    });
    queue.frame_time.spend(&budget);
}

/// Removes the fallback colliders of entities that get no collider.
pub(crate) fn remove_fallbacks(
    mut commands: Commands,
    fallbacks: Query<(Entity, &AttachedFallback, &DecompositionStatus)>,
) {
    for (entity, fallback, status) in &fallbacks {
        if !matches!(status, DecompositionStatus::Failed(_) | DecompositionStatus::Cancelled) {
            continue;
        }
        let mut entity = commands.entity(entity);
        entity.try_remove::<(AttachedFallback, Collider, ColliderScale)>();
        if fallback.owns_mass {
            entity.try_remove::<ColliderMassProperties>();
        }
    }
}

fn bounding_box(data: &MeshData) -> Option<SharedShape> {
    primitive_around(PrimitiveKind::Cuboid, data, &Affine3A::IDENTITY).ok()
}

fn convex_hull(data: &MeshData) -> Option<SharedShape> {
    let points: Vec<[f64; 3]> = used_points(data).map(|point| point.map(f64::from)).collect();
    let (hull, _) = solid_hull(&mut HullBuilder::new(), &points, [0.0; 3], 0.0).ok()?;
    crate::rapier::shape_from_points(&[hull.points], [1.0; 3]).ok()
}
