//! Names and glTF extras that give meshes colliders: Godot 4's suffixes, our `-convdecomp` beside
//! them, Unreal's prefixes, and `{"collider": "convex_decomposition"}`. The Bevy plugin and
//! `hullwright bake` follow the same rules.
//!
//! [`HullsRecord`] is what a glTF file says of hulls that `hullwright bake --into` wrote there.

#[cfg(feature = "extras")]
mod extras;
#[cfg(feature = "extras")]
mod hulls_record;
mod names;

#[cfg(feature = "extras")]
pub use extras::{Body, Complaint, ExtrasTag, Fallback, read_extras};
#[cfg(feature = "extras")]
pub use hulls_record::{HullsRecord, ReadBack, WrittenHull, hull_digest};
pub use names::{
    ColliderKind, NameTag, is_coarser_level, level_of_detail, mesh_tag, node_tag, whole_of,
    without_copy_number,
};
