//! glTF 2.0 and GLB: the triangles of the scene.
//!
//! The crate `gltf` (1.4) splits the GLB and reads the JSON. Its typed document and accessor
//! readers are not used: they panic on what its validation does not look at (a GLB length under
//! 12, accessors beyond their buffer, short strides), and the validation refuses files over
//! materials or missing bounds that don't matter here. The JSON's structures are walked instead,
//! each index checked. Nodes must form trees; a node that is reached twice is an error, which
//! also stops cycles.
//!
//! Extensions that a file requires are refused unless they leave geometry alone or are read here:
//! `KHR_mesh_quantization`, `KHR_draco_mesh_compression`, `EXT_meshopt_compression` and
//! `KHR_meshopt_compression`. Compressed data is preferred to an uncompressed copy beside it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::rc::Rc;

use glam::{DAffine3, DMat3, DMat4};
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{Extras, Index, Root};

use super::gltf_data::{Beside, DRACO, Data, DracoMesh, DracoStream, MESHOPT};
use super::mesh_file::{MeshFile, SceneMesh, SceneNode, next_index, split_objects};
use super::text::quote;
use crate::geometry::Sidedness;
use crate::geometry::vector::Vector;

/// A small file can place a mesh any number of times. A scene may have this many vertices and
/// this many triangles, and one more for each byte that was read and for each element that was
/// decompressed, so that what a file holds can always be placed at least once.
const PLACED_FOR_FREE: usize = 1 << 22;

/// A GLB begins with a magic number, its version and its length, each of four bytes.
const GLB_HEADER: usize = 12;

/// Required extensions that are read, besides meshoptimizer's.
const KNOWN_EXTENSIONS: [&str; 2] = ["KHR_mesh_quantization", DRACO];

/// Required extensions that don't change where vertices are, by the beginning of their name.
const HARMLESS_EXTENSIONS: [&str; 7] = [
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_xmp",
    "EXT_texture_",
    "EXT_lights_",
    "MSFT_texture_",
];

/// All meshes of the scene, each node's transform applied.
pub(super) fn read(bytes: &[u8], beside: Beside<'_>) -> Result<MeshFile, String> {
    read_with(bytes, beside, |scene| scene.read())
}

/// Each mesh of the document once, in its own space, whether a scene shows it or not, with its extras and those of
/// its nodes.
pub(super) fn read_scene(bytes: &[u8], beside: Beside<'_>) -> Result<Vec<SceneMesh>, String> {
    let mut notes_of_objects = Vec::new();
    let file = read_with(bytes, beside, |scene| {
        for (index, notes) in extras_and_nodes(scene.root).into_iter().enumerate() {
            let objects = scene.file.objects.len();
            scene.add_own_space(index)?;
            // A mesh without triangles is no object.
            if scene.file.objects.len() > objects {
                notes_of_objects.push((Some(index as u32), notes));
            }
        }
        Ok(())
    })?;
    let meshes = split_objects(&file).into_iter().zip(notes_of_objects).map(|(named, notes)| {
        let (index, (extras, nodes)) = notes;
        SceneMesh { name: named.name, index, mesh: named.mesh, extras, nodes }
    });
    Ok(meshes.collect())
}

fn read_with(
    bytes: &[u8],
    beside: Beside<'_>,
    read: impl FnOnce(&mut Scene<'_>) -> Result<(), String>,
) -> Result<MeshFile, String> {
    let (json, chunk) = if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (bytes, None) };
    let root = Root::from_slice(json).map_err(|error| format!("JSON: {error}"))?;
    for extension in &root.extensions_required {
        if !is_read_or_harmless(extension) {
            let extension = quote(extension.as_bytes());
            return Err(format!("it requires the extension {extension}, which can't be read"));
        }
    }
    let mut scene = Scene {
        root: &root,
        data: Data::new(&root, chunk, beside, bytes.len()),
        decompressed: BTreeMap::new(),
        file: MeshFile::default(),
    };
    read(&mut scene)?;
    Ok(scene.file)
}

