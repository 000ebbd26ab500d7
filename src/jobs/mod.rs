//! Work for entities: requests wait, the first of them become jobs, jobs end in results. Nothing
//! waits for a job.

pub(super) mod baked;
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
mod browser;
pub(super) mod cache;
mod elsewhere;
mod kept;
pub(super) mod label;
mod level;
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
mod native;
mod platform;
mod pool;
mod progress;
#[cfg(feature = "bake")]
pub(super) mod recipe;
pub(super) mod request;
pub(super) mod task;

use std::cmp::Reverse;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use bevy::asset::{AssetEventSystems, UntypedAssetId};
use bevy::ecs::system::SystemParam;
use bevy::platform::collections::HashMap;
use bevy::platform::collections::hash_map::Entry;
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::tasks::{Task, TaskPool, block_on, poll_once};
use hullwright::{Control, MethodReport};

use self::baked::{BakedDecomposition, BakedScene, FromBakedScene, HullSceneLoader};
use self::cache::{BuiltCollider, ColliderGeometry, GeometryCache};
use self::label::{Labels, Outlines, is_for_gpu_only, note_outlines};
use self::level::PlacedData;
use self::pool::{Pool, decomposition_threads};
use self::progress::SharedProgress;
#[cfg(feature = "bake")]
use self::recipe::{HullRecipeLoader, HullRecipeProcessor};
use self::request::{ColliderRequest, ContentKey, InputId, MapKey, read_parts, read_placed};
use self::task::{DecompositionTask, TaskInput, TaskOutput, TaskResult, contain_panics};
use super::tag::outcomes::{
    DecompositionCounters, DecompositionError, DecompositionStatus, HullSource, Outcomes,
    WaitReason,
};
use super::tag::parameters::Goal;
use super::tag::settings::{BudgetSettings, Execution, HullwrightSettings, HullwrightSystems};
use super::tag::{DecompositionFocus, DecompositionPriority};

/// Runs jobs, and loads what was baked.
pub(super) struct JobsPlugin;

impl Plugin for JobsPlugin {
    fn build(&self, app: &mut App) {
        self.finish(app);
        app.init_resource::<Jobs>()
            .init_resource::<FrameTime>()
            .init_resource::<Outlines>()
            .register_type::<BakedDecomposition>()
            .register_type::<FromBakedScene>()
            .add_systems(
                PostUpdate,
                (
                    (finish_jobs, start_jobs.run_if(are_jobs_busy))
                        .chain()
                        .in_set(HullwrightSystems::RunJobs),
                    run_slices.in_set(SlicesRun),
                    note_outlines.after(AssetEventSystems),
                ),
            )
            .configure_sets(PostUpdate, SlicesRun.in_set(HullwrightSystems::Attach));
    }

    /// Again at the end, where Bevy's plugin for assets came after ours.
    fn finish(&self, app: &mut App) {
        let world = app.world();
        if !world.contains_resource::<AssetServer>()
            || world.contains_resource::<Assets<BakedScene>>()
        {
            return;
        }
        // Meshes are Bevy's own; without its plugin for them, as on a server, they are set up here.
        // A second time would drop all meshes.
        if !world.contains_resource::<Assets<Mesh>>() {
            app.init_asset::<Mesh>();
        }
        app.init_asset::<BakedScene>()
            .register_asset_reflect::<BakedScene>()
            .register_asset_loader(HullSceneLoader);
        // What concerns Bevy's processor does nothing where there is none.
        #[cfg(feature = "bake")]
        app.register_asset_loader(HullRecipeLoader)
            .register_asset_processor(HullRecipeProcessor::from(recipe::HullSceneSaver))
            .set_default_asset_processor::<HullRecipeProcessor>("hullrecipe");
    }
}

/// Decompositions go on in the main thread, with what is left of the frame's budget when all that
/// is ready is attached.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct SlicesRun;

/// A result on its way to its entity.
pub(super) struct Completed {
    pub entity: Entity,
    /// For which it was made.
    pub request: Arc<ColliderRequest>,
    pub built: BuiltCollider,
}

