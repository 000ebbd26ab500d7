//! `hullwright stability-run`: one mesh and method under all variations, one line each.

use std::path::PathBuf;

use hullwright::io::read_mesh;
use hullwright::measure::{HullShape, MeasureOptions, measure};
use hullwright::{Control, Error};
use serde::{Deserialize, Serialize};

use super::variations::{Mesh, Variation};
use crate::Failure;
use crate::bench::methods::Run;
use crate::output::print;

/// One mesh of the stability report, for its own use
#[derive(clap::Args)]
pub struct Arguments {
    mesh: PathBuf,
    #[arg(long)]
    method: String,
    #[arg(long)]
    setting: String,
    /// The variation to begin with
    #[arg(long, default_value_t = 0)]
    from: usize,
}

/// What a variation gave, or what went wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    pub hulls: usize,
    /// Hausdorff, as a share of the diagonal.
    pub error: f64,
    pub non_convex_hulls: usize,
    pub non_positive_volumes: usize,
    /// Empty where all went well.
    pub failure: String,
}

/// Points on hulls, and on the mesh: fewer than in the benchmark, since there are many runs.
pub const SURFACE_POINTS: usize = 20_000;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = read_mesh(&arguments.mesh).map_err(|error| Failure::Work(error.to_string()))?;
    let run = Run::parse(&arguments.method, &arguments.setting)
        .ok_or_else(|| Failure::Usage("no such method or setting".into()))?;
    let mesh = Mesh { positions: file.positions, triangles: file.triangles };
    for variation in Variation::all().into_iter().skip(arguments.from) {
        let outcome = vary(&run, &mesh, variation).unwrap_or_else(|error| Outcome {
            hulls: 0,
            error: 0.0,
            non_convex_hulls: 0,
            non_positive_volumes: 0,
            failure: error.to_string(),
        });
        let line =
            serde_json::to_string(&outcome).map_err(|error| Failure::Work(error.to_string()))?;
        print(&line)?;
    }
    Ok(())
}

fn vary(run: &Run, mesh: &Mesh, variation: Variation) -> Result<Outcome, Error> {
    let Some(parameters) = run.parameters() else {
        let reason = "it has no stability report".into();
        return Err(Error::InvalidParameter { name: "method", reason });
    };
    let (given, sound) = variation.apply(mesh);
    let control = Control::new();
    let found = hullwright::decompose(&given.positions, &given.triangles, &parameters, &control)?;
    let shapes: Vec<HullShape<'_>> = found.hulls.iter().map(HullShape::from).collect();
    let mut options = MeasureOptions::default();
    options.hull_samples = SURFACE_POINTS;
    options.mesh_samples = SURFACE_POINTS;
    options.volume_samples = 0;
    let judged = measure(&sound.positions, &sound.triangles, &shapes, &options)?;
    Ok(Outcome {
        hulls: judged.hulls,
        error: judged.hausdorff,
        non_convex_hulls: judged.non_convex_hulls,
        non_positive_volumes: judged.non_positive_volumes,
        failure: String::new(),
    })
}
