//! The panel at the left, the numbers above the model, and the list of keys.

mod hud;
mod style;
mod widgets;

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};
use hullwright::{Openings, Preset};
use hullwright_demos::orbit::Orbit;

use crate::action::{Action, BOUNDS, Help};
use crate::decompose::{Settings, Tuning};
use crate::export::Export;
use crate::model::{BUNDLED, Library, bundled};
use crate::scene::{Show, Trial, fit_of};
use hud::{draw_drop_hint, draw_help, draw_message, draw_numbers};
use widgets::{capped, choice, free_width, heading, row, wide_button};

pub use style::set_style;
pub use widgets::Controls;

/// Width of the panel, in pixels.
pub const PANEL: f32 = 312.0;

/// The ends of the sliders of caps, and where a cap begins when it is switched on.
const HULLS: std::ops::RangeInclusive<usize> = 1..=128;
const FIRST_HULLS: usize = 16;
const VERTICES: std::ops::RangeInclusive<usize> = 8..=256;
const FIRST_VERTICES: usize = 64;

/// Radii of the probe, in percent of the diagonal.
const PROBES: std::ops::RangeInclusive<f64> = 0.0..=12.0;

/// Farthest that hulls are moved apart.
const MOST_APART: f32 = 1.5;

/// What is written into the field for a path.
#[derive(Resource, Default)]
pub struct PathField(pub String);

/// All that the panel shows and changes.
#[derive(bevy::ecs::system::SystemParam)]
pub struct State<'w> {
    library: ResMut<'w, Library>,
    settings: ResMut<'w, Settings>,
    show: ResMut<'w, Show>,
    tuning: Res<'w, Tuning>,
    export: Res<'w, Export>,
    help: Res<'w, Help>,
    path: ResMut<'w, PathField>,
    controls: ResMut<'w, Controls>,
    actions: MessageWriter<'w, Action>,
}

/// Draws everything.
pub fn draw(mut contexts: EguiContexts, mut state: State, mut views: Query<&mut Orbit>) -> Result {
    let context = contexts.ctx_mut()?.clone();
    state.controls.clear();
    let screen = context.content_rect();
    let mut whole = egui::Ui::new(
        context.clone(),
        "whole".into(),
        egui::UiBuilder::new().layer_id(egui::LayerId::background()).max_rect(screen),
    );
    let panel = egui::Panel::left("panel").exact_size(PANEL).resizable(false);
    panel.frame(style::panel_frame()).show(&mut whole, |ui| {
        egui::ScrollArea::vertical().show(ui, |ui| {
            ui.set_width(PANEL - 2.0 * style::PANEL_MARGIN - 1.0);
            model_section(ui, &mut state);
            hulls_section(ui, &mut state);
            view_section(ui, &mut state);
            trial_section(ui, &mut state);
            export_section(ui, &mut state);
        });
    });
    for mut orbit in &mut views {
        orbit.covered = PANEL / screen.width().max(PANEL);
    }
    let free = screen.with_min_x(screen.left() + PANEL);
    let model = state.library.current.as_ref();
    let fit = model.and_then(|model| fit_of(&state.tuning, model));
    draw_numbers(&context, free, model.map(AsRef::as_ref), fit.map(AsRef::as_ref), &state.tuning);
    let error = state.library.error.as_ref().or(state.tuning.error.as_ref());
    draw_message(&context, free, &state.export.message, error, state.show.trial, model);
    draw_drop_hint(&context, free);
    if state.help.0 {
        draw_help(&context, free);
    }
    Ok(())
}

fn model_section(ui: &mut egui::Ui, state: &mut State) {
    heading(ui, "Model");
    let name = state.library.current.as_ref().map_or("", |model| model.name.as_str()).to_owned();
    let combo = egui::ComboBox::from_id_salt("bundled")
        .width(ui.available_width())
        .height(460.0)
        .selected_text(&name)
        .show_ui(ui, |ui| {
            for choice in BUNDLED {
                let entry = ui.selectable_label(choice == name, choice);
                state.controls.mark(choice, &entry);
                if entry.clicked() {
                    state.library.open(bundled(choice));
                }
            }
        });
    state.controls.mark("bundled", &combo.response);
    ui.horizontal(|ui| {
        let width = ui.available_width() - 58.0;
        let field = egui::TextEdit::singleline(&mut state.path.0)
            .hint_text("path of a mesh, or drop a file")
            .desired_width(width)
            .margin(egui::Margin::symmetric(8, 5));
        let field = ui.add(field);
        state.controls.mark("path", &field);
        let is_entered =
            field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        let open = ui.add_sized([ui.available_width(), 26.0], egui::Button::new("Open"));
        state.controls.mark("open", &open);
        if (is_entered || open.clicked()) && !state.path.0.trim().is_empty() {
            state.library.open(state.path.0.trim());
        }
    });
}

