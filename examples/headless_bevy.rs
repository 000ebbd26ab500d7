//! Tags meshes in a Bevy app without a window, waits for their colliders while frames go on, lets
//! them fall, prints a table:
//! `cargo run --ignore-rust-version --release --example headless_bevy [MESH…]`, with
//! `--features avian` in Avian.

mod headless;
#[path = "headless/mass.rs"]
mod mass;

use std::path::Path;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use headless::physics::{self, RigidBody};
use headless::{bundled, is_finished, load};

const MODELS: [&str; 8] = ["mug", "chair", "teapot", "lamp", "bowl", "dog", "torus", "gear"];

/// All bodies are scaled to this diagonal, in metres.
const SIZE: f32 = 1.0;

/// kg per m³.
const DENSITY: f32 = 500.0;

const SECONDS: usize = 6;

/// What the table says of a body.
#[derive(Component)]
struct Row {
    triangles: usize,
    frame: usize,
    hulls: usize,
}

/// Frames so far.
#[derive(Resource, Default)]
struct Frames(usize);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut app = headless::app();
    app.init_resource::<Frames>().add_observer(on_ready).add_observer(on_failed);

    app.world_mut().spawn(physics::fixed_box(Vec3::NEG_Y, Vec3::new(100.0, 1.0, 100.0)));
    let given: Vec<String> = std::env::args().skip(1).collect();
    let paths = if given.is_empty() { MODELS.map(bundled).to_vec() } else { given };
    for (index, path) in paths.iter().enumerate() {
        let at = Vec3::new(2.0 * SIZE * index as f32, 1.5 * SIZE, 0.0);
        spawn(&mut app, path, at)?;
    }

    // A game would just go on; here each frame is timed, and those without work are skipped.
    let start = Instant::now();
    let mut longest = Duration::ZERO;
    while !is_finished(&mut app) {
        let frame = Instant::now();
        app.world_mut().resource_mut::<Frames>().0 += 1;
        app.update();
        longest = longest.max(frame.elapsed());
        std::thread::sleep(Duration::from_millis(1));
    }
    let frames = app.world().resource::<Frames>().0;
    let seconds = start.elapsed().as_secs_f64();
    let milliseconds = 1000.0 * longest.as_secs_f64();
    println!(
        "all ready after {seconds:.2} s and {frames} frames, the longest {milliseconds:.1} ms"
    );

    for _ in 0..SECONDS * 60 {
        app.update();
    }
    print_table(&mut app);
    Ok(())
}

fn spawn(app: &mut App, path: &str, at: Vec3) -> Result<(), Box<dyn std::error::Error>> {
    let model = load(app, path)?;
    let name = Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    app.world_mut().spawn((
        Name::new(name),
        Mesh3d(model.mesh),
        RigidBody::Dynamic,
        ConvexDecomposition::default().with_density(DENSITY),
        Transform::from_translation(at).with_scale(Vec3::splat(SIZE / model.diagonal)),
        mass::with_mass(),
        Row { triangles: model.triangles, frame: 0, hulls: 0 },
    ));
    Ok(())
}

fn on_ready(event: On<DecompositionReady>, frames: Res<Frames>, mut rows: Query<&mut Row>) {
    if let Ok(mut row) = rows.get_mut(event.entity) {
        (row.frame, row.hulls) = (frames.0, event.hulls);
    }
}

fn on_failed(event: On<DecompositionFailed>, names: Query<&Name>) {
    let name = names.get(event.entity).map_or("a mesh", Name::as_str);
    println!("{name} has no collider: {}", event.error);
}

fn print_table(app: &mut App) {
    println!("\nbody       triangles  hulls  ready in frame     mass  rests at  turned by");
    let world = app.world_mut();
    let mut bodies = world.query::<(&Name, &Row, mass::MassOfBody, &Transform)>();
    for (name, row, of_body, place) in bodies.iter(world) {
        let Row { triangles, frame, hulls } = row;
        let (mass, centre) = mass::mass(of_body);
        let centre = place.rotation * centre + place.translation;
        let turned = place.up().angle_between(Vec3::Y).to_degrees();
        println!(
            "{name:<10} {triangles:>9} {hulls:>6} {frame:>15} {mass:>7.1} kg {:>7.3} m {turned:>8.1}°",
            centre.y
        );
    }
}
