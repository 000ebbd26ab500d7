//! The stage that the demos share: plugins, a floor, a light, a camera, and `--screenshot FILE`,
//! which writes a picture once all bodies have come to rest, and ends; with an error if the picture
//! is empty. Space shows and hides the hulls.

use std::collections::HashSet;

use bevy::app::PluginGroupBuilder;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;
use hullwright::bevy::{HullwrightDebug, HullwrightDebugPlugin};

/// Frames from the last collider to the picture: two seconds of falling.
const FRAMES_TO_REST: usize = 120;

/// A picture of nothing has one colour; light and shadow on an empty floor give some hundreds.
const FEWEST_COLOURS: usize = 50;

/// Bytes of a pixel of a screenshot.
const PIXEL: usize = 4;

/// How large a scene is, in metres.
#[derive(Resource, Clone, Copy)]
struct SceneSize(f32);

/// Where the picture goes, and frames since all was ready.
#[derive(Resource)]
struct Picture {
    path: String,
    frames: usize,
}

/// The bundled models, wherever the demo is started.
const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets");

/// Bevy with a window and the bundled models, Rapier and Hullwright.
pub fn plugins() -> impl PluginGroup {
    DemoPlugins
}

struct DemoPlugins;

impl PluginGroup for DemoPlugins {
    fn build(self) -> PluginGroupBuilder {
        DefaultPlugins
            .set(AssetPlugin { file_path: ASSETS.into(), ..default() })
            .add(RapierPhysicsPlugin::<NoUserData>::default())
            .add(HullwrightPlugin::default())
            .add(HullwrightDebugPlugin)
    }
}

/// The floor, the light, the camera and the keys.
pub struct Stage {
    /// Width of the scene, in metres.
    pub size: f32,
}

impl Plugin for Stage {
    fn build(&self, app: &mut App) {
        app.insert_resource(SceneSize(self.size))
            .add_systems(Startup, set_up)
            .add_systems(Update, (toggle_hulls, take_picture.run_if(resource_exists::<Picture>)));
        let mut arguments = std::env::args().skip_while(|argument| argument != "--screenshot");
        if let Some(path) = arguments.nth(1) {
            app.insert_resource(Picture { path, frames: 0 });
        }
    }
}

fn set_up(
    mut commands: Commands,
    size: Res<SceneSize>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let size = size.0;
    commands.spawn((
        Camera3d::default(),
        // The others need textures that Bevy bundles behind a feature.
        Tonemapping::AcesFitted,
        Transform::from_xyz(0.0, 0.6 * size, 1.2 * size).looking_at(Vec3::Y * 0.15 * size, Vec3::Y),
    ));
    let sun = Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((DirectionalLight { shadow_maps_enabled: true, ..default() }, sun));
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(10.0 * size, 10.0 * size))),
        MeshMaterial3d(materials.add(Color::srgb(0.3, 0.32, 0.35))),
        Collider::halfspace(Vec3::Y).expect("up is a direction"),
    ));
}

/// Space shows and hides the hulls.
fn toggle_hulls(keys: Res<ButtonInput<KeyCode>>, mut debug: ResMut<HullwrightDebug>) {
    if keys.just_pressed(KeyCode::Space) {
        debug.is_drawn = !debug.is_drawn;
    }
}

fn take_picture(
    mut commands: Commands,
    mut picture: ResMut<Picture>,
    statuses: Query<&DecompositionStatus>,
) {
    let are_ready = !statuses.is_empty() && statuses.iter().all(DecompositionStatus::is_finished);
    picture.frames += usize::from(are_ready);
    if picture.frames == FRAMES_TO_REST {
        commands
            .spawn(Screenshot::primary_window())
            .observe(save_to_disk(picture.path.clone()))
            .observe(|picture: On<ScreenshotCaptured>, mut exit: MessageWriter<AppExit>| {
                exit.write(judge(&picture.image));
            });
    }
}

fn judge(picture: &Image) -> AppExit {
    let pixels = picture.data.iter().flat_map(|data| data.chunks_exact(PIXEL));
    let colours = pixels.collect::<HashSet<_>>().len();
    println!("{} × {} pixels of {colours} colours", picture.width(), picture.height());
    if colours < FEWEST_COLOURS { AppExit::error() } else { AppExit::Success }
}
