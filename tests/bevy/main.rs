//! What the Bevy plugin promises, without a window: `MinimalPlugins`, assets, Rapier and the plugin.

mod app;
#[cfg(feature = "bevy_gltf")]
mod artists;
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
#[cfg(all(feature = "bevy_gltf", feature = "serde"))]
mod skein;
mod static_geometry;
mod tags;
mod waiting;
