//! The plugin: what it adds to an app, and in which order its systems run.

use bevy::asset::AssetEventSystems;
use bevy::mesh::mark_3d_meshes_as_changed_if_their_assets_changed;
use bevy::prelude::*;
use bevy_rapier3d::plugin::PhysicsSet;

use super::baked::{BakedDecomposition, BakedHulls, HullsLoader};
use super::hierarchy::ConvexDecompositionHierarchy;
use super::library::Library;
use super::work::Work;
use super::{
    ConvexDecomposition, DecompositionCounters, DecompositionFocus, DecompositionStatus,
    HullwrightSettings, NoConvexDecomposition, attach, failing, hierarchy, hold, meanwhile, notice,
    resolve, run,
};

/// Gives entities with [`ConvexDecomposition`] their colliders.
///
/// Needs Bevy's `AssetPlugin`, and Rapier's plugin needs `TransformPlugin`; `MinimalPlugins` are
/// enough otherwise. The order of plugins does not matter.
#[derive(Debug, Clone, Default)]
pub struct HullwrightPlugin {
    /// The settings to begin with.
    pub settings: HullwrightSettings,
}

/// The plugin's systems, in `PostUpdate` before Bevy propagates transforms and before Rapier's
/// [`PhysicsSet::SyncBackend`].
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum HullwrightSystems {
    /// What is new and what has changed is noticed.
    Notice,
    /// Jobs end and begin.
    Work,
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
        app.insert_resource(self.settings.clone())
            .init_resource::<Work>()
            .init_resource::<Library>()
            .init_resource::<DecompositionCounters>()
            .register_type::<ConvexDecomposition>()
            .register_type::<BakedDecomposition>()
            .register_type::<ConvexDecompositionHierarchy>()
            .register_type::<NoConvexDecomposition>()
            .register_type::<DecompositionFocus>()
            .register_type::<DecompositionStatus>()
            .register_type::<DecompositionCounters>()
            .register_type::<HullwrightSettings>()
            .add_observer(notice::on_untag::<ConvexDecomposition>)
            .add_observer(notice::on_untag::<BakedDecomposition>);
        app.configure_sets(
            PostUpdate,
            (HullwrightSystems::Notice, HullwrightSystems::Work, HullwrightSystems::Attach)
                .chain()
                .after(AssetEventSystems)
                // It marks entities whose mesh changed, which `notice` then sees in the same frame.
                .after(mark_3d_meshes_as_changed_if_their_assets_changed)
                .before(TransformSystems::Propagate)
                .before(PhysicsSet::SyncBackend),
        );
        app.add_systems(
            PostUpdate,
            (
                (
                    hierarchy::tag_hierarchies,
                    notice::notice_tags,
                    notice::notice_bodies,
                    notice::notice_assets,
                    notice::notice_scales,
                )
                    .chain()
                    .in_set(HullwrightSystems::Notice),
                (run::finish_jobs, resolve::resolve, run::start_jobs, meanwhile::stand_in)
                    .chain()
                    .in_set(HullwrightSystems::Work)
                    .run_if(is_busy),
                (
                    (attach::attach, failing::report_failures, hold::hold).chain().run_if(is_busy),
                    hold::release.run_if(any_with_component::<hold::Held>),
                    meanwhile::remove_stand_ins.run_if(any_with_component::<meanwhile::StandIn>),
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

fn has_asset_server(app: &App) -> bool {
    app.world().contains_resource::<AssetServer>()
}

/// Meshes are Bevy's own; without its plugin for them, as on a server, they are set up here. Doing
/// so twice would throw away what is there.
fn set_up_assets(app: &mut App) {
    if !app.world().contains_resource::<Assets<Mesh>>() {
        app.init_asset::<Mesh>();
    }
    app.init_asset::<BakedHulls>().register_asset_loader(HullsLoader);
}

fn is_busy(work: Res<Work>, counters: Res<DecompositionCounters>) -> bool {
    let is_shown_idle = counters.running + counters.queued + counters.waiting_for_mesh == 0;
    !work.is_idle() || !is_shown_idle
}
