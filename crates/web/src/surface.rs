//! A surface with few triangles.

use hullwright::{SimplifiedSurface, SimplifyParameters, simplify_surface};
use js_sys::Function;
use serde_json::to_value;
use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

use crate::calls::control;
use crate::errors::{library, parameter};
use crate::mesh::Mesh;

/// What simplifying gives.
#[wasm_bindgen]
pub struct Simplified {
    made: SimplifiedSurface,
}

/// Makes a surface with few triangles within a bound of a mesh. `settings` is
/// [`SimplifyParameters`] as text.
///
/// # Errors
/// The library's.
#[wasm_bindgen]
pub fn simplify(
    mesh: &Mesh,
    settings: &str,
    progress: Option<Function>,
) -> Result<Simplified, JsValue> {
    let parameters: SimplifyParameters = settings.parse().map_err(parameter)?;
    let made = simplify_surface(&mesh.mesh, parameters, &control(progress)).map_err(library)?;
    Ok(Simplified { made })
}

#[wasm_bindgen]
impl Simplified {
    /// Three numbers a vertex.
    #[wasm_bindgen(getter)]
    pub fn positions(&self) -> Vec<f64> {
        self.made.mesh.positions.as_flattened().to_vec()
    }

    /// Three a triangle.
    #[wasm_bindgen(getter)]
    pub fn indices(&self) -> Vec<u32> {
        self.made.mesh.triangles.as_flattened().to_vec()
    }

    /// For each triangle one of the mesh.
    #[wasm_bindgen(getter)]
    pub fn sources(&self) -> Vec<u32> {
        self.made.sources.clone()
    }

    /// The triangles of the mesh that nothing can touch.
    #[wasm_bindgen(getter)]
    pub fn hidden(&self) -> Vec<u32> {
        self.made.hidden.clone()
    }

    /// The library's report. JSON.
    #[wasm_bindgen(getter)]
    pub fn report(&self) -> String {
        to_value(self.made.report).unwrap_or_default().to_string()
    }
}
