//! The plugin for Bevy 0.20 with bevy_rapier3d 0.37 (feature `bevy`): tag a mesh, get a moving
//! concave body.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_rapier3d::prelude::*;
//! use hullwright::bevy::prelude::*;
//!
//! # fn setup(mut commands: Commands, mesh: Handle<Mesh>) {
//! commands.spawn((
//!     Mesh3d(mesh),
//!     RigidBody::Dynamic,
//!     // At most 1 % of the mesh's diagonal between hulls and mesh; 2 % without it.
//!     ConvexDecomposition::default().with_max_error(0.01),
//! ));
//! # }
//! ```
//!
//! Work runs on Bevy's `AsyncComputeTaskPool`; no frame waits for it. [`DecompositionStatus`] and
//! the events [`DecompositionReady`], [`DecompositionSkipped`], [`DecompositionFailed`] and
//! [`DecompositionCancelled`] report it: every tag ends in exactly one of them.
//!
//! | you have | you want | use |
//! |---|---|---|
//! | an app | the plugin | [`HullwrightPlugin`], [`HullwrightSettings`] |
//! | a mesh, or a glTF node with meshes below it | a collider | [`ConvexDecomposition`] |
//! | a whole scene | a collider per mesh, by names and extras | [`ConvexDecompositionHierarchy`] |
//! | a `.hulls` file | a collider without any work | [`BakedDecomposition`] |
//! | a `.hullscene` file | the same for a scene | [`ConvexDecompositionHierarchy::with_baked`] |
//! | a body that waits for its hulls | a collider until then | [`FallbackCollider`] |
//! | an entity | to know how far it is | [`DecompositionStatus`], and one event at its end |
//! | a scene | to know when all of it is done | [`HierarchyFinished`], [`all_decompositions_done`] |
//! | a loading screen | to show how far it is | [`DecompositionProgress`] |
//! | many entities | the nearest first; how many are done | [`DecompositionFocus`], [`DecompositionPriority`], [`DecompositionCounters`] |
//! | the feature `debug` | hulls drawn, counters among the diagnostics | `HullwrightDebugPlugin` |

// Modules, by layers; each uses those above it and the public API of the rest of the crate only:
//
// | module | what |
// |---|---|
// | `error`, `status`, `events`, `settings` | what users read, and what all entities share |
// | `tag`, `decomposition_priority`, `baked`, `baked_scene` | components that request a collider |
// | `scene_recipe` (feature `io`), `scene_processor` | scenes that are baked when they are loaded, or at build time |
// | `parameters` | from the tag's flat settings to the library's parameters |
// | `artists`, `nodes`, `hierarchy` | whole scenes, tagged by names and extras |
// | `mesh_data`, `convert`, `placement` | triangles of meshes, and the scale that is baked |
// | `primitive`, `static_geometry` | boxes, balls and capsules; which colliders are triangle meshes |
// | `content`, `cache`, `disk_cache` | known results by content |
// | `task` | one decomposition, in steps |
// | `request`, `budget`, `queue` | requests of entities, and the state of all work |
// | `outcomes` | statuses, counters and the events in which tags end |
// | `describe` | entities by id, name and asset, for the log |
// | `change_detection` | what makes a collider out of date |
// | `skip` | what is hidden, too small or too far |
// | `resolve` | from tags to requests |
// | `pool`, `scheduler` | jobs start and finish |
// | `fallback_collider`, `freeze` | colliders and bodies that wait |
// | `attach`, `failures` | results and errors reach their entities |
// | `hierarchy_status`, `hierarchy_progress`, `progress` | how far scenes and all work are |
// | `debug` (feature) | hulls drawn, and numbers among the diagnostics |
// | `plugin` | the systems and their order |

mod collider;
#[cfg(feature = "debug")]
mod debug;
mod jobs;
mod plugin;
mod scene;
mod tag;

#[cfg(feature = "debug")]
pub use debug::{HullGizmos, HullwrightDebug, HullwrightDebugPlugin};
pub use jobs::baked::{BakedDecomposition, BakedHulls, HullsLoader, LoadHullsError};
pub use jobs::baked_scene::{BakedScene, FromBakedScene, HullSceneLoader};
pub use jobs::scene_processor::{HullSceneProcessor, HullSceneSaver};
pub use plugin::{HullwrightPlugin, HullwrightSystems};
pub use scene::hierarchy::ConvexDecompositionHierarchy;
pub use scene::hierarchy_status::{HierarchyFinished, HierarchyReport, HierarchyStatus};
pub use scene::progress::{DecompositionProgress, all_decompositions_done, decompositions_pending};
pub use tag::components::{
    ConvexDecomposition, DEFAULT_DENSITY, DecompositionFocus, DecompositionOpenings,
    DecompositionPreset, DecompositionShape, MaxError, NoConvexDecomposition,
};
pub use tag::decomposition_priority::DecompositionPriority;
pub use tag::error::DecompositionError;
pub use tag::events::{
    DecompositionCancelled, DecompositionFailed, DecompositionReady, DecompositionSkipped,
    VerifiedError,
};
pub use tag::settings::{Execution, FallbackCollider, HullwrightSettings};
pub use tag::status::{
    DecompositionCounters, DecompositionStatus, HullSource, SkipReason, WaitReason,
};

/// What most users need.
pub mod prelude {
    pub use super::{
        BakedDecomposition, ConvexDecomposition, ConvexDecompositionHierarchy,
        DecompositionCancelled, DecompositionCounters, DecompositionFailed, DecompositionFocus,
        DecompositionOpenings, DecompositionPreset, DecompositionReady, DecompositionShape,
        DecompositionSkipped, DecompositionStatus, FallbackCollider, HullSource, HullwrightPlugin,
        HullwrightSettings, HullwrightSystems, MaxError, NoConvexDecomposition, SkipReason,
        VerifiedError,
    };
    pub use super::{
        BakedScene, DecompositionPriority, DecompositionProgress, FromBakedScene,
        HierarchyFinished, HierarchyReport, HierarchyStatus, all_decompositions_done,
        decompositions_pending,
    };
}

/// The pages' programs run as tests, except the one in `docs/bevy.md`, which needs a window: it is the README's.
#[cfg(doctest)]
mod pages {
    #[doc = include_str!("../../docs/bevy.md")]
    struct Index;
    #[doc = include_str!("../../docs/bevy/bounds.md")]
    struct Bounds;
    #[doc = include_str!("../../docs/bevy/fixed-timestep.md")]
    struct FixedTimestep;
    #[doc = include_str!("../../docs/bevy/migration.md")]
    struct Migration;
    #[doc = include_str!("../../docs/bevy/settings.md")]
    struct Settings;
    #[doc = include_str!("../../docs/bevy/troubleshooting.md")]
    struct Troubleshooting;
}
