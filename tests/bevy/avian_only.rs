//! What only Avian needs: its colliders belong to a body, and it scales them by itself.

use avian3d::prelude::*;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::has_mass;

#[test]
fn one_line_says_that_nothing_bumps_into_a_collider_without_a_body() {
    Log::install();
    let mut app = app();
    let mesh = add(&mut app, unit_cube());
    let lone = app.put((Mesh3d(mesh.clone()), tag(), Name::new("lone wall")));
    let other = app.put((Mesh3d(mesh), tag(), Name::new("another lone wall")));
    update_until_finished(&mut app, &[lone, other]);
    let lines = Log::lines_with("no RigidBody");
    let of_these: Vec<_> = lines.iter().filter(|line| line.contains("lone wall")).collect();
    assert_eq!(of_these.len(), 1, "{of_these:?}");
}

/// Parry multiplies normals by the scale, as Avian has it do.
#[test]
fn a_stretched_collider_has_normals_at_right_angles_to_its_faces_in_avian() {
    let mut app = app();
    let mesh = add(&mut app, model("torus"));
    let stretched = Transform::from_scale(Vec3::new(1.0, 4.0, 2.0));
    let body = app.put((Mesh3d(mesh), tag(), RigidBody::Dynamic, stretched));
    update_until_finished(&mut app, &[body]);
    update_times(&mut app, 3);
    assert_eq!(app.get::<Collider>(body).unwrap().scale(), stretched.scale);
    assert_faces_are_right(&app, body);
}

/// Avian would place it where its place was before.
#[test]
fn what_moves_while_it_has_no_collider_stays_where_it_is_when_it_has_one() {
    let mut app = app();
    let mesh = add(&mut app, unit_cube());
    let above = app.put((Transform::default(), RigidBody::Static));
    let child = spawn_with(&mut app, &mesh, ChildOf(above));
    update_until_finished(&mut app, &[child]);
    update_times(&mut app, 2);
    app.edit(child).remove::<(Mesh3d, Collider)>();
    update_times(&mut app, 2);
    let there = Transform::from_xyz(3.0, 0.0, 0.0);
    app.edit(child).insert((there, Mesh3d(mesh)));
    update_until(&mut app, |app| has_collider(app, child));
    update_times(&mut app, 3);
    assert_eq!(app.get::<Transform>(child), Some(&there));
}

#[test]
fn many_of_one_kind_and_scale_share_one_scaled_shape() {
    let mut app = app();
    let mesh = add(&mut app, model("u_prism"));
    let two = Transform::from_scale(Vec3::splat(2.0));
    let bodies = [0; 3].map(|_| spawn_with(&mut app, &mesh, (RigidBody::Static, two)));
    update_until_finished(&mut app, &bodies);
    update_times(&mut app, 2);
    let [a, b, c] = bodies.map(|body| app.get::<Collider>(body).unwrap().shape_scaled().clone());
    assert!(std::sync::Arc::ptr_eq(&a.0, &b.0) && std::sync::Arc::ptr_eq(&b.0, &c.0));
}

#[test]
fn avian_does_not_warn_of_bodies_that_wait_and_what_gets_no_collider_has_no_mass() {
    Log::install();
    let mut app = app();
    let never = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let body = spawn_with(&mut app, &never, RigidBody::Dynamic);
    let above = app.put((RigidBody::Dynamic, Transform::default()));
    let below = spawn_with(&mut app, &never, ChildOf(above));
    update_times(&mut app, 5);
    for of in [body, above] {
        let line = format!("rigid body {of:?} has no mass");
        assert!(Log::lines_with(&line).is_empty(), "{line}");
    }
    for tagged in [body, below] {
        app.edit(tagged).remove::<ConvexDecomposition>();
    }
    update_times(&mut app, 3);
    for of in [body, above] {
        assert!(!has_mass(&app, of));
    }
}
