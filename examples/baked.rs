//! Bakes a mesh as `hullwright bake` does, then starts a Bevy app without a window in which a
//! hundred bodies take their colliders from the file, without any decomposition:
//! `cargo run --release --example baked --features io,bevy [MESH]`.

use std::time::Instant;

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;
use hullwright::hulls_format::HullsFile;
use hullwright::io::read_mesh;
use hullwright::{Control, Parameters, decompose, mass_properties};

const BODIES: usize = 100;

/// kg per m³, if the mesh is in metres.
const DENSITY: f64 = 500.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mug = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/mug.glb");
    let path = std::env::args().nth(1).unwrap_or_else(|| mug.into());

    // Once, when the game is built.
    let start = Instant::now();
    let mesh = read_mesh(&path)?;
    let decomposition = decompose(&mesh, &Parameters::default(), &Control::new())?;
    let mass = mass_properties(&mesh, &decomposition.hulls, DENSITY)?;
    let directory = std::env::temp_dir().join("hullwright-baked-example");
    std::fs::create_dir_all(&directory)?;
    let file = HullsFile::new("example", &decomposition).with_mass_properties(mass);
    file.write(directory.join("example.hulls"))?;
    let seconds = start.elapsed().as_secs_f64();
    println!("baked {path}: {} hulls, {seconds:.3} s", file.hulls.len());

    // Whenever the game starts.
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin { file_path: directory.display().to_string(), ..default() },
        TransformPlugin,
        RapierPhysicsPlugin::<NoUserData>::default(),
        HullwrightPlugin::default(),
    ));
    app.finish();
    app.cleanup();
    let start = Instant::now();
    let hulls = app.world().resource::<AssetServer>().load("example.hulls");
    for index in 0..BODIES {
        app.world_mut().spawn((
            BakedDecomposition::new(hulls.clone()),
            RigidBody::Dynamic,
            Transform::from_xyz(index as f32, 0.0, 0.0),
        ));
    }
    let mut frames = 0;
    loop {
        app.update();
        frames += 1;
        let world = app.world_mut();
        let mut statuses = world.query::<&DecompositionStatus>();
        if statuses.iter(world).all(DecompositionStatus::is_finished) {
            break;
        }
    }
    let milliseconds = 1e3 * start.elapsed().as_secs_f64();
    let counters = app.world().resource::<DecompositionCounters>();
    println!(
        "{} of {BODIES} bodies have their colliders after {milliseconds:.1} ms and {frames} \
         frames; {} decompositions, {} failures",
        counters.baked + counters.shared,
        counters.decomposed,
        counters.failed
    );
    Ok(())
}
