//! Hulls to be seen and counters to be read, where there is something to draw on and where not.

use bevy::asset::AssetPlugin;
use bevy::diagnostic::{DiagnosticPath, DiagnosticsStore};
use bevy::gizmos::{GizmoAsset, GizmoPlugin};
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_hullwright::{HullwrightDebug, HullwrightDebugPlugin};

use crate::app::*;
use crate::engine::*;

/// Ours before Bevy's, so that what Bevy brings is not there yet when ours is added.
fn debug_app(add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((HullwrightDebugPlugin, hullwright(default())));
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
    assert_eq!(lines(&mut app, true), 12);
    assert_eq!(lines(&mut app, false), 0);
    assert_eq!(lines(&mut app, true), 12);
}

fn app_with_gizmos() -> App {
    debug_app(|app| {
        app.add_plugins((MeshPlugin, GizmoPlugin));
    })
}

/// Lines of the last frame, and the colours that they have.
fn drawn(app: &mut App) -> (usize, Vec<[u8; 3]>) {
    update_times(app, 3);
    let assets = app.world().resource::<Assets<GizmoAsset>>();
    let (mut ends, mut colours) = (0, Vec::new());
    for (_, gizmo) in assets.iter() {
        let buffer = gizmo.buffer().buffer();
        ends += buffer.list_positions.len();
        let bytes = |colour: &LinearRgba| Srgba::from(*colour).to_u8_array_no_alpha();
        colours.extend(buffer.list_colors.iter().map(bytes));
    }
    colours.sort_unstable();
    colours.dedup();
    (ends / 2, colours)
}

const GREEN: [u8; 3] = [77, 204, 77];
const GREY: [u8; 3] = [153, 153, 153];
const RED: [u8; 3] = [255, 38, 26];

#[test]
fn a_hundred_large_static_meshes_are_boxes_and_their_triangles_on_request_within_the_limit() {
    let mut app = app_with_gizmos();
    let dog = add(&mut app, model("dog"));
    let dogs: Vec<Entity> = (0..100).map(|_| spawn_with(&mut app, &dog, automatic())).collect();
    update_until_finished(&mut app, &dogs);
    assert_eq!(drawn(&mut app), (1200, vec![GREEN]));
    app.world_mut().resource_mut::<HullwrightDebug>().triangles = true;
    let (lines, _) = drawn(&mut app);
    assert_eq!(lines, 20_000);
}

#[test]
fn what_is_far_is_not_drawn_and_what_waits_or_failed_has_a_box() {
    use bevy::camera::primitives::Aabb;
    let mut app = app_with_gizmos();
    app.world_mut().spawn((Transform::default(), DecompositionFocus));
    let cube = add(&mut app, unit_cube());
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    let [near, far] = [10.0, 100.0].map(|x| spawn_with(&mut app, &cube, at(x)));
    update_until_finished(&mut app, &[near, far]);
    assert_eq!(drawn(&mut app).0, 12);
    app.world_mut().resource_mut::<HullwrightDebug>().radius = 200.0;
    assert_eq!(drawn(&mut app).0, 24);

    let mut debug = app.world_mut().resource_mut::<HullwrightDebug>();
    debug.hulls = false;
    let never = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let bounds = || Aabb::from_min_max(Vec3::ZERO, Vec3::ONE);
    let _ = spawn_with(&mut app, &never, (at(0.0), bounds()));
    assert_eq!(drawn(&mut app), (12, vec![GREY]));
    let bad = add(&mut app, mesh(vec![[1.0; 3]; 3], vec![0, 1, 2]));
    let _ = finish(&mut app, &bad, (at(0.0), bounds()));
    assert_eq!(drawn(&mut app), (24, vec![GREY, RED]));
    app.world_mut().resource_mut::<HullwrightDebug>().waiting = false;
    assert_eq!(drawn(&mut app), (12, vec![RED]));
}
