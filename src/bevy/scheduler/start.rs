//! Jobs begin, go on and end here. Nothing waits for them.

use std::cmp::Ordering;
use std::time::Duration;

use bevy::asset::AssetId;
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, TaskPool, block_on, poll_once};

use super::baked::BakedHulls;
use super::failing::Failure;
use super::job::{Machine, Made, Outcome, ProgressCell, Task};
use super::library::{Content, Library, Material};
use super::mesh_data::read_parts;
use super::resolve::Scene;
use super::work::{Ask, Budget, Delivery, Job, SourceId, Work, Worker};
use super::{
    DecompositionCounters, DecompositionFailure, DecompositionFocus, DecompositionStatus,
    Execution, HullwrightSettings, Origin, Wait,
};

/// Steps of progress that a status shows: smaller ones are not worth a change.
const PROGRESS_STEP: f32 = 0.01;

/// Takes the results of finished jobs, and shows the progress of the others.
pub(super) fn finish_jobs(
    mut work: ResMut<Work>,
    mut counters: ResMut<DecompositionCounters>,
    settings: Res<HullwrightSettings>,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let work = &mut *work;
    work.spent = Duration::ZERO;
    let mut budget = work.budget(&settings);
    let mut index = 0;
    while let Some(job) = work.jobs.get_mut(index) {
        if let Some(result) = result_of(job, &mut budget) {
            let job = work.jobs.remove(index);
            take_result(work, &mut counters, job, result, &mut statuses);
        } else {
            show_progress(job, &mut statuses);
            index += 1;
        }
    }
    work.spend(&budget);
}

fn result_of(job: &mut Job, budget: &mut Budget) -> Option<Result<Outcome, DecompositionFailure>> {
    match &mut job.worker {
        Worker::Thread(task) => {
            if task.is_finished() {
                block_on(poll_once(task))
            } else {
                None
            }
        }
        Worker::Slices(machine) => {
            while budget.allows_one() {
                let result = machine.step(&job.control).transpose();
                if result.is_some() {
                    return result;
                }
            }
            None
        }
    }
}

fn show_progress(job: &mut Job, statuses: &mut Query<&mut DecompositionStatus>) {
    let progress = job.progress.get();
    if progress < job.shown_progress + PROGRESS_STEP {
        return;
    }
    job.shown_progress = progress;
    for entity in &job.entities {
        if let Ok(mut status) = statuses.get_mut(*entity) {
            *status = DecompositionStatus::Running { progress };
        }
    }
}

fn take_result(
    work: &mut Work,
    counters: &mut DecompositionCounters,
    job: Job,
    result: Result<Outcome, DecompositionFailure>,
    statuses: &mut Query<&mut DecompositionStatus>,
) {
    match result {
        Ok(Outcome::Made(made)) => {
            if let (Origin::Decomposed, Material::Hulls(file)) = (made.origin, &*made.material) {
                counters.decomposed += 1;
                let share = |length: f64| (length / file.diagonal) as f32;
                counters.last_bound = file.bound.map(share);
                counters.last_phantom = file.verified.map(|errors| share(errors.phantom_max));
            }
            work.known.insert(job.source.clone(), Ok(made.content));
            for (place, entity) in job.entities.into_iter().enumerate() {
                let ask = work.requests.get(&entity).and_then(|request| request.ask.clone());
                let Some(ask) = ask else { continue };
                let is_other = place > 0 && made.origin == Origin::Decomposed;
                let origin = if is_other { Origin::Shared } else { made.origin };
                work.deliveries.push_back(Delivery {
                    entity,
                    ask,
                    made: Made { origin, ..made.clone() },
                });
            }
        }
        Ok(Outcome::InWork(content)) => {
            work.known.insert(job.source.clone(), Ok(content));
            for entity in job.entities {
                if let Some(request) = work.requests.get_mut(&entity) {
                    request.is_running = false;
                    work.queue.push(entity);
                }
                if let Ok(mut status) = statuses.get_mut(entity) {
                    *status = DecompositionStatus::Waiting(Wait::InQueue);
                }
            }
        }
        Err(failure) => fail(work, &job.source, &job.entities, failure),
    }
}

