//! Readers and writers of mesh files (feature `io`).
//!
//! | format | read by |
//! |---|---|
//! | glTF, GLB | crate `gltf` for the container and the JSON; buffers, accessors and nodes are walked here, since its own readers panic on hostile files |
//! | Draco in glTF | crate `draco-core`, the decoder alone |
//! | meshopt in glTF | crate `meshoptimizer-rs`, its codecs and filters |
//! | PLY | crate `ply-rs-bw` for the header and binary elements; text elements here, since it refuses numbers such as `.5` and `nan` |
//! | OBJ | this module: `tobj` refuses sound files, makes faces of polylines and says no line in its errors |
//! | OFF | this module: `off-rs` holds `f32` and knows one form of header |
//! | STL | this module: `stl_io` holds `f32`, drops all solids but the first, and goes by the first word alone |
//!
//! All readers keep three promises on any input: no panic, no allocation that a count in the file
//! asks for and the file's size does not justify, and errors that say what is wrong and where.
//! Coordinates that are written as text keep their full `f64` precision, and `nan` and `inf` are
//! let through, since repair counts and drops them. Points and lines are left out. Polygons,
//! concave ones too, are triangulated by ear clipping and Delaunay refinement (crate `earcut`);
//! those without an inside become fans.

mod accessor;
mod buffers;
mod draco;
mod extension;
mod format;
mod gltf;
mod meshopt;
mod obj;
mod off;
mod ply;
mod polygon;
mod scene;
mod scene_mesh;
mod stl;
mod text;
mod transform;
mod views;
mod write;
mod write_glb;
mod write_obj;

use std::ops::Range;
use std::path::Path;

pub use format::{Format, HullFormat};
pub use scene::{read_scene, read_scene_from_bytes};
pub use scene_mesh::{SceneMesh, SceneNode};
pub use write::{check_output, write_hulls};

use crate::error::{Error, FileError};
use crate::geometry::{MeshView, TriangleMesh};
use crate::hulls_format::HullsFile;

/// A named part of a mesh file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Object {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// Its part of the triangles of [`MeshFile::mesh`]; not empty.
    pub triangles: Range<usize>,
}

/// What a mesh file holds, in its own units, neither welded nor repaired.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshFile {
    /// All vertices and triangles. A coordinate may be infinite or not a number if the file says so;
    /// each index is below the number of positions.
    pub mesh: TriangleMesh,
    /// The parts that hold triangles, in the file's order, which together hold all triangles: the
    /// objects of an OBJ (its groups, where it has no object), the solids of an STL, the nodes
    /// with a mesh of a glTF scene. A file of another format is a single part.
    pub objects: Vec<Object>,
}

impl<'a> From<&'a MeshFile> for MeshView<'a> {
    fn from(file: &'a MeshFile) -> Self {
        file.mesh.view()
    }
}

impl MeshFile {
    /// Ends an object whose triangles began at `start`; one without triangles is left out.
    fn close_object(&mut self, name: impl Into<String>, start: usize) {
        let triangles = start..self.mesh.triangles.len();
        if !triangles.is_empty() {
            let name = name.into();
            self.objects.push(Object { name, triangles });
        }
    }
}

/// A mesh, or a hull of a hull set, by itself, in the file's units.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedMesh {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// Vertices, each of which is used by a triangle, and triangles as the file winds them.
    pub mesh: TriangleMesh,
}

impl<'a> From<&'a NamedMesh> for MeshView<'a> {
    fn from(named: &'a NamedMesh) -> Self {
        named.mesh.view()
    }
}

/// Reads a mesh file; its suffix names the format.
///
/// Of a glTF file all meshes of the default scene are read (of all scenes where none is the
/// default, of all nodes where there is no scene) with the nodes' transforms applied. Skins and
/// morph targets are not: a mesh stands as it was modelled. Geometry may be quantised
/// (`KHR_mesh_quantization`) and compressed (`KHR_draco_mesh_compression`,
/// `EXT_meshopt_compression`, `KHR_meshopt_compression`).
///
/// A glTF file may name other files beside it. Of files that strangers send, hand over the bytes:
/// [`read_mesh_from_bytes`] opens no other file.
///
/// A file may be fine and hold no triangles, such as a point cloud.
///
/// # Errors
/// [`Error::File`] if the suffix is that of no [`Format`], if the file can't be read, or if it does
/// not hold what it should.
///
/// ```
/// let file = hullwright::io::read_mesh("assets/mug.glb")?;
/// assert_eq!(file.mesh.triangles.len(), 1020);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn read_mesh(path: impl AsRef<Path>) -> Result<MeshFile, Error> {
    let path = path.as_ref();
    read_mesh_file(path).map_err(|source| Error::file(path, source))
}

fn read_mesh_file(path: &Path) -> Result<MeshFile, FileError> {
    let Some(format) = Format::from_path(path) else {
        return Err(format!("its suffix is not {}", Format::suffix_list()).into());
    };
    let bytes = std::fs::read(path)?;
    Ok(parse(format, &bytes, path.parent())?)
}

