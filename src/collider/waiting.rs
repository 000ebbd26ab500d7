//! What waits for its first collider: bodies are frozen, since without one they would fall through
//! the floor, and entities get a fallback collider, the convex hull or the bounding box.

use std::collections::VecDeque;
use std::sync::Arc;

use bevy::ecs::entity::{EntityHashMap, EntityHashSet};
use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy::tasks::{Task, block_on, poll_once};
use hullwright::hull::{HullBuilder, solid_hull};
use hullwright_parry::parry3d::shape::SharedShape;

use super::placement::Placements;
use super::work::{
    AttachedCollider, AttachedFallback, FarFromFocus, MadeBefore, MadeBeforeItem, OwnCollider,
    Unfinished, Work, attach_shape,
};
use crate::engine::{Engine, Frozen, Motion, Weight};
use crate::jobs::Frame;
use crate::jobs::baked::BakedDecomposition;
use crate::jobs::request::{ColliderRequest, MeshData, read_parts};
use crate::jobs::task::{contain_panics, primitive_around};
use crate::tag::ConvexDecomposition;
use crate::tag::outcomes::{DecompositionStatus, SkipReason};
use crate::tag::parameters::PrimitiveKind;
use crate::tag::settings::{Execution, FallbackCollider, HullwrightSettings};

/// Tags of this frame, on what has no collider of its own.
type NewTag<E> =
    (Or<(Added<ConvexDecomposition>, Added<BakedDecomposition>)>, Without<<E as Engine>::Collider>);

/// The bodies of entities that wait.
#[derive(SystemParam)]
pub(super) struct Bodies<'w, 's, E: Engine> {
    placements: Placements<'w, 's, E>,
    attached: Query<'w, 's, (), With<AttachedCollider>>,
    frozen: Query<'w, 's, &'static mut Frozen>,
}

