//! A series of tasks, each in a process of its own.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rayon::prelude::*;
use serde_json::{Value, json};
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};
use tempfile::TempDir;

use super::journal::Journal;
use super::limits::{self, Limits};
use super::row::{Row, Status};
use super::worker::{Task, Work};
use crate::report::{Report, create_folder};
use crate::terminal::{Failure, print, time};
use crate::tools::meshes::Mesh;

pub struct Session {
    pub output: PathBuf,
    pub limits: Limits,
    /// Repeats tasks that did not end well.
    pub retries: bool,
    /// Runs nothing.
    pub only_reports: bool,
    /// Tasks at once; one where others must not disturb the time on the wall.
    pub jobs: usize,
    journal: Mutex<Journal>,
    /// Removed at the end, where nothing is kept.
    _folder: Option<TempDir>,
}

impl Session {
    /// A session whose journal and report are in a folder.
    pub fn open(output: &Path, limits: Limits) -> Result<Self, String> {
        create_folder(output)?;
        Ok(Self {
            output: output.to_owned(),
            limits,
            retries: false,
            only_reports: false,
            jobs: 1,
            journal: Mutex::new(Journal::open(&output.join("runs.jsonl"))?),
            _folder: None,
        })
    }

    /// A session that keeps nothing.
    pub fn temporary(limits: Limits) -> Result<Self, String> {
        let folder = tempfile::tempdir().map_err(|error| format!("no scratch folder: {error}"))?;
        let session = Self::open(folder.path(), limits)?;
        Ok(Self { _folder: Some(folder), ..session })
    }

    /// All that the journal holds, of earlier versions and other meshes too.
    pub fn journal(&self) -> Vec<Row> {
        self.lock().rows().to_vec()
    }

    fn lock(&self) -> MutexGuard<'_, Journal> {
        self.journal.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The rows of all tasks of all meshes, from the journal or from running them.
    pub fn rows(
        &self,
        meshes: &[Mesh],
        tasks: impl Fn(&Mesh) -> Vec<Task>,
    ) -> Result<Vec<Row>, Failure> {
        let tasks = meshes.iter().flat_map(|mesh| tasks(mesh).into_iter().map(move |t| (mesh, t)));
        let tasks: Vec<(&Mesh, Task)> = tasks.collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.jobs).build();
        let pool = pool.map_err(|error| format!("the threads can't be started: {error}"))?;
        let all = tasks.len();
        // One after the other in the order of the list, whichever job takes them.
        let row = |(number, (mesh, task)): (usize, &(&Mesh, Task))| {
            self.row((number + 1, all), mesh, task).transpose()
        };
        let next = Mutex::new(tasks.iter().enumerate());
        let take = || next.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = |_| std::iter::from_fn(take).filter_map(|task| Some((task.0, row(task)?)));
        let found: Vec<_> =
            pool.install(|| (0..self.jobs).into_par_iter().flat_map_iter(work).collect());
        let mut found: Vec<(usize, Result<Row, Failure>)> = found;
        found.sort_by_key(|found| found.0);
        found.into_iter().map(|found| found.1).collect()
    }

    /// The row of one task. `place` is that of the mesh among all, which is printed.
    pub fn row(
        &self,
        place: (usize, usize),
        mesh: &Mesh,
        task: &Task,
    ) -> Result<Option<Row>, Failure> {
        let blank = Row {
            mesh: mesh.name.clone(),
            mesh_bytes: mesh.bytes,
            mesh_hash: mesh.hash.clone(),
            method: task.run.method().into(),
            setting: task.run.setting(),
            variation: task.variation.name(),
            version: task.run.version(),
            ..Row::default()
        };
        let known = self.lock().get(&blank.key()).cloned();
        let is_enough = |row: &Row| row.status == Status::Done || !self.retries;
        if known.as_ref().is_some_and(is_enough) || self.only_reports {
            return Ok(known);
        }
        let row = self.execute(mesh, task, blank)?;
        print(&progress(place, &row))?;
        self.lock().add(row.clone())?;
        Ok(Some(row))
    }

    /// Runs a task in a process of its own.
    fn execute(&self, mesh: &Mesh, task: &Task, row: Row) -> Result<Row, String> {
        let work = Work { mesh: mesh.path.clone(), task: task.clone(), row };
        let text = serde_json::to_string(&work).map_err(|error| error.to_string())?;
        let program = std::env::current_exe().map_err(|error| format!("this program: {error}"))?;
        let mut command = Command::new(program);
        command.arg("run").arg(text);
        let ended = limits::run(command, self.limits)?;
        let mut row = match ended.lines.last() {
            Some(line) => serde_json::from_str(line).map_err(|e| format!("a worker said: {e}"))?,
            None => work.row,
        };
        match (ended.status, row.hulls.is_some(), row.status) {
            (Status::Done, true, _) | (Status::Done, _, Status::Error) => {}
            (Status::Done, ..) => {
                (row.status, row.reason) = (Status::Error, "it ended without a result".into());
            }
            (status, false, _) => (row.status, row.reason) = (status, ended.reason),
            // It was decomposed, and what came after went wrong: that is not the method's failure.
            (status, true, _) => row.broken = format!("judge: {}: {}", status.name(), ended.reason),
        }
        Ok(row)
    }

    /// Writes a report, with what times depend on.
    pub fn report(&self, report: Report) -> Result<(), String> {
        let limits = [
            ("time_limit_seconds", json!(self.limits.time.as_secs_f64())),
            ("memory_limit_megabytes", json!(self.limits.memory >> 20)),
        ];
        let mut machine = describe();
        machine.extend(limits.map(|(name, value)| (name.to_owned(), value)));
        Report { machine, ..report }.write(&self.output)
    }
}

