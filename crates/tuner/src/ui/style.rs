//! Colours and sizes: dark, quiet, one accent.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};
use egui::Color32;

/// The panel, and what lies on the picture.
pub const PANEL: Color32 = Color32::from_rgb(27, 29, 34);
/// Buttons, rails and fields.
pub const BUTTON: Color32 = Color32::from_rgb(44, 48, 56);
/// The same under the pointer.
const HOVERED: Color32 = Color32::from_rgb(58, 63, 73);
/// What is written.
pub const TEXT: Color32 = Color32::from_rgb(214, 218, 225);
/// What is written beside it.
pub const QUIET: Color32 = Color32::from_rgb(138, 146, 160);
/// What is chosen.
pub const ACCENT: Color32 = Color32::from_rgb(96, 165, 230);
/// What is written on it.
pub const ON_ACCENT: Color32 = Color32::from_rgb(14, 24, 36);
/// What went wrong.
pub const WRONG: Color32 = Color32::from_rgb(240, 138, 108);
/// What went well.
pub const WELL: Color32 = Color32::from_rgb(134, 204, 150);

/// Corners of everything, in pixels.
const CORNER: u8 = 5;

/// Pixels between the panel's edges and what is on it.
pub const PANEL_MARGIN: f32 = 16.0;

/// The frame of the panel.
pub fn panel_frame() -> egui::Frame {
    egui::Frame::new().fill(PANEL).inner_margin(egui::Margin::symmetric(PANEL_MARGIN as i8, 8))
}

/// The frame of what lies on the picture.
pub fn card() -> egui::Frame {
    egui::Frame::new()
        .fill(PANEL.gamma_multiply(0.94))
        .corner_radius(8)
        .inner_margin(egui::Margin::symmetric(18, 12))
}

/// Once, at the start.
pub fn set_style(mut contexts: EguiContexts) -> Result {
    let context = contexts.ctx_mut()?;
    context.set_theme(egui::Theme::Dark);
    // However slowly frames are drawn, a click is a click.
    context.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
    context.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(7.0, 6.0);
        style.spacing.interact_size.y = 24.0;
        style.spacing.button_padding = egui::vec2(8.0, 4.0);
        style.spacing.slider_rail_height = 5.0;
        style.spacing.icon_width = 17.0;
        let visuals = &mut style.visuals;
        visuals.override_text_color = None;
        visuals.panel_fill = PANEL;
        visuals.window_fill = PANEL;
        visuals.extreme_bg_color = Color32::from_rgb(18, 20, 24);
        visuals.slider_trailing_fill = true;
        visuals.selection.bg_fill = ACCENT;
        visuals.selection.stroke.color = ON_ACCENT;
        let widgets = &mut visuals.widgets;
        widgets.noninteractive.fg_stroke.color = TEXT;
        let states = [
            (&mut widgets.inactive, BUTTON, TEXT),
            (&mut widgets.hovered, HOVERED, Color32::WHITE),
            (&mut widgets.active, HOVERED, Color32::WHITE),
            (&mut widgets.open, HOVERED, Color32::WHITE),
        ];
        for (widget, fill, ink) in states {
            widget.bg_fill = fill;
            widget.weak_bg_fill = fill;
            widget.bg_stroke = egui::Stroke::NONE;
            widget.fg_stroke = egui::Stroke::new(1.2, ink);
            widget.corner_radius = CORNER.into();
            widget.expansion = 0.0;
        }
    });
    Ok(())
}
