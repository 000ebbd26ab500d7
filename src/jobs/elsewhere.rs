//! What a platform says of work that goes on elsewhere than in the plugin's own code.

use hullwright::hulls_format::HullsFile;

use super::level::FewTriangles;

/// What a cache outside of memory has.
#[allow(dead_code, reason = "a platform's cache answers at once, or later")]
pub(super) enum Lookup<E> {
    Found(Box<HullsFile>),
    /// The answer comes later.
    Pending(E),
    Missing,
}

/// What has become of work elsewhere.
#[allow(dead_code, reason = "on native platforms there is no such work")]
pub(super) enum Answer {
    Pending,
    /// The hulls were in the cache.
    Found(Box<HullsFile>),
    /// They were not.
    Missing,
    /// They were made.
    Made(Box<HullsFile>),
    /// A surface was.
    Simplified(FewTriangles),
    /// It could not be made there. An error comes again here, with its type.
    Refused,
    /// What made them is gone.
    Trapped,
}
