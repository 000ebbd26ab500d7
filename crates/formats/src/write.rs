//! Writes hull sets as OBJ and GLB, all or nothing.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use hullwright::{Error, MeshView};
use serde_json::{Value, json};

use super::gltf::GLB_HEADER;
use super::mesh_file::{HullFormat, is_hulls_file};
use crate::atomic_write::{directory, write_file};
use crate::palette::{colour, linear};
use crate::vector::{Vector, bounds};

/// Writes hulls to a file, for example `write_hulls(path, &decomposition.hulls)`. A file that is
/// already there is replaced; if anything goes wrong it stays as it was.
///
/// The suffix `obj` gives a Wavefront OBJ with the objects `hull_0`, `hull_1` and so on, and as
/// many digits as it takes to read back the same `f64`.
///
/// The suffix `glb` gives a binary glTF 2.0 with one node, mesh and colour (see
/// [`palette`](crate::palette)) per hull, named in the same way. Its coordinates are `f32`,
/// relative to the centre of all hulls, so that hulls far from the origin keep their shape; a
/// node `hulls` above the others moves them there.
///
/// The bytes of a `.hulls` file are made by
/// [`HullsFile::to_bytes`](hullwright::hulls_format::HullsFile::to_bytes), and written by
/// [`write_file`].
///
/// # Errors
/// [`Error::File`] if the suffix is another, if the directory does not exist, or if writing
/// fails.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// # let (parameters, control) = (hullwright::Parameters::default(), hullwright::Control::new());
/// # let decomposition = hullwright::decompose(&mesh, &parameters, &control)?;
/// # let directory = tempfile::tempdir().expect("a temporary directory");
/// # let path = directory.path().join("hulls.glb");
/// hullwright_formats::write_hulls(&path, &decomposition.hulls)?;
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn write_hulls<'a, H: Into<MeshView<'a>>>(
    path: impl AsRef<Path>,
    hulls: impl IntoIterator<Item = H>,
) -> Result<(), Error> {
    let path = path.as_ref();
    let bytes =
        bytes_of(output_format(path)?, hulls).map_err(|reason| Error::file(path, reason))?;
    write_file(path, &bytes)
}

/// The bytes that [`write_hulls`] would write.
///
/// # Errors
/// [`Error::File`] if the hulls are more than a file of the format can hold.
pub fn hulls_to_bytes<'a, H: Into<MeshView<'a>>>(
    format: HullFormat,
    hulls: impl IntoIterator<Item = H>,
) -> Result<Vec<u8>, Error> {
    let path = format!("{} in memory", format.suffix());
    bytes_of(format, hulls).map_err(|reason| Error::file(Path::new(&path), reason))
}

fn bytes_of<'a, H: Into<MeshView<'a>>>(
    format: HullFormat,
    hulls: impl IntoIterator<Item = H>,
) -> Result<Vec<u8>, String> {
    match format {
        HullFormat::Obj => Ok(obj_of(named_by_number(hulls)).into_bytes()),
        HullFormat::Glb => glb_of("hulls", named_by_number(hulls).collect()),
    }
}

fn named_by_number<'a, H: Into<MeshView<'a>>>(
    hulls: impl IntoIterator<Item = H>,
) -> impl Iterator<Item = (String, MeshView<'a>)> {
    let named = |(index, hull): (usize, H)| (format!("hull_{index}"), hull.into());
    hulls.into_iter().enumerate().map(named)
}

/// Checks what [`write_hulls`] or [`write_file`] would refuse, before there is anything to write.
///
/// # Errors
/// [`Error::File`] if the suffix is neither that of a [`HullFormat`] nor `hulls`, or if the
/// directory does not exist.
pub fn check_output(path: impl AsRef<Path>) -> Result<(), Error> {
    let path = path.as_ref();
    if !is_hulls_file(path) {
        output_format(path)?;
    }
    check_directory(path)
}

/// An error where there is no folder for a file.
pub(super) fn check_directory(path: &Path) -> Result<(), Error> {
    let directory = directory(path);
    if directory.is_dir() {
        Ok(())
    } else {
        let reason = format!("the directory `{}` does not exist", directory.display());
        Err(Error::file(path, reason))
    }
}

