//! What the Bevy plugin promises with Avian: the tests of `main.rs`.

mod app;
#[cfg(feature = "bevy_gltf")]
mod artists;
mod avian_only;
mod baked;
#[cfg(feature = "bevy_gltf")]
mod baked_scenes;
mod cells;
mod changes;
mod children;
mod contacts;
#[cfg(feature = "debug")]
mod debug;
mod docs;
mod endings;
#[path = "engine_avian.rs"]
mod engine;
mod failures;
mod fragments;
mod freeze;
#[cfg(feature = "bevy_gltf")]
mod gltf;
#[cfg(feature = "bevy_gltf")]
mod levels;
mod load;
mod meshes;
mod order;
mod parts;
#[cfg(feature = "bevy_gltf")]
mod physics;
#[cfg(feature = "bevy_gltf")]
mod pieces;
mod scale;
mod scenes;
mod sharing;
#[cfg(all(feature = "bevy_gltf", feature = "serde"))]
mod skein;
mod skipping;
#[cfg(feature = "bevy_gltf")]
mod surfaces;
mod tags;
mod waiting;
#[cfg(feature = "bevy_gltf")]
mod written;
