//! What waits for its first collider: bodies are frozen, since without one they would fall through
//! the floor, and entities get a fallback collider, the convex hull or the bounding box.

use std::collections::VecDeque;
use std::sync::Arc;

use bevy::ecs::entity::{EntityHashMap, EntityHashSet};
use bevy::ecs::schedule::ScheduleLabel;
use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy::tasks::{Task, block_on, poll_once};
use bevy_rapier3d::plugin::PhysicsSet;
use bevy_rapier3d::prelude::{
    Collider, ColliderMassProperties, RapierContextEntityLink, RapierRigidBodyHandle,
    RapierRigidBodySet, RigidBody,
};
use bevy_rapier3d::rapier::dynamics;
use bevy_rapier3d::rapier::geometry::SharedShape;
use bevy_rapier3d::rapier::math::Vector;
use hullwright::hull::{HullBuilder, solid_hull};

use super::placement::Placements;
use super::work::{
    AttachedCollider, AttachedFallback, FarFromFocus, MadeBefore, OwnCollider, Unfinished, Work,
    attach_shape,
};
use crate::jobs::Frame;
use crate::jobs::baked::BakedDecomposition;
use crate::jobs::request::{ColliderRequest, MeshData, read_parts};
use crate::jobs::task::{contain_panics, primitive_around};
use crate::tag::ConvexDecomposition;
use crate::tag::outcomes::DecompositionStatus;
use crate::tag::parameters::PrimitiveKind;
use crate::tag::settings::{Execution, FallbackCollider, HullwrightSettings};

/// On a body that is frozen: the entities that it waits for. It is held in Rapier alone and during
/// steps alone, so that what users see, clone and save of it is their own.
#[derive(Component, Debug, Default)]
pub(crate) struct Frozen {
    for_entities: EntityHashSet,
    /// What it has before the step.
    held: Option<Held>,
}

/// What a body is to have again after the step.
#[derive(Debug, Clone, Copy)]
struct Held {
    velocity: [Vector; 2],
    locked: dynamics::LockedAxes,
}

/// Tags of this frame, on what has no collider of its own.
type NewTag = (Or<(Added<ConvexDecomposition>, Added<BakedDecomposition>)>, Without<Collider>);

/// The bodies of entities that wait.
#[derive(SystemParam)]
pub(super) struct Bodies<'w, 's> {
    placements: Placements<'w, 's>,
    attached: Query<'w, 's, (), With<AttachedCollider>>,
    frozen: Query<'w, 's, &'static mut Frozen>,
}

impl Bodies<'_, '_> {
    /// Freezes the bodies of those that have no collider yet.
    fn freeze_for(&mut self, entities: impl Iterator<Item = Entity>, commands: &mut Commands) {
        let mut new: EntityHashMap<Frozen> = EntityHashMap::default();
        for entity in entities {
            let Some((body, RigidBody::Dynamic)) = self.placements.body(entity) else { continue };
            if self.attached.contains(entity) {
                continue;
            }
            match self.frozen.get_mut(body) {
                Ok(mut frozen) => frozen.for_entities.insert(entity),
                Err(_) => new.entry(body).or_default().for_entities.insert(entity),
            };
        }
        for (body, frozen) in new {
            commands.entity(body).try_insert(frozen);
        }
    }
}

/// Freezes the bodies of entities that wait for their first collider.
pub(super) fn freeze(
    mut commands: Commands,
    unfinished: Res<Unfinished>,
    settings: Res<HullwrightSettings>,
    far: Query<Entity, Added<FarFromFocus>>,
    mut bodies: Bodies,
) {
    if settings.freeze_until_ready {
        let waiting = unfinished.awake().chain(&far);
        bodies.freeze_for(waiting, &mut commands);
    }
}

/// Freezes bodies in the fixed step in which they are tagged: physics may run there before the
/// plugin does.
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
        bodies.freeze_for(tagged.iter().filter_map(waits), &mut commands);
    }
}

/// One whose tag was removed is not waited for.
type IsFar = (With<FarFromFocus>, With<ConvexDecomposition>);

/// Releases bodies whose entities are all finished.
pub(super) fn release(
    mut commands: Commands,
    unfinished: Res<Unfinished>,
    far: Query<(), IsFar>,
    mut frozen: Query<(Entity, &mut Frozen)>,
) {
    let waits = |entity: &Entity| unfinished.contains(*entity) || far.contains(*entity);
    for (body, mut frozen) in &mut frozen {
        frozen.for_entities.retain(waits);
        if frozen.for_entities.is_empty() {
            commands.entity(body).try_remove::<Frozen>();
        }
    }
}

