//! What is skipped on request, each with its counter, and what never moves, which gets its
//! triangles.

use std::time::Duration;

use bevy::prelude::*;
use bevy_hullwright::SkipReason;
use bevy_hullwright::prelude::*;

use hullwright_parry::parry3d::shape::TriMeshFlags;

use crate::app::*;
use crate::engine::*;

fn skipped(app: &App, entity: Entity) -> Option<SkipReason> {
    match status(app, entity) {
        DecompositionStatus::Skipped(reason) => Some(reason),
        _ => None,
    }
}

fn place(app: &mut App, entity: Entity, x: f32) {
    app.change::<Transform>(entity).translation.x = x;
}

#[test]
fn what_is_too_small_in_the_world_gets_no_collider() {
    let mut app = app_with(skipping(SkipSettings { min_size: 1.0, ..default() }));
    let cube = add(&mut app, unit_cube());
    // The diagonal of a unit cube is 1.73.
    let [small, large] = [0.5, 0.6]
        .map(|scale| spawn_with(&mut app, &cube, Transform::from_scale(Vec3::splat(scale))));
    update_until_finished(&mut app, &[small, large]);
    assert_eq!(skipped(&app, small), Some(SkipReason::TooSmall));
    assert!(!has_collider(&app, small) && has_collider(&app, large));
    assert_eq!(counters(&app).too_small, 1);
}

/// As the page about scenes says of what is skipped.
#[test]
fn a_body_that_is_too_small_hangs_where_it_is_unless_it_has_a_mass() {
    let mut app = app_with(skipping(SkipSettings { min_size: 9.0, ..default() }));
    let cube = add(&mut app, unit_cube());
    let hangs = finish(&mut app, &cube, RigidBody::Dynamic);
    let falls = (RigidBody::Dynamic, mass_of_body(1.0));
    let falls = finish(&mut app, &cube, falls);
    update_times(&mut app, 30);
    assert_eq!(translation(&app, hangs), Vec3::ZERO);
    assert!(translation(&app, falls).y < -0.5);
}

#[test]
fn a_body_with_one_small_part_falls_with_the_others() {
    let mut app = app_with(skipping(SkipSettings { min_size: 1.0, ..default() }));
    let cube = add(&mut app, unit_cube());
    let body = app.put((RigidBody::Dynamic, Transform::default()));
    let small = Transform::from_scale(Vec3::splat(0.1));
    let bolt = spawn_with(&mut app, &cube, (ChildOf(body), small));
    let case = spawn_with(&mut app, &cube, (ChildOf(body), Transform::default()));
    update_until_finished(&mut app, &[bolt, case]);
    assert_eq!(skipped(&app, bolt), Some(SkipReason::TooSmall));
    update_times(&mut app, 30);
    assert!(translation(&app, body).y < -0.5);
}

#[test]
fn a_body_of_small_parts_alone_hangs_also_where_it_becomes_one_later_unless_it_has_a_mass() {
    let mut app = app_with(skipping(SkipSettings { min_size: 9.0, ..default() }));
    let cube = add(&mut app, unit_cube());
    let bodies = [0; 2].map(|_| app.put(Transform::default()));
    let bolts = bodies.map(|body| spawn_with(&mut app, &cube, ChildOf(body)));
    update_until_finished(&mut app, &bolts);
    let [hangs, falls] = bodies;
    app.edit(hangs).insert(RigidBody::Dynamic);
    app.edit(falls).insert((RigidBody::Dynamic, mass_of_body(1.0)));
    update_times(&mut app, 30);
    assert!(translation(&app, hangs).y > -0.05);
    assert!(translation(&app, falls).y < -0.5);
}

