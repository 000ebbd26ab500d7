//! Bakes a scene as `hullwright bake` does, then starts a Bevy app without a window in which a
//! hundred bodies take their colliders from the file, without any decomposition:
//! `cargo run --ignore-rust-version --release --example baked [SCENE.glb]`.

use std::time::Instant;

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::Control;
use hullwright::hulls_format::HullScene;
use hullwright_formats::bake::{BakeOptions, bake_jobs};
use hullwright_formats::{read_scene, write_file};

const BODIES: usize = 100;

/// kg per m³, if the mesh is in metres.
const DENSITY: f32 = 500.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mug = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/mug.glb");
    let path = std::env::args().nth(1).unwrap_or_else(|| mug.into());

    // Once, when the game is built.
    let start = Instant::now();
    let jobs = bake_jobs(read_scene(&path)?, &BakeOptions::default());
    let meshes = jobs.iter().map(|job| job.run(&Control::new())).collect::<Result<Vec<_>, _>>()?;
    let name = meshes.first().and_then(|baked| baked.names.first()).cloned();
    let name = name.ok_or("there is no mesh in it")?;
    let directory = std::env::temp_dir().join("hullwright-baked-example");
    std::fs::create_dir_all(&directory)?;
    let scene = HullScene::new("example", meshes);
    write_file(directory.join("example.hullscene"), &scene.to_bytes()?)?;
    let seconds = start.elapsed().as_secs_f64();
    let hulls: usize = scene.meshes.iter().map(|baked| baked.hulls.hulls.len()).sum();
    println!("baked {path}: {} meshes, {hulls} hulls, {seconds:.3} s", scene.meshes.len());

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
    let scene = app.world().resource::<AssetServer>().load("example.hullscene");
    let baked = BakedDecomposition::new(scene).with_mesh(name).with_density(DENSITY);
    for index in 0..BODIES {
        app.world_mut().spawn((
            baked.clone(),
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
        counters.baked, counters.decomposed, counters.failed
    );
    Ok(())
}
