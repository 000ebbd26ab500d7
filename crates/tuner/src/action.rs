//! All that can be done, by a button or by a key.

use bevy::input::keyboard::Key;
use bevy::prelude::*;
use bevy_egui::input::EguiWantsInput;

use crate::balls::Throw;
use crate::decompose::{Settings, Tuning};
use crate::export::{Export, extras, rust};
use crate::model::{BUNDLED, Library, bundled};
use crate::scene::{Show, Trial, fit_of};

/// Factor by which a key changes the bound.
const BOUND_STEP: f64 = 1.25;

/// Bounds, in percent.
pub const BOUNDS: std::ops::RangeInclusive<f64> = 0.1..=20.0;

/// How far hulls are moved apart by the key.
const EXPLOSION: f32 = 0.6;

/// Something to be done.
#[derive(Message, Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Tries something.
    Try(Trial),
    /// Tries the same again.
    Again,
    /// Throws balls.
    Throw,
    /// Shows or hides hulls, mesh, edges, and what no ball reaches.
    Hulls,
    /// See above.
    Mesh,
    /// See above.
    Edges,
    /// See above.
    Filled,
    /// Moves hulls apart, or together.
    Explode,
    /// Turns a model upright whose third axis points up.
    ZUp,
    /// A smaller or larger bound.
    Finer,
    /// See above.
    Coarser,
    /// The next bundled model, or the one before.
    Next,
    /// See above.
    Previous,
    /// Copies the component.
    CopyRust,
    /// See above.
    CopyExtras,
    /// Saves the hulls.
    SaveHulls,
    /// See above.
    SaveGlb,
    /// Back to the default settings.
    Reset,
    /// Shows or hides the list of keys.
    Help,
}

/// Keys, as their caps say, and what they do.
pub const KEYS: [(&str, &str, Action); 22] = [
    ("1", "look at it", Action::Try(Trial::Look)),
    ("2", "drop it on the floor", Action::Try(Trial::Drop)),
    ("3", "hang it on a hook", Action::Try(Trial::Hook)),
    ("4", "stack ten", Action::Try(Trial::Stack)),
    ("b", "throw balls at it", Action::Throw),
    ("r", "try again", Action::Again),
    ("h", "hulls on and off", Action::Hulls),
    ("m", "mesh on and off", Action::Mesh),
    ("e", "edges on and off", Action::Edges),
    ("f", "what a probe fills instead of hulls", Action::Filled),
    ("x", "hulls apart and together", Action::Explode),
    ("z", "z points up, or y", Action::ZUp),
    ("[", "a smaller bound", Action::Finer),
    ("]", "a larger bound", Action::Coarser),
    ("n", "next model", Action::Next),
    ("p", "model before", Action::Previous),
    ("0", "default settings", Action::Reset),
    ("c", "copy the component as Rust", Action::CopyRust),
    ("j", "copy it as glTF extras", Action::CopyExtras),
    ("s", "save .hulls", Action::SaveHulls),
    ("g", "save .glb", Action::SaveGlb),
    ("?", "these keys", Action::Help),
];

/// Whether the list of keys is shown.
#[derive(Resource, Default)]
pub struct Help(pub bool);

/// Keys become actions while no text is written.
pub fn read_keys(
    keys: Res<ButtonInput<Key>>,
    wants: Res<EguiWantsInput>,
    mut help: ResMut<Help>,
    mut actions: MessageWriter<Action>,
) {
    if keys.just_pressed(Key::Escape) {
        help.0 = false;
    }
    if wants.wants_keyboard_input() {
        return;
    }
    let is_pressed = |cap: &str| {
        let upper = cap.to_uppercase();
        keys.just_pressed(Key::Character(cap.into()))
            || keys.just_pressed(Key::Character(upper.as_str().into()))
    };
    for (_, _, action) in KEYS.iter().filter(|(cap, ..)| is_pressed(cap)) {
        actions.write(*action);
    }
}

/// Does it.
#[allow(clippy::too_many_arguments)]
pub fn act(
    mut actions: MessageReader<Action>,
    mut show: ResMut<Show>,
    mut settings: ResMut<Settings>,
    mut library: ResMut<Library>,
    mut export: ResMut<Export>,
    mut help: ResMut<Help>,
    mut throws: MessageWriter<Throw>,
    tuning: Res<Tuning>,
) {
    for action in actions.read() {
        let fit = library.current.as_ref().and_then(|model| fit_of(&tuning, model));
        let diagonal = library.current.as_ref().map_or(1.0, |model| model.diagonal());
        match action {
            Action::Try(trial) => show.trial = *trial,
            Action::Again => show.attempt += 1,
            Action::Throw => {
                // They would meet the collider of hulls that are drawn elsewhere.
                show.explosion = 0.0;
                throws.write(Throw);
            }
            Action::Hulls => show.hulls = !show.hulls,
            Action::Mesh => show.mesh = !show.mesh,
            Action::Edges => show.edges = !show.edges,
            Action::Filled => show.filled = !show.filled,
            Action::Explode => {
                show.trial = Trial::Look;
                show.explosion = if show.explosion > 0.0 { 0.0 } else { EXPLOSION };
            }
            Action::ZUp => show.z_up = !show.z_up,
            Action::Finer => settings.bound = stepped(settings.bound, 1.0 / BOUND_STEP),
            Action::Coarser => settings.bound = stepped(settings.bound, BOUND_STEP),
            Action::Next => open_neighbour(&mut library, 1),
            Action::Previous => open_neighbour(&mut library, BUNDLED.len() - 1),
            Action::CopyRust => {
                export.copy(&rust(&settings, diagonal), "the component as Rust");
            }
            Action::CopyExtras => {
                export.copy(&extras(&settings, diagonal), "the component as glTF extras");
            }
            Action::SaveHulls | Action::SaveGlb => {
                let suffix = if *action == Action::SaveGlb { "glb" } else { "hulls" };
                match fit {
                    Some(fit) => export.save(fit, suffix),
                    None => export.message = Err("there are no hulls yet".into()),
                }
            }
            Action::Reset => *settings = Settings::default(),
            Action::Help => help.0 = !help.0,
        }
    }
}

/// Two digits are enough for a bound.
fn stepped(bound: f64, factor: f64) -> f64 {
    let next = (bound * factor).clamp(*BOUNDS.start(), *BOUNDS.end());
    let unit = 10_f64.powf(next.log10().floor() - 1.0);
    (next / unit).round() * unit
}

fn open_neighbour(library: &mut Library, step: usize) {
    let name = library.current.as_ref().map(|model| model.name.as_str());
    let here = BUNDLED.iter().position(|bundled| Some(*bundled) == name);
    let next = here.map_or(0, |here| (here + step) % BUNDLED.len());
    library.open(bundled(BUNDLED[next]));
}