fn fail(
    work: &mut Work,
    source: &std::sync::Arc<SourceId>,
    entities: &[Entity],
    failure: DecompositionFailure,
) {
    // A scale that flattens is no fault of the mesh, and what is not there may yet come.
    if !matches!(failure, DecompositionFailure::Collider(_) | DecompositionFailure::NotLoaded) {
        work.known.insert(source.clone(), Err(failure.clone()));
    }
    let of = |entity: &Entity| Failure { entity: *entity, why: failure.clone(), is_known: false };
    work.failures.extend(entities.iter().map(of));
}

/// Begins jobs for those in the queue, the nearest to a focus first, as far as jobs and time
/// allow.
pub(super) fn start_jobs(
    mut work: ResMut<Work>,
    mut counters: ResMut<DecompositionCounters>,
    settings: Res<HullwrightSettings>,
    library: Res<Library>,
    scene: Scene,
    near: Near,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let work = &mut *work;
    let mut budget = work.budget(&settings);
    let most = most_jobs(&settings);
    if !work.queue.is_empty() {
        if work.jobs.len() < most {
            near.sort(&mut work.queue);
        }
        let mut begun = EntityHashSet::default();
        for index in 0..work.queue.len() {
            let entity = work.queue[index];
            let ask = work.requests.get(&entity).and_then(|request| request.ask.clone());
            let Some(ask) = ask else {
                begun.insert(entity);
                continue;
            };
            let is_begun = match place_for(work, &library, &ask) {
                Place::Later => false,
                Place::Join(job) => {
                    work.jobs[job].entities.push(entity);
                    true
                }
                Place::Ready(made) => {
                    work.deliveries.push_back(Delivery { entity, ask, made });
                    begun.insert(entity);
                    continue;
                }
                Place::Failed(why) => {
                    work.failures.push(Failure { entity, why, is_known: true });
                    begun.insert(entity);
                    continue;
                }
                Place::New if work.jobs.len() >= most || !budget.allows_one() => false,
                Place::New => {
                    match task_for(work, &library, &ask, &scene) {
                        Ok(task) => begin(work, &settings, &library, entity, &ask, task),
                        Err(failure) => fail(work, &ask.source, &[entity], failure),
                    }
                    true
                }
            };
            if is_begun {
                begun.insert(entity);
                if let Some(request) = work.requests.get_mut(&entity) {
                    request.is_running = true;
                }
                if let Ok(mut status) = statuses.get_mut(entity) {
                    *status = DecompositionStatus::Running { progress: 0.0 };
                }
            }
        }
        work.queue.retain(|entity| !begun.contains(entity));
    }
    work.spend(&budget);
    if !work.is_idle() || counters.running + counters.queued + counters.waiting_for_mesh > 0 {
        counters.running = work.jobs.len();
        counters.queued = work.queue.len();
        counters.waiting_for_mesh = work.to_resolve.len();
        (counters.cached, counters.cached_bytes) = library.size();
    }
}

fn most_jobs(settings: &HullwrightSettings) -> usize {
    match (settings.execution, settings.max_jobs) {
        (Execution::Slices, _) => 1,
        (Execution::Background, 0) => pool().thread_num().saturating_sub(1).max(1),
        (Execution::Background, most) => most,
    }
}

/// Bevy's task pool plugin makes it; without that plugin it is made here.
pub(super) fn pool() -> &'static AsyncComputeTaskPool {
    AsyncComputeTaskPool::get_or_init(TaskPool::default)
}

enum Place {
    Join(usize),
    Ready(Made),
    /// Others that wanted the same failed.
    Failed(DecompositionFailure),
    New,
    /// Another job is at work on the same input.
    Later,
}

fn place_for(work: &Work, library: &Library, ask: &Ask) -> Place {
    let map = ask.map_key();
    let same_source = |job: &Job| job.source == ask.source;
    if let Some(job) = work.jobs.iter().position(|job| same_source(job) && job.map == map) {
        return Place::Join(job);
    }
    match work.known.get(&ask.source) {
        Some(Err(failure)) => Place::Failed(failure.clone()),
        Some(Ok(content)) => {
            if let Some((material, shape)) = library.shape(*content, map) {
                let origin = Origin::Shared;
                return Place::Ready(Made { content: *content, material, shape, origin });
            }
            let is_there = library.material(*content).is_some();
            if !is_there && library.is_claimed(*content) { Place::Later } else { Place::New }
        }
        _ if work.jobs.iter().any(same_source) => Place::Later,
        _ => Place::New,
    }
}

