//! The entities that are not finished, and the components that record what became of the others.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use bevy::asset::UntypedAssetId;
use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::system::{EntityCommands, SystemParam};
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy_rapier3d::prelude::{Collider, ColliderMassProperties, ColliderScale, RigidBody};
use bevy_rapier3d::rapier::geometry::SharedShape;

use super::placement::Stretch;
use crate::bevy::jobs::Jobs;
use crate::bevy::jobs::baked::BakedDecomposition;
use crate::bevy::jobs::request::ColliderRequest;
use crate::bevy::tag::outcomes::DecompositionError;
use crate::bevy::tag::parameters::Goal;
use crate::bevy::tag::{ConvexDecomposition, NoConvexDecomposition};

/// What has any of these is left out of the input above it, with all below it.
pub(super) type InputBoundary = Or<(
    With<ConvexDecomposition>,
    With<BakedDecomposition>,
    With<RigidBody>,
    With<NoConvexDecomposition>,
)>;

/// What an entity requests, at the scale that it had then.
#[derive(Debug, Clone)]
pub(crate) struct Requested {
    pub request: Arc<ColliderRequest>,
    pub stretch: Stretch,
}

impl Requested {
    pub(super) fn uses(&self, asset: UntypedAssetId) -> bool {
        self.request.input.uses(asset)
    }
}

/// On entities with a collider of the plugin's: what it was made from.
#[derive(Component, Debug, Clone)]
pub(crate) struct AttachedCollider {
    pub requested: Requested,
    /// Whether the plugin set the mass properties, or found them set.
    pub owns_mass: bool,
}

/// On entities that have their fallback collider.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct AttachedFallback {
    /// Whether the plugin set the mass properties, or found them set.
    pub owns_mass: bool,
}

/// On entities that failed: what they requested, to detect when another attempt may succeed.
#[derive(Component, Debug, Clone)]
pub(super) struct FailedRequest {
    pub requested: Requested,
    pub error: DecompositionError,
}

impl FailedRequest {
    /// Whether it may succeed when an asset is there.
    pub(super) fn lacks_asset(&self) -> bool {
        self.error == DecompositionError::NotLoaded
    }

    /// Whether it may succeed at another scale. A mesh that is bad in itself stays so.
    pub(super) fn depends_on_scale(&self) -> bool {
        let is_of_shape = matches!(self.error, DecompositionError::Collider(_));
        is_of_shape || self.requested.request.goal.as_ref().is_some_and(Goal::has_absolute_length)
    }
}

/// On entities that are too far from every focus.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct FarFromFocus;

/// On entities that are too small: the scale that they had then.
#[derive(Component, Debug, Clone, Copy)]
pub(super) struct TooSmallAt(pub Stretch);

/// Gives an entity a collider, and records by `record` that it is the plugin's.
pub(super) fn attach_shape(entity: &mut EntityCommands, shape: SharedShape, record: impl Bundle) {
    // The scale is in the points; bevy_rapier must not apply it again.
    entity.try_insert((Collider::from(shape), ColliderScale::Absolute(Vec3::ONE), record));
}

/// Takes from an entity the collider that has a record `T`.
pub(super) fn detach<T: Component>(entity: &mut EntityCommands, owns_mass: bool) {
    entity.try_remove::<(Collider, ColliderScale, T)>();
    if owns_mass {
        entity.try_remove::<ColliderMassProperties>();
    }
}

/// An entity that is not finished.
#[derive(Debug)]
struct Entry {
    /// `None` until its meshes are known.
    requested: Option<Requested>,
    /// When it was tagged, or changed.
    since: Instant,
    /// Whether the log says that it waits for a mesh.
    is_wait_logged: bool,
}

/// The entities that are not finished, and those whose scale changes.
#[derive(Resource, Default)]
pub(crate) struct Unfinished {
    entries: EntityHashMap<Entry>,
    /// Entities that were tagged since everything was finished.
    entered: usize,
    /// Entities whose meshes are not known yet.
    unresolved: VecDeque<Entity>,
    /// Entities whose scale changed, to what, and when it last did.
    rescaling: EntityHashMap<(Stretch, Instant)>,
}

impl Unfinished {
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// Entities that were tagged since everything was finished, at least those that are not.
    pub(crate) fn entered(&self) -> usize {
        self.entered.max(self.len())
    }

