//! Bodies come to rest where their shape says.

use rapier3d::prelude::*;

use crate::common::{Mesh, lathe, polygon};
use crate::world::{Prop, World};

#[test]
fn a_chair_stands_on_its_legs_and_leaves_room_below() {
    let chair = Prop::model("chair");
    let mut world = World::with_floor(1.0);
    let stands = world.dynamic_at([0.0, 0.02, 0.0], chair.collider());
    // Between the legs, which a hull of the whole chair would fill.
    let cat = world.dynamic_at([0.0, 0.1, 0.0], ColliderBuilder::cuboid(0.1, 0.1, 0.1));
    world.run(4.0);
    assert!(world.tilt(stands, Vector::Y) < 0.5);
    assert!(world.place(stands).length() < 0.01, "{}", world.place(stands));
    assert!(world.is_at_rest(stands));
    assert!((world.place(cat) - Vector::new(0.0, 0.1, 0.0)).length() < 0.005);
}

#[test]
fn nothing_falls_through_the_ground_in_half_a_minute() {
    let names = [
        "mug", "chair", "table", "teapot", "lamp", "bowl", "dog", "leaf", "torus", "gear",
        "spring", "l_prism", "u_prism", "plus",
    ];
    let mut world = World::new(0.5);
    // A ground of hulls too: a shallow dish, so that round things don't roll away.
    world.fixed(Prop::mesh(dish()).collider());
    let bodies: Vec<_> = names
        .iter()
        .enumerate()
        .map(|(index, name)| {
            let angle = index as f32 * 2.4;
            let radius = 0.45 * (index as f32).sqrt();
            let at = [radius * angle.cos(), 1.0 + 0.2 * index as f32, radius * angle.sin()];
            let tilt = Vector::new(0.5 * angle.sin(), 0.3, 0.8 * angle.cos());
            let body = RigidBodyBuilder::dynamic().translation(Vector::from(at)).rotation(tilt);
            world.dynamic(body, Prop::model(name).collider())
        })
        .collect();
    world.run(30.0);
    for (body, name) in bodies.iter().zip(names) {
        let place = world.place(*body);
        let low = world.body(*body).center_of_mass().y;
        assert!(place.is_finite() && low > -0.05, "{name} is at {place}");
        assert!(place.length() < 5.0, "{name} flew to {place}");
        assert!(world.body(*body).linvel().length() < 0.5, "{name} does not come to rest");
    }
}

#[test]
fn a_gear_stands_on_its_teeth_or_lies_on_its_hub() {
    let bound = 0.01;
    let gear = Prop::model_bounded("gear", bound);
    let tolerance = bound as f32 * 0.17 + 0.0005;
    let centre = Vector::from(gear.mass_properties().centre.map(|x| x as f32));

    // Standing: on one tooth's tip, or on the two beside a gap. Both are sides of the polygon
    // around the teeth, whose corners are at these shares of a tooth's angle. Locks keep it from
    // falling over. Rapier lets a body on two narrow feet rock for ever (a compound of two cuboids
    // does it too), so it is the mean that counts.
    let upright = LockedAxes::TRANSLATION_LOCKED_Z
        | LockedAxes::ROTATION_LOCKED_X
        | LockedAxes::ROTATION_LOCKED_Y;
    let tooth = std::f32::consts::TAU / 14.0;
    let [on_gap, on_tip] = [0.37, 0.13].map(|half_side| 0.06 * (half_side * tooth).cos());
    for turned in [0.0, 0.25, 0.5] {
        let mut world = World::with_floor(0.1);
        let turn = Rotation::from_rotation_z(turned * tooth);
        let lifted = Vector::new(0.0, 0.061, 0.0) - turn * centre;
        let body = RigidBodyBuilder::dynamic().pose(Pose::from_parts(lifted, turn));
        let stands = world.dynamic(body.locked_axes(upright), gear.collider());
        world.run(2.0);
        let (mut height, mut lowest, mut steps) = (0.0, 0.0, 0.0);
        world.run_with(2.0, |world| {
            height += world.body(stands).center_of_mass().y;
            lowest += gear.lowest(world.body(stands).position(), [1.0; 3]);
            steps += 1.0;
        });
        let (height, lowest) = (height / steps, lowest / steps);
        let expected = on_gap - tolerance..on_tip + tolerance;
        assert!(expected.contains(&height), "{turned}: {height} outside of {expected:?}");
        assert!(lowest.abs() < tolerance, "{turned}: {lowest}");
    }

    let mut world = World::with_floor(0.1);
    let lies = Rotation::from_rotation_x(std::f32::consts::FRAC_PI_2 + 0.2);
    let pose = Pose::from_parts(Vector::new(0.0, 0.05, 0.0) - lies * centre, lies);
    let lying = world.dynamic(RigidBodyBuilder::dynamic().pose(pose), gear.collider());
    // It rolls around on its rim for some seconds.
    world.run(8.0);
    assert!(world.is_at_rest(lying));
    let axle = world.body(lying).rotation() * Vector::Z;
    assert!(axle.y.abs() > 0.995, "{axle}");
    let height = world.body(lying).center_of_mass().y;
    assert!((height - 0.012).abs() < tolerance, "{height}");
}

#[test]
fn mirrored_and_stretched_bodies_rest_where_they_should() {
    for name in ["l_prism", "chair"] {
        let prop = Prop::model(name);
        for scale in [[-1.0, 1.0, 1.0], [0.5, 1.5, 2.0], [-2.0, 0.75, -0.5]] {
            let mut world = World::with_floor(1.0);
            let body = world.dynamic_at([3.0, 0.05, -2.0], prop.scaled_collider(scale));
            world.run(4.0);
            let place = world.place(body);
            assert!(world.is_at_rest(body), "{name} {scale:?}");
            assert!(world.tilt(body, Vector::Y) < 0.5, "{name} {scale:?}");
            assert!(
                (place - Vector::new(3.0, 0.0, -2.0)).length() < 0.02,
                "{name} {scale:?}: {place}"
            );
            let lowest = prop.lowest(world.body(body).position(), scale);
            assert!(lowest.abs() < 0.01, "{name} {scale:?}: {lowest}");

            // What it is made of lies where the scaled mesh lies.
            let collider = &world.0.colliders[world.body(body).colliders()[0]];
            let bounds = collider.shape().compute_local_aabb();
            for axis in 0..3 {
                let ends = |p: &[f64; 3]| p[axis] as f32 * scale[axis];
                let least = prop.mesh.positions.iter().map(ends).fold(f32::INFINITY, f32::min);
                let most = prop.mesh.positions.iter().map(ends).fold(f32::NEG_INFINITY, f32::max);
                assert!((bounds.mins[axis] - least).abs() < 0.03 * scale[axis].abs());
                assert!((bounds.maxs[axis] - most).abs() < 0.03 * scale[axis].abs());
            }
        }
    }
}

/// A round dish, 10 m wide, its middle at height 0 and its rim at 0.6 m, on a flat bottom.
fn dish() -> Mesh {
    // Radius and height, from the middle of the bottom over the rim to the middle of the top.
    let profile =
        polygon(&[0.0, -0.5, 5.5, -0.5, 5.5, 0.6, 5.0, 0.6, 4.0, 0.2, 2.0, 0.0, 0.0, 0.0]);
    let (mut positions, triangles) = lathe(&profile, 16);
    // From around z to around y.
    positions.iter_mut().for_each(|point| point.rotate_left(1));
    (positions, triangles)
}
