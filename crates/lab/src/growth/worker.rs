//! `lab grow`: one mesh of one size, in a process of its own. It prints a line before it starts to
//! decompose, since a limit on time counts from one line to the next.

use cpu_time::ProcessTime;
use hullwright::Control;
use serde::{Deserialize, Serialize};

use super::shapes::KINDS;
use crate::harness::limits::{peak_memory, reset_peak_memory};
use crate::terminal::{Failure, print};
use crate::tools::methods::Run;

/// One size of one kind, for the use of `growth`
#[derive(clap::Args)]
pub struct Arguments {
    kind: String,
    triangles: usize,
}

/// The bound as a fraction of the diagonal: the default.
pub const BOUND: f64 = 0.02;

/// What a size took.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Grown {
    pub triangles: usize,
    /// Of the processor: other processes do not count.
    pub seconds: f64,
    /// The mesh itself included; `None` where the system does not tell.
    pub megabytes: Option<f64>,
    pub hulls: usize,
    /// The larger one of protrusion and uncovered distance, as a fraction of the bound.
    pub error: f64,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let kind = KINDS.iter().find(|kind| kind.0 == arguments.kind);
    let make = kind.ok_or_else(|| Failure::Usage("there is no such kind".into()))?.2;
    let method = Run::bounded(BOUND).own_method().ok_or("it is not a method of ours")?;
    let mesh = make(arguments.triangles);
    print("made")?;
    reset_peak_memory();
    let start = ProcessTime::now();
    let found = method.decompose(mesh.view(), &Control::new().with_parallel(false))?;
    let seconds = start.elapsed().as_secs_f64();
    let report = found.report.bounded().ok_or("it has no bound")?;
    let grown = Grown {
        triangles: mesh.triangles.len(),
        seconds,
        megabytes: peak_memory().map(|bytes| bytes as f64 / f64::from(1 << 20)),
        hulls: found.hulls.len(),
        error: report.protrusion_max.max(report.uncovered_max) / report.bound,
    };
    print(&serde_json::to_string(&grown).map_err(|error| error.to_string())?)?;
    Ok(())
}
