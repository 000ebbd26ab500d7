//! Small things touch as large ones do.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;

use crate::app::*;

/// A marble of 8 mm comes to rest in a bowl of 15 cm.
#[test]
fn a_marble_stays_in_a_bowl() {
    let mut app = app();
    let floor = Transform::from_xyz(0.0, -0.5, 0.0);
    app.world_mut().spawn((floor, Collider::cuboid(5.0, 0.5, 5.0)));
    let bowl = add(&mut app, model("bowl"));
    let bowl = finish(&mut app, &bowl, RigidBody::Dynamic);
    update_times(&mut app, 120);

    let start = translation(&app, bowl) + Vec3::new(0.02, 0.05, 0.01);
    let marble = app.world_mut().spawn((
        Transform::from_translation(start),
        RigidBody::Dynamic,
        Collider::ball(0.008),
        ColliderMassProperties::Density(2500.0),
    ));
    let marble = marble.id();
    update_times(&mut app, 300);
    let off = translation(&app, marble) - translation(&app, bowl);
    assert!(off.x.hypot(off.z) < 0.045, "{off}");
    // The inside is 10 to 12 mm above the ground there; Rapier lets things sink in by a millimetre.
    assert!((0.016..0.026).contains(&off.y), "{off}");
}
