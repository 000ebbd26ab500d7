//! `hullwright inspect`: what a mesh holds, without decomposing it.

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};
use hullwright::Inspection;
use hullwright::hulls_format::HullsFile;
use hullwright::io::{is_hulls_file, read_mesh};

use crate::Failure;
use crate::output::print;
use crate::progress::waiting;
use crate::tables::{PADDING, repairs};

/// Show counts, bounds, components, open and non-manifold edges, and what would be repaired
#[derive(clap::Args)]
pub struct Arguments {
    /// The mesh: obj, off, ply, stl, gltf or glb; or a .hulls file
    mesh: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if is_hulls_file(&arguments.mesh) {
        let file =
            HullsFile::read(&arguments.mesh).map_err(|error| Failure::Work(error.to_string()))?;
        return print(&left_aligned(baked_rows(&file)).trim_fmt());
    }
    let file = waiting("reading", || read_mesh(&arguments.mesh))
        .map_err(|error| Failure::Work(error.to_string()))?;
    let found = waiting("looking", || hullwright::inspect(&file))
        .map_err(|error| Failure::Work(format!("{}: {error}", arguments.mesh.display())))?;
    print(&table(&found, file.objects.len()).trim_fmt())
}

fn table(found: &Inspection, objects: usize) -> Table {
    let counts = |given: usize, left: usize| {
        if given == left { given.to_string() } else { format!("{given}, {left} after repair") }
    };
    let closed = match found.closed_components {
        closed if closed == found.components => "yes".into(),
        0 => "no".into(),
        closed => format!("{closed} of {} components", found.components),
    };
    let volume = match found.closed_components {
        0 => "nothing is closed".into(),
        _ => number(found.volume),
    };
    let repairs = repairs(&found.repairs);
    let repairs = if repairs.is_empty() { "none needed".into() } else { repairs.join(", ") };

    left_aligned([
        ("objects", objects.to_string()),
        ("vertices", counts(found.source_vertices, found.vertices)),
        ("triangles", counts(found.source_triangles, found.triangles)),
        ("bounds from", point(found.bounds.min)),
        ("bounds to", point(found.bounds.max)),
        ("diagonal", number(found.diagonal)),
        ("area", number(found.area)),
        ("components", found.components.to_string()),
        ("open edges", found.repairs.open_edges.to_string()),
        ("non-manifold edges", found.repairs.non_manifold_edges.to_string()),
        ("closed", closed),
        ("volume", volume),
        ("repairs", repairs),
    ])
}

/// What a `.hulls` file says.
fn baked_rows(file: &HullsFile) -> Vec<(&'static str, String)> {
    let vertices: usize = file.hulls.iter().map(|hull| hull.shape.points.len()).sum();
    let length = |value: f64| match file.diagonal {
        0.0 => number(value),
        diagonal => format!("{}, {:.2} % of the diagonal", number(value), 100.0 * value / diagonal),
    };
    let algorithm = match file.is_current() {
        true => file.algorithm_version.to_string(),
        false => format!("{}, another than this program's", file.algorithm_version),
    };
    let mut rows = vec![
        ("mesh", file.name.clone()),
        ("hulls", file.hulls.len().to_string()),
        ("vertices", vertices.to_string()),
        ("source triangles", file.source_triangles.to_string()),
        ("diagonal", number(file.diagonal)),
        ("method", file.method.clone()),
        ("algorithm version", algorithm),
    ];
    rows.extend(file.bound.map(|bound| ("bound", length(bound))));
    if let Some(verified) = file.verified {
        rows.push(("phantom", format!("at most {}", length(verified.protrusion_max))));
        rows.push(("exposed", format!("at most {}", length(verified.uncovered_max))));
    }
    if let Some(properties) = file.mass_properties {
        rows.push(("mass", number(properties.mass)));
        rows.push(("centre of mass", point(properties.centre)));
    }
    rows
}

fn left_aligned(rows: impl IntoIterator<Item = (&'static str, String)>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    for (name, value) in rows {
        table.add_row([name.to_owned(), value]);
    }
    for column in table.column_iter_mut() {
        column.set_padding(PADDING);
        column.set_cell_alignment(CellAlignment::Left);
    }
    table
}

fn point([x, y, z]: [f64; 3]) -> String {
    format!("{}, {}, {}", number(x), number(y), number(z))
}

/// Six significant digits tell one mesh from another.
const DIGITS: i32 = 6;

/// Plain within a few powers of ten, else with an exponent.
fn number(value: f64) -> String {
    let magnitude = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if !(-4..DIGITS + 3).contains(&magnitude) {
        return format!("{value:.*e}", DIGITS as usize - 1);
    }
    let decimals = (DIGITS - 1 - magnitude).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits_and_no_empty_decimals() {
        for (value, expected) in [
            (0.0, "0"),
            (2.0, "2"),
            (-0.123456789, "-0.123457"),
            (1234.56789, "1234.57"),
            (12345678.0, "12345678"),
            (1.5e-9, "1.50000e-9"),
            (-2e20, "-2.00000e20"),
        ] {
            assert_eq!(number(value), expected);
        }
    }
}
