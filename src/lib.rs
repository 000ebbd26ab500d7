//! The plugin for Bevy 0.20 with Rapier or Avian: tag a mesh, get a moving concave body.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_hullwright::prelude::*;
//! use bevy_rapier3d::prelude::*; // or avian3d::prelude::*
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
//! Work runs on threads of the plugin's own, of a lower priority than the game's; no frame waits
//! for it. Every tag ends in exactly one of two events: [`ColliderReady`], or [`ColliderAbsent`]
//! with the reason. [`DecompositionStatus`] says the same at any time, and the finer events
//! [`DecompositionReady`], [`DecompositionSkipped`], [`DecompositionFailed`] and
//! [`DecompositionCancelled`] say more.
//!
//! The physics engine is Rapier (bevy_rapier3d 0.37) or Avian (avian3d 0.8), by a feature. The
//! default of [`HullwrightPlugin`] is for the engine that is built. Where both are, it is for
//! Rapier, and [`with_engine`](HullwrightPlugin::with_engine) chooses.
//!
//! In metres, Rapier's own contacts let small things sink into each other, so the plugin gives each
//! world of Rapier a `hullwright_rapier::ContactDispatcher`.
//! [`without_contact_dispatcher`](HullwrightPlugin::without_contact_dispatcher) leaves worlds as
//! they are. Avian calls Parry's contacts itself.
//!
//! | you have | you want | use |
//! |---|---|---|
//! | an app | the plugin | [`HullwrightPlugin`], [`HullwrightSettings`] |
//! | a mesh, or a glTF node with meshes below it | a collider | [`ConvexDecomposition`] |
//! | a whole scene | a collider per mesh, by names and extras | [`ConvexDecompositionHierarchy`] |
//! | a `.hullscene` file | the colliders of a scene without any work | [`ConvexDecompositionHierarchy::with_baked`] |
//! | the same, and no mesh | a collider | [`BakedDecomposition`] |
//! | a body that waits for its hulls | a collider until then | [`FallbackCollider`] |
//! | an entity | to know whether its collider is there | [`ColliderReady`], [`ColliderAbsent`], [`DecompositionStatus`] |
//! | a scene | to know when all of it is done | [`HierarchyFinished`], [`all_decompositions_done`] |
//! | a loading screen | to show how far it is | [`DecompositionProgress`] |
//! | many entities | the nearest first; how many are done | [`DecompositionFocus`], [`DecompositionPriority`], [`DecompositionCounters`] |
//! | the feature `debug` | hulls drawn, counters among the diagnostics | `HullwrightDebugPlugin` |
//!
//! | feature | what it adds |
//! |---|---|
//! | `rapier` (default) | the physics engine Rapier |
//! | `avian` | the physics engine Avian; with `default-features = false` Rapier is not built |
//! | `parallel` (default) | independent parts of the work run on rayon's pool, where the library is called directly |
//! | `bevy_gltf` | tags in glTF extras, what is hidden, levels of detail |
//! | `bake` | scenes are baked in Bevy's asset processor: `HullRecipeProcessor` |
//! | `debug` | `HullwrightDebugPlugin` |
//! | `serde` | tags and parameters can be written and read |

#![cfg_attr(docsrs, feature(doc_cfg))]

// Seven concepts, each but `engine` with a plugin of its own. Imports go down this table only; what
// a concept owns is private to it, and others use verbs on it.
//
// | concept | owns, and alone writes | what |
// |---|---|---|
// | `debug` (feature) | gizmos, diagnostics | hulls drawn, and numbers among the diagnostics |
// | `breaking` | `Fragment`, `CutFaces` | bodies that break into bodies |
// | `scene` | `HierarchyStatus`, `HierarchyWork`, `ColliderPieceOf`, `TaggedByHierarchy`, `HiddenByHierarchy`, `GltfPhysics`, `CollisionSystems`, `DecompositionProgress` | whole scenes, tagged by names, extras and what files say of physics, and how far all work is |
// | `collider` | `Unfinished`, `Fallbacks`, `Cells` with `LevelCell` and `InLevelCell`, `OwnCollider`, `OwnMass`, `AttachedCollider`, `AttachedFallback`, `FailedRequest`, `FarFromFocus`, `GivesSurface`, `Frozen` | from tags to requests, from results to colliders; what is out of date; colliders that follow a scale; bodies that wait |
// | `jobs` | `Jobs` with the caches, `FrameTime`, the asset `BakedScene` | requests wait, become jobs, end in results |
// | `engine` | the engine's collider and mass, `OwnMass`, what a body has during a step | the seam to Rapier and to Avian: what both do in different ways |
// | `tag` | `DecompositionStatus`, the events and counters of endings, by `Outcomes` alone | what users set, and what is reported |
//
// `scene` writes tags as users do. In the counters `jobs` and `collider` write how much runs and
// waits. `collider` writes `Frozen`, a type of `engine`, whose systems hold such bodies.

