//! `stability-run`: one mesh and method under all variations, one line each.

use std::path::PathBuf;

use cpu_time::ProcessTime;
use hullwright::io::read_mesh;
use hullwright::measure::MeasureOptions;
use hullwright::{Control, Error, MeshView};
use hullwright_cli::terminal::{Failure, print};
use serde::{Deserialize, Serialize};

use super::variations::{Mesh, Variation};
use crate::runs::judge::judge;
use crate::runs::methods::Run;

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
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct VariationResult {
    pub hulls: usize,
    /// Hausdorff, as a share of the diagonal.
    pub error: f64,
    pub non_convex_hulls: usize,
    pub non_positive_volumes: usize,
    /// Share of the solid in no hull; none where the mesh is open.
    pub uncovered_volume: Option<f64>,
    pub iou: Option<f64>,
    /// Processor time of decomposing, in seconds.
    pub seconds: f64,
    /// Empty where all went well.
    pub failure: String,
}

/// Points on hulls, and on the mesh: fewer than in the benchmark, since there are many runs.
pub const SURFACE_POINTS: usize = 20_000;

/// Points in space: shares of the volume are told to about a hundredth.
pub const VOLUME_POINTS: usize = 20_000;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = read_mesh(&arguments.mesh)?;
    let run = Run::parse(&arguments.method, &arguments.setting)
        .ok_or_else(|| Failure::Usage("no such method or setting".into()))?;
    let mesh = Mesh { positions: file.mesh.positions, triangles: file.mesh.triangles };
    for variation in Variation::all().into_iter().skip(arguments.from) {
        let result = vary(&run, &mesh, variation).unwrap_or_else(|error| VariationResult {
            failure: error.to_string(),
            ..VariationResult::default()
        });
        let line = serde_json::to_string(&result).map_err(|error| error.to_string())?;
        print(&line)?;
    }
    Ok(())
}

fn vary(run: &Run, mesh: &Mesh, variation: Variation) -> Result<VariationResult, Error> {
    let Some(method) = run.own_method() else {
        let reason = "it has no stability report".into();
        return Err(Error::InvalidParameter { name: "method", reason });
    };
    let (given, sound) = variation.apply(mesh);
    let control = Control::new();
    let start = ProcessTime::now();
    let found = method.decompose(MeshView::new(&given.positions, &given.triangles), &control)?;
    let seconds = start.elapsed().as_secs_f64();
    let mut options = MeasureOptions::default();
    options.hull_samples = SURFACE_POINTS;
    options.mesh_samples = SURFACE_POINTS;
    options.volume_samples = VOLUME_POINTS;
    let judged = judge(MeshView::new(&sound.positions, &sound.triangles), &found.hulls, &options)?;
    Ok(VariationResult {
        hulls: judged.hulls,
        error: judged.hausdorff,
        non_convex_hulls: judged.non_convex_hulls,
        non_positive_volumes: judged.non_positive_volumes,
        uncovered_volume: judged.uncovered_volume,
        iou: judged.iou,
        seconds,
        failure: String::new(),
    })
}
