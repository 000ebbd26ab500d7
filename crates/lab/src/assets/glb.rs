//! Writes a model as GLB (glTF 2.0, binary): one primitive per mesh and material.

use hullwright_formats::palette::linear;
use serde_json::{Value, json};

use super::model::Model;
use super::shape::{Point, Shape};

/// Cosine of the greatest angle, 40 degrees, between faces that are shaded as one smooth surface.
const SMOOTH: f64 = 0.766;

/// Normals are rounded to this many steps per unit, so that the last bit of a root cannot change
/// a file.
const NORMAL_STEPS: f64 = 1e4;

/// glTF's numbers for component types and buffer targets.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// For each triangle the normals at its corners.
fn corner_normals(shape: &Shape) -> Vec<[Point; 3]> {
    let corners: Vec<[Point; 3]> = shape.corners().collect();
    let normal = |&[a, b, c]: &[Point; 3]| (b - a).cross(c - a).normalize_or_zero();
    let faces: Vec<Point> = corners.iter().map(normal).collect();
    let mut incident = vec![Vec::new(); shape.positions.len()];
    for (triangle, indices) in shape.triangles.iter().enumerate() {
        for (corner, vertex) in indices.iter().enumerate() {
            let [a, b, c] = [0, 1, 2].map(|step| corners[triangle][(corner + step) % 3]);
            let (first, second) = (b - a, c - a);
            let angle = first.cross(second).length().atan2(first.dot(second));
            incident[*vertex as usize].push((triangle, angle));
        }
    }
    let smooth = |face: Point, vertex: u32| {
        let near = incident[vertex as usize].iter().map(|&(other, angle)| (faces[other], angle));
        let near = near.filter(|(other, _)| other.dot(face) > SMOOTH);
        near.map(|(other, angle)| other * angle).sum::<Point>().normalize_or_zero()
    };
    let triangles = shape.triangles.iter().zip(&faces);
    triangles.map(|(triangle, face)| triangle.map(|vertex| smooth(*face, vertex))).collect()
}

/// The binary chunk, and the buffer views and accessors that point into it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds an accessor and returns its number.
    fn push(&mut self, bytes: &[u8], target: u32, mut accessor: Value) -> usize {
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": bytes.len(),
            "target": target,
        }));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn push_vectors(&mut self, vectors: &[[f32; 3]], with_bounds: bool) -> usize {
        let bytes: Vec<u8> =
            vectors.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
        let mut accessor = json!({"componentType": FLOAT, "count": vectors.len(), "type": "VEC3"});
        if with_bounds {
            let fold = |choose: fn(f32, f32) -> f32| {
                [0, 1, 2].map(|axis| vectors.iter().map(|vector| vector[axis]).reduce(choose))
            };
            accessor["min"] = json!(fold(f32::min));
            accessor["max"] = json!(fold(f32::max));
        }
        self.push(&bytes, VERTICES, accessor)
    }
}

/// A primitive of the triangles that have a material.
fn primitive(buffer: &mut Buffer, shape: &Shape, normals: &[[Point; 3]], material: usize) -> Value {
    let mut known = std::collections::BTreeMap::new();
    let (mut positions, mut directions, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for (triangle, vertices) in shape.triangles.iter().enumerate() {
        if shape.materials[triangle] != material {
            continue;
        }
        for (vertex, normal) in vertices.iter().zip(normals[triangle]) {
            let steps = (normal * NORMAL_STEPS).round().as_ivec3().to_array();
            let index = *known.entry((*vertex, steps)).or_insert_with(|| {
                positions.push(shape.positions[*vertex as usize].as_vec3().to_array());
                let direction = Point::from_array(steps.map(f64::from)).normalize_or_zero();
                directions.push(direction.as_vec3().to_array());
                positions.len() as u16 - 1
            });
            indices.push(index);
        }
    }
    assert!(positions.len() < usize::from(u16::MAX), "more vertices than 16-bit indices name");
    let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    let accessor =
        json!({"componentType": UNSIGNED_SHORT, "count": indices.len(), "type": "SCALAR"});
    json!({
        "attributes": {
            "POSITION": buffer.push_vectors(&positions, true),
            "NORMAL": buffer.push_vectors(&directions, false),
        },
        "indices": buffer.push(&bytes, INDICES, accessor),
        "material": material,
    })
}

fn nodes(model: &Model) -> Vec<Value> {
    let node = |(index, node): (usize, &super::model::Node)| {
        let mut value = json!({"name": node.name});
        if let Some(mesh) = node.mesh {
            value["mesh"] = json!(mesh);
        }
        if let Some((key, text)) = node.extras {
            value["extras"] = json!({key: text});
        }
        if node.scale != [1.0; 3] {
            value["scale"] = json!(node.scale);
        }
        if node.tilt != 0.0 {
            let (sine, cosine) = (0.5 * node.tilt.to_radians()).sin_cos();
            let round = |value: f64| (value * 1e7).round() / 1e7;
            value["rotation"] = json!([round(sine), 0.0, 0.0, round(cosine)]);
        }
        if node.translation != [0.0; 3] {
            value["translation"] = json!(node.translation);
        }
        let is_child = |(_, other): &(usize, &super::model::Node)| other.parent == Some(index);
        let children: Vec<usize> =
            model.nodes.iter().enumerate().filter(is_child).map(|(child, _)| child).collect();
        if !children.is_empty() {
            value["children"] = json!(children);
        }
        value
    };
    model.nodes.iter().enumerate().map(node).collect()
}

/// The bytes of the file. The same model gives the same bytes.
pub fn glb(model: &Model) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let mut meshes = Vec::new();
    for (shape, name) in model.meshes.iter().zip(&model.mesh_names) {
        let normals = corner_normals(shape);
        let used = (0..model.materials.len()).filter(|material| shape.materials.contains(material));
        let primitives: Vec<Value> =
            used.map(|material| primitive(&mut buffer, shape, &normals, material)).collect();
        meshes.push(json!({"name": name, "primitives": primitives}));
    }
    let material = |material: &super::model::Material| {
        let [r, g, b] = linear(material.colour).map(|light| (f64::from(light) * 1e4).round() / 1e4);
        json!({
            "name": material.name,
            "doubleSided": !model.closed,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": material.metallic,
                "roughnessFactor": material.roughness,
            },
        })
    };
    let roots: Vec<usize> =
        (0..model.nodes.len()).filter(|node| model.nodes[*node].parent.is_none()).collect();
    let document = json!({
        "asset": {
            "version": "2.0",
            "generator": "hullwright: examples/make_assets",
            "copyright": "The Hullwright developers, MIT OR Apache-2.0",
        },
        "scene": 0,
        "scenes": [{"nodes": roots}],
        "nodes": nodes(model),
        "meshes": meshes,
        "materials": model.materials.iter().map(material).collect::<Vec<Value>>(),
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": buffer.bytes.len()}],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + buffer.bytes.len();
    let mut file = Vec::with_capacity(total);
    file.extend(b"glTF");
    file.extend(2u32.to_le_bytes());
    file.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &buffer.bytes)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}
