//! A mesh in flat arrays.

use std::ops::Range;

use hullwright::{Sidedness, TriangleMesh};
use serde_json::{Value, json};
use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

use crate::errors::argument;

/// Positions, three numbers a vertex; indices, three a triangle; and for each triangle whether both
/// its sides are drawn.
#[wasm_bindgen]
pub struct Mesh {
    pub(crate) mesh: TriangleMesh,
    pub(crate) parts: Vec<Part>,
}

/// A named part of a mesh, in triangles.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub name: String,
    pub triangles: Range<usize>,
}

#[wasm_bindgen]
impl Mesh {
    /// `double_sided` may be empty: then nothing is known of that.
    ///
    /// # Errors
    /// `invalid_argument` if positions or indices do not come in threes.
    #[wasm_bindgen(constructor)]
    pub fn new(positions: &[f64], indices: &[u32], double_sided: &[u8]) -> Result<Mesh, JsValue> {
        let (positions, []) = positions.as_chunks() else {
            return Err(argument("the number of positions is not a multiple of 3"));
        };
        let (triangles, []) = indices.as_chunks() else {
            return Err(argument("the number of indices is not a multiple of 3"));
        };
        let sidedness = |&is_double: &u8| match is_double {
            0 => Sidedness::One,
            _ => Sidedness::Two,
        };
        let mesh = TriangleMesh {
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            sidedness: double_sided.iter().map(sidedness).collect(),
        };
        Ok(Self { mesh, parts: Vec::new() })
    }

    /// Three numbers a vertex.
    #[wasm_bindgen(getter)]
    pub fn positions(&self) -> Vec<f64> {
        self.mesh.positions.as_flattened().to_vec()
    }

    /// Three a triangle.
    #[wasm_bindgen(getter)]
    pub fn indices(&self) -> Vec<u32> {
        self.mesh.triangles.as_flattened().to_vec()
    }

    /// A byte a triangle, 1 where both sides are drawn; empty where nothing is known.
    #[wasm_bindgen(getter, js_name = doubleSided)]
    pub fn double_sided(&self) -> Vec<u8> {
        self.mesh.sidedness.iter().map(|side| u8::from(*side == Sidedness::Two)).collect()
    }

    /// The named parts: JSON, a list of `{name, start, count}` in triangles.
    #[wasm_bindgen(getter)]
    pub fn objects(&self) -> String {
        let part = |Part { name, triangles }: &Part| json!({ "name": name, "start": triangles.start, "count": triangles.len() });
        Value::Array(self.parts.iter().map(part).collect()).to_string()
    }
}