/// Reads a mesh file that is already in memory.
///
/// # Errors
/// As [`read_mesh`]; a glTF file that names buffers in other files is an error too.
pub fn read_mesh_from_bytes(format: Format, bytes: &[u8]) -> Result<MeshFile, Error> {
    parse(format, bytes, None)
        .map_err(|reason| Error::file(Path::new(&format!("{} in memory", format.name())), reason))
}

/// Reads the meshes of a file one by one, each in the space that it was modelled in: what a game
/// places any number of times and decomposes once.
///
/// Of a glTF file, each mesh that holds triangles, whether a scene shows it or not, without the
/// nodes' transforms, all its primitives together; one without a name is called `mesh_` and its
/// index. A file of another format is one mesh, named after the file.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_own_meshes(path: impl AsRef<Path>) -> Result<Vec<NamedMesh>, Error> {
    let path = path.as_ref();
    if Format::from_path(path) == Some(Format::Gltf) {
        let bytes = std::fs::read(path).map_err(|error| Error::file(path, error))?;
        let file = gltf::read_own_space(unmarked(&bytes), path.parent())
            .map_err(|reason| Error::file(path, reason))?;
        return Ok(split_objects(&file));
    }
    let MeshFile { mesh, .. } = read_mesh(path)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(vec![NamedMesh { name, mesh }])
}

/// Without the mark that some editors put before UTF-8 text, which would hide the first line.
fn unmarked(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

fn parse(format: Format, bytes: &[u8], directory: Option<&Path>) -> Result<MeshFile, String> {
    let bytes = unmarked(bytes);
    match format {
        Format::Obj => obj::read(bytes),
        Format::Off => off::read(bytes),
        Format::Ply => ply::read(bytes),
        Format::Stl => stl::read(bytes),
        Format::Gltf => gltf::read(bytes, directory),
    }
}

/// Reads a set of hulls: each object of a mesh file is one, see [`MeshFile::objects`]; a
/// [`.hulls`](crate::hulls_format) file holds just them. Each becomes a [`Hull`](crate::Hull) by
/// `Hull::from(convex_hull(&named.mesh.positions)?)`.
///
/// # Errors
/// As [`read_mesh`], and if there is no triangle in the file.
pub fn read_hulls(path: impl AsRef<Path>) -> Result<Vec<NamedMesh>, Error> {
    let path = path.as_ref();
    if is_hulls_file(path) {
        return read_hulls_file(path);
    }
    let file = read_mesh(path)?;
    if file.objects.is_empty() {
        return Err(Error::file(path, "it holds no triangles, so no hulls".to_owned()));
    }
    Ok(split_objects(&file))
}

/// Whether a file name's suffix is `hulls`, in upper or lower case.
pub fn is_hulls_file(path: impl AsRef<Path>) -> bool {
    path.as_ref().extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("hulls"))
}

fn read_hulls_file(path: &Path) -> Result<Vec<NamedMesh>, Error> {
    let bytes = std::fs::read(path).map_err(|error| Error::file(path, error))?;
    let file =
        HullsFile::from_bytes(&bytes).map_err(|error| Error::file(path, error.to_string()))?;
    if file.hulls.is_empty() {
        return Err(Error::file(path, "it holds no hulls".to_owned()));
    }
    let hulls = file.hulls.into_iter().enumerate().map(|(index, hull)| NamedMesh {
        name: format!("hull_{index}"),
        mesh: TriangleMesh::new(hull.shape.points, hull.shape.triangles),
    });
    Ok(hulls.collect())
}

/// Gives each object its own vertices, in the order in which its triangles use them.
fn split_objects(file: &MeshFile) -> Vec<NamedMesh> {
    const UNSEEN: u32 = u32::MAX;
    let mut new_index = vec![UNSEEN; file.mesh.positions.len()];
    let mut hulls = Vec::with_capacity(file.objects.len());
    for object in &file.objects {
        let source = &file.mesh.triangles[object.triangles.clone()];
        let mut positions = Vec::new();
        let triangles = source
            .iter()
            .map(|triangle| {
                triangle.map(|vertex| {
                    let index = &mut new_index[vertex as usize];
                    if *index == UNSEEN {
                        *index = positions.len() as u32;
                        positions.push(file.mesh.positions[vertex as usize]);
                    }
                    *index
                })
            })
            .collect();
        for vertex in source.iter().flatten() {
            new_index[*vertex as usize] = UNSEEN;
        }
        let sidedness = file.mesh.sidedness.get(object.triangles.clone());
        let sidedness = sidedness.unwrap_or_default().to_vec();
        let mesh = TriangleMesh { positions, triangles, sidedness };
        hulls.push(NamedMesh { name: object.name.clone(), mesh });
    }
    hulls
}

/// The index of the first of `more` new vertices, if all of them can have an index.
fn next_index(positions: &[[f64; 3]], more: usize) -> Result<u32, String> {
    match u32::try_from(positions.len().saturating_add(more)) {
        Ok(_) => Ok(positions.len() as u32),
        Err(_) => Err(format!("it has more than {} vertices", u32::MAX)),
    }
}
