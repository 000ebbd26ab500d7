//! What rolls or slides over the seams of a compound goes straight on. `docs/reliability.md` has
//! more floors, speeds and headings.

use hullwright_rapier::shape_from_points;
use rapier3d::prelude::*;

use crate::world::World;

const RADIUS: f32 = 0.1;

/// Tiles of a metre in one compound, their top at height 0.
fn tiles() -> SharedShape {
    let corners = |x: i8, z: i8| -> Vec<[f64; 3]> {
        let corner = |index: u8| {
            let [right, up, back] = [0, 1, 2].map(|axis| f64::from(index >> axis & 1));
            [f64::from(x) + right, 0.5 * (up - 1.0), f64::from(z) + back - 0.5]
        };
        (0..8).map(corner).collect()
    };
    let tiles: Vec<_> =
        (-1..10).flat_map(|x| (-1..10).map(move |z| (x, z))).map(|(x, z)| corners(x, z)).collect();
    shape_from_points(&tiles, [1.0; 3]).unwrap()
}

/// Degrees off the heading at the end, the highest hop in metres, and the speed that is left.
fn drift(floor: &SharedShape, body: ColliderBuilder, heading: f32, speed: f32) -> (f32, f32, f32) {
    let mut world = World::new(1.0).dispatched();
    world.fixed(ColliderBuilder::new(floor.clone()).friction(0.0));
    let angle = heading.to_radians();
    let forward = Vector::new(angle.cos(), 0.0, angle.sin());
    let start = RigidBodyBuilder::dynamic()
        .translation(Vector::new(0.37, RADIUS, 0.0))
        .rotation(-Vector::Y * angle)
        .linvel(forward * speed);
    let body = world.dynamic(start, body.friction(0.0));
    let mut hop = 0.0_f32;
    world.run_with((8.0 / speed).min(6.0), |world| hop = hop.max(world.place(body).y - RADIUS));
    let end = world.body(body).linvel();
    let level = Vector::new(end.x, 0.0, end.z);
    (level.angle_between(forward).to_degrees(), hop, level.dot(forward) / speed)
}

#[test]
fn balls_and_boxes_go_straight_over_tiles_of_one_compound() {
    let floor = tiles();
    for heading in [0.0, 1.0, 30.0, 45.0] {
        for speed in [0.5, 2.0, 10.0] {
            for body in
                [ColliderBuilder::ball(RADIUS), ColliderBuilder::cuboid(RADIUS, RADIUS, RADIUS)]
            {
                let (deflection, hop, left) = drift(&floor, body, heading, speed);
                let case = format!("heading {heading}°, {speed} m/s");
                assert!(deflection < 0.5, "{case}: deflected by {deflection}°");
                assert!(hop < 0.001, "{case}: a hop of {hop} m");
                assert!(left > 0.98, "{case}: {left} of the speed is left");
            }
        }
    }
}
