//! What an entity has until its collider is ready: a body that is frozen, a fallback collider.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

#[test]
fn a_body_is_frozen_until_its_collider_is_ready_and_then_falls() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let start = Transform::from_xyz(0.0, 5.0, 0.0);
    let own_locks = locked_along_z();
    let body = spawn_with(
        &mut app,
        &mesh,
        (RigidBody::Dynamic, mass_of_body(1.0), start, velocity(Vec3::X, Vec3::Y), own_locks),
    );
    let mut frozen_frames = 0;
    while !status(&app, body).is_finished() {
        app.update();
        if !status(&app, body).is_finished() {
            frozen_frames += 1;
            assert_eq!(app.get::<Transform>(body), Some(&start));
            // What a user reads or saves is the body's own.
            assert!(is_locked_along_z(&app, body));
            assert_eq!(linear_velocity(&app, body), Vec3::X);
        }
    }
    assert!(frozen_frames > 3, "it was ready at once");
    update_times(&mut app, 30);
    let moved = translation(&app, body) - start.translation;
    assert!(moved.y < -0.5, "it does not fall: {moved}");
    assert!(moved.x > 0.2, "its velocity was lost: {moved}");
    assert!(moved.z.abs() < 1e-3, "its axes were unlocked: {moved}");
    assert_ne!(app.get::<Transform>(body).unwrap().rotation, Quat::IDENTITY);
}

#[test]
fn a_frozen_body_stays_where_it_is_for_as_long_as_it_takes_and_falls_afterwards() {
    let mut app = app();
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let body = spawn_with(&mut app, &handle, RigidBody::Dynamic);
    // Longer than engines take to let a body sleep.
    update_times(&mut app, 200);
    assert_eq!(translation(&app, body), Vec3::ZERO);
    give_mesh(&mut app, body, &handle);
    update_times(&mut app, 30);
    assert!(translation(&app, body).y < -0.5);
}

#[test]
fn a_clone_of_a_frozen_body_and_one_that_was_saved_while_it_was_frozen_are_free_in_the_end() {
    let mut app = app();
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let push = || velocity(Vec3::X, Vec3::ZERO);
    // They are in one place, and do not touch.
    let alone = alone();
    let locks = locked_along_z();
    let more = (push(), locks, mass_of_body(1.0), alone);
    let body = spawn_with(&mut app, &handle, (RigidBody::Dynamic, Transform::default(), more));
    update_times(&mut app, 10);
    let clone = clone_of(&mut app, body);
    let saved = saved(&app, body);
    let loaded = load(&mut app, &saved);
    app.edit(loaded).insert(Mesh3d(handle.clone()));
    update_times(&mut app, 10);
    for entity in [body, clone, loaded] {
        assert_eq!(translation(&app, entity), Vec3::ZERO, "it is not frozen");
    }
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(handle.id(), unit_cube()).unwrap();
    update_until_finished(&mut app, &[body, clone, loaded]);
    update_times(&mut app, 30);
    for (what, entity) in [("it", body), ("its clone", clone), ("the one from a file", loaded)] {
        let moved = translation(&app, entity);
        assert!(moved.y < -0.5 && moved.x > 0.1 && moved.z.abs() < 1e-3, "{what}: {moved}");
        assert!(is_locked_along_z(&app, entity));
    }
}

#[test]
fn a_body_that_is_not_frozen_falls_at_once() {
    let mut app = app_with(HullwrightSettings { freeze_until_ready: false, ..default() });
    let never_loaded = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let body = spawn_with(&mut app, &never_loaded, (RigidBody::Dynamic, mass_of_body(1.0)));
    update_times(&mut app, 30);
    assert!(translation(&app, body).y < -0.5);
}

