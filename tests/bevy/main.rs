//! What the Bevy plugin promises, without a window: `MinimalPlugins`, assets, Rapier and the plugin.

mod app;
mod baked;
#[cfg(feature = "bevy_gltf")]
mod baked_scenes;
#[cfg(feature = "debug")]
mod debug;
mod docs;
mod endings;
mod failures;
mod fallback;
mod falling;
mod freeze;
#[cfg(feature = "bevy_gltf")]
mod gltf;
mod log;
mod meshes;
mod order;
mod progress;
mod scale;
mod scenes;
mod sharing;
mod skipping;
mod streaming;
mod tags;
mod waiting;
