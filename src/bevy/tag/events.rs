//! Events for observers. Every tag ends in exactly one of them: ready, skipped, failed or cancelled. What
//! changes later, such as the mesh or the scale, starts anew and ends in one again.

use std::time::Duration;

use bevy::prelude::*;

use crate::bevy::tag::error::DecompositionError;
use crate::bevy::tag::status::{HullSource, SkipReason};

/// The entity has its collider of hulls. Also after a changed scale or mesh.
///
/// ```
/// use bevy::prelude::*;
/// use hullwright::bevy::prelude::*;
///
/// # let mut app = App::new();
/// app.add_observer(|ready: On<DecompositionReady>| println!("{}: {}", ready.entity, ready.hulls));
/// ```
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionReady {
    /// The tagged entity.
    pub entity: Entity,
    /// Hulls of the collider, at least 1.
    pub hulls: usize,
    /// How far hulls and mesh are apart; `None` where nothing was verified, as by the paper's method.
    pub error: Option<VerifiedError>,
    /// Where the hulls came from.
    pub source: HullSource,
    /// From the tag, or from what changed, to the collider, by the clock on the wall.
    pub time: Duration,
}

/// How far hulls and mesh are apart, as verified, in shares of the mesh's diagonal before scale.
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct VerifiedError {
    /// No point of a hull is farther outside the solid: things stop before they touch.
    pub protrusion: f32,
    /// No point of the surface is farther outside every hull: things sink in.
    pub uncovered: f32,
}

impl VerifiedError {
    /// The larger of both, which is what the tag's bound is about.
    pub fn max(&self) -> f32 {
        self.protrusion.max(self.uncovered)
    }
}

/// No decomposition was made. The entity has the collider that it had, or its triangles.
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionSkipped {
    /// The tagged entity.
    pub entity: Entity,
    /// Why.
    pub reason: SkipReason,
}

/// The entity gets no collider.
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionFailed {
    /// The tagged entity.
    pub entity: Entity,
    /// Why not.
    pub error: DecompositionError,
}

/// The tag was removed, or the entity despawned, before the collider was ready. A despawned entity is
/// gone when observers run.
#[derive(EntityEvent, Reflect, Debug, Clone, PartialEq)]
#[reflect(Debug, Clone, PartialEq)]
#[type_path = "hullwright"]
pub struct DecompositionCancelled {
    /// The entity that was tagged.
    pub entity: Entity,
}
