//! What hangs on a peg comes to rest. `crates/lab/reports/rapier-hooks.md` says why Rapier's
//! defaults keep it swinging.

use std::f32::consts::{PI, TAU};

use rapier3d::prelude::*;

use crate::world::{Prop, World};

/// How far bodies may move before their contacts are computed anew, in units of length: Rapier's
/// own 0.05 keeps contacts where they were while a body rocks, which feeds the swing.
const RECYCLED_FOR: f32 = 0.001;

/// As in air: a swing of two seconds loses two thirds of its speed.
const DAMPING: f32 = 1.5;

/// What moves less is at rest, in joules for each kilogram: a hundredth of what swings on keep.
const REST: f32 = 1e-3;

const PEG: f32 = 0.05;

/// A ring of bars around z, of an inner radius of half a metre. It starts with a bar's middle above
/// the centre.
fn ring(bars: usize) -> ColliderBuilder {
    let (radius, thickness, depth) = (0.5, 0.1, 0.3);
    let half = radius * (PI / bars as f32).tan();
    let bar = |bar: usize| {
        let turn = Rotation::from_rotation_z(PI / 2.0 + TAU * bar as f32 / bars as f32);
        let middle = turn * Vector::new(radius + thickness, 0.0, 0.0);
        (Pose::from_parts(middle, turn), SharedShape::cuboid(thickness, half, depth))
    };
    ColliderBuilder::compound((0..bars).map(bar).collect()).density(60.0)
}

/// One plate, whose weight hangs far below it: no compound.
fn plate() -> (RigidBodyBuilder, ColliderBuilder) {
    let weight = MassProperties::new(Vector::new(0.0, -0.6, 0.0), 20.0, Vector::splat(2.0));
    let body = RigidBodyBuilder::dynamic()
        .translation(Vector::new(0.02, 0.12, 0.0))
        .rotation(Vector::new(0.0, 0.0, 0.05))
        .additional_mass_properties(weight);
    (body, ColliderBuilder::cuboid(0.5, 0.06, 0.3).density(1.0))
}

/// The bundled mug, twelve times as large, its handle over the peg.
fn mug() -> (RigidBodyBuilder, ColliderBuilder) {
    let scale = 12.0;
    let mug = Prop::model("mug");
    let outside = mug.mesh.positions.iter().map(|p| p[0]).fold(f64::NEG_INFINITY, f64::max) as f32;
    let turn = Rotation::from_rotation_z(1.2);
    let hole = turn * Vector::new(outside - 0.015, 0.052, 0.0) * scale;
    let body = RigidBodyBuilder::dynamic().translation(-hole).rotation(turn.to_scaled_axis());
    (body, mug.scaled_collider([scale; 3]))
}

fn hung_off_centre() -> Vec<(&'static str, RigidBodyBuilder, ColliderBuilder)> {
    let beside = RigidBodyBuilder::dynamic().translation(Vector::new(0.03, -0.44, 0.0));
    let (plate, plate_shape) = plate();
    let (mug, mug_shape) = mug();
    vec![
        ("a plate", plate, plate_shape),
        ("a ring of four", beside.clone(), ring(4)),
        ("a ring of sixteen", beside, ring(16)),
        ("a mug", mug, mug_shape),
    ]
}

/// A peg along z between two stops.
fn world_with_peg() -> World {
    let mut world = World::new(1.0);
    world.0.integration_parameters.normalized_contact_recycle_distance = RECYCLED_FOR;
    world.fixed(ColliderBuilder::capsule_z(1.0, PEG).friction(0.6));
    for end in [-1.0, 1.0] {
        world.fixed(ColliderBuilder::ball(0.12).translation(Vector::new(0.0, 0.0, end)));
    }
    world
}

/// Energy of motion, in joules, for each kilogram.
fn energy(world: &World, body: RigidBodyHandle) -> f32 {
    let body = world.body(body);
    body.kinetic_energy() / body.mass()
}

#[test]
fn what_hangs_comes_to_rest_and_stays_there_with_either_dispatcher() {
    for world in [world_with_peg, || world_with_peg().dispatched()] {
        for (name, body, shape) in hung_off_centre() {
            let mut world = world();
            // Rapier lets a pendulum sleep askew.
            let body = body.angular_damping(DAMPING).linear_damping(0.1).can_sleep(false);
            let hung = world.dynamic(body, shape.friction(0.6));
            world.run(20.0);
            world.run_with(10.0, |world| {
                let energy = energy(world, hung);
                assert!(energy < REST, "{name} swings: {energy} J/kg");
            });
            assert!(world.place(hung).length() < 1.5, "{name} has left the peg");
        }
    }
}

#[test]
fn a_ring_that_is_hung_at_rest_stays_at_rest() {
    for bars in [4, 6, 16] {
        let mut world = world_with_peg().dispatched();
        let body = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, PEG - 0.5, 0.0));
        let hung = world.dynamic(body.can_sleep(false), ring(bars).friction(0.6));
        world.run_with(10.0, |world| {
            let energy = energy(world, hung);
            assert!(energy < REST, "a ring of {bars} swings: {energy} J/kg");
        });
        assert!(world.tilt(hung, Vector::Y) < 1.0);
    }
}
