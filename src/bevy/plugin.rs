//! The plugin: what it adds to an app, and in which order its systems run.

use bevy::asset::AssetEventSystems;
use bevy::prelude::*;
use bevy_rapier3d::plugin::PhysicsSet;

use crate::bevy::collider::attach::attach;
use crate::bevy::collider::changes::{
    detect_assets, detect_bodies, detect_scales, detect_tags, on_untag,
};
use crate::bevy::collider::contacts::set_dispatcher;
use crate::bevy::collider::failures::report_failures;
use crate::bevy::collider::fallback_collider::{attach_fallbacks, remove_fallbacks};
use crate::bevy::collider::freeze::{Frozen, freeze, freeze_new, release};
use crate::bevy::collider::resolve::resolve;
use crate::bevy::collider::skip::{FarFromFocus, drop_far, start_near};
use crate::bevy::jobs::baked::{BakedDecomposition, BakedHulls, HullsLoader};
use crate::bevy::jobs::baked_scene::{BakedScene, FromBakedScene, HullSceneLoader};
use crate::bevy::jobs::cache::GeometryCache;
use crate::bevy::jobs::finish::finish_jobs;
use crate::bevy::jobs::queue::WorkQueue;
use crate::bevy::jobs::request::AttachedFallback;
use crate::bevy::jobs::scene_processor::{HullSceneProcessor, HullSceneSaver};
use crate::bevy::jobs::start::start_jobs;
use crate::bevy::scene::hierarchy::{ConvexDecompositionHierarchy, tag_hierarchies};
use crate::bevy::scene::hierarchy_progress::finish_hierarchies;
use crate::bevy::scene::hierarchy_status::{HierarchyStatus, HierarchyWork};
use crate::bevy::scene::progress::{DecompositionProgress, sum_up_progress};
use crate::bevy::tag::components::{
    ConvexDecomposition, DecompositionFocus, NoConvexDecomposition,
};
use crate::bevy::tag::decomposition_priority::DecompositionPriority;
use crate::bevy::tag::events::{
    DecompositionCancelled, DecompositionFailed, DecompositionReady, DecompositionSkipped,
};
use crate::bevy::tag::settings::HullwrightSettings;
use crate::bevy::tag::status::{DecompositionCounters, DecompositionStatus};

/// Gives entities with [`ConvexDecomposition`] their colliders.
///
/// Needs Bevy's `AssetPlugin`, and Rapier's plugin needs `TransformPlugin`; `MinimalPlugins` are
/// enough otherwise. The order of plugins does not matter.
#[derive(Debug, Clone, Default)]
pub struct HullwrightPlugin {
    /// The initial settings. If they are the default, settings that were inserted before stay.
    pub settings: HullwrightSettings,
}

/// The plugin's systems, in `PostUpdate` before Bevy propagates transforms and before Rapier's
/// `PhysicsSet::SyncBackend`.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HullwrightSystems {
    /// New and changed tags, meshes and scales are detected.
    DetectChanges,
    /// Jobs finish and start.
    RunJobs,
    /// Colliders are attached and events sent.
    Attach,
    /// Hulls are drawn and counters become diagnostics, by `HullwrightDebugPlugin`; after Bevy
    /// propagates transforms.
    #[cfg(feature = "debug")]
    Debug,
}

