//! `hullwright measure --surface`: how far a mesh and one that stands for it are from each other.

use std::path::Path;

use hullwright::inspect::inspect;
use hullwright::{Control, HiddenTriangles, SurfaceDistance, SurfaceDistances, surface_distances};
use hullwright_cli::terminal::{Failure, print, print_json, print_warning};
use hullwright_formats::MeshFile;
use serde_json::{Value, json};

use crate::notes::read_with_warnings;
use crate::progress::waiting;

/// Surfaces that are farther apart than this fraction of the diagonal hardly belong together.
const FOREIGN: f64 = 0.5;

/// What is measured.
pub struct Surfaces<'a> {
    pub mesh: &'a Path,
    pub simplified: &'a Path,
    pub keep_hidden: bool,
}

pub fn run(surfaces: &Surfaces<'_>, as_json: bool) -> Result<(), Failure> {
    let &Surfaces { mesh, simplified, keep_hidden } = surfaces;
    let (source, result) = (read_with_warnings(mesh)?, read_with_warnings(simplified)?);
    let hidden = if keep_hidden { HiddenTriangles::Kept } else { HiddenTriangles::Found };
    let measured =
        waiting("measuring", || surface_distances(&source, &result, hidden, &Control::new()));
    let found = measured.map_err(|error| {
        let path = if inspect(&source).is_err() { mesh } else { simplified };
        format!("{}: {error}", path.display())
    })?;
    let least = found.from_a_to_b.at_least.max(found.from_b_to_a.at_least);
    if least > FOREIGN * found.diagonal {
        print_warning(&format!(
            "{} and {} are {:.0} % of the diagonal apart: units or places may differ",
            mesh.display(),
            simplified.display(),
            100.0 * least / found.diagonal
        ));
    }
    if as_json {
        return print_json(&line(surfaces, [&source, &result], &found));
    }
    print(&text([&source, &result], &found))
}

/// Lines of a name and a value.
fn text([source, result]: [&MeshFile; 2], found: &SurfaceDistances) -> String {
    let triangles = |file: &MeshFile, hidden: &[u32]| match hidden.len() {
        0 => file.mesh.triangles.len().to_string(),
        hidden => format!("{}, of them {hidden} hidden", file.mesh.triangles.len()),
    };
    let distance = |distance: SurfaceDistance| {
        let SurfaceDistance { at_most, at_least, .. } = distance;
        let share = 100.0 * at_most / found.diagonal;
        format!("{} ({share:.4} % of the diagonal), at least {}", digits(at_most), digits(at_least))
    };
    let rows = [
        ("triangles of the mesh", triangles(source, &found.hidden_of_a)),
        ("triangles of the result", triangles(result, &found.hidden_of_b)),
        ("diagonal of the mesh", digits(found.diagonal)),
        ("result from mesh, at most", distance(found.from_b_to_a)),
        ("mesh from result, at most", distance(found.from_a_to_b)),
        ("resolution", format!("{} % of a distance", 100.0 * SurfaceDistances::RESOLUTION)),
    ];
    rows.map(|(name, value)| format!("{name:<25}  {value}")).join("\n")
}

/// Four digits that count, or none where it is next to nothing.
fn digits(length: f64) -> String {
    let size = length.abs().log10().floor();
    match size {
        _ if length == 0.0 => "0".into(),
        -4.0..=6.0 => format!("{length:.*}", (3.0 - size).max(0.0) as usize),
        _ => format!("{length:.3e}"),
    }
}

/// Lengths are in the mesh's units, as in all lines of JSON.
fn line(
    surfaces: &Surfaces<'_>,
    [source, result]: [&MeshFile; 2],
    found: &SurfaceDistances,
) -> Value {
    json!({
        "mesh": surfaces.mesh.display().to_string(),
        "result": surfaces.simplified.display().to_string(),
        "from_source": found.from_b_to_a.at_most,
        "from_source_at_least": found.from_b_to_a.at_least,
        "to_source": found.from_a_to_b.at_most,
        "to_source_at_least": found.from_a_to_b.at_least,
        "resolution": SurfaceDistances::RESOLUTION,
        "source_triangles": source.mesh.triangles.len(),
        "triangles": result.mesh.triangles.len(),
        "hidden_triangles": found.hidden_of_a.len(),
        "hidden_triangles_of_result": found.hidden_of_b.len(),
        "diagonal": found.diagonal,
        "version": env!("CARGO_PKG_VERSION"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_four_digits() {
        let lengths = [0.0, 1.0, 0.012_345_6, 123.456, 98_765.4, 1.25e-9, 3e9];
        let shown = ["0", "1.000", "0.01235", "123.5", "98765", "1.250e-9", "3.000e9"];
        assert_eq!(lengths.map(digits), shown);
    }
}