fn task_for(
    work: &Work,
    library: &Library,
    ask: &Ask,
    scene: &Scene,
) -> Result<Task, DecompositionFailure> {
    if let SourceId::Baked(id) = *ask.source {
        return baked_task(id, library, scene);
    }
    if let Some(Ok(content)) = work.known.get(&ask.source)
        && let Some(material) = library.material(*content)
    {
        return Ok(Task::Shape { content: *content, material, origin: Origin::Shared });
    }
    let data = read_parts(&ask.parts, &ask.before, scene.meshes())?;
    Ok(Task::Mesh { data, parameters: ask.parameters.clone() })
}

fn baked_task(
    id: AssetId<BakedHulls>,
    library: &Library,
    scene: &Scene,
) -> Result<Task, DecompositionFailure> {
    let content = Content::Baked(id);
    let material = library.material(content).or_else(|| scene.baked_material(id));
    let material = material.ok_or(DecompositionFailure::NotLoaded)?;
    Ok(Task::Shape { content, material, origin: Origin::Baked })
}

fn begin(
    work: &mut Work,
    settings: &HullwrightSettings,
    library: &Library,
    entity: Entity,
    ask: &Ask,
    task: Task,
) {
    let progress = ProgressCell::default();
    let control = progress.control();
    let cache = settings.disk_cache.clone();
    let machine = Machine::new(task, ask.map, library.clone(), settings.cache_bytes, cache);
    let worker = match settings.execution {
        Execution::Slices => Worker::Slices(Box::new(machine)),
        Execution::Background => {
            let control = control.clone();
            let run = move || machine.run(&control);
            Worker::Thread(pool().spawn(async move { catch_defects(run) }))
        }
    };
    work.jobs.push(Job {
        source: ask.source.clone(),
        map: ask.map_key(),
        entities: vec![entity],
        control,
        progress,
        shown_progress: 0.0,
        worker,
    });
}

/// A defect of ours shall cost a collider, not the game.
fn catch_defects(
    run: impl FnOnce() -> Result<Outcome, DecompositionFailure>,
) -> Result<Outcome, DecompositionFailure> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(run))
        .unwrap_or(Err(DecompositionFailure::Lost))
}

/// What the queue is sorted by.
#[derive(SystemParam)]
pub(super) struct Near<'w, 's> {
    focuses: Query<'w, 's, Entity, With<DecompositionFocus>>,
    places: TransformHelper<'w, 's>,
}

impl Near<'_, '_> {
    /// Stable, so that without a focus those that came first go first. What has no place goes last.
    fn sort(&self, queue: &mut [Entity]) {
        // Also in the frame in which they are spawned, when `GlobalTransform` is not known yet.
        let place = |entity| Some(self.places.compute_global_transform(entity).ok()?.translation());
        let focuses: Vec<Vec3> = self.focuses.iter().filter_map(place).collect();
        if focuses.is_empty() {
            return;
        }
        let distance = |place: Vec3| {
            focuses.iter().map(|focus| focus.distance_squared(place)).fold(f32::INFINITY, f32::min)
        };
        queue.sort_by_cached_key(|entity| Nearness(place(*entity).map_or(f32::INFINITY, distance)));
    }
}

#[derive(PartialEq)]
struct Nearness(f32);

impl Eq for Nearness {}

impl PartialOrd for Nearness {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Nearness {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_that_panics_is_lost_and_says_so() {
        let result = catch_defects(|| panic!("on purpose, in a test"));
        assert!(matches!(result, Err(DecompositionFailure::Lost)));
        assert!(DecompositionFailure::Lost.to_string().contains("without a result"));
    }

    #[test]
    fn a_job_that_fails_says_why() {
        let result = catch_defects(|| Err(DecompositionFailure::NoPositions));
        assert!(matches!(result, Err(DecompositionFailure::NoPositions)));
    }
}
