//! Who waits for what: the requests of entities, the queue, the jobs.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use bevy::asset::AssetId;
use bevy::ecs::entity::EntityHashMap;
use bevy::math::Affine3A;
use bevy::platform::collections::HashMap;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy_rapier3d::rapier::geometry::SharedShape;

use crate::{Control, Parameters};

use super::baked::BakedHulls;
use super::failing::Failure;
use super::job::{Machine, Made, Outcome, ProgressCell};
use super::library::Content;
use super::mesh_data::Part;
use super::placement::{MapKey, Stretch};
use super::{DecompositionFailure, HullwrightSettings};

/// Names what a collider is made from without looking into it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum SourceId {
    Mesh {
        parts: Vec<(AssetId<Mesh>, MapKey)>,
        /// Hash of what to make of it.
        recipe: [u8; 32],
        /// Applied before the work.
        before: MapKey,
    },
    Baked(AssetId<BakedHulls>),
}

impl SourceId {
    pub(super) fn uses_mesh(&self, id: AssetId<Mesh>) -> bool {
        match self {
            Self::Mesh { parts, .. } => parts.iter().any(|(mesh, _)| *mesh == id),
            Self::Baked(_) => false,
        }
    }
}

/// What an entity wants.
#[derive(Debug)]
pub(super) struct Ask {
    pub source: Arc<SourceId>,
    pub parts: Vec<Part>,
    /// `None` for the triangles as they are.
    pub parameters: Option<Parameters>,
    /// Baked before the work, and after it.
    pub before: Affine3A,
    pub map: Affine3A,
    pub stretch: Stretch,
}

impl Ask {
    /// Whether it is for the triangles as they are.
    pub(super) fn is_exact(&self) -> bool {
        self.parameters.is_none() && matches!(*self.source, SourceId::Mesh { .. })
    }

    pub(super) fn map_key(&self) -> MapKey {
        MapKey::new(&self.map)
    }
}

/// An entity that is not finished.
#[derive(Debug)]
pub(super) struct Request {
    /// `None` until its meshes are known.
    pub ask: Option<Arc<Ask>>,
    /// Whether it has its turn in a job.
    pub is_running: bool,
}

/// Work for one or several entities that want the same.
pub(super) struct Job {
    pub source: Arc<SourceId>,
    pub map: MapKey,
    pub entities: Vec<Entity>,
    pub control: Control,
    pub progress: ProgressCell,
    pub shown_progress: f32,
    pub worker: Worker,
}

pub(super) enum Worker {
    Thread(bevy::tasks::Task<Result<Outcome, DecompositionFailure>>),
    Slices(Box<Machine>),
}

/// A result on its way to its entity.
pub(super) struct Delivery {
    pub entity: Entity,
    pub ask: Arc<Ask>,
    pub made: Made,
}

/// A stand-in in the making.
pub(super) struct StandInJob {
    pub entity: Entity,
    pub task: bevy::tasks::Task<Option<SharedShape>>,
}

/// All that is going on.
#[derive(Resource, Default)]
pub(super) struct Work {
    pub requests: EntityHashMap<Request>,
    /// Whose meshes are not known yet.
    pub to_resolve: VecDeque<Entity>,
    /// Who waits for a job.
    pub queue: Vec<Entity>,
    pub jobs: Vec<Job>,
    pub deliveries: VecDeque<Delivery>,
    pub failures: Vec<Failure>,
    /// What is known of sources without looking into them.
    pub known: HashMap<Arc<SourceId>, Result<Content, DecompositionFailure>>,
    /// Who wants a stand-in.
    pub to_fill: VecDeque<Entity>,
    pub stand_ins: Vec<StandInJob>,
    /// Time that the systems have taken in this frame.
    pub spent: Duration,
    /// Whose scale changed, to what, and when it last did.
    pub rescaling: EntityHashMap<(Stretch, Instant)>,
}

impl Work {
    /// Begins anew with an entity.
    pub(super) fn restart(&mut self, entity: Entity) {
        self.forget(entity);
        self.requests.insert(entity, Request { ask: None, is_running: false });
        self.to_resolve.push_back(entity);
    }

    /// Stops all work that is only done for this entity. Whether there was any request of it.
    pub(super) fn forget(&mut self, entity: Entity) -> bool {
        self.rescaling.remove(&entity);
        self.stand_ins.retain(|job| job.entity != entity);
        self.to_fill.retain(|other| *other != entity);
        let Some(request) = self.requests.remove(&entity) else { return false };
        self.to_resolve.retain(|other| *other != entity);
        self.queue.retain(|other| *other != entity);
        self.deliveries.retain(|delivery| delivery.entity != entity);
        if request.is_running {
            for job in &mut self.jobs {
                job.entities.retain(|other| *other != entity);
            }
            // A dropped task is not waited for; its thread stops at the next look at the control.
            self.jobs.retain(|job| {
                let is_wanted = !job.entities.is_empty();
                if !is_wanted {
                    job.control.cancel();
                }
                is_wanted
            });
        }
        true
    }

    /// Has a scale baked anew that changed while the work went on: that change came before there
    /// was anything to compare it with.
    pub(super) fn notice_missed_scale(
        &mut self,
        entity: Entity,
        baked: &Stretch,
        present: Stretch,
    ) {
        if present.differs(baked) {
            self.rescaling.insert(entity, (present, Instant::now()));
        }
    }

    /// Whether an entity is to be looked at anyway.
    pub(super) fn is_to_be_resolved(&self, entity: Entity) -> bool {
        self.requests.get(&entity).is_some_and(|request| request.ask.is_none())
    }

    /// The time that a system may take: what the others have left of the frame's budget.
    pub(super) fn budget(&self, settings: &HullwrightSettings) -> Budget {
        let length = settings.frame_budget.saturating_sub(self.spent);
        Budget { start: Instant::now(), length, has_begun: false }
    }

    /// Says what a system has taken.
    pub(super) fn spend(&mut self, budget: &Budget) {
        self.spent += budget.start.elapsed();
    }

    /// Forgets what was made from a mesh.
    pub(super) fn forget_mesh(&mut self, id: AssetId<Mesh>) {
        self.known.retain(|source, _| !source.uses_mesh(id));
    }

    pub(super) fn is_idle(&self) -> bool {
        self.requests.is_empty() && self.failures.is_empty() && self.rescaling.is_empty()
    }
}

/// The time that a system may take in this frame.
pub(super) struct Budget {
    start: Instant,
    length: Duration,
    has_begun: bool,
}

impl Budget {
    /// Whether there is time for another piece of work; for the first there always is.
    pub(super) fn allows_one(&mut self) -> bool {
        let allows = !self.has_begun || self.start.elapsed() < self.length;
        self.has_begun = true;
        allows
    }
}
