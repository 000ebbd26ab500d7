//! Starts jobs for entities in the queue.

use std::sync::Arc;

use bevy::asset::AssetId;
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::bevy::jobs::baked::BakedHulls;
use crate::bevy::jobs::baked_scene::BakedScene;
use crate::bevy::jobs::budget::Budget;
use crate::bevy::jobs::cache::{ColliderGeometry, GeometryCache};
use crate::bevy::jobs::content::ContentKey;
use crate::bevy::jobs::mesh_data::read_parts;
use crate::bevy::jobs::pool::pool;
use crate::bevy::jobs::priority::Priority;
use crate::bevy::jobs::queue::{Completed, Failed, Job, WorkQueue, Worker};
use crate::bevy::jobs::request::{ColliderRequest, InputId};
use crate::bevy::jobs::task::{
    BuiltCollider, DecompositionTask, SharedProgress, TaskInput, contain_panics,
};
use crate::bevy::tag::error::DecompositionError;
use crate::bevy::tag::outcomes::Outcomes;
use crate::bevy::tag::settings::{Execution, HullwrightSettings};
use crate::bevy::tag::status::{DecompositionStatus, HullSource};

/// Starts jobs for those in the queue, the nearest to a focus first, as far as jobs and time
/// allow.
pub fn start_jobs(
    mut queue: ResMut<WorkQueue>,
    settings: Res<HullwrightSettings>,
    sources: Sources,
    priority: Priority,
    mut outcomes: Outcomes,
) {
    let queue = &mut *queue;
    let mut budget = queue.frame_time.budget(&settings);
    if queue.jobs.len() < most_jobs(&settings) {
        priority.sort(&mut queue.to_start);
    }
    let mut left = EntityHashSet::default();
    for index in 0..queue.to_start.len() {
        let Some(&entity) = queue.to_start.get(index) else { break };
        match start(queue, &settings, &sources, entity, &mut budget) {
            Started::Waits => {}
            Started::Ended => {
                left.insert(entity);
            }
            Started::Runs => {
                left.insert(entity);
                if let Some(unfinished) = queue.unfinished.get_mut(&entity) {
                    unfinished.is_running = true;
                }
                outcomes.show(entity, DecompositionStatus::Running { progress: 0.0 });
            }
        }
    }
    queue.to_start.retain(|entity| !left.contains(entity));
    queue.frame_time.spend(&budget);
    let counters = &mut outcomes.counters;
    if !queue.is_idle() || !counters.show_idle() {
        counters.running = queue.jobs.len();
        counters.queued = queue.to_start.len();
        counters.waiting_for_mesh = queue.to_resolve.len();
        (counters.cached, counters.cached_bytes) = sources.cache.size();
    }
}

fn most_jobs(settings: &HullwrightSettings) -> usize {
    match (settings.execution, settings.max_jobs) {
        (Execution::Slices, _) => 1,
        (Execution::Background, 0) => pool().thread_num().saturating_sub(1).max(1),
        (Execution::Background, most) => most,
    }
}

/// Jobs that are done within a frame wait in the pool, so that its threads do not wait for the next frame.
const QUICK_JOBS: usize = 32;

/// How many more jobs there may be for a request that takes no decomposition. A limit from the settings is not exceeded.
fn quick_jobs(settings: &HullwrightSettings, request: &ColliderRequest) -> usize {
    let is_baked = request.scene.is_some() || matches!(*request.input, InputId::Baked(_));
    let is_quick = is_baked || request.why_triangles().is_some();
    let has_pool = settings.execution == Execution::Background && settings.max_jobs == 0;
    if is_quick && has_pool { QUICK_JOBS } else { 0 }
}

/// What became of an entity in the queue.
enum Started {
    /// It stays in the queue.
    Waits,
    /// A job is at work on it.
    Runs,
    /// It has a result or an error, or nothing to wait for.
    Ended,
}

