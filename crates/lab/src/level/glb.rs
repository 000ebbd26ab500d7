//! A level as a binary glTF 2.0: a node for each tile and each prop; props share meshes.

use hullwright::TriangleMesh;
use serde_json::{Value, json};

use super::compose::{Level, TILES};
use crate::shapes::bounds;

/// Numbers of the specification: types of components, and what a buffer view is for.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// Buffer, and what names its parts.
#[derive(Default)]
struct Parts {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
}

/// The bytes of the file. Coordinates of tiles are those of the level, so that the borders of
/// neighbours are the same to the bit.
pub fn bytes(level: &Level) -> Result<Vec<u8>, String> {
    let mut parts = Parts::default();
    for model in &level.models {
        parts.add(&model.name, &model.mesh);
    }
    let mut nodes: Vec<Value> = level
        .props
        .iter()
        .enumerate()
        .map(|(index, prop)| {
            json!({
                "name": format!("prop_{index}"),
                "mesh": prop.model,
                "translation": prop.translation,
                "rotation": prop.rotation,
                "scale": [prop.scale, prop.scale, prop.scale],
            })
        })
        .collect();
    for (index, tile) in level.terrain.tiles().iter().enumerate() {
        let name = format!("terrain_{}_{}", index % TILES, index / TILES);
        let mesh = parts.add(&name, tile);
        nodes.push(json!({ "name": name, "mesh": mesh }));
    }
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "name": "level", "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": parts.meshes,
        "accessors": parts.accessors,
        "bufferViews": parts.views,
        "buffers": [{ "byteLength": parts.bytes.len() }],
    });
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    // Two heads of chunks, and the head of the file.
    let length = u32::try_from(json.len() + parts.bytes.len() + 2 * 8 + 12);
    let length = length.map_err(|_| "the level is more than a GLB can have".to_owned())?;
    let head = |length: u32, kind: &[u8; 4]| [&length.to_le_bytes()[..], kind].concat();
    let file = [b"glTF".to_vec(), [2, length].map(u32::to_le_bytes).concat()].concat();
    let json_head = head(json.len() as u32, b"JSON");
    let bytes_head = head(parts.bytes.len() as u32, b"BIN\0");
    Ok([file, json_head, json, bytes_head, parts.bytes].concat())
}

impl Parts {
    /// Adds a mesh, and says its index.
    fn add(&mut self, name: &str, mesh: &TriangleMesh) -> usize {
        let points = mesh.positions.iter().flatten().flat_map(|&x| (x as f32).to_le_bytes());
        let view = self.view(points.collect(), VERTICES);
        let (low, high) = bounds(&mesh.positions);
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "type": "VEC3",
            "count": mesh.positions.len(),
            "min": low.to_array().map(|x| x as f32), "max": high.to_array().map(|x| x as f32),
        }));
        let indices = mesh.triangles.as_flattened();
        let view = self.view(indices.iter().flat_map(|v| v.to_le_bytes()).collect(), INDICES);
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "type": "SCALAR",
            "count": indices.len(),
        }));
        let last = self.accessors.len() - 1;
        let primitive = json!({ "attributes": { "POSITION": last - 1 }, "indices": last });
        self.meshes.push(json!({ "name": name, "primitives": [primitive] }));
        self.meshes.len() - 1
    }

    /// All content is of four bytes, so that nothing has to be aligned.
    fn view(&mut self, content: Vec<u8>, target: u32) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": content.len(),
            "target": target,
        }));
        self.bytes.extend(content);
        self.views.len() - 1
    }
}