fn is_read_or_harmless(extension: &str) -> bool {
    KNOWN_EXTENSIONS.contains(&extension)
        || MESHOPT.contains(&extension)
        || HARMLESS_EXTENSIONS.iter().any(|harmless| extension.starts_with(harmless))
}

/// The JSON of a GLB, and the chunk of binary data if there is one.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let length = bytes.get(8..GLB_HEADER).and_then(|length| length.first_chunk::<4>());
    let length = length.map_or(0, |length| u32::from_le_bytes(*length) as usize);
    if length < GLB_HEADER || length > bytes.len() {
        return Err(format!("its header announces {length} bytes, but it has {}", bytes.len()));
    }
    let glb = gltf::Glb::from_slice(&bytes[..length]).map_err(|error| format!("GLB: {error}"))?;
    match (glb.json, glb.bin) {
        (Cow::Borrowed(json), None) => Ok((json, None)),
        (Cow::Borrowed(json), Some(Cow::Borrowed(chunk))) => Ok((json, Some(chunk))),
        _ => Err("GLB: its chunks could not be told apart".into()),
    }
}

struct Scene<'a> {
    root: &'a Root,
    data: Data<'a>,
    /// A mesh may be placed many times, and a Draco stream may be used by many primitives.
    decompressed: BTreeMap<DracoStream, Rc<DracoMesh>>,
    file: MeshFile,
}

/// Where vertices come from.
#[derive(Clone, Copy, PartialEq)]
enum Source {
    Accessor(Index<Accessor>),
    Draco(DracoStream),
}

/// The vertices of a mesh that are in the scene already.
struct Placed {
    source: Source,
    first: u32,
    count: usize,
}