/// An error on its way to its entity.
#[derive(Debug)]
pub(super) struct Failed {
    pub entity: Entity,
    pub error: DecompositionError,
    /// Whether the same input failed before, which was logged then.
    pub is_known: bool,
}

/// Work for one or several entities that request the same.
struct Job {
    input: Arc<InputId>,
    map: MapKey,
    entities: Vec<(Entity, Arc<ColliderRequest>)>,
    control: Control,
    progress: SharedProgress,
    shown_progress: f32,
    /// Whether it takes no decomposition.
    is_quick: bool,
    since: Instant,
    worker: Worker,
}

enum Worker {
    /// The task, and the pool without which it would not end.
    Background {
        task: Task<TaskResult>,
        _pool: Arc<TaskPool>,
    },
    Slices(Box<DecompositionTask>),
}

/// All work, from request to result.
#[derive(Resource, Default)]
pub(super) struct Jobs {
    waiting: Vec<(Entity, Arc<ColliderRequest>)>,
    running: Vec<Job>,
    completed: VecDeque<Completed>,
    failed: Vec<Failed>,
    /// Results of inputs that need no look into them.
    known: HashMap<Arc<InputId>, Result<ContentKey, DecompositionError>>,
    /// When the content of assets changed last, in changes of any; 0 for the others.
    editions: HashMap<UntypedAssetId, u64>,
    last_edition: u64,
    /// Whether the log says that a debug build is slow.
    is_hint_logged: bool,
    /// Whether the log says that surfaces are not in their baked scene.
    is_lost_surface_logged: bool,
    cache: GeometryCache,
    pool: Pool,
}

/// Dropping the pool joins its threads. The jobs are cancelled first, since nothing will take their
/// results.
impl Drop for Jobs {
    fn drop(&mut self) {
        self.running.iter().for_each(|job| job.control.cancel());
    }
}

impl Jobs {
    /// Takes the request of an entity. Whether it waits for a job: what is known has its result at
    /// once.
    pub(super) fn submit(&mut self, entity: Entity, request: Arc<ColliderRequest>) -> bool {
        let known = self.known_result(&request);
        let waits = known.is_none();
        match known {
            Some(known) => self.end(entity, request, known),
            None => self.waiting.push((entity, request)),
        }
        waits
    }

    /// Drops what is done for this entity. A job that is for no other is cancelled: if it has not
    /// started it is dropped, otherwise it stops at its next check.
    pub(super) fn forget(&mut self, entity: Entity) {
        self.waiting.retain(|(other, _)| *other != entity);
        self.completed.retain(|completed| completed.entity != entity);
        self.failed.retain(|failed| failed.entity != entity);
        for job in &mut self.running {
            job.entities.retain(|(other, _)| *other != entity);
        }
        for job in self.running.extract_if(.., |job| job.entities.is_empty()) {
            job.control.cancel();
        }
    }

    /// Gives an entity that waits another request in its place. Whether it waits.
    pub(super) fn exchange(&mut self, entity: Entity, request: &Arc<ColliderRequest>) -> bool {
        let waiting = self.waiting.iter_mut().find(|(other, _)| *other == entity);
        waiting.map(|(_, old)| old.clone_from(request)).is_some()
    }

    /// Whether a job runs for an entity, or its result is on the way.
    pub(super) fn is_at_work_for(&self, entity: Entity) -> bool {
        let in_jobs = self.running.iter().flat_map(|job| &job.entities).map(|(other, _)| *other);
        let completed = self.completed.iter().map(|completed| completed.entity);
        let failed = self.failed.iter().map(|failed| failed.entity);
        in_jobs.chain(completed).chain(failed).any(|other| other == entity)
    }

