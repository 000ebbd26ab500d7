//! Concave things do what only concave things can, and what modellers leave open is solid or not as
//! a player expects.

use rapier3d::prelude::*;

use crate::common::comb;
use crate::world::{Prop, World};

#[test]
fn a_ball_falls_through_a_torus_but_not_a_larger_one_and_none_through_its_ring() {
    // The hole is 0.44 m wide, the ring 0.26 m thick.
    let torus = Prop::model("torus");
    for (radius, falls) in [(0.19, true), (0.25, false)] {
        let mut world = World::new(1.0);
        world.fixed(torus.collider());
        let ball = world.dynamic_at([0.005, 0.6, 0.0], ColliderBuilder::ball(radius));
        world.run(3.0);
        assert_eq!(world.place(ball).y < -2.0, falls, "a ball of {radius} m");
    }

    let mut world = World::new(1.0);
    world.fixed(torus.collider());
    let radius = 0.05;
    let balls: Vec<_> = (0..8_u8)
        .map(|index| {
            let angle = f32::from(index) * std::f32::consts::FRAC_PI_4;
            let at = [0.34 * angle.cos(), 0.6, 0.34 * angle.sin()];
            world.dynamic_at(at, ColliderBuilder::ball(radius))
        })
        .collect();
    let mut nearest = f32::INFINITY;
    world.run_with(3.0, |world| {
        for ball in &balls {
            let place = world.place(*ball);
            let to_ring = place.x.hypot(place.z) - 0.35;
            nearest = nearest.min(to_ring.hypot(place.y - 0.13));
        }
    });
    // Rapier lets balls sink in by a millimetre or two when they land.
    assert!(nearest > 0.13 + radius - 0.01, "{nearest}");
    assert!(nearest < 0.13 + radius + 0.03, "never touched: {nearest}");
}

#[test]
fn a_mug_hangs_by_its_handle_on_a_hook() {
    let mug = Prop::model("mug");
    // The handle's opening ends 7 mm before its outside.
    let outside = mug.mesh.positions.iter().map(|p| p[0]).fold(f64::NEG_INFINITY, f64::max) as f32;
    let hook = Vector::new(outside - 0.012, 0.066, 0.0);
    let mut world = World::new(0.1);
    world.fixed(ColliderBuilder::capsule_z(0.05, 0.003).translation(hook));
    for end in [-1.0, 1.0] {
        let stop = Vector::new(hook.x, hook.y, 0.06 * end);
        world.fixed(ColliderBuilder::ball(0.02).translation(stop));
    }
    let body = RigidBodyBuilder::dynamic().angular_damping(4.0).linear_damping(1.0);
    let hung = world.dynamic(body, mug.collider());
    world.run(4.0);
    let (mut off, mut steps) = (Vector::ZERO, 0.0);
    world.run_with(2.0, |world| {
        let body = world.body(hung);
        let in_mug = body.position().inverse_transform_point(hook);
        assert!((0.0..outside).contains(&in_mug.x), "the hook left the handle: {in_mug}");
        assert!((0.01..0.09).contains(&in_mug.y), "the hook left the handle: {in_mug}");
        off += body.center_of_mass() - hook;
        steps += 1.0;
    });
    // It hangs with its weight below the hook.
    let off = off / steps;
    assert!(off.y < -0.02, "{off}");
    assert!(off.x.abs() < 0.01, "{off}");
}

/// A ball that falls into the bundled bowl, both as many times as large, ends on its bottom.
fn assert_a_ball_stays_in_a_bowl(scale: f32, seconds: f32, mut world: World) {
    let bowl = Prop::model("bowl");
    let bowl_body = world.dynamic_at([0.0, 0.001 * scale, 0.0], bowl.scaled_collider([scale; 3]));
    let radius = 0.008;
    let ball = world.dynamic_at(
        [0.05, 0.09, 0.01].map(|x: f32| scale * x),
        ColliderBuilder::ball(scale * radius).density(2500.0).friction(0.3),
    );
    world.run(seconds);
    let (in_bowl, bowl_at) = (world.place(ball), world.place(bowl_body));
    let off = (in_bowl - bowl_at) / scale;
    assert!(off.x.hypot(off.z) < 0.045, "{off}");
    // The inside is 10 to 12 mm above the ground there.
    assert!((0.008..0.018).contains(&(off.y - radius)), "{off}");
    assert!(world.tilt(bowl_body, Vector::Y) < 2.0);
}

/// With Rapier's own contacts it sinks in: Parry's tolerances are lengths.
#[test]
fn a_marble_stays_in_a_bowl() {
    assert_a_ball_stays_in_a_bowl(1.0, 5.0, World::with_floor(0.1).dispatched());
}