    /// Counts from here on.
    pub(crate) fn begin_anew(&mut self) {
        self.entered = 0;
    }

    pub(super) fn is_idle(&self) -> bool {
        self.entries.is_empty() && self.rescaling.is_empty()
    }

    pub(crate) fn contains(&self, entity: Entity) -> bool {
        self.entries.contains_key(&entity)
    }

    pub(super) fn entities(&self) -> impl Iterator<Item = Entity> {
        self.entries.keys().copied()
    }

    /// What an entity requests, once its meshes are known.
    pub(super) fn requested(&self, entity: Entity) -> Option<&Requested> {
        self.entries.get(&entity)?.requested.as_ref()
    }

    /// Entities whose request uses an asset.
    pub(super) fn users(&self, asset: UntypedAssetId) -> impl Iterator<Item = Entity> {
        let uses = move |entry: &Entry| entry.requested.as_ref().is_some_and(|of| of.uses(asset));
        self.entries.iter().filter(move |(_, entry)| uses(entry)).map(|(entity, _)| *entity)
    }

    /// Whether an entity is to be resolved anyway.
    pub(super) fn is_unresolved(&self, entity: Entity) -> bool {
        self.entries.get(&entity).is_some_and(|entry| entry.requested.is_none())
    }

    pub(super) fn unresolved(&self) -> usize {
        self.unresolved.len()
    }

    pub(super) fn pop_unresolved(&mut self) -> Option<Entity> {
        self.unresolved.pop_front()
    }

    /// The meshes of an entity are not there yet. Whether it has waited for longer than `patience`, which is said
    /// once.
    pub(super) fn resolve_later(&mut self, entity: Entity, patience: Option<Duration>) -> bool {
        self.unresolved.push_back(entity);
        let Some((patience, entry)) = patience.zip(self.entries.get_mut(&entity)) else {
            return false;
        };
        let is_overdue = !entry.is_wait_logged && entry.since.elapsed() >= patience;
        entry.is_wait_logged |= is_overdue;
        is_overdue
    }

    pub(super) fn resolve(&mut self, entity: Entity, requested: Requested) {
        if let Some(entry) = self.entries.get_mut(&entity) {
            entry.requested = Some(requested);
        }
    }

    /// An entity is finished: how long that took, and what it had requested. `None` if it was forgotten.
    pub(super) fn end(&mut self, entity: Entity) -> Option<(Duration, Option<Requested>)> {
        let entry = self.entries.remove(&entity)?;
        Some((entry.since.elapsed(), entry.requested))
    }

    /// Notes a scale that is another than the one that is baked, or that was noted before.
    pub(super) fn detect_scale(&mut self, entity: Entity, baked: &Stretch, present: Stretch) {
        let last = self.rescaling.get(&entity).map_or(baked, |(stretch, _)| stretch);
        if present.differs(last) {
            self.rescaling.insert(entity, (present, Instant::now()));
        }
    }

    /// Entities whose scale changed, and has not for as long as this.
    pub(super) fn rescaled(&self, delay: Duration) -> Vec<Entity> {
        let is_due = |since: &Instant| since.elapsed() >= delay;
        let due = self.rescaling.iter().filter(|(_, (_, since))| is_due(since));
        due.map(|(entity, _)| *entity).collect()
    }
}

/// The work for entities, from the tag to the collider.
#[derive(SystemParam)]
pub(crate) struct Work<'w> {
    pub unfinished: ResMut<'w, Unfinished>,
    pub jobs: ResMut<'w, Jobs>,
}

impl Work<'_> {
    /// Restarts an entity from its tag.
    pub(super) fn restart(&mut self, entity: Entity) {
        let was_finished = !self.forget(entity);
        let unfinished = &mut *self.unfinished;
        unfinished.entered += usize::from(was_finished);
        let entry = Entry { requested: None, since: Instant::now(), is_wait_logged: false };
        unfinished.entries.insert(entity, entry);
        unfinished.unresolved.push_back(entity);
    }

    /// Stops all work that is only done for this entity. Whether it was unfinished.
    pub(super) fn forget(&mut self, entity: Entity) -> bool {
        self.unfinished.rescaling.remove(&entity);
        let was_unfinished = self.unfinished.end(entity).is_some();
        if was_unfinished {
            self.unfinished.unresolved.retain(|other| *other != entity);
            self.jobs.forget(entity);
        }
        was_unfinished
    }
}
