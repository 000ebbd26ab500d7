//! What the Bevy plugin promises, without a window: `MinimalPlugins`, assets, Rapier and the plugin.

mod app;
mod baked;
mod contacts;
#[cfg(feature = "debug")]
mod debug;
mod endings;
mod failures;
mod fallback;
mod falling;
mod freeze;
#[cfg(feature = "bevy_gltf")]
mod gltf;
mod load;
mod log;
mod meshes;
mod order;
mod scale;
mod scenes;
mod sharing;
mod tags;
mod waiting;
