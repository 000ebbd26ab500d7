//! Jobs start, go on and finish here. Nothing waits for them.

mod finish;
mod priority;
mod start;

pub(super) use finish::finish_jobs;
pub(super) use start::start_jobs;