#[test]
fn a_ball_stays_in_a_large_bowl() {
    assert_a_ball_stays_in_a_bowl(4.0, 10.0, World::with_floor(0.1));
    assert_a_ball_stays_in_a_bowl(4.0, 10.0, World::with_floor(0.1).dispatched());
}

#[test]
fn a_box_slides_over_the_seams_of_a_decomposed_floor() {
    // Its top is at height 0. No two of its tines fit into one hull.
    let (mut positions, triangles) = comb(10, 3.0, 0.5);
    positions.iter_mut().for_each(|[_, y, z]| (*y, *z) = (-*z, *y));
    let floor = Prop::mesh((positions, triangles));
    assert!(floor.decomposition.hulls.len() >= 5, "a floor with seams");
    let slide = |collider: ColliderBuilder| {
        let mut world = World::new(1.0);
        world.fixed(collider.friction(0.3));
        let body = RigidBodyBuilder::dynamic()
            .translation(Vector::new(1.0, 0.25, 0.5))
            .linvel(Vector::new(5.0, 0.0, 0.0));
        let cube = ColliderBuilder::cuboid(0.25, 0.25, 0.25).friction(0.3).density(1000.0);
        let cube = world.dynamic(body, cube);
        let (mut highest, mut spin) = (0.0_f32, 0.0_f32);
        world.run_with(2.5, |world| {
            highest = highest.max(world.place(cube).y);
            spin = spin.max(world.body(cube).angvel().length());
        });
        (world.place(cube), highest, spin)
    };
    let plain = ColliderBuilder::cuboid(10.0, 0.5, 10.0).translation(Vector::new(0.0, -0.5, 0.0));
    let (expected, ..) = slide(plain);
    let (found, highest, spin) = slide(floor.collider());
    assert!(expected.x > 4.0);
    assert!((found - expected).length() < 0.1, "{found}, not {expected}");
    assert!(highest < 0.26, "it hopped to {highest}");
    assert!(spin < 0.2, "it stumbled: {spin}");
}

#[test]
fn a_fast_ball_does_not_end_inside_a_solid() {
    let dog = Prop::model("dog");
    let mut world = World::new(1.0);
    world.0.gravity = Vector::ZERO;
    let target = world.fixed(dog.collider());
    let middle = world.0.colliders[target].compute_aabb().center();
    let balls: Vec<_> = (0..24_u8)
        .map(|index| {
            let angle = f32::from(index) * std::f32::consts::TAU / 24.0;
            let out = Vector::new(angle.cos(), (3.0 * angle).sin() / 2.0, angle.sin());
            let body = RigidBodyBuilder::dynamic()
                .translation(middle + 3.0 * out)
                .linvel(-300.0 * out)
                .ccd_enabled(true);
            // Balls pass through each other.
            let groups = InteractionGroups::new(
                Group::GROUP_1,
                Group::ALL ^ Group::GROUP_1,
                InteractionTestMode::And,
            );
            world.dynamic(body, ColliderBuilder::ball(0.02).collision_groups(groups))
        })
        .collect();
    let mut hits = 0;
    world.run(0.5);
    let solid = &world.0.colliders[target];
    for ball in &balls {
        // Rapier may let a ball at this speed sink in for a step, but out it must come again.
        let place = world.place(*ball);
        assert!(!solid.shape().contains_point(solid.position(), place), "{place}");
        // A ball that missed is far away by now.
        hits += usize::from(world.place(*ball).length() < 100.0);
    }
    assert!(hits >= 12, "{hits} hits");
}

/// A box without the side at its top (`true`) or bottom, drawn from outside, or from inside.
fn open_box(is_open_above: bool, is_lined: bool) -> Prop {
    let corners = |i: usize| [(i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64];
    let positions: Vec<[f64; 3]> = (0..8).map(corners).collect();
    let mut quads = vec![[0, 4, 6, 2], [1, 3, 7, 5], [0, 2, 3, 1], [4, 5, 7, 6]];
    quads.push(if is_open_above { [0, 1, 5, 4] } else { [2, 6, 7, 3] });
    if is_lined {
        quads.iter_mut().for_each(|quad| quad.reverse());
    }
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Prop::mesh((positions, triangles.collect()))
}

#[test]
fn a_ball_lies_on_the_missing_side_of_a_crate_and_falls_into_a_bin_that_is_seen_from_within() {
    let radius = 0.1;
    for (is_open_above, is_lined, height) in
        [(false, false, 1.0), (true, false, 1.0), (true, true, 0.0)]
    {
        let mut world = World::new(1.0);
        world.fixed(open_box(is_open_above, is_lined).collider());
        let ball = world.dynamic_at([0.52, 2.0, 0.49], ColliderBuilder::ball(radius));
        world.run(3.0);
        let end = world.place(ball).y - radius;
        let tolerance = if is_lined { 0.05 } else { 0.01 };
        assert!((end - height).abs() < tolerance, "{is_open_above} {is_lined}: {end}");
    }
}