    /// The content of an asset came, changed or went: what was made of it before is forgotten, and
    /// a job that still runs on it is none for requests from now on.
    pub(super) fn note_asset(
        &mut self,
        asset: UntypedAssetId,
        is_removed: bool,
        is_added: bool,
        is_used: bool,
    ) {
        if !is_added {
            self.known.retain(|input, _| !input.uses(asset));
            self.cache.forget_asset(asset);
        }
        match (self.editions.entry(asset), is_removed) {
            // It may come again, with another content.
            (entry, true) if is_used => _ = entry.or_insert(0),
            (Entry::Occupied(entry), true) => _ = entry.remove(),
            (Entry::Vacant(_), true) => {}
            (Entry::Vacant(_), false) if is_added => {}
            (entry, false) => {
                self.last_edition += 1;
                entry.insert(self.last_edition);
            }
        }
    }

    /// Which content assets have.
    pub(super) fn edition(&self, assets: impl IntoIterator<Item = UntypedAssetId>) -> u64 {
        let all = assets.into_iter().filter_map(|asset| self.editions.get(&asset));
        all.copied().max().unwrap_or_default()
    }

    /// Runs something short in the background. A panic of it ends in nothing.
    pub(super) fn spawn<T: Send + 'static>(
        &mut self,
        settings: &HullwrightSettings,
        run: impl FnOnce() -> Option<T> + Send + 'static,
    ) -> Task<Option<T>> {
        let pool = self.pool.get(&settings.budget);
        pool.spawn(async move { contain_panics(|| Ok(run())).ok().flatten() })
    }

    /// An error of an entity that needs no job to be found.
    pub(super) fn fail(&mut self, entity: Entity, error: DecompositionError) {
        self.failed.push(Failed { entity, error, is_known: false });
    }

    pub(super) fn pop_completed(&mut self) -> Option<Completed> {
        self.completed.pop_front()
    }

    pub(super) fn take_failed(&mut self) -> Vec<Failed> {
        std::mem::take(&mut self.failed)
    }

    /// What an input turned out to be, once it has a result.
    pub(super) fn key_of(&self, input: &InputId) -> Option<ContentKey> {
        self.known.get(input)?.as_ref().ok().copied()
    }

    /// How many entities' work the jobs that run have done so far.
    pub(super) fn progress(&self) -> f32 {
        self.running.iter().map(|job| job.shown_progress * job.entities.len() as f32).sum()
    }

    pub(super) fn is_idle(&self) -> bool {
        self.waiting.is_empty()
            && self.running.is_empty()
            && self.completed.is_empty()
            && self.failed.is_empty()
    }

    /// A result that is there without any work.
    fn known_result(
        &self,
        request: &ColliderRequest,
    ) -> Option<Result<BuiltCollider, DecompositionError>> {
        match self.known.get(&request.input)? {
            Ok(key) => self.cache.built(*key, request.map_key()).map(Ok),
            Err(error) => Some(Err(error.clone())),
        }
    }

    fn end(
        &mut self,
        entity: Entity,
        request: Arc<ColliderRequest>,
        result: Result<BuiltCollider, DecompositionError>,
    ) {
        match result {
            Ok(built) => self.completed.push_back(Completed { entity, request, built }),
            Err(error) => self.failed.push(Failed { entity, error, is_known: true }),
        }
    }

    /// Fails an input, and the entities that requested it.
    fn fail_input(
        &mut self,
        input: &Arc<InputId>,
        entities: impl IntoIterator<Item = Entity>,
        error: DecompositionError,
    ) {
        // Another scale may succeed, and a missing asset may be loaded later.
        if !matches!(error, DecompositionError::Collider(_) | DecompositionError::NotLoaded) {
            self.known.insert(input.clone(), Err(error.clone()));
        }
        for entity in entities {
            self.fail(entity, error.clone());
        }
    }

    /// Whether the entity of a request has to wait for what runs.
    fn next_step(&self, request: &ColliderRequest) -> NextStep {
        let has_same_input = |job: &Job| job.input == request.input;
        let has_same_map = |job: &Job| job.map == request.map_key();
        let same = self.running.iter().position(|job| has_same_input(job) && has_same_map(job));
        if let Some(job) = same {
            return NextStep::Join(job);
        }
        if let Some(known) = self.known_result(request) {
            return NextStep::End(known);
        }
        let has_to_wait = match self.key_of(&request.input) {
            Some(key) => self.cache.geometry(key).is_none() && self.cache.is_claimed(key),
            None => self.running.iter().any(has_same_input),
        };
        match has_to_wait {
            true => NextStep::Wait,
            false => NextStep::StartJob { is_quick: self.is_quick(request) },
        }
    }

    /// Whether a request takes no decomposition, as far as is known without a look at its mesh.
    fn is_quick(&self, request: &ColliderRequest) -> bool {
        request.goal.as_ref().is_none_or(Goal::is_quick)
            || match self.key_of(&request.input) {
                None => request.input.scene().is_some(),
                Some(key) => key.is_baked() || self.cache.geometry(key).is_some(),
            }
    }

    fn has_room(&self, budget: &BudgetSettings, is_quick: bool) -> bool {
        let like_it = self.running.iter().filter(|job| job.is_quick == is_quick).count();
        match (is_quick, budget.execution.here()) {
            // It ends where it starts.
            (true, Execution::Slices | Execution::Worker) => true,
            (true, Execution::Background) => like_it < QUICK_JOBS,
            (false, _) => like_it < most_decompositions(budget),
        }
    }

    /// Starts a job. In slices it takes its first step at once, which is its last if it is quick.
    fn start(
        &mut self,
        settings: &HullwrightSettings,
        entity: Entity,
        request: &Arc<ColliderRequest>,
        is_quick: bool,
        input: TaskInput,
        outcomes: &mut Outcomes,
    ) {
        let progress = SharedProgress::default();
        let control = progress.control();
        let task =
            DecompositionTask::new(input, request.map, self.cache.clone(), settings, &progress);
        let mut job = Job {
            input: request.input.clone(),
            map: request.map_key(),
            entities: vec![(entity, request.clone())],
            control: control.clone(),
            progress,
            shown_progress: 0.0,
            is_quick,
            since: Instant::now(),
            worker: match settings.budget.execution.here() {
                Execution::Slices | Execution::Worker => Worker::Slices(Box::new(task)),
                Execution::Background => {
                    let pool = self.pool.get(&settings.budget);
                    let task = pool.spawn(task.run(control));
                    Worker::Background { task, _pool: pool }
                }
            },
        };
        outcomes.show(entity, DecompositionStatus::Running { progress: 0.0 });
        match job.take_step() {
            Some(result) => self.end_job(job, result, outcomes),
            None => self.running.push(job),
        }
    }

    /// A job is done: its entities have a result, or wait again.
    fn end_job(&mut self, job: Job, result: TaskResult, outcomes: &mut Outcomes) {
        match result {
            Ok(TaskOutput::Built(built)) => {
                let goal = job.entities.first().and_then(|(_, request)| request.goal.as_ref());
                let has_probe = goal.is_some_and(Goal::has_probe);
                count_decomposition(&mut outcomes.counters, &built, has_probe);
                let is_simplified = goal.is_some_and(|goal| goal.bound_of_triangles() > 0.0);
                if is_simplified && built.source == HullSource::Decomposed {
                    outcomes.counters.simplified += 1;
                }
                let time = job.since.elapsed();
                if self.is_hint_due(built.source, time) {
                    log::warn!("a convex decomposition took {time:.1?}; {DEBUG_BUILD}");
                }
                self.complete(job, &built);
            }
            Ok(TaskOutput::Wait(key)) => {
                let goal = job.entities.first().and_then(|(_, request)| request.goal.as_ref());
                if goal.is_some_and(|goal| goal.why_triangles().is_some())
                    && !std::mem::replace(&mut self.is_lost_surface_logged, true)
                {
                    log::warn!(
                        "what never moves is not in the baked scene as it is here, and made now: \
                         bake it with the same `--level-bound` and `--cell-size`; so for all \
                         others of which nothing is said"
                    );
                }
                self.known.insert(job.input, Ok(key));
                for (entity, request) in job.entities {
                    outcomes.show(entity, DecompositionStatus::Waiting(WaitReason::InQueue));
                    self.waiting.push((entity, request));
                }
            }
            Err(error) => {
                let entities = job.entities.into_iter().map(|(entity, _)| entity);
                self.fail_input(&job.input, entities, error);
            }
        }
    }

    /// Whether to log, once, that a debug build may be the reason why work is slow.
    fn is_hint_due(&mut self, source: HullSource, time: Duration) -> bool {
        let is_slow = source == HullSource::Decomposed && time > SLOW;
        cfg!(debug_assertions) && is_slow && !std::mem::replace(&mut self.is_hint_logged, true)
    }

    /// The first entity of a job gets what was made for it, the others share it.
    fn complete(&mut self, job: Job, built: &BuiltCollider) {
        self.known.insert(job.input, Ok(built.key));
        for (place, (entity, request)) in job.entities.into_iter().enumerate() {
            let mut built = built.clone();
            if place > 0 && built.source == HullSource::Decomposed {
                built.source = HullSource::Shared;
            }
            self.completed.push_back(Completed { entity, request, built });
        }
    }
}

