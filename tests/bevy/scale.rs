//! Scale is baked into the points, once, however it comes about.

use std::time::Duration;

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_hullwright::{HullSource, WaitReason};

use crate::app::*;
use crate::engine::*;

fn at_once() -> HullwrightSettings {
    HullwrightSettings { scale_delay: Duration::ZERO, ..default() }
}

#[test]
fn a_scaled_entity_has_scaled_points_and_mass_and_is_not_scaled_again() {
    let (mut app, mesh) = with_mesh(app(), unit_cube());
    let transform = Transform::from_scale(Vec3::new(2.0, 3.0, 4.0))
        .with_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 1.1, -0.7));
    let entity = spawn_with(&mut app, &mesh, (RigidBody::Dynamic, transform));
    update_until_finished(&mut app, &[entity]);
    update_times(&mut app, 3);
    let (low, high) = bounds(&app, entity);
    assert_near(low, [0.0; 3], 1e-3);
    assert_near(high, [2.0, 3.0, 4.0], 4e-3);
    let mass = mass(&app, entity);
    assert!((mass.mass / (24.0 * DENSITY) - 1.0).abs() < 2e-3);
    assert_near(mass.centre, [1.0, 1.5, 2.0], 5e-3);
    // About its centre a box of these sides has a twelfth of mass times the other sides' squares.
    let mut moments = (mass.moments / (24.0 * DENSITY / 12.0)).to_array();
    moments.sort_by(f32::total_cmp);
    assert_near(moments.into(), [13.0, 20.0, 25.0], 0.1);
}

#[test]
fn a_mirrored_entity_has_mirrored_points() {
    let (mut app, mesh) = with_mesh(app(), cuboid([0.0; 3], [1.0, 2.0, 3.0]));
    for scale in [[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, -1.0, -1.0], [-1.0, 1.0, -2.0]] {
        let transform =
            Transform::from_scale(scale.into()).with_rotation(Quat::from_rotation_y(1.0));
        let entity = finish(&mut app, &mesh, transform);
        app.update();
        // Where the engine puts the collider, its points lie where the mesh is drawn.
        let pose = app.get::<GlobalTransform>(entity).unwrap().compute_transform();
        let drawn = [Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)].map(|p| transform.transform_point(p));
        let (low, high) = bounds(&app, entity);
        let centre = pose.rotation * ((low + high) / 2.0) + pose.translation;
        assert_near(centre, (drawn[0] + drawn[1]) / 2.0, 1e-2);
        assert_near(high - low, Vec3::new(1.0, 2.0, 3.0) * Vec3::from(scale).abs(), 1e-2);
    }
}

#[test]
fn a_turned_child_below_a_stretched_body_lies_where_it_is_drawn() {
    let (mut app, mesh) = with_mesh(app(), unit_cube());
    let of_body = Transform::from_xyz(1.0, 2.0, 3.0)
        .with_rotation(Quat::from_rotation_x(0.4))
        .with_scale(Vec3::new(3.0, 1.0, 1.0));
    let of_child = Transform::from_xyz(0.5, 0.0, 0.0).with_rotation(Quat::from_rotation_z(0.7));
    let body = app.put((FIXED, of_body));
    let child = spawn_with(&mut app, &mesh, (of_child, ChildOf(body)));
    app.world_mut().resource_mut::<HullwrightSettings>().exact_static_colliders = false;
    update_until_finished(&mut app, &[child]);
    update_times(&mut app, 2);

    let drawn = app.get::<GlobalTransform>(child).unwrap().affine();
    let corners: Vec<Vec3> = (0..8)
        .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32))
        .map(|corner| drawn.transform_point3(corner))
        .collect();
    let (place, shape) = in_engine(&mut app, child);
    let hull = shape.as_convex_polyhedron().expect("one hull");
    assert_eq!(hull.points().len(), 8);
    for point in hull.points() {
        let found = place.transform_point3(*point);
        let nearest = corners.iter().map(|corner| corner.distance(found)).fold(9.0, f32::min);
        assert!(nearest < 5e-3, "{found} is no corner: {nearest} away");
    }
}

#[test]
fn a_changed_scale_bakes_the_points_anew_without_a_new_decomposition() {
    let (mut app, entity) = finished_with(at_once(), model("u_prism"), ());
    let (low, high) = bounds(&app, entity);
    let scale = Vec3::new(2.0, 1.0, 0.5);
    set_scale(&mut app, entity, scale);
    update_until_ready_times(&mut app, 2);
    let (new_low, new_high) = bounds(&app, entity);
    assert_near(new_low, low * scale, 1e-2);
    assert_near(new_high, high * scale, 1e-2);
    assert_eq!(counters(&app).decomposed, 1);
}

