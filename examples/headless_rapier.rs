//! Loads a mesh, decomposes it, drops ten of it onto each other in Rapier, prints where they go:
//! `cargo run --ignore-rust-version --release --example headless_rapier [MESH]`.

use std::time::Instant;

use hullwright::{Control, Parameters, decompose, mass_properties};
use hullwright_formats::read_mesh;
use rapier3d::prelude::*;

/// kg per m³, if the mesh is in metres.
const DENSITY: f64 = 500.0;

const BODIES: usize = 10;

const SECONDS: usize = 6;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mug = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/mug.glb");
    let path = std::env::args().nth(1).unwrap_or_else(|| mug.into());
    let mesh = read_mesh(&path)?.mesh;

    let start = Instant::now();
    let parameters = Parameters::default();
    let decomposition = decompose(&mesh, &parameters, &Control::new())?;
    let hulls = &decomposition.hulls;
    let properties = mass_properties(&mesh, hulls, DENSITY)?;
    let seconds = start.elapsed().as_secs_f64();
    println!("{path}: {} triangles, {} hulls, {seconds:.2} s", mesh.triangles.len(), hulls.len());
    let report = &decomposition.report;
    let percent = |length: f64| 100.0 * length / decomposition.run.diagonal;
    let protrusion = percent(report.protrusion_max);
    let uncovered = percent(report.uncovered_max);
    println!("protrusion {protrusion:.2} %, uncovered {uncovered:.2} % of the diagonal at most");
    println!("mass {:.3} kg, from {:?}", properties.mass, properties.source);

    // One shape, shared by all bodies.
    let collider = hullwright_rapier::collider(hulls, &properties, [1.0; 3])?;

    let size = decomposition.run.diagonal as f32;
    let mut world = PhysicsWorld::new();
    // Small bodies cross their own size sooner: Rapier needs shorter steps.
    world.integration_parameters.length_unit = size;
    world.integration_parameters.dt *= size.sqrt().min(1.0);
    let floor = ColliderBuilder::cuboid(50.0 * size, size, 50.0 * size);
    world.insert_collider(floor.translation(Vector::new(0.0, -size, 0.0)), None);
    let bodies: Vec<RigidBodyHandle> = (0..BODIES)
        .map(|index| {
            let turn = index as f32;
            let at = Vector::new(0.3 * turn.cos(), 0.7 + turn, 0.3 * turn.sin()) * size;
            let body = RigidBodyBuilder::dynamic().translation(at).rotation(Vector::splat(turn));
            world.insert(body, collider.clone()).0
        })
        .collect();

    println!("\n  time   highest   fastest   asleep");
    let steps_per_second = (1.0 / world.integration_parameters.dt).round() as usize;
    let start = Instant::now();
    for second in 1..=SECONDS {
        for _ in 0..steps_per_second {
            world.step();
        }
        let all = || bodies.iter().map(|body| &world.bodies[*body]);
        let highest = all().map(|body| body.center_of_mass().y).fold(f32::MIN, f32::max);
        let fastest = all().map(|body| body.linvel().length()).fold(0.0, f32::max);
        let asleep = all().filter(|body| body.is_sleeping()).count();
        println!("{second:>4} s {highest:>7.3} m {fastest:>5.3} m/s {asleep:>8}");
    }
    let steps = SECONDS * steps_per_second;
    let milliseconds = 1000.0 * start.elapsed().as_secs_f64() / steps as f64;
    println!("\n{milliseconds:.3} ms for each of {steps} steps");
    Ok(())
}