fn hulls_section(ui: &mut egui::Ui, state: &mut State) {
    heading(ui, "Hulls");
    let settings = state.settings.bypass_change_detection();
    let before = settings.clone();
    let controls = &mut state.controls;
    row(ui, "Bound", |ui| {
        let slider = egui::Slider::new(&mut settings.bound, BOUNDS)
            .logarithmic(true)
            .custom_formatter(|value, _| format!("{value:.2}"))
            .suffix(" %");
        let slider = ui.add(slider).on_hover_text(
            "No hull is farther than this outside of the mesh, and no part of the mesh farther \
             outside the hulls: in percent of the mesh's diagonal.",
        );
        controls.mark("bound", &slider);
    });
    row(ui, "Most hulls", |ui| {
        capped(
            ui,
            controls,
            ["cap hulls", "max hulls"],
            &mut settings.max_hulls,
            HULLS,
            FIRST_HULLS,
        );
    });
    row(ui, "Most vertices", |ui| {
        let cap = &mut settings.max_vertices;
        capped(ui, controls, ["cap vertices", "max vertices"], cap, VERTICES, FIRST_VERTICES);
    });
    row(ui, "Preset", |ui| {
        let presets = [Preset::Fast, Preset::Balanced, Preset::Fine];
        choice(ui, controls, &mut settings.preset, presets.map(|preset| (preset, preset.name())));
    });
    row(ui, "Openings", |ui| {
        let all = [Openings::Auto, Openings::Keep, Openings::Close];
        choice(
            ui,
            controls,
            &mut settings.openings,
            all.map(|openings| (openings, openings.name())),
        );
    });
    row(ui, "Cavities", |ui| {
        let keep = ui.checkbox(&mut settings.keep_cavities, "stay empty");
        controls.mark("cavities", &keep);
    });
    row(ui, "Probe", |ui| {
        let slider =
            egui::Slider::new(&mut settings.probe, PROBES).custom_formatter(
                |value, _| match value {
                    0.0 => "none".to_owned(),
                    value => format!("{value:.1} %"),
                },
            );
        let slider = ui.add(slider).on_hover_text(
            "The radius of what moves: gaps that no such ball enters may be filled. In percent of the \
             mesh's diagonal. A ball of it follows the pointer, and rests where it would.",
        );
        controls.mark("probe", &slider);
    });
    if settings.probe > 0.0 {
        row(ui, "Filled", |ui| {
            let filled =
                ui.checkbox(&mut state.show.bypass_change_detection().filled, "instead of hulls");
            controls.mark("filled", &filled);
        });
    }
    if *settings != before {
        state.settings.set_changed();
    }
}

fn view_section(ui: &mut egui::Ui, state: &mut State) {
    heading(ui, "View");
    let show = state.show.bypass_change_detection();
    let controls = &mut state.controls;
    row(ui, "Show", |ui| {
        for (name, shown) in
            [("hulls", &mut show.hulls), ("mesh", &mut show.mesh), ("edges", &mut show.edges)]
        {
            let toggle = ui.checkbox(shown, name);
            controls.mark(name, &toggle);
        }
    });
    row(ui, "Apart", |ui| {
        let slider = egui::Slider::new(&mut show.explosion, 0.0..=MOST_APART)
            .custom_formatter(|value, _| format!("{:.0} %", 100.0 * value));
        let slider = ui.add(slider);
        controls.mark("apart", &slider);
        if slider.changed() {
            show.trial = Trial::Look;
        }
    });
    row(ui, "Upwards", |ui| {
        choice(ui, controls, &mut show.z_up, [(false, "y up"), (true, "z up")]);
    });
}

fn trial_section(ui: &mut egui::Ui, state: &mut State) {
    heading(ui, "Try it");
    let trials = [
        (Trial::Look, "look"),
        (Trial::Drop, "drop"),
        (Trial::Hook, "hook"),
        (Trial::Stack, "stack ten"),
    ];
    let mut trial = state.show.trial;
    choice(ui, &mut state.controls, &mut trial, trials);
    if trial != state.show.trial {
        state.actions.write(Action::Try(trial));
    }
    ui.add_space(2.0);
    let buttons = [("throw balls", Action::Throw), ("again", Action::Again)];
    wide_buttons(ui, state, buttons);
}

fn export_section(ui: &mut egui::Ui, state: &mut State) {
    heading(ui, "Take it away");
    wide_buttons(
        ui,
        state,
        [("copy as Rust", Action::CopyRust), ("copy as extras", Action::CopyExtras)],
    );
    wide_buttons(ui, state, [("save .hulls", Action::SaveHulls), ("save .glb", Action::SaveGlb)]);
    ui.add_space(6.0);
    wide_buttons(ui, state, [("default settings", Action::Reset), ("keys  ?", Action::Help)]);
}

/// Two buttons of half the panel's width.
fn wide_buttons(ui: &mut egui::Ui, state: &mut State, buttons: [(&'static str, Action); 2]) {
    ui.horizontal(|ui| {
        let gap = ui.spacing().item_spacing.x;
        let width = (free_width(ui) - gap) / 2.0;
        for (name, action) in buttons {
            let button = wide_button(ui, name, width);
            state.controls.mark(name, &button);
            if button.clicked() {
                state.actions.write(action);
            }
        }
    });
}
