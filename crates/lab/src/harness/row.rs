//! What became of a task: a line of the journal, and of the table of all rows.

use std::collections::BTreeMap;
use std::path::Path;

use hullwright::measure::Measurement;
use hullwright::{Report, RunReport};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::tools::meshes;
use crate::tools::methods::Run;

/// How a task ended.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// There are hulls.
    #[default]
    Done,
    /// It was refused with a reason.
    Error,
    /// It panicked, or was ended by a signal that it caused itself.
    Crash,
    /// Over the time limit.
    TimeOut,
    /// Over the memory limit.
    OutOfMemory,
}

impl Status {
    pub const ALL: [Self; 5] =
        [Self::Done, Self::Error, Self::Crash, Self::TimeOut, Self::OutOfMemory];

    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Error => "error",
            Self::Crash => "crash",
            Self::TimeOut => "time-out",
            Self::OutOfMemory => "out of memory",
        }
    }
}

/// One mesh, one method with its setting, one variation of the mesh. What is `None` was not reached
/// or not asked for. Lengths are fractions of the mesh's diagonal.
///
/// The names are columns of CSV files, which later versions read: aliases are those of earlier
/// ones.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Row {
    pub mesh: String,
    pub mesh_bytes: u64,
    /// Of the file's bytes.
    pub mesh_hash: String,
    pub method: String,
    pub setting: String,
    /// Empty for the mesh as it is.
    pub variation: String,
    pub version: String,
    pub status: Status,
    /// What went wrong, in one line.
    pub reason: String,
    /// Whether the time was taken on another machine.
    pub taken_elsewhere: bool,
    pub triangles: Option<usize>,
    /// What is wrong with the mesh as it is given, by commas, where the task asks; empty for a
    /// solid.
    pub kinds: String,
    pub hulls: Option<usize>,
    pub vertices: Option<usize>,
    /// Of decomposing alone, on one thread: the median over the repeats.
    #[serde(alias = "wall_seconds")]
    pub seconds: Option<f64>,
    /// The same by the processor's clock, of the first repeat.
    pub processor_seconds: Option<f64>,
    /// With all processors; `None` where the method has no such mode.
    pub seconds_all_threads: Option<f64>,
    pub same_with_all_threads: Option<bool>,
    /// Highest resident memory while reading and decomposing, in bytes.
    pub peak_memory: Option<u64>,
    /// The paper's cost, where the method groups a surface.
    pub cost: Option<f64>,
    /// What the bounded method was asked for, and what was verified of hulls of any method.
    pub bound: Option<f64>,
    pub protrusion_verified: Option<f64>,
    pub uncovered_verified: Option<f64>,
    /// How much smaller the true protrusion may be, where hulls of other methods were verified.
    pub verified_resolution: Option<f64>,
    /// What sampling by brute force finds.
    pub protrusion_sampled: Option<f64>,
    pub uncovered_sampled: Option<f64>,
    pub samples: Option<usize>,
    pub undecided_samples: Option<usize>,
    /// What a promise is broken by, or how a judge went wrong; empty where all holds.
    pub broken: String,
    /// Hulls that are not closed, by exact predicates in single precision.
    pub open_hulls: Option<usize>,
    /// By exact predicates where the task has them, else by 1e-6 of the diagonal.
    pub non_convex_hulls: Option<usize>,
    pub hulls_without_volume: Option<usize>,
    /// Hulls that have no form in single precision.
    pub hulls_beyond_single: Option<usize>,
    /// Hulls that `measure` leaves out.
    pub unusable_hulls: Option<usize>,
    pub worst_concavity: Option<f64>,
    pub protrusion_mean: Option<f64>,
    pub protrusion_p99: Option<f64>,
    pub protrusion_max: Option<f64>,
    pub uncovered_mean: Option<f64>,
    pub uncovered_p99: Option<f64>,
    pub uncovered_max: Option<f64>,
    pub hausdorff: Option<f64>,
    /// Share of the solid in no hull.
    pub uncovered_volume: Option<f64>,
    pub iou: Option<f64>,
    pub overlap: Option<f64>,
    pub samples_hulls: Option<usize>,
    pub samples_boundary: Option<usize>,
    pub samples_mesh: Option<usize>,
    pub samples_space: Option<usize>,
    /// What else the method reports: the paper's p, r, average pieces and polygons.
    pub details: BTreeMap<String, f64>,
}

