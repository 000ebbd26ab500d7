//! `cargo lab growth`: how time and memory grow with the number of triangles, by kind of mesh.

mod shapes;
pub mod worker;

use std::path::PathBuf;
use std::process::Command;

use self::shapes::KINDS;
use self::worker::{BOUND, Grown};
use crate::harness::describe;
use crate::harness::limits::{self, Limits, Status};
use crate::harness::session;
use crate::plots::{Series, log_lines};
use crate::report::{NOTHING, Plot, Report, Table, create_folder, number, number_or_nothing};
use crate::statistics::power;
use crate::terminal::{Failure, print, time};

/// Decompose meshes of several kinds in growing sizes, and report how time and memory grow
///
/// Each size runs in a process of its own, on one thread. A kind ends with the first size that
/// reaches a limit.
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// The most triangles
    #[arg(long, value_name = "TRIANGLES", default_value_t = 10_000_000)]
    most: usize,

    /// The longest time of a size, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 120.0)]
    time_limit: f64,

    /// The most memory of a size, in megabytes
    #[arg(long, value_name = "MB", default_value_t = 8192)]
    memory_limit: u64,
}

/// Sizes for each power of ten.
const STEPS: [usize; 2] = [1, 3];

/// Sizes from here on count for the slope: below, what every mesh costs shows.
const FITTED: usize = 10_000;

/// The sizes of a kind, and why there are no more.
struct Line {
    name: &'static str,
    sizes: Vec<Grown>,
    end: String,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    create_folder(&arguments.output)?;
    let limits = session::limits(arguments.time_limit, arguments.memory_limit)?;
    let lines = KINDS.iter().map(|kind| line((kind.0, kind.1), arguments.most, limits));
    let lines = lines.collect::<Result<Vec<Line>, Failure>>()?;
    let words = vec![format!(
        "Time of the processor and the peak of the memory, the mesh itself included, on one thread under a bound of \
         {BOUND} of the diagonal. A kind ends at {} triangles, at {} s or at {} MB.",
        arguments.most, arguments.time_limit, arguments.memory_limit,
    )];
    let time: Figure = |size| Some(size.seconds);
    let plots = [
        plot(&lines, ("growth-time.svg", "Time by triangles"), "seconds", time)?,
        plot(&lines, ("growth-memory.svg", "Memory by triangles"), "MB", |size| size.megabytes)?,
    ];
    let plots = plots.into_iter().flatten().collect();
    let tables = vec![slopes(&lines), sizes(&lines)];
    let (title, name, machine) = ("Growth", "growth", describe());
    Ok(Report { title, name, words, machine, plots, tables }.write(&arguments.output)?)
}

/// Grows a kind until it reaches a limit.
fn line(
    (name, least): (&'static str, usize),
    most: usize,
    limits: Limits,
) -> Result<Line, Failure> {
    let mut line = Line { name, sizes: Vec::new(), end: NOTHING.into() };
    let powers = (0..).map(|power| least.saturating_mul(10_usize.saturating_pow(power)));
    let all = powers.flat_map(|power| STEPS.map(|step| power.saturating_mul(step)));
    for triangles in all.take_while(|&triangles| triangles <= most) {
        let program = std::env::current_exe().map_err(|error| format!("this program: {error}"))?;
        let mut command = Command::new(program);
        command.args(["grow", name, &triangles.to_string()]).env("RAYON_NUM_THREADS", "1");
        let ended = limits::run(command, limits)?;
        if ended.status != Status::Done {
            line.end = format!("{triangles}: {}, {}", ended.status.name(), ended.reason);
            print(&format!("{name:<20} {}", line.end))?;
            break;
        }
        let last = ended.lines.last().map_or("", String::as_str);
        let size: Grown = serde_json::from_str(last).map_err(|e| format!("a worker said: {e}"))?;
        let Grown { triangles, seconds, hulls, .. } = size;
        print(&format!(
            "{name:<20} {triangles:>9} triangles {:>9} {hulls:>6} hulls",
            time(seconds)
        ))?;
        line.sizes.push(size);
    }
    Ok(line)
}

/// A figure of a size, for plots and slopes.
type Figure = fn(&Grown) -> Option<f64>;

fn points(sizes: &[Grown], figure: Figure) -> Vec<(f64, f64)> {
    sizes.iter().filter_map(|size| Some((size.triangles as f64, figure(size)?))).collect()
}

/// Nothing where no size was reached.
fn plot(
    lines: &[Line],
    (file, title): (&'static str, &'static str),
    y: &str,
    figure: Figure,
) -> Result<Option<Plot>, String> {
    let series = lines
        .iter()
        .map(|line| Series { name: line.name.into(), points: points(&line.sizes, figure) });
    let note = format!("{title}, both axes logarithmic: a straight line is a power.");
    let svg = log_lines(title, "triangles", y, series.collect())?;
    Ok(svg.map(|svg| Plot { file, title, note, svg }))
}

fn slopes(lines: &[Line]) -> Table {
    let header = [
        "kind",
        "slope of time",
        "of the last three sizes",
        "slope of memory",
        "bytes a triangle",
        "ended at",
    ];
    let note = format!(
        "The power of the number of triangles with which time and memory grow: least squares over \
         the logarithms, from {FITTED} triangles on, or over all sizes of a kind that ends before. \
         Bytes are those of the largest size."
    );
    let mut table = Table::new("Slopes", &note, &header);
    for Line { name, sizes, end } in lines {
        // Meshes have a few triangles less than they should.
        let first = sizes.partition_point(|size| 10 * size.triangles < 9 * FITTED);
        let fitted = if first < sizes.len() { &sizes[first..] } else { &sizes[..] };
        let last = &sizes[sizes.len().saturating_sub(3)..];
        let slope = |sizes, figure| number_or_nothing(power(&points(sizes, figure)));
        let bytes = sizes
            .last()
            .and_then(|size| Some(size.megabytes? * f64::from(1 << 20) / size.triangles as f64));
        table.rows.push(vec![
            (*name).to_owned(),
            slope(fitted, |size| Some(size.seconds)),
            slope(last, |size| Some(size.seconds)),
            slope(fitted, |size| size.megabytes),
            number_or_nothing(bytes),
            end.clone(),
        ]);
    }
    table
}

fn sizes(lines: &[Line]) -> Table {
    let header = ["kind", "triangles", "seconds", "MB", "hulls", "verified error over the bound"];
    let mut table = Table::new("Sizes", "", &header);
    for (line, size) in lines.iter().flat_map(|line| line.sizes.iter().map(move |s| (line, s))) {
        table.rows.push(vec![
            line.name.to_owned(),
            size.triangles.to_string(),
            number(size.seconds),
            number_or_nothing(size.megabytes),
            size.hulls.to_string(),
            number(size.error),
        ]);
    }
    table
}
