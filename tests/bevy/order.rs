//! The plugin's place among the others' systems.

use std::collections::HashSet;

use bevy::asset::{AssetEventSystems, AssetPlugin};
use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

/// An app with all that has to do with us: Bevy's systems for meshes, the engine's, ours.
fn full_app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        MeshPlugin,
        TransformPlugin,
        physics(),
        hullwright(default()),
    ));
    #[cfg(feature = "debug")]
    app.add_plugins((bevy::gizmos::GizmoPlugin, bevy_hullwright::HullwrightDebugPlugin));
    app.finish();
    app.cleanup();
    app
}

/// The pairs of systems that may run in any order and touch the same, one of them ours.
fn ambiguities(mut app: App) -> Vec<String> {
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_build_settings(ScheduleBuildSettings {
            ambiguity_detection: LogLevel::Ignore,
            ..default()
        });
    });
    app.update();
    let schedules = app.world().resource::<Schedules>();
    let schedule = schedules.get(PostUpdate).unwrap();
    let sets = [
        HullwrightSystems::DetectChanges,
        HullwrightSystems::RunJobs,
        HullwrightSystems::Attach,
        #[cfg(feature = "debug")]
        HullwrightSystems::Debug,
    ];
    let mut ours = HashSet::new();
    for set in sets {
        let systems = schedule.graph().systems_in_set(set.intern()).unwrap();
        assert!(!systems.is_empty(), "nothing in {set:?}");
        ours.extend(systems.iter().copied());
    }
    let conflicts = schedule.graph().conflicting_systems();
    let with_ours = conflicts.iter().filter(|(a, b, _)| ours.contains(a) || ours.contains(b));
    with_ours.map(|conflict| format!("{conflict:?}")).collect()
}

#[test]
fn no_system_of_ours_is_ambiguous() {
    let found = ambiguities(full_app());
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_system_that_is_ambiguous_with_ours_would_be_seen() {
    let mut app = full_app();
    app.add_systems(PostUpdate, |mut counters: ResMut<DecompositionCounters>| {
        counters.decomposed += 1;
    });
    assert!(!ambiguities(app).is_empty());
}

/// With Bevy's default features the schedule once had no order: `bevy_ui` writes assets after
/// transforms are propagated, and bevy_rapier's soft bodies write meshes after the step.
#[test]
fn others_may_write_assets_after_transforms_and_after_the_step() {
    let mut app = full_app();
    app.add_systems(
        PostUpdate,
        (
            (|| ()).after(TransformSystems::Propagate).before(AssetEventSystems),
            (|| ()).in_set(AFTER).before(AssetEventSystems),
        ),
    );
    app.update();
}

/// Decomposes a mesh in an app that is not started yet.
fn assert_it_works(mut app: App) {
    app.finish();
    app.cleanup();
    let mesh = add(&mut app, model("u_prism"));
    let entity = finish(&mut app, &mesh, ());
    assert!(is_ready(&app, entity));
}

#[test]
fn it_works_without_the_engines_plugin() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), hullwright(default())));
    assert_it_works(app);
}

#[test]
fn it_works_before_bevys_mesh_plugin() {
    let mut app = App::new();
    app.add_plugins(hullwright(default()));
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin));
    assert_it_works(app);
}

#[test]
fn it_works_after_bevys_mesh_plugin_and_throws_no_mesh_away() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), MeshPlugin));
    let before = add(&mut app, model("u_prism"));
    app.add_plugins(hullwright(default()));
    assert!(app.world().resource::<Assets<Mesh>>().contains(&before));
    assert_it_works(app);
}

#[test]
fn one_line_names_the_plugin_that_is_missing() {
    Log::install();
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), hullwright(default())));
    app.finish();
    for name in [PHYSICS_PLUGIN, "TransformPlugin is missing"] {
        assert!(!Log::lines_with(name).is_empty(), "{name}");
    }
}

#[test]
#[should_panic(expected = "AssetPlugin")]
fn without_assets_the_panic_names_the_plugin() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, hullwright(default())));
    app.finish();
}
