//! A decomposition that stays: its hulls in every state of the merge tree, and all that a page of
//! `hullwright view` shows.

use hullwright::surface::SurfaceParameters;
use hullwright::{
    Error, MassProperties, MergeTree, Method, Parameters, decompose, mass_properties_with,
};
use hullwright_cli::viewer::{HullSet, Page};
use hullwright_formats::{HullFormat, Object, hulls_to_bytes};
use js_sys::Function;
use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

use crate::calls::{control, mass_report, parameters};
use crate::errors::{hulls_file, library};
use crate::hulls::{HullArrays, HullList};
use crate::mesh::{Mesh, Part};

/// A decomposition and what a page shows of it.
#[wasm_bindgen]
pub struct Shown {
    tree: MergeTree,
    mass: MassProperties,
    document: String,
    geometry: Vec<u8>,
    remarks: Vec<String>,
}

#[wasm_bindgen]
impl Shown {
    /// Decomposes a mesh, joins the hulls, and measures all of them. `settings` is
    /// [`Parameters`](hullwright::Parameters) as text; with `compares`, the paper's hulls stand
    /// beside.
    ///
    /// # Errors
    /// The library's.
    #[wasm_bindgen(constructor)]
    pub fn new(
        mesh: &Mesh,
        title: &str,
        settings: &str,
        compares: bool,
        progress: Option<Function>,
    ) -> Result<Shown, JsValue> {
        let parameters = parameters(settings)?;
        shown(mesh, title, &parameters, compares, progress).map_err(library)
    }

    /// The page's text, JSON.
    #[wasm_bindgen(getter)]
    pub fn document(&self) -> String {
        self.document.clone()
    }

    /// The bytes of its arrays.
    #[wasm_bindgen(getter)]
    pub fn geometry(&self) -> Vec<u8> {
        self.geometry.clone()
    }

    /// What was repaired and closed, and why the bound is exceeded if it is, one line each.
    #[wasm_bindgen(getter)]
    pub fn remarks(&self) -> String {
        self.remarks.join("\n")
    }

    /// The mesh's mass properties for a density of 1, JSON.
    #[wasm_bindgen(getter)]
    pub fn mass(&self) -> String {
        mass_report(&self.mass).to_string()
    }

    /// The state with at most `most` hulls, in single precision.
    ///
    /// # Errors
    /// As [`HullList::arrays`].
    pub fn hulls(&self, most: usize) -> Result<HullArrays, JsValue> {
        HullList { hulls: self.tree.at_hulls(most) }.arrays()
    }

    /// The same as a `.hulls` file.
    ///
    /// # Errors
    /// `hulls_file`.
    pub fn file(&self, name: &str, most: usize) -> Result<Vec<u8>, JsValue> {
        let file = self.tree.to_file(name, most).with_mass_properties(self.mass);
        file.to_bytes().map_err(hulls_file)
    }

    /// The same as a GLB file.
    ///
    /// # Errors
    /// `file`.
    pub fn glb(&self, most: usize) -> Result<Vec<u8>, JsValue> {
        hulls_to_bytes(HullFormat::Glb, &self.tree.at_hulls(most)).map_err(library)
    }
}

fn shown(
    mesh: &Mesh,
    title: &str,
    parameters: &Parameters,
    compares: bool,
    progress: Option<Function>,
) -> Result<Shown, Error> {
    let control = control(progress);
    let result = decompose(&mesh.mesh, parameters, &control)?;
    let seconds = result.run.times.iter().map(|time| time.seconds).sum();
    let tree = MergeTree::new(&mesh.mesh, &result, parameters, &control)?;
    let mass = mass_properties_with(&mesh.mesh, &result.hulls, 1.0, parameters)?;
    let object = |Part { name, triangles }: &Part| Object {
        name: name.clone(),
        triangles: triangles.clone(),
    };
    let objects: Vec<Object> = mesh.parts.iter().map(object).collect();
    let mut page = Page::new(title, &mesh.mesh, parameters, &control)?.objects(&objects);
    let name = format!("bounded, {}", parameters.max_error);
    let set = HullSet::new(name, &result.hulls).tree(&tree).fact("time", milliseconds(seconds));
    page.add(set, &control)?;
    if compares {
        let other =
            Method::Surface(SurfaceParameters::default()).decompose(&mesh.mesh, &control)?;
        let tree = MergeTree::from_hulls(&mesh.mesh, &other.hulls, parameters, &control)?;
        page.add(HullSet::new("surface (the paper's)", &other.hulls).tree(&tree), &control)?;
    }
    let (document, geometry) = page.data()?;
    let geometry = geometry.to_vec();
    Ok(Shown { tree, mass, document, geometry, remarks: result.remarks() })
}

fn milliseconds(seconds: f64) -> String {
    format!("{:.0} ms", 1000.0 * seconds)
}