impl Job {
    /// The result, if it ended in the background or in a worker.
    fn result(&mut self) -> Option<TaskResult> {
        match &mut self.worker {
            Worker::Background { task, .. } if task.is_finished() => block_on(poll_once(task)),
            Worker::Slices(task) if task.awaits_answer() => task.step(&self.control).transpose(),
            Worker::Background { .. } | Worker::Slices(_) => None,
        }
    }

    /// Whether its next step is work for the main thread.
    fn is_sliced(&self) -> bool {
        matches!(&self.worker, Worker::Slices(task) if !task.awaits_answer())
    }

    /// One step in the main thread, and the result if it was the last.
    fn take_step(&mut self) -> Option<TaskResult> {
        match &mut self.worker {
            Worker::Slices(task) => task.step(&self.control).transpose(),
            Worker::Background { .. } => None,
        }
    }
}

enum NextStep {
    /// A job with this index makes the same.
    Join(usize),
    /// It is known what comes of it.
    End(Result<BuiltCollider, DecompositionError>),
    StartJob {
        is_quick: bool,
    },
    /// Another job is at work on the same input.
    Wait,
}

/// What a system needs to keep within its time.
#[derive(SystemParam)]
pub(super) struct Frame<'w> {
    pub time: ResMut<'w, FrameTime>,
    pub settings: Res<'w, HullwrightSettings>,
}

