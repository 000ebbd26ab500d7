//! The same function over all items of a list, on rayon's current pool if there is one to be used.
//! Results come in the order of the items, so they do not depend on threads.

/// Applies `function` to every item.
pub(super) fn map<T: Sync, R: Send>(
    items: &[T],
    function: impl Fn(&T) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    if items.len() > 1 && rayon::current_num_threads() > 1 && IS_PARALLEL.get() {
        use rayon::prelude::*;
        return items.par_iter().map(function).collect();
    }
    items.iter().map(function).collect()
}

/// Runs two functions, at the same time if there are threads for it.
pub(super) fn join<A: Send, B: Send>(
    first: impl FnOnce() -> A + Send,
    second: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "parallel")]
    if rayon::current_num_threads() > 1 && IS_PARALLEL.get() {
        return rayon::join(first, second);
    }
    (first(), second())
}

#[cfg(feature = "parallel")]
thread_local! {
    static IS_PARALLEL: std::cell::Cell<bool> = const { std::cell::Cell::new(true) };
}

/// Runs `work` with or without other threads.
pub(super) fn with<R>(parallel: bool, work: impl FnOnce() -> R) -> R {
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
