//! `sweep-run`: one mesh in a process of its own. It prints a line of JSON after decomposing, and one
//! after each judge.

use std::path::PathBuf;
use std::time::Instant;

use cpu_time::ProcessTime;
use hullwright::internals::surface_and_solid;
use hullwright::io::{MeshFile, read_mesh};
use hullwright::measure::MeasureOptions;
use hullwright::{Control, Decomposition, Error, Parameters, decompose};
use hullwright_cli::terminal::{Failure, print};
use serde::{Deserialize, Serialize};

use super::row::Row;
use crate::independent::exact::faults;
use crate::independent::sampling::{Sampled, sample};
use crate::runs::judge::{Judged, Verified, judge};
use crate::runs::limits::{peak_memory, reset_peak_memory};
use crate::runs::record::Status;

/// One mesh of the sweep, for its own use
#[derive(clap::Args)]
pub struct Arguments {
    mesh: PathBuf,
}

/// A line of output. Lengths are shares of the diagonal.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Line {
    Refused {
        reason: String,
    },
    Worked {
        triangles: usize,
        hulls: usize,
        vertices: usize,
        processor_seconds: f64,
        wall_seconds: f64,
        peak_memory: Option<u64>,
    },
    /// By exact predicates.
    Exact {
        open_hulls: usize,
        non_convex_hulls: usize,
        hulls_without_volume: usize,
        hulls_beyond_single: usize,
    },
    Bound {
        bound: f64,
        protrusion_verified: f64,
        uncovered_verified: f64,
        protrusion_sampled: f64,
        uncovered_sampled: f64,
        samples: usize,
        undecided_samples: usize,
        broken: String,
    },
    Volume {
        uncovered_volume: Option<f64>,
        iou: Option<f64>,
    },
}

/// Points on all hulls, and as many on the surface: fewer than in the benchmark, since there are many meshes.
const SAMPLES: usize = 10_000;

/// Points in space: shares of the volume are told to about a hundredth.
const VOLUME_SAMPLES: usize = 20_000;

/// Rounding of what was verified and of what is sampled, in bounds.
const ROUNDING: f64 = 1e-3;

/// Where the bound is small, rounding of the coordinates themselves, in diagonals.
const LEAST_ROUNDING: f64 = 1e-9;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    reset_peak_memory();
    let parameters = Parameters::default();
    let control = Control::new().with_parallel(false);
    let found = read_mesh(&arguments.mesh).and_then(|mesh| {
        let (wall, processor) = (Instant::now(), ProcessTime::now());
        let found = decompose(&mesh, &parameters, &control)?;
        Ok((mesh, found, processor.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64()))
    });
    let (mesh, found, processor_seconds, wall_seconds) = match found {
        Ok(found) => found,
        Err(error) => return say(&Line::Refused { reason: reason(&error) }),
    };
    say(&Line::Worked {
        triangles: mesh.mesh.triangles.len(),
        hulls: found.hulls.len(),
        vertices: found.hulls.iter().map(|hull| hull.shape.points.len()).sum(),
        processor_seconds,
        wall_seconds,
        peak_memory: peak_memory(std::process::id()),
    })?;
    say(&exact(&found))?;
    let mut options = MeasureOptions::default();
    (options.hull_samples, options.mesh_samples) = (SAMPLES, SAMPLES);
    options.volume_samples = VOLUME_SAMPLES;
    let judged = judge(mesh.mesh.view(), &found.hulls, &options)?;
    let verified = Verified::of(&found);
    say(&bound(&mesh, &found, &parameters, verified, &judged)?)?;
    say(&Line::Volume { uncovered_volume: judged.uncovered_volume, iou: judged.iou })
}

fn say(line: &Line) -> Result<(), Failure> {
    print(&serde_json::to_string(line).map_err(|error| error.to_string())?)
}

/// Without the path, so that equal reasons are equal.
fn reason(error: &Error) -> String {
    match error {
        Error::File { source, .. } => format!("file: {source}"),
        other => other.to_string(),
    }
}

fn exact(found: &Decomposition) -> Line {
    let hulls: Vec<_> =
        found.hulls.iter().map(|hull| hull.shape.to_single_precision().ok()).collect();
    let all: Vec<_> =
        hulls.iter().flatten().map(|(points, triangles)| faults(points, triangles)).collect();
    Line::Exact {
        open_hulls: all.iter().filter(|faults| faults.is_open).count(),
        non_convex_hulls: all.iter().filter(|faults| faults.is_not_convex).count(),
        hulls_without_volume: all.iter().filter(|faults| faults.has_no_volume).count(),
        hulls_beyond_single: hulls.iter().filter(|hull| hull.is_none()).count(),
    }
}

fn bound(
    mesh: &MeshFile,
    found: &Decomposition,
    parameters: &Parameters,
    verified: Verified,
    judged: &Judged,
) -> Result<Line, Error> {
    let (surface, solid) = surface_and_solid(mesh.into(), parameters, &Control::new())?;
    let sampled = sample(found, &surface, &solid, SAMPLES);
    let Sampled { protrusion, uncovered, beyond_verified, samples, undecided } = sampled;
    let rounding = (ROUNDING * verified.bound).max(LEAST_ROUNDING);
    let own = Judged { protrusion_max: protrusion, uncovered_max: uncovered, ..Judged::default() };
    let broken: Vec<&str> = [
        (verified.is_broken(&own, rounding), "sampled"),
        (verified.is_broken(judged, rounding), "measured"),
        (beyond_verified > rounding, "a hull's own protrusion"),
    ]
    .into_iter()
    .filter_map(|(is_broken, by)| is_broken.then_some(by))
    .collect();
    Ok(Line::Bound {
        bound: verified.bound,
        protrusion_verified: verified.protrusion_max,
        uncovered_verified: verified.uncovered_max,
        protrusion_sampled: protrusion,
        uncovered_sampled: uncovered,
        samples,
        undecided_samples: undecided,
        broken: broken.join(", "),
    })
}

/// Writes what a line says into a row.
pub fn take(line: Line, row: &mut Row) {
    match line {
        Line::Refused { reason } => (row.status, row.reason) = (Status::Error, reason),
        Line::Worked {
            triangles,
            hulls,
            vertices,
            processor_seconds,
            wall_seconds,
            peak_memory,
        } => {
            (row.triangles, row.hulls, row.vertices) =
                (Some(triangles), Some(hulls), Some(vertices));
            (row.processor_seconds, row.wall_seconds) =
                (Some(processor_seconds), Some(wall_seconds));
            row.peak_memory = peak_memory;
        }
        Line::Exact { open_hulls, non_convex_hulls, hulls_without_volume, hulls_beyond_single } => {
            (row.open_hulls, row.non_convex_hulls) = (Some(open_hulls), Some(non_convex_hulls));
            row.hulls_without_volume = Some(hulls_without_volume);
            row.hulls_beyond_single = Some(hulls_beyond_single);
        }
        Line::Bound {
            bound,
            protrusion_verified,
            uncovered_verified,
            protrusion_sampled,
            uncovered_sampled,
            samples,
            undecided_samples,
            broken,
        } => {
            row.bound = Some(bound);
            row.protrusion_verified = Some(protrusion_verified);
            row.uncovered_verified = Some(uncovered_verified);
            row.protrusion_sampled = Some(protrusion_sampled);
            row.uncovered_sampled = Some(uncovered_sampled);
            (row.samples, row.undecided_samples) = (Some(samples), Some(undecided_samples));
            row.broken = broken;
        }
        Line::Volume { uncovered_volume, iou } => {
            (row.uncovered_volume, row.iou) = (uncovered_volume, iou);
        }
    }
}
