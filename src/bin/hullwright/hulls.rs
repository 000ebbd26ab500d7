//! What several commands do with hulls.

use std::path::Path;

use hullwright::hulls_format::HullsFile;
use hullwright::{Decomposition, Error, Hull, MeshView, MethodReport, Parameters};

use crate::output::count;

/// Mass per cubed unit. With 1 the mass is the volume, which any density can be multiplied with.
pub const DEFAULT_DENSITY: f64 = 1.0;

/// Vertices of all hulls.
pub fn vertices(hulls: &[Hull]) -> usize {
    hulls.iter().map(|hull| hull.shape.points.len()).sum()
}

/// What a `.hulls` file holds of a mesh. `solid` describes what its mass is computed from.
pub fn hulls_file(
    name: impl Into<String>,
    mesh: MeshView<'_>,
    decomposition: &Decomposition<MethodReport>,
    solid: &Parameters,
    density: f64,
) -> Result<HullsFile, Error> {
    let hulls = &decomposition.hulls;
    let properties = hullwright::mass_properties_with(mesh, hulls, density, solid)?;
    Ok(HullsFile::new(name, decomposition).with_mass_properties(properties))
}

/// Says that hulls were written to a file.
pub fn wrote(output: &Path, hulls: &[Hull]) -> String {
    let vertices = count(vertices(hulls), "vertex", "vertices");
    format!("wrote {}: {}, {vertices}", output.display(), count(hulls.len(), "hull", "hulls"))
}
