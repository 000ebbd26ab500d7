//! Every tag ends in exactly one event, and the log says whose tag it was. Failures recover where
//! they can.

use std::time::Duration;

use bevy::asset::AssetPlugin;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_hullwright::DecompositionError;
use bevy_hullwright::prelude::*;
use hullwright::Error;

use crate::app::*;
use crate::baked::baked;
use crate::engine::*;

fn failure(app: &App, entity: Entity) -> DecompositionError {
    match status(app, entity) {
        DecompositionStatus::Failed(failure) => failure,
        other => panic!("it did not fail: {other:?}"),
    }
}

/// A cube with an index that is out of range.
fn broken_cube() -> Mesh {
    let mut cube = cuboid([0.0; 3], [1.0; 3]);
    cube.insert_indices(Indices::U32(vec![0, 1, 99]));
    cube
}

fn repair(app: &mut App, handle: &Handle<Mesh>) {
    let whole = cuboid([0.0; 3], [1.0; 3]);
    let indices = whole.indices().unwrap().clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.get_mut(handle).unwrap().insert_indices(indices);
}

/// Rapier's plugin may bring Bevy's for meshes, which marks entities whose mesh changed; a server
/// has neither, and the plugin alone must detect it.
fn app_without_rapier() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), hullwright(default())));
    app
}

/// No time limit per frame, so that all of one kind fail in the same.
fn unhurried() -> HullwrightSettings {
    let budget = BudgetSettings {
        frame_time: Duration::from_secs(60),
        max_attached_per_frame: usize::MAX,
        ..default()
    };
    HullwrightSettings { budget, ..default() }
}

#[test]
fn a_mesh_that_is_repaired_is_decomposed() {
    let (mut app, handle) = with_mesh(app_without_rapier(), broken_cube());
    let entities = [spawn(&mut app, &handle), spawn(&mut app, &handle)];
    update_until_finished(&mut app, &entities);
    for entity in entities {
        assert!(matches!(failure(&app, entity), DecompositionError::Mesh(_)));
    }
    repair(&mut app, &handle);
    update_until(&mut app, |app| {
        entities.iter().all(|entity| matches!(status(app, *entity), DecompositionStatus::Ready(_)))
    });
    for entity in entities {
        assert_near(bounds(&app, entity).1, [1.0; 3], 1e-3);
    }
}

#[test]
fn what_failed_without_a_tag_is_left_alone() {
    let (mut app, handle) = with_mesh(app_without_rapier(), broken_cube());
    let entity = finish(&mut app, &handle, ());
    app.edit(entity).remove::<ConvexDecomposition>();
    repair(&mut app, &handle);
    update_times(&mut app, 5);
    assert!(matches!(failure(&app, entity), DecompositionError::Mesh(_)));
    assert!(!has_collider(&app, entity));
}

#[test]
fn a_body_without_mass_gets_its_triangles_when_it_becomes_fixed() {
    let (mut app, handle) = with_mesh(app(), unit_cube());
    let tag = automatic().with_density(0.0);
    let entity = app.put((Mesh3d(handle), tag, RigidBody::Dynamic));
    update_until_finished(&mut app, &[entity]);
    assert!(matches!(failure(&app, entity), DecompositionError::Collider(_)));
    app.edit(entity).insert(FIXED);
    update_until(&mut app, |app| has_collider(app, entity));
    assert!(shape(collider(&app, entity)).as_trimesh().is_some());
}

#[test]
fn a_mesh_that_can_not_be_loaded_fails_and_recovers_when_it_is_there() {
    let mut app = app();
    let handle: Handle<Mesh> = app.load("nowhere.mesh");
    let entity = finish(&mut app, &handle, ());
    assert_eq!(failure(&app, entity), DecompositionError::NotLoaded);
    let cube = cuboid([0.0; 3], [1.0; 3]);
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(handle.id(), cube).unwrap();
    update_until(&mut app, |app| {
        status(app, entity) == DecompositionStatus::Ready(HullSource::Decomposed)
    });
}

#[test]
fn baked_hulls_that_can_not_be_loaded_fail_and_recover_when_they_are_there() {
    let mut app = app();
    let handle = app.load("nowhere.hullscene");
    let entity = app.put(BakedDecomposition::new(handle.clone()));
    update_until_finished(&mut app, &[entity]);
    assert_eq!(failure(&app, entity), DecompositionError::NotLoaded);
    let mut all = app.world_mut().resource_mut::<Assets<BakedScene>>();
    all.insert(handle.id(), BakedScene::new(baked())).unwrap();
    update_until(&mut app, |app| {
        status(app, entity) == DecompositionStatus::Ready(HullSource::Baked)
    });
}

#[test]
fn a_fixed_body_fails_as_clearly_as_others() {
    let nothing_finite = || mesh(vec![[f32::NAN; 3]; 3], vec![0, 1, 2]);
    let lines = || {
        Mesh::new(PrimitiveTopology::LineList, default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 6])
    };
    for (mesh, is_expected) in [
        (broken_cube(), |failure| {
            matches!(failure, DecompositionError::Mesh(Error::IndexOutOfRange { .. }))
        }),
        (nothing_finite(), |failure| {
            matches!(failure, DecompositionError::Mesh(Error::NothingUsable { .. }))
        }),
        (lines(), |failure| matches!(failure, DecompositionError::NotTriangles("lines"))),
    ] as [(Mesh, fn(DecompositionError) -> bool); 3]
    {
        let (app, entity) = finished(mesh, (automatic(), FIXED));
        let failure = failure(&app, entity);
        assert!(is_expected(failure.clone()), "{failure:?}");
        assert!(!has_collider(&app, entity));
        assert_eq!(failed(&app).len(), 1);
        assert_eq!((counters(&app).failed, counters(&app).triangle_meshes), (1, 0));
    }
}