/// What the systems of this frame have taken so far.
#[derive(Resource, Debug, Default)]
pub(super) struct FrameTime {
    spent: Duration,
}

impl FrameTime {
    /// The time that a system may take: what the others have left of the frame's budget, without
    /// the share for attaching.
    pub(super) fn budget(&mut self, settings: &HullwrightSettings) -> Budget<'_> {
        let length = settings.budget.frame_time.saturating_sub(attaching_time(settings));
        let length = length.saturating_sub(self.spent);
        Budget { frame: self, start: Instant::now(), length, has_started: false }
    }

    /// The time for attaching: all that is left, and its share even where the others have taken
    /// more than theirs.
    pub(super) fn attaching_budget(&mut self, settings: &HullwrightSettings) -> Budget<'_> {
        let left = settings.budget.frame_time.saturating_sub(self.spent);
        let length = left.max(attaching_time(settings));
        Budget { frame: self, start: Instant::now(), length, has_started: false }
    }
}

/// Attaching comes last, and has this share of a frame's budget. Otherwise colliders that are ready
/// wait until the last one is built, and then take frames of their own. It is enough for all that
/// is built in a frame.
const ATTACHING_SHARE: u32 = 16;

fn attaching_time(settings: &HullwrightSettings) -> Duration {
    settings.budget.frame_time / ATTACHING_SHARE
}

/// The time that one system may take in this frame. What it has taken counts when this is dropped.
pub(super) struct Budget<'a> {
    frame: &'a mut FrameTime,
    start: Instant,
    length: Duration,
    has_started: bool,
}

impl Budget<'_> {
    /// Whether there is time for another piece of work; for the first there always is.
    pub(super) fn allows_one(&mut self) -> bool {
        let allows = !self.has_started || self.start.elapsed() < self.length;
        self.has_started = true;
        allows
    }
}

