//! What waits for its first collider: bodies are frozen, since without one they would fall through the floor, and
//! entities get a fallback collider, the convex hull or the bounding box.

use std::collections::VecDeque;
use std::sync::Arc;

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy::tasks::{Task, block_on, poll_once};
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties, LockedAxes, RigidBody, Velocity};
use bevy_rapier3d::rapier::geometry::SharedShape;

use super::placement::Placements;
use super::work::{
    AttachedCollider, AttachedFallback, FarFromFocus, Unfinished, attach_shape, detach,
};
use crate::bevy::jobs::baked::BakedDecomposition;
use crate::bevy::jobs::request::{ColliderRequest, MeshData, read_parts};
use crate::bevy::jobs::task::primitive_around;
use crate::bevy::jobs::{Frame, pool};
use crate::bevy::tag::ConvexDecomposition;
use crate::bevy::tag::outcomes::DecompositionStatus;
use crate::bevy::tag::parameters::PrimitiveKind;
use crate::bevy::tag::settings::{Execution, FallbackCollider, HullwrightSettings};
use crate::hull::{HullBuilder, solid_hull};

/// On a body that is frozen: the entities that it waits for, and what to restore.
#[derive(Component, Debug)]
pub(super) struct Frozen {
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
pub(super) struct Bodies<'w, 's> {
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
                frozen.for_entities.insert(entity);
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
pub(super) fn freeze(
    mut commands: Commands,
    unfinished: Res<Unfinished>,
    settings: Res<HullwrightSettings>,
    far: Query<Entity, Added<FarFromFocus>>,
    mut bodies: Bodies,
) {
    bodies.keep_velocities();
    if settings.freeze_until_ready {
        let waiting = unfinished.entities().chain(&far);
        bodies.freeze_for(waiting, false, &mut commands);
    }
}

/// Freezes bodies in the fixed step in which they are tagged: physics may run there before the plugin does.
pub(super) fn freeze_new(
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
pub(super) fn release(
    mut commands: Commands,
    unfinished: Res<Unfinished>,
    far: Query<(), IsFar>,
    mut frozen: Query<(Entity, &mut Frozen, Option<&LockedAxes>)>,
) {
    let waits = |entity: &Entity| unfinished.contains(*entity) || far.contains(*entity);
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

/// Fallback colliders to be made, each for what its entity requests.
#[derive(Resource, Default)]
pub(super) struct Fallbacks {
    waiting: VecDeque<(Entity, Arc<ColliderRequest>, FallbackCollider)>,
    jobs: Vec<(Entity, Arc<ColliderRequest>, Task<Option<SharedShape>>)>,
}

impl Fallbacks {
    pub(super) fn push(
        &mut self,
        entity: Entity,
        request: Arc<ColliderRequest>,
        kind: FallbackCollider,
    ) {
        self.waiting.push_back((entity, request, kind));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty() && self.jobs.is_empty()
    }
}

/// What fallback colliders are made from, and the entities that get them.
#[derive(SystemParam)]
pub(super) struct Targets<'w, 's> {
    meshes: Res<'w, Assets<Mesh>>,
    tags: Query<'w, 's, (&'static ConvexDecomposition, Has<Collider>, Has<ColliderMassProperties>)>,
}

/// Makes fallback colliders for entities in the queue, within the frame's budget.
pub(super) fn attach_fallbacks(
    mut commands: Commands,
    mut fallbacks: ResMut<Fallbacks>,
    Frame { mut time, settings }: Frame,
    unfinished: Res<Unfinished>,
    Targets { meshes, tags }: Targets,
) {
    let fallbacks = &mut *fallbacks;
    // An entity that was forgotten, or requests something else by now, has no use for it.
    let is_wanted = |entity: Entity, request: &Arc<ColliderRequest>| {
        unfinished.requested(entity).is_some_and(|now| Arc::ptr_eq(&now.request, request))
    };
    let mut attach = |entity: Entity, shape: SharedShape| {
        let Ok((tag, false, has_mass)) = tags.get(entity) else { return };
        let mut commands = commands.entity(entity);
        attach_shape(&mut commands, shape, AttachedFallback { owns_mass: !has_mass });
        if !has_mass {
            commands.try_insert(ColliderMassProperties::Density(tag.density));
        }
    };
    let mut budget = time.budget(&settings);
    while !fallbacks.waiting.is_empty() && budget.allows_one() {
        let Some((entity, request, kind)) = fallbacks.waiting.pop_front() else { break };
        if !is_wanted(entity, &request) {
            continue;
        }
        let Ok(data) = read_parts(&request.parts, &request.to_collider(), &meshes) else {
            continue;
        };
        let shape = match (kind, settings.execution) {
            (FallbackCollider::None, _) => None,
            (FallbackCollider::BoundingBox, _) => {
                primitive_around(PrimitiveKind::Cuboid, &data, &Affine3A::IDENTITY).ok()
            }
            (FallbackCollider::ConvexHull, Execution::Slices) => convex_hull(&data),
            (FallbackCollider::ConvexHull, Execution::Background) => {
                let task = pool().spawn(async move { convex_hull(&data) });
                fallbacks.jobs.push((entity, request, task));
                None
            }
        };
        if let Some(shape) = shape {
            attach(entity, shape);
        }
    }
    fallbacks.jobs.retain_mut(|(entity, request, task)| {
        if is_wanted(*entity, request) && !task.is_finished() {
            return true;
        }
        if is_wanted(*entity, request)
            && let Some(Some(shape)) = block_on(poll_once(task))
        {
            attach(*entity, shape);
        }
        false
    });
}

/// Removes the fallback colliders of entities that get no collider.
pub(super) fn remove_fallbacks(
    mut commands: Commands,
    fallbacks: Query<(Entity, &AttachedFallback, &DecompositionStatus)>,
) {
    for (entity, fallback, status) in &fallbacks {
        if matches!(status, DecompositionStatus::Failed(_) | DecompositionStatus::Cancelled) {
            detach::<AttachedFallback>(&mut commands.entity(entity), fallback.owns_mass);
        }
    }
}

fn convex_hull(data: &MeshData) -> Option<SharedShape> {
    let points: Vec<[f64; 3]> = data.used_points().map(|point| point.map(f64::from)).collect();
    let (hull, _) = solid_hull(&mut HullBuilder::new(), &points, [0.0; 3], 0.0).ok()?;
    crate::rapier::shape_from_points(&[hull.points], [1.0; 3]).ok()
}
