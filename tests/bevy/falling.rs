//! A tagged mesh becomes a body that falls and rests as its shape says.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::{DecompositionStatus, HullSource};

use crate::app::*;

fn floor(app: &mut App) {
    app.world_mut().spawn((Transform::from_xyz(0.0, -1.0, 0.0), Collider::cuboid(50.0, 1.0, 50.0)));
}

#[test]
fn a_tagged_mesh_gets_a_collider_and_falls_onto_the_floor() {
    let mut app = app();
    floor(&mut app);
    let u = add(&mut app, model("u_prism"));
    let body = app
        .world_mut()
        .spawn((Mesh3d(u), tag(), RigidBody::Dynamic, Transform::from_xyz(0.0, 3.0, 0.0)))
        .id();
    update_until_finished(&mut app, &[body]);
    assert_eq!(status(&app, body), DecompositionStatus::Ready(HullSource::Decomposed));
    let hulls = collider(&app, body).as_compound().expect("a compound").shapes().count();
    assert_eq!(hulls, 3);
    assert_eq!(ready(&app), [(body, 3)]);
    assert_eq!(counters(&app).convex, 0);

    update_times(&mut app, 300);
    let place = app.world().get::<Transform>(body).unwrap().translation;
    let (low, high) = bounds(&app, body);
    assert!(place.y < 1.0, "it still hangs at {place}");
    assert!(place.y > -(high - low).length(), "it fell through to {place}");
}

#[test]
fn mass_is_that_of_the_mesh_at_the_density_given() {
    let (app, body) = finished(cuboid([0.0; 3], [1.0, 2.0, 3.0]), RigidBody::Dynamic);
    let properties = mass(&app, body);
    assert!((properties.mass / (6.0 * DENSITY) - 1.0).abs() < 1e-3);
    assert_near(properties.local_center_of_mass, [0.5, 1.0, 1.5], 1e-3);
}

#[test]
fn a_convex_mesh_is_one_hull() {
    let (app, body) = finished(cuboid([-1.0; 3], [1.0; 3]), ());
    assert!(collider(&app, body).as_convex_polyhedron().is_some());
    assert_eq!(ready(&app), [(body, 1)]);
    assert_eq!(counters(&app).convex, 1);
    let (low, high) = bounds(&app, body);
    assert_near(low, [-1.0; 3], 1e-3);
    assert_near(high, [1.0; 3], 1e-3);
}