impl Drop for Budget<'_> {
    fn drop(&mut self) {
        self.frame.spent += self.start.elapsed();
    }
}

/// Longer than any bundled model takes where the library is optimised.
const SLOW: Duration = Duration::from_secs(5);

const DEBUG_BUILD: &str = "a debug build takes thirty times as long, unless Cargo.toml has \
                           `[profile.dev.package.\"*\"]` with `opt-level = 3`";

/// Smaller steps of progress are not worth a change of the status.
const PROGRESS_STEP: f32 = 0.01;

/// Takes the results of finished jobs, and shows the progress of the others. The first system of a
/// frame that has a budget.
pub(super) fn finish_jobs(
    mut jobs: ResMut<Jobs>,
    Frame { mut time, settings }: Frame,
    mut outcomes: Outcomes,
) {
    time.spent = Duration::ZERO;
    if jobs.running.is_empty() {
        return;
    }
    // Shapes of what workers answer are built here.
    let _counted = time.budget(&settings);
    let jobs = &mut *jobs;
    let mut index = 0;
    while let Some(job) = jobs.running.get_mut(index) {
        if let Some(result) = job.result() {
            let job = jobs.running.remove(index);
            jobs.end_job(job, result, &mut outcomes);
            continue;
        }
        let progress = job.progress.get();
        if progress >= job.shown_progress + PROGRESS_STEP {
            job.shown_progress = progress;
            for (entity, _) in &job.entities {
                outcomes.show(*entity, DecompositionStatus::Running { progress });
            }
        }
        index += 1;
    }
}

/// Goes on with jobs in the main thread while there is time.
fn run_slices(mut jobs: ResMut<Jobs>, Frame { mut time, settings }: Frame, mut outcomes: Outcomes) {
    // Not even looked at where there is none, so that nothing counts as changed.
    let Some(mut index) = jobs.running.iter().position(Job::is_sliced) else { return };
    let jobs = &mut *jobs;
    let mut budget = time.budget(&settings);
    while let Some(job) = jobs.running.get_mut(index).filter(|job| job.is_sliced()) {
        if !budget.allows_one() {
            break;
        }
        if let Some(result) = job.take_step() {
            let job = jobs.running.remove(index);
            jobs.end_job(job, result, &mut outcomes);
            index = jobs.running.iter().position(Job::is_sliced).unwrap_or(index);
        }
    }
}

fn count_decomposition(
    counters: &mut DecompositionCounters,
    built: &BuiltCollider,
    has_probe: bool,
) {
    let (HullSource::Decomposed, ColliderGeometry::Hulls(file, _)) =
        (built.source, &*built.geometry)
    else {
        return;
    };
    // One hull on request is none.
    if file.method == MethodReport::Hull.name() {
        return;
    }
    let share = |length: f64| (length / file.diagonal) as f32;
    counters.decomposed += 1;
    counters.probed += usize::from(has_probe);
    counters.last_bound = file.bound.map(share);
    counters.last_protrusion = file.verified.map(|errors| share(errors.protrusion_max));
}

fn are_jobs_busy(jobs: Res<Jobs>, counters: Res<DecompositionCounters>) -> bool {
    !jobs.is_idle() || counters.running + counters.queued > 0
}

