//! A tagged mesh becomes a body that falls, touches and rests as its shape says, small things as
//! large ones.

use bevy::prelude::*;
use bevy_hullwright::{DecompositionStatus, HullSource};

use crate::app::*;
use crate::engine::*;

/// A marble of 8 mm comes to rest in a bowl of 15 cm.
#[test]
fn a_marble_stays_in_a_bowl() {
    let mut app = app();
    let floor = Transform::from_xyz(0.0, -0.5, 0.0);
    app.world_mut().spawn((floor, FIXED, cuboid_collider(5.0, 0.5, 5.0)));
    let bowl = add(&mut app, model("bowl"));
    let bowl = finish(&mut app, &bowl, RigidBody::Dynamic);
    update_times(&mut app, 120);

    let start = translation(&app, bowl) + Vec3::new(0.02, 0.05, 0.01);
    let marble = app.world_mut().spawn((
        Transform::from_translation(start),
        RigidBody::Dynamic,
        ball(0.008),
        density(2500.0),
    ));
    let marble = marble.id();
    update_times(&mut app, 300);
    let off = translation(&app, marble) - translation(&app, bowl);
    assert!(off.x.hypot(off.z) < 0.045, "{off}");
    // The inside is 10 to 12 mm above the ground there; Rapier lets things sink in by a millimetre.
    assert!((0.016..0.026).contains(&off.y), "{off}");
}

fn floor(app: &mut App) {
    let place = Transform::from_xyz(0.0, -1.0, 0.0);
    app.world_mut().spawn((place, FIXED, cuboid_collider(50.0, 1.0, 50.0)));
}

#[test]
fn a_tagged_mesh_gets_a_collider_and_falls_onto_the_floor() {
    let mut app = app();
    floor(&mut app);
    let u = add(&mut app, model("u_prism"));
    let body = app.put((Mesh3d(u), tag(), RigidBody::Dynamic, Transform::from_xyz(0.0, 3.0, 0.0)));
    update_until_finished(&mut app, &[body]);
    assert_eq!(status(&app, body), DecompositionStatus::Ready(HullSource::Decomposed));
    let hulls = shape(collider(&app, body)).as_compound().expect("a compound").shapes().len();
    assert_eq!(hulls, 3);
    assert_eq!(ready(&app), [(body, 3)]);
    assert_eq!(counters(&app).convex, 0);

    update_times(&mut app, 300);
    let place = app.get::<Transform>(body).unwrap().translation;
    let (low, high) = bounds(&app, body);
    assert!(place.y < 1.0, "it still hangs at {place}");
    assert!(place.y > -(high - low).length(), "it fell through to {place}");
}

#[test]
fn mass_is_that_of_the_mesh_at_the_density_given() {
    let (app, body) = finished(cuboid([0.0; 3], [1.0, 2.0, 3.0]), RigidBody::Dynamic);
    let properties = mass(&app, body);
    assert!((properties.mass / (6.0 * DENSITY) - 1.0).abs() < 1e-3);
    assert_near(properties.centre, [0.5, 1.0, 1.5], 1e-3);
}

#[test]
fn a_convex_mesh_is_one_hull() {
    let (app, body) = finished(cuboid([-1.0; 3], [1.0; 3]), ());
    assert!(shape(collider(&app, body)).as_convex_polyhedron().is_some());
    assert_eq!(ready(&app), [(body, 1)]);
    assert_eq!(counters(&app).convex, 1);
    assert_bounds(&app, body, [-1.0; 3], [1.0; 3], 1e-3);
}
