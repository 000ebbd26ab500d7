//! Hulls: in single precision for engines, in double precision from `.hulls` files.

use hullwright::hulls_format::HullsFile;
use hullwright::{Error, Hull, convex_hull};
use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

use crate::errors::{argument, hulls_file, library};

/// Hulls of a decomposition, of a `.hulls` file or of any tool.
#[wasm_bindgen]
pub struct HullList {
    pub(crate) hulls: Vec<Hull>,
}

#[wasm_bindgen]
impl HullList {
    /// The hulls of a `.hulls` file, with their verified errors.
    ///
    /// # Errors
    /// `hulls_file` says what is wrong with it.
    #[wasm_bindgen(js_name = fromFile)]
    pub fn from_file(bytes: &[u8]) -> Result<HullList, JsValue> {
        let file = HullsFile::from_bytes(bytes).map_err(hulls_file)?;
        Ok(Self { hulls: file.hulls })
    }

    /// The convex hulls of sets of points: `counts` are their numbers of points.
    ///
    /// # Errors
    /// `invalid_argument` if the counts do not add up; `no_hull` for a set without volume.
    #[wasm_bindgen(js_name = fromPoints)]
    pub fn from_points(points: &[f64], counts: &[u32]) -> Result<HullList, JsValue> {
        let (mut rest, []) = points.as_chunks::<3>() else {
            return Err(argument("the number of coordinates is not a multiple of 3"));
        };
        let mut hulls = Vec::new();
        for &count in counts {
            let Some((points, others)) = rest.split_at_checked(count as usize) else {
                return Err(argument("there are fewer points than the counts say"));
            };
            hulls.push(convex_hull(points).map_err(library)?.into());
            rest = others;
        }
        Ok(Self { hulls })
    }

    /// In single precision, each convex as it stands.
    ///
    /// # Errors
    /// `no_hull` if a coordinate is beyond the range of single precision.
    pub fn arrays(&self) -> Result<HullArrays, JsValue> {
        arrays(&self.hulls).map_err(library)
    }
}

/// Hulls one after the other.
#[wasm_bindgen]
#[derive(Default)]
pub struct HullArrays {
    points: Vec<f32>,
    indices: Vec<u32>,
    point_counts: Vec<u32>,
    index_counts: Vec<u32>,
    protrusions: Vec<f64>,
}

fn arrays(hulls: &[Hull]) -> Result<HullArrays, Error> {
    let mut all = HullArrays::default();
    for hull in hulls {
        let (points, triangles) = hull.shape.to_single_precision()?;
        all.points.extend_from_slice(points.as_flattened());
        all.indices.extend_from_slice(triangles.as_flattened());
        all.point_counts.push(points.len() as u32);
        all.index_counts.push(3 * triangles.len() as u32);
        all.protrusions.push(hull.errors.protrusion_max.unwrap_or(f64::NAN));
    }
    Ok(all)
}

#[wasm_bindgen]
impl HullArrays {
    /// Three numbers a point.
    #[wasm_bindgen(getter)]
    pub fn points(&self) -> Vec<f32> {
        self.points.clone()
    }

    /// Three a triangle; each hull's begin at 0.
    #[wasm_bindgen(getter)]
    pub fn indices(&self) -> Vec<u32> {
        self.indices.clone()
    }

    /// Points of each hull.
    #[wasm_bindgen(getter, js_name = pointCounts)]
    pub fn point_counts(&self) -> Vec<u32> {
        self.point_counts.clone()
    }

    /// Indices of each hull.
    #[wasm_bindgen(getter, js_name = indexCounts)]
    pub fn index_counts(&self) -> Vec<u32> {
        self.index_counts.clone()
    }

    /// The verified protrusion of each hull, in the mesh's units; not a number where nothing was
    /// verified.
    #[wasm_bindgen(getter)]
    pub fn protrusions(&self) -> Vec<f64> {
        self.protrusions.clone()
    }
}
