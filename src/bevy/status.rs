//! How it goes: a component per entity, events for observers, counters for all.

use bevy::prelude::*;

use crate::{ColliderError, Error};

/// How far an entity's collider has come.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
pub enum DecompositionStatus {
    /// Not begun.
    Waiting(Wait),
    /// Being made.
    Running {
        /// Share of the work that is done, from 0 to 1; it never falls.
        progress: f32,
    },
    /// The collider is there.
    Ready(Origin),
    /// No decomposition was made, and why.
    Skipped(Skip),
    /// There will be no collider, and why. It was logged once.
    Failed(DecompositionFailure),
    /// The tag was removed before the collider was ready.
    Cancelled,
}

impl Default for DecompositionStatus {
    fn default() -> Self {
        Self::Waiting(Wait::ForMesh)
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
pub enum Wait {
    /// There is no `Mesh3d` on it or below it, and no baked hulls, or they are not loaded.
    ForMesh,
    /// Others go first.
    InQueue,
}

/// Where hulls came from.
#[derive(Reflect, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Origin {
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
pub enum Skip {
    /// The entity had a `Collider` already, which stays.
    HasCollider,
    /// The body is fixed, so it got the triangle mesh itself.
    FixedBody,
}

/// Why there is no collider.
#[non_exhaustive]
#[derive(Reflect, Debug, Clone, PartialEq, thiserror::Error)]
#[reflect(opaque)]
#[reflect(Debug, Clone, PartialEq)]
pub enum DecompositionFailure {
    /// The asset server could not load the mesh or the baked hulls.
    #[error("the asset could not be loaded")]
    NotLoaded,
    /// The mesh's data is gone: it was uploaded and not kept.
    #[error(
        "the mesh is on the GPU only; load it with RenderAssetUsages::default(), which keeps \
         MAIN_WORLD"
    )]
    RenderWorldOnly,
    /// The mesh has no positions, or not as three `f32`.
    #[error("the mesh has no positions of three f32")]
    NoPositions,
    /// The mesh is made of points or lines.
    #[error("the mesh consists of {0} instead of triangles")]
    NotTriangles(&'static str),
    /// The mesh could not be decomposed or weighed.
    #[error("{0}")]
    Mesh(Error),
    /// Its hulls could not be made a collider.
    #[error("{0}")]
    Collider(ColliderError),
    /// Rapier refused the triangle mesh of a fixed body.
    #[error("Rapier refused the triangle mesh: {0}")]
    TriangleMesh(String),
    /// The work ended without a word.
    #[error("the background task ended without a result")]
    Lost,
}

impl From<ColliderError> for DecompositionFailure {
    fn from(error: ColliderError) -> Self {
        match error {
            ColliderError::Mesh(error) => Self::Mesh(error),
            error => Self::Collider(error),
        }
    }
}

impl From<Error> for DecompositionFailure {
    fn from(error: Error) -> Self {
        Self::Mesh(error)
    }
}

/// The entity has its collider: hulls, or the triangle mesh where the body is fixed. Also after a
/// changed scale or mesh.
#[derive(EntityEvent, Debug, Clone)]
pub struct DecompositionReady {
    /// The tagged entity.
    pub entity: Entity,
    /// Hulls of the collider; 0 if it is a triangle mesh.
    pub hulls: usize,
}

/// The entity gets no collider.
#[derive(EntityEvent, Debug, Clone)]
pub struct DecompositionFailed {
    /// The tagged entity.
    pub entity: Entity,
    /// Why not.
    pub failure: DecompositionFailure,
}

/// What the plugin has done and is doing.
#[derive(Resource, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Resource, Default, Clone, PartialEq)]
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
    /// Colliders that are a single hull, as those of convex meshes are.
    pub convex: usize,
    /// Triangle meshes for fixed bodies.
    pub triangle_meshes: usize,
    /// Entities skipped because they had a collider.
    pub had_collider: usize,
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
    /// How far its hulls stand out at most, verified, as a share of its mesh's diagonal.
    pub last_phantom: Option<f32>,
}