impl Plugin for HullwrightPlugin {
    fn build(&self, app: &mut App) {
        if has_asset_server(app) {
            set_up_assets(app);
        }
        // What was inserted before the plugin stays, unless the plugin has settings of its own.
        let has_own = self.settings != HullwrightSettings::default();
        if has_own || !app.world().contains_resource::<HullwrightSettings>() {
            app.insert_resource(self.settings.clone());
        }
        register_types(app);
        app.init_resource::<WorkQueue>()
            .init_resource::<GeometryCache>()
            .init_resource::<DecompositionCounters>()
            .init_resource::<DecompositionProgress>()
            .add_observer(on_untag::<ConvexDecomposition>)
            .add_observer(on_untag::<BakedDecomposition>);
        #[cfg(feature = "bevy_gltf")]
        app.add_observer(crate::bevy::scene::hierarchy_progress::on_scene_spawned);
        // Where Rapier runs in fixed steps: a body that is tagged before them does not fall.
        app.add_systems(
            FixedUpdate,
            freeze_new.in_set(HullwrightSystems::DetectChanges).before(PhysicsSet::SyncBackend),
        );
        app.configure_sets(
            PostUpdate,
            (
                HullwrightSystems::DetectChanges,
                HullwrightSystems::RunJobs,
                HullwrightSystems::Attach,
            )
                .chain()
                .before(TransformSystems::Propagate)
                .before(PhysicsSet::SyncBackend)
                // Bevy's UI and Rapier's soft bodies write assets after transforms and before the
                // events about them, so these can't come first. A mesh that was modified is seen in
                // the next frame, by its event and by the mark that Bevy then sets on `Mesh3d`.
                .before(AssetEventSystems),
        );
        app.add_systems(
            PostUpdate,
            (
                set_dispatcher.in_set(HullwrightSystems::DetectChanges),
                (
                    tag_hierarchies,
                    detect_tags,
                    detect_bodies,
                    detect_assets,
                    detect_scales,
                    #[cfg(feature = "bevy_gltf")]
                    crate::bevy::collider::skip::detect_shown.run_if(skips_hidden),
                    start_near.run_if(any_with_component::<FarFromFocus>),
                    drop_far.run_if(drops_far),
                )
                    .chain()
                    .in_set(HullwrightSystems::DetectChanges),
                (finish_jobs, resolve, start_jobs, attach_fallbacks)
                    .chain()
                    .in_set(HullwrightSystems::RunJobs)
                    .run_if(is_busy),
                (
                    (attach, report_failures).chain().run_if(is_busy),
                    freeze.run_if(
                        is_busy
                            .or_else(any_with_component::<Frozen>)
                            .or_else(any_match_filter::<Added<FarFromFocus>>),
                    ),
                    release.run_if(any_with_component::<Frozen>),
                    remove_fallbacks.run_if(any_with_component::<AttachedFallback>),
                    finish_hierarchies.run_if(any_with_component::<HierarchyWork>),
                    sum_up_progress,
                )
                    .chain()
                    .in_set(HullwrightSystems::Attach),
            ),
        );
    }

    fn finish(&self, app: &mut App) {
        // Where Bevy's plugin for assets came after ours.
        if has_asset_server(app) && !app.world().contains_resource::<Assets<BakedHulls>>() {
            set_up_assets(app);
        }
    }
}

/// For scenes, editors and extras that name types.
fn register_types(app: &mut App) {
    app.register_type::<ConvexDecomposition>()
        .register_type::<BakedDecomposition>()
        .register_type::<ConvexDecompositionHierarchy>()
        .register_type::<HierarchyStatus>()
        .register_type::<FromBakedScene>()
        .register_type::<DecompositionPriority>()
        .register_type::<DecompositionProgress>()
        .register_type::<NoConvexDecomposition>()
        .register_type::<DecompositionFocus>()
        .register_type::<DecompositionStatus>()
        .register_type::<DecompositionReady>()
        .register_type::<DecompositionSkipped>()
        .register_type::<DecompositionFailed>()
        .register_type::<DecompositionCancelled>()
        .register_type::<DecompositionCounters>()
        .register_type::<HullwrightSettings>();
}

fn has_asset_server(app: &App) -> bool {
    app.world().contains_resource::<AssetServer>()
}

/// Meshes are Bevy's own; without its plugin for them, as on a server, they are set up here. A second
/// time would drop all meshes.
fn set_up_assets(app: &mut App) {
    if !app.world().contains_resource::<Assets<Mesh>>() {
        app.init_asset::<Mesh>();
    }
    app.init_asset::<BakedHulls>()
        .register_asset_reflect::<BakedHulls>()
        .register_asset_loader(HullsLoader);
    // What concerns Bevy's processor does nothing where there is none.
    app.init_asset::<BakedScene>()
        .register_asset_reflect::<BakedScene>()
        .register_asset_loader(HullSceneLoader)
        .register_asset_processor(HullSceneProcessor::from(HullSceneSaver))
        .set_default_asset_processor::<HullSceneProcessor>("hullscene");
}

fn drops_far(settings: Res<HullwrightSettings>) -> bool {
    settings.drop_far
}

#[cfg(feature = "bevy_gltf")]
fn skips_hidden(settings: Res<HullwrightSettings>) -> bool {
    settings.skip_hidden
}

fn is_busy(queue: Res<WorkQueue>, counters: Res<DecompositionCounters>) -> bool {
    !queue.is_idle() || !counters.show_idle()
}
