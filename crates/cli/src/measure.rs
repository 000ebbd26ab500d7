//! `hullwright measure`: judges hulls, ours or another tool's, against their mesh.

use std::path::PathBuf;

use hullwright::io::{read_hulls, read_mesh};
use hullwright::measure::{Distances, MeasureOptions, Measurement, measure};
use hullwright::{Control, Length};
use hullwright_cli::terminal::{Failure, print, print_json};
use serde_json::{Value, json};

use crate::arguments::{SolidArguments, mesh_help, parse_point};
use crate::progress::waiting;
use crate::report::{NOTHING, pairs};

/// Judge a set of hulls, of any tool, against the mesh that they stand for
#[derive(clap::Args)]
#[command(
    after_help = "Protrusion is how far the hulls reach outside the solid, uncovered how far the \
    surface reaches outside all hulls, uncovered volume the share of the solid in no hull. Lengths are \
    fractions of the bounding-box diagonal. Points are sampled, always the same."
)]
pub struct Arguments {
    #[arg(help = mesh_help())]
    mesh: PathBuf,

    /// The hulls: a .hulls file, or one per object of the file: obj, stl, gltf or glb
    hulls: PathBuf,

    /// Print one line of JSON instead of a table
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    solid: SolidArguments,

    /// Judge protrusion in the space that a ball of this radius can reach from outside, 6% of the diagonal or 0.1m: how
    /// far hulls enter it
    #[arg(long, value_name = "RADIUS", allow_hyphen_values = true)]
    probe_radius: Option<Length>,

    /// Where the ball starts too, as x,y,z
    #[arg(long, value_name = "POINT", value_parser = parse_point, allow_hyphen_values = true)]
    probe_from: Vec<[f64; 3]>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mesh = waiting("reading", || read_mesh(&arguments.mesh))?;
    let hulls = waiting("reading", || read_hulls(&arguments.hulls))?;
    let parameters = arguments.solid.parameters();
    let parameters =
        parameters.probe_radius(arguments.probe_radius).probe_from(&arguments.probe_from[..]);
    parameters.validate().map_err(|error| Failure::Usage(error.to_string()))?;
    let options = MeasureOptions::from(&parameters);
    let judged = waiting("measuring", || measure(&mesh, &hulls, &options, &Control::new()));
    let found = judged.map_err(|error| {
        let path = match error {
            hullwright::Error::NoHulls | hullwright::Error::UnusableHull { .. } => &arguments.hulls,
            _ => &arguments.mesh,
        };
        format!("{}: {error}", path.display())
    })?;
    if arguments.json {
        return print_json(&line(arguments, &found));
    }
    print(&text(&found))
}

/// Lengths are fractions of the mesh's diagonal, which is in its units. A figure that needs a volume is
/// null where the mesh has none.
fn line(arguments: &Arguments, found: &Measurement) -> Value {
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
        "protrusion": found.protrusion,
        "uncovered": found.uncovered,
        "hausdorff": found.hausdorff,
        "uncovered_volume": found.uncovered_volume,
        "iou": found.iou,
        "overlap": found.overlap,
        "open_edges": found.open_edges,
        "diagonal": found.diagonal,
        "samples": found.samples,
        "version": env!("CARGO_PKG_VERSION"),
    })
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
        ("protrusion", distances(found.protrusion)),
        ("uncovered", distances(found.uncovered)),
        ("Hausdorff", length(found.hausdorff)),
        ("uncovered volume", share(found.uncovered_volume)),
        ("volume IoU", share(found.iou)),
        (
            "overlap",
            found.overlap.map_or_else(|| NOTHING.into(), |overlap| format!("{overlap:.3}")),
        ),
    ]);
    let samples = &found.samples;
    let mut text = format!(
        "{}\n\nlengths are fractions of the mesh's diagonal, {}\n\
         points: {} on hulls ({} of them on the boundary of all), {} on the mesh, {} in space",
        pairs(rows),
        // Single precision prints seven digits.
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
    share.map_or_else(|| NOTHING.into(), |share| format!("{:.1} %", 100.0 * share))
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
