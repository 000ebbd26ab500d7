//! The tuner: a window in which the hulls of a mesh are chosen by looking, and tried in physics.
//! `cargo tuner [FILE]`; `cargo tuner --help` lists what else it takes.

mod action;
mod arguments;
mod balls;
mod decompose;
mod export;
mod follow;
mod hang;
mod model;
mod pointer;
mod scene;
mod stopwatch;
mod tour;
mod ui;

use std::path::PathBuf;

use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::prelude::*;
use bevy::window::FileDragAndDrop;
use bevy::winit::WinitSettings;
use bevy_egui::input::EguiInputEvent;
use bevy_egui::{EguiPrimaryContextPass, PrimaryEguiContext, egui};
use bevy_rapier3d::prelude::*;
use hullwright_demos::frugal::draw_less;
use hullwright_demos::hulls::HullMaterials;
use hullwright_demos::orbit::{Orbit, OrbitPlugin, camera};
use hullwright_demos::picture::{self, PicturePlugin, PictureTaken, Shutter, is_without_person};
use hullwright_demos::studio::Studio;

use arguments::{Arguments, USAGE};
use export::Export;
use model::Library;
use stopwatch::{StopwatchPlugin, mark};
use tour::{Tour, Watched};

/// Width of what is on the stage, in metres.
const STAGE: f32 = 3.4;

/// Bevy's fixed steps in a second. Nothing here uses them, and Bevy's own 64 make a long frame
/// longer: what it missed is caught up with in the next.
const FIXED_RATE: f64 = 4.0;

/// Frames for which all sleeps before `--screenshot`.
const STILL_FRAMES: usize = 6;

/// Where the only picture goes, and for how many frames all was still.
#[derive(Resource)]
struct Screenshot(PathBuf, usize);

fn main() -> AppExit {
    let arguments = match Arguments::read(std::env::args().skip(1)) {
        Ok(Some(arguments)) => arguments,
        Ok(None) => {
            println!("{USAGE}");
            return AppExit::Success;
        }
        Err(error) => {
            eprintln!("{error}\n\n{USAGE}");
            return AppExit::error();
        }
    };
    let mut app = App::new();
    app.add_plugins((
        hullwright_demos::plugins("Hullwright tuner"),
        Studio::dark(STAGE),
        OrbitPlugin,
        PicturePlugin,
        StopwatchPlugin,
    ))
    .insert_resource(hullwright_demos::timestep(1))
    .insert_resource(Export::new(arguments.folder))
    .insert_resource(scene::Show { trial: arguments.trial, ..default() })
    .insert_resource(Time::<Fixed>::from_hz(FIXED_RATE))
    .init_resource::<HullMaterials>()
    .init_resource::<scene::Materials>()
    .init_resource::<Library>()
    .init_resource::<decompose::Settings>()
    .init_resource::<decompose::Tuning>()
    .init_resource::<action::Help>()
    .init_resource::<ui::PathField>()
    .init_resource::<ui::Controls>()
    .add_message::<PictureTaken>()
    .add_message::<action::Action>()
    .add_message::<balls::Throw>()
    .add_systems(Startup, (set_up, pointer::set_up))
    .add_systems(PostStartup, (ui::set_style, draw_less))
    .add_systems(EguiPrimaryContextPass, (ui::draw, mark("controls")).chain())
    .add_systems(
        Update,
        (
            (open_dropped, action::read_keys, paste),
            mark("keys"),
            (action::act, export::take_saved),
            mark("actions"),
            model::take_read,
            mark("model"),
            decompose::follow_settings,
            mark("hulls"),
            (scene::arrange, scene::renew_contacts),
            mark("stage"),
            (
                balls::throw,
                follow::follow_stack,
                follow::see_through_haze,
                pointer::follow_pointer,
                scene::show_layers,
                picture::watch_sleep,
            ),
        )
            .chain(),
    );
    // Without a person the window has no focus, and would be drawn less often.
    if is_without_person() {
        app.insert_resource(WinitSettings::continuous());
    }
    if let Some(folder) = arguments.tour {
        match Tour::new(folder, arguments.step.as_deref()) {
            Ok(tour) => {
                app.insert_resource(tour).add_systems(Last, tour::go_on);
            }
            Err(error) => {
                eprintln!("{error}");
                return AppExit::error();
            }
        }
    }
    if let Some(path) = arguments.screenshot {
        app.insert_resource(Screenshot(path, 0)).add_systems(Last, (take_screenshot, end));
    }
    let path = arguments.model;
    app.add_systems(Startup, move |mut library: ResMut<Library>| library.open(&path));
    run_in_turn(&mut app);
    app.run()
}

/// Systems run one after the other. All of them together take some milliseconds; beside a job that
/// has all processors, each thread that one of them is handed to would first wait for its turn.
fn run_in_turn(app: &mut App) {
    for (_, schedule) in app.world_mut().resource_mut::<Schedules>().iter_mut() {
        schedule.set_executor(SingleThreadedExecutor::new());
    }
}

fn set_up(mut commands: Commands, studio: Res<Studio>) {
    let view = Orbit::new(Vec3::Y * 0.5, 1.0).from_angles(0.6, 0.38);
    commands.spawn((camera(view, &studio), PrimaryEguiContext));
    let floor =
        (Collider::halfspace(Vec3::Y).expect("up is a direction"), Friction::coefficient(0.7));
    commands.spawn(floor);
}

/// A file that is dropped on the window.
fn open_dropped(mut files: MessageReader<FileDragAndDrop>, mut library: ResMut<Library>) {
    for file in files.read() {
        if let FileDragAndDrop::DroppedFile { path_buf, .. } = file {
            library.open(path_buf);
        }
    }
}

/// Ctrl and v into a field of text: the window has no clipboard of its own.
fn paste(
    keys: Res<ButtonInput<KeyCode>>,
    export: Res<Export>,
    contexts: Query<Entity, With<PrimaryEguiContext>>,
    mut events: MessageWriter<EguiInputEvent>,
) {
    let is_held =
        keys.any_pressed([KeyCode::ControlLeft, KeyCode::ControlRight, KeyCode::SuperLeft]);
    if is_held
        && keys.just_pressed(KeyCode::KeyV)
        && let Ok(text) = export.copied()
    {
        for context in &contexts {
            events.write(EguiInputEvent { context, event: egui::Event::Paste(text.clone()) });
        }
    }
}

fn take_screenshot(
    mut shutter: ResMut<Shutter>,
    mut screenshot: ResMut<Screenshot>,
    watched: Watched,
) {
    let Screenshot(path, still) = &mut *screenshot;
    if *still < STILL_FRAMES {
        *still = if watched.is_current() && watched.is_still() { *still + 1 } else { 0 };
        if *still == STILL_FRAMES {
            shutter.take(path);
        }
    }
}

fn end(mut taken: MessageReader<PictureTaken>, mut exit: MessageWriter<AppExit>) {
    for picture in taken.read() {
        exit.write(if picture.is_empty { AppExit::error() } else { AppExit::Success });
    }
}
