//! Mesh files, from bytes.

use std::collections::BTreeMap;

use hullwright_formats::{Format, MeshFile, Object, read_mesh_from_files};
use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

use crate::errors::{argument, library};
use crate::mesh::{Mesh, Part};

/// Files by their paths, of which one is read.
#[wasm_bindgen]
#[derive(Default)]
pub struct MeshReader {
    files: BTreeMap<String, Vec<u8>>,
}

#[wasm_bindgen]
impl MeshReader {
    /// Without files yet.
    #[wasm_bindgen(constructor)]
    pub fn new() -> MeshReader {
        Self::default()
    }

    /// Adds a file that the one to read may name.
    pub fn add(&mut self, path: String, bytes: Vec<u8>) {
        self.files.insert(path, bytes);
    }

    /// Reads a file of a format: `obj`, `off`, `ply`, `stl`, `gltf` or `glb`.
    ///
    /// A glTF names others by paths relative to its own. A browser may only have their names: then
    /// the last part of the path is enough.
    ///
    /// # Errors
    /// `file` says what is wrong with it, and where.
    pub fn read(&self, format: &str, bytes: &[u8]) -> Result<Mesh, JsValue> {
        let Some(format) = Format::from_path(format!("mesh.{format}")) else {
            return Err(argument(&format!("`{format}` is not {}", Format::suffix_list())));
        };
        let beside = |path: &str| {
            let name = path.rsplit('/').next().unwrap_or(path);
            self.files.get(path).or_else(|| self.files.get(name)).cloned()
        };
        let MeshFile { mesh, objects, .. } =
            read_mesh_from_files(format, bytes, &beside).map_err(library)?;
        let part = |Object { name, triangles }| Part { name, triangles };
        Ok(Mesh { mesh, parts: objects.into_iter().map(part).collect() })
    }
}
