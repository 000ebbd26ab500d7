//! The pool that jobs run on.

use bevy::tasks::{AsyncComputeTaskPool, TaskPool};

/// Bevy's task pool plugin makes it; without that plugin it is made here.
pub(crate) fn pool() -> &'static AsyncComputeTaskPool {
    AsyncComputeTaskPool::get_or_init(TaskPool::default)
}
