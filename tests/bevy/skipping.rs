//! What is skipped on request: each with its counter.

use std::time::Duration;

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::SkipReason;
use hullwright::bevy::prelude::*;

use crate::app::*;

fn skipped(app: &App, entity: Entity) -> Option<SkipReason> {
    match status(app, entity) {
        DecompositionStatus::Skipped(reason) => Some(reason),
        _ => None,
    }
}

fn place(app: &mut App, entity: Entity, x: f32) {
    app.world_mut().get_mut::<Transform>(entity).unwrap().translation.x = x;
}

#[test]
fn what_is_too_small_in_the_world_gets_no_collider() {
    let mut app = app_with(HullwrightSettings { min_size: 1.0, ..default() });
    let cube = add(&mut app, unit_cube());
    // The diagonal of a unit cube is 1.73.
    let [small, large] = [0.5, 0.6]
        .map(|scale| spawn_with(&mut app, &cube, Transform::from_scale(Vec3::splat(scale))));
    update_until_finished(&mut app, &[small, large]);
    assert_eq!(skipped(&app, small), Some(SkipReason::TooSmall));
    assert!(!has_collider(&app, small) && has_collider(&app, large));
    assert_eq!(counters(&app).too_small, 1);
}

#[cfg(feature = "bevy_gltf")]
#[test]
fn what_is_hidden_starts_when_it_is_shown() {
    let mut app = app_with(HullwrightSettings { skip_hidden: true, ..default() });
    let cube = add(&mut app, unit_cube());
    let room = app.world_mut().spawn((Transform::default(), Visibility::Hidden)).id();
    let inside = spawn_with(&mut app, &cube, (ChildOf(room), Visibility::Inherited));
    let shown = spawn_with(&mut app, &cube, (ChildOf(room), Visibility::Visible));
    update_until_finished(&mut app, &[inside, shown]);
    assert_eq!(skipped(&app, inside), Some(SkipReason::Hidden));
    assert!(is_ready(&app, shown));
    assert_eq!(counters(&app).hidden, 1);
    app.world_mut().entity_mut(room).insert(Visibility::Visible);
    update_until(&mut app, |app| is_ready(app, inside));
}

#[test]
fn what_is_far_from_every_focus_starts_when_one_is_near() {
    let mut app = app_with(HullwrightSettings { focus_radius: Some(10.0), ..default() });
    let cube = add(&mut app, unit_cube());
    let focus = app.world_mut().spawn((Transform::default(), DecompositionFocus)).id();
    let at = |x: f32| (Transform::from_xyz(x, 0.0, 0.0), RigidBody::Dynamic);
    let near = spawn_with(&mut app, &cube, at(9.0));
    let far = spawn_with(&mut app, &cube, at(50.0));
    update_until_finished(&mut app, &[near, far]);
    assert!(is_ready(&app, near));
    assert_eq!((skipped(&app, far), counters(&app).too_far), (Some(SkipReason::TooFar), 1));
    // Without a collider it would fall through the floor.
    update_times(&mut app, 20);
    assert_eq!(translation(&app, far), Vec3::new(50.0, 0.0, 0.0));
    place(&mut app, focus, 45.0);
    update_until(&mut app, |app| is_ready(app, far));
    update_times(&mut app, 20);
    assert!(translation(&app, far).y < -0.1, "it is still frozen");
    // It stays when the focus goes away, unless the settings say otherwise.
    place(&mut app, focus, -500.0);
    update_times(&mut app, 5);
    assert!(has_collider(&app, far));
}

#[test]
fn a_collider_that_is_far_may_be_dropped_and_comes_back() {
    let settings = HullwrightSettings { focus_radius: Some(10.0), drop_far: true, ..default() };
    let mut app = app_with(settings);
    let cube = add(&mut app, unit_cube());
    let focus = app.world_mut().spawn((Transform::default(), DecompositionFocus)).id();
    let entity = finish(&mut app, &cube, ());
    // At the border it neither comes nor goes.
    place(&mut app, focus, 11.0);
    update_times(&mut app, 3);
    assert!(has_collider(&app, entity));
    place(&mut app, focus, 100.0);
    update_until(&mut app, |app| !has_collider(app, entity));
    assert_eq!(skipped(&app, entity), Some(SkipReason::TooFar));
    assert!(app.world().get::<ColliderMassProperties>(entity).is_none());
    place(&mut app, focus, 0.0);
    update_until(&mut app, |app| has_collider(app, entity));
    assert!(is_ready(&app, entity));
    assert_eq!((counters(&app).decomposed, counters(&app).too_far), (1, 1));
}

#[test]
fn without_a_focus_or_a_radius_nothing_is_far() {
    let mut app = app_with(HullwrightSettings { focus_radius: Some(1.0), ..default() });
    let cube = add(&mut app, unit_cube());
    let first = spawn_with(&mut app, &cube, Transform::from_xyz(50.0, 0.0, 0.0));
    update_until(&mut app, |app| is_ready(app, first));
    app.world_mut().spawn((Transform::default(), DecompositionFocus));
    let second = spawn_with(&mut app, &cube, Transform::from_xyz(50.0, 0.0, 0.0));
    update_until(&mut app, |app| skipped(app, second).is_some());
    app.world_mut().resource_mut::<HullwrightSettings>().focus_radius = None;
    update_until(&mut app, |app| is_ready(app, second));
}

#[test]
fn a_higher_priority_goes_before_a_shorter_distance() {
    // All are seen in the same frame, however slow the machine.
    let frame_budget = Duration::MAX;
    let mut app = app_with(HullwrightSettings { max_jobs: 1, frame_budget, ..default() });
    app.world_mut().spawn((Transform::default(), DecompositionFocus));
    let mut entities = Vec::new();
    for (x, priority) in [(1.0, 0), (2.0, -1), (9.0, 7), (3.0, 0)] {
        let mesh = add(&mut app, cuboid([0.0; 3], [1.0 + x; 3]));
        let more = (Transform::from_xyz(x, 0.0, 0.0), DecompositionPriority(priority));
        entities.push(spawn_with(&mut app, &mesh, more));
    }
    update_until_finished(&mut app, &entities);
    let order: Vec<usize> = ready(&app)
        .iter()
        .map(|(entity, _)| entities.iter().position(|other| other == entity).unwrap())
        .collect();
    assert_eq!(order, [2, 0, 3, 1]);
}

#[test]
fn hulls_that_are_boxes_become_boxes_on_request() {
    for (primitives, boxes) in [(false, 0), (true, 2)] {
        // An L is two boxes.
        let scale = Transform::from_scale(Vec3::splat(2.0));
        let (app, entity) = finished_with(
            HullwrightSettings { primitives, ..default() },
            model("l_prism"),
            (RigidBody::Dynamic, scale),
        );
        let compound = collider(&app, entity).raw.as_compound().unwrap();
        let found = compound.shapes().iter().filter(|(_, part)| part.as_cuboid().is_some());
        assert_eq!((found.count(), compound.shapes().len()), (boxes, 2));
    }
}