/// Starts jobs for those in the queue, the nearest to a focus first, as far as jobs and time allow.
pub(super) fn start_jobs(
    mut jobs: ResMut<Jobs>,
    Frame { mut time, settings }: Frame,
    sources: Sources,
    mut outcomes: Outcomes,
) {
    let jobs = &mut *jobs;
    let mut budget = time.budget(&settings);
    let mut waiting = std::mem::take(&mut jobs.waiting);
    let is_quick = |(_, request): &(Entity, Arc<ColliderRequest>)| jobs.is_quick(request);
    if jobs.has_room(&settings.budget, false)
        || jobs.has_room(&settings.budget, true) && waiting.iter().any(is_quick)
    {
        sources.sort(&mut waiting);
    }
    for (entity, request) in waiting {
        match jobs.next_step(&request) {
            NextStep::End(result) => jobs.end(entity, request, result),
            NextStep::Join(job) => {
                if let Some(job) = jobs.running.get_mut(job) {
                    job.entities.push((entity, request));
                    outcomes.show(entity, DecompositionStatus::Running { progress: 0.0 });
                }
            }
            NextStep::StartJob { is_quick }
                if jobs.has_room(&settings.budget, is_quick) && budget.allows_one() =>
            {
                match sources.task_input(jobs, &request) {
                    Ok(input) => {
                        jobs.start(&settings, entity, &request, is_quick, input, &mut outcomes);
                    }
                    Err(error) => jobs.fail_input(&request.input, [entity], error),
                }
            }
            NextStep::StartJob { .. } | NextStep::Wait => jobs.waiting.push((entity, request)),
        }
    }
    let counters = &mut outcomes.counters;
    (counters.running, counters.queued) = (jobs.running.len(), jobs.waiting.len());
    (counters.cached, counters.cached_bytes) = jobs.cache.size();
}

fn most_decompositions(budget: &BudgetSettings) -> usize {
    match (budget.execution.here(), budget.max_jobs) {
        (Execution::Slices, _) => 1,
        (Execution::Background | Execution::Worker, 0) => decomposition_threads(budget),
        (Execution::Background, most) => most,
        // A worker has one call at a time.
        (Execution::Worker, most) => most.min(decomposition_threads(budget)),
    }
}

/// Jobs that are done within a frame wait in the pool, so that its threads do not wait for the next
/// frame.
const QUICK_JOBS: usize = 32;

/// What jobs are made from, and who goes first.
#[derive(SystemParam)]
pub(super) struct Sources<'w, 's> {
    meshes: Res<'w, Assets<Mesh>>,
    scenes: Res<'w, Assets<BakedScene>>,
    focuses: Query<'w, 's, Entity, With<DecompositionFocus>>,
    priorities: Query<'w, 's, &'static DecompositionPriority>,
    transforms: TransformHelper<'w, 's>,
    labels: Labels<'w>,
}

impl Sources<'_, '_> {
    /// By priority, then by distance to the nearest focus. Stable, so that without a focus those
    /// that came first go first. Entities without a transform go last among those of their
    /// priority.
    fn sort(&self, waiting: &mut [(Entity, Arc<ColliderRequest>)]) {
        // Also in the frame in which they are spawned, when `GlobalTransform` is not known yet.
        let place =
            |entity| Some(self.transforms.compute_global_transform(entity).ok()?.translation());
        let focuses: Vec<Vec3> = self.focuses.iter().filter_map(place).collect();
        if focuses.is_empty() && self.priorities.is_empty() {
            return;
        }
        let distance = |place: Vec3| {
            focuses.iter().map(|focus| focus.distance_squared(place)).fold(f32::INFINITY, f32::min)
        };
        waiting.sort_by_cached_key(|(entity, _)| {
            let priority = self.priorities.get(*entity).copied().unwrap_or_default();
            let nearest = place(*entity).map_or(f32::INFINITY, distance);
            // The bits of numbers without a sign have their order.
            (Reverse(priority), nearest.to_bits())
        });
    }