#[cfg(feature = "bevy_gltf")]
#[test]
fn a_body_that_is_hidden_hangs_where_it_is_and_falls_once_it_is_shown() {
    let mut app = app_with(skipping(SkipSettings { hidden: true, ..default() }));
    let cube = add(&mut app, unit_cube());
    let hidden = (RigidBody::Dynamic, Visibility::Hidden);
    let hangs = finish(&mut app, &cube, hidden);
    let falls = finish(&mut app, &cube, (hidden, mass_of_body(1.0)));
    update_times(&mut app, 30);
    assert_eq!(skipped(&app, hangs), Some(SkipReason::Hidden));
    assert_eq!(translation(&app, hangs), Vec3::ZERO);
    assert!(translation(&app, falls).y < -0.5);
    app.edit(hangs).insert(Visibility::Visible);
    update_until(&mut app, |app| is_ready(app, hangs));
    update_times(&mut app, 30);
    assert!(translation(&app, hangs).y < -0.5);
    // What is hidden later keeps its collider.
    app.edit(hangs).insert(Visibility::Hidden);
    update_times(&mut app, 30);
    assert!(has_collider(&app, hangs));
}

#[cfg(feature = "bevy_gltf")]
#[test]
fn what_is_hidden_starts_when_it_is_shown() {
    let mut app = app_with(skipping(SkipSettings { hidden: true, ..default() }));
    let cube = add(&mut app, unit_cube());
    let room = app.put((Transform::default(), Visibility::Hidden));
    let inside = spawn_with(&mut app, &cube, (ChildOf(room), Visibility::Inherited));
    let shown = spawn_with(&mut app, &cube, (ChildOf(room), Visibility::Visible));
    update_until_finished(&mut app, &[inside, shown]);
    assert_eq!(skipped(&app, inside), Some(SkipReason::Hidden));
    assert!(is_ready(&app, shown));
    assert_eq!(counters(&app).hidden, 1);
    app.edit(room).insert(Visibility::Visible);
    update_until(&mut app, |app| is_ready(app, inside));
}

#[test]
fn what_is_far_from_every_focus_starts_when_one_is_near() {
    let mut app = app_with(skipping(SkipSettings { focus_radius: Some(10.0), ..default() }));
    let cube = add(&mut app, unit_cube());
    let focus = app.put((Transform::default(), DecompositionFocus));
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
    let settings = skipping(SkipSettings { focus_radius: Some(10.0), drop_far: true, ..default() });
    let (mut app, cube) = with_mesh(app_with(settings), unit_cube());
    let focus = app.put((Transform::default(), DecompositionFocus));
    let entity = finish(&mut app, &cube, ());
    // At the border it neither comes nor goes.
    place(&mut app, focus, 11.0);
    update_times(&mut app, 3);
    assert!(has_collider(&app, entity));
    place(&mut app, focus, 100.0);
    update_until(&mut app, |app| !has_collider(app, entity));
    assert_eq!(skipped(&app, entity), Some(SkipReason::TooFar));
    assert!(!has_mass(&app, entity));
    place(&mut app, focus, 0.0);
    update_until(&mut app, |app| has_collider(app, entity));
    assert!(is_ready(&app, entity));
    assert_eq!((counters(&app).decomposed, counters(&app).too_far), (1, 1));
}

#[test]
fn without_a_focus_or_a_radius_nothing_is_far() {
    let mut app = app_with(skipping(SkipSettings { focus_radius: Some(1.0), ..default() }));
    let cube = add(&mut app, unit_cube());
    let first = spawn_with(&mut app, &cube, Transform::from_xyz(50.0, 0.0, 0.0));
    update_until(&mut app, |app| is_ready(app, first));
    app.world_mut().spawn((Transform::default(), DecompositionFocus));
    let second = spawn_with(&mut app, &cube, Transform::from_xyz(50.0, 0.0, 0.0));
    update_until(&mut app, |app| skipped(app, second).is_some());
    app.world_mut().resource_mut::<HullwrightSettings>().skip.focus_radius = None;
    update_until(&mut app, |app| is_ready(app, second));
}

