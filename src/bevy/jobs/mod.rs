//! From requests to shapes, in the background, and what is known already.

pub(crate) mod baked;
pub(crate) mod baked_scene;
pub(crate) mod budget;
pub(crate) mod cache;
pub(crate) mod content;
pub(crate) mod convert;
pub(crate) mod disk_cache;
pub(crate) mod finish;
pub(crate) mod mesh_data;
pub(crate) mod pool;
pub(crate) mod primitive;
pub(crate) mod priority;
pub(crate) mod queue;
pub(crate) mod request;
pub(crate) mod scene_processor;
#[cfg(feature = "io")]
pub(crate) mod scene_recipe;
pub(crate) mod start;
pub(crate) mod task;