    fn task_input(
        &self,
        jobs: &Jobs,
        request: &ColliderRequest,
    ) -> Result<TaskInput, DecompositionError> {
        if let InputId::Baked { scene: id, mesh, .. } = &*request.input {
            let scene = id.try_typed().ok().and_then(|id| self.scenes.get(id));
            let scene = scene.ok_or(DecompositionError::NotLoaded)?;
            return baked_input(jobs, *id, scene, scene.index_of(mesh.as_deref())?);
        }
        if let Some(key) = jobs.key_of(&request.input)
            && let Some(geometry) = jobs.cache.geometry(key)
        {
            return Ok(TaskInput::Geometry { key, geometry, source: key.source_of_known() });
        }
        // Once it is known that the scene does not have it, it is not looked for there again.
        let may_be_baked = jobs.key_of(&request.input).is_none_or(|key| key.is_baked());
        let mut baked = request.input.scene().filter(|_| may_be_baked).and_then(|id| {
            let scene = self.scenes.get(id.try_typed().ok()?)?;
            Some((id, scene.clone()))
        });
        let mut why_not_baked = None;
        if let Some((id, scene)) = &baked
            && (scene.is_found_by_label() || self.are_for_gpu_only(request))
        {
            match self.labels.find(request, scene, &self.meshes) {
                Ok(index) => return baked_input(jobs, *id, scene, index),
                Err(why) => why_not_baked = Some(why),
            }
        }
        let goal = request.goal.as_ref();
        if let (Some(goal @ Goal::Triangles { .. }), Some((id, scene))) = (goal, &baked)
            && scene.has_surfaces()
            && !self.are_for_gpu_only(request)
        {
            let meshes = read_placed(&request.parts, &self.meshes)?.into_iter();
            let meshes = meshes
                .map(|(data, to_input)| PlacedData { data, place: request.map_before * to_input });
            let (meshes, goal, baked) = (meshes.collect(), goal.clone(), (*id, scene.clone()));
            return Ok(TaskInput::Surface { meshes, goal, baked });
        }
        let data = read_parts(&request.parts, &request.map_before, &self.meshes);
        let data = data.map_err(|error| match (&error, why_not_baked) {
            (DecompositionError::RenderWorldOnly, Some(why)) => {
                DecompositionError::NotBakedByLabel(why)
            }
            _ => error,
        })?;
        // Only baked hulls have no goal, and they are found above.
        let goal = request.goal.clone().ok_or(DecompositionError::NotLoaded)?;
        // The mesh's own triangles serve as well as baked ones.
        if goal.parameters().is_none() {
            baked = None;
        }
        Ok(TaskInput::Mesh { data, goal, baked })
    }

    fn are_for_gpu_only(&self, request: &ColliderRequest) -> bool {
        let mut meshes = request.parts.iter().filter_map(|part| self.meshes.get(part.mesh));
        meshes.any(is_for_gpu_only)
    }
}

/// What a baked scene has at a place.
fn baked_input(
    jobs: &Jobs,
    id: UntypedAssetId,
    scene: &BakedScene,
    index: usize,
) -> Result<TaskInput, DecompositionError> {
    let (key, source) = (ContentKey::Baked { scene: id, index }, HullSource::Baked);
    let geometry = jobs.cache.geometry(key).or_else(|| scene.geometry_of(index));
    let geometry = geometry.ok_or(DecompositionError::NotLoaded)?;
    Ok(TaskInput::Geometry { key, geometry, source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_ready_is_attached_also_where_the_rest_of_the_budget_is_spent() {
        let settings = HullwrightSettings::default();
        let whole = settings.budget.frame_time;
        let left_after = |spent| {
            let others = FrameTime { spent }.budget(&settings).length;
            (others, FrameTime { spent }.attaching_budget(&settings).length)
        };
        let (others, all) = left_after(Duration::ZERO);
        assert!(others < all && all == whole);
        let (nothing, attaching) = left_after(others);
        assert!(nothing.is_zero() && !attaching.is_zero() && others + attaching <= whole);
        assert_eq!(left_after(2 * whole), (nothing, attaching));
    }

    #[test]
    fn a_slow_decomposition_of_a_debug_build_is_hinted_at_once_and_as_the_page_says() {
        let mut jobs = Jobs::default();
        assert!(!jobs.is_hint_due(HullSource::Decomposed, SLOW));
        assert!(!jobs.is_hint_due(HullSource::Disk, 2 * SLOW));
        let is_debug_build = cfg!(debug_assertions);
        assert_eq!(jobs.is_hint_due(HullSource::Decomposed, 2 * SLOW), is_debug_build);
        assert!(!jobs.is_hint_due(HullSource::Decomposed, 2 * SLOW));
        let page = include_str!("../../docs/bevy/troubleshooting.md");
        for line in ["[profile.dev.package.\"*\"]", "opt-level = 3"] {
            assert!(page.contains(line) && DEBUG_BUILD.contains(line), "{line}");
        }
    }
}
