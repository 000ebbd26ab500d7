//! A plate with its weight far below rocks on a round peg, in plain Rapier: how fast, for half a minute. No energy is
//! added, so no swing may grow. `cargo run --package hullwright_lab --example rapier_hooks`.

use rapier3d::prelude::*;

/// Seconds of each figure, and how many there are.
const WINDOW: f32 = 5.0;
const WINDOWS: usize = 6;

/// A change of Rapier's parameters.
type Change = fn(&mut IntegrationParameters);

const CHANGES: [(&str, Change); 12] = [
    ("as it is", |_| {}),
    ("16 solver iterations", |with| with.num_solver_iterations = 16),
    ("no stabilization", |with| with.num_internal_stabilization_iterations = 0),
    ("no warm start", |with| with.warmstart_coefficient = 0.0),
    ("contacts of 10 Hz", |with| with.static_contact_softness.natural_frequency = 10.0),
    ("corrected at 0.1 m/s", |with| with.normalized_max_corrective_velocity = 0.1),
    ("0.5 mm of slop", |with| with.normalized_allowed_linear_error = 0.0005),
    ("Coulomb friction", |with| with.friction_model = FrictionModel::Coulomb),
    ("no CCD", |with| with.max_ccd_substeps = 0),
    ("240 steps in a second", |with| with.dt = 1.0 / 240.0),
    ("no recycled contacts", |with| with.contact_recycling = false),
    ("recycled for 1 mm", |with| with.normalized_contact_recycle_distance = 0.001),
];

fn main() {
    println!("greatest angular speed in each {WINDOW} s, in rad/s; 9.99 where it has left the peg");
    for damping in [0.0, 0.5, 1.5, 6.0] {
        println!("angular damping {damping}");
        for (name, change) in CHANGES {
            let speeds = swing(damping, change).map(|speed| format!("{speed:.2}"));
            println!("  {name:<22} {}", speeds.join("  "));
        }
    }
}

fn swing(damping: f32, change: Change) -> [f32; WINDOWS] {
    let mut world = PhysicsWorld::new();
    change(&mut world.integration_parameters);
    world.insert_collider(ColliderBuilder::capsule_z(1.0, 0.05).friction(0.6), None);
    let weight = MassProperties::new(Vector::new(0.0, -0.6, 0.0), 20.0, Vector::splat(2.0));
    let plate = RigidBodyBuilder::dynamic()
        .translation(Vector::new(0.02, 0.12, 0.0))
        .rotation(Vector::new(0.0, 0.0, 0.05))
        .additional_mass_properties(weight)
        .angular_damping(damping)
        .can_sleep(false);
    let shape = ColliderBuilder::cuboid(0.5, 0.06, 0.3).density(1.0).friction(0.6);
    let (plate, _) = world.insert(plate, shape);
    let steps = (WINDOW / world.integration_parameters.dt).round() as usize;
    [(); WINDOWS].map(|()| {
        let mut most = 0.0_f32;
        for _ in 0..steps {
            world.step();
            most = most.max(world.bodies[plate].angvel().length());
        }
        if world.bodies[plate].translation().length() > 1.0 { 9.99 } else { most }
    })
}
