//! `cargo lab openings`: hulls and time with all openings kept, and with openings closed; or pictures of the
//! tests' own cases.

// The unused rest is for tests.
#[allow(dead_code)]
#[path = "../../../tests/openings/cases.rs"]
mod cases;

use std::path::{Path, PathBuf};
use std::time::Instant;

use hullwright::io::read_mesh;
use hullwright::measure::{MeasureOptions, measure};
use hullwright::{Control, Openings, Parameters, TriangleMesh, decompose};

use crate::pictures::{self, FROM_ABOVE, FROM_BELOW};
use crate::statistics::median;
use crate::terminal::{Failure, print};
use crate::tools::meshes::find;

/// Compare hulls and time with openings kept and with openings closed, on every mesh where one is closed
#[derive(clap::Args)]
pub struct Arguments {
    /// Meshes, and folders of meshes
    #[arg(required_unless_present = "cases", value_name = "DIR")]
    folders: Vec<PathBuf>,

    /// Draw the cases of the tests into this folder instead
    #[arg(long, conflicts_with = "folders", value_name = "DIR")]
    cases: Option<PathBuf>,
}

/// Cases beside each other, three panels each, of this size in pixels.
const COLUMNS: usize = 2;
const PANEL: (usize, usize) = (220, 180);

/// How far hulls move away from the centre, as a share of their distance.
const EXPLOSION: f64 = 0.3;

/// Meshes with one hull more may come out either way; with more it counts as worse.
const ONE_MORE: usize = 1;

/// What is summed over the meshes: with openings kept, and closed.
#[derive(Default)]
struct Totals {
    hulls: [usize; 2],
    seconds: [f64; 2],
    ratios: Vec<f64>,
    worse: usize,
    broken: usize,
    closed: usize,
    left: usize,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.cases {
        draw(&cases::solids(), FROM_BELOW, &folder.join("opening-cases-solid.png"))?;
        return draw(&cases::hollows(), FROM_ABOVE, &folder.join("opening-cases-hollow.png"));
    }
    let mut totals = Totals::default();
    for mesh in find(&arguments.folders)? {
        let Ok(file) = read_mesh(&mesh.path) else { continue };
        let control = Control::new();
        let timed = |openings: Openings| {
            let start = Instant::now();
            let parameters = Parameters::default().openings(openings);
            decompose(&file, &parameters, &control)
                .map(|found| (found, start.elapsed().as_secs_f64()))
        };
        let Ok((closed, after)) = timed(Openings::Auto) else { continue };
        let openings = &closed.run.openings;
        let count = openings.iter().filter(|opening| opening.outcome.is_closed()).count();
        if count == 0 {
            continue;
        }
        let (kept, before) = timed(Openings::Keep)?;
        let hulls = [kept.hulls.len(), closed.hulls.len()];
        totals.hulls = [totals.hulls[0] + hulls[0], totals.hulls[1] + hulls[1]];
        totals.seconds = [totals.seconds[0] + before, totals.seconds[1] + after];
        totals.ratios.push(after / before);
        totals.worse += usize::from(hulls[1] > hulls[0] + ONE_MORE);
        totals.closed += count;
        totals.left += openings.len() - count;
        let judged = measure(&file, &closed.hulls, &MeasureOptions::default(), &control)?;
        let bound = closed.report.bound;
        totals.broken += usize::from(judged.hausdorff * judged.diagonal > bound * (1.0 + 1e-6));
        print(&format!(
            "{:4} → {:3} hulls {:8.1} → {:7.1} ms {count:4} closed {:4} left  {}",
            hulls[0],
            hulls[1],
            1e3 * before,
            1e3 * after,
            openings.len() - count,
            mesh.path.display()
        ))?;
    }
    let Totals { hulls, seconds, ratios, worse, broken, closed, left } = totals;
    if ratios.is_empty() {
        return print("no opening was closed");
    }
    let ratio_of_hulls = hulls[1] as f64 / hulls[0] as f64;
    print(&format!(
        "{} meshes, {closed} openings closed, {left} left: {} → {} hulls ({ratio_of_hulls:.3} times), {:.2} → {:.2} s \
         ({:.2} times, median {:.2}), {worse} with more than one hull more, {broken} broken promises",
        ratios.len(),
        hulls[0],
        hulls[1],
        seconds[0],
        seconds[1],
        seconds[1] / seconds[0],
        median(ratios),
    ))
}

/// Draws each case, and prints what became of it.
fn draw(cases: &[(&str, TriangleMesh)], elevation: f64, path: &Path) -> Result<(), Failure> {
    let mut panels = Vec::new();
    print("| case | hulls, openings kept | hulls | openings |\n|---|---|---|---|")?;
    for (name, mesh) in cases {
        let (of_case, [kept, closed]) = pictures::openings(mesh, EXPLOSION)?;
        panels.extend(of_case);
        let found = decompose(mesh, &Parameters::default(), &Control::new())?.run.openings;
        let mut openings: Vec<&str> =
            found.iter().map(|opening| opening.outcome.describe()).collect();
        openings.sort_unstable();
        openings.dedup();
        let openings = if openings.is_empty() { "none".into() } else { openings.join("; ") };
        print(&format!("| {name} | {kept} | {closed} | {openings} |"))?;
    }
    let rows = panels.chunks(3 * COLUMNS).map(<[_]>::to_vec).collect();
    pictures::write(path, rows, PANEL, elevation)
}