fn output_format(path: &Path) -> Result<HullFormat, Error> {
    HullFormat::from_path(path).ok_or_else(|| {
        Error::file(path, format!("hulls can be written as {}", HullFormat::suffix_list()))
    })
}

/// Named meshes as [`write_hulls`](super::write_hulls) describes.
pub(super) fn obj_of<'a>(meshes: impl Iterator<Item = (String, MeshView<'a>)>) -> String {
    let mut text = String::new();
    let mut first_vertex = 1;
    for (name, hull) in meshes {
        // Writing to a string can't fail.
        let _ = writeln!(text, "o {name}");
        for [x, y, z] in hull.positions() {
            let _ = writeln!(text, "v {x:?} {y:?} {z:?}");
        }
        for triangle in hull.triangles() {
            let [a, b, c] = triangle.map(|vertex| first_vertex + vertex as usize);
            let _ = writeln!(text, "f {a} {b} {c}");
        }
        first_vertex += hull.vertex_count();
    }
    text
}

/// glTF's codes for component types and for what a buffer view is for.
pub(super) const UNSIGNED_SHORT: u32 = 5123;
pub(super) const UNSIGNED_INT: u32 = 5125;
pub(super) const FLOAT: u32 = 5126;
pub(super) const VERTICES: u32 = 34962;
pub(super) const INDICES: u32 = 34963;

/// Moderately glossy, so that edges show in any light.
const ROUGHNESS: f64 = 0.6;

/// The greatest 16-bit integer may not be used as an index.
pub(super) const MOST_SHORT_INDICES: usize = 65_535;

