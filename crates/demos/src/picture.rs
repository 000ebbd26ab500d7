//! Pictures of the window: when all lies still, and whether there is anything to be seen.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy::render::render_resource::PipelineCache;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk};
use bevy::render::{Render, RenderApp, RenderSystems};
use bevy_rapier3d::prelude::*;

/// A picture of nothing has one colour; light and shadow on an empty floor give some hundreds.
const FEWEST_COLOURS: usize = 50;

/// Bytes of a pixel of a screenshot.
const PIXEL: usize = 4;

/// Bodies slower than this, in metres per second, lie still for the eye: some roll on for minutes.
const STILL: f32 = 0.01;

/// Says when a picture is taken, and when there is nothing left out of what is drawn.
pub struct PicturePlugin;

impl Plugin for PicturePlugin {
    fn build(&self, app: &mut App) {
        let shaders = Shaders::default();
        app.add_message::<PictureTaken>().insert_resource(shaders.clone());
        if let Some(render) = app.get_sub_app_mut(RenderApp) {
            render
                .insert_resource(shaders)
                .add_systems(Render, note_shaders.in_set(RenderSystems::Cleanup));
        }
    }
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

/// A pipeline whose shader misses something waits forever, and nothing that is drawn needs it: when as many
/// have waited for this long, no more will come.
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

/// Gives every body the component by which Rapier says that it sleeps.
pub fn watch_sleep(mut commands: Commands, bodies: Query<Entity, Added<RigidBody>>) {
    for body in &bodies {
        commands.entity(body).insert_if_new((Sleeping::default(), Velocity::default()));
    }
}

/// The bodies that may move.
pub type Bodies<'w, 's> = Query<'w, 's, (&'static RigidBody, &'static Sleeping, &'static Velocity)>;

/// Whether all bodies that may move lie still.
pub fn is_still(bodies: &Bodies) -> bool {
    bodies
        .iter()
        .filter(|(body, ..)| matches!(body, RigidBody::Dynamic))
        .all(|(_, sleeping, velocity)| sleeping.sleeping || velocity.linear.length() < STILL)
}

/// A picture is written.
#[derive(Message, Debug, Clone, PartialEq)]
pub struct PictureTaken {
    /// Where it is.
    pub path: PathBuf,
    /// Whether nothing is to be seen on it.
    pub is_empty: bool,
}

/// Writes a picture of the window as PNG, and then the message [`PictureTaken`].
pub fn take(commands: &mut Commands, path: &Path) {
    let written = path.to_owned();
    commands.spawn(Screenshot::primary_window()).observe(save_to_disk(path.to_owned())).observe(
        move |captured: On<ScreenshotCaptured>, mut taken: MessageWriter<PictureTaken>| {
            let (image, colours) = (&captured.image, colours(&captured.image));
            let [width, height] = [image.width(), image.height()];
            println!("{}: {width} × {height} pixels of {colours} colours", written.display());
            let is_empty = colours < FEWEST_COLOURS;
            taken.write(PictureTaken { path: written.clone(), is_empty });
        },
    );
}

fn colours(picture: &Image) -> usize {
    let pixels = picture.data.iter().flat_map(|data| data.chunks_exact(PIXEL));
    pixels.collect::<HashSet<_>>().len()
}
