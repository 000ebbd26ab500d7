//! Whole scenes, tagged at once.

pub(crate) mod artists;
pub(crate) mod hierarchy;
pub(crate) mod hierarchy_progress;
pub(crate) mod hierarchy_status;
pub(crate) mod nodes;
pub(crate) mod progress;
