//! Reads the meshes of a file one by one, with all that artists say of them.

use std::path::Path;

use super::scene_mesh::SceneMesh;
use super::{Format, MeshFile, gltf, read_mesh, unmarked};
use crate::error::Error;

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
