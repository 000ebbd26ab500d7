//! What the Bevy plugin promises, without a window: `MinimalPlugins`, assets, Rapier and the plugin.

mod app;
mod baked;
mod falling;
#[cfg(feature = "bevy_gltf")]
mod gltf;
mod meanwhile;
mod meshes;
mod order;
mod scale;
mod scenes;
mod sharing;
mod waiting;
