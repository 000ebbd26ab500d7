//! `cargo lab stages`: where the time goes, in milliseconds.

use std::path::PathBuf;

use hullwright::{Control, Parameters, Preset, decompose};
use hullwright_formats::read_mesh;

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

    /// Run each once, and print nothing: for `valgrind --tool=callgrind`, which counts
    /// instructions, since clocks are noisy
    #[arg(long)]
    once: bool,
}

/// Runs of which the quickest counts, stage by stage: noise only ever adds.
const RUNS: usize = 3;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let parameters = Parameters::default().with_preset(arguments.preset);
    let control = Control::new().with_parallel(false);
    if arguments.once {
        for path in &arguments.meshes {
            decompose(&read_mesh(path)?, &parameters, &control)?;
        }
        return Ok(());
    }
    let mut totals: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for path in &arguments.meshes {
        let file = read_mesh(path)?;
        let mut best: Vec<(&str, f64)> = Vec::new();
        let mut hulls = 0;
        for _ in 0..RUNS {
            let result = decompose(&file, &parameters, &control)?;
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
