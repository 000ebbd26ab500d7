//! `lab run`: one task, in a process of its own. It prints its row after decomposing, and again
//! after each judge, so that what is known stays known however the process ends.

use std::path::PathBuf;
use std::time::Instant;

use cpu_time::ProcessTime;
use hullwright::measure::{MeasureOptions, measure, verify};
use hullwright::openings::close_openings;
use hullwright::surface::average_cost;
use hullwright::{
    Control, Decomposition, Error, Hull, Length, MeshView, Method, MethodReport, Parameters,
    TriangleMesh,
};
use hullwright_formats::{NamedMesh, read_hulls, read_mesh};
use serde::{Deserialize, Serialize};

use super::limits::{peak_memory, reset_peak_memory};
use super::row::{Row, Status};
use crate::independent::exact::faults;
use crate::independent::sampling::{Sampled, sample};
use crate::statistics::median;
use crate::terminal::{Failure, print};
use crate::tools::kinds::kinds;
use crate::tools::methods::Run;
use crate::tools::variations::Variation;
use crate::tools::vhacd;

/// A method with its setting, what is done to the mesh before, and how its hulls are judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Task {
    pub run: Run,
    pub variation: Variation,
    pub judge: Judge,
}

/// How closely hulls are judged.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Judge {
    /// Whether short runs are repeated, and again on all threads.
    pub is_timed: bool,
    /// Points on hulls, and as many on the mesh.
    pub surface_samples: usize,
    /// Points in space.
    pub volume_samples: usize,
    /// Exact predicates, and the bound by a sampling of our own, which knows no probe.
    pub by_brute_force: bool,
    /// Whether errors of hulls that are not of the bounded method are verified too.
    pub verifies: bool,
    /// As a fraction of the diagonal. Protrusion counts where such a ball comes, and the bounded
    /// method fills the rest.
    pub probe_radius: Option<f64>,
}

/// As many points as `measure` takes by default.
pub const FULL: Judge = Judge {
    is_timed: true,
    surface_samples: 50_000,
    volume_samples: 200_000,
    by_brute_force: false,
    verifies: false,
    probe_radius: None,
};

impl Task {
    /// A task on the mesh as it is.
    pub fn new(run: Run, judge: Judge) -> Self {
        Self { run, variation: Variation::None, judge }
    }

    /// Our own methods, with their parameters.
    fn own_method(&self) -> Option<Method> {
        let mut method = self.run.own_method()?;
        if let Method::Bounded(parameters) = &mut method {
            parameters.probe_radius = self.judge.probe_radius.map(Length::Share);
        }
        Some(method)
    }

    /// The parameters of the bounded method.
    fn bounded_parameters(&self) -> Option<Parameters> {
        match self.own_method() {
            Some(Method::Bounded(parameters)) => Some(parameters),
            _ => None,
        }
    }
}

/// One task of an experiment, for its own use
#[derive(clap::Args)]
pub struct Arguments {
    /// A mesh, a task, and what is known of it, as JSON
    work: String,
}

#[derive(Serialize, Deserialize)]
pub struct Work {
    pub mesh: PathBuf,
    pub task: Task,
    /// What is known before.
    pub row: Row,
}

/// Short runs are repeated up to this often, enough for a median.
const MOST_REPEATS: usize = 3;
/// Runs that took this long together are not repeated: their times scatter by little.
const ENOUGH_SECONDS: f64 = 0.5;

/// Rounding of what was verified and of what is sampled, as a fraction of the bound.
const ROUNDING: f64 = 1e-3;
/// Where the bound is small, rounding of the coordinates themselves, as a fraction of the diagonal.
const LEAST_ROUNDING: f64 = 1e-9;

