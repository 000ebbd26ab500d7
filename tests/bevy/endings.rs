//! Every tag ends in exactly one event, and the log says whose tag it was.

use std::time::Duration;

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::BakedHulls;
use hullwright::bevy::prelude::*;

use crate::app::*;
use crate::log::Log;

/// Frames in which nothing more may happen.
const AFTERWARDS: usize = 20;

/// What one tag ended in.
fn ending_of(more: impl Bundle) -> (App, Entity) {
    let (mut app, entity) = finished(model("u_prism"), more);
    update_times(&mut app, AFTERWARDS);
    assert_eq!(seen(&app).all(), 1);
    (app, entity)
}

#[test]
fn ready_says_hulls_verified_error_source_and_time() {
    let mut app = app();
    app.init_resource::<Last>();
    app.add_observer(|ready: On<DecompositionReady>, mut last: ResMut<Last>| {
        last.0 = Some(ready.event().clone());
    });
    let mesh = add(&mut app, model("u_prism"));
    let entity = finish(&mut app, &mesh, ());
    let last = |app: &App| app.world().resource::<Last>().0.clone().expect("an event");
    let first = last(&app);
    assert_eq!((first.entity, first.hulls), (entity, hulls(&app, entity).len()));
    assert_eq!(first.source, HullSource::Decomposed);
    assert!(first.time > Duration::ZERO);
    let error = first.error.expect("a verified error");
    assert!(error.max() <= 0.02, "{error:?}");

    let _ = finish(&mut app, &mesh, ());
    let second = last(&app);
    assert_eq!((second.source, second.error), (HullSource::Shared, Some(error)));
}

#[derive(Resource, Default)]
struct Last(Option<DecompositionReady>);

#[test]
fn a_fixed_body_is_skipped() {
    let (app, entity) = ending_of((automatic(), RigidBody::Fixed));
    assert_eq!(seen(&app).skipped, [(entity, SkipReason::FixedBody)]);
}

#[test]
fn an_entity_that_had_a_collider_keeps_it_and_is_skipped() {
    let (app, entity) = ending_of(Collider::ball(0.5));
    assert_eq!(seen(&app).skipped, [(entity, SkipReason::HasCollider)]);
    assert!(collider(&app, entity).as_ball().is_some());
    assert_eq!(counters(&app).had_collider, 1);
}

#[test]
fn what_can_not_be_decomposed_fails() {
    let (app, entity) = ending_of(tag().with_max_hulls(0));
    assert_eq!(seen(&app).failed[0].0, entity);
}

#[test]
fn a_tag_that_is_removed_in_time_is_cancelled() {
    let mut app = app_with(sliced());
    let mesh = add(&mut app, model("u_prism"));
    let [untagged, despawned] = [(); 2].map(|()| spawn(&mut app, &mesh));
    // Without a mesh they would wait for ever.
    let [without_mesh, despawned_without_mesh] =
        [(); 2].map(|()| app.world_mut().spawn((Transform::default(), tag())).id());
    update_times(&mut app, 3);
    assert_eq!(seen(&app).all(), 0);
    for entity in [untagged, without_mesh] {
        app.world_mut().entity_mut(entity).remove::<ConvexDecomposition>();
    }
    for entity in [despawned, despawned_without_mesh] {
        app.world_mut().despawn(entity);
    }
    update_times(&mut app, AFTERWARDS);
    let mut cancelled = seen(&app).cancelled.clone();
    cancelled.sort();
    let mut expected = [untagged, despawned, without_mesh, despawned_without_mesh];
    expected.sort();
    assert_eq!(cancelled, expected);
    assert_eq!((seen(&app).all(), counters(&app).cancelled), (4, 4));
}

