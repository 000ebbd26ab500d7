//! What the windows share: plugins, a studio, a camera, hulls drawn over what they stand for, a
//! line that says what is seen, and `--screenshot FILE`, which writes a picture once all bodies lie
//! still, and ends; with an error if the picture is empty.

mod caption;
pub mod frugal;
pub mod hulls;
pub mod orbit;
pub mod picture;
mod shown;
pub mod studio;

use std::path::PathBuf;

use bevy::app::PluginGroupBuilder;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::window::WindowResolution;
use bevy::winit::WinitSettings;
use bevy_egui::EguiPlugin;
use bevy_hullwright::prelude::*;
use bevy_hullwright::{HullwrightDebug, HullwrightDebugPlugin};
use bevy_rapier3d::prelude::*;

use caption::Caption;
use hulls::HullMaterials;
use orbit::{Orbit, OrbitPlugin, camera};
use picture::{
    Bodies, PicturePlugin, PictureTaken, Shutter, arguments, awake, is_tour, is_without_person,
};
pub use shown::ShownHulls;
use shown::{draw_new_hulls, note_ready, toggle};
use studio::Studio;

/// The bundled models, wherever a window is started from; in a browser beside the page.
pub const ASSETS: &str = match cfg!(target_family = "wasm") {
    false => concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets"),
    true => "assets",
};

/// Size of the window, in pixels: what fits on a screen, and into `xvfb-run` with a screen of 1280
/// by 800.
pub const WINDOW: [u32; 2] = [1280, 800];

/// That of a tour, whose pictures are many: all controls fit, and a processor draws it in half the
/// time.
const TOUR_WINDOW: [u32; 2] = [960, 720];

/// A frame moves bodies by at most this many seconds, in this many steps: a slow machine shows
/// fewer pictures of the same fall.
const LONGEST_FRAME: f32 = 1.0 / 20.0;
const STEPS: usize = 3;

/// Frames for which all must sleep before the picture: hulls that are ready are drawn a little
/// later.
const STILL_FRAMES: usize = 4;

/// Frames after which the picture is taken all the same, and it is said what still moves: a minute
/// and a half of the fall.
const MOST_FRAMES: usize = 450;

/// Nobody sees the fall before the picture: so many frames of it are one.
const FRAMES_AT_ONCE: usize = 4;

/// Bevy with a window and the bundled models, Rapier and Hullwright.
pub fn plugins(title: &str) -> PluginGroupBuilder {
    let [width, height] = if is_tour() { TOUR_WINDOW } else { WINDOW };
    let window = Window {
        title: title.into(),
        resolution: WindowResolution::new(width, height),
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

/// Steps of Rapier that keep up with slow frames; without a person as many in each frame as in some
/// of the longest, however long it takes.
pub fn timestep(frames: usize) -> TimestepMode {
    match is_without_person() {
        true => TimestepMode::Fixed { dt: LONGEST_FRAME * frames as f32, substeps: STEPS * frames },
        false => TimestepMode::Variable { max_dt: LONGEST_FRAME, time_scale: 1.0, substeps: STEPS },
    }
}

/// How far bodies may move before Rapier computes their contacts anew, in metres, where something
/// hangs. Rapier's own 5 cm keep the contacts of what rocks on a hook where they were, and push it
/// on: it swings without end. Things that lie on each other come to rest sooner with these.
pub const RECYCLED_FOR: f32 = 0.001;

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

/// Where the picture goes, for how many frames all has slept, and how many there were.
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
        .insert_resource(timestep(FRAMES_AT_ONCE))
        .insert_resource(HullwrightDebug { is_drawn: false, ..default() })
        .init_resource::<HullMaterials>()
        .init_resource::<ShownHulls>()
        .add_systems(Startup, set_up)
        .add_systems(PostStartup, frugal::draw_less)
        .add_systems(Update, (picture::watch_sleep, toggle, draw_new_hulls))
        .add_systems(Update, (take_picture, end).run_if(resource_exists::<Picture>))
        .add_observer(note_ready);
        let mut arguments = arguments().skip_while(|argument| argument != "--screenshot");
        if let Some(path) = arguments.nth(1) {
            // Without a person the window has no focus, and would be drawn less often.
            app.insert_resource(WinitSettings::continuous());
            app.insert_resource(Picture { path: path.into(), still: 0, frames: 0 });
            app.world_mut().resource_mut::<Shutter>().holds_bodies = true;
        }
    }
}

fn set_up(mut commands: Commands, view: Res<View>, studio: Res<Studio>) {
    commands.spawn(camera(view.0, &studio));
    commands.spawn(Collider::halfspace(Vec3::Y).expect("up is a direction"));
}

/// Bodies wait until all have their hulls, so that each run shows the same fall.
fn take_picture(
    mut picture: ResMut<Picture>,
    mut shutter: ResMut<Shutter>,
    statuses: Query<&DecompositionStatus>,
    bodies: Bodies,
    named: Query<(Option<&Name>, &Velocity)>,
) {
    let are_ready = !statuses.is_empty() && statuses.iter().all(DecompositionStatus::is_finished);
    shutter.holds_bodies = !are_ready;
    if !are_ready || picture.still == STILL_FRAMES {
        return;
    }
    picture.frames += 1;
    picture.still = if awake(&bodies).next().is_none() { picture.still + 1 } else { 0 };
    if picture.frames == MOST_FRAMES && picture.still < STILL_FRAMES {
        warn!("these bodies still move after {MOST_FRAMES} frames:");
        for (name, speed) in awake(&bodies).filter_map(|body| named.get(body).ok()) {
            let name = name.map_or("one without a name", Name::as_str);
            let [linear, angular] = [speed.linear, speed.angular].map(Vec3::length);
            warn!("  {name}: {linear:.3} m/s, {angular:.3} rad/s");
        }
        picture.still = STILL_FRAMES;
    }
    if picture.still == STILL_FRAMES {
        let count = statuses.iter().filter(|status| status.has_collider() == Some(true)).count();
        info!("{count} with colliders; the picture is taken after {} frames", picture.frames);
        shutter.take(&picture.path);
    }
}

fn end(mut taken: MessageReader<PictureTaken>, mut exit: MessageWriter<AppExit>) {
    for taken in taken.read() {
        exit.write(if taken.is_empty { AppExit::error() } else { AppExit::Success });
    }
}