/// What a method returned.
#[derive(Default)]
struct Output {
    hulls: Vec<NamedMesh>,
    /// Of our own methods.
    found: Option<Decomposition<MethodReport>>,
    cost: Option<f64>,
    details: Vec<(&'static str, f64)>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let work: Work = serde_json::from_str(&arguments.work).map_err(|error| error.to_string())?;
    let mut row = work.row.clone();
    match decompose_and_judge(&work, &mut row) {
        Ok(()) => Ok(()),
        // Without the path, so that equal reasons are equal.
        Err(Error::File { source, .. }) => refuse(row, format!("file: {source}")),
        Err(error) => refuse(row, error.to_string()),
    }
}

fn refuse(row: Row, reason: String) -> Result<(), Failure> {
    say(&Row { status: Status::Error, reason, ..row }).map_err(Into::into)
}

fn say(row: &Row) -> Result<(), String> {
    let line = serde_json::to_string(row).map_err(|error| error.to_string())?;
    print(&line).map_err(|_| "can't print".to_owned())
}

fn decompose_and_judge(work: &Work, row: &mut Row) -> Result<(), Error> {
    // The parent has gone; nobody can be told.
    let tell = |row: &Row| say(row).map_err(|_| Error::Cancelled);
    let task = &work.task;
    let Task { run, variation, judge } = task;
    reset_peak_memory();
    let file = read_mesh(&work.mesh)?;
    row.triangles = Some(file.mesh.triangles.len());
    if let Run::Files { hulls, seconds, .. } = run {
        (row.seconds, row.taken_elsewhere) = (Some(*seconds), true);
        judge_by_measure(task, file.mesh.view(), &read_hulls(hulls)?, row)?;
        return tell(row);
    }
    let (given, mut sound) = variation.apply(&file.mesh);
    if judge.by_brute_force {
        // The promise is about the mesh that was given.
        sound.clone_from(&given);
        row.triangles = Some(given.triangles.len());
        row.kinds = kinds(&given).join(", ");
        // Known, whatever becomes of it.
        tell(row)?;
        reset_peak_memory();
    }
    let repeats = if judge.is_timed { MOST_REPEATS } else { 1 };
    let (output, times) = repeat(task, given.view(), 1, repeats)?;
    let repeats = times.len();
    row.seconds = Some(median(times.iter().map(|time| time.0).collect()));
    row.processor_seconds = times.first().map(|time| time.1);
    row.peak_memory = times.first().and_then(|time| time.2);
    row.hulls = Some(output.hulls.len());
    row.vertices = Some(output.hulls.iter().map(|hull| hull.mesh.positions.len()).sum());
    row.cost = output.cost;
    row.details =
        output.details.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    tell(row)?;

    judge_by_measure(task, sound.view(), &output.hulls, row)?;
    if let Some(found) = &output.found
        && let Some(report) = found.report.bounded()
    {
        row.set_verified(&found.run, report);
        note_broken(row, "measured", row.protrusion_max, row.uncovered_max);
        if judge.by_brute_force {
            judge_by_brute_force(task, given.view(), found, row)?;
        }
    }
    tell(row)?;

    // Parry has no such mode: its `parallel` feature is for something else.
    if judge.is_timed && vhacd::parameters(run).is_none() {
        let (again, times) = repeat(task, given.view(), 0, repeats)?;
        row.seconds_all_threads = Some(median(times.iter().map(|time| time.0).collect()));
        row.same_with_all_threads = Some(again.hulls == output.hulls);
        tell(row)?;
    }
    Ok(())
}

/// Seconds on the wall and of the processor, and the peak of the memory.
type Times = Vec<(f64, f64, Option<u64>)>;

/// Decomposes on so many threads (0: all), up to `most` times.
fn repeat(
    task: &Task,
    mesh: MeshView<'_>,
    threads: usize,
    most: usize,
) -> Result<(Output, Times), Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| invalid("threads", error.to_string()))?;
    let mut times: Times = Vec::new();
    loop {
        let (wall, processor) = (Instant::now(), ProcessTime::now());
        let output = pool.install(|| decompose(task, mesh, threads != 1))?;
        let seconds = (wall.elapsed().as_secs_f64(), processor.elapsed().as_secs_f64());
        times.push((seconds.0, seconds.1, peak_memory()));
        let all: f64 = times.iter().map(|time| time.0).sum();
        if times.len() >= most || all >= ENOUGH_SECONDS {
            return Ok((output, times));
        }
    }
}

fn invalid(name: &'static str, reason: String) -> Error {
    Error::InvalidParameter { name, reason }
}

