//! `cargo lab openings`: hulls and time with all openings kept, and with openings closed; or pictures of the
//! tests' own cases.

// The unused rest is for tests.
#[allow(dead_code)]
#[path = "../../../tests/openings/cases.rs"]
mod cases;

use std::path::{Path, PathBuf};

use hullwright::{Control, Openings, Parameters, Preset, TriangleMesh, decompose};

use crate::harness::session::limits;
use crate::harness::{FULL, Row, Session, Task};
use crate::pictures::{self, FROM_ABOVE, FROM_BELOW};
use crate::statistics::median;
use crate::terminal::{Failure, print};
use crate::tools::meshes::find;
use crate::tools::methods::Run;

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
const ONE_MORE: f64 = 1.0;

/// Longest time of a run in seconds, and most memory in megabytes: as in the benchmark.
const LIMITS: (f64, u64) = (300.0, 4096);

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.cases {
        draw(&cases::solids(), FROM_BELOW, &folder.join("opening-cases-solid.png"))?;
        return draw(&cases::hollows(), FROM_ABOVE, &folder.join("opening-cases-hollow.png"));
    }
    let session = Session::temporary(limits(LIMITS.0, LIMITS.1)?)?;
    let task = |openings| {
        Task::new(Run::Bounded { error: 0.02, preset: Preset::Balanced, openings }, FULL)
    };
    let detail = |row: &Row, name: &str| row.details.get(name).copied().unwrap_or(0.0);
    let mut pairs = Vec::new();
    let meshes = find(&arguments.folders)?;
    for (number, mesh) in meshes.iter().enumerate() {
        let place = (number + 1, meshes.len());
        let Some(closed) = session.row(place, mesh, &task(Openings::Auto))? else { continue };
        if detail(&closed, "openings_closed") > 0.0
            && let Some(kept) = session.row(place, mesh, &task(Openings::Keep))?
        {
            pairs.push((kept, closed));
        }
    }
    if pairs.is_empty() {
        return print("no opening was closed");
    }
    let sum = |of: &dyn Fn(&(Row, Row)) -> f64| pairs.iter().map(of).sum::<f64>();
    let hulls = |row: &Row| row.hulls.unwrap_or(0) as f64;
    let seconds = |row: &Row| row.seconds_all_threads.unwrap_or(0.0);
    let [before, after] = [sum(&|pair| hulls(&pair.0)), sum(&|pair| hulls(&pair.1))];
    let worse = pairs.iter().filter(|pair| hulls(&pair.1) > hulls(&pair.0) + ONE_MORE).count();
    print(&format!(
        "{} meshes, {} openings closed, {} left: {before} → {after} hulls ({:.3} times), in {:.2} times the time \
         (median {:.2}), {worse} with more than one hull more, {} broken promises",
        pairs.len(),
        sum(&|pair| detail(&pair.1, "openings_closed")),
        sum(&|pair| detail(&pair.1, "openings_left")),
        after / before,
        sum(&|pair| seconds(&pair.1)) / sum(&|pair| seconds(&pair.0)),
        median(pairs.iter().map(|pair| seconds(&pair.1) / seconds(&pair.0)).collect()),
        pairs.iter().filter(|pair| !pair.1.broken.is_empty()).count(),
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