#[test]
fn a_scale_that_keeps_changing_is_baked_once_it_rests() {
    let mut app =
        app_with(HullwrightSettings { scale_delay: Duration::from_millis(40), ..default() });
    let mesh = add(&mut app, unit_cube());
    let entity = finish(&mut app, &mesh, ());
    for step in 0..10 {
        app.change::<Transform>(entity).scale = Vec3::splat(1.0 + step as f32);
        app.update();
    }
    update_until(&mut app, |app| (bounds(app, entity).1 - Vec3::splat(10.0)).length() < 0.05);
    assert!(ready(&app).len() <= 4);
}

#[test]
fn a_moved_and_turned_entity_keeps_its_collider() {
    let transform = Transform::from_scale(Vec3::new(0.3, 7.0, 1.7));
    let (mut app, entity) = finished_with(at_once(), unit_cube(), transform);
    for step in 0..50 {
        let mut transform = app.change::<Transform>(entity);
        transform.rotate_local_x(0.37);
        transform.rotate_y(0.11);
        transform.translation = Vec3::splat(100.0 * step as f32);
        app.update();
    }
    update_times(&mut app, 3);
    assert_eq!(ready(&app).len(), 1);
}

/// Deeper than the notch of the bundled U, but not of one eight times the size.
const BOUND: f32 = 1.5;

#[test]
fn a_bound_in_metres_is_kept_in_metres() {
    // A bound so large that one hull keeps it, until the body grows.
    let tag = tag().with_max_error(MaxError::Metres(BOUND));
    let (mut app, small) = finished_with(at_once(), model("u_prism"), tag);
    let hulls = |app: &App| ready(app).last().unwrap().1;
    assert_eq!(hulls(&app), 1);
    set_scale(&mut app, small, Vec3::splat(8.0));
    update_until_ready_times(&mut app, 2);
    assert_eq!(counters(&app).decomposed, 2);
    assert!(hulls(&app) > 1);
}

#[test]
fn a_scale_that_changes_while_the_job_is_at_work_is_baked_in_the_end() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), unit_cube());
    let [running, queued] = [1.0, 3.0].map(|scale| {
        let transform = Transform::from_scale(Vec3::splat(scale));
        spawn_with(&mut app, &mesh, transform)
    });
    update_times(&mut app, 2);
    assert!(matches!(status(&app, running), DecompositionStatus::Running { .. }));
    assert_eq!(status(&app, queued), DecompositionStatus::Waiting(WaitReason::InQueue));
    for entity in [running, queued] {
        set_scale(&mut app, entity, Vec3::splat(2.0));
    }
    update_times(&mut app, 200);
    for entity in [running, queued] {
        assert!(is_ready(&app, entity));
        assert_near(bounds(&app, entity).1, [2.0; 3], 1e-2);
    }
    assert_eq!(counters(&app).decomposed, 1);
}

#[test]
fn a_scale_of_zero_fails_and_recovers() {
    let (mut app, mesh) = with_mesh(app_with(at_once()), unit_cube());
    let flat = Vec3::new(1.0, 0.0, 1.0);
    let of_scale = |scale| (Mesh3d(mesh.clone()), tag(), Transform::from_scale(scale));
    let flat_first = app.put(of_scale(flat));
    let flat_later = app.put(of_scale(Vec3::ONE));
    update_until_finished(&mut app, &[flat_first, flat_later]);
    assert!(matches!(status(&app, flat_first), DecompositionStatus::Failed(_)));
    assert!(is_ready(&app, flat_later));

    set_scale(&mut app, flat_first, Vec3::splat(2.0));
    set_scale(&mut app, flat_later, flat);
    update_until(&mut app, |app| {
        is_ready(app, flat_first)
            && matches!(status(app, flat_later), DecompositionStatus::Failed(_))
    });
    assert_near(bounds(&app, flat_first).1, [2.0; 3], 1e-2);

    set_scale(&mut app, flat_later, Vec3::ONE);
    update_until(&mut app, |app| is_ready(app, flat_later));
    assert_near(bounds(&app, flat_later).1, [1.0; 3], 1e-2);
}

#[test]
fn a_scale_that_grows_while_a_flat_job_is_at_work_recovers() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), unit_cube());
    let flat = Transform::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let entity = spawn_with(&mut app, &mesh, flat);
    update_times(&mut app, 2);
    set_scale(&mut app, entity, Vec3::ONE);
    update_times(&mut app, 200);
    assert!(is_ready(&app, entity));
}

