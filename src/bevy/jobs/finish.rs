//! Takes the results of finished jobs.

use bevy::prelude::*;
use bevy::tasks::{block_on, poll_once};

use crate::MethodReport;
use crate::bevy::jobs::budget::Budget;
use crate::bevy::jobs::cache::ColliderGeometry;
use crate::bevy::jobs::queue::{Completed, Job, WorkQueue, Worker};
use crate::bevy::jobs::task::{BuiltCollider, TaskOutput};
use crate::bevy::tag::error::DecompositionError;
use crate::bevy::tag::settings::HullwrightSettings;
use crate::bevy::tag::status::{
    DecompositionCounters, DecompositionStatus, HullSource, WaitReason,
};

/// Smaller steps of progress are not worth a change of the status.
const PROGRESS_STEP: f32 = 0.01;

/// Takes the results of finished jobs, and shows the progress of the others.
pub fn finish_jobs(
    mut queue: ResMut<WorkQueue>,
    mut counters: ResMut<DecompositionCounters>,
    settings: Res<HullwrightSettings>,
    mut statuses: Query<&mut DecompositionStatus>,
) {
    let queue = &mut *queue;
    queue.frame_time.start_frame();
    let mut budget = queue.frame_time.budget(&settings);
    let mut index = 0;
    while let Some(job) = queue.jobs.get_mut(index) {
        if let Some(result) = result_of(job, &mut budget) {
            let job = queue.jobs.remove(index);
            match result {
                Ok(TaskOutput::Built(built)) => {
                    count_decomposition(&mut counters, &built);
                    complete(queue, job, &built);
                }
                Ok(TaskOutput::InProgress(key)) => {
                    queue.known.insert(job.input.clone(), Ok(key));
                    put_back(queue, &job, &mut statuses);
                }
                Err(error) => queue.fail(&job.input, &job.entities, error),
            }
        } else {
            show_progress(job, &mut statuses);
            index += 1;
        }
    }
    queue.frame_time.spend(&budget);
}

fn result_of(job: &mut Job, budget: &mut Budget) -> Option<Result<TaskOutput, DecompositionError>> {
    match &mut job.worker {
        Worker::Background(task) if task.is_finished() => block_on(poll_once(task)),
        Worker::Background(_) => None,
        Worker::Slices(task) => {
            while budget.allows_one() {
                let result = task.step(&job.control).transpose();
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

fn count_decomposition(counters: &mut DecompositionCounters, built: &BuiltCollider) {
    let (HullSource::Decomposed, ColliderGeometry::Hulls(file)) = (built.source, &*built.geometry)
    else {
        return;
    };
    // One hull on request is none.
    if file.method == MethodReport::Hull.name() {
        return;
    }
    let share = |length: f64| (length / file.diagonal) as f32;
    counters.decomposed += 1;
    counters.last_bound = file.bound.map(share);
    counters.last_protrusion = file.verified.map(|errors| share(errors.protrusion_max));
}

/// The first entity of a job gets what was made for it, the others share it.
fn complete(queue: &mut WorkQueue, job: Job, built: &BuiltCollider) {
    queue.known.insert(job.input, Ok(built.key));
    for (place, entity) in job.entities.into_iter().enumerate() {
        let Some(request) = queue.request(entity).cloned() else { continue };
        let is_other = place > 0 && built.source == HullSource::Decomposed;
        let source = if is_other { HullSource::Shared } else { built.source };
        let built = BuiltCollider { source, ..built.clone() };
        queue.completed.push_back(Completed { entity, request, built });
    }
}

/// Another job is at work on the same content: these entities wait for its result.
fn put_back(queue: &mut WorkQueue, job: &Job, statuses: &mut Query<&mut DecompositionStatus>) {
    for &entity in &job.entities {
        if let Some(unfinished) = queue.unfinished.get_mut(&entity) {
            unfinished.is_running = false;
            queue.to_start.push(entity);
        }
        if let Ok(mut status) = statuses.get_mut(entity) {
            *status = DecompositionStatus::Waiting(WaitReason::InQueue);
        }
    }
}
