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
mod failures;
mod freeze;
#[cfg(feature = "bevy_gltf")]
mod gltf;
mod load;
mod meshes;
mod order;
mod scale;
mod scenes;
mod sharing;
#[cfg(all(feature = "bevy_gltf", feature = "serde"))]
mod skein;
mod skipping;
mod tags;
mod waiting;
