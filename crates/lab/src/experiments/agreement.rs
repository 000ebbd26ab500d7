//! `cargo lab agreement`: `hullwright::measure` against another evaluator.
//!
//! The other evaluator samples at random, 20,000 points on surfaces and 60,000 in space, so that
//! its figures have an error of their own. A figure that is farther from ours than agreed is marked:
//! - `^`: a maximum above theirs. Ours is a point that protrudes so far, and theirs missed it.
//! - `~`: no farther than such samples scatter: within the range of 100 measurements of ours with as
//!   many random points; for IoU within three standard deviations of a share of so many points.
//! - `!`: neither.

use std::path::PathBuf;
use std::time::Instant;

use hullwright::Error;
use hullwright::io::{MeshFile, NamedMesh, read_hulls, read_mesh};
use hullwright::measure::MeasureOptions;
use hullwright_cli::terminal::{Failure, print};

use crate::runs::data_folder::{DataFolder, ToolResult};
use crate::runs::judge::{Judged, judge};
use crate::statistics::range;

/// Compare `measure` with another evaluator, figure by figure, on hull files of other tools
#[derive(clap::Args)]
pub struct Arguments {
    /// A folder with peers/results.tsv, the hulls in peers/coacd and peers/vhacd_parry, and the
    /// meshes in meshes (those of glTF scenes flattened in peers/src)
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Agreed deviation of lengths, relative to the other evaluator's.
const RELATIVE: f64 = 0.05;

/// Agreed deviation of uncovered distances, uncovered volume, and IoU.
const ABSOLUTE: f64 = 0.005;

/// Points of the other evaluator.
const THEIR_SURFACE_POINTS: usize = 20_000;
const THEIR_VOLUME_POINTS: f64 = 60_000.0;

/// Standard deviations within which a share may scatter: one in 400 is farther.
const SIGMAS: f64 = 3.0;

/// Samples that show how much such samples scatter: enough for a range that one in 50 leaves.
const REPEATS: u64 = 100;

/// A figure that both evaluators give.
struct Figure {
    name: &'static str,
    /// Whether deviations are relative to theirs.
    is_relative: bool,
    is_maximum: bool,
    ours: fn(&Judged) -> Option<f64>,
    theirs: fn(&ToolResult) -> Option<f64>,
}

const FIGURES: [Figure; 8] = [
    Figure {
        name: "Hausdorff",
        is_relative: true,
        is_maximum: true,
        ours: |judged| Some(judged.hausdorff),
        theirs: |result| result.hausdorff,
    },
    Figure {
        name: "prot.mean",
        is_relative: true,
        is_maximum: false,
        ours: |judged| Some(judged.protrusion_mean),
        theirs: |result| result.protrusion_mean,
    },
    Figure {
        name: "prot.p99",
        is_relative: true,
        is_maximum: false,
        ours: |judged| Some(judged.protrusion_p99),
        theirs: |result| result.protrusion_p99,
    },
    Figure {
        name: "prot.max",
        is_relative: true,
        is_maximum: true,
        ours: |judged| Some(judged.protrusion_max),
        theirs: |result| result.protrusion_max,
    },
    Figure {
        name: "unc.mean",
        is_relative: false,
        is_maximum: false,
        ours: |judged| Some(judged.uncovered_mean),
        theirs: |result| result.uncovered_mean,
    },
    Figure {
        name: "unc.max",
        is_relative: false,
        is_maximum: true,
        ours: |judged| Some(judged.uncovered_max),
        theirs: |result| result.uncovered_max,
    },
    Figure {
        name: "unc.vol.",
        is_relative: false,
        is_maximum: false,
        ours: |judged| judged.uncovered_volume,
        theirs: |result| result.uncovered_volume,
    },
    Figure {
        name: "IoU",
        is_relative: false,
        is_maximum: false,
        ours: |judged| judged.iou,
        theirs: |result| result.iou,
    },
];

/// How often a figure agrees.
#[derive(Clone, Copy, Default)]
struct Tally {
    compared: usize,
    agreed: usize,
    missed: usize,
    scattered: usize,
    deviations: f64,
}

/// Hulls of another tool, their mesh, and our measurement of them.
struct Case {
    mesh: MeshFile,
    hulls: Vec<NamedMesh>,
    ours: Judged,
    /// Made when first needed.
    repeats: Option<Vec<Judged>>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let folder = DataFolder(arguments.folder.clone());
    let results = folder.tool_results()?;
    let columns: String = FIGURES.iter().map(|figure| format!("{:>9}", figure.name)).collect();
    print(&format!("{:51} {:6} {:>5} {columns}  seconds", "mesh", "method", "hulls"))?;
    let mut tallies = [Tally::default(); FIGURES.len()];
    let (mut equal_counts, mut seconds) = (0, 0.0);
    for result in &results {
        let start = Instant::now();
        let mut case = Case::new(&folder, result)?;
        let elapsed = start.elapsed().as_secs_f64();
        seconds += elapsed;
        let more_hulls = case.ours.hulls as i64 - result.hulls as i64;
        equal_counts += usize::from(more_hulls == 0);
        let method = result.method.split('-').next().unwrap_or_default();
        let mut line = format!("{:51} {method:6} {more_hulls:>+5} ", result.mesh);
        for (figure, tally) in FIGURES.iter().zip(&mut tallies) {
            line += &case.compare(figure, result, tally)?;
        }
        print(&format!("{line}  {elapsed:.2}"))?;
    }
    print("\n^ theirs missed a point that is farther out; ~ theirs is within scatter; ! neither")?;
    let each = seconds / results.len() as f64;
    print(&format!("hulls: {equal_counts} of {} counts equal; {each:.2} s each", results.len()))?;
    for (figure, tally) in FIGURES.iter().zip(tallies) {
        print(&tally.line(figure))?;
    }
    Ok(())
}

impl Case {
    fn new(folder: &DataFolder, result: &ToolResult) -> Result<Self, Error> {
        let mesh = read_mesh(folder.flat_mesh(&result.mesh))?;
        let hulls = read_hulls(if result.method.starts_with("vhacd") {
            folder.vhacd_hulls(&result.mesh)
        } else {
            folder.coacd_hulls(&result.mesh)
        })?;
        let options = MeasureOptions::default();
        let ours = judge(mesh.mesh.view(), &hulls, &options)?;
        Ok(Self { mesh, hulls, ours, repeats: None })
    }