fn start(
    queue: &mut WorkQueue,
    settings: &HullwrightSettings,
    sources: &Sources,
    entity: Entity,
    budget: &mut Budget,
) -> Started {
    let Some(request) = queue.request(entity).cloned() else { return Started::Ended };
    match next_step(queue, &sources.cache, &request) {
        NextStep::Wait => Started::Waits,
        NextStep::Join(job) => {
            if let Some(job) = queue.jobs.get_mut(job) {
                job.entities.push(entity);
            }
            Started::Runs
        }
        NextStep::Complete(built) => {
            queue.completed.push_back(Completed { entity, request, built });
            Started::Ended
        }
        NextStep::Fail(error) => {
            queue.failed.push(Failed { entity, error, is_known: true });
            Started::Ended
        }
        NextStep::StartJob
            if queue.jobs.len() >= most_jobs(settings) + quick_jobs(settings, &request)
                || !budget.allows_one() =>
        {
            Started::Waits
        }
        NextStep::StartJob => {
            match sources.task_input(queue, &request) {
                Ok(input) => {
                    let job = job(settings, &sources.cache, entity, &request, input);
                    queue.jobs.push(job);
                }
                Err(error) => queue.fail(&request.input, &[entity], error),
            }
            Started::Runs
        }
    }
}

enum NextStep {
    /// A job with this number makes the same.
    Join(usize),
    Complete(BuiltCollider),
    /// The same input failed before.
    Fail(DecompositionError),
    StartJob,
    /// Another job is at work on the same input.
    Wait,
}

fn next_step(queue: &WorkQueue, cache: &GeometryCache, request: &ColliderRequest) -> NextStep {
    let map = request.map_key();
    let has_same_input = |job: &Job| job.input == request.input;
    if let Some(job) = queue.jobs.iter().position(|job| has_same_input(job) && job.map == map) {
        return NextStep::Join(job);
    }
    match queue.known.get(&request.input) {
        Some(Err(error)) => NextStep::Fail(error.clone()),
        Some(Ok(key)) => {
            if let Some((geometry, shape)) = cache.shape(*key, map) {
                let source = HullSource::Shared;
                return NextStep::Complete(BuiltCollider { key: *key, geometry, shape, source });
            }
            let is_there = cache.geometry(*key).is_some();
            if !is_there && cache.is_claimed(*key) { NextStep::Wait } else { NextStep::StartJob }
        }
        None if queue.jobs.iter().any(has_same_input) => NextStep::Wait,
        None => NextStep::StartJob,
    }
}

fn job(
    settings: &HullwrightSettings,
    cache: &GeometryCache,
    entity: Entity,
    request: &ColliderRequest,
    input: TaskInput,
) -> Job {
    let progress = SharedProgress::default();
    let control = progress.control();
    let task = DecompositionTask::new(input, request.map, cache.clone(), settings);
    let worker = match settings.execution {
        Execution::Slices => Worker::Slices(Box::new(task)),
        Execution::Background => {
            let control = control.clone();
            let run = move || task.run(&control);
            Worker::Background(pool().spawn(async move { contain_panics(run) }))
        }
    };
    Job {
        input: request.input.clone(),
        map: request.map_key(),
        entities: vec![entity],
        control,
        progress,
        shown_progress: 0.0,
        worker,
    }
}

/// What jobs are made from.
#[derive(SystemParam)]
pub struct Sources<'w> {
    cache: Res<'w, GeometryCache>,
    meshes: Res<'w, Assets<Mesh>>,
    baked: Res<'w, Assets<BakedHulls>>,
    scenes: Res<'w, Assets<BakedScene>>,
}

impl Sources<'_> {
    fn task_input(
        &self,
        queue: &WorkQueue,
        request: &ColliderRequest,
    ) -> Result<TaskInput, DecompositionError> {
        if let InputId::Baked(id) = *request.input {
            return self.baked_input(id);
        }
        if let Some(Ok(key)) = queue.known.get(&request.input)
            && let Some(geometry) = self.cache.geometry(*key)
        {
            return Ok(TaskInput::Geometry { key: *key, geometry, source: HullSource::Shared });
        }
        let data = read_parts(&request.parts, &request.map_before, &self.meshes)?;
        // Only baked hulls have no goal, and they are found above.
        let goal = request.goal.clone().ok_or(DecompositionError::NotLoaded)?;
        let scene = request.scene.and_then(|scene| self.scenes.get(scene));
        let baked = scene.map(BakedScene::geometry);
        Ok(TaskInput::Mesh { data, goal, baked })
    }

    fn baked_input(&self, id: AssetId<BakedHulls>) -> Result<TaskInput, DecompositionError> {
        let key = ContentKey::Baked(id);
        let of_asset = || {
            let BakedHulls(file) = self.baked.get(id)?;
            Some(Arc::new(ColliderGeometry::Hulls(Box::new(file.clone()))))
        };
        let geometry = self.cache.geometry(key).or_else(of_asset);
        let geometry = geometry.ok_or(DecompositionError::NotLoaded)?;
        Ok(TaskInput::Geometry { key, geometry, source: HullSource::Baked })
    }
}
