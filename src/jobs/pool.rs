//! The plugin's own threads: Bevy compiles render pipelines on its pool for background work, and
//! that has a single thread on most machines.

use std::sync::{Arc, OnceLock};

use bevy::tasks::{TaskPool, TaskPoolBuilder};

use super::platform;
use crate::tag::settings::BudgetSettings;

/// More would take memory bandwidth from the game rather than end sooner.
const MOST_THREADS: usize = 4;

/// Threads, or workers, for decompositions.
pub(super) fn decomposition_threads(budget: &BudgetSettings) -> usize {
    // Looking it up reads files.
    static DEFAULT: OnceLock<usize> = OnceLock::new();
    match budget.threads {
        0 => *DEFAULT.get_or_init(|| (platform::processors() / 2).clamp(1, MOST_THREADS)),
        threads => threads,
    }
}

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
    platform::with_lower_priority(pool).build()
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
