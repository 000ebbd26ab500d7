//! Progress: a component per entity, and counters for all.

use bevy::prelude::*;

use crate::bevy::tag::error::DecompositionError;

/// How far an entity's collider has come.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub enum DecompositionStatus {
    /// Not started.
    Waiting(WaitReason),
    /// Being made.
    Running {
        /// Share of the work that is done, from 0 to 1; it never falls.
        progress: f32,
    },
    /// The collider is there.
    Ready(HullSource),
    /// No decomposition was made, and why.
    Skipped(SkipReason),
    /// There is no collider, and why. It was logged once.
    Failed(DecompositionError),
    /// The tag was removed before the collider was ready.
    Cancelled,
}

impl Default for DecompositionStatus {
    fn default() -> Self {
        Self::Waiting(WaitReason::ForMesh)
    }
}

impl DecompositionStatus {
    /// Whether nothing more will come, unless the entity or its mesh changes.
    pub fn is_finished(&self) -> bool {
        !matches!(self, Self::Waiting(_) | Self::Running { .. })
    }
}

/// What an entity waits for.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[type_path = "hullwright"]
pub enum WaitReason {
    /// There is no `Mesh3d` on it or below it, and no baked hulls, or they are not loaded.
    ForMesh,
    /// Others go first.
    InQueue,
}

/// Where hulls came from.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[type_path = "hullwright"]
pub enum HullSource {
    /// They were made for this entity.
    Decomposed,
    /// They were made for another entity with the same mesh and parameters.
    Shared,
    /// They were read from the cache on disk.
    Disk,
    /// They were baked.
    Baked,
}

/// Why no decomposition was made.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[type_path = "hullwright"]
pub enum SkipReason {
    /// The entity had a `Collider` already, which stays.
    HasCollider,
    /// The body is fixed, so it got the triangle mesh itself.
    FixedBody,
    /// There is no body, so nothing moves it, and it got the triangle mesh itself.
    NoBody,
    /// The tag asked for the triangle mesh.
    TrianglesRequested,
    /// It is hidden, and [`skip_hidden`](crate::bevy::HullwrightSettings::skip_hidden) is set. It starts
    /// when it is shown.
    Hidden,
    /// It is smaller than [`min_size`](crate::bevy::HullwrightSettings::min_size).
    TooSmall,
    /// Every [`DecompositionFocus`](crate::bevy::DecompositionFocus) is farther away than
    /// [`focus_radius`](crate::bevy::HullwrightSettings::focus_radius). It starts when one is near.
    TooFar,
}

/// What the plugin has done and is doing.
#[derive(Resource, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Resource, Default, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionCounters {
    /// Entities that wait for their meshes.
    pub waiting_for_mesh: usize,
    /// Entities in the queue.
    pub queued: usize,
    /// Jobs at work.
    pub running: usize,
    /// Decompositions made so far.
    pub decomposed: usize,
    /// Colliders whose hulls were made for another entity.
    pub shared: usize,
    /// Colliders whose hulls came from the cache on disk.
    pub from_disk: usize,
    /// Colliders of baked hulls.
    pub baked: usize,
    /// Colliders that are a single hull, as those of convex meshes are, or a box, ball or capsule.
    pub convex: usize,
    /// Triangle meshes, of what never moves or on request.
    pub triangle_meshes: usize,
    /// Entities skipped because they had a collider.
    pub had_collider: usize,
    /// Entities skipped because they are hidden.
    pub hidden: usize,
    /// Entities skipped because they are too small.
    pub too_small: usize,
    /// Entities skipped, or whose colliders were dropped, because every focus is too far.
    pub too_far: usize,
    /// Entities that failed.
    pub failed: usize,
    /// Entities whose work was cancelled.
    pub cancelled: usize,
    /// Decompositions in the cache in memory.
    pub cached: usize,
    /// Their size in bytes, about.
    pub cached_bytes: usize,
    /// The bound of the decomposition that was made last, as a share of its mesh's diagonal.
    pub last_bound: Option<f32>,
    /// The verified protrusion of its hulls, as a share of its mesh's diagonal: no point of them
    /// is farther outside the solid.
    pub last_protrusion: Option<f32>,
}

impl DecompositionCounters {
    pub(crate) fn count_skipped(&mut self, reason: SkipReason) {
        let counter = match reason {
            SkipReason::HasCollider => &mut self.had_collider,
            SkipReason::FixedBody | SkipReason::NoBody | SkipReason::TrianglesRequested => {
                &mut self.triangle_meshes
            }
            SkipReason::Hidden => &mut self.hidden,
            SkipReason::TooSmall => &mut self.too_small,
            SkipReason::TooFar => &mut self.too_far,
        };
        *counter += 1;
    }

    /// Whether they say that nothing is to be done.
    pub(crate) fn show_idle(&self) -> bool {
        self.running + self.queued + self.waiting_for_mesh == 0
    }
}