mod breaking;
mod collider;
#[cfg(feature = "debug")]
mod debug;
mod engine;
mod jobs;
mod scene;
mod tag;

use bevy::asset::AssetEventSystems;
use bevy::prelude::*;

use self::engine::Engine;

/// The library, and what makes its hulls Rapier's: their types are in this crate's signatures.
pub use hullwright;
pub use hullwright_parry;
pub use hullwright_parry::subshape_at;
#[cfg(feature = "rapier")]
pub use hullwright_rapier;

pub use breaking::{BreakApart, BreakApartExt, BrokenApart, CutFaces, Fragment};
pub use collider::cells::{InLevelCell, LevelCell};
pub use collider::children::HullCollider;
pub use collider::parts::ColliderParts;
#[cfg(feature = "debug")]
pub use debug::{HullGizmos, HullwrightDebug, HullwrightDebugPlugin};
pub use engine::PhysicsEngine;
pub use jobs::baked::{
    BakedDecomposition, BakedScene, BakedSceneSettings, FromBakedScene, HullSceneLoader,
    LoadHullsError,
};
#[cfg(feature = "bake")]
pub use jobs::recipe::{HullRecipeLoader, HullRecipeProcessor, HullSceneSaver};
pub use jobs::request::{mesh_of_hull, triangle_mesh};
#[cfg(feature = "bevy_gltf")]
pub use scene::collision_systems::CollisionSystems;
pub use scene::hierarchy::{
    ConvexDecompositionHierarchy, HierarchyFinished, HierarchyReport, HierarchyStatus,
};
pub use scene::tagging::{ColliderPieceOf, ColliderPieces};
pub use scene::{DecompositionProgress, all_decompositions_done, decompositions_pending};
pub use tag::outcomes::{
    AbsentReason, ColliderAbsent, ColliderReady, DecompositionCancelled, DecompositionCounters,
    DecompositionError, DecompositionFailed, DecompositionReady, DecompositionSkipped,
    DecompositionStatus, HullSource, MadeOf, SkipReason, VerifiedDistances, WaitReason,
};
pub use tag::settings::{
    BudgetSettings, CacheSettings, Execution, FallbackCollider, HullwrightSettings,
    HullwrightSystems, SkipSettings,
};
pub use tag::{
    ConvexDecomposition, DEFAULT_DENSITY, DecompositionFocus, DecompositionOpenings,
    DecompositionPreset, DecompositionPriority, DecompositionShape, HullGrouping, MaxError,
    NoConvexDecomposition,
};

/// What most users need.
pub mod prelude {
    #[cfg(feature = "bevy_gltf")]
    pub use super::CollisionSystems;
    pub use super::{
        AbsentReason, BakedDecomposition, BakedScene, BreakApart, BreakApartExt, BrokenApart,
        BudgetSettings, CacheSettings, ColliderAbsent, ColliderParts, ColliderPieceOf,
        ColliderPieces, ColliderReady, ConvexDecomposition, ConvexDecompositionHierarchy, CutFaces,
        DecompositionCancelled, DecompositionCounters, DecompositionFailed, DecompositionFocus,
        DecompositionOpenings, DecompositionPreset, DecompositionPriority, DecompositionProgress,
        DecompositionReady, DecompositionShape, DecompositionSkipped, DecompositionStatus,
        Execution, FallbackCollider, Fragment, FromBakedScene, HierarchyFinished, HierarchyReport,
        HierarchyStatus, HullCollider, HullGrouping, HullSource, HullwrightPlugin,
        HullwrightSettings, HullwrightSystems, InLevelCell, LevelCell, MadeOf, MaxError,
        NoConvexDecomposition, PhysicsEngine, SkipReason, SkipSettings, VerifiedDistances,
        WaitReason, all_decompositions_done, decompositions_pending,
    };
    #[cfg(feature = "debug")]
    pub use super::{HullwrightDebug, HullwrightDebugPlugin};
}

/// Gives entities with [`ConvexDecomposition`] their colliders.
///
/// Needs Bevy's `AssetPlugin`, and the physics engine's own plugin, which needs `TransformPlugin`;
/// `MinimalPlugins` are enough otherwise. The order of plugins does not matter.
#[derive(Debug, Clone, Default)]
pub struct HullwrightPlugin {
    /// The initial settings. Settings that were inserted before stay, unless these differ from the
    /// default in more than the contacts.
    pub settings: HullwrightSettings,
    /// The engine that gets the colliders. Default: Rapier, or Avian where the feature `rapier` is
    /// off.
    pub engine: PhysicsEngine,
}

