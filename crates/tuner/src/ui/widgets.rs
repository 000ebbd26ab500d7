//! Rows, headings and choices of the panel, and where each control is.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use bevy::prelude::Resource;
use bevy_egui::egui;

use super::style;

/// Width of a row's name, and of a cap's checkbox, in pixels.
const NAME: f32 = 94.0;

/// Width of the number beside a slider.
const NUMBER: f32 = 58.0;

/// Where each control is on the screen, by its name: what a tour without a person clicks on.
#[derive(Resource, Default)]
pub struct Controls(HashMap<&'static str, egui::Rect>);

impl Controls {
    /// Forgets those of the frame before.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Notes where a control is.
    pub fn mark(&mut self, name: &'static str, response: &egui::Response) {
        self.0.insert(name, response.rect);
    }

    /// Where a control is.
    pub fn get(&self, name: &str) -> Option<egui::Rect> {
        self.0.get(name).copied()
    }
}

/// The name of a section.
pub fn heading(ui: &mut egui::Ui, text: &str) {
    ui.add_space(12.0);
    let text = egui::RichText::new(text.to_uppercase()).size(11.0).extra_letter_spacing(1.2);
    ui.label(text.color(style::QUIET));
    ui.add_space(2.0);
}

/// A name, and controls to the right of it.
pub fn row(ui: &mut egui::Ui, name: &str, add: impl FnOnce(&mut egui::Ui)) {
    ui.horizontal(|ui| {
        let (place, _) = ui.allocate_exact_size(egui::vec2(NAME, 24.0), egui::Sense::hover());
        let font = egui::FontId::proportional(14.0);
        let left = egui::Align2::LEFT_CENTER;
        ui.painter().text(place.left_center(), left, name, font, style::TEXT);
        ui.spacing_mut().slider_width = ui.available_width() - NUMBER - ui.spacing().item_spacing.x;
        add(ui);
    });
}

/// A cap that can be switched off.
pub fn capped(
    ui: &mut egui::Ui,
    controls: &mut super::Controls,
    [switch, slider]: [&'static str; 2],
    cap: &mut Option<usize>,
    range: RangeInclusive<usize>,
    first: usize,
) {
    let mut is_capped = cap.is_some();
    let name = if is_capped { "" } else { "no cap" };
    let toggle = ui.checkbox(&mut is_capped, name);
    controls.mark(switch, &toggle);
    if toggle.changed() {
        *cap = is_capped.then_some(first);
    }
    if let Some(most) = cap {
        let spacing = ui.spacing().item_spacing.x;
        ui.spacing_mut().slider_width = ui.available_width() - NUMBER - spacing;
        let slide = ui.add(egui::Slider::new(most, range).logarithmic(true));
        controls.mark(slider, &slide);
    }
}

/// One of several, side by side.
pub fn choice<T: PartialEq + Copy, const N: usize>(
    ui: &mut egui::Ui,
    controls: &mut super::Controls,
    value: &mut T,
    choices: [(T, &'static str); N],
) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        // The longest name fits into a third.
        ui.spacing_mut().button_padding.x = 2.0;
        let width = (free_width(ui) - 3.0 * (N - 1) as f32) / N as f32;
        for (choice, name) in choices {
            let is_chosen = *value == choice;
            let (fill, ink) = if is_chosen {
                (style::ACCENT, style::ON_ACCENT)
            } else {
                (style::BUTTON, style::TEXT)
            };
            let text = egui::RichText::new(name).color(ink).size(13.0);
            let button = ui.add_sized([width, 25.0], egui::Button::new(text).fill(fill));
            controls.mark(name, &button);
            if button.clicked() {
                *value = choice;
            }
        }
    });
}

/// Pixels from the cursor to the right edge of the panel's content.
pub fn free_width(ui: &egui::Ui) -> f32 {
    super::PANEL - style::PANEL_MARGIN - 1.0 - ui.cursor().left()
}

/// A button of a given width.
pub fn wide_button(ui: &mut egui::Ui, name: &str, width: f32) -> egui::Response {
    let text = egui::RichText::new(name).size(13.5);
    ui.add_sized([width, 27.0], egui::Button::new(text))
}