impl Scene<'_> {
    /// All meshes, in the order of the node trees.
    fn read(&mut self) -> Result<(), String> {
        let nodes = &self.root.nodes;
        if nodes.is_empty() {
            for index in 0..self.root.meshes.len() {
                self.add_mesh(Index::new(index as u32), None, &DAffine3::IDENTITY)?;
            }
            return Ok(());
        }
        let mut is_reached = vec![false; nodes.len()];
        for tree in self.trees()? {
            if is_reached.get(tree.value()) == Some(&true) {
                // Scenes may share trees, and a scene may name one twice.
                continue;
            }
            let mut open = vec![(tree, DAffine3::IDENTITY)];
            while let Some((index, parent)) = open.pop() {
                let node =
                    nodes.get(index.value()).ok_or_else(|| format!("there is no node {index}"))?;
                if std::mem::replace(&mut is_reached[index.value()], true) {
                    return Err(format!("node {index} has two parents or is inside of itself"));
                }
                let transform = parent * transform(node);
                if let Some(mesh) = node.mesh {
                    self.add_mesh(mesh, node.name.as_deref(), &transform)?;
                }
                let children = node.children.iter().flatten();
                open.extend(children.rev().map(|child| (*child, transform)));
            }
        }
        Ok(())
    }

    fn add_own_space(&mut self, index: usize) -> Result<(), String> {
        let name = self.root.meshes.get(index).and_then(|mesh| mesh.name.clone());
        let name = name.filter(|name| !name.is_empty()).unwrap_or(format!("mesh_{index}"));
        self.add_mesh(Index::new(index as u32), Some(&name), &DAffine3::IDENTITY)
    }

    /// The roots of the default scene, or else of all scenes, or else of all nodes.
    fn trees(&self) -> Result<Vec<Index<Node>>, String> {
        let Root { nodes, scenes, scene, .. } = self.root;
        if let Some(scene) = scene {
            let found = self.root.get(*scene);
            return Ok(found.ok_or_else(|| format!("there is no scene {scene}"))?.nodes.clone());
        }
        if !scenes.is_empty() {
            return Ok(scenes.iter().flat_map(|scene| scene.nodes.clone()).collect());
        }
        let mut is_child = vec![false; nodes.len()];
        for child in nodes.iter().flat_map(|node| node.children.iter().flatten()) {
            if let Some(is_child) = is_child.get_mut(child.value()) {
                *is_child = true;
            }
        }
        let roots = is_child.iter().enumerate().filter(|(_, is_child)| !**is_child);
        Ok(roots.map(|(index, _)| Index::new(index as u32)).collect())
    }

    fn add_mesh(
        &mut self,
        index: Index<Mesh>,
        node_name: Option<&str>,
        transform: &DAffine3,
    ) -> Result<(), String> {
        let root = self.root;
        let mesh = root.get(index).ok_or_else(|| format!("there is no mesh {index}"))?;
        let start = self.file.mesh.triangles.len();
        // Primitives often share their vertices, each with a material of its own.
        let mut placed = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            self.add_primitive(primitive, transform, &mut placed)
                .map_err(|reason| format!("mesh {index}, primitive {number}: {reason}"))?;
        }
        let name = node_name.or(mesh.name.as_deref()).unwrap_or_default();
        self.file.close_object(name, start);
        Ok(())
    }

    fn add_primitive(
        &mut self,
        primitive: &Primitive,
        transform: &DAffine3,
        placed: &mut Vec<Placed>,
    ) -> Result<(), String> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err("its mode is unknown".into());
        };
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let Some(accessor) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else {
            return Ok(());
        };
        let is_normalized = self.root.get(*accessor).is_some_and(|accessor| accessor.normalized);
        let stream = DracoStream::of(primitive, is_normalized)?;
        let geometry = stream.map(|stream| self.decompressed(stream)).transpose()?;
        let source = stream.map_or(Source::Accessor(*accessor), Source::Draco);
        let known = placed.iter().find(|known| known.source == source);
        let (first, count) = match known {
            Some(known) => (known.first, known.count),
            None => {
                let positions = match &geometry {
                    Some(geometry) => Cow::Borrowed(&geometry.positions),
                    None => Cow::Owned(self.data.positions(*accessor)?),
                };
                let count = positions.len();
                self.check_growth("vertices", self.file.mesh.positions.len(), count)?;
                let first = next_index(&self.file.mesh.positions, count)?;
                let places = positions.iter().map(|&p| transform.transform_point3(p.into()));
                self.file.mesh.positions.extend(places.map(|place| place.to_array()));
                placed.push(Placed { source, first, count });
                (first, count)
            }
        };
        // Draco holds triangles one by one, in whatever mode the primitive announces them.
        let mode = if geometry.is_some() { Mode::Triangles } else { mode };
        let indices = match (&geometry, primitive.indices) {
            (Some(geometry), _) => Cow::Borrowed(&geometry.indices),
            (None, Some(accessor)) => Cow::Owned(self.data.indices(accessor)?),
            (None, None) => Cow::Owned((0..count as u32).collect()),
        };
        if let Some(index) = indices.iter().find(|index| **index as usize >= count) {
            return Err(format!("index {index} is beyond its {count} vertices"));
        }
        // Strips and fans have about as many triangles as indices.
        let corners = if mode == Mode::Triangles { 3 } else { 1 };
        let more = indices.len() / corners;
        self.check_growth("triangles", self.file.mesh.triangles.len(), more)?;
        let triangles = triangles(mode, &indices)?;
        // Left and right change places.
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        self.file.mesh.triangles.extend(triangles.map(|triangle| {
            let [a, b, c] = triangle.map(|index| first + index);
            if is_mirrored { [a, c, b] } else { [a, b, c] }
        }));
        let sidedness = self.sidedness(primitive);
        self.file.mesh.sidedness.resize(self.file.mesh.triangles.len(), sidedness);
        Ok(())
    }

    /// By its material; without one a renderer draws one side.
    fn sidedness(&self, primitive: &Primitive) -> Sidedness {
        let material = primitive.material.and_then(|index| self.root.get(index));
        match material {
            Some(material) if material.double_sided => Sidedness::Two,
            _ => Sidedness::One,
        }
    }

    fn decompressed(&mut self, stream: DracoStream) -> Result<Rc<DracoMesh>, String> {
        if let Some(geometry) = self.decompressed.get(&stream) {
            return Ok(Rc::clone(geometry));
        }
        let geometry = Rc::new(self.data.draco(stream)?);
        self.decompressed.insert(stream, Rc::clone(&geometry));
        Ok(geometry)
    }

    /// Refuses to let an array of the scene grow too long.
    fn check_growth(&mut self, what: &str, present: usize, more: usize) -> Result<(), String> {
        let most = PLACED_FOR_FREE + self.data.elements_read();
        if present + more > most {
            return Err(format!("placed here once more, the scene has over {most} {what}"));
        }
        Ok(())
    }
}