/// A figure of a row, for tables.
pub type Figure = (&'static str, fn(&Row) -> Option<f64>);

impl Row {
    /// What makes a task the same task.
    pub fn key(&self) -> [String; 6] {
        let Self { mesh, mesh_hash, method, setting, variation, version, .. } = self;
        [mesh, mesh_hash, method, setting, variation, version].map(String::clone)
    }

    /// Whether there are hulls, and measured.
    pub fn is_done(&self) -> bool {
        self.status == Status::Done && self.hausdorff.is_some()
    }

    /// Whether the method ran with its default setting.
    pub fn is_default(&self) -> bool {
        Run::is_default(&self.method, &self.setting)
    }

    /// The folder that the mesh is in.
    pub fn folder(&self) -> &str {
        meshes::folder(&self.mesh)
    }

    /// The mesh, and what was done to it.
    pub fn name(&self) -> String {
        format!("{} {}", self.mesh, self.variation).trim().to_owned()
    }

    pub fn megabytes(&self) -> Option<f64> {
        self.peak_memory.map(|bytes| bytes as f64 / f64::from(1 << 20))
    }

    /// Hulls that are open, not convex, without volume or beyond single precision.
    pub fn unsound_hulls(&self) -> usize {
        let Self {
            open_hulls, non_convex_hulls, hulls_without_volume, hulls_beyond_single, ..
        } = self;
        let counts = [open_hulls, non_convex_hulls, hulls_without_volume, hulls_beyond_single];
        counts.into_iter().flatten().sum()
    }

    /// What is wrong with the hulls or the promise, in words; empty where nothing is.
    pub fn faults(&self) -> String {
        let counts = [
            (self.open_hulls, "open"),
            (self.non_convex_hulls, "not convex"),
            (self.hulls_without_volume, "without volume"),
            (self.hulls_beyond_single, "beyond single precision"),
        ];
        let faulty = counts.into_iter().filter_map(|(count, what)| Some((count?, what)));
        let mut words: Vec<String> = faulty
            .filter(|&(count, _)| count > 0)
            .map(|(count, what)| format!("{count} hulls {what}"))
            .collect();
        if !self.broken.is_empty() {
            words.push(self.broken.clone());
        }
        words.join("; ")
    }

    pub fn set_verified(&mut self, run: &RunReport, report: &Report) {
        let relative = |length: f64| Some(length / run.diagonal);
        self.bound = relative(report.bound);
        self.protrusion_verified = relative(report.protrusion_max);
        self.uncovered_verified = relative(report.uncovered_max);
    }

    pub fn set_measured(&mut self, found: &Measurement) {
        self.hulls = Some(found.hulls);
        self.vertices = Some(found.vertices);
        self.unusable_hulls = Some(found.unusable_hulls);
        self.non_convex_hulls = Some(found.non_convex_hulls);
        self.hulls_without_volume = Some(found.non_positive_volumes);
        self.worst_concavity = Some(found.worst_concavity);
        self.protrusion_mean = Some(found.protrusion.mean);
        self.protrusion_p99 = Some(found.protrusion.p99);
        self.protrusion_max = Some(found.protrusion.max);
        self.uncovered_mean = Some(found.uncovered.mean);
        self.uncovered_p99 = Some(found.uncovered.p99);
        self.uncovered_max = Some(found.uncovered.max);
        self.hausdorff = Some(found.hausdorff);
        self.uncovered_volume = found.uncovered_volume;
        self.iou = found.iou;
        self.overlap = found.overlap;
        self.samples_hulls = Some(found.samples.hull);
        self.samples_boundary = Some(found.samples.boundary);
        self.samples_mesh = Some(found.samples.mesh);
        self.samples_space = Some(found.samples.volume);
    }

    /// Whether more is verified than the bound, or more is found than was verified, up to
    /// `tolerance`.
    pub fn exceeds(&self, protrusion: f64, uncovered: f64, tolerance: f64) -> bool {
        let (Some(bound), Some(most_protrusion), Some(most_uncovered)) =
            (self.bound, self.protrusion_verified, self.uncovered_verified)
        else {
            return false;
        };
        let most = [bound, bound, most_protrusion, most_uncovered];
        let found = [most_protrusion, most_uncovered, protrusion, uncovered];
        found.iter().zip(most).any(|(found, most)| *found > most + tolerance)
    }
}

/// Rows as CSV, with a line of names above; what is a list stays in the journal.
pub fn to_csv<T: Serialize>(rows: &[T]) -> Result<String, String> {
    let say = |error: &dyn std::fmt::Display| format!("a table: {error}");
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (number, row) in rows.iter().enumerate() {
        let row = serde_json::to_value(row).map_err(|error| say(&error))?;
        let cells = row.as_object().into_iter().flatten();
        let cells: Vec<_> =
            cells.filter(|(_, cell)| !cell.is_array() && !cell.is_object()).collect();
        if number == 0 {
            writer.write_record(cells.iter().map(|cell| cell.0)).map_err(|error| say(&error))?;
        }
        let text = |(_, cell): &(_, &Value)| match cell {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        writer.write_record(cells.iter().map(text)).map_err(|error| say(&error))?;
    }
    let bytes = writer.into_inner().map_err(|error| say(&error))?;
    String::from_utf8(bytes).map_err(|error| say(&error))
}

/// The reverse of [`to_csv`], for files of earlier versions too.
pub fn from_csv(path: &Path) -> Result<Vec<Row>, String> {
    let say = |error: csv::Error| format!("{}: {error}", path.display());
    let mut reader = csv::Reader::from_path(path).map_err(say)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(say)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(mesh: &str) -> Row {
        Row { mesh: mesh.into(), version: "1".into(), ..Row::default() }
    }

    #[test]
    fn a_table_is_read_as_it_was_written_and_so_is_that_of_an_earlier_version() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sweep.csv");
        let done = Row {
            processor_seconds: Some(0.1 + 0.2),
            hulls: Some(7),
            same_with_all_threads: Some(true),
            reason: "with, a \"comma\"".into(),
            ..row("a/b.obj")
        };
        let rows = [done, Row { status: Status::OutOfMemory, ..row("a/c.obj") }];
        std::fs::write(&path, to_csv(&rows).unwrap()).unwrap();
        assert_eq!(from_csv(&path).unwrap(), rows);
        assert!(from_csv(&folder.path().join("none.csv")).is_err());
        let earlier = "mesh,mesh_bytes,status,hulls,processor_seconds,wall_seconds,broken,iou\n\
                       a/b.obj,9,time_out,7,0.25,0.5,sampled,\n";
        std::fs::write(&path, earlier).unwrap();
        let read = &from_csv(&path).unwrap()[0];
        assert_eq!((read.status, read.seconds, read.iou), (Status::TimeOut, Some(0.5), None));
    }

    #[test]
    fn faults_are_said_in_words() {
        assert_eq!(Row { open_hulls: Some(0), ..row("a") }.faults(), "");
        let faulty = Row { non_convex_hulls: Some(2), broken: "sampled".into(), ..row("a") };
        assert_eq!(faulty.faults(), "2 hulls not convex; sampled");
    }

    #[test]
    fn a_promise_is_broken_by_what_is_verified_and_by_what_is_found() {
        let kept = Row {
            bound: Some(0.02),
            protrusion_verified: Some(0.019),
            uncovered_verified: Some(0.001),
            ..row("a")
        };
        assert!(!kept.exceeds(0.018, 0.001, 1e-6));
        let beyond = Some(0.021);
        assert!(Row { protrusion_verified: beyond, ..kept.clone() }.exceeds(0.0, 0.0, 1e-6));
        assert!(Row { uncovered_verified: beyond, ..kept.clone() }.exceeds(0.0, 0.0, 1e-6));
        assert!(kept.exceeds(0.0191, 0.0, 1e-6));
        assert!(kept.exceeds(0.0, 0.0011, 1e-6));
        assert!(!kept.exceeds(0.0, 0.0011, 1e-3));
        assert!(!row("a").exceeds(1.0, 1.0, 0.0), "nothing was promised");
    }
}
