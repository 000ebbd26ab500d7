//! `cargo lab stages`: where the time goes.

use std::path::PathBuf;

use hullwright::io::read_mesh;
use hullwright::{Control, Parameters, decompose};

use crate::output::Failure;

/// Show the milliseconds of each stage: of several runs on one thread the least
#[derive(clap::Args)]
pub struct Arguments {
    /// The meshes: obj, off, ply, stl, gltf or glb
    #[arg(required = true, value_name = "MESH")]
    meshes: Vec<PathBuf>,
}

/// Runs of which the quickest counts, stage by stage.
const RUNS: usize = 3;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut parameters = Parameters::default();
    parameters.parallel = false;
    let mut totals: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for path in &arguments.meshes {
        let file = read_mesh(path)?;
        let mut best: Vec<(String, f64)> = Vec::new();
        let mut hulls = 0;
        for _ in 0..RUNS {
            let result = decompose(&file.positions, &file.triangles, &parameters, &Control::new())?;
            hulls = result.hulls.len();
            for (index, stage) in result.report.times.iter().enumerate() {
                let time = 1e3 * stage.seconds;
                match best.get_mut(index) {
                    Some(entry) => entry.1 = entry.1.min(time),
                    None => best.push((format!("{:?}", stage.stage).to_lowercase(), time)),
                }
            }
        }
        let total: f64 = best.iter().map(|entry| entry.1).sum();
        print!("{total:9.1} ms {hulls:4} hulls {:8} triangles ", file.triangles.len());
        for (index, (stage, time)) in best.iter().enumerate() {
            print!(" {stage} {time:.1}");
            if columns.len() <= index {
                columns.push(Vec::new());
            }
            columns[index].push(*time);
        }
        println!("  {}", path.display());
        totals.push(total);
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    print!("{:9.1} ms, median; stages", median(&mut totals));
    for column in &mut columns {
        print!(" {:.1}", median(column));
    }
    println!();
    Ok(())
}
