//! What the Bevy plugin promises, without a window: `MinimalPlugins`, assets, Rapier and the plugin.

mod app;
#[cfg(feature = "bevy_gltf")]
mod artists;
mod baked;
#[cfg(feature = "bevy_gltf")]
mod baked_scenes;
mod contacts;
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
mod load;
mod log;
mod meshes;
mod order;
mod progress;
mod scale;
mod scenes;
mod sharing;
#[cfg(all(feature = "bevy_gltf", feature = "serde"))]
mod skein;
mod skipping;
mod static_geometry;
mod streaming;
mod tags;
mod waiting;