#[test]
fn all_that_share_a_bad_mesh_fail_the_later_at_once_and_one_line_is_logged() {
    Log::install();
    let mut app = app();
    // No other test has a mesh of two vertices, and all share the log.
    let bad = add(&mut app, mesh(vec![[0.0; 3]; 2], Vec::new()));
    let entities: Vec<Entity> = (0..5).map(|_| spawn(&mut app, &bad)).collect();
    update_until_finished(&mut app, &entities);
    assert_eq!((counters(&app).failed, counters(&app).running), (5, 0));
    let later = spawn(&mut app, &bad);
    app.update();
    assert_eq!(status(&app, later), status(&app, entities[0]));
    assert_eq!((counters(&app).failed, failed(&app).len()), (6, 6));
    update_times(&mut app, 20);
    let lines = Log::lines_with("2 vertices");
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(!lines[0].contains('\n'));
}

#[test]
fn all_with_a_bad_density_fail_and_one_line_is_logged() {
    Log::install();
    let (mut app, mesh) = with_mesh(app_with(unhurried()), unit_cube());
    let _ = finish(&mut app, &mesh, ());
    // No other test has this density: the text says the mass.
    let tag = tag().with_density(-1.25e-7);
    let entities: Vec<Entity> =
        (0..30).map(|_| app.put((Mesh3d(mesh.clone()), tag.clone()))).collect();
    update_until_finished(&mut app, &entities);
    assert_eq!(counters(&app).failed, 30);
    let text = failure(&app, entities[0]).to_string();
    let lines = Log::lines_with(&text);
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("30 entities"), "{lines:?}");
}

#[test]
fn all_whose_mesh_can_not_be_loaded_fail_and_one_line_is_logged() {
    Log::install();
    let mut app = app_with(unhurried());
    let handle: Handle<Mesh> = app.load("nowhere.mesh");
    // No other test has as many.
    let entities: Vec<Entity> = (0..23).map(|_| spawn(&mut app, &handle)).collect();
    update_until_finished(&mut app, &entities);
    let lines = Log::lines_with(&DecompositionError::NotLoaded.to_string());
    let lines: Vec<_> = lines.iter().filter(|line| line.contains("23 entities")).collect();
    assert_eq!(lines.len(), 1, "{lines:?}");
}

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
fn ready_says_hulls_verified_distances_source_and_time() {
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
    let verified = first.verified.expect("verified distances");
    assert!(verified.max() <= 0.02, "{verified:?}");

    let _ = finish(&mut app, &mesh, ());
    let second = last(&app);
    assert_eq!((second.source, second.verified), (HullSource::Shared, Some(verified)));
}

#[derive(Resource, Default)]
struct Last(Option<DecompositionReady>);

#[test]
fn a_fixed_body_and_an_entity_that_had_a_collider_are_skipped() {
    let (app, entity) = ending_of((automatic(), FIXED));
    assert_eq!(seen(&app).skipped, [(entity, SkipReason::FixedBody)]);
    let (app, entity) = ending_of(ball(0.5));
    assert_eq!(seen(&app).skipped, [(entity, SkipReason::HasCollider)]);
    assert!(shape(collider(&app, entity)).as_ball().is_some());
    assert_eq!(counters(&app).had_collider, 1);
}

#[test]
fn what_can_not_be_decomposed_fails() {
    let (app, entity) = ending_of(tag().with_max_hulls(0));
    assert_eq!(seen(&app).failed[0].0, entity);
}

#[test]
fn a_tag_that_is_removed_in_time_is_cancelled() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let [untagged, despawned] = [(); 2].map(|()| spawn(&mut app, &mesh));
    // Without a mesh they would wait for ever.
    let [without_mesh, despawned_without_mesh] =
        [(); 2].map(|()| app.put((Transform::default(), tag())));
    update_times(&mut app, 3);
    assert_eq!(seen(&app).all(), 0);
    for entity in [untagged, without_mesh] {
        app.edit(entity).remove::<ConvexDecomposition>();
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
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let handle = app.world().resource::<Assets<BakedScene>>().reserve_handle();
    let both = || BakedDecomposition::new(handle.clone());
    let [goes_on, despawned] = [both(), both()].map(|baked| spawn_with(&mut app, &mesh, baked));
    app.update();
    app.edit(goes_on).remove::<BakedDecomposition>();
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
    app.edit(entity).remove::<ConvexDecomposition>();
    app.edit(entity).insert(Transform::from_scale(Vec3::splat(2.0)));
    app.edit(entity).insert(FIXED);
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
    let handle: Handle<Mesh> = app.load(path);
    let parent = app.put((Name::new("old chair"), Transform::default()));
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
        .map(|name| app.put((Name::new(name), Transform::default(), tag())));
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
    app.edit(entities[1]).insert(Mesh3d(mesh));
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