#[test]
fn a_body_is_released_when_the_work_fails_or_is_cancelled() {
    let (mut app, bad) = with_mesh(app(), mesh(vec![[1.0; 3]; 3], vec![0, 1, 2]));
    let body = || (RigidBody::Dynamic, mass_of_body(1.0), Transform::default());
    let failed = spawn_with(&mut app, &bad, body());
    let waiting = app.put((tag(), body()));
    update_until_finished(&mut app, &[failed]);
    update_times(&mut app, 30);
    assert_eq!(translation(&app, waiting), Vec3::ZERO);
    app.edit(waiting).remove::<ConvexDecomposition>();
    update_times(&mut app, 30);
    for body in [failed, waiting] {
        assert!(translation(&app, body).y < -0.5);
    }
}

#[test]
fn a_sleeping_body_wakes_when_its_collider_arrives() {
    let mut app = app_with(HullwrightSettings { freeze_until_ready: false, ..default() });
    let body = app.put((
        RigidBody::Dynamic,
        mass_of_body(1.0),
        GravityScale(0.0),
        asleep(),
        Transform::default(),
    ));
    update_times(&mut app, 10);
    assert!(is_asleep(&app, body));
    let mesh = add(&mut app, unit_cube());
    app.edit(body).insert((Mesh3d(mesh), tag()));
    update_until_finished(&mut app, &[body]);
    update_times(&mut app, 2);
    assert!(!is_asleep(&app, body));
}

/// A body that is frozen, since its mesh is not there yet, and the handle of that mesh.
fn frozen_body(app: &mut App, more: impl Bundle) -> (Entity, Handle<Mesh>) {
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let body = (RigidBody::Dynamic, GravityScale(0.0), Transform::default());
    let body = spawn_with(app, &handle, (body, more));
    update_times(app, 3);
    assert_eq!(translation(app, body), Vec3::ZERO);
    (body, handle)
}

fn give_mesh(app: &mut App, body: Entity, handle: &Handle<Mesh>) {
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(handle.id(), unit_cube()).unwrap();
    update_until_finished(app, &[body]);
    update_times(app, 2);
}

#[test]
fn a_velocity_that_is_set_while_the_body_is_frozen_comes_after_the_release() {
    for (before, expected) in
        [(Some(Vec3::X), Vec3::Z), (Some(Vec3::X), Vec3::ZERO), (None, Vec3::Y)]
    {
        let mut app = app();
        let (body, mesh) = match before {
            Some(linear) => frozen_body(&mut app, velocity(linear, Vec3::ZERO)),
            None => frozen_body(&mut app, ()),
        };
        set_linear_velocity(&mut app.edit(body), expected);
        update_times(&mut app, 10);
        // It is kept, and does not move the body.
        assert_near(translation(&app, body), Vec3::ZERO, 1e-6);
        give_mesh(&mut app, body, &mesh);
        assert_near(linear_velocity(&app, body), expected, 1e-3);
        assert_near(velocity_in_engine(&app, body), expected, 1e-3);
    }
}

#[test]
fn a_velocity_that_comes_in_the_frame_of_the_release_survives() {
    let mut app = app();
    let (body, _) = frozen_body(&mut app, velocity(Vec3::X, Vec3::ZERO));
    set_linear_velocity(&mut app.edit(body), Vec3::Z);
    app.edit(body).remove::<ConvexDecomposition>();
    update_times(&mut app, 3);
    assert_near(linear_velocity(&app, body), Vec3::Z, 1e-3);
}

/// Steps that one frame takes when the one before it was long.
const STEPS: u32 = 3;

#[derive(Resource)]
struct Crate(Mesh3d, Option<Entity>);

