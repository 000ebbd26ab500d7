//! Readers and writers of mesh files.
//!
//! | format | read by |
//! |---|---|
//! | glTF, GLB | crate `serde_json` for the JSON; the rest here, since the crate `gltf` refuses files over what moves no vertex, and panics on hostile ones |
//! | Draco in glTF | crate `draco-core`, the decoder alone |
//! | meshopt in glTF | crate `meshoptimizer-rs`, its codecs and filters |
//! | PLY | `ply`, since the crate `ply-rs-bw` reads files wrong that name a property twice, and refuses numbers such as `.5` and `nan` |
//! | OBJ | `obj`, since the crate `tobj` refuses sound files, makes faces of polylines and names no line in its errors |
//! | OFF | `off`, since the crate `off-rs` holds `f32` and reads one form of header |
//! | STL | `stl`, since the crate `stl_io` holds `f32`, drops all solids but the first, and goes by the first word alone |
//!
//! All readers keep three promises on any input: no panic, no allocation beyond what the file's
//! size justifies, whatever its counts are, and errors of one line with what was found, where, and
//! what would be read. What they leave out or mend stands in [`MeshFile::notes`]. Text may be
//! UTF-8, UTF-16 with its mark, or any encoding that has ASCII as it is. Coordinates that are
//! written as text keep their full `f64` precision, and `nan` and `inf` are let through, since
//! repair counts and drops them. Points and lines are left out. Polygons, concave ones too, are
//! triangulated by ear clipping and Delaunay refinement (crate `earcut`); those without an inside
//! become fans.

use std::borrow::Cow;
use std::path::Path;

use hullwright::hulls_format::HullsFile;
use hullwright::{Error, FileError, TriangleMesh};

use crate::gltf_data::Beside;
use crate::mesh_file::{Format, MeshFile, NamedMesh, SceneMesh, is_hulls_file};
use crate::{gltf, mesh_file, obj, off, ply, stl};

/// Reads a mesh file; its suffix names the format.
///
/// Of a glTF file all meshes of the default scene are read (of all scenes where none is the
/// default, of all nodes where there is no scene) with the nodes' transforms applied, without nodes
/// that `KHR_node_visibility` hides, and with all instances of `EXT_mesh_gpu_instancing`. A skin is
/// applied where its joints move or scale the mesh at rest; morph targets are not. Geometry may be
/// quantised (`KHR_mesh_quantization`) and compressed (`KHR_draco_mesh_compression`,
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
/// let file = hullwright_formats::read_mesh("../../assets/mug.glb")?;
/// assert_eq!(file.mesh.triangles.len(), 1020);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn read_mesh(path: impl AsRef<Path>) -> Result<MeshFile, Error> {
    let path = path.as_ref();
    read_mesh_file(path).map_err(|source| Error::file(path, source))
}

fn read_mesh_file(path: &Path) -> Result<MeshFile, FileError> {
    let Some(format) = Format::from_path(path) else {
        let reason = match path.is_dir() {
            true => "it is a folder, not a mesh file".to_owned(),
            false => format!("its suffix is not {}", Format::suffix_list()),
        };
        return Err(reason.into());
    };
    let bytes = std::fs::read(path)?;
    Ok(parse(format, &bytes, path.parent().into())?)
}

/// Reads a mesh file that is already in memory.
///
/// # Errors
/// As [`read_mesh`]; a glTF file that names buffers in other files is an error too.
pub fn read_mesh_from_bytes(format: Format, bytes: &[u8]) -> Result<MeshFile, Error> {
    parse(format, bytes, Beside::Nothing).map_err(|reason| in_memory(format, reason))
}

/// The same for a file that names others: `files` finds them by their paths, relative to the file,
/// without escapes. Only buffers of glTF are looked up, and no path that leaves the file's folder.
///
/// # Errors
/// As [`read_mesh`], also for a buffer that `files` does not find.
///
/// ```
/// use hullwright_formats::{Format, read_mesh_from_files};
///
/// let document = br#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
///     "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
///     "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
///     "bufferViews": [{"buffer": 0, "byteLength": 36}],
///     "buffers": [{"byteLength": 36, "uri": "a%20triangle.bin"}]}"#;
/// let files = |path: &str| (path == "a triangle.bin").then(|| vec![0; 36]);
/// let file = read_mesh_from_files(Format::Gltf, document, &files)?;
/// assert_eq!(file.mesh.triangles.len(), 1);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn read_mesh_from_files(
    format: Format,
    bytes: &[u8],
    files: &dyn Fn(&str) -> Option<Vec<u8>>,
) -> Result<MeshFile, Error> {
    parse(format, bytes, Beside::Files(files)).map_err(|reason| in_memory(format, reason))
}

