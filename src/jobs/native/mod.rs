//! Where there are threads and files: decompositions run on threads of the plugin's own, and what
//! they make is kept in a folder. `browser` has the same items.

mod disk;

use bevy::tasks::TaskPoolBuilder;
pub(super) use bevy::tasks::available_parallelism as processors;
use hullwright::Method;
use hullwright::hulls_format::MeshHash;

pub(super) use self::disk::{DiskCache, DiskState};
use super::elsewhere::{Answer, Lookup};
use super::progress::SharedProgress;
use super::request::{ContentKey, MeshData};
use crate::tag::settings::BudgetSettings;

/// The hash of a mesh, which is there at once.
pub(super) struct Hashing;

impl Hashing {
    pub(super) fn new() -> Self {
        Self
    }

    pub(super) fn hash(&mut self, data: &MeshData) -> Option<MeshHash> {
        Some(MeshHash::of(data.view()))
    }

    pub(super) fn is_pending(&self) -> bool {
        false
    }
}

/// What the cache on disk has.
pub(super) fn look(cache: &DiskCache, key: ContentKey) -> Lookup<Elsewhere> {
    cache.read(key).map_or(Lookup::Missing, |file| Lookup::Found(Box::new(file)))
}

/// Nothing runs elsewhere than on the plugin's threads.
pub(super) enum Elsewhere {}

impl Elsewhere {
    pub(super) fn answer(&self) -> Answer {
        match *self {}
    }
}

/// Starts work elsewhere.
pub(super) struct Runner;

impl Runner {
    pub(super) fn new(_: &BudgetSettings, _: &SharedProgress) -> Self {
        Self
    }

    pub(super) fn decompose(&self, _: &MeshData, _: &Method) -> Option<Elsewhere> {
        None
    }

    pub(super) fn simplify(&self, _: &MeshData, _: f32) -> Option<Elsewhere> {
        None
    }
}

/// Threads that yield to the game's.
pub(super) fn with_lower_priority(pool: TaskPoolBuilder) -> TaskPoolBuilder {
    pool.on_thread_spawn(lower_priority)
}

/// Below normal on Windows, a niceness of about 10 on Linux: less than the game's own threads, but
/// not only what they leave.
const PRIORITY: u8 = 25;

fn lower_priority() {
    let priority = thread_priority::ThreadPriorityValue::try_from(PRIORITY);
    let lowered = priority.is_ok_and(|priority| {
        let priority = thread_priority::ThreadPriority::Crossplatform(priority);
        // A game's thread may be a real-time one, among which this priority could be the higher
        // one.
        #[cfg(unix)]
        return thread_priority::set_thread_priority_and_policy(
            thread_priority::thread_native_id(),
            priority,
            thread_priority::ThreadSchedulePolicy::Normal(
                thread_priority::NormalThreadSchedulePolicy::Other,
            ),
        )
        .is_ok();
        #[cfg(not(unix))]
        return thread_priority::set_current_thread_priority(priority).is_ok();
    });
    if !lowered {
        log::debug!("the threads for convex decompositions run with the priority of the game");
    }
}