/// Named meshes as [`write_hulls`](super::write_hulls) describes. There are no normals, so that
/// viewers shade the faces flat. The error, in words, is a file of more than 4 GiB or a coordinate
/// that is too large for `f32`.
pub(super) fn glb_of(top: &str, meshes: Vec<(String, MeshView<'_>)>) -> Result<Vec<u8>, String> {
    // Rounded first, since what is taken off each vertex must be what the node adds.
    let centre = centre(&meshes).as_vec3().to_array();
    let mut parts = Parts::default();
    for (index, (name, mesh)) in meshes.iter().enumerate() {
        parts.add(index, name, mesh, centre)?;
    }
    let json = parts.document(top, centre).to_string().into_bytes();
    assemble(json, parts.bytes, &[])
}

/// The middle of the bounding box.
fn centre(meshes: &[(String, MeshView<'_>)]) -> Vector {
    let points = meshes.iter().flat_map(|(_, mesh)| mesh.positions());
    let (low, high) = bounds(points.map(Vector::from));
    if low[0] > high[0] { Vector::ZERO } else { low * 0.5 + high * 0.5 }
}

/// The growing arrays of the document, by their names.
#[derive(Default)]
struct Parts {
    bytes: Vec<u8>,
    arrays: BTreeMap<&'static str, Vec<Value>>,
}

impl Parts {
    /// Appends to an array. The index there.
    fn push(&mut self, array: &'static str, value: Value) -> usize {
        let array = self.arrays.entry(array).or_default();
        array.push(value);
        array.len() - 1
    }

    fn add(
        &mut self,
        index: usize,
        name: &str,
        hull: &MeshView,
        centre: [f32; 3],
    ) -> Result<(), String> {
        let positions = self.add_positions(hull, Vector::from(centre.map(f64::from)))?;
        let indices = self.add_indices(hull);
        let primitive = json!({
            "attributes": { "POSITION": positions },
            "indices": indices,
            "material": self.push("materials", material(name, index)),
        });
        let mesh = self.push("meshes", json!({ "name": name, "primitives": [primitive] }));
        self.push("nodes", json!({ "name": name, "mesh": mesh }));
        Ok(())
    }

    /// The index of the accessor.
    fn add_positions(&mut self, hull: &MeshView, centre: Vector) -> Result<usize, String> {
        let positions = hull.positions().map(|point| (Vector::from(point) - centre).as_vec3());
        let (mut min, mut max) = (glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY);
        let start = self.bytes.len();
        for position in positions {
            // In this order, coordinates that are not numbers are passed over.
            (min, max) = (position.min(min), position.max(max));
            self.bytes.extend(position.to_array().into_iter().flat_map(f32::to_le_bytes));
        }
        if !(min.is_finite() && max.is_finite()) {
            return Err("GLB has 32-bit coordinates, and some are too large for that".into());
        }
        let accessor = json!({
            "bufferView": self.close_view(start, VERTICES),
            "componentType": FLOAT,
            "count": hull.vertex_count(),
            "type": "VEC3",
            "min": min.to_array(),
            "max": max.to_array(),
        });
        Ok(self.push("accessors", accessor))
    }

    /// The index of the accessor.
    fn add_indices(&mut self, hull: &MeshView) -> usize {
        let start = self.bytes.len();
        let indices = hull.triangles().as_flattened().iter();
        let component = if hull.vertex_count() <= MOST_SHORT_INDICES {
            self.bytes.extend(indices.flat_map(|&index| (index as u16).to_le_bytes()));
            UNSIGNED_SHORT
        } else {
            self.bytes.extend(indices.flat_map(|index| index.to_le_bytes()));
            UNSIGNED_INT
        };
        let accessor = json!({
            "bufferView": self.close_view(start, INDICES),
            "componentType": component,
            "count": hull.triangles().len() * 3,
            "type": "SCALAR",
        });
        self.push("accessors", accessor)
    }

    /// Makes a buffer view of the bytes since `start`. What follows is aligned to four bytes.
    fn close_view(&mut self, start: usize, target: u32) -> usize {
        let length = self.bytes.len() - start;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view =
            json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target });
        self.push("bufferViews", view)
    }

    fn document(&mut self, name: &str, centre: [f32; 3]) -> Value {
        let mut top = json!({ "name": name });
        let hulls = self.arrays.get("nodes").map_or(0, Vec::len);
        // Arrays and buffers may not be empty.
        if hulls > 0 {
            top["translation"] = json!(centre);
            top["children"] = (0..hulls).collect();
            self.push("buffers", json!({ "byteLength": self.bytes.len() }));
        }
        let top = self.push("nodes", top);
        let mut document = json!({
            "asset": { "version": "2.0", "generator": concat!("hullwright ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [{ "name": name, "nodes": [top] }],
        });
        for array in ["buffers", "nodes", "meshes", "materials", "accessors", "bufferViews"] {
            if let Some(values) = self.arrays.remove(array) {
                document[array] = Value::Array(values);
            }
        }
        document
    }
}

/// The material of a hull: the colour of its number.
pub(super) fn material(name: &str, number: usize) -> Value {
    let [red, green, blue] = linear(colour(number));
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": ROUGHNESS,
        },
    })
}

/// A GLB of its JSON, its binary data if there is any, and whole chunks of other kinds.
pub(super) fn assemble(json: Vec<u8>, bytes: Vec<u8>, others: &[u8]) -> Result<Vec<u8>, String> {
    let length = json.len().saturating_add(bytes.len()).saturating_add(others.len());
    if u32::try_from(length.saturating_add(64)).is_err() {
        return Err(format!("its {length} bytes are more than a GLB can have"));
    }
    let mut chunks = chunk(b"JSON", json, b' ');
    if !bytes.is_empty() {
        chunks.extend(chunk(b"BIN\0", bytes, 0));
    }
    chunks.extend(others);
    let mut glb = b"glTF".to_vec();
    glb.extend(2_u32.to_le_bytes());
    glb.extend((GLB_HEADER as u32 + chunks.len() as u32).to_le_bytes());
    glb.extend(chunks);
    Ok(glb)
}

/// A chunk of a GLB, filled up to a multiple of four bytes.
fn chunk(kind: &[u8; 4], mut content: Vec<u8>, filler: u8) -> Vec<u8> {
    content.resize(content.len().next_multiple_of(4), filler);
    let length = content.len() as u32;
    [&length.to_le_bytes(), kind, content.as_slice()].concat()
}
