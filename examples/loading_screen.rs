//! A loading screen without a window: a scene is loaded, its meshes get their colliders in the
//! background while the progress is shown, and the level starts when all is done. With a
//! `.hullscene` file beside the scene, as `hullwright bake SCENE` writes it, nothing is decomposed:
//! `cargo run --ignore-rust-version --release --example loading_screen --features bake,bevy_gltf
//! [SCENE.glb]`. One with textures in it wants the features `bevy/png,bevy/jpeg` too.

#[path = "headless/scenes.rs"]
mod scenes;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::app::ScheduleRunnerPlugin;
use bevy::asset::LoadState;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;

use scenes::HeadlessScenes;

/// A frame at 60 Hz.
const FRAME: Duration = Duration::from_micros(16_667);

/// Frames of the level before the program ends.
const FRAMES_OF_PLAY: usize = 60;

/// In a game one of Bevy's `States`.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Default)]
enum Screen {
    #[default]
    Loading,
    Playing,
}

/// The scene's file, and when the program began.
#[derive(Resource)]
struct Level {
    file: String,
    has_baked: bool,
    start: Instant,
}

fn main() -> AppExit {
    let props = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/props.glb");
    let scene = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| props.into()));
    let directory = scene.parent().unwrap_or(Path::new("")).display().to_string();
    let directory = std::path::absolute(if directory.is_empty() { "." } else { &directory });
    let level = Level {
        file: scene.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        has_baked: scene.with_extension("hullscene").exists(),
        start: Instant::now(),
    };
    App::new()
        .add_plugins((
            MinimalPlugins.set(ScheduleRunnerPlugin::run_loop(FRAME)),
            AssetPlugin {
                file_path: directory.unwrap_or_default().display().to_string(),
                ..default()
            },
            TransformPlugin,
            HeadlessScenes,
            RapierPhysicsPlugin::<NoUserData>::default(),
            HullwrightPlugin::default(),
        ))
        .init_resource::<Screen>()
        .insert_resource(level)
        .add_observer(make_body)
        .add_observer(on_finished)
        .add_systems(Startup, load)
        .add_systems(
            Update,
            (
                show_progress.run_if(resource_changed::<DecompositionProgress>),
                start_playing.run_if(all_decompositions_done),
            )
                .chain()
                .run_if(resource_equals(Screen::Loading)),
        )
        .add_systems(Update, (hold_physics, play.run_if(resource_equals(Screen::Playing))))
        .run()
}

fn load(mut commands: Commands, server: Res<AssetServer>, level: Res<Level>) {
    let scene = GltfAssetLabel::Scene(0).from_asset(level.file.clone());
    let mut colliders = ConvexDecompositionHierarchy::default();
    if level.has_baked {
        let baked = Path::new(&level.file).with_extension("hullscene");
        colliders = colliders.with_baked(server.load(baked));
    }
    commands.spawn((WorldAssetRoot(server.load(scene)), colliders));
}

/// Each prop is a body of its own, and a piece belongs to its mesh. What is no body stands still.
fn make_body(
    tagged: On<Add<ConvexDecomposition>>,
    mut commands: Commands,
    nodes: Query<(&Name, Option<&ColliderPieceOf>)>,
) {
    let Ok((name, piece)) = nodes.get(tagged.entity) else { return };
    if name.as_str() != "floor" {
        let body = piece.map_or(tagged.entity, |piece| piece.0);
        commands.entity(body).insert(RigidBody::Dynamic);
    }
}

/// Nothing moves before all it may fall onto is there.
fn hold_physics(screen: Res<Screen>, mut worlds: Query<&mut RapierConfiguration>) {
    for mut world in &mut worlds {
        world.physics_pipeline_active = *screen == Screen::Playing;
    }
}

fn show_progress(progress: Res<DecompositionProgress>) {
    let bar = "#".repeat((40.0 * progress.fraction) as usize);
    let (percent, finished) = (100.0 * progress.fraction, progress.finished);
    println!("[{bar:<40}] {percent:>3.0} %, {finished} of {}", progress.total);
}

fn on_finished(
    finished: On<HierarchyFinished>,
    roots: Query<&WorldAssetRoot>,
    server: Res<AssetServer>,
    mut exit: MessageWriter<AppExit>,
) {
    let report = finished.report;
    if report.is_lost {
        let state = roots.get(finished.entity).ok().and_then(|root| server.get_load_state(&root.0));
        if let Some(LoadState::Failed(error)) = state {
            eprintln!("{error}");
        }
        exit.write(AppExit::error());
    }
    println!(
        "{} ready ({} baked, {} stale, {} not in the file), {} skipped, {} failed, {} left out",
        report.ready,
        report.from_baked,
        report.stale,
        report.missing,
        report.skipped,
        report.failed,
        report.left_out
    );
}

fn start_playing(
    mut screen: ResMut<Screen>,
    level: Res<Level>,
    counters: Res<DecompositionCounters>,
) {
    let seconds = level.start.elapsed().as_secs_f64();
    println!("the level starts after {seconds:.2} s and {} decompositions", counters.decomposed);
    *screen = Screen::Playing;
}

fn play(
    mut frames: Local<usize>,
    mut exit: MessageWriter<AppExit>,
    colliders: Query<(), With<Collider>>,
) {
    *frames += 1;
    if *frames == FRAMES_OF_PLAY {
        // A level without colliders has nothing to stand on.
        exit.write(if colliders.is_empty() { AppExit::error() } else { AppExit::Success });
    }
}