/// Holds frozen bodies during the steps of a schedule.
pub(super) fn hold_in(app: &mut App, schedule: impl ScheduleLabel) {
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
pub(super) struct FrozenBodies<'w, 's> {
    frozen: Query<'w, 's, (&'static mut Frozen, BodyHandle)>,
    sets: Query<'w, 's, &'static mut RapierRigidBodySet>,
}

type BodyHandle = (&'static RapierRigidBodyHandle, &'static RapierContextEntityLink);

impl FrozenBodies<'_, '_> {
    fn for_each(&mut self, run: impl Fn(&mut Option<Held>, &mut dynamics::RigidBody)) {
        for (mut frozen, (handle, context)) in &mut self.frozen {
            if let Ok(mut set) = self.sets.get_mut(context.0)
                && let Some(body) = set.bodies.get_mut(handle.0)
            {
                run(&mut frozen.held, body);
            }
        }
    }
}

/// Rapier moves by its velocity also what is locked. A clone may share its body with the original,
/// and what is held by one of them is not held again.
fn hold(mut bodies: FrozenBodies) {
    bodies.for_each(|held, body| {
        let (velocity, locked) = ([body.linvel(), body.angvel()], body.locked_axes());
        let is_held = locked == dynamics::LockedAxes::all() && velocity == [Vector::ZERO; 2];
        if body.is_dynamic() && !is_held {
            *held = Some(Held { velocity, locked });
            body.set_linvel(Vector::ZERO, false);
            body.set_angvel(Vector::ZERO, false);
            body.set_locked_axes(dynamics::LockedAxes::all(), false);
        }
    });
}

/// Awake, since it is to fall as soon as it is released.
fn let_go(mut bodies: FrozenBodies) {
    bodies.for_each(|held, body| {
        if let Some(Held { velocity: [linear, angular], locked }) = held.take() {
            body.set_locked_axes(locked, true);
            body.wake_up(true);
            body.set_linvel(linear, true);
            body.set_angvel(angular, true);
        }
    });
}

/// Fallback colliders to be made, each for what its entity requests.
#[derive(Resource, Default)]
pub(super) struct Fallbacks {
    waiting: VecDeque<(Entity, Arc<ColliderRequest>, FallbackCollider)>,
    tasks: Vec<(Entity, Arc<ColliderRequest>, Task<Option<SharedShape>>)>,
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
        self.waiting.is_empty() && self.tasks.is_empty()
    }
}

/// What fallback colliders are made from, and the entities that get them.
#[derive(SystemParam)]
pub(super) struct Targets<'w, 's> {
    meshes: Res<'w, Assets<Mesh>>,
    tags: Query<'w, 's, (&'static ConvexDecomposition, MadeBefore)>,
    placements: Placements<'w, 's>,
}

/// Makes fallback colliders for entities in the queue, within the frame's budget.
pub(super) fn attach_fallbacks(
    mut commands: Commands,
    mut fallbacks: ResMut<Fallbacks>,
    Frame { mut time, settings }: Frame,
    Work { unfinished, mut jobs }: Work,
    Targets { meshes, tags, placements }: Targets,
) {
    let fallbacks = &mut *fallbacks;
    // An entity that was forgotten, or has other meshes by now, has no use for it.
    let is_wanted = |entity: Entity, request: &Arc<ColliderRequest>| {
        unfinished.requested(entity).is_some_and(|now| now.request.parts == request.parts)
    };
    let mut attach = |entity: Entity, request: &ColliderRequest, made: SharedShape| {
        let Ok((tag, before)) = tags.get(entity) else { return };
        if before.collider.is_some() {
            return;
        }
        let place = placements.placement(entity);
        let own = OwnCollider::at(&place, made, request.to_collider(), None);
        let mass = before.owns_mass().then_some(ColliderMassProperties::Density(tag.density));
        attach_shape(&mut commands.entity(entity), own, mass, AttachedFallback);
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
        let shape = match (kind, settings.budget.execution.here()) {
            (FallbackCollider::None, _) => None,
            (FallbackCollider::BoundingBox, _) => {
                primitive_around(PrimitiveKind::Cuboid, &data, &Affine3A::IDENTITY).ok()
            }
            (FallbackCollider::ConvexHull, Execution::Slices | Execution::Worker) => {
                contain_panics(|| Ok(convex_hull(&data))).ok().flatten()
            }
            (FallbackCollider::ConvexHull, Execution::Background) => {
                let task = jobs.spawn(&settings, move || convex_hull(&data));
                fallbacks.tasks.push((entity, request.clone(), task));
                None
            }
        };
        if let Some(shape) = shape {
            attach(entity, &request, shape);
        }
    }
    fallbacks.tasks.retain_mut(|(entity, request, task)| {
        if is_wanted(*entity, request) && !task.is_finished() {
            return true;
        }
        if is_wanted(*entity, request)
            && let Some(Some(shape)) = block_on(poll_once(task))
        {
            attach(*entity, request, shape);
        }
        false
    });
}

/// Removes the fallback colliders of entities that get no collider.
pub(super) fn remove_fallbacks(
    mut commands: Commands,
    fallbacks: Query<(Entity, MadeBefore, &DecompositionStatus), With<AttachedFallback>>,
) {
    for (entity, before, status) in &fallbacks {
        if status.has_collider() == Some(false) {
            before.detach(&mut commands.entity(entity));
        }
    }
}

fn convex_hull(data: &MeshData) -> Option<SharedShape> {
    let points: Vec<[f64; 3]> = data.used_points().map(|point| point.map(f64::from)).collect();
    let (hull, _) = solid_hull(&mut HullBuilder::new(), &points, [0.0; 3], 0.0).ok()?;
    hullwright_rapier::shape_from_points(&[hull.points], [1.0; 3]).ok()
}
