//! What the Bevy plugin promises, without a window: `MinimalPlugins`, assets, Rapier and the plugin.

mod app;
mod baked;
mod falling;
mod meanwhile;
mod meshes;
mod order;
mod scale;
mod scenes;
mod sharing;
mod waiting;
