//! The plugin's own threads: Bevy compiles render pipelines on its pool for background work, and
//! that has a single thread on most machines.

use std::sync::{Arc, OnceLock};

use bevy::tasks::{TaskPool, TaskPoolBuilder};

use crate::tag::settings::BudgetSettings;

/// More would take memory bandwidth from the game rather than end sooner.
const MOST_THREADS: usize = 4;

/// Threads, or workers, for decompositions.
pub(super) fn decomposition_threads(budget: &BudgetSettings) -> usize {
    // Looking it up reads files.
    static DEFAULT: OnceLock<usize> = OnceLock::new();
    match budget.threads {
        0 => *DEFAULT.get_or_init(|| (processors() / 2).clamp(1, MOST_THREADS)),
        threads => threads,
    }
}

#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
fn processors() -> usize {
    bevy::tasks::available_parallelism()
}

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
use super::worker::processors;

/// The pool, made at its first use, and anew when the number of threads in the settings changes.
/// Work that began on the old one ends there.
#[derive(Default)]
pub(super) struct Pool(Option<(usize, Arc<TaskPool>)>);

impl Pool {
    pub(super) fn get(&mut self, budget: &BudgetSettings) -> Arc<TaskPool> {
        let threads = decomposition_threads(budget);
        match &self.0 {
            Some((made_with, pool)) if *made_with == threads => pool.clone(),
            _ => self.0.insert((threads, Arc::new(new_pool(threads)))).1.clone(),
        }
    }
}

fn new_pool(threads: usize) -> TaskPool {
    // One more than decompositions ever take, so that what is quick does not wait for them.
    let pool = TaskPoolBuilder::new().num_threads(threads + 1).thread_name("Hullwright".into());
    #[cfg(not(target_family = "wasm"))]
    let pool = pool.on_thread_spawn(lower_priority);
    pool.build()
}

/// Below normal on Windows, a niceness of about 10 on Linux: less than the game's own threads, but
/// not only what they leave.
#[cfg(not(target_family = "wasm"))]
const PRIORITY: u8 = 25;

#[cfg(not(target_family = "wasm"))]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pool_has_the_threads_of_the_settings_and_one_for_what_is_quick() {
        let budget = |threads| BudgetSettings { threads, ..BudgetSettings::default() };
        let mut pool = Pool::default();
        let first = pool.get(&budget(2));
        assert_eq!(first.thread_num(), 3);
        assert!(Arc::ptr_eq(&first, &pool.get(&budget(2))));
        assert_eq!(pool.get(&budget(1)).thread_num(), 2);
        assert!((1..=MOST_THREADS).contains(&decomposition_threads(&budget(0))));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn its_threads_are_nicer_than_this_one() {
        let niceness = || {
            let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
            // The nineteenth field; the second may contain spaces, and ends with a parenthesis.
            let after_name = stat.rsplit_once(')').unwrap().1;
            after_name.split_whitespace().nth(16).unwrap().parse::<i32>().unwrap()
        };
        let own = niceness();
        let pool = Pool::default().get(&BudgetSettings::default());
        let of_pool = bevy::tasks::block_on(pool.spawn(async move { niceness() }));
        assert!(of_pool > own || own >= 10, "{of_pool} and {own}");
    }
}
