//! The same function over all items of a list, on rayon's current pool if there is one to be used.
//! Results come in the order of the items, so they do not depend on threads.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use crate::control::Control;
use crate::error::Error;

/// Applies `function` to every item.
pub(crate) fn map<T: Sync, R: Send>(
    items: &[T],
    function: impl Fn(&T) -> R + Sync + Send,
) -> Vec<R> {
    map_indices(items.len(), |index| function(&items[index]))
}

/// Tasks that many items are divided into, at least: by itself rayon leaves a few items together,
/// and the thread with the larger ones ends last.
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

/// Applies `function` to every item, those of the greatest `size` first: of few and unequal items a
/// large one that came last would leave all other threads idle.
pub(crate) fn map_largest_first<T: Sync, R: Send>(
    items: &[T],
    size: impl Fn(&T) -> usize,
    function: impl Fn(&T) -> R + Sync + Send,
) -> Vec<R> {
    let mut order: Vec<usize> = (0..items.len()).collect();
    if threads() > 1 {
        order.sort_by_key(|&index| std::cmp::Reverse(size(&items[index])));
    }
    let results = map_until(&order, |&index| (index, function(&items[index])), |_| false);
    in_order(items.len(), results)
}

/// Applies `function` to items in order, one after the other on each thread, up to the first result
/// that `ends` it. As many items as there are other threads may be computed in vain.
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
    let mut results = in_order(items.len(), on_each_thread.into_iter().flatten());
    results.truncate(last.into_inner() + 1);
    results
}

/// Results by their indices, which are all different.
fn in_order<R>(count: usize, results: impl IntoIterator<Item = (usize, R)>) -> Vec<R> {
    let mut places: Vec<Option<R>> = (0..count).map(|_| None).collect();
    for (index, result) in results {
        places[index] = Some(result);
    }
    places.into_iter().flatten().collect()
}

/// A fold over items in order: `function` is applied to those for which `needs` holds in the state
/// so far, and `add` adds its result to the state. What is not needed must not become so. Other
/// threads run ahead, and may do so in vain.
///
/// # Errors
/// The first error of `function`.
pub(crate) fn fold_ahead<T: Sync, S: Send, R: Send, E: Send>(
    items: &[T],
    state: S,
    needs: impl Fn(&S, &T) -> bool + Sync + Send,
    function: impl Fn(&T) -> Result<R, E> + Sync + Send,
    add: impl Fn(&mut S, R) + Sync + Send,
) -> Result<S, E> {
    let next = AtomicUsize::new(0);
    let fold = Mutex::new(Fold { state: Ok(state), done: 0, ahead: BTreeMap::new() });
    map_indices(threads().min(items.len()), |_| {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(index) else { break };
            let is_needed = match &lock(&fold).state {
                Ok(state) => needs(state, item),
                Err(_) => break,
            };
            let result = is_needed.then(|| function(item));
            let mut fold = lock(&fold);
            fold.ahead.insert(index, result);
            fold.add_ready(items, &needs, &add);
        }
    });
    fold.into_inner().unwrap_or_else(PoisonError::into_inner).state
}

/// The state of [`fold_ahead`] after the first `done` items, and results of later ones.
struct Fold<S, R, E> {
    state: Result<S, E>,
    done: usize,
    ahead: BTreeMap<usize, Option<Result<R, E>>>,
}

impl<S, R, E> Fold<S, R, E> {
    /// Adds the results of items whose predecessors are all done.
    fn add_ready<T>(
        &mut self,
        items: &[T],
        needs: impl Fn(&S, &T) -> bool,
        add: impl Fn(&mut S, R),
    ) {
        while let Some(result) = self.ahead.remove(&self.done) {
            if let (Ok(state), Some(result)) = (&mut self.state, result)
                && needs(state, &items[self.done])
            {
                match result {
                    Ok(result) => add(state, result),
                    Err(error) => self.state = Err(error),
                }
            }
            self.done += 1;
        }
    }
}

/// Locks a mutex, also after a panic: the results that these guard are valid whichever thread found
/// them.
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

/// Time between two checks for a stop while work runs that can't be stopped.
const CHECK_EVERY: Duration = Duration::from_millis(1);

/// Runs work that can't be stopped on a thread of its own, which is left to itself once `control`
/// stops. In a browser, which has no such threads, it is done whole.
///
/// # Errors
/// [`Error::Cancelled`] and [`Error::DeadlineExceeded`]; `None` where the work panics.
pub(crate) fn leave_if_stopped<R: Send + 'static>(
    work: impl Fn() -> R + Send + Sync + 'static,
    control: &Control,
) -> Result<Option<R>, Error> {
    let work = Arc::new(work);
    let (sender, receiver) = channel();
    let of_thread = Arc::clone(&work);
    let spawned = thread::Builder::new().spawn(move || {
        // Nobody receives it if the work was left.
        let _ = sender.send(of_thread());
    });
    if spawned.is_err() {
        return Ok(Some(work()));
    }
    loop {
        match receiver.recv_timeout(CHECK_EVERY) {
            Ok(result) => return Ok(Some(result)),
            Err(RecvTimeoutError::Timeout) => control.check()?,
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
        }
    }
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::{fold_ahead, leave_if_stopped};
    use crate::control::Control;
    use crate::error::Error;

    /// Numbers of which no smaller one is a factor, up to the first that means an error.
    fn primes(numbers: std::ops::Range<u64>, errors: &[u64]) -> Result<Vec<u64>, u64> {
        let numbers: Vec<u64> = numbers.collect();
        fold_ahead(
            &numbers,
            Vec::new(),
            |found: &Vec<u64>, &number| found.iter().all(|&factor| number % factor != 0),
            |&number| if errors.contains(&number) { Err(number) } else { Ok(number) },
            |found, number| found.push(number),
        )
    }

    #[test]
    fn what_is_done_ahead_in_vain_is_left_out() {
        for _ in 0..1_000 {
            assert_eq!(primes(2..24, &[4, 15]), Ok(vec![2, 3, 5, 7, 11, 13, 17, 19, 23]));
        }
        assert_eq!(primes(2..2, &[]), Ok(Vec::new()));
    }

    #[test]
    fn the_first_error_that_counts_is_returned() {
        for _ in 0..1_000 {
            assert_eq!(primes(2..24, &[4, 11, 13, 17]), Err(11));
        }
    }

    #[test]
    fn work_that_can_not_be_stopped_is_left() {
        let (sender, receiver) = std::sync::mpsc::channel::<()>();
        let control = Control::new();
        control.cancel();
        // Ends only after it was left.
        let receiver = std::sync::Mutex::new(receiver);
        let endless = move || super::lock(&receiver).recv_timeout(Duration::from_secs(60)).is_ok();
        assert_eq!(leave_if_stopped(endless, &control), Err(Error::Cancelled));
        drop(sender);
        assert_eq!(leave_if_stopped(|| 3, &Control::new()), Ok(Some(3)));
    }

    #[test]
    fn work_that_panics_has_no_result() {
        let broken = || -> u32 { std::panic::resume_unwind(Box::new(())) };
        assert_eq!(leave_if_stopped(broken, &Control::new()), Ok(None));
    }
}
