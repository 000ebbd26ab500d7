//! A line of text at the foot of the window: what is seen, and which keys there are.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass, egui};

/// Keys that every demo has.
const KEYS: &str = "H  hulls      G  the plugin's debug lines      drag  turn      wheel  nearer";

/// Pixels from the window's left and lower edge.
const MARGIN: f32 = 28.0;

/// What is seen.
#[derive(Resource, Clone, Copy)]
pub struct Caption(pub &'static str);

impl Plugin for Caption {
    fn build(&self, app: &mut App) {
        app.insert_resource(*self).add_systems(EguiPrimaryContextPass, draw);
    }
}

fn draw(mut contexts: EguiContexts, caption: Res<Caption>) -> Result {
    let context = contexts.ctx_mut()?;
    egui::Area::new("caption".into())
        .anchor(egui::Align2::LEFT_BOTTOM, [MARGIN, -MARGIN])
        .interactable(false)
        .show(context, |ui| {
            ui.spacing_mut().item_spacing.y = 6.0;
            let ink = egui::Color32::from_rgb(42, 44, 48);
            let line = |text: &str, size: f32| egui::RichText::new(text).size(size).color(ink);
            let wide = egui::TextWrapMode::Extend;
            ui.add(egui::Label::new(line(caption.0, 21.0)).wrap_mode(wide));
            ui.add(egui::Label::new(line(KEYS, 14.0).weak()).wrap_mode(wide));
        });
    Ok(())
}
