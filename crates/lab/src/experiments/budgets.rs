//! `cargo lab budgets`: whether limits of time and memory hold.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use hullwright::io::{MeshFile, read_mesh};
use hullwright::{Control, Error, Parameters, TriangleMesh, decompose};
use hullwright_cli::terminal::{Failure, print};

use crate::runs::limits::{peak_memory, reset_peak_memory};
use crate::runs::meshes;

/// Show how far limits of time are exceeded, or how much memory a large mesh takes
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = meshes::files_help(), value_name = "MESH")]
    meshes: Vec<PathBuf>,
    /// Decompose a bumpy sphere of about so many triangles, and show the bytes per triangle
    #[arg(long, value_name = "COUNT")]
    sphere: Option<u32>,
}

/// Limits, as shares of the time that the whole work takes.
const SHARES: [f64; 4] = [0.1, 0.3, 0.5, 0.8];

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (mut soft, mut hard) = (Vec::new(), Vec::new());
    for path in &arguments.meshes {
        let file = read_mesh(path)?;
        let whole = match whole(&file) {
            Ok(whole) => whole,
            Err(error) => {
                print(&format!("{}: {error}", path.display()))?;
                continue;
            }
        };
        let mut worst = [Duration::ZERO; 2];
        for share in SHARES {
            let limit = whole.mul_f64(share);
            let (late, is_valid) = past(&file, limit, |control, at| control.with_deadline(at));
            let late = late.unwrap_or_default();
            worst[0] = worst[0].max(late);
            soft.push((share, late.as_secs_f64() / limit.as_secs_f64(), is_valid));
            let (late, _) = past(&file, limit, |control, at| control.with_time_limit(at));
            worst[1] = worst[1].max(late.unwrap_or_default());
            hard.push(late.unwrap_or_default());
        }
        let triangles = file.mesh.triangles.len();
        print(&format!(
            "{triangles:>9} triangles {whole:>10.1?} whole, past the deadline by {:>10.1?}, past the time limit by \
             {:>8.1?}  {}",
            worst[0],
            worst[1],
            path.display()
        ))?;
    }
    hard.sort();
    let at = |share: usize| hard.get(hard.len() * share / 100).copied().unwrap_or_default();
    for share in SHARES {
        let late = soft.iter().filter(|run| run.0 == share).map(|run| run.1);
        let mut late: Vec<f64> = late.collect();
        late.sort_by(f64::total_cmp);
        if let (Some(median), Some(last)) = (late.get(late.len() / 2), late.last()) {
            print(&format!(
                "deadlines at {share} of the time: {} of {} hold within 20 %; the end comes at {:.2} of the deadline \
                 in the median, {:.2} at most",
                late.iter().filter(|&&late| late <= 0.2).count(),
                late.len(),
                1.0 + median,
                1.0 + last,
            ))?;
        }
    }
    if !hard.is_empty() {
        print(&format!(
            "all deadlines end with a result: {}; of {} time limits 50 % hold within {:.1?}, 95 % within {:.1?}, all \
             within {:.1?}",
            soft.iter().all(|(_, _, is_valid)| *is_valid),
            hard.len(),
            at(50),
            at(95),
            hard.last().copied().unwrap_or_default(),
        ))?;
    }
    arguments.sphere.map_or(Ok(()), memory)
}

/// The time of the whole work: of three runs the middle one.
fn whole(file: &MeshFile) -> Result<Duration, Error> {
    let mut times = [Duration::ZERO; 3];
    for time in &mut times {
        let start = Instant::now();
        decompose(file, &Parameters::default(), &Control::new())?;
        *time = start.elapsed();
    }
    times.sort();
    Ok(times[1])
}

/// How long after a limit the work ended, and whether with a result; nothing where it was done before.
fn past(
    file: &MeshFile,
    limit: Duration,
    with_limit: impl FnOnce(Control, Instant) -> Control,
) -> (Option<Duration>, bool) {
    let at = Instant::now() + limit;
    let result = decompose(file, &Parameters::default(), &with_limit(Control::new(), at));
    (Instant::now().checked_duration_since(at), result.is_ok())
}

fn memory(count: u32) -> Result<(), Failure> {
    let mesh = sphere(count);
    let own = peak_memory(std::process::id());
    reset_peak_memory();
    let start = Instant::now();
    let result = decompose(&mesh, &Parameters::default(), &Control::new());
    let peak = peak_memory(std::process::id());
    let triangles = mesh.triangles.len();
    let per_triangle =
        |bytes: Option<u64>| bytes.map_or(f64::NAN, |bytes| bytes as f64 / triangles as f64);
    let outcome = match result {
        Ok(result) => format!("{} hulls", result.hulls.len()),
        Err(Error::Cancelled) => "cancelled".into(),
        Err(error) => error.to_string(),
    };
    print(&format!(
        "{triangles} triangles: {outcome} after {:.1?}; {:.0} bytes per triangle at most, of these {:.0} for the mesh \
         that is given",
        start.elapsed(),
        per_triangle(peak),
        per_triangle(own),
    ))
}

/// A sphere with bumps, in rings of as many quads as there are rings.
fn sphere(count: u32) -> TriangleMesh {
    let rings = (f64::from(count) / 2.0).sqrt() as u32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (ring, column) in (0..=rings).flat_map(|ring| (0..rings).map(move |column| (ring, column)))
    {
        let polar = f64::from(ring) / f64::from(rings) * std::f64::consts::PI;
        let around = f64::from(column) / f64::from(rings) * std::f64::consts::TAU;
        let radius = 1.0 + 0.1 * (7.0 * polar).sin() * (9.0 * around).cos();
        let [x, y] = [around.cos(), around.sin()].map(|x| radius * polar.sin() * x);
        positions.push([x, y, radius * polar.cos()]);
        if ring > 0 {
            let next = (column + 1) % rings;
            let [above, below] = [(ring - 1) * rings, ring * rings];
            triangles.push([above + column, below + column, below + next]);
            triangles.push([above + column, below + next, above + next]);
        }
    }
    TriangleMesh::new(positions, triangles)
}
