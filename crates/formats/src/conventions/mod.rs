//! Names and glTF extras that give meshes colliders: Godot 4's suffixes, our `-convdecomp` beside
//! them, Unreal's prefixes, and `{"collider": "convex_decomposition"}`. The Bevy plugin and
//! `hullwright bake` follow the same rules.

#[cfg(feature = "extras")]
mod extras;
mod names;

#[cfg(feature = "extras")]
pub use extras::{Body, Complaint, ExtrasTag, Fallback, read_extras};
pub use names::{
    ColliderKind, NameTag, is_coarser_level, level_of_detail, mesh_tag, node_tag, whole_of,
    without_copy_number,
};