#[test]
fn a_higher_priority_goes_before_a_shorter_distance() {
    // All are seen in the same frame, however slow the machine.
    let budget = BudgetSettings { max_jobs: 1, frame_time: Duration::MAX, ..default() };
    let mut app = app_with(HullwrightSettings { budget, ..default() });
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
        let compound = shape(collider(&app, entity)).as_compound().unwrap();
        let found = compound.shapes().iter().filter(|(_, part)| part.as_cuboid().is_some());
        assert_eq!((found.count(), compound.shapes().len()), (boxes, 2));
    }
}

/// Whether an entity with this ends with triangles, and why.
fn triangles_of(more: impl Bundle) -> Option<SkipReason> {
    triangles_by(automatic(), more)
}

fn triangles_by(tag: ConvexDecomposition, more: impl Bundle) -> Option<SkipReason> {
    let (app, entity) = finished(model("u_prism"), (tag, more));
    let reason = reason(&app, entity);
    let is_mesh = reason.is_some();
    let counters = counters(&app);
    assert_eq!(
        (counters.triangle_meshes, counters.decomposed),
        (usize::from(is_mesh), usize::from(!is_mesh))
    );
    reason
}

fn reason(app: &App, entity: Entity) -> Option<SkipReason> {
    let is_mesh = shape(collider(app, entity)).as_trimesh().is_some();
    match status(app, entity) {
        DecompositionStatus::Skipped(reason) if is_mesh => Some(reason),
        DecompositionStatus::Ready(_) if !is_mesh => None,
        other => panic!("{other:?}, and triangles: {is_mesh}"),
    }
}

#[test]
fn triangles_without_a_body_and_on_a_fixed_one_hulls_for_all_that_moves() {
    assert_eq!(triangles_of(()), Some(SkipReason::NoBody));
    assert_eq!(triangles_of(FIXED), Some(SkipReason::FixedBody));
    for body in [RigidBody::Dynamic, KINEMATIC, KINEMATIC_BY_VELOCITY] {
        assert_eq!(triangles_of(body), None);
    }
}

#[test]
fn a_sensor_gets_hulls_whatever_its_body() {
    assert_eq!(triangles_of((FIXED, Sensor)), None);
    assert_eq!(triangles_of(Sensor), None);
}

#[test]
fn a_tag_may_ask_for_either() {
    let shaped = |shape| automatic().with_shape(shape);
    assert_eq!(triangles_by(shaped(DecompositionShape::Hulls), FIXED), None);
    let asked = triangles_by(shaped(DecompositionShape::Triangles), RigidBody::Dynamic);
    assert_eq!(asked, Some(SkipReason::TrianglesRequested));
}

#[test]
fn the_settings_may_want_hulls_everywhere() {
    let settings = HullwrightSettings { exact_static_colliders: false, ..default() };
    let (mut app, entity) = finished_with(settings, model("u_prism"), automatic());
    let mesh = add(&mut app, model("l_prism"));
    let fixed = finish(&mut app, &mesh, (automatic(), FIXED));
    assert_eq!([entity, fixed].map(|entity| reason(&app, entity)), [None; 2]);
}

#[test]
fn bodies_and_sensors_that_come_and_go_change_it() {
    let (mut app, mesh) = with_mesh(app(), model("u_prism"));
    let above = app.put(Transform::default());
    let entity = finish(&mut app, &mesh, (automatic(), ChildOf(above)));
    let mut expect = |changed, change: fn(&mut EntityWorldMut), expected| {
        change(&mut app.edit(changed));
        update_until(&mut app, |app| {
            status(app, entity).is_finished()
                && shape(collider(app, entity)).as_trimesh().is_some() == expected
        });
        assert!(expected || has_mass(&app, entity));
    };
    expect(above, |_| {}, true);
    expect(above, |body| _ = body.insert(RigidBody::Dynamic), false);
    expect(above, |body| _ = body.insert(FIXED), true);
    expect(entity, |collider| _ = collider.insert(Sensor), false);
    expect(entity, |collider| _ = collider.remove::<Sensor>(), true);
    expect(above, |body| _ = body.insert(RigidBody::Dynamic), false);
    expect(above, |body| _ = body.remove::<RigidBody>(), true);
    expect(above, |body| _ = body.insert(RigidBody::Dynamic), false);
    expect(entity, |collider| _ = collider.remove::<ChildOf>(), true);
}

