//! The paper's full search with its defaults, one thread: `cargo bench --package hullwright --bench
//! search`.
//!
//! First a mesh of a million triangles, made by subdivision of a bundled one, with the peak of
//! the process's memory. Then every mesh of the folder that `HULLWRIGHT_MESHES`
//! names, or of `assets`: the median over all meshes, the slowest, and which share each stage
//! takes. Reading files is not counted. Memory and time on the processor are printed on Linux only.

use std::collections::HashMap;
use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use hullwright::surface::{SurfaceParameters, decompose};
use hullwright::{Control, MeshView, RunReport, Stage};
use hullwright_formats::read_mesh;

/// Names the folder of meshes.
const FOLDER: &str = "HULLWRIGHT_MESHES";

/// Runs of each mesh; the median of them counts.
const ROUNDS: usize = 5;

/// Triangles of the large mesh, at least.
const MANY: usize = 1_000_000;

/// The stages of the paper's method, in order.
const STAGES: [Stage; 6] =
    [Stage::Repair, Stage::Simplify, Stage::Search, Stage::Merge, Stage::Hulls, Stage::Assign];

/// Positions and triangles.
type Mesh = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn main() -> ExitCode {
    match million().and_then(|()| folder()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("search: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A large mesh, before anything else has used memory.
fn million() -> Result<(), Box<dyn Error>> {
    let mut mesh = read(&assets().join("mug.glb"))?;
    while mesh.1.len() < MANY {
        mesh = subdivide(&mesh);
    }
    let runs = runs(&mesh)?;
    println!(
        "{} triangles: {:.0} ms{}",
        mesh.1.len(),
        1e3 * runs.seconds,
        processor(runs.processor)
    );
    print_shares(&runs.stages);
    match peak_memory() {
        Some(megabytes) => println!("peak memory {megabytes} MB, the input included\n"),
        None => println!("peak memory not known here\n"),
    }
    Ok(())
}

fn folder() -> Result<(), Box<dyn Error>> {
    let folder = std::env::var_os(FOLDER).map_or_else(assets, PathBuf::from);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(&folder)? {
        files.push(entry?.path());
    }
    files.sort();
    let (mut times, mut processor_times) = (Vec::new(), Vec::new());
    let mut stages = [0.0; STAGES.len()];
    for file in &files {
        let Ok(mesh) = read(file) else { continue };
        let runs = runs(&mesh)?;
        for (sum, seconds) in stages.iter_mut().zip(runs.stages) {
            *sum += seconds;
        }
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned());
        times.push((runs.seconds, name.unwrap_or_default()));
        processor_times.extend(runs.processor);
    }
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(middle), Some(slowest)) = (times.get(times.len() / 2), times.last()) else {
        return Err(format!("no meshes in {}", folder.display()).into());
    };
    println!(
        "{} meshes: median {:.1} ms{}, slowest {:.1} ms ({})",
        times.len(),
        1e3 * middle.0,
        processor((!processor_times.is_empty()).then(|| median(processor_times))),
        1e3 * slowest.0,
        slowest.1
    );
    print_shares(&stages);
    Ok(())
}

fn processor(seconds: Option<f64>) -> String {
    seconds.map_or_else(String::new, |seconds| format!(" ({:.1} on the processor)", 1e3 * seconds))
}

fn print_shares(stages: &[f64; STAGES.len()]) {
    let all: f64 = stages.iter().sum();
    for (stage, seconds) in STAGES.iter().zip(stages) {
        println!("  {:<9} {:>5.1} %", stage.name(), 100.0 * seconds / all);
    }
}

/// Medians over the rounds.
struct Runs {
    seconds: f64,
    /// Mean time on the processor, which a busy machine hardly changes.
    processor: Option<f64>,
    stages: [f64; STAGES.len()],
}

fn runs((positions, triangles): &Mesh) -> Result<Runs, Box<dyn Error>> {
    let (parameters, serial) = (SurfaceParameters::paper(), Control::new().with_parallel(false));
    let mut seconds = Vec::new();
    let mut stages: [Vec<f64>; STAGES.len()] = Default::default();
    let before = processor_seconds();
    for _ in 0..ROUNDS {
        let start = Instant::now();
        let found =
            decompose(MeshView::new(black_box(positions), triangles), &parameters, &serial)?;
        seconds.push(start.elapsed().as_secs_f64());
        let by_stage = by_stage(&found.run);
        for (times, stage) in stages.iter_mut().zip(STAGES) {
            times.push(by_stage.get(&stage).copied().unwrap_or(0.0));
        }
        black_box(found);
    }
    let processor = processor_seconds().zip(before).map(|(after, before)| after - before);
    Ok(Runs {
        seconds: median(seconds),
        processor: processor.map(|all| all / ROUNDS as f64),
        stages: stages.map(median),
    })
}

fn by_stage(run: &RunReport) -> HashMap<Stage, f64> {
    run.times.iter().map(|time| (time.stage, time.seconds)).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets")
}

fn read(path: &Path) -> Result<Mesh, Box<dyn Error>> {
    let input = read_mesh(path)?;
    Ok((input.mesh.positions, input.mesh.triangles))
}

/// Each triangle becomes four, by the middles of its edges.
fn subdivide((positions, triangles): &Mesh) -> Mesh {
    let mut positions = positions.clone();
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut result = Vec::with_capacity(4 * triangles.len());
    for &[a, b, c] in triangles {
        let mut middle = |first: u32, second: u32| {
            *middles.entry((first.min(second), first.max(second))).or_insert_with(|| {
                let [p, q] = [first, second].map(|vertex| positions[vertex as usize]);
                positions.push([0, 1, 2].map(|axis| (p[axis] + q[axis]) / 2.0));
                positions.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        result.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    (positions, result)
}

/// Time that the main thread has spent on a processor, on Linux.
fn processor_seconds() -> Option<f64> {
    // The kernel counts when it switches threads.
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/self/schedstat").ok()?;
    Some(text.split_whitespace().next()?.parse::<f64>().ok()? / 1e9)
}

/// Most memory that the process has had, in MB, on Linux.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kilobytes| kilobytes / 1024)
}
