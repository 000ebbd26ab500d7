//! `bench-run`: one run, in a process of its own. It prints a line of JSON after
//! decomposing, one after measuring, and one after decomposing again with all processors.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::{MeshFile, NamedMesh, read_hulls, read_mesh};
use hullwright::measure::MeasureOptions;
use hullwright::{Control, Error, Hull, Method, TriangleMesh};
use hullwright_cli::terminal::{Failure, print};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::judge::{Judged, judge};
use super::limits::{peak_memory, reset_peak_memory};
use super::methods::Run;
use super::record::Worked;
use super::vhacd;
use crate::hacd::{self, HacdParameters};
use crate::statistics::median;

/// One run of the benchmark, for its own use
#[derive(clap::Args)]
pub struct Arguments {
    mesh: PathBuf,
    #[arg(long)]
    method: String,
    #[arg(long)]
    setting: String,
    /// Only measure these hulls
    #[arg(long)]
    hulls: Option<PathBuf>,
}

/// A line of output.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Line {
    Worked(Worked),
    Judged(Box<Judged>),
    AllThreads { seconds: f64, same: bool },
}

/// Short runs are repeated up to this often, enough for a median.
const MOST_REPEATS: usize = 3;
/// Runs that took this long together are not repeated: their times scatter by little.
const ENOUGH_SECONDS: f64 = 0.5;

/// What a method returned.
#[derive(Default)]
struct Output {
    hulls: Vec<NamedMesh>,
    stages: Vec<(String, f64)>,
    cost: Option<f64>,
    details: BTreeMap<String, Value>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mesh = read_mesh(&arguments.mesh)?;
    if let Some(hulls) = &arguments.hulls {
        let hulls = read_hulls(hulls)?;
        say(&Line::Judged(Box::new(judge_default(&mesh, &hulls)?)))?;
        return Ok(());
    }
    let run = Run::parse(&arguments.method, &arguments.setting)
        .ok_or_else(|| Failure::Usage("no such method or setting".into()))?;

    reset_peak_memory();
    let alone = pool(1)?;
    let mut times = Vec::new();
    let mut first = None;
    let mut peak = None;
    while times.len() < MOST_REPEATS && times.iter().sum::<f64>() < ENOUGH_SECONDS {
        let start = Instant::now();
        let output = alone.install(|| decompose(&run, &mesh, false))?;
        times.push(start.elapsed().as_secs_f64());
        peak = peak.or_else(|| peak_memory(std::process::id()));
        first.get_or_insert(output);
    }
    let repeats = times.len();
    let Output { hulls, stages, cost, details } = first.unwrap_or_default();
    say(&Line::Worked(Worked {
        triangles: mesh.mesh.triangles.len(),
        seconds: median(times),
        repeats,
        seconds_all_threads: None,
        same_with_all_threads: None,
        stages,
        peak_memory: peak,
        cost,
        details,
    }))?;
    say(&Line::Judged(Box::new(judge_run(&run, &mesh, &hulls)?)))?;

    // Parry has no such mode (its `parallel` feature is for something else).
    if vhacd::parameters(&run).is_some() {
        return Ok(());
    }
    let together = pool(0)?;
    let mut times = Vec::new();
    let mut same = true;
    while times.len() < repeats {
        let start = Instant::now();
        let output = together.install(|| decompose(&run, &mesh, true))?;
        times.push(start.elapsed().as_secs_f64());
        same &= output.hulls == hulls;
    }
    say(&Line::AllThreads { seconds: median(times), same })
}

fn say(line: &Line) -> Result<(), Failure> {
    print(&serde_json::to_string(line).map_err(|error| error.to_string())?)
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    Ok(pool.map_err(|error| format!("the threads can't be started: {error}"))?)
}

fn judge_default(mesh: &MeshFile, hulls: &[NamedMesh]) -> Result<Judged, Error> {
    judge(mesh.mesh.view(), hulls, &MeasureOptions::default())
}

/// Judges the hulls of a run: ours against the mesh with those openings closed that its bound closes.
fn judge_run(run: &Run, mesh: &MeshFile, hulls: &[NamedMesh]) -> Result<Judged, Error> {
    let mut options = MeasureOptions::default();
    if let Some(Method::Bounded(parameters)) = run.own_method() {
        options.flatness = parameters.max_error;
    }
    judge(mesh.mesh.view(), hulls, &options)
}

fn decompose(run: &Run, mesh: &MeshFile, parallel: bool) -> Result<Output, Error> {
    if let Some(parameters) = vhacd::parameters(run) {
        let hulls = vhacd::decompose(mesh.into(), &parameters);
        return Ok(Output { hulls, ..Output::default() });
    }
    let control = Control::new().with_parallel(parallel);
    if let Some(parameters) = run.hacd_parameters() {
        return decompose_with_hacd(mesh, &parameters, &control);
    }
    let Some(method) = run.own_method() else {
        let reason = "it does not run in this process".into();
        return Err(Error::InvalidParameter { name: "method", reason });
    };
    decompose_with_ours(mesh, &method, &control)
}

fn decompose_with_hacd(
    mesh: &MeshFile,
    parameters: &HacdParameters,
    control: &Control,
) -> Result<Output, Error> {
    let found = hacd::decompose(mesh, parameters, control)?;
    let times = found.times.iter().map(|(stage, seconds)| (stage.name().into(), *seconds));
    let details = [
        ("resolution", json!(found.resolution)),
        ("average_pieces", json!(found.average_pieces)),
        ("polygons", json!(found.groups.len())),
    ];
    Ok(Output {
        stages: times.collect(),
        cost: Some(found.cost),
        details: details.map(|(name, value)| (name.to_owned(), value)).into(),
        hulls: found.hulls.into_iter().map(hull_mesh).collect(),
    })
}

fn decompose_with_ours(
    mesh: &MeshFile,
    method: &Method,
    control: &Control,
) -> Result<Output, Error> {
    let found = method.decompose(mesh, control)?;
    let times = &found.run.times;
    let mut details = BTreeMap::new();
    let mut cost = None;
    if let Some(surface) = found.report.surface() {
        cost = Some(surface.cost);
        details.insert("planar_threshold".into(), json!(surface.planar_threshold));
        details.insert("resolution".into(), json!(surface.resolution));
        details.insert("average_pieces".into(), json!(surface.average_pieces));
        details.insert("polygons".into(), json!(surface.polygons));
    }
    Ok(Output {
        stages: times.iter().map(|time| (time.stage.name().into(), time.seconds)).collect(),
        cost: cost.or_else(|| {
            let is_grouped = !found.grouped.triangles.is_empty();
            is_grouped.then(|| hacd::average_cost(&found.grouped))
        }),
        details,
        hulls: found.hulls.into_iter().map(hull_mesh).collect(),
    })
}

fn hull_mesh(hull: Hull) -> NamedMesh {
    NamedMesh {
        name: String::new(),
        mesh: TriangleMesh::new(hull.shape.points, hull.shape.triangles),
    }
}

/// The command that runs this worker.
pub fn command(
    mesh: &Path,
    run: &Run,
    hulls: Option<&Path>,
) -> Result<std::process::Command, String> {
    let program = std::env::current_exe().map_err(|error| format!("this program: {error}"))?;
    let mut command = std::process::Command::new(program);
    command.arg("bench-run").arg(mesh);
    command.args(["--method", run.method(), "--setting", &run.setting()]);
    if let Some(hulls) = hulls {
        command.arg("--hulls").arg(hulls);
    }
    Ok(command)
}
