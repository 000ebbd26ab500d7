//! `cargo lab stages`: where the time goes, in milliseconds, or in instructions counted by a simulator.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use hullwright::io::read_mesh;
use hullwright::{Control, Parameters, Preset, decompose};

use crate::statistics::median;
use crate::terminal::{Failure, print};
use crate::tools::meshes;

/// Show the milliseconds of each stage: of several runs on one thread the least
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = meshes::files_help(), required = true, value_name = "MESH")]
    meshes: Vec<PathBuf>,

    /// fast, balanced or fine
    #[arg(long, value_name = "NAME", default_value = "balanced")]
    preset: Preset,

    /// Count instructions with valgrind's callgrind, which must be installed: clocks are noisy
    #[arg(long)]
    instructions: bool,

    /// Run once, and print nothing: what the simulator runs
    #[arg(long, hide = true)]
    once: bool,
}

/// Runs of which the quickest counts, stage by stage: noise only ever adds.
const RUNS: usize = 3;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let parameters = Parameters::default().preset(arguments.preset);
    if arguments.once {
        let control = Control::new().with_parallel(false);
        for path in &arguments.meshes {
            decompose(&read_mesh(path)?, &parameters, &control)?;
        }
        return Ok(());
    }
    if arguments.instructions {
        for path in &arguments.meshes {
            print(&instructions(path, arguments.preset)?)?;
        }
        return Ok(());
    }
    milliseconds(&arguments.meshes, &parameters)
}

fn milliseconds(meshes: &[PathBuf], parameters: &Parameters) -> Result<(), Failure> {
    let control = Control::new().with_parallel(false);
    let mut totals: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for path in meshes {
        let file = read_mesh(path)?;
        let mut best: Vec<(&str, f64)> = Vec::new();
        let mut hulls = 0;
        for _ in 0..RUNS {
            let result = decompose(&file, parameters, &control)?;
            hulls = result.hulls.len();
            for (index, time) in result.run.times.iter().enumerate() {
                let milliseconds = 1e3 * time.seconds;
                match best.get_mut(index) {
                    Some(entry) => entry.1 = entry.1.min(milliseconds),
                    None => best.push((time.stage.name(), milliseconds)),
                }
            }
        }
        let total: f64 = best.iter().map(|entry| entry.1).sum();
        let mut line =
            format!("{total:9.1} ms {hulls:4} hulls {:8} triangles ", file.mesh.triangles.len());
        columns.resize(columns.len().max(best.len()), Vec::new());
        for ((stage, time), column) in best.iter().zip(&mut columns) {
            line += &format!(" {stage} {time:.1}");
            column.push(*time);
        }
        print(&format!("{line}  {}", path.display()))?;
        totals.push(total);
    }
    let stages: String =
        columns.into_iter().map(|column| format!(" {:.1}", median(column))).collect();
    print(&format!("{:9.1} ms, median; stages{stages}", median(totals)))
}

/// Parts of the work, and the functions that do it. Some are parts of others: `fit tests` is all of
/// them, in whatever stage; cells of the grid are filled by what needs them. A function that the compiler has
/// put into its caller counts as nothing.
const PARTS: [(&str, &str); 10] = [
    ("all", "decompose::decompose"),
    ("repair", "mesh::repair::prepare"),
    ("openings", "openings::prepare::close_prepared"),
    ("solid", "bounded::search::solid_and_patch_mesh"),
    ("patches", "bounded::patches::divide_into_patches"),
    ("merge", "bounded::merge::merge"),
    ("cover", "bounded::cover::cover"),
    ("finalize", "bounded::finalize::finalize"),
    ("verification", "solid::protrusion::protrusion"),
    ("fit tests", "solid::fit::FitTester::fits"),
];

/// A line with the millions of instructions of each part.
fn instructions(mesh: &Path, preset: Preset) -> Result<String, Failure> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let counts = folder.path().join("callgrind.out");
    let mut option = std::ffi::OsString::from("--callgrind-out-file=");
    option.push(&counts);
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let status = Command::new("valgrind")
        .args(["--tool=callgrind", "-q"])
        .arg(option)
        .arg(own)
        .args(["stages", "--once", "--preset", preset.name()])
        .arg(mesh)
        .stderr(Stdio::null())
        .status();
    if !status.map_err(|error| format!("valgrind: {error}"))?.success() {
        return Err(format!("{}: valgrind failed", mesh.display()).into());
    }
    let output = Command::new("callgrind_annotate")
        .args(["--inclusive=yes", "--threshold=100"])
        .arg(&counts)
        .output()
        .map_err(|error| format!("callgrind_annotate: {error}"))?;
    let table = String::from_utf8_lossy(&output.stdout);
    let mut line = String::new();
    for (part, function) in PARTS {
        let count = count_of(&table, &format!("hullwright::{function}"));
        line += &format!("{part} {:.1}  ", count as f64 / 1e6);
    }
    Ok(format!("{line} {}", mesh.display()))
}

/// The instructions of a function and all that it calls: the largest of its lines, since a function
/// may be there more than once.
fn count_of(table: &str, function: &str) -> u64 {
    let lines = table.lines().filter_map(|line| {
        let (count, name) = line.trim_start().split_once(' ')?;
        let (_, name) = name.rsplit_once(')').map_or(("", name), |(before, after)| {
            if after.trim().is_empty() { ("", name) } else { (before, after) }
        });
        let name = name.trim_start();
        let is_it = name.match_indices(function).any(|(at, _)| {
            let rest = &name[at + function.len()..];
            rest.is_empty() || rest.starts_with([' ', '\'']) || rest.starts_with("::h")
        });
        is_it.then(|| count.replace(',', "").parse().ok())?
    });
    lines.max().unwrap_or(0)
}
