//! What happens until a collider is ready.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;

use crate::app::*;

/// An app in which another mesh keeps the only job busy.
fn busy_app(settings: HullwrightSettings) -> App {
    let mut app = app_with(HullwrightSettings { max_jobs: 1, ..settings });
    let mesh = add(&mut app, model("dog"));
    spawn(&mut app, &mesh);
    update_until(&mut app, |app| counters(app).running == 1);
    app
}

fn assert_stands_in(meanwhile: Meanwhile, is_it: impl Fn(&Collider) -> bool) {
    let mut app = busy_app(default());
    let mesh = add(&mut app, model("u_prism"));
    let tag = tag().with_meanwhile(meanwhile);
    let entity = app.world_mut().spawn((Mesh3d(mesh), tag, RigidBody::Dynamic)).id();
    update_until(&mut app, |app| app.world().get::<Collider>(entity).is_some());
    assert!(!status(&app, entity).is_finished());
    assert!(is_it(collider(&app, entity)));
    let stand_in = bounds(&app, entity);
    update_until_finished(&mut app, &[entity]);
    assert_eq!(collider(&app, entity).as_compound().unwrap().shapes().count(), 3);
    let (low, high) = bounds(&app, entity);
    assert_near(low, stand_in.0, 2e-2);
    assert_near(high, stand_in.1, 2e-2);
    assert!(matches!(
        app.world().get::<ColliderMassProperties>(entity),
        Some(ColliderMassProperties::MassProperties(_))
    ));
}

#[test]
fn the_bounding_box_stands_in() {
    assert_stands_in(Meanwhile::BoundingBox, |collider| {
        collider.as_compound().is_some_and(|parts| parts.shapes().count() == 1)
    });
}

#[test]
fn the_convex_hull_stands_in() {
    assert_stands_in(Meanwhile::ConvexHull, |collider| collider.as_convex_polyhedron().is_some());
}

#[test]
fn nothing_stands_in_by_default() {
    let mut app = busy_app(default());
    let mesh = add(&mut app, model("u_prism"));
    let entity = spawn(&mut app, &mesh);
    update_times(&mut app, 3);
    assert!(status(&app, entity).is_finished() || app.world().get::<Collider>(entity).is_none());
}

#[test]
fn a_stand_in_goes_with_the_tag() {
    let mut app = busy_app(HullwrightSettings { meanwhile: Meanwhile::BoundingBox, ..default() });
    let mesh = add(&mut app, model("gear"));
    let entity = spawn(&mut app, &mesh);
    update_until(&mut app, |app| app.world().get::<Collider>(entity).is_some());
    app.world_mut().entity_mut(entity).remove::<ConvexDecomposition>();
    update_times(&mut app, 2);
    assert!(app.world().get::<Collider>(entity).is_none());
    assert!(app.world().get::<ColliderMassProperties>(entity).is_none());
}

#[test]
fn a_body_is_held_still_until_its_collider_is_ready_and_then_falls() {
    let mut app = busy_app(default());
    let mesh = add(&mut app, model("u_prism"));
    let start = Transform::from_xyz(0.0, 5.0, 0.0);
    let velocity = Velocity::linear(Vec3::X);
    let locked = LockedAxes::TRANSLATION_LOCKED_Z;
    let body = app
        .world_mut()
        .spawn((
            Mesh3d(mesh),
            tag(),
            RigidBody::Dynamic,
            AdditionalMassProperties::Mass(1.0),
            start,
            velocity,
            locked,
        ))
        .id();
    let place = |app: &App| app.world().get::<Transform>(body).unwrap().translation;
    update_until(&mut app, |app| {
        let is_held = place(app).distance(start.translation) < 1e-6;
        let is_finished = status(app, body).is_finished();
        assert!(is_held || is_finished, "it moved to {}", place(app));
        is_finished
    });
    update_times(&mut app, 30);
    assert_eq!(app.world().get::<LockedAxes>(body), Some(&locked));
    let moved = place(&app) - start.translation;
    assert!(moved.y < -0.5, "it does not fall: {moved}");
    assert!(moved.x > 0.2, "its velocity was lost: {moved}");
    assert!(moved.z.abs() < 1e-3, "its axes were unlocked: {moved}");
}

#[test]
fn a_body_that_is_not_held_falls_at_once() {
    let mut app = busy_app(HullwrightSettings { hold_still: false, ..default() });
    let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let body = app
        .world_mut()
        .spawn((Mesh3d(handle), tag(), RigidBody::Dynamic, AdditionalMassProperties::Mass(1.0)))
        .id();
    update_times(&mut app, 30);
    assert!(app.world().get::<Transform>(body).unwrap().translation.y < -0.5);
}

#[test]
fn a_body_is_let_go_when_the_work_fails_or_is_cancelled() {
    let mut app = app();
    let bad = add(&mut app, mesh(vec![[1.0; 3]; 3], vec![0, 1, 2]));
    let failed = app.world_mut().spawn((Mesh3d(bad), tag(), RigidBody::Dynamic)).id();
    let waiting = app.world_mut().spawn((Transform::default(), tag(), RigidBody::Dynamic)).id();
    update_until_finished(&mut app, &[failed]);
    assert_eq!(app.world().get::<LockedAxes>(waiting), Some(&LockedAxes::all()));
    app.world_mut().entity_mut(waiting).remove::<ConvexDecomposition>();
    update_times(&mut app, 2);
    for body in [failed, waiting] {
        let locked = app.world().get::<LockedAxes>(body).copied().unwrap_or(LockedAxes::empty());
        assert!(locked.is_empty());
    }
}

#[test]
fn a_sleeping_body_wakes_when_its_collider_arrives() {
    let mut app = app_with(HullwrightSettings { hold_still: false, ..default() });
    let body = app
        .world_mut()
        .spawn((
            RigidBody::Dynamic,
            AdditionalMassProperties::Mass(1.0),
            GravityScale(0.0),
            Sleeping { sleeping: true, ..default() },
            Transform::default(),
        ))
        .id();
    update_times(&mut app, 10);
    assert!(app.world().get::<Sleeping>(body).unwrap().sleeping);
    let mesh = add(&mut app, cuboid([0.0; 3], [1.0; 3]));
    app.world_mut().entity_mut(body).insert((Mesh3d(mesh), tag()));
    update_until_finished(&mut app, &[body]);
    update_times(&mut app, 2);
    assert!(!app.world().get::<Sleeping>(body).unwrap().sleeping);
}
