//! `hullwright curve`: hulls against error, from one run.

use std::path::{Path, PathBuf};

use hullwright::merge_tree::CurvePoint;
use hullwright::{Error, MergeTree};
use hullwright_cli::terminal::{Failure, print, print_json};
use hullwright_formats::write_file;
use plotters::prelude::*;
use serde_json::json;

use crate::arguments::{ParameterArguments, ThreadArguments, Uses, mesh_help};
use crate::notes::read_with_warnings;
use crate::progress::LateBar;
use crate::report;

/// Show hulls against error, from the decomposition down to one hull
#[derive(clap::Args)]
#[command(
    after_help = "The hulls of one decomposition are joined pair by pair, those first whose joint \
    hull protrudes least. Each error is verified against the mesh."
)]
pub struct Arguments {
    #[arg(help = mesh_help())]
    mesh: PathBuf,

    /// Draw the curve into this file: .svg
    #[arg(short, long, value_name = "OUT", value_parser = parse_output)]
    output: Option<PathBuf>,

    /// Print one line of JSON instead of a table
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    threads: ThreadArguments,

    #[command(flatten)]
    parameters: ParameterArguments,
}

fn parse_output(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_svg = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
    if is_svg { Ok(path) } else { Err("the curve is drawn as .svg".into()) }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let chosen = arguments.parameters.checked(&Uses { bound: true, ..Uses::default() })?;
    let name = arguments.mesh.display().to_string();
    let file = read_with_warnings(&arguments.mesh)?;
    let pool = arguments.threads.pool()?;
    let bar = LateBar::start();
    let control = bar.control().with_parallel(arguments.threads.is_parallel());
    let curve = pool.install(|| {
        let result = chosen.method.decompose(&file, &control)?;
        let tree = MergeTree::new(&file, &result, &chosen.solid(), &control)?;
        Ok::<_, Error>((tree.curve(), result))
    });
    bar.finish();
    let (curve, result) = curve.map_err(|error| format!("{name}: {error}"))?;
    let diagonal = result.run.diagonal;
    if let Some(output) = &arguments.output {
        draw(output, &curve, diagonal)
            .map_err(|error| format!("{}: can't be drawn: {error}", output.display()))?;
    }
    if arguments.json {
        let bound = result.report.bounded().map(|report| report.bound);
        return print_json(
            &json!({ "mesh": name, "diagonal": diagonal, "bound": bound, "curve": curve }),
        );
    }
    print(&report::curve(&curve, diagonal))?;
    result.exceeded_bound().map_or(Ok(()), |line| print(&line))
}

/// Size of the plot in pixels.
const SIZE: (u32, u32) = (640, 400);

/// Hulls to the right, error in percent of the diagonal upward.
fn draw(
    path: &Path,
    curve: &[CurvePoint],
    diagonal: f64,
) -> Result<(), Box<dyn std::error::Error>> {
    let most = curve.iter().map(|point| point.hulls).max().unwrap_or(1);
    let percent = |point: &CurvePoint| 100.0 * point.error / diagonal;
    let highest = curve.iter().map(percent).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&area)
            .margin(16)
            .x_label_area_size(40)
            .y_label_area_size(56)
            .build_cartesian_2d(0.0..most as f64 + 1.0, 0.0..1.05 * highest)?;
        chart
            .configure_mesh()
            .x_desc("hulls")
            .y_desc("error, % of the diagonal")
            .x_label_formatter(&|x| format!("{x:.0}"))
            .light_line_style(WHITE)
            .draw()?;
        let points = || curve.iter().map(|point| (point.hulls as f64, percent(point)));
        chart.draw_series(LineSeries::new(points(), BLUE.stroke_width(2)))?;
        chart.draw_series(points().map(|point| Circle::new(point, 3, BLUE.filled())))?;
        area.present()?;
    }
    Ok(write_file(path, text.as_bytes())?)
}