impl<E: Engine> Bodies<'_, '_, E> {
    /// Freezes the bodies of those that have no collider yet.
    fn freeze_for(&mut self, entities: impl Iterator<Item = Entity>, commands: &mut Commands) {
        let mut new: EntityHashMap<Frozen> = EntityHashMap::default();
        for entity in entities {
            let Some((body, Motion::Dynamic)) = self.placements.body(entity) else { continue };
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
pub(super) fn freeze<E: Engine>(
    mut commands: Commands,
    unfinished: Res<Unfinished>,
    settings: Res<HullwrightSettings>,
    far: Query<Entity, Added<FarFromFocus>>,
    mut bodies: Bodies<E>,
) {
    if settings.freeze_until_ready {
        let waiting = unfinished.awake().chain(&far);
        bodies.freeze_for(waiting, &mut commands);
    }
}

/// Freezes bodies in the fixed step in which they are tagged: physics may run there before the
/// plugin does.
pub(super) fn freeze_new<E: Engine>(
    mut commands: Commands,
    settings: Res<HullwrightSettings>,
    tagged: Query<(Entity, &DecompositionStatus), NewTag<E>>,
    mut bodies: Bodies<E>,
) {
    if settings.freeze_until_ready {
        let waits = |(entity, status): (Entity, &DecompositionStatus)| {
            (!status.is_finished()).then_some(entity)
        };
        bodies.freeze_for(tagged.iter().filter_map(waits), &mut commands);
    }
}

/// Bodies that hang where those without mass fall: all of their meshes are skipped.
#[derive(SystemParam)]
pub(super) struct Hanging<'w, 's, E: Engine> {
    statuses: Query<'w, 's, &'static DecompositionStatus>,
    made: Query<'w, 's, MadeBefore<E>>,
    children: Query<'w, 's, &'static Children>,
}

impl<E: Engine> Hanging<'_, '_, E> {
    /// An entity and all below it.
    fn all(&self, body: Entity) -> impl Iterator<Item = Entity> {
        std::iter::once(body).chain(self.children.iter_descendants(body))
    }

    fn is_skipped(&self, entity: Entity) -> bool {
        use SkipReason::{Hidden, TooSmall};
        let status = self.statuses.get(entity);
        matches!(status, Ok(DecompositionStatus::Skipped(Hidden | TooSmall)))
    }

    /// Whether a body has a mesh that is skipped, and neither a collider nor a mass of the game's
    /// own.
    fn is_hanging(&self, body: Entity) -> bool {
        let hangs = |made: MadeBeforeItem<E>| !made.has_collider() && made.owns_mass();
        E::BODIES_FALL_WITHOUT_MASS
            && self.all(body).any(|entity| self.is_skipped(entity))
            && self.all(body).all(|entity| self.made.get(entity).is_ok_and(hangs))
    }
}

/// Freezes bodies whose meshes are all skipped, where those without mass fall.
pub(super) fn freeze_skipped<E: Engine>(
    mut commands: Commands,
    changed: Query<Entity, Changed<DecompositionStatus>>,
    new_bodies: Query<Entity, Added<<E as Engine>::Body>>,
    settings: Res<HullwrightSettings>,
    hanging: Hanging<E>,
    placements: Placements<E>,
) {
    if !settings.freeze_until_ready {
        return;
    }
    let below = new_bodies.iter().flat_map(|body| hanging.all(body));
    let skipped = changed.iter().chain(below).filter(|entity| hanging.is_skipped(*entity));
    let bodies: EntityHashSet = skipped
        .filter_map(|entity| placements.body(entity))
        .filter_map(|(body, motion)| (motion == Motion::Dynamic).then_some(body))
        .collect();
    for body in bodies.into_iter().filter(|body| hanging.is_hanging(*body)) {
        commands.entity(body).try_insert_if_new(Frozen::default());
    }
}

/// One whose tag was removed is not waited for.
type IsFar = (With<FarFromFocus>, With<ConvexDecomposition>);

/// Releases bodies whose entities are all finished.
pub(super) fn release<E: Engine>(
    mut commands: Commands,
    unfinished: Res<Unfinished>,
    far: Query<(), IsFar>,
    hanging: Hanging<E>,
    mut frozen: Query<(Entity, &mut Frozen)>,
) {
    let waits = |entity: &Entity| unfinished.contains(*entity) || far.contains(*entity);
    for (body, mut frozen) in &mut frozen {
        frozen.for_entities.retain(waits);
        if frozen.for_entities.is_empty() && !hanging.is_hanging(body) {
            commands.entity(body).try_remove::<Frozen>();
        }
    }
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
pub(super) struct Targets<'w, 's, E: Engine> {
    meshes: Res<'w, Assets<Mesh>>,
    tags: Query<'w, 's, (&'static ConvexDecomposition, MadeBefore<E>)>,
    placements: Placements<'w, 's, E>,
}

/// Makes fallback colliders for entities in the queue, within the frame's budget.
pub(super) fn attach_fallbacks<E: Engine>(
    mut commands: Commands,
    mut fallbacks: ResMut<Fallbacks>,
    mut cache: ResMut<E::Cache>,
    Frame { mut time, settings }: Frame,
    Work { unfinished, mut jobs }: Work,
    Targets { meshes, tags, placements }: Targets<E>,
) {
    let fallbacks = &mut *fallbacks;
    // An entity that was forgotten, or has other meshes by now, has no use for it.
    let is_wanted = |entity: Entity, request: &Arc<ColliderRequest>| {
        unfinished.requested(entity).is_some_and(|now| now.request.parts == request.parts)
    };
    let mut attach = |entity: Entity, request: &ColliderRequest, made: SharedShape| {
        let Ok((tag, before)) = tags.get(entity) else { return };
        if before.has_collider() {
            return;
        }
        let place = placements.placement(entity);
        let made_map = request.to_collider();
        let (own, collider) = OwnCollider::at::<E>(&place, made, made_map, None, &mut cache);
        let weight = Weight { density: tag.density, mass: None };
        let mass = before.owns_mass().then(|| E::mass_by_volume(&own.shape, weight));
        let mut entity = commands.entity(entity);
        attach_shape::<E>(&mut entity, (own, collider), mass, AttachedFallback);
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
pub(super) fn remove_fallbacks<E: Engine>(
    mut commands: Commands,
    fallbacks: Query<(Entity, MadeBefore<E>, &DecompositionStatus), With<AttachedFallback>>,
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
    hullwright_parry::shape_from_points(&[hull.points], [1.0; 3]).ok()
}
