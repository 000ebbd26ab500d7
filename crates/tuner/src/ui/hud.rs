//! What lies on the picture: numbers, messages, keys.

use std::sync::Arc;

use bevy_egui::egui;

use super::style;
use crate::action::KEYS;
use crate::decompose::{Fit, Tuning};
use crate::model::Model;
use crate::scene::Trial;

/// Pixels from the edges of the picture.
const MARGIN: f32 = 20.0;

/// Jobs that take less than this, in seconds, show no progress: it would only flicker.
const SLOW: f32 = 0.25;

/// The numbers of the hulls that are shown.
pub fn draw_numbers(
    context: &egui::Context,
    free: egui::Rect,
    model: Option<&Model>,
    fit: Option<&Fit>,
    tuning: &Tuning,
) {
    let Some(model) = model else { return };
    area("numbers", egui::Align2::LEFT_TOP, free.left_top() + egui::vec2(MARGIN, MARGIN)).show(
        context,
        |ui| {
            style::card().show(ui, |ui| {
                ui.spacing_mut().item_spacing = egui::vec2(26.0, 2.0);
                ui.horizontal(|ui| {
                    for (value, name) in numbers(model, fit) {
                        number(ui, &value, name);
                    }
                });
                if let Some((done, seconds)) = tuning.progress().filter(|(_, time)| *time > SLOW) {
                    progress(ui, done, seconds);
                }
            });
        },
    );
}

fn numbers(model: &Model, fit: Option<&Fit>) -> Vec<(String, &'static str)> {
    let mut numbers = vec![(grouped(model.mesh.triangles.len()), "triangles")];
    let Some(fit) = fit else { return numbers };
    let [protrusion, uncovered] = fit.errors();
    let time = if fit.seconds < 1.0 {
        format!("{:.0} ms", 1000.0 * fit.seconds)
    } else {
        format!("{:.1} s", fit.seconds)
    };
    numbers.extend([
        (fit.decomposition.hulls.len().to_string(), "hulls"),
        (grouped(fit.vertices()), "vertices"),
        (format!("{protrusion:.2} %"), "protrusion at most"),
        (format!("{uncovered:.2} %"), "uncovered at most"),
        (time, "time"),
    ]);
    numbers
}

fn number(ui: &mut egui::Ui, value: &str, name: &str) {
    ui.vertical(|ui| {
        let value = egui::RichText::new(value).size(21.0).color(egui::Color32::WHITE);
        ui.add(egui::Label::new(value).wrap_mode(egui::TextWrapMode::Extend));
        let name = egui::RichText::new(name).size(12.0).color(style::QUIET);
        ui.add(egui::Label::new(name).wrap_mode(egui::TextWrapMode::Extend));
    });
}

fn progress(ui: &mut egui::Ui, done: f32, seconds: f32) {
    let (place, _) =
        ui.allocate_exact_size(egui::vec2(ui.min_rect().width(), 16.0), egui::Sense::hover());
    let rail =
        egui::Rect::from_min_size(place.left_center(), egui::vec2(place.width() - 60.0, 4.0));
    let filled = egui::Rect::from_min_size(rail.min, egui::vec2(done * rail.width(), 4.0));
    ui.painter().rect_filled(rail, 2.0, style::BUTTON);
    ui.painter().rect_filled(filled, 2.0, style::ACCENT);
    let text = format!("{seconds:.1} s");
    let font = egui::FontId::proportional(12.0);
    let right = egui::Align2::RIGHT_CENTER;
    ui.painter().text(place.right_center(), right, text, font, style::QUIET);
}

/// What was done last, what went wrong, and how the hook is used.
pub fn draw_message(
    context: &egui::Context,
    free: egui::Rect,
    done: &Result<String, String>,
    error: Option<&String>,
    trial: Trial,
    model: Option<&Arc<Model>>,
) {
    let (text, colour) = match (error, done) {
        (Some(error), _) | (None, Err(error)) => (error.as_str(), style::WRONG),
        (None, Ok(done)) if !done.is_empty() => (done.as_str(), style::WELL),
        _ => (hint(trial, model.map(AsRef::as_ref)), style::QUIET),
    };
    area("message", egui::Align2::LEFT_BOTTOM, free.left_bottom() + egui::vec2(MARGIN, -MARGIN))
        .show(context, |ui| {
            style::card().show(ui, |ui| {
                ui.set_max_width(free.width() - 4.0 * MARGIN);
                ui.label(egui::RichText::new(text).size(14.0).color(colour));
            });
        });
}

fn hint(trial: Trial, model: Option<&Model>) -> &'static str {
    match (trial, model.map(|model| model.hang)) {
        (Trial::Hook, Some(hang)) if hang.is_hole => {
            "It hangs by its widest hole, while the hulls leave it open: try a larger bound."
        }
        (Trial::Hook, Some(hang)) if hang.clearance > 0.0 => {
            "It has no hole, and hangs by a notch."
        }
        (Trial::Hook, _) => "It has no hole and no notch: it is laid on the hook.",
        (Trial::Drop, _) => "It falls as its hulls: r to try again, b to throw balls.",
        (Trial::Stack, _) => "Ten of it share one collider: b to throw balls.",
        (Trial::Look, _) => {
            "Drag to turn, wheel to come nearer, x for hulls apart, ? for all keys."
        }
    }
}

/// While a file is held over the window.
pub fn draw_drop_hint(context: &egui::Context, free: egui::Rect) {
    if context.input(|input| input.raw.hovered_files.is_empty()) {
        return;
    }
    area("drop", egui::Align2::CENTER_CENTER, free.center()).show(context, |ui| {
        style::card().show(ui, |ui| {
            ui.label(egui::RichText::new("Drop it to open it").size(20.0).color(style::TEXT));
        });
    });
}

/// The list of keys.
pub fn draw_help(context: &egui::Context, free: egui::Rect) {
    area("keys", egui::Align2::CENTER_CENTER, free.center()).show(context, |ui| {
        style::card().show(ui, |ui| {
            ui.label(egui::RichText::new("Keys").size(18.0).color(egui::Color32::WHITE));
            ui.add_space(6.0);
            egui::Grid::new("keys").spacing([16.0, 5.0]).show(ui, |ui| {
                let (left, right) = KEYS.split_at(KEYS.len().div_ceil(2));
                for row in 0..left.len() {
                    for side in [left, right] {
                        let Some((cap, what, _)) = side.get(row) else { continue };
                        let cap = format!(" {} ", cap.to_uppercase());
                        let cap = egui::RichText::new(cap).monospace().size(13.0);
                        ui.label(cap.background_color(style::BUTTON).color(egui::Color32::WHITE));
                        let what = egui::RichText::new(*what).size(14.0).color(style::TEXT);
                        ui.add(egui::Label::new(what).wrap_mode(egui::TextWrapMode::Extend));
                    }
                    ui.end_row();
                }
            });
        });
    });
}

fn area(name: &'static str, pivot: egui::Align2, place: egui::Pos2) -> egui::Area {
    egui::Area::new(name.into()).pivot(pivot).fixed_pos(place).interactable(false)
}

/// A number with a thin space between thousands.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}
