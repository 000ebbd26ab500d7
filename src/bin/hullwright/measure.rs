//! `hullwright measure`: judges hulls, ours or another tool's, against their mesh.

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};
use hullwright::Control;
use hullwright::io::{read_hulls, read_mesh};
use hullwright::measure::{Distances, MeasureOptions, Measurement, measure};
use serde_json::{Value, json};

use crate::Failure;
use crate::output::print;
use crate::progress::waiting;
use crate::tables::PADDING;

/// Judge a set of hulls, of any tool, against the mesh that they stand for
///
/// Phantom is how far the hulls stick out of the solid, exposed how far the mesh sticks out of the
/// hulls, hollow the share of the solid in no hull. Lengths are shares of the diagonal of the
/// mesh's bounding box. Points are sampled, always the same.
#[derive(clap::Args)]
pub struct Arguments {
    /// The mesh: obj, off, ply, stl, gltf or glb
    mesh: PathBuf,

    /// The hulls: a .hulls file, or one per object of the file: obj, stl, gltf or glb
    hulls: PathBuf,

    /// Print one line of JSON instead of a table
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let work = |error: hullwright::Error| Failure::Work(error.to_string());
    let mesh = waiting("reading", || read_mesh(&arguments.mesh)).map_err(work)?;
    let hulls = waiting("reading", || read_hulls(&arguments.hulls)).map_err(work)?;
    let options = MeasureOptions::default();
    let judged = waiting("measuring", || measure(&mesh, &hulls, &options, &Control::new()));
    let found = judged.map_err(|error| {
        let path = match error {
            hullwright::Error::NoHulls | hullwright::Error::UnusableHull { .. } => &arguments.hulls,
            _ => &arguments.mesh,
        };
        Failure::Work(format!("{}: {error}", path.display()))
    })?;
    if arguments.json {
        return print(&json_line(arguments, &found));
    }
    print(&text(&found))
}

fn json_line(arguments: &Arguments, found: &Measurement) -> String {
    let distances = |distances: Distances| -> Value {
        json!({ "mean": distances.mean, "p99": distances.p99, "max": distances.max })
    };
    json!({
        "mesh": arguments.mesh.display().to_string(),
        "hulls_file": arguments.hulls.display().to_string(),
        "hulls": found.hulls,
        "vertices": found.vertices,
        "unusable_hulls": found.unusable_hulls,
        "non_convex_hulls": found.non_convex_hulls,
        "worst_concavity": found.worst_concavity,
        "open_hulls": found.open_hulls,
        "non_positive_volumes": found.non_positive_volumes,
        "phantom": distances(found.protrusion),
        "exposed": distances(found.uncovered),
        "hausdorff": found.hausdorff,
        "hollow": found.uncovered_volume,
        "iou": found.iou,
        "overlap": found.overlap,
        "open_edges": found.open_edges,
        "diagonal": found.diagonal,
        "samples": {
            "hull": found.samples.hull,
            "boundary": found.samples.boundary,
            "mesh": found.samples.mesh,
            "volume": found.samples.volume,
            "solid": found.samples.solid,
            "in_hulls": found.samples.in_hulls,
            "union": found.samples.union,
        },
        "version": env!("CARGO_PKG_VERSION"),
    })
    .to_string()
}

fn text(found: &Measurement) -> String {
    let of_all = |flagged: usize| format!("{flagged} of {}", found.hulls);
    let convex = match found.non_convex_hulls {
        0 => "all".into(),
        flagged => format!("not {}", of_all(flagged)),
    };
    let mut rows = vec![
        ("hulls", found.hulls.to_string()),
        ("vertices", found.vertices.to_string()),
        ("convex", format!("{convex}, off by at most {}", length(found.worst_concavity))),
    ];
    for (name, flagged) in [
        ("not closed", found.open_hulls),
        ("no volume or wound inward", found.non_positive_volumes),
    ] {
        if flagged > 0 {
            rows.push((name, of_all(flagged)));
        }
    }
    if found.unusable_hulls > 0 {
        rows.push(("left out as unusable", found.unusable_hulls.to_string()));
    }
    rows.extend([
        ("phantom", distances(found.protrusion)),
        ("exposed", distances(found.uncovered)),
        ("Hausdorff", length(found.hausdorff)),
        ("hollow", share(found.uncovered_volume)),
        ("volume IoU", share(found.iou)),
        ("overlap", found.overlap.map_or_else(nothing, |overlap| format!("{overlap:.3}"))),
    ]);
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    for (name, value) in rows {
        table.add_row([name.to_owned(), value]);
    }
    for column in table.column_iter_mut() {
        column.set_padding(PADDING);
        column.set_cell_alignment(CellAlignment::Left);
    }
    let samples = &found.samples;
    let mut text = format!(
        "{}\n\nlengths are shares of the mesh's diagonal, {}\n\
         points: {} on hulls ({} of them on the boundary of all), {} on the mesh, {} in space",
        table.trim_fmt(),
        // Seven digits will do for people.
        found.diagonal as f32,
        samples.hull,
        samples.boundary,
        samples.mesh,
        samples.volume
    );
    if found.iou.is_none() && found.open_edges > 0.0 {
        let open = 100.0 * found.open_edges;
        text += &format!("\n{open:.1} % of the mesh's edges are open, so it has no sure volume");
    }
    text
}

fn distances(distances: Distances) -> String {
    let Distances { mean, p99, max, .. } = distances;
    format!("mean {}, 99 % below {}, at most {}", length(mean), length(p99), length(max))
}

/// A relative length: four digits after the point show what samples resolve.
fn length(value: f64) -> String {
    if value > 0.0 && value < 1e-4 { format!("{value:.1e}") } else { format!("{value:.4}") }
}

fn share(share: Option<f64>) -> String {
    share.map_or_else(nothing, |share| format!("{:.1} %", 100.0 * share))
}

/// Stands where there is no number.
fn nothing() -> String {
    "–".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_four_decimals_and_tiny_ones_an_exponent() {
        assert_eq!(length(0.0), "0.0000");
        assert_eq!(length(0.018_77), "0.0188");
        assert_eq!(length(2.54e-8), "2.5e-8");
    }

    #[test]
    fn shares_are_percentages() {
        assert_eq!(share(Some(0.8842)), "88.4 %");
        assert_eq!(share(None), "–");
    }
}
