//! What there is to be seen, for comparing before and after.

use std::path::PathBuf;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;
use bevy_rapier3d::prelude::Velocity;
use hullwright::hulls_format::HullsFile;
use hullwright_demos::orbit::Orbit;
use hullwright_demos::picture::{Bodies, awake};
use hullwright_formats::read_mesh;

use crate::action::Help;
use crate::balls::Ball;
use crate::decompose::{Settings, Tuning};
use crate::export::Export;
use crate::model::Library;
use crate::pointer::PointerBall;
use crate::scene::{Show, Thing, fit_of};

/// What a step may promise something about.
#[derive(Debug, Clone, Default)]
pub struct Seen {
    /// The model's name.
    pub model: String,
    /// Hulls that are shown, and their vertices.
    pub hulls: usize,
    /// See above.
    pub vertices: usize,
    /// Triangles of what no ball of the probe's radius reaches.
    pub filled: usize,
    /// Whether the ball at the pointer is seen.
    pub is_ball_seen: bool,
    /// The model's diagonal, in its own units.
    pub diagonal: f64,
    /// Verified, in percent.
    pub errors: [f64; 2],
    /// What the controls say.
    pub settings: Settings,
    /// See above.
    pub show: Show,
    /// Whether a job runs.
    pub is_busy: bool,
    /// What went wrong.
    pub error: Option<String>,
    /// Whether keys are listed.
    pub help: bool,
    /// Whether a list of choices is open.
    pub is_list_open: bool,
    /// Bodies that are the model.
    pub things: usize,
    /// The highest and the lowest middle of these, in metres.
    pub highest: f32,
    /// See above.
    pub lowest: f32,
    /// Whether all sleep.
    pub is_still: bool,
    /// Balls.
    pub balls: usize,
    /// Where the camera is.
    pub azimuth: f32,
    /// See above.
    pub elevation: f32,
    /// See above.
    pub distance: f32,
    /// Text in the clipboard.
    pub copied: Option<String>,
    folder: PathBuf,
}

impl Seen {
    /// How many hulls are in the file that was saved with a suffix.
    pub fn saved(&self, suffix: &str) -> Option<usize> {
        let path = self.folder.join(format!("{}.{suffix}", self.model));
        match suffix {
            "hulls" => Some(HullsFile::read(path).ok()?.hulls.len()),
            _ => Some(read_mesh(path).ok()?.objects.len()),
        }
    }
}

/// Where to look.
#[derive(SystemParam)]
pub struct Watched<'w, 's> {
    library: Res<'w, Library>,
    settings: Res<'w, Settings>,
    show: Res<'w, Show>,
    tuning: Res<'w, Tuning>,
    export: Res<'w, Export>,
    help: Res<'w, Help>,
    wants: Res<'w, EguiWantsInput>,
    balls: Query<'w, 's, (), With<Ball>>,
    things: Query<'w, 's, &'static Transform, With<Thing>>,
    views: Query<'w, 's, &'static Orbit>,
    pointer: Query<'w, 's, &'static Visibility, With<PointerBall>>,
    bodies: Bodies<'w, 's>,
    velocities: Query<'w, 's, &'static Velocity>,
}

impl Watched<'_, '_> {
    /// Whether the hulls are those of the settings.
    pub fn is_current(&self) -> bool {
        let model = self.library.current.as_ref();
        !self.library.is_reading()
            && !self.export.is_saving()
            && (model.is_none() || self.tuning.is_current(model, &self.settings))
    }

    /// Whether all bodies sleep.
    pub fn is_still(&self) -> bool {
        awake(&self.bodies).next().is_none()
    }

    /// The highest speed of what does not sleep, in metres and in radians per second.
    pub fn speeds(&self) -> [f32; 2] {
        let speeds = awake(&self.bodies).filter_map(|body| self.velocities.get(body).ok());
        speeds.fold([0.0; 2], |[linear, angular], speed| {
            [linear.max(speed.linear.length()), angular.max(speed.angular.length())]
        })
    }

    /// Seconds for which a job has run.
    pub fn busy_seconds(&self) -> Option<f32> {
        self.tuning.progress().map(|(_, seconds)| seconds)
    }

    /// All of it.
    pub fn look(&self) -> Seen {
        let model = self.library.current.as_ref();
        let fit = model.and_then(|model| fit_of(&self.tuning, model));
        let heights = || self.things.iter().map(|place| place.translation.y);
        let view = self.views.iter().next();
        Seen {
            model: model.map_or_else(String::new, |model| model.name.clone()),
            hulls: fit.map_or(0, |fit| fit.decomposition.hulls.len()),
            vertices: fit.map_or(0, |fit| fit.vertices()),
            filled: fit
                .and_then(|fit| fit.probed.as_ref())
                .map_or(0, |(_, filled)| filled.triangles.len()),
            is_ball_seen: self
                .pointer
                .iter()
                .any(|visibility| *visibility == Visibility::Inherited),
            diagonal: model.map_or(1.0, |model| model.diagonal()),
            errors: fit.map_or([0.0; 2], |fit| fit.errors()),
            settings: self.settings.clone(),
            show: self.show.clone(),
            is_busy: self.tuning.progress().is_some(),
            error: self.library.error.clone().or_else(|| self.export.message.clone().err()),
            help: self.help.0,
            is_list_open: self.wants.is_popup_open(),
            things: self.things.iter().count(),
            highest: heights().fold(f32::NEG_INFINITY, f32::max),
            lowest: heights().fold(f32::INFINITY, f32::min),
            is_still: self.is_still(),
            balls: self.balls.iter().count(),
            azimuth: view.map_or(0.0, |view| view.azimuth),
            elevation: view.map_or(0.0, |view| view.elevation),
            distance: view.map_or(0.0, |view| view.distance),
            copied: self.export.copied().ok(),
            folder: self.export.folder.clone(),
        }
    }
}