impl HullwrightPlugin {
    /// The same for another engine, where a build has the features of both.
    #[must_use]
    pub fn with_engine(mut self, engine: PhysicsEngine) -> Self {
        self.engine = engine;
        self
    }

    /// The same, but worlds of Rapier keep their own contacts.
    #[must_use]
    pub fn without_contact_dispatcher(mut self) -> Self {
        self.settings.contact_dispatcher = false;
        self
    }
}

impl Plugin for HullwrightPlugin {
    fn build(&self, app: &mut App) {
        // Worlds that keep their contacts are no reason to drop settings that were inserted before.
        let with_contacts =
            HullwrightSettings { contact_dispatcher: true, ..self.settings.clone() };
        if with_contacts != HullwrightSettings::default() {
            app.insert_resource(self.settings.clone());
        } else if !self.settings.contact_dispatcher {
            app.init_resource::<HullwrightSettings>();
            app.world_mut().resource_mut::<HullwrightSettings>().contact_dispatcher = false;
        }
        app.configure_sets(
            PostUpdate,
            (
                HullwrightSystems::DetectChanges,
                HullwrightSystems::RunJobs,
                HullwrightSystems::Attach,
            )
                .chain()
                .before(TransformSystems::Propagate)
                // Bevy's UI and Rapier's soft bodies write assets after transforms and before the
                // events about them, so these can't come first. A mesh that was modified is seen in
                // the next frame, by its event and by the mark that Bevy then sets on `Mesh3d`.
                .before(AssetEventSystems),
        );
        app.add_plugins((tag::TagPlugin, jobs::JobsPlugin));
        match self.engine {
            #[cfg(feature = "rapier")]
            PhysicsEngine::Rapier => add_for_engine::<engine::rapier::Rapier>(app),
            #[cfg(feature = "avian")]
            PhysicsEngine::Avian => add_for_engine::<engine::avian::Avian>(app),
        }
    }

    /// Where a plugin is missing, Bevy's panic names a resource at best, and nothing at all may be
    /// said.
    fn finish(&self, app: &mut App) {
        let world = app.world();
        assert!(
            world.contains_resource::<AssetServer>(),
            "HullwrightPlugin needs Bevy's AssetPlugin: add it, or DefaultPlugins"
        );
        if !app.is_plugin_added::<TransformPlugin>() {
            log::warn!(
                "Bevy's TransformPlugin is missing: nothing has a place in the world, and the \
                 physics engine's systems fail"
            );
        }
        match self.engine {
            #[cfg(feature = "rapier")]
            PhysicsEngine::Rapier => engine::rapier::Rapier::finish(app),
            #[cfg(feature = "avian")]
            PhysicsEngine::Avian => engine::avian::Avian::finish(app),
        }
    }
}

fn add_for_engine<E: Engine>(app: &mut App) {
    E::build(app);
    app.add_plugins((collider::plugin::<E>, breaking::plugin::<E>, scene::plugin::<E>));
}

/// The pages' programs run as tests.
#[cfg(all(doctest, feature = "rapier"))]
mod pages {
    #[doc = include_str!("../docs/bevy.md")]
    struct Index;
    #[doc = include_str!("../docs/bevy/bounds.md")]
    struct Bounds;
    #[doc = include_str!("../docs/bevy/behaviour.md")]
    struct Behaviour;
    #[doc = include_str!("../docs/bevy/artists.md")]
    struct Artists;
    #[doc = include_str!("../docs/bevy/fixed-timestep.md")]
    struct FixedTimestep;
    #[doc = include_str!("../docs/bevy/hulls.md")]
    struct Hulls;
    #[doc = include_str!("../docs/bevy/levels.md")]
    struct Levels;
    #[doc = include_str!("../docs/bevy/migration.md")]
    struct Migration;
    #[doc = include_str!("../docs/bevy/settings.md")]
    struct Settings;
    #[doc = include_str!("../docs/bevy/troubleshooting.md")]
    struct Troubleshooting;
}

/// The page about files, whose programs run as tests.
#[cfg(all(doctest, feature = "bevy_gltf"))]
#[doc = include_str!("../docs/bevy/files.md")]
struct PageOfFiles;

/// The page about Avian, whose programs run as tests.
#[cfg(all(doctest, feature = "avian"))]
#[doc = include_str!("../docs/bevy/avian.md")]
struct PageOfAvian;
