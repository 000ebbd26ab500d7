//! A mesh of a scene, with all that artists say of it: names and extras.

use super::{MeshFile, split_objects};
use crate::geometry::TriangleMesh;

/// A mesh of a scene, in the space that it was modelled in.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct SceneMesh {
    /// Its name; `mesh_` and its index where it has none.
    pub name: String,
    /// All its primitives together, each vertex used by a triangle.
    pub mesh: TriangleMesh,
    /// Its extras: custom properties, as JSON.
    pub extras: Option<String>,
    /// The nodes that show it, in the file's order, of all scenes.
    pub nodes: Vec<SceneNode>,
}

/// A node that shows a mesh.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SceneNode {
    /// Its name; may be empty.
    pub name: String,
    /// Its extras: custom properties, as JSON.
    pub extras: Option<String>,
}

/// The meshes of a file whose objects are the meshes with these indices and extras.
pub(super) fn scene_meshes(
    file: &MeshFile,
    of_objects: Vec<(Option<String>, Vec<SceneNode>)>,
) -> Vec<SceneMesh> {
    let meshes = split_objects(file).into_iter().zip(of_objects);
    meshes
        .map(|(named, (extras, nodes))| SceneMesh {
            name: named.name,
            mesh: named.mesh,
            extras,
            nodes,
        })
        .collect()
}
