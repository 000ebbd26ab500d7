//! From tags to requests, and from results to colliders.

pub(crate) mod attach;
pub(crate) mod changes;
pub(crate) mod contacts;
pub(crate) mod failures;
pub(crate) mod fallback_collider;
pub(crate) mod freeze;
pub(crate) mod placement;
pub(crate) mod resolve;
pub(crate) mod skip;
pub(crate) mod static_geometry;
