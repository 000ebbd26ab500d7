//! The plugin's place among the others' systems.

use bevy::ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy::prelude::*;
use hullwright::bevy::prelude::*;

use crate::app::*;

#[test]
fn no_system_of_ours_is_ambiguous() {
    let mut app = app();
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_build_settings(ScheduleBuildSettings {
            ambiguity_detection: LogLevel::Ignore,
            ..default()
        });
    });
    app.update();
    let schedules = app.world().resource::<Schedules>();
    let schedule = schedules.get(PostUpdate).unwrap();
    let name = |key| format!("{:?}", schedule.graph().systems.get(key).map(|s| s.name()));
    let ours: Vec<String> = schedule
        .graph()
        .conflicting_systems()
        .iter()
        .map(|(a, b, _)| format!("{} and {}", name(*a), name(*b)))
        .filter(|names| names.contains("hullwright"))
        .collect();
    assert!(ours.is_empty(), "{ours:#?}");
}

#[test]
fn it_works_without_rapiers_plugin() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        bevy::asset::AssetPlugin::default(),
        HullwrightPlugin::default(),
    ));
    app.finish();
    app.cleanup();
    let mesh = add(&mut app, model("u_prism"));
    let entity = spawn(&mut app, &mesh);
    update_until_finished(&mut app, &[entity]);
    assert!(matches!(status(&app, entity), DecompositionStatus::Ready(_)));
}

#[test]
fn the_order_of_plugins_does_not_matter() {
    for is_first in [true, false] {
        let mut app = App::new();
        let others = (MinimalPlugins, bevy::asset::AssetPlugin::default(), bevy::mesh::MeshPlugin);
        if is_first {
            app.add_plugins(HullwrightPlugin::default()).add_plugins(others);
        } else {
            app.add_plugins(others);
            let before = add(&mut app, model("u_prism"));
            app.add_plugins(HullwrightPlugin::default());
            // What was there is not thrown away.
            assert!(app.world().resource::<Assets<Mesh>>().contains(&before));
        }
        app.finish();
        app.cleanup();
        let mesh = add(&mut app, model("u_prism"));
        let entity = spawn(&mut app, &mesh);
        update_until_finished(&mut app, &[entity]);
        assert!(matches!(status(&app, entity), DecompositionStatus::Ready(_)));
    }
}

#[test]
fn tags_and_settings_are_reflected() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for name in [
        "hullwright::bevy::tag::ConvexDecomposition",
        "hullwright::bevy::baked::BakedDecomposition",
        "hullwright::bevy::hierarchy::ConvexDecompositionHierarchy",
        "hullwright::bevy::status::DecompositionStatus",
        "hullwright::bevy::status::DecompositionCounters",
        "hullwright::bevy::settings::HullwrightSettings",
    ] {
        assert!(registry.get_with_type_path(name).is_some(), "{name} is not registered");
    }
}
