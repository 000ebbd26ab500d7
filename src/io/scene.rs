//! The meshes of a file one by one, with all that artists say of them: names and extras.

use std::path::Path;

use super::{Format, MeshFile, gltf, read_mesh, split_objects, unmarked};
use crate::error::Error;
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

/// Reads the meshes of a scene one by one, each in the space that it was modelled in.
///
/// Of a glTF file, each mesh that holds triangles, whether a node shows it or not. A file of another
/// format is one mesh, named after the file, that no node shows.
///
/// # Errors
/// As [`read_mesh`].
///
/// ```
/// let meshes = hullwright::io::read_scene("assets/props.glb")?;
/// let nodes: Vec<&str> =
///     meshes.iter().flat_map(|mesh| &mesh.nodes).map(|node| node.name.as_str()).collect();
/// assert!(nodes.contains(&"mug-convdecomp"));
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn read_scene(path: impl AsRef<Path>) -> Result<Vec<SceneMesh>, Error> {
    let path = path.as_ref();
    if Format::from_path(path) == Some(Format::Gltf) {
        let bytes = std::fs::read(path).map_err(|error| Error::file(path, error))?;
        return gltf::read_scene(unmarked(&bytes), path.parent())
            .map_err(|reason| Error::file(path, reason));
    }
    let MeshFile { mesh, .. } = read_mesh(path)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(vec![SceneMesh { name, mesh, extras: None, nodes: Vec::new() }])
}

/// Reads the meshes of a glTF or GLB file that is already in memory, as [`read_scene`].
///
/// # Errors
/// As [`read_mesh`]; a file that names buffers in other files is an error too.
pub fn read_scene_from_bytes(bytes: &[u8]) -> Result<Vec<SceneMesh>, Error> {
    gltf::read_scene(unmarked(bytes), None)
        .map_err(|reason| Error::file(Path::new("glTF in memory"), reason))
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
