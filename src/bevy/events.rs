//! Events for observers, one per entity.

use bevy::prelude::*;

use super::error::DecompositionError;

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
    pub error: DecompositionError,
}
