//! The plugin for Bevy 0.20 with bevy_rapier3d 0.37 (feature `bevy`): tag a mesh, get a moving
//! concave body.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_rapier3d::prelude::*;
//! use hullwright::bevy::prelude::*;
//!
//! # fn setup(mut commands: Commands, mesh: Handle<Mesh>) {
//! commands.spawn((Mesh3d(mesh), RigidBody::Dynamic, ConvexDecomposition::default()));
//! # }
//! ```
//!
//! Work runs on Bevy's `AsyncComputeTaskPool`; no frame waits for it. [`DecompositionStatus`] and
//! the events [`DecompositionReady`] and [`DecompositionFailed`] say how it goes.
//!
//! | module | what |
//! |---|---|
//! | `plugin`, `settings` | the plugin, its systems' order, its settings |
//! | `tag`, `baked` | components that ask for a collider |
//! | `hierarchy`, `names` | whole scenes, what artists say |
//! | `status` | statuses, events, counters |
//! | `notice` | what makes a collider out of date |
//! | `resolve`, `mesh_data`, `placement` | which meshes, their triangles, what scale is baked |
//! | `work`, `run`, `job`, `library` | the queue, the jobs, what is known already |
//! | `meanwhile`, `hold` | stand-ins, and bodies that wait |
//! | `attach`, `failing` | results reach their entities, and what went wrong does |
//! | `debug` (feature) | hulls drawn, and numbers among the diagnostics |

mod attach;
mod baked;
#[cfg(feature = "debug")]
mod debug;
mod failing;
mod hierarchy;
mod hold;
mod job;
mod library;
mod meanwhile;
mod mesh_data;
mod names;
mod notice;
mod placement;
mod plugin;
mod resolve;
mod run;
mod settings;
mod status;
mod tag;
mod work;

pub use baked::{BakedDecomposition, BakedHulls, HullsLoader, LoadHullsError};
#[cfg(feature = "debug")]
pub use debug::{HullGizmos, HullwrightDebug, HullwrightDebugPlugin};
pub use hierarchy::ConvexDecompositionHierarchy;
pub use plugin::{HullwrightPlugin, HullwrightSystems};
pub use settings::{Execution, HullwrightSettings};
pub use status::{
    DecompositionCounters, DecompositionFailed, DecompositionFailure, DecompositionReady,
    DecompositionStatus, Origin, Skip, Wait,
};
pub use tag::{
    ConvexDecomposition, DEFAULT_DENSITY, DecompositionFocus, Meanwhile, NoConvexDecomposition,
};

/// What most users need.
pub mod prelude {
    pub use super::{
        BakedDecomposition, ConvexDecomposition, ConvexDecompositionHierarchy,
        DecompositionCounters, DecompositionFailed, DecompositionFocus, DecompositionReady,
        DecompositionStatus, HullwrightPlugin, HullwrightSettings, HullwrightSystems, Meanwhile,
        NoConvexDecomposition,
    };
}
