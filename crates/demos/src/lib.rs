//! What the windows share: plugins, a studio, a camera, hulls drawn over what they stand for, a line
//! that says what is seen, and `--screenshot FILE`, which writes a picture once all bodies lie still,
//! and ends; with an error if the picture is empty.

mod caption;
pub mod hulls;
pub mod orbit;
pub mod picture;
mod shown;
pub mod studio;

use std::path::PathBuf;
use std::time::Duration;

use bevy::app::PluginGroupBuilder;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::window::WindowResolution;
use bevy::winit::WinitSettings;
use bevy_egui::EguiPlugin;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;
use hullwright::bevy::{HullwrightDebug, HullwrightDebugPlugin};

use caption::Caption;
use hulls::HullMaterials;
use orbit::{Orbit, OrbitPlugin, camera};
use picture::{Bodies, PicturePlugin, PictureTaken, Shaders, is_still};
use shown::{ShownHulls, show_new_hulls, toggle};
use studio::Studio;

/// The bundled models, wherever a window is started from.
pub const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets");

/// Size of the window, in pixels: what fits on a screen, and into `xvfb-run` with a screen of 1280 by 800.
pub const WINDOW: [u32; 2] = [1280, 800];

/// A frame moves bodies by at most this many seconds, in this many steps: a slow machine shows fewer
/// pictures of the same fall.
const LONGEST_FRAME: f32 = 1.0 / 20.0;
const STEPS: usize = 3;

/// Frames for which all must lie still before the picture: at the top of its way a body is slow too.
const STILL_FRAMES: usize = 30;

/// Frames after which the picture is taken all the same.
const MOST_FRAMES: usize = 1200;

/// As long where frames take long, as without a graphics card.
const LONGEST: Duration = Duration::from_secs(100);

/// Bevy with a window and the bundled models, Rapier and Hullwright.
pub fn plugins(title: &str) -> PluginGroupBuilder {
    let window = Window {
        title: title.into(),
        resolution: WindowResolution::new(WINDOW[0], WINDOW[1]),
        ..default()
    };
    DefaultPlugins
        .set(AssetPlugin { file_path: ASSETS.into(), ..default() })
        .set(WindowPlugin { primary_window: Some(window), ..default() })
        .set(RenderPlugin { synchronous_pipeline_compilation: is_without_person(), ..default() })
        .add(EguiPlugin::default())
        .add(RapierPhysicsPlugin::<NoUserData>::default())
        .add(HullwrightPlugin::default())
        .add(HullwrightDebugPlugin)
}

/// Whether pictures are written: then things are not left out while their shaders are compiled.
fn is_without_person() -> bool {
    std::env::args().any(|argument| argument == "--screenshot" || argument == "--tour")
}

/// Steps of Rapier that keep up with slow frames.
pub fn timestep() -> TimestepMode {
    TimestepMode::Variable { max_dt: LONGEST_FRAME, time_scale: 1.0, substeps: STEPS }
}

/// A demo: its studio with a floor, its camera, its line of text and its keys.
pub struct Stage {
    /// What is seen, in one line.
    pub caption: &'static str,
    /// Width of the scene, in metres.
    pub width: f32,
    /// From where it is seen.
    pub view: Orbit,
}

/// From where the scene is seen.
#[derive(Resource)]
struct View(Orbit);

/// Where the picture goes, frames since all lies still, and since the start.
#[derive(Resource)]
struct Picture {
    path: PathBuf,
    still: usize,
    frames: usize,
}

impl Plugin for Stage {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            Studio::light(self.width),
            OrbitPlugin,
            Caption(self.caption),
            PicturePlugin,
        ))
        .insert_resource(View(self.view))
        .insert_resource(timestep())
        .insert_resource(HullwrightDebug { is_drawn: false })
        .init_resource::<HullMaterials>()
        .init_resource::<ShownHulls>()
        .add_systems(Startup, set_up)
        .add_systems(Update, (picture::watch_sleep, toggle))
        .add_systems(Update, (take_picture, end).run_if(resource_exists::<Picture>))
        .add_observer(show_new_hulls);
        let mut arguments = std::env::args().skip_while(|argument| argument != "--screenshot");
        if let Some(path) = arguments.nth(1) {
            // Without a person the window has no focus, and would be drawn less often.
            app.insert_resource(WinitSettings::continuous());
            app.insert_resource(Picture { path: path.into(), still: 0, frames: 0 });
        }
    }
}

fn set_up(mut commands: Commands, view: Res<View>, studio: Res<Studio>) {
    commands.spawn(camera(view.0, &studio));
    commands.spawn(Collider::halfspace(Vec3::Y).expect("up is a direction"));
}

fn take_picture(
    mut commands: Commands,
    mut picture: ResMut<Picture>,
    statuses: Query<&DecompositionStatus>,
    bodies: Bodies,
    shaders: Res<Shaders>,
    time: Res<Time<Real>>,
) {
    let are_ready = shaders.are_ready()
        && !statuses.is_empty()
        && statuses.iter().all(DecompositionStatus::is_finished);
    picture.frames += 1;
    if picture.still == STILL_FRAMES {
        return;
    }
    picture.still = if are_ready && is_still(&bodies) { picture.still + 1 } else { 0 };
    if picture.frames == MOST_FRAMES || time.elapsed() > LONGEST {
        println!("not all lies still after {} frames", picture.frames);
        picture.still = STILL_FRAMES;
    }
    if picture.still == STILL_FRAMES {
        picture::take(&mut commands, &picture.path);
    }
}

fn end(mut taken: MessageReader<PictureTaken>, mut exit: MessageWriter<AppExit>) {
    for picture in taken.read() {
        exit.write(if picture.is_empty { AppExit::error() } else { AppExit::Success });
    }
}