fn in_memory(format: Format, reason: String) -> Error {
    Error::file(Path::new(&format!("{} in memory", format.name())), reason)
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
    let meshes = read_scene(path)?.into_iter();
    Ok(meshes.map(|SceneMesh { name, mesh, .. }| NamedMesh { name, mesh }).collect())
}

/// Text as UTF-8, without the mark that some editors put before it, which would hide the first
/// line. What has no mark of UTF-16 is left as it is.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, [u8]> {
    let utf_16 = |from_bytes: fn([u8; 2]) -> u16| {
        let (pairs, _) = bytes.as_chunks::<2>();
        let units = pairs.iter().skip(1).map(|pair| from_bytes(*pair));
        let text: String =
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        Cow::Owned(text.into_bytes())
    };
    match bytes {
        [0xff, 0xfe, ..] => utf_16(u16::from_le_bytes),
        [0xfe, 0xff, ..] => utf_16(u16::from_be_bytes),
        _ => Cow::Borrowed(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)),
    }
}

fn parse(format: Format, bytes: &[u8], beside: Beside<'_>) -> Result<MeshFile, String> {
    let bytes = &decoded(bytes);
    let read = match format {
        Format::Obj => obj::read(bytes),
        Format::Off => off::read(bytes),
        Format::Ply => ply::read(bytes),
        Format::Stl => stl::read(bytes),
        Format::Gltf => gltf::read(bytes, beside),
    };
    read.map_err(|reason| stand_in(bytes).map_or(reason, str::to_owned))
}

/// What is wrong with a file that was not fetched whole.
fn stand_in(bytes: &[u8]) -> Option<&'static str> {
    let starts_with = |text: &[u8]| {
        let start = bytes.trim_ascii_start().get(..text.len());
        start.is_some_and(|start| start.eq_ignore_ascii_case(text))
    };
    if starts_with(b"version https://git-lfs") {
        return Some("it is a pointer of Git LFS, not the file: `git lfs pull` fetches that");
    }
    let is_page = starts_with(b"<!doctype html") || starts_with(b"<html");
    is_page.then_some("it is a web page, not the file: the download went wrong")
}

/// Reads a set of hulls: each object of a mesh file is one, see [`MeshFile::objects`]; a
/// [`.hulls`](hullwright::hulls_format) file holds just them. Each becomes a
/// [`Hull`](hullwright::Hull) by `Hull::from(convex_hull(&named.mesh.positions)?)`.
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
    Ok(mesh_file::split_objects(&file))
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

/// Reads the meshes of a scene one by one, each in the space that it was modelled in.
///
/// Of a glTF file, each mesh that holds triangles, whether a node shows it or not. A file of
/// another format is one mesh, named after the file, that no node shows.
///
/// # Errors
/// As [`read_mesh`].
///
/// ```
/// let meshes = hullwright_formats::read_scene("../../assets/props.glb")?;
/// let nodes: Vec<&str> =
///     meshes.iter().flat_map(|mesh| &mesh.nodes).map(|node| node.name.as_str()).collect();
/// assert!(nodes.contains(&"mug-convdecomp"));
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn read_scene(path: impl AsRef<Path>) -> Result<Vec<SceneMesh>, Error> {
    let path = path.as_ref();
    if Format::from_path(path) == Some(Format::Gltf) {
        let bytes = std::fs::read(path).map_err(|error| Error::file(path, error))?;
        return parse_scene(&bytes, path.parent().into())
            .map_err(|reason| Error::file(path, reason));
    }
    let MeshFile { mesh, parts, notes, .. } = read_mesh(path)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let nodes = Vec::new();
    Ok(vec![SceneMesh { name, index: None, mesh, parts, extras: None, nodes, notes }])
}

/// Reads the meshes of a glTF or GLB file that is already in memory, as [`read_scene`].
///
/// # Errors
/// As [`read_mesh`]; a file that names buffers in other files is an error too.
pub fn read_scene_from_bytes(bytes: &[u8]) -> Result<Vec<SceneMesh>, Error> {
    parse_scene(bytes, Beside::Nothing)
        .map_err(|reason| Error::file(Path::new("glTF in memory"), reason))
}

fn parse_scene(bytes: &[u8], beside: Beside<'_>) -> Result<Vec<SceneMesh>, String> {
    let bytes = &decoded(bytes);
    let read = gltf::read_scene(bytes, beside);
    read.map_err(|reason| stand_in(bytes).map_or(reason, str::to_owned))
}
