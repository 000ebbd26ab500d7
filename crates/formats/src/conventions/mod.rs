//! Names and glTF extras that give meshes colliders: Godot 4's suffixes, our `-convdecomp` beside
//! them, Unreal's prefixes, `{"collider": "convex_decomposition"}`, and glTF's physics
//! extensions. The Bevy plugin and `hullwright bake` follow the same rules.
//!
//! [`HullsRecord`] is what a glTF file says of hulls that `hullwright bake --into` wrote there.

#[cfg(feature = "extras")]
mod extras;
#[cfg(feature = "extras")]
mod hulls_record;
mod levels;
mod names;
#[cfg(feature = "extras")]
mod physics;
#[cfg(feature = "extras")]
mod surface;
#[cfg(feature = "extras")]
mod values;

#[cfg(feature = "extras")]
pub use extras::{Body, ExtrasTag, Fallback, read_extras};
#[cfg(feature = "extras")]
pub use hulls_record::{HullsRecord, ReadBack, WrittenHull, hull_digest};
pub use levels::level_cell;
pub use names::{
    ColliderKind, NameTag, is_coarser_level, level_of_detail, mesh_tag, node_tag, whole_of,
    without_copy_number,
};
#[cfg(feature = "extras")]
pub use physics::{
    BodyMotion, CollisionFilter, DeclaredCollider, Geometry, ImplicitShape, NodePhysics,
    PHYSICS_EXTENSIONS, PhysicsError, PhysicsExtensions,
};
#[cfg(feature = "extras")]
pub use surface::{CombineRule, Events, Groups, SurfaceProperties, read_surface};
#[cfg(feature = "extras")]
pub use values::Complaint;
