//! `hullwright inspect`: what a mesh holds, without decomposing it.

use std::path::PathBuf;

use hullwright::hulls_format::HullsFile;
use hullwright::io::{is_hulls_file, read_mesh};
use hullwright::{Inspection, Opening};
use hullwright_cli::terminal::{Failure, print};

use crate::arguments::{SolidArguments, mesh_help};
use crate::progress::waiting;
use crate::report::{columns, openings, pairs, repairs, vertices};

/// Show counts, bounds, components, open and non-manifold edges, and what would be repaired
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = format!("{}; or a .hulls file", mesh_help()))]
    mesh: PathBuf,

    #[command(flatten)]
    solid: SolidArguments,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if is_hulls_file(&arguments.mesh) {
        return print(&pairs(hulls_file_rows(&HullsFile::read(&arguments.mesh)?)));
    }
    let file = waiting("reading", || read_mesh(&arguments.mesh))?;
    let parameters = arguments.solid.parameters();
    let found = waiting("inspecting", || hullwright::inspect_with(&file, &parameters))
        .map_err(|error| format!("{}: {error}", arguments.mesh.display()))?;
    print(&pairs(rows(&found, file.objects.len())))?;
    match found.openings.is_empty() {
        true => Ok(()),
        false => print(&format!("\n{}", openings_table(&found.openings))),
    }
}

/// A row for each opening.
fn openings_table(openings: &[Opening]) -> String {
    let row = |opening: &Opening| {
        let outcome = opening.outcome.describe().into();
        [opening.edges.to_string(), number(opening.area), point(opening.centre), outcome]
    };
    columns(&["edges", "area", "middle", "opening"], openings.iter().map(row))
}

fn rows(found: &Inspection, objects: usize) -> [(&'static str, String); 14] {
    let counts = |given: usize, left: usize| {
        if given == left { given.to_string() } else { format!("{given}, {left} after repair") }
    };
    let closed = match found.closed_components {
        closed if closed == found.components => "yes".into(),
        0 => "no".into(),
        closed => format!("{closed} of {} components", found.components),
    };
    let volume = match found.volume {
        0.0 => "nothing is closed".into(),
        volume => number(volume),
    };
    let repairs = repairs(&found.repairs);
    let repairs = if repairs.is_empty() { "none needed".into() } else { repairs.join(", ") };

    [
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
        ("openings", openings(&found.openings).unwrap_or_else(|| "none".into())),
        ("volume", volume),
        ("repairs", repairs),
    ]
}

/// What a `.hulls` file says.
fn hulls_file_rows(file: &HullsFile) -> Vec<(&'static str, String)> {
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
        ("vertices", vertices(&file.hulls).to_string()),
        ("source triangles", file.source_triangles.to_string()),
        ("diagonal", number(file.diagonal)),
        ("method", file.method.clone()),
        ("algorithm version", algorithm),
    ];
    rows.extend(file.bound.map(|bound| ("bound", length(bound))));
    if let Some(verified) = file.verified {
        rows.push(("protrusion", format!("at most {}", length(verified.protrusion_max))));
        rows.push(("uncovered", format!("at most {}", length(verified.uncovered_max))));
    }
    if let Some(properties) = file.mass_properties {
        rows.push(("mass", number(properties.mass)));
        rows.push(("centre of mass", point(properties.centre)));
    }
    rows
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