    /// The deviation of one figure, with its mark.
    fn compare(
        &mut self,
        figure: &Figure,
        result: &ToolResult,
        tally: &mut Tally,
    ) -> Result<String, Error> {
        let (ours, theirs) = match ((figure.ours)(&self.ours), (figure.theirs)(result)) {
            (Some(ours), Some(theirs)) => (ours, theirs),
            (None, None) => return Ok("        –".into()),
            _ => return Ok("   given?".into()),
        };
        let deviation = if figure.is_relative { (ours - theirs) / theirs } else { ours - theirs };
        let limit = if figure.is_relative { RELATIVE } else { ABSOLUTE };
        tally.compared += 1;
        tally.deviations += deviation.abs();
        let mark = if deviation.abs() <= limit {
            tally.agreed += 1;
            ' '
        } else if figure.is_maximum && deviation > 0.0 {
            tally.missed += 1;
            '^'
        } else if self.is_scatter(figure, theirs)? {
            tally.scattered += 1;
            '~'
        } else {
            '!'
        };
        Ok(match figure.is_relative {
            true => format!("{:>+7.1}%{mark}", 100.0 * deviation),
            false => format!("{deviation:>+8.4}{mark}"),
        })
    }

    /// Whether samples as small as theirs scatter as far as their figure.
    fn is_scatter(&mut self, figure: &Figure, theirs: f64) -> Result<bool, Error> {
        if !figure.is_relative {
            let share = self.ours.iou.unwrap_or(0.0);
            let samples = &self.ours.samples;
            let points = THEIR_VOLUME_POINTS * samples.union as f64 / samples.space as f64;
            let sigma = (share * (1.0 - share) / points).sqrt();
            return Ok(figure.name == "IoU" && (share - theirs).abs() <= SIGMAS * sigma);
        }
        if self.repeats.is_none() {
            let Self { mesh, hulls, .. } = self;
            let repeats = (0..REPEATS).map(|repeat| {
                let mut options = MeasureOptions::default();
                options.hull_samples = THEIR_SURFACE_POINTS;
                options.mesh_samples = THEIR_SURFACE_POINTS;
                options.random_seed = Some(repeat);
                options.volume_samples = 0;
                judge(mesh.mesh.view(), hulls, &options)
            });
            self.repeats = Some(repeats.collect::<Result<_, _>>()?);
        }
        let (lowest, highest) = range(self.repeats.iter().flatten().filter_map(figure.ours));
        Ok(theirs >= lowest && theirs <= highest)
    }
}

impl Tally {
    fn line(self, figure: &Figure) -> String {
        let Self { compared, agreed, missed, scattered, deviations } = self;
        let average = deviations / compared.max(1) as f64;
        let (limit, average) = match figure.is_relative {
            true => (format!("{} %", 100.0 * RELATIVE), format!("{:.2} %", 100.0 * average)),
            false => (ABSOLUTE.to_string(), format!("{average:.5}")),
        };
        format!(
            "{:9} {agreed} of {compared} within {limit} (and {missed} ^, {scattered} ~), average \
             deviation {average}",
            figure.name
        )
    }
}
