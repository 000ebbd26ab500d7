//! `hullwright measure`: hulls of any tool against their mesh, or two surfaces.

use std::path::PathBuf;

use hullwright::measure::{
    Distances, MeasureOptions, Measurement, VerifiedDistances, measure, verify,
};
use hullwright::{Control, Length};
use hullwright_cli::terminal::{Failure, print, print_json, print_warning};
use hullwright_formats::read_hulls;
use serde_json::{Value, json};

use crate::arguments::{SolidArguments, mesh_help, parse_point};
use crate::measure_surface::{self, Surfaces};
use crate::notes::read_with_warnings;
use crate::progress::waiting;

/// Measure a set of hulls, of any tool, against their mesh; or a simplified mesh
#[derive(clap::Args)]
#[command(
    after_help = "Protrusion is how far the hulls reach outside the solid, uncovered how far the \
    surface reaches outside all hulls, uncovered volume the percentage of the solid in no hull. Points \
    are sampled, the same on every run; --verify bounds the errors of whole faces from above. With --surface distances are bounds for whole triangles."
)]
pub struct Arguments {
    #[arg(help = mesh_help())]
    mesh: PathBuf,

    /// The hulls: a .hulls file, or one per object of the file: obj, stl, gltf or glb; with
    /// --surface a mesh
    hulls: PathBuf,

    /// Measure how far the surfaces of two meshes are from each other, as of a level and its
    /// simplified mesh
    #[arg(long)]
    surface: bool,

    /// With --surface: measure triangles that nothing can touch, too
    #[arg(long, requires = "surface")]
    keep_hidden: bool,

    /// Bound protrusion and uncovered distance from above, too: no samples
    #[arg(long, conflicts_with = "surface")]
    verify: bool,

    /// Print one line of JSON instead of a table
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    solid: SolidArguments,

    /// Measure how far hulls enter balls of this radius: 6% of the diagonal or 0.1m
    #[arg(long, value_name = "RADIUS", allow_hyphen_values = true)]
    probe_radius: Option<Length>,

    /// A point x,y,z where it starts too
    #[arg(long, value_name = "POINT", value_parser = parse_point, allow_hyphen_values = true)]
    probe_from: Vec<[f64; 3]>,
}

/// Why options of the solid are refused.
const NO_SOLID: &str = "surfaces are measured, not solids";

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.surface {
        arguments.solid.refuse(NO_SOLID)?;
        if arguments.probe_radius.is_some() || !arguments.probe_from.is_empty() {
            return Err(Failure::Usage(format!("a probe has no effect: {NO_SOLID}")));
        }
        let &Arguments { ref mesh, hulls: ref simplified, keep_hidden, json, .. } = arguments;
        return measure_surface::run(&Surfaces { mesh, simplified, keep_hidden }, json);
    }
    let solid = arguments.solid.parameters()?;
    let solid =
        solid.with_probe_radius(arguments.probe_radius).with_probe_from(&arguments.probe_from[..]);
    solid.validate().map_err(|error| Failure::Usage(error.to_string()))?;
    let mesh = read_with_warnings(&arguments.mesh)?;
    let hulls = waiting("reading", || read_hulls(&arguments.hulls))?;
    let options = MeasureOptions::from(&solid);
    let control = Control::new();
    let judged = waiting("measuring", || {
        let found = measure(&mesh, &hulls, &options, &control)?;
        let verified = arguments.verify.then(|| verify(&mesh, &hulls, &options, &control));
        Ok((found, verified.transpose()?))
    });
    let (found, verified) = judged.map_err(|error| {
        let path = match error {
            hullwright::Error::NoHulls | hullwright::Error::UnusableHull { .. } => &arguments.hulls,
            _ => &arguments.mesh,
        };
        format!("{}: {error}", path.display())
    })?;
    if is_of_another(&found) {
        let [hulls, mesh] = [&arguments.hulls, &arguments.mesh].map(|path| path.display());
        print_warning(&format!("{hulls} and {mesh} are far apart: units or places may differ"));
    }
    if arguments.json {
        return print_json(&line(arguments, &found, verified.as_ref()));
    }
    let verified = verified.map(|verified| format!("\n{verified}")).unwrap_or_default();
    print(&format!("{found}{verified}"))
}

/// No hull of a mesh's own points reaches farther out of it than this share of its diagonal.
const FARTHEST_OUT: f64 = 0.5;

/// Hulls that leave the surface this far uncovered in the mean, as a share of the diagonal, miss
/// most of it.
const FAR_UNCOVERED: f64 = 0.05;

fn is_of_another(found: &Measurement) -> bool {
    found.protrusion.max > FARTHEST_OUT || found.uncovered.mean > FAR_UNCOVERED
}

/// Lengths are in the mesh's units, as in all lines of JSON. A figure that needs a volume is null
/// where the mesh has none.
fn line(arguments: &Arguments, found: &Measurement, verified: Option<&VerifiedDistances>) -> Value {
    let length = |share: f64| share * found.diagonal;
    let distances = |of: &Distances| json!({ "mean": length(of.mean), "p99": length(of.p99), "max": length(of.max) });
    let mut line = json!({
        "mesh": arguments.mesh.display().to_string(),
        "hulls_file": arguments.hulls.display().to_string(),
        "hulls": found.hulls,
        "vertices": found.vertices,
        "unusable_hulls": found.unusable_hulls,
        "non_convex_hulls": found.non_convex_hulls,
        "worst_concavity": length(found.worst_concavity),
        "open_hulls": found.open_hulls,
        "non_positive_volumes": found.non_positive_volumes,
        "protrusion": distances(&found.protrusion),
        "uncovered": distances(&found.uncovered),
        "hausdorff": length(found.hausdorff),
        "uncovered_volume": found.uncovered_volume,
        "iou": found.iou,
        "overlap": found.overlap,
        "open_edges": found.open_edges,
        "diagonal": found.diagonal,
        "samples": found.samples,
        "version": env!("CARGO_PKG_VERSION"),
    });
    if let Some(verified) = verified {
        line["verified"] = json!({
            "protrusion_max": length(verified.protrusion_max),
            "uncovered_max": length(verified.uncovered_max),
            "resolution": length(verified.resolution),
        });
    }
    line
}
