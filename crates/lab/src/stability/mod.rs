//! `cargo lab stability`: the same meshes in other words, and how much the result varies.

mod summary;
pub mod variations;
pub mod worker;

use hullwright_cli::terminal::{Failure, print};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use variations::Variation;
use worker::VariationResult;

use crate::report::html_report::{Report, create_folder};
use crate::runs::journal::{Entry, Journal, Key};
use crate::runs::limits::{self, Limits};
use crate::runs::machine;
use crate::runs::meshes::{self, Mesh};
use crate::runs::methods::Run;

/// Decompose meshes that are turned, scaled, moved, jittered, shuffled, flipped or doubled, and
/// report how much the result varies
///
/// Takes meshes evenly from those below the folders. Can be stopped and goes on where it was.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folders with meshes
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// How many meshes
    #[arg(long, value_name = "N", default_value_t = 60)]
    meshes: usize,

    /// Only these methods, by name, separated by commas
    #[arg(long, value_name = "METHODS", value_delimiter = ',')]
    only: Vec<String>,
}

/// Longest time of a variation: several times that of the slowest mesh.
const TIME_LIMIT: Duration = Duration::from_secs(120);
/// Most memory of a variation, in bytes: as in the benchmark.
const MEMORY_LIMIT: u64 = 4 << 30;

/// A mesh, a method, a variation, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub mesh: String,
    pub mesh_hash: String,
    pub method: String,
    pub setting: String,
    pub version: String,
    /// Of the variation in the list of all.
    pub place: usize,
    pub variation: Variation,
    pub result: VariationResult,
}

impl Entry for Row {
    fn key(&self) -> Key {
        key(&self.mesh, &self.mesh_hash, (&self.method, &self.setting), &self.version, self.place)
    }
}

fn key(mesh: &str, hash: &str, run: (&str, &str), version: &str, place: usize) -> Key {
    let run = format!("{} {}", run.0, run.1);
    [mesh.into(), hash.into(), run, version.into(), place.to_string()]
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let output = &arguments.output;
    create_folder(output)?;
    let mut journal = Journal::open(&output.join("runs.jsonl"))?;
    let meshes = meshes::find(&arguments.folders)?;
    let meshes = meshes::spread(meshes, arguments.meshes);
    let mut runs: Vec<Run> = Run::own();
    runs.retain(|run| run.own_method().is_some() && run.is_default());
    runs.retain(|run| {
        arguments.only.is_empty() || arguments.only.iter().any(|name| name == run.method())
    });
    for (number, mesh) in meshes.iter().enumerate() {
        for run in &runs {
            vary(mesh, run, &mut journal)?;
        }
        print(&format!("{:>3}/{}  {}", number + 1, meshes.len(), mesh.name))?;
    }
    // The journal may hold what another version did, or another list of meshes.
    let version = Run::own().first().map(|run| run.version(&Default::default()));
    let names: Vec<&str> = meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    let is_meant = |row: &&Row| {
        names.contains(&row.mesh.as_str()) && version.as_ref().is_none_or(|v| *v == row.version)
    };
    let rows: Vec<Row> = journal.rows().iter().filter(is_meant).cloned().collect();
    Ok(report(output, &rows, &names)?)
}

/// All variations of a mesh that are not in the journal yet. Where one ends its process, it is a
/// failure, and another process goes on after it.
fn vary(mesh: &Mesh, run: &Run, journal: &mut Journal<Row>) -> Result<(), String> {
    let all = Variation::all();
    let version = run.version(&Default::default());
    let (method, setting) = (run.method(), run.setting());
    loop {
        let is_done = |place: &usize| {
            let run = (method, &setting[..]);
            journal.get(&key(&mesh.name, &mesh.hash, run, &version, *place)).is_some()
        };
        let Some(from) = (0..all.len()).find(|place| !is_done(place)) else { return Ok(()) };
        let ended = limits::run(
            command(&mesh.path, run, from)?,
            Limits { time: TIME_LIMIT, memory: MEMORY_LIMIT },
        )?;
        let mut results: Vec<VariationResult> = Vec::new();
        for line in &ended.lines {
            results.push(serde_json::from_str(line).map_err(|e| format!("a worker said: {e}"))?);
        }
        if from + results.len() < all.len() {
            let failure = format!("{}: {}", ended.status.name(), ended.reason);
            results.push(VariationResult { failure, ..VariationResult::default() });
        }
        for (place, result) in (from..).zip(results) {
            let Some(&variation) = all.get(place) else { break };
            journal.add(Row {
                mesh: mesh.name.clone(),
                mesh_hash: mesh.hash.clone(),
                method: method.into(),
                setting: setting.clone(),
                version: version.clone(),
                place,
                variation,
                result,
            })?;
        }
    }
}

fn command(mesh: &Path, run: &Run, from: usize) -> Result<Command, String> {
    let program = std::env::current_exe().map_err(|error| format!("this program: {error}"))?;
    let mut command = Command::new(program);
    command.arg("stability-run").arg(mesh);
    command.args(["--method", run.method(), "--setting", &run.setting()]);
    command.args(["--from", &from.to_string()]);
    Ok(command)
}

fn report(output: &Path, rows: &[Row], meshes: &[&str]) -> Result<(), String> {
    let tables = summary::tables(rows);
    let failures = rows.iter().filter(|row| !row.result.failure.is_empty()).count();
    let broken = rows
        .iter()
        .filter(|row| row.result.failure.is_empty() && summary::breaks_promise(row))
        .count();
    let words = vec![
        format!(
            "{} runs: {} meshes, taken evenly from the list of all, in {} variations each. \
             Failures: {failures}. Broken promises: {broken}.",
            rows.len(),
            meshes.len(),
            Variation::all().len(),
        ),
        format!("The meshes: {}.", meshes.join(", ")),
        "The hulls of a mesh that was shuffled, flipped or doubled are measured against the mesh \
         as it is; those of one that was turned, scaled, moved or jittered against that."
            .into(),
    ];
    let mut machine = machine::describe(Limits { time: TIME_LIMIT, memory: MEMORY_LIMIT });
    for points in ["points_on_hulls", "points_on_mesh"] {
        machine.insert(points.into(), worker::SURFACE_POINTS.into());
    }
    machine.insert("points_in_space".into(), worker::VOLUME_POINTS.into());
    let title = "Numerical stability";
    let report =
        Report { title, words, machine: &machine, plots: &[], tables: &tables, pages: &[] };
    report.write(output, "stability")
}
