//! Hulls to be seen and counters to be read, where there is something to draw on and where not.

use bevy::asset::AssetPlugin;
use bevy::diagnostic::{DiagnosticPath, DiagnosticsStore};
use bevy::gizmos::{GizmoAsset, GizmoPlugin};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use hullwright::bevy::prelude::*;
use hullwright::bevy::{HullwrightDebug, HullwrightDebugPlugin};

use crate::app::*;

/// Ours before Bevy's, so that what Bevy brings is not there yet when ours is added.
fn debug_app(add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((HullwrightDebugPlugin, HullwrightPlugin::default()));
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
    add(&mut app);
    app.finish();
    app.cleanup();
    app
}

fn measured(app: &App, path: &DiagnosticPath) -> Option<f64> {
    app.world().resource::<DiagnosticsStore>().get(path).expect("it is registered").value()
}

#[test]
fn a_server_without_gizmos_has_the_counters_among_its_diagnostics() {
    let (mut app, cube) = with_mesh(debug_app(|_| {}), unit_cube());
    let entities = [spawn(&mut app, &cube), spawn(&mut app, &cube)];
    update_until_finished(&mut app, &entities);
    update_times(&mut app, 3);
    for (path, expected) in [
        (HullwrightDebugPlugin::DECOMPOSED, 1.0),
        (HullwrightDebugPlugin::SHARED, 1.0),
        (HullwrightDebugPlugin::CONVEX, 2.0),
        (HullwrightDebugPlugin::CACHED_COUNT, 1.0),
        (HullwrightDebugPlugin::RUNNING, 0.0),
        (HullwrightDebugPlugin::WAITING, 0.0),
        (HullwrightDebugPlugin::FAILED, 0.0),
        (HullwrightDebugPlugin::FROM_DISK, 0.0),
        (HullwrightDebugPlugin::BAKED, 0.0),
        (HullwrightDebugPlugin::TRIANGLE_MESHES, 0.0),
        (HullwrightDebugPlugin::HAD_COLLIDER, 0.0),
        (HullwrightDebugPlugin::CANCELLED, 0.0),
    ] {
        assert_eq!(measured(&app, &path), Some(expected), "{path}");
    }
    let bound = f64::from(100.0 * counters(&app).last_bound.unwrap());
    let found = measured(&app, &HullwrightDebugPlugin::BOUND).unwrap();
    assert!((found - bound).abs() < 1e-4, "{found} % is not {bound} %");
    assert!(measured(&app, &HullwrightDebugPlugin::CACHED).unwrap() > 0.0);
}

#[test]
fn hulls_are_drawn_until_they_are_switched_off_and_again_when_on() {
    let mut app = debug_app(|app| {
        app.add_plugins((MeshPlugin, GizmoPlugin));
    });
    let cube = add(&mut app, unit_cube());
    let _ = finish(&mut app, &cube, ());
    let lines = |app: &mut App, is_drawn| {
        app.world_mut().resource_mut::<HullwrightDebug>().is_drawn = is_drawn;
        update_times(app, 3);
        let assets = app.world().resource::<Assets<GizmoAsset>>();
        let ends = assets.iter().map(|(_, gizmo)| gizmo.buffer().buffer().list_positions.len());
        ends.sum::<usize>() / 2
    };
    // Six faces of four edges, each drawn from both sides.
    assert_eq!(lines(&mut app, true), 24);
    assert_eq!(lines(&mut app, false), 0);
    assert_eq!(lines(&mut app, true), 24);
}