#[test]
fn an_entity_with_both_tags_goes_on_with_the_other_or_is_cancelled_once() {
    let mut app = app_with(sliced());
    let mesh = add(&mut app, model("u_prism"));
    let handle = app.world().resource::<Assets<BakedHulls>>().reserve_handle();
    let both = || BakedDecomposition::new(handle.clone());
    let [goes_on, despawned] = [both(), both()].map(|baked| spawn_with(&mut app, &mesh, baked));
    app.update();
    app.world_mut().entity_mut(goes_on).remove::<BakedDecomposition>();
    app.world_mut().despawn(despawned);
    update_until_finished(&mut app, &[goes_on]);
    update_times(&mut app, AFTERWARDS);
    assert!(is_ready(&app, goes_on));
    assert_eq!(seen(&app).cancelled, [despawned]);
    assert_eq!(seen(&app).all(), 2);
}

#[test]
fn a_tag_that_is_removed_later_ends_no_second_time() {
    let (mut app, entity) = ending_of(());
    app.world_mut().entity_mut(entity).remove::<ConvexDecomposition>();
    app.world_mut().entity_mut(entity).insert(Transform::from_scale(Vec3::splat(2.0)));
    app.world_mut().entity_mut(entity).insert(RigidBody::Fixed);
    update_times(&mut app, AFTERWARDS);
    app.world_mut().despawn(entity);
    update_times(&mut app, AFTERWARDS);
    assert_eq!(seen(&app).all(), 1);
}

#[test]
fn a_failure_names_entity_name_and_asset() {
    Log::install();
    let mut app = app();
    let path = "of_no_other_test.mesh";
    let handle: Handle<Mesh> = app.world().resource::<AssetServer>().load(path);
    let parent = app.world_mut().spawn((Name::new("old chair"), Transform::default())).id();
    let entity = finish(&mut app, &handle, ChildOf(parent));
    let lines = Log::lines_with(path);
    assert_eq!(lines.len(), 1, "{lines:?}");
    let expected = format!("no convex decomposition for {entity} \"old chair\" ({path}): ");
    assert!(lines[0].starts_with(&expected), "{lines:?}");
}

#[test]
fn a_tag_without_a_mesh_is_logged_once() {
    Log::install();
    let patience = Some(Duration::from_millis(10));
    let mut app = app_with(HullwrightSettings { warn_without_mesh_after: patience, ..default() });
    let entities = ["waits in vain", "so does this"]
        .map(|name| app.world_mut().spawn((Name::new(name), Transform::default(), tag())).id());
    update_until(&mut app, |_| !Log::lines_with("waits in vain").is_empty());
    std::thread::sleep(Duration::from_millis(20));
    update_times(&mut app, AFTERWARDS);
    let lines = Log::lines_with("waits in vain");
    assert_eq!(lines.len(), 1, "{lines:?}");
    for text in ["2 entities", &entities[0].to_string(), "no Mesh3d"] {
        assert!(lines[0].contains(text), "{lines:?}");
    }
    // It is still waited for.
    let mesh = add(&mut app, unit_cube());
    app.world_mut().entity_mut(entities[1]).insert(Mesh3d(mesh));
    update_until_finished(&mut app, &entities[1..]);
    assert!(is_ready(&app, entities[1]));
}

#[test]
fn a_mesh_that_is_not_loaded_is_logged_once_with_its_path() {
    Log::install();
    let patience = Some(Duration::ZERO);
    let mut app = app_with(HullwrightSettings { warn_without_mesh_after: patience, ..default() });
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    app.world_mut().spawn((Name::new("never loaded"), Mesh3d(handle), tag()));
    update_times(&mut app, AFTERWARDS);
    let lines = Log::lines_with("never loaded");
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("is not loaded"), "{lines:?}");
}

#[test]
fn nothing_is_logged_if_the_settings_say_so() {
    Log::install();
    let mut app = app_with(HullwrightSettings { warn_without_mesh_after: None, ..default() });
    app.world_mut().spawn((Name::new("waits in silence"), Transform::default(), tag()));
    update_times(&mut app, AFTERWARDS);
    assert!(Log::lines_with("waits in silence").is_empty());
}