/// As what pops in by a tween: without a body, fixed, as a primitive, with a bound in metres.
#[test]
fn what_begins_with_a_scale_of_zero_recovers_whatever_it_is_and_the_error_names_the_scale() {
    let (mut app, mesh) = with_mesh(app(), model("u_prism"));
    let nothing = Transform::from_scale(Vec3::ZERO);
    let all = [
        spawn_with(&mut app, &mesh, (automatic(), nothing)),
        match ALLOWS_SCALE_ZERO {
            true => spawn_with(&mut app, &mesh, (automatic(), FIXED, nothing)),
            false => spawn_with(&mut app, &mesh, (automatic(), nothing)),
        },
        spawn_with(&mut app, &mesh, (tag().with_shape(DecompositionShape::Cuboid), nothing)),
        spawn_with(&mut app, &mesh, (tag().with_shape(DecompositionShape::ConvexHull), nothing)),
        spawn_with(&mut app, &mesh, (tag().with_max_error(MaxError::Metres(0.02)), nothing)),
    ];
    update_until_finished(&mut app, &all);
    for entity in all {
        let DecompositionStatus::Failed(error) = status(&app, entity) else { panic!("no error") };
        assert!(error.to_string().contains("scale [0.0, 0.0, 0.0]"), "{error}");
    }
    for step in 1..=20 {
        for entity in all {
            set_scale(&mut app, entity, Vec3::splat(step as f32 / 20.0));
        }
        app.update();
    }
    update_until(&mut app, |app| {
        all.iter().all(|entity| status(app, *entity).has_collider() == Some(true))
    });
    std::thread::sleep(Duration::from_millis(120));
    update_times(&mut app, 3);
    update_until_finished(&mut app, &all);
    let (low, high) = bounds(&app, all[0]);
    for entity in &all[1..] {
        assert_bounds(&app, *entity, low, high, 0.1);
    }
}

#[test]
fn a_changed_scale_does_not_try_a_bad_mesh_again() {
    let (mut app, entity) = finished_with(at_once(), mesh(vec![[1.0; 3]; 3], vec![0, 1, 2]), ());
    set_scale(&mut app, entity, Vec3::splat(2.0));
    update_times(&mut app, 5);
    assert_eq!(failed(&app).len(), 1);
    assert_eq!(counters(&app).failed, 1);
}

#[test]
fn a_modified_mesh_is_decomposed_anew() {
    let (mut app, handle) = with_mesh(app(), unit_cube());
    let entity = finish(&mut app, &handle, ());
    let positions: Vec<[f32; 3]> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|x| 3.0 * x as f32)).collect();
    app.world_mut()
        .resource_mut::<Assets<Mesh>>()
        .get_mut(&handle)
        .unwrap()
        .insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    update_until_ready_times(&mut app, 2);
    assert_near(bounds(&app, entity).1, [3.0; 3], 1e-2);
    assert_eq!(counters(&app).decomposed, 2);
}

#[test]
fn another_mesh_in_its_place_is_decomposed() {
    let (mut app, small) = with_mesh(app(), unit_cube());
    let large = add(&mut app, cuboid([0.0; 3], [5.0; 3]));
    let entity = finish(&mut app, &small, ());
    app.edit(entity).insert(Mesh3d(large));
    update_until_ready_times(&mut app, 2);
    assert_near(bounds(&app, entity).1, [5.0; 3], 1e-2);
}

#[test]
fn mass_properties_that_were_there_stay() {
    let (app, entity) = finished(unit_cube(), games_mass(7.0));
    assert!(has_games_mass(&app, entity, 7.0));
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Decomposed));
}

#[test]
fn an_untagged_collider_follows_later_changes_of_scale() {
    let start = Transform::from_scale(Vec3::new(2.0, 1.0, -3.0));
    let (mut app, entity) = finished(unit_cube(), start);
    app.edit(entity).remove::<ConvexDecomposition>();
    update_times(&mut app, 2);
    let size = |app: &App| {
        let (low, high) = bounds(app, entity);
        high - low
    };
    assert_near(size(&app), [2.0, 1.0, 3.0], 1e-3);
    app.change::<Transform>(entity).scale *= 2.0;
    update_times(&mut app, 3);
    assert_near(size(&app), [4.0, 2.0, 6.0], 1e-3);
    // The tag takes it back.
    app.edit(entity).insert(tag());
    update_until_finished(&mut app, &[entity]);
    update_times(&mut app, 2);
    assert_near(size(&app), [4.0, 2.0, 6.0], 1e-3);
}

/// Each movement began the work anew, for as long as the collider of the old scale was there.
#[test]
fn a_body_whose_scale_changes_while_it_moves_gets_its_new_collider() {
    let body = (RigidBody::Dynamic, GravityScale(0.0), velocity(Vec3::X, Vec3::ZERO));
    // In metres of the world, so that another scale is another decomposition.
    let metres = tag().with_max_error(MaxError::Metres(0.02));
    let (mut app, entity) = finished_with(sliced(), model("u_prism"), (body, metres));
    let before = bounds(&app, entity);
    set_scale(&mut app, entity, Vec3::splat(2.0));
    update_times(&mut app, 2);
    let moves_at = translation(&app, entity);
    // The hulls that are there follow at once, and those of the new size come later.
    assert_near(bounds(&app, entity).1, before.1 * 2.0, 0.1);
    let mut frames = 0;
    while ready(&app).len() < 2 {
        app.update();
        frames += 1;
        assert!(frames < 200, "{:?}", status(&app, entity));
    }
    assert!(frames > 3, "it was ready at once");
    assert!(translation(&app, entity).x > moves_at.x, "it does not move");
    assert_near(bounds(&app, entity).1, before.1 * 2.0, 0.1);
    assert_eq!(counters(&app).decomposed, 2);
}