/// Each mesh's extras, and the nodes that show it.
fn extras_and_nodes(root: &Root) -> Vec<(Option<String>, Vec<SceneNode>)> {
    let text = |extras: &Extras| Some(extras.as_ref()?.get().to_owned());
    let mut notes: Vec<_> =
        root.meshes.iter().map(|mesh| (text(&mesh.extras), Vec::new())).collect();
    for node in &root.nodes {
        if let Some((_, nodes)) = node.mesh.and_then(|mesh| notes.get_mut(mesh.value())) {
            let name = node.name.clone().unwrap_or_default();
            nodes.push(SceneNode { name, extras: text(&node.extras) });
        }
    }
    notes
}

/// Of a 4×4 matrix the last row is taken as (0, 0, 0, 1).
fn transform(node: &Node) -> DAffine3 {
    match node.matrix {
        Some(matrix) => DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from))),
        None => transform_from_parts(
            node.translation.unwrap_or_default(),
            node.rotation.unwrap_or_default().0,
            node.scale.unwrap_or([1.0; 3]),
        ),
    }
}

/// First scaled, then rotated by a quaternion (x, y, z, w), then moved.
fn transform_from_parts(translation: [f32; 3], rotation: [f32; 4], size: [f32; 3]) -> DAffine3 {
    let [x, y, z, w] = rotation.map(f64::from);
    let length_squared = x * x + y * y + z * z + w * w;
    // A quaternion of length 0 or infinite turns nothing.
    let s = if length_squared.is_normal() { 2.0 / length_squared } else { 0.0 };
    let columns = [
        [1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)],
        [s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)],
        [s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)],
    ];
    let [a, b, c] = [0, 1, 2].map(|axis| Vector::from(columns[axis]) * f64::from(size[axis]));
    DAffine3 {
        matrix3: DMat3::from_cols(a, b, c),
        translation: Vector::from(translation.map(f64::from)),
    }
}

/// The triangles of a list, strip or fan of indices.
fn triangles(
    mode: Mode,
    indices: &[u32],
) -> Result<Box<dyn Iterator<Item = [u32; 3]> + '_>, String> {
    let (whole, rest) = indices.as_chunks::<3>();
    Ok(match (mode, indices) {
        (Mode::TriangleFan, [centre, rim @ ..]) => {
            Box::new(rim.windows(2).map(|pair| [*centre, pair[0], pair[1]]))
        }
        (Mode::TriangleStrip, _) => {
            // Every other triangle of a strip is wound the other way.
            Box::new(indices.windows(3).enumerate().map(|(number, corners)| {
                let (second, third) = if number % 2 == 0 { (1, 2) } else { (2, 1) };
                [corners[0], corners[second], corners[third]]
            }))
        }
        _ if rest.is_empty() => Box::new(whole.iter().copied()),
        _ => {
            return Err(format!("{} indices don't make whole triangles", indices.len()));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_comes_before_rotation_and_translation() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let quarter_turn_about_z = [0.0, 0.0, half, half];
        let transform =
            transform_from_parts([10.0, 0.0, 0.0], quarter_turn_about_z, [2.0, 1.0, -1.0]);
        let placed = transform.transform_point3(Vector::new(1.0, 0.0, 5.0));
        assert!(placed.distance(Vector::new(10.0, 2.0, -5.0)) < 1e-6);
    }

    #[test]
    fn an_unnormalised_quaternion_only_turns() {
        let transform = transform_from_parts([0.0; 3], [0.0, 0.0, 3.0, 0.0], [1.0; 3]);
        let placed = transform.transform_point3(Vector::new(1.0, 2.0, 3.0));
        assert_eq!(placed, Vector::new(-1.0, -2.0, 3.0));
        assert_eq!(transform_from_parts([0.0; 3], [0.0; 4], [1.0; 3]), DAffine3::IDENTITY);
    }
}
