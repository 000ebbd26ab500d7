//! Events for observers, one per entity.

use bevy::prelude::*;

use super::error::DecompositionError;

/// The entity has its collider: hulls, or the triangle mesh where the body is fixed. Also after a
/// changed scale or mesh.
///
/// ```
/// use bevy::prelude::*;
/// use hullwright::bevy::prelude::*;
///
/// # let mut app = App::new();
/// app.add_observer(|ready: On<DecompositionReady>| println!("{}: {}", ready.entity, ready.hulls));
/// ```
#[derive(EntityEvent, Debug, Clone)]
pub struct DecompositionReady {
    /// The tagged entity.
    pub entity: Entity,
    /// Hulls of the collider; 0 if it is a triangle mesh.
    pub hulls: usize,
}

/// The entity gets no collider.
///
/// ```
/// use bevy::prelude::*;
/// use hullwright::bevy::prelude::*;
///
/// # let mut app = App::new();
/// app.add_observer(|failed: On<DecompositionFailed>| eprintln!("{}: {}", failed.entity, failed.error));
/// ```
#[derive(EntityEvent, Debug, Clone)]
pub struct DecompositionFailed {
    /// The tagged entity.
    pub entity: Entity,
    /// Why not.
    pub error: DecompositionError,
}
