//! A function of an index, over all indices, on one thread or many, with the same result.

/// The function's values in order.
#[cfg(feature = "parallel")]
pub(super) fn map<T: Send>(
    count: usize,
    parallel: bool,
    function: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    use rayon::iter::{IntoParallelIterator, ParallelIterator};

    if parallel {
        (0..count).into_par_iter().map(&function).collect()
    } else {
        (0..count).map(function).collect()
    }
}

/// The function's values in order.
#[cfg(not(feature = "parallel"))]
pub(super) fn map<T>(count: usize, _parallel: bool, function: impl Fn(usize) -> T) -> Vec<T> {
    (0..count).map(function).collect()
}
