//! Readers and writers of mesh files (feature `io`).
//!
//! | format | read by |
//! |---|---|
//! | glTF, GLB | crate `gltf` for the container and the JSON; buffers, accessors and nodes are walked here, since its own readers panic on hostile files |
//! | Draco in glTF | crate `draco-core`, the decoder alone |
//! | meshopt in glTF | crate `meshoptimizer-rs`, its codecs and filters |
//! | PLY | crate `ply-rs-bw` for the header and binary elements; text elements here, since it refuses numbers such as `.5` and `nan` |
//! | OBJ | this module: `tobj` refuses sound files, makes faces of polylines and says no line in its errors |
//! | OFF | this module: `off-rs` holds `f32` and reads one form of header |
//! | STL | this module: `stl_io` holds `f32`, drops all solids but the first, and goes by the first word alone |
//!
//! All readers keep three promises on any input: no panic, no allocation beyond what the
//! file's size justifies, whatever its counts say, and errors that say what is wrong and where.
//! Coordinates that are written as text keep their full `f64` precision, and `nan` and `inf` are
//! let through, since repair counts and drops them. Points and lines are left out. Polygons,
//! concave ones too, are triangulated by ear clipping and Delaunay refinement (crate `earcut`);
//! those without an inside become fans.

mod draco;
mod gltf;
mod gltf_data;
mod mesh_file;
mod meshopt;
mod obj;
mod off;
pub mod palette;
mod ply;
mod read;
mod stl;
mod text;
mod write;

pub use mesh_file::{
    Format, HullFormat, MeshFile, NamedMesh, Object, SceneMesh, SceneNode, is_hulls_file,
};
pub use read::{
    read_hulls, read_mesh, read_mesh_from_bytes, read_own_meshes, read_scene, read_scene_from_bytes,
};
pub use write::{check_output, write_file, write_hulls};
