//! The library's functions.

use std::cell::RefCell;

use hullwright::hulls_format::HullsFile;
use hullwright::measure::{MeasureOptions, measure as measure_hulls};
use hullwright::{
    ALGORITHM_VERSION, Control, MassProperties, MergeTree, Parameters, Progress,
    mass_properties_with,
};
use js_sys::Function;
use serde_json::{Value, json, to_value};
use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

use crate::errors::{error, hulls_file, library, parameter};
use crate::hulls::{HullArrays, HullList};
use crate::mesh::Mesh;

/// Makes an error with the message of every panic. Runs when the module is instantiated.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|info| wasm_bindgen::throw_val(error("trap", &info))));
}

/// Changes whenever the same input and parameters may give another result.
#[wasm_bindgen(js_name = algorithmVersion)]
pub fn algorithm_version() -> u32 {
    ALGORITHM_VERSION
}

thread_local! {
    // A function of JavaScript stays on its thread, and a listener of `Control` may not.
    static LISTENER: RefCell<Option<Function>> = const { RefCell::new(None) };
}

/// Calls `progress`, if there is one, with a stage and a fraction.
pub(crate) fn control(progress: Option<Function>) -> Control {
    let is_heard = progress.is_some();
    LISTENER.set(progress);
    let control = Control::new().with_parallel(false);
    if !is_heard {
        return control;
    }
    control.with_progress(|Progress { stage, fraction, .. }| {
        LISTENER.with_borrow(|listener| {
            if let Some(listener) = listener {
                // What a listener throws changes no result.
                let _ = listener.call2(&JsValue::NULL, &stage.name().into(), &fraction.into());
            }
        });
    })
}

pub(crate) fn parameters(text: &str) -> Result<Parameters, JsValue> {
    text.parse().map_err(parameter)
}

/// Numbers and texts always have a form in JSON.
fn text(value: Result<Value, serde_json::Error>) -> String {
    value.unwrap_or_default().to_string()
}

/// What a decomposition gives.
#[wasm_bindgen]
pub struct Decomposed {
    hulls: HullList,
    report: String,
    file: Vec<u8>,
}

/// Decomposes a mesh. `settings` is [`Parameters`] as text.
///
/// # Errors
/// The library's.
#[wasm_bindgen]
pub fn decompose(
    mesh: &Mesh,
    settings: &str,
    progress: Option<Function>,
) -> Result<Decomposed, JsValue> {
    let parameters = parameters(settings)?;
    let result =
        hullwright::decompose(&mesh.mesh, &parameters, &control(progress)).map_err(library)?;
    let mass =
        mass_properties_with(&mesh.mesh, &result.hulls, 1.0, &parameters).map_err(library)?;
    let report = json!({
        "report": to_value(result.report).unwrap_or_default(),
        "run": to_value(&result.run).unwrap_or_default(),
        "remarks": result.remarks(),
        "mass": mass_report(&mass),
    });
    let file = HullsFile::new("", &result).with_mass_properties(mass);
    let file = file.to_bytes().map_err(hulls_file)?;
    Ok(Decomposed { hulls: HullList { hulls: result.hulls }, report: report.to_string(), file })
}

/// With a density of 1.
pub(crate) fn mass_report(mass: &MassProperties) -> Value {
    let principal = mass.principal_inertia();
    json!({
        "volume": mass.mass,
        "centre": mass.centre,
        "inertia": mass.inertia,
        "principal_moments": principal.moments,
        "principal_rotation": principal.rotation,
        "source": to_value(mass.source).unwrap_or_default(),
    })
}

#[wasm_bindgen]
impl Decomposed {
    /// In single precision.
    ///
    /// # Errors
    /// As [`HullList::arrays`].
    pub fn arrays(&self) -> Result<HullArrays, JsValue> {
        self.hulls.arrays()
    }

    /// JSON: `report` and `run` as the library has them, `remarks` in words, `mass`.
    #[wasm_bindgen(getter)]
    pub fn report(&self) -> String {
        self.report.clone()
    }

    /// The bytes of a `.hulls` file, with mass properties for a density of 1.
    #[wasm_bindgen(getter)]
    pub fn file(&self) -> Vec<u8> {
        self.file.clone()
    }
}

/// Samples how far hulls are from a mesh. JSON.
///
/// # Errors
/// The library's.
#[wasm_bindgen]
pub fn measure(mesh: &Mesh, hulls: &HullList, settings: &str) -> Result<String, JsValue> {
    let options = MeasureOptions::from(&parameters(settings)?);
    let found =
        measure_hulls(&mesh.mesh, &hulls.hulls, &options, &control(None)).map_err(library)?;
    Ok(text(to_value(found)))
}

/// What hulls are joined to, from all of them down to one.
#[wasm_bindgen]
pub struct Joined {
    curve: String,
    joined: Vec<u32>,
    joints: HullList,
}

/// Joins hulls down to one.
///
/// # Errors
/// The library's.
#[wasm_bindgen(js_name = mergeTree)]
pub fn merge_tree(mesh: &Mesh, hulls: &HullList, settings: &str) -> Result<Joined, JsValue> {
    let parameters = parameters(settings)?;
    let tree = MergeTree::from_hulls(&mesh.mesh, &hulls.hulls, &parameters, &control(None))
        .map_err(library)?;
    let (joined, joints) = tree
        .joins()
        .into_iter()
        .map(|join| (join.joined.map(|hull| hull as u32), join.hull))
        .unzip();
    let joined: Vec<[u32; 2]> = joined;
    Ok(Joined {
        curve: text(to_value(tree.curve())),
        joined: joined.as_flattened().to_vec(),
        joints: HullList { hulls: joints },
    })
}

#[wasm_bindgen]
impl Joined {
    /// JSON: hulls and errors of each state.
    #[wasm_bindgen(getter)]
    pub fn curve(&self) -> String {
        self.curve.clone()
    }

    /// Two for each join: which hulls give way. Those given come first, then the joint ones.
    #[wasm_bindgen(getter)]
    pub fn joined(&self) -> Vec<u32> {
        self.joined.clone()
    }

    /// The joint hulls, in single precision.
    ///
    /// # Errors
    /// As [`HullList::arrays`].
    pub fn arrays(&self) -> Result<HullArrays, JsValue> {
        self.joints.arrays()
    }
}