/// A limit in seconds and one in megabytes, as commands take them.
pub fn limits(seconds: f64, megabytes: u64) -> Result<Limits, Failure> {
    let time = Duration::try_from_secs_f64(seconds)
        .map_err(|_| Failure::Usage("a limit must be a time".into()))?;
    Ok(Limits { time, memory: megabytes.saturating_mul(1 << 20) })
}

fn progress((number, of): (usize, usize), row: &Row) -> String {
    let Row { mesh, method, setting, variation, .. } = row;
    let what = match (row.status, row.hulls) {
        (Status::Done, Some(hulls)) => {
            let distance = match (row.hausdorff, row.bound) {
                (Some(found), Some(bound)) => format!("{:.3} of the bound", found / bound),
                (Some(found), None) => format!("distance {found:.4}"),
                _ => String::new(),
            };
            let seconds = time(row.seconds.unwrap_or(0.0));
            let triangles = row.triangles.unwrap_or(0);
            let faults = row.faults();
            format!("{hulls:>4} hulls of {triangles} triangles  {distance}  {seconds}  {faults}")
        }
        (status, _) => format!("{}: {}", status.name(), row.reason),
    };
    format!("{number:>4}/{of}  {mesh:<44} {method:<8} {setting:<14} {variation:<12} {what}")
}

/// Processor, memory, system and version: what times depend on.
pub fn describe() -> BTreeMap<String, Value> {
    let parts = RefreshKind::nothing()
        .with_cpu(CpuRefreshKind::nothing())
        .with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(parts);
    let memory = system.as_ref().map(|system| format!("{} kB", system.total_memory() >> 10));
    let processor = system.as_ref().ok().and_then(|system| Some(system.cpus().first()?.brand()));
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let rows = [
        ("processor", json!(processor)),
        ("processors", json!(processors)),
        ("memory", json!(memory.ok())),
        ("system", json!(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH))),
        ("kernel", json!(System::kernel_version().ok())),
        ("hullwright", json!(env!("CARGO_PKG_VERSION"))),
        ("algorithm_version", json!(hullwright::ALGORITHM_VERSION)),
        ("optimised", json!(!cfg!(debug_assertions))),
    ];
    rows.map(|(name, value)| (name.to_owned(), value)).into()
}