#[test]
fn internal_edges_are_fixed() {
    let (app, entity) = finished(unit_cube(), automatic());
    let flags = shape(collider(&app, entity)).as_trimesh().unwrap().flags();
    assert!(flags.contains(TriMeshFlags::FIX_INTERNAL_EDGES));
}

/// A floor of small triangles at height 0, wound one way or the other.
pub fn floor(is_turned: bool) -> Mesh {
    const SIDE: u32 = 20;
    let positions = (0..SIDE * SIDE)
        .map(|i| [(i % SIDE) as f32 * 0.5 - 2.0, 0.0, (i / SIDE) as f32 * 0.5 - 5.0]);
    let squares = (0..SIDE - 1).flat_map(|z| (0..SIDE - 1).map(move |x| z * SIDE + x));
    let triangles = squares.flat_map(|a| {
        let (b, c, d) = (a + SIDE, a + 1, a + SIDE + 1);
        if is_turned { [a, c, b, c, d, b] } else { [a, b, c, c, b, d] }
    });
    mesh(positions.collect(), triangles.collect())
}

#[test]
fn a_box_slides_over_a_floor_of_triangles_without_a_bump() {
    for is_turned in [false, true] {
        let (mut app, _) = finished(floor(is_turned), (automatic(), FIXED, friction(0.0)));
        let half = 0.2;
        let sliding = (
            RigidBody::Dynamic,
            cuboid_collider(half, half, half),
            friction(0.0),
            velocity(Vec3::X * 3.0, Vec3::ZERO),
            Transform::from_xyz(0.0, half, 0.0),
        );
        let body = app.put(sliding);
        for _ in 0..60 {
            app.update();
            let at = translation(&app, body);
            assert!((at.y - half).abs() < 0.02, "turned: {is_turned}, at {at}");
        }
        assert!((translation(&app, body).x - 3.0).abs() < 0.2);
    }
}

/// A comb: a back, and teeth of 0.1 with gaps of 0.1 between them.
fn comb() -> Mesh {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    let teeth = (0..6).map(|tooth| 0.2 * tooth as f32);
    let teeth = teeth.map(|x| ([x, 0.0, 0.0], [x + 0.1, 1.0, 0.2]));
    for (low, high) in std::iter::once(([0.0, -0.1, 0.0], [1.1, 0.0, 0.2])).chain(teeth) {
        let part = cuboid(low, high);
        let first = positions.len() as u32;
        let points = part.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
        positions.extend(points);
        indices.extend(part.indices().unwrap().iter().map(|index| first + index as u32));
    }
    mesh(positions, indices)
}

#[test]
fn gaps_that_nothing_can_enter_are_filled_by_settings_or_tag_in_metres_of_the_world() {
    let mut settings = HullwrightSettings { probe_radius: Some(0.5), ..default() };
    settings.scale_delay = Duration::ZERO;
    let (mut app, comb) = with_mesh(app_with(settings), comb());
    let by_settings = finish(&mut app, &comb, ());
    let by_tag = finish(&mut app, &comb, tag().with_probe_radius(0.01));
    let large = Transform::from_scale(Vec3::splat(100.0));
    let large = finish(&mut app, &comb, large);
    let count = |entity| hulls(&app, entity).len();
    assert_eq!(count(by_settings), 1);
    // Gaps of 0.1 let a ball of that radius in, and gaps of 10 m one of half a metre.
    assert!(count(by_tag) >= 7 && count(large) >= 7, "{} {}", count(by_tag), count(large));
    assert_eq!((counters(&app).decomposed, counters(&app).probed), (3, 3));
}
