//! Hundreds of props of ten kinds rain into a Bevy app without a window, first unknown to the
//! plugin, then known; prints how long frames took:
//! `cargo run --ignore-rust-version --release --example stress [PROPS]`.

mod headless;

use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use headless::physics::{self, RigidBody};
use headless::{Model, bundled, is_finished, load};

const MODELS: [&str; 10] =
    ["mug", "table", "chair", "lamp", "bowl", "plus", "torus", "gear", "teapot", "dog"];

const PROPS: usize = 300;

/// Of the box that they fall into, in metres.
const WIDTH: usize = 10;

/// After all colliders are there.
const FRAMES_AFTER: usize = 300;

/// Upper ends of the histogram's bars, in milliseconds: 16.7 is a frame at 60 Hz.
const BARS: [f64; 7] = [1.0, 2.0, 4.0, 8.0, 16.7, 33.3, f64::INFINITY];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let props = std::env::args().nth(1).map_or(Ok(PROPS), |text| text.parse())?;
    let mut app = headless::app();
    walls(&mut app);
    let models = MODELS.map(|name| load(&mut app, bundled(name)));
    let models: Vec<Model> = models.into_iter().collect::<Result<_, _>>()?;
    let triangles: usize = models.iter().map(|model| model.triangles).sum();
    println!("{} kinds of props, {triangles} triangles", models.len());
    for (round, title) in ["unknown meshes", "known meshes"].into_iter().enumerate() {
        for index in 0..props {
            let Model { mesh, diagonal, .. } = &models[index % models.len()];
            let (x, z) = (index % WIDTH, index / WIDTH % WIDTH);
            let y = 1.0 + (index / (WIDTH * WIDTH) + 5 * round) as f32;
            let at = Vec3::new(x as f32 - 4.5, y, z as f32 - 4.5);
            app.world_mut().spawn((
                Mesh3d(mesh.clone()),
                RigidBody::Dynamic,
                ConvexDecomposition::default(),
                Transform::from_translation(at).with_scale(Vec3::splat(0.7 / diagonal)),
            ));
        }
        let mut waiting = Vec::new();
        while !is_finished(&mut app) {
            waiting.push(timed_frame(&mut app));
            // The rest of a frame, in which the game would draw.
            std::thread::sleep(Duration::from_millis(2));
        }
        let after = (0..FRAMES_AFTER).map(|_| timed_frame(&mut app)).collect();
        histogram(&format!("{props} props of {title}, until all are ready"), waiting);
        histogram("then", after);
    }
    let counters = app.world().resource::<DecompositionCounters>();
    println!("\n{} decompositions, {} shared", counters.decomposed, counters.shared);
    Ok(())
}

fn walls(app: &mut App) {
    let half = WIDTH as f32 / 2.0;
    let wall = |x: f32, y: f32, z: f32, size: [f32; 3]| {
        physics::fixed_box(Vec3::new(x, y, z), Vec3::from(size))
    };
    app.world_mut().spawn(wall(0.0, -1.0, 0.0, [2.0 * half, 1.0, 2.0 * half]));
    for side in [-1.0, 1.0] {
        app.world_mut().spawn(wall(side * (half + 1.0), 10.0, 0.0, [1.0, 10.0, half]));
        app.world_mut().spawn(wall(0.0, 10.0, side * (half + 1.0), [half, 10.0, 1.0]));
    }
}

/// In milliseconds.
fn timed_frame(app: &mut App) -> f64 {
    let start = Instant::now();
    app.update();
    1e3 * start.elapsed().as_secs_f64()
}

fn histogram(title: &str, mut times: Vec<f64>) {
    times.sort_by(f64::total_cmp);
    let longest = times.last().copied().unwrap_or_default();
    println!("\n{title}: {} frames, physics included, the longest {longest:.1} ms", times.len());
    let mut begin = 0;
    for bar in BARS {
        let end = times.partition_point(|time| *time <= bar);
        let stars = "*".repeat((60 * (end - begin)).div_ceil(times.len().max(1)));
        println!("{:>9} ms {:>6} {stars}", format!("≤ {bar}"), end - begin);
        begin = end;
    }
}
