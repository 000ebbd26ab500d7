//! Pictures of the window: when all lies still, and whether there is anything to be seen.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy::render::render_resource::PipelineCache;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::render::{Render, RenderApp, RenderSystems};
use bevy_rapier3d::prelude::*;

/// A picture of nothing has one colour; light and shadow on an empty floor give some hundreds.
const FEWEST_COLOURS: usize = 50;

/// Bytes of a pixel of a screenshot.
const PIXEL: usize = 4;

/// Frames that are drawn before the one that is kept: egui and the shadows need one each to begin.
const FRAMES_BEFORE: usize = 2;

/// Speeds below which a body falls asleep, in metres and radians per second, and for how long, in
/// seconds. Rapier's own are so high that a pendulum sleeps askew.
const LINEAR_SLEEP: f32 = 0.1;
const ANGULAR_SLEEP: f32 = 0.3;
const SLEEP_AFTER: f32 = 0.4;

/// Writes pictures, says when one is there, and when nothing is left out of what is drawn.
///
/// Without a person only what goes into pictures is drawn, and bodies stand still meanwhile:
/// without a graphics card a frame takes a second, and what the pictures show must not depend on
/// that.
pub struct PicturePlugin;

impl Plugin for PicturePlugin {
    fn build(&self, app: &mut App) {
        let shaders = Shaders::default();
        app.add_message::<PictureTaken>()
            .init_resource::<Shutter>()
            .insert_resource(shaders.clone())
            // Before the first frame too: what stands still from the beginning must not fall in it.
            .add_systems(PostStartup, work_shutter)
            .add_systems(Last, work_shutter);
        if let Some(render) = app.get_sub_app_mut(RenderApp) {
            render
                .insert_resource(shaders)
                .add_systems(Render, note_shaders.in_set(RenderSystems::Cleanup));
        }
    }
}

/// What is to be on a picture, and whether bodies may move.
#[derive(Resource, Default)]
pub struct Shutter {
    /// Whether bodies stand still.
    pub holds_bodies: bool,
    path: Option<PathBuf>,
    drawn: usize,
    is_asked: bool,
}

impl Shutter {
    /// Writes a picture of the window as PNG, and then the message [`PictureTaken`].
    pub fn take(&mut self, path: &Path) {
        self.path = Some(path.to_owned());
        self.drawn = 0;
        self.is_asked = false;
    }
}

fn work_shutter(
    mut commands: Commands,
    mut shutter: ResMut<Shutter>,
    mut cameras: Query<&mut Camera>,
    mut physics: Query<&mut RapierConfiguration>,
    shaders: Res<Shaders>,
) {
    let is_open = shutter.path.is_some();
    let may_move = !(shutter.holds_bodies || is_open && is_without_person());
    for mut configuration in &mut physics {
        if configuration.physics_pipeline_active != may_move {
            configuration.physics_pipeline_active = may_move;
        }
    }
    for mut camera in &mut cameras {
        let is_active = is_open || !is_without_person();
        if camera.is_active != is_active {
            camera.is_active = is_active;
        }
    }
    let Shutter { path: Some(path), drawn, is_asked, .. } = &mut *shutter else { return };
    *drawn += usize::from(*drawn < FRAMES_BEFORE || shaders.are_ready());
    // Once: a second picture would look like that of the next step.
    if *drawn > FRAMES_BEFORE && !std::mem::replace(is_asked, true) {
        capture(&mut commands, path.clone());
    }
}

fn capture(commands: &mut Commands, path: PathBuf) {
    commands.spawn(Screenshot::primary_window()).observe(save_to_disk(path.clone())).observe(
        move |captured: On<ScreenshotCaptured>,
              mut shutter: ResMut<Shutter>,
              mut taken: MessageWriter<PictureTaken>| {
            let (image, colours) = (&captured.image, colours(&captured.image));
            let [width, height] = [image.width(), image.height()];
            info!("{}: {width} × {height} pixels of {colours} colours", path.display());
            let is_empty = colours < FEWEST_COLOURS;
            if is_empty {
                error!("nothing is to be seen in {}", path.display());
            }
            shutter.path = None;
            taken.write(PictureTaken { path: path.clone(), is_empty });
        },
    );
}

/// Whether pictures are written: then the window may be slow, and nothing may be left out.
pub fn is_without_person() -> bool {
    is_for_show() || is_tour()
}

/// Whether the picture is to be as good as it can be: those of a tour are many.
pub fn is_for_show() -> bool {
    is_argument("--screenshot")
}

/// Whether a picture of each step is written.
pub fn is_tour() -> bool {
    is_argument("--tour")
}

fn is_argument(name: &str) -> bool {
    arguments().any(|argument| argument == name)
}

/// What the program was called with.
#[cfg(not(target_family = "wasm"))]
pub fn arguments() -> impl Iterator<Item = String> {
    std::env::args()
}

/// What the page's address says, as in `?--screenshot&mugs.png`.
#[cfg(target_family = "wasm")]
pub fn arguments() -> impl Iterator<Item = String> {
    let query = web_sys::window().and_then(|window| window.location().search().ok());
    let query = query.unwrap_or_default();
    query.trim_start_matches('?').split('&').map(String::from).collect::<Vec<_>>().into_iter()
}

/// Whether all shaders that are wanted are there: things without one are not drawn.
#[derive(Resource, Clone, Default)]
pub struct Shaders(Arc<AtomicBool>);

impl Shaders {
    /// As of the last frame that was drawn.
    pub fn are_ready(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A pipeline whose shader misses something waits forever, and nothing that is drawn needs it: when
/// as many have waited for this long, no more will come.
const LONGEST_WAIT: Duration = Duration::from_secs(5);

fn note_shaders(
    cache: Res<PipelineCache>,
    shaders: Res<Shaders>,
    mut waiting: Local<Option<(usize, Instant)>>,
) {
    let count = cache.waiting_pipelines().count();
    let since = match *waiting {
        Some((before, since)) if before == count => since,
        _ => Instant::now(),
    };
    *waiting = Some((count, since));
    let are_ready = count == 0 || since.elapsed() > LONGEST_WAIT;
    shaders.0.store(are_ready, Ordering::Relaxed);
}

/// Gives every body the components by which Rapier says that it sleeps.
pub fn watch_sleep(mut commands: Commands, bodies: Query<Entity, Added<RigidBody>>) {
    let sleeping = Sleeping {
        normalized_linear_threshold: LINEAR_SLEEP,
        angular_threshold: ANGULAR_SLEEP,
        time_until_sleep: SLEEP_AFTER,
        sleeping: false,
    };
    for body in &bodies {
        commands.entity(body).insert_if_new((sleeping, Velocity::default()));
    }
}

/// The bodies that may move.
pub type Bodies<'w, 's> = Query<'w, 's, (Entity, &'static RigidBody, &'static Sleeping)>;

/// The bodies that may move and do not sleep.
pub fn awake(bodies: &Bodies) -> impl Iterator<Item = Entity> {
    bodies
        .iter()
        .filter(|(_, body, sleeping)| matches!(body, RigidBody::Dynamic) && !sleeping.sleeping)
        .map(|(entity, ..)| entity)
}

/// A picture is written.
#[derive(Message, Debug, Clone, PartialEq)]
pub struct PictureTaken {
    /// Where it is.
    pub path: PathBuf,
    /// Whether nothing is to be seen on it.
    pub is_empty: bool,
}

fn colours(picture: &Image) -> usize {
    let pixels = picture.data.iter().flat_map(|data| data.chunks_exact(PIXEL));
    pixels.collect::<HashSet<_>>().len()
}
