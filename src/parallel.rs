//! The same function over all items of a list, on rayon's current pool if there is one to be used.
//! Results come in the order of the items, so they do not depend on threads.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Applies `function` to every item.
pub(crate) fn map<T: Sync, R: Send>(
    items: &[T],
    function: impl Fn(&T) -> R + Sync + Send,
) -> Vec<R> {
    map_indices(items.len(), |index| function(&items[index]))
}

/// Tasks that many items are divided into, at least: left to itself, rayon leaves a few items together, and
/// a thread that has the larger ones keeps the others waiting.
#[cfg(feature = "parallel")]
const TASKS: usize = 64;

/// Applies `function` to the indices `0..count`.
pub(crate) fn map_indices<R: Send>(
    count: usize,
    function: impl Fn(usize) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    if count > 1 && threads() > 1 {
        use rayon::prelude::*;
        let most = (count / TASKS).max(1);
        return (0..count).into_par_iter().with_max_len(most).map(function).collect();
    }
    (0..count).map(function).collect()
}

/// Applies `function` to every item, those of the greatest `size` first: of few and unequal items one large
/// one that comes last would keep all other threads waiting.
pub(crate) fn map_largest_first<T: Sync, R: Send>(
    items: &[T],
    size: impl Fn(&T) -> usize,
    function: impl Fn(&T) -> R + Sync + Send,
) -> Vec<R> {
    let mut order: Vec<usize> = (0..items.len()).collect();
    if threads() > 1 {
        order.sort_by_key(|&index| std::cmp::Reverse(size(&items[index])));
    }
    let mut results = map_until(&order, |&index| (index, function(&items[index])), |_| false);
    results.sort_by_key(|&(index, _)| index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Applies `function` to items in order, one after the other on each thread, up to the first result that `ends`
/// it. As many items as there are other threads may be computed in vain.
pub(crate) fn map_until<T: Sync, R: Send>(
    items: &[T],
    function: impl Fn(&T) -> R + Sync + Send,
    ends: impl Fn(&R) -> bool + Sync + Send,
) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let last = AtomicUsize::new(items.len());
    let on_each_thread = map_indices(threads().min(items.len()), |_| {
        let mut results = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(index) else { break };
            if index > last.load(Ordering::Relaxed) {
                break;
            }
            let result = function(item);
            if ends(&result) {
                last.fetch_min(index, Ordering::Relaxed);
            }
            results.push((index, result));
        }
        results
    });
    let mut results: Vec<(usize, R)> = on_each_thread.into_iter().flatten().collect();
    results.sort_by_key(|&(index, _)| index);
    results.truncate(last.into_inner() + 1);
    results.into_iter().map(|(_, result)| result).collect()
}

/// What a mutex guards, also after a panic: only results are kept in these that are true whoever found them.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs two functions, at the same time if there are threads for it.
pub(crate) fn join<A: Send, B: Send>(
    first: impl FnOnce() -> A + Send,
    second: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "parallel")]
    if threads() > 1 {
        return rayon::join(first, second);
    }
    (first(), second())
}

#[cfg(feature = "parallel")]
thread_local! {
    static IS_PARALLEL: std::cell::Cell<bool> = const { std::cell::Cell::new(true) };
}

/// Threads that may work.
fn threads() -> usize {
    #[cfg(feature = "parallel")]
    if IS_PARALLEL.get() {
        return rayon::current_num_threads().max(1);
    }
    1
}

/// Runs `work` with or without other threads.
pub fn with<R>(parallel: bool, work: impl FnOnce() -> R) -> R {
    #[cfg(feature = "parallel")]
    {
        let before = IS_PARALLEL.replace(parallel);
        let result = work();
        IS_PARALLEL.set(before);
        result
    }
    #[cfg(not(feature = "parallel"))]
    {
        let _ = parallel;
        work()
    }
}