fn decompose(task: &Task, mesh: MeshView<'_>, is_parallel: bool) -> Result<Output, Error> {
    let run = &task.run;
    if let Some(parameters) = vhacd::parameters(run) {
        let hulls = vhacd::decompose(mesh, &parameters);
        return Ok(Output { hulls, ..Output::default() });
    }
    let control = Control::new().with_parallel(is_parallel);
    let method = task.own_method();
    let method = method.ok_or_else(|| invalid("method", "runs elsewhere".into()))?;
    let found = method.decompose(mesh, &control)?;
    let surface = found.report.surface();
    let cost = match surface {
        Some(report) => Some(report.cost),
        None if found.grouped.triangles.is_empty() => None,
        None => Some(average_cost(&found.grouped)?),
    };
    Ok(Output {
        cost,
        details: match surface {
            Some(report) => {
                let threshold = report.planar_threshold.map(|p| ("planar_threshold", p));
                let rest = [
                    ("resolution", report.resolution as f64),
                    ("average_pieces", report.average_pieces),
                    ("polygons", report.polygons as f64),
                    ("initial_polygons", report.initial_polygons as f64),
                ];
                threshold.into_iter().chain(rest).collect()
            }
            None => Vec::new(),
        },
        hulls: hull_meshes(&found.hulls),
        found: Some(found),
    })
}

fn hull_meshes(hulls: &[Hull]) -> Vec<NamedMesh> {
    let mesh =
        |hull: &Hull| TriangleMesh::new(hull.shape.points.clone(), hull.shape.triangles.clone());
    hulls.iter().map(|hull| NamedMesh { name: String::new(), mesh: mesh(hull) }).collect()
}

/// Judges hulls of any kind: ours against the mesh with those openings closed that the bound
/// closes.
fn judge_by_measure(
    task: &Task,
    mesh: MeshView<'_>,
    hulls: &[NamedMesh],
    row: &mut Row,
) -> Result<(), Error> {
    let judge = &task.judge;
    let mut options = MeasureOptions::default();
    options.probe_radius = judge.probe_radius.map(Length::Share);
    (options.hull_samples, options.mesh_samples) = (judge.surface_samples, judge.surface_samples);
    options.volume_samples = judge.volume_samples;
    if let Some(parameters) = task.bounded_parameters() {
        options.flatness = parameters.max_error;
    }
    row.set_measured(&measure(mesh, hulls, &options, &Control::new())?);
    if judge.verifies && task.bounded_parameters().is_none() {
        let verified = verify(mesh, hulls, &options, &Control::new())?;
        row.protrusion_verified = Some(verified.protrusion_max);
        row.uncovered_verified = Some(verified.uncovered_max);
        row.verified_resolution = Some(verified.resolution);
    }
    Ok(())
}

/// Judges our hulls by exact predicates in single precision, and the bound by a sampling that
/// shares no code with the library.
fn judge_by_brute_force(
    task: &Task,
    mesh: MeshView<'_>,
    found: &Decomposition<MethodReport>,
    row: &mut Row,
) -> Result<(), Error> {
    let hulls: Vec<_> =
        found.hulls.iter().map(|hull| hull.shape.to_single_precision().ok()).collect();
    let all: Vec<_> =
        hulls.iter().flatten().map(|(points, triangles)| faults(points, triangles)).collect();
    row.open_hulls = Some(all.iter().filter(|faults| faults.is_open).count());
    row.non_convex_hulls = Some(all.iter().filter(|faults| faults.is_not_convex).count());
    row.hulls_without_volume = Some(all.iter().filter(|faults| faults.has_no_volume).count());
    row.hulls_beyond_single = Some(hulls.iter().filter(|hull| hull.is_none()).count());

    let Some(parameters) = task.bounded_parameters() else { return Ok(()) };
    let closed = close_openings(mesh, &parameters, &Control::new())?;
    let sampled = sample(found, &closed.mesh, &closed.solid, task.judge.surface_samples);
    let Sampled { protrusion, uncovered, beyond_verified, samples, undecided } = sampled;
    (row.protrusion_sampled, row.uncovered_sampled) = (Some(protrusion), Some(uncovered));
    (row.samples, row.undecided_samples) = (Some(samples), Some(undecided));
    note_broken(row, "sampled", Some(protrusion), Some(uncovered));
    if beyond_verified > rounding(row) {
        add(&mut row.broken, "a hull's own protrusion");
    }
    Ok(())
}

fn rounding(row: &Row) -> f64 {
    (ROUNDING * row.bound.unwrap_or(0.0)).max(LEAST_ROUNDING)
}

/// Notes a promise that these distances break.
fn note_broken(row: &mut Row, by: &str, protrusion: Option<f64>, uncovered: Option<f64>) {
    let [protrusion, uncovered] = [protrusion, uncovered].map(|length| length.unwrap_or(0.0));
    if row.exceeds(protrusion, uncovered, rounding(row)) {
        add(&mut row.broken, by);
    }
}

fn add(list: &mut String, what: &str) {
    if !list.is_empty() {
        *list += ", ";
    }
    *list += what;
}
