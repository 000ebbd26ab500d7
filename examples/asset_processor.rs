//! Bevy's asset processor bakes a scene at build time: beside `level.glb` lies a recipe,
//! `level.hullrecipe`, a line of JSON. The first start makes the hulls and writes them to the
//! folder of processed assets; the second one loads them. No other line of the game differs from
//! one with a file of `hullwright bake`: `cargo run --ignore-rust-version --release --example
//! asset_processor --features bake [SCENE.glb]`.

use std::path::Path;
use std::time::{Duration, Instant};

use bevy::asset::AssetMode;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;

const RECIPE: &str = r#"{ "scene": "level.glb", "parameters": "max_error=1%" }"#;

/// The processor hangs rather than that it takes so long.
const PATIENCE: Duration = Duration::from_secs(120);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let props = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/props.glb");
    let scene = std::env::args().nth(1).unwrap_or_else(|| props.into());
    let project = std::env::temp_dir().join("hullwright-asset-processor-example");
    // As if it were built for the first time.
    if project.exists() {
        std::fs::remove_dir_all(&project)?;
    }
    std::fs::create_dir_all(project.join("assets"))?;
    std::fs::copy(scene, project.join("assets/level.glb"))?;
    std::fs::write(project.join("assets/level.hullrecipe"), RECIPE)?;
    for time in ["first", "second"] {
        let start = Instant::now();
        let scene = load(&project)?;
        let hulls: usize = scene.meshes.iter().map(|mesh| mesh.hulls.hulls.len()).sum();
        let seconds = start.elapsed().as_secs_f64();
        println!("{time} start: {} meshes, {hulls} hulls, {seconds:.3} s", scene.meshes.len());
    }
    Ok(())
}

/// Starts a game whose assets are processed, until its scene is loaded.
fn load(project: &Path) -> Result<hullwright::hulls_format::HullScene, String> {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin {
            mode: AssetMode::Processed,
            file_path: project.join("assets").display().to_string(),
            processed_file_path: project.join("imported_assets").display().to_string(),
            // Bevy's feature `asset_processor` does that elsewhere; a release leaves it out.
            use_asset_processor_override: Some(true),
            ..default()
        },
        TransformPlugin,
        RapierPhysicsPlugin::<NoUserData>::default(),
        HullwrightPlugin::default(),
    ));
    app.finish();
    app.cleanup();
    let handle: Handle<BakedScene> = app.world().resource::<AssetServer>().load("level.hullrecipe");
    let start = Instant::now();
    loop {
        app.update();
        let world = app.world();
        if let Some(baked) = world.resource::<Assets<BakedScene>>().get(&handle) {
            return Ok(baked.scene().clone());
        }
        let state = world.resource::<AssetServer>().load_state(&handle);
        if state.is_failed() || start.elapsed() > PATIENCE {
            return Err(format!("level.hullrecipe: {state:?}"));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}
