//! Mesh files for [Hullwright](hullwright): read and written, and whole scenes whose hulls are
//! baked.
//!
//! ```
//! use hullwright::{Control, Parameters, decompose};
//!
//! let mug = hullwright_formats::read_mesh("../../assets/mug.glb")?;
//! let made = decompose(&mug.mesh, &Parameters::default(), &Control::new())?;
//! let bytes = hullwright_formats::hulls_to_bytes(hullwright_formats::HullFormat::Obj, &made.hulls)?;
//! assert!(bytes.starts_with(b"o hull_0"));
//! # Ok::<(), hullwright::Error>(())
//! ```
//!
//! | you have | you want | use |
//! |---|---|---|
//! | OBJ, OFF, PLY, STL, glTF, GLB | a mesh; its parts; the meshes of a scene | [`read_mesh`]; [`read_own_meshes`]; [`read_scene`] |
//! | bytes, from a stranger or in a browser | the same, without opening other files | [`read_mesh_from_bytes`], [`read_scene_from_bytes`] |
//! | a mesh of several materials, and its hulls | what each hull is made of | [`MeshParts::shares`] |
//! | hulls of any tool in a file | the hulls | [`read_hulls`] |
//! | hulls | OBJ or GLB with a colour per hull | [`write_hulls`], [`hulls_to_bytes`] |
//! | meshes | OBJ, OFF, PLY, STL or GLB | [`write_meshes`] |
//! | bytes | a file, all or nothing | [`write_file`] |
//! | a scene | the hulls of all its meshes in one file | [`bake`] |
//! | a scene | few triangles of what never moves | [`bake_surfaces`] |
//! | a glTF file | the hulls of its meshes in the file itself | [`gltf_hulls`] |
//! | names and extras of a glTF file | the colliders that they stand for | [`conventions`] |
//!
//! `.hulls` and `.hullscene` files are read and written as bytes by [`hullwright::hulls_format`].
//!
//! # Features
//!
//! | feature | what it adds |
//! |---|---|
//! | `meshes` (default) | readers and writers of mesh files, and baking; without it [`write_file`] and names are left |
//! | `extras` (in `meshes`) | extras of glTF files: those of artists, and those of hulls in the file |

#![cfg_attr(docsrs, feature(doc_cfg))]

mod atomic_write;
#[cfg(feature = "meshes")]
pub mod bake;
#[cfg(feature = "meshes")]
pub mod bake_surfaces;
pub mod conventions;
#[cfg(feature = "meshes")]
mod gltf;
#[cfg(feature = "meshes")]
mod gltf_data;
#[cfg(feature = "meshes")]
mod gltf_extensions;
#[cfg(feature = "meshes")]
mod gltf_groups;
#[cfg(feature = "meshes")]
pub mod gltf_hulls;
#[cfg(feature = "meshes")]
mod gltf_json;
#[cfg(feature = "meshes")]
mod gltf_nodes;
#[cfg(feature = "meshes")]
mod gltf_skins;
#[cfg(feature = "meshes")]
mod gltf_tree;
#[cfg(feature = "extras")]
mod hulls_extras;
#[cfg(feature = "meshes")]
mod mesh_file;
#[cfg(feature = "meshes")]
mod notes;
#[cfg(feature = "meshes")]
mod obj;
#[cfg(feature = "meshes")]
mod off;
#[cfg(feature = "meshes")]
pub mod palette;
#[cfg(feature = "meshes")]
mod ply;
#[cfg(feature = "meshes")]
mod ply_header;
#[cfg(feature = "meshes")]
mod read;
#[cfg(feature = "meshes")]
mod stl;
#[cfg(feature = "meshes")]
mod text;
#[cfg(feature = "meshes")]
mod vector;
#[cfg(feature = "meshes")]
mod write;
#[cfg(feature = "meshes")]
mod write_meshes;

pub use atomic_write::write_file;
#[cfg(feature = "meshes")]
pub use mesh_file::{
    Format, HullFormat, MeshFile, MeshParts, NamedMesh, Object, SceneMesh, SceneNode,
    is_hulls_file, is_mesh_output, mesh_suffix_list,
};
#[cfg(feature = "meshes")]
pub use notes::{Note, NoteKind, sum_notes};
#[cfg(feature = "meshes")]
pub use read::{
    read_hulls, read_mesh, read_mesh_from_bytes, read_mesh_from_files, read_own_meshes, read_scene,
    read_scene_from_bytes,
};
#[cfg(feature = "meshes")]
pub use write::{check_output, hulls_to_bytes, write_hulls};
#[cfg(feature = "meshes")]
pub use write_meshes::{check_mesh_output, write_meshes};

/// The examples of the README run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
