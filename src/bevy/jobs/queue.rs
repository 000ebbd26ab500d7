//! The state of all work: requests of entities, the queue, jobs, results.

use std::collections::VecDeque;
use std::sync::Arc;

use bevy::asset::AssetId;
use bevy::ecs::entity::EntityHashMap;
use bevy::platform::collections::HashMap;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::tasks::Task;
use bevy_rapier3d::rapier::geometry::SharedShape;

use crate::Control;

use crate::bevy::collider::placement::{MapKey, Stretch};
use crate::bevy::jobs::budget::FrameTime;
use crate::bevy::jobs::content::ContentKey;
use crate::bevy::jobs::request::{ColliderRequest, InputId};
use crate::bevy::jobs::task::{BuiltCollider, DecompositionTask, SharedProgress, TaskOutput};
use crate::bevy::tag::error::DecompositionError;

/// An entity that is not finished.
#[derive(Debug)]
pub(crate) struct UnfinishedEntity {
    /// `None` until its meshes are known.
    pub request: Option<Arc<ColliderRequest>>,
    /// Whether a job is at work on it.
    pub is_running: bool,
    /// When it was tagged, or changed.
    pub since: Instant,
    /// Whether the log says that it waits for a mesh.
    pub is_wait_logged: bool,
}

impl UnfinishedEntity {
    fn new() -> Self {
        Self { request: None, is_running: false, since: Instant::now(), is_wait_logged: false }
    }
}

/// Work for one or several entities with the same request.
pub(crate) struct Job {
    pub input: Arc<InputId>,
    pub map: MapKey,
    pub entities: Vec<Entity>,
    pub control: Control,
    pub progress: SharedProgress,
    pub shown_progress: f32,
    pub worker: Worker,
}

impl Job {
    /// Cancelled: a task that has not started is dropped, a running one stops at its next check.
    fn abandon(self) {
        self.control.cancel();
    }
}

pub(crate) enum Worker {
    Background(Task<Result<TaskOutput, DecompositionError>>),
    Slices(Box<DecompositionTask>),
}

/// A result on its way to its entity.
pub(crate) struct Completed {
    pub entity: Entity,
    pub request: Arc<ColliderRequest>,
    pub built: BuiltCollider,
}

/// An error on its way to its entity.
#[derive(Debug)]
pub(crate) struct Failed {
    pub entity: Entity,
    pub error: DecompositionError,
    /// Whether the same input failed before, which was logged then.
    pub is_known: bool,
}

/// Fallback colliders to be made.
#[derive(Default)]
pub(crate) struct FallbackQueue {
    pub waiting: VecDeque<Entity>,
    pub jobs: Vec<(Entity, Task<Option<SharedShape>>)>,
}

/// The state of all work.
#[derive(Resource, Default)]
pub(crate) struct WorkQueue {
    pub unfinished: EntityHashMap<UnfinishedEntity>,
    /// Entities that were tagged since everything was finished.
    pub entered: usize,
    /// Entities whose meshes are not known yet.
    pub to_resolve: VecDeque<Entity>,
    /// Entities that wait for a job.
    pub to_start: Vec<Entity>,
    pub jobs: Vec<Job>,
    pub completed: VecDeque<Completed>,
    pub failed: Vec<Failed>,
    /// Results of inputs that need no look into them.
    pub known: HashMap<Arc<InputId>, Result<ContentKey, DecompositionError>>,
    pub fallbacks: FallbackQueue,
    pub frame_time: FrameTime,
    /// Entities whose scale changed, to what, and when it last did.
    pub rescaling: EntityHashMap<(Stretch, Instant)>,
}

impl WorkQueue {
    /// Restarts an entity from its tag.
    pub(crate) fn restart(&mut self, entity: Entity) {
        if !self.forget(entity) {
            self.entered += 1;
        }
        self.unfinished.insert(entity, UnfinishedEntity::new());
        self.to_resolve.push_back(entity);
    }

    /// Stops all work that is only done for this entity. Whether it was unfinished.
    pub(crate) fn forget(&mut self, entity: Entity) -> bool {
        self.rescaling.remove(&entity);
        self.fallbacks.jobs.retain(|(other, _)| *other != entity);
        self.fallbacks.waiting.retain(|other| *other != entity);
        let Some(unfinished) = self.unfinished.remove(&entity) else { return false };
        self.to_resolve.retain(|other| *other != entity);
        self.to_start.retain(|other| *other != entity);
        self.completed.retain(|completed| completed.entity != entity);
        if unfinished.is_running {
            for job in &mut self.jobs {
                job.entities.retain(|other| *other != entity);
            }
            for job in self.jobs.extract_if(.., |job| job.entities.is_empty()) {
                job.abandon();
            }
        }
        true
    }

    /// The request of an entity that is not finished, once its meshes are known.
    pub(crate) fn request(&self, entity: Entity) -> Option<&Arc<ColliderRequest>> {
        self.unfinished.get(&entity)?.request.as_ref()
    }

    /// Whether an entity is to be resolved anyway.
    pub(crate) fn is_to_be_resolved(&self, entity: Entity) -> bool {
        self.unfinished.get(&entity).is_some_and(|unfinished| unfinished.request.is_none())
    }

    /// Schedules a scale that changed while the work went on, before there was a baked one to
    /// compare it with.
    pub(crate) fn detect_missed_scale(
        &mut self,
        entity: Entity,
        baked: &Stretch,
        present: Stretch,
    ) {
        if present.differs(baked) {
            self.rescaling.insert(entity, (present, Instant::now()));
        }
    }

    /// Fails an input, and the entities that requested it.
    pub(crate) fn fail(
        &mut self,
        input: &Arc<InputId>,
        entities: &[Entity],
        error: DecompositionError,
    ) {
        // Another scale may succeed, and a missing asset may be loaded later.
        if !matches!(error, DecompositionError::Collider(_) | DecompositionError::NotLoaded) {
            self.known.insert(input.clone(), Err(error.clone()));
        }
        let of =
            |entity: &Entity| Failed { entity: *entity, error: error.clone(), is_known: false };
        self.failed.extend(entities.iter().map(of));
    }

    /// Forgets what was made from a mesh.
    pub(crate) fn forget_mesh(&mut self, id: AssetId<Mesh>) {
        self.known.retain(|input, _| !input.uses_mesh(id));
    }

    pub(crate) fn is_idle(&self) -> bool {
        self.unfinished.is_empty() && self.failed.is_empty() && self.rescaling.is_empty()
    }
}
