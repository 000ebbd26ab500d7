//! Less to draw for machines without a graphics card.

use bevy::light::{DirectionalLightShadowMap, ShadowFilteringMethod};
use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use wgpu_types::DeviceType;

use crate::picture::is_for_show;

/// Pixels along each side of the shadow map.
const SHADOW_MAP: usize = 1024;

/// Draws edges as they come and shadows without a soft rim, if the processor draws. Pictures of
/// `--screenshot` stay as they are.
pub fn draw_less(
    mut commands: Commands,
    adapter: Option<Res<RenderAdapterInfo>>,
    cameras: Query<Entity, With<Camera3d>>,
    mut shadows: ResMut<DirectionalLightShadowMap>,
) {
    let is_software = adapter.is_some_and(|adapter| adapter.device_type == DeviceType::Cpu);
    if !is_software || is_for_show() {
        return;
    }
    shadows.size = SHADOW_MAP;
    for camera in &cameras {
        commands.entity(camera).insert((Msaa::Off, ShadowFilteringMethod::Hardware2x2));
    }
}