#[test]
fn a_body_that_is_tagged_before_a_fixed_step_does_not_move_before_it_is_ready() {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        bevy::asset::AssetPlugin::default(),
        TransformPlugin,
        hullwright(sliced()),
    ));
    add_physics_in_fixed_steps(&mut app);
    app.insert_resource(bevy::time::TimeUpdateStrategy::FixedTimesteps(STEPS));
    app.add_systems(FixedPreUpdate, |mut commands: Commands, mut it: ResMut<Crate>| {
        if it.1.is_none() {
            let body = (RigidBody::Dynamic, mass_of_body(1.0));
            let more = (velocity(Vec3::X, Vec3::ZERO), Transform::from_xyz(0.0, 5.0, 0.0));
            it.1 = Some(commands.spawn((it.0.clone(), tag(), body, more)).id());
        }
    });
    let mesh = add(&mut app, model("u_prism"));
    app.insert_resource(Crate(Mesh3d(mesh), None));
    app.finish();
    app.cleanup();
    // The first frame has no steps.
    update_until(&mut app, |app| app.world().resource::<Crate>().1.is_some());
    let body = app.world().resource::<Crate>().1.expect("a body");
    let mut frames = 0;
    while !status(&app, body).is_finished() {
        assert_eq!(translation(&app, body), Vec3::new(0.0, 5.0, 0.0));
        app.update();
        frames += 1;
    }
    assert!(frames > 3, "it was ready at once");
    update_times(&mut app, 10);
    let at = translation(&app, body);
    assert!(at.y < 4.9 && at.x > 0.2, "it does not fall, or lost its velocity: {at}");
}

/// An app with a tagged mesh in the queue, while another keeps the only job busy.
fn app_with_one_in_the_queue(
    settings: HullwrightSettings,
    tag: ConvexDecomposition,
) -> (App, Entity) {
    let mut settings = settings;
    settings.budget.max_jobs = 1;
    let mut app = app_with(settings);
    let busy = add(&mut app, model("dog"));
    spawn(&mut app, &busy);
    update_until(&mut app, |app| counters(app).running == 1);
    let mesh = add(&mut app, model("u_prism"));
    let entity = spawn_with(&mut app, &mesh, (tag, RigidBody::Dynamic));
    (app, entity)
}

/// Waits for the fallback and then for the collider in its place.
fn assert_falls_back(
    settings: HullwrightSettings,
    kind: FallbackCollider,
    is_it: impl Fn(&Collider) -> bool,
) {
    let (mut app, entity) = app_with_one_in_the_queue(settings, tag().with_fallback_collider(kind));
    update_until(&mut app, |app| has_collider(app, entity));
    assert!(!status(&app, entity).is_finished());
    assert!(is_it(collider(&app, entity)));
    let fallback = bounds(&app, entity);
    update_until_finished(&mut app, &[entity]);
    assert_eq!(hulls(&app, entity).len(), 3);
    assert_bounds(&app, entity, fallback.0, fallback.1, 2e-2);
    assert!(mass(&app, entity).mass > 0.0);
}

#[test]
fn the_bounding_box_is_the_collider_until_the_hulls_are_ready() {
    assert_falls_back(sliced(), FallbackCollider::BoundingBox, |collider| {
        shape(collider).as_compound().is_some_and(|parts| parts.shapes().len() == 1)
    });
}

#[test]
fn the_convex_hull_is_the_collider_until_the_hulls_are_ready() {
    for settings in [sliced(), default()] {
        assert_falls_back(settings, FallbackCollider::ConvexHull, |collider| {
            shape(collider).as_convex_polyhedron().is_some()
        });
    }
}

#[test]
fn there_is_no_fallback_by_default() {
    let (mut app, entity) = app_with_one_in_the_queue(sliced(), tag());
    let mut frames = 0;
    while !is_ready(&app, entity) {
        assert!(!has_collider(&app, entity), "in frame {frames}");
        app.update();
        frames += 1;
    }
    assert!(frames > 3, "it never waited");
}

#[test]
fn a_fallback_is_removed_with_the_tag() {
    let settings =
        HullwrightSettings { fallback_collider: FallbackCollider::BoundingBox, ..sliced() };
    let (mut app, entity) = app_with_one_in_the_queue(settings, tag());
    update_until(&mut app, |app| has_collider(app, entity));
    app.edit(entity).remove::<ConvexDecomposition>();
    update_times(&mut app, 2);
    assert!(!has_collider(&app, entity));
    assert!(!has_mass(&app, entity));
}
