//! Pictures as SVG: text in the reader's own sans-serif, so no fonts are needed to draw them.

use std::collections::BTreeMap;
use std::error::Error;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::curves::{geometric_mean, power_law};
use super::methods::Run;
use super::record::Row;
use super::summary::{METHODS, Results};

/// A picture, and the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub file: &'static str,
    pub title: &'static str,
    pub note: String,
    pub svg: String,
}

type Result<T> = std::result::Result<T, Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Width and height of the pictures in the report, and of the small ones.
const LARGE: (u32, u32) = (900, 560);
const SMALL: (u32, u32) = (560, 360);

/// One per method, in the order of [`METHODS`]: distinct for colour-blind eyes too (Okabe and Ito).
const COLOURS: [RGBColor; 7] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(140, 90, 60),
    RGBColor(230, 159, 0),
    RGBColor(180, 140, 0),
];

fn colour(method: &str) -> RGBColor {
    let place = METHODS.iter().position(|&other| other == method);
    place.map_or(BLACK, |place| COLOURS[place % COLOURS.len()])
}

/// What lies on a logarithmic axis is at least this.
const LEAST: f64 = 1e-5;

/// All pictures of a benchmark, those that have something to show.
pub fn pictures(results: &Results<'_>) -> std::result::Result<Vec<Picture>, String> {
    let draw = |size, paint: &dyn Fn(&Area<'_>) -> Result<()>| -> Result<String> {
        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        area.fill(&WHITE)?;
        paint(&area)?;
        area.present()?;
        drop(area);
        Ok(svg)
    };
    let all = || -> Result<Vec<Picture>> {
        let picture =
            |file, title, note: &str, svg| Picture { file, title, note: note.into(), svg };
        let means = "Large dots are geometric means over the meshes that all settings shown have \
                     done; lines join those that no other setting of the method beats.";
        let mut pictures = vec![
            picture(
                "error-time.svg",
                "Error against time",
                &format!("Every run (dots). {means}"),
                draw(LARGE, &|area| error_time(area, results, true))?,
            ),
            picture(
                "hulls-error.svg",
                "Hulls against error",
                means,
                draw(LARGE, &|area| hulls_error(area, results))?,
            ),
        ];
        let (svg, note) = time_triangles(results)?;
        pictures.push(picture("time-triangles.svg", "Time against triangles", &note, svg));
        if !stage_seconds(results).is_empty() {
            let note = "Mean seconds of each method's default setting, one thread.";
            let svg = draw(LARGE, &|area| stages(area, results))?;
            pictures.push(picture("stages.svg", "Time by stage", note, svg));
        }
        if let Some(shared) = results.shared_with_files() {
            let note =
                &format!("On the {} meshes of `coacd-files`. {means}", shared.meshes().len());
            let svg = draw(LARGE, &|area| error_time(area, &shared, true))?;
            let title = "Error against time where CoACD ran";
            pictures.push(picture("error-time-coacd.svg", title, note, svg));
            let svg = draw(LARGE, &|area| hulls_error(area, &shared))?;
            let title = "Hulls against error where CoACD ran";
            pictures.push(picture("hulls-error-coacd.svg", title, note, svg));
        }
        pictures.push(picture(
            "error-time-small.svg",
            "Error against time, small",
            means,
            draw(SMALL, &|area| error_time(area, results, false))?,
        ));
        pictures.push(picture(
            "hulls-error-small.svg",
            "Hulls against error, small",
            means,
            draw(SMALL, &|area| hulls_error(area, results))?,
        ));
        Ok(pictures)
    };
    all().map_err(|error| format!("a picture: {error}"))
}

/// What the axes of time say.
const SECONDS: &str = "seconds, one thread (CoACD and V-HACD 4: as many as they choose)";

/// A setting's geometric means over meshes.
struct Mean {
    seconds: f64,
    error: f64,
    hulls: f64,
}

/// For each method its settings' means, by error, over the meshes that all of these settings have
/// done. Methods that ran on few meshes are left out: their means would be those of other meshes.
fn means<'a>(results: &Results<'a>) -> Vec<(&'a str, Vec<Mean>)> {
    let done = |rows: &[&'a Row]| -> BTreeMap<&'a str, &'a Row> {
        let done = rows.iter().filter(|row| row.done().is_some());
        done.map(|row| (row.mesh.as_str(), *row)).collect()
    };
    let mut done: Vec<_> =
        results.variants().iter().map(|(name, rows)| (*name, done(rows))).collect();
    let most = done.iter().map(|(_, rows)| rows.len()).max().unwrap_or(0);
    done.retain(|(_, rows)| 2 * rows.len() > most);
    let common = |mesh: &&str| done.iter().all(|(_, rows)| rows.contains_key(mesh));
    let mut means: Vec<(&str, Vec<Mean>)> = Vec::new();
    for ((method, _), rows) in &done {
        let rows: Vec<_> = rows.iter().filter(|(mesh, _)| common(mesh)).collect();
        let of = |figure: fn(&Row) -> Option<f64>| {
            geometric_mean(rows.iter().filter_map(|(_, row)| figure(row)).map(|x| x.max(LEAST)))
        };
        let mean = (|| {
            Some(Mean {
                seconds: of(|row| Some(row.done()?.0.seconds))?,
                error: of(|row| Some(row.done()?.1.hausdorff))?,
                hulls: of(|row| Some(row.done()?.1.hulls as f64))?,
            })
        })();
        let Some(mean) = mean else { continue };
        match means.iter_mut().find(|(other, _)| other == method) {
            Some((_, list)) => list.push(mean),
            None => means.push((method, vec![mean])),
        }
    }
    for (_, list) in &mut means {
        list.sort_by(|a, b| a.error.total_cmp(&b.error));
    }
    means
}

/// Powers of ten around all values.
fn decades(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|value| value.is_finite() && *value > 0.0)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return 0.1..10.0;
    }
    let floor = 10.0_f64.powf(low.log10().floor());
    let ceiling = 10.0_f64.powf(high.log10().ceil());
    floor..if ceiling > floor { ceiling } else { 10.0 * floor }
}

/// Values with a little room around them.
fn room(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|value| value.is_finite() && *value > 0.0)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return 0.1..10.0;
    }
    // Less than this would leave an axis with a single label.
    const LEAST_SPAN: f64 = 20.0;
    let factor = (LEAST_SPAN / (high / low)).sqrt().max(1.3);
    low / factor..high * factor
}

fn label(value: &f64) -> String {
    match *value {
        value if value >= 1e4 => format!("{value:.0e}"),
        value if value >= 1.0 => format!("{value:.0}"),
        value => format!("{}", (value * 1e6).round() / 1e6),
    }
}

/// A chart with two logarithmic axes, and its legend.
macro_rules! log_chart {
    ($area:expr, $x:expr, $y:expr, $x_name:expr, $y_name:expr) => {{
        let mut chart = ChartBuilder::on($area)
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(58)
            .build_cartesian_2d($x.log_scale(), $y.log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .x_desc($x_name)
            .y_desc($y_name)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .label_style(("sans-serif", 13))
            .axis_desc_style(("sans-serif", 14))
            .draw()?;
        chart
    }};
}

macro_rules! legend {
    ($chart:expr, $position:expr) => {
        $chart
            .configure_series_labels()
            .position($position)
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .label_font(("sans-serif", 13))
            .draw()?
    };
}

fn error_time(area: &Area<'_>, results: &Results<'_>, with_runs: bool) -> Result<()> {
    let runs: Vec<(&str, f64, f64)> = results
        .rows
        .iter()
        .filter_map(|row| {
            let (worked, judged) = row.done()?;
            Some((row.method.as_str(), worked.seconds.max(LEAST), judged.hausdorff.max(LEAST)))
        })
        .collect();
    let means = means(results);
    let all = means.iter().flat_map(|(_, list)| list);
    let (x, y) = if with_runs {
        (decades(runs.iter().map(|run| run.1)), decades(runs.iter().map(|run| run.2)))
    } else {
        (decades(all.clone().map(|m| m.seconds)), room(all.map(|m| m.error)))
    };
    let mut chart = log_chart!(area, x, y, SECONDS, "Hausdorff error / diagonal");
    if with_runs {
        let mut unnamed: Vec<&str> = Vec::new();
        for &(method, seconds, error) in &runs {
            let colour = colour(method);
            let drawn =
                chart.draw_series([Circle::new((seconds, error), 2, colour.mix(0.25).filled())])?;
            // What ran on few meshes has no means, and would have no name else.
            if !unnamed.contains(&method) && !means.iter().any(|(other, _)| *other == method) {
                unnamed.push(method);
                drawn
                    .label(method)
                    .legend(move |(x, y)| Circle::new((x + 8, y), 2, colour.filled()));
            }
        }
    }
    for (method, list) in &means {
        let points: Vec<(f64, f64)> = list.iter().map(|mean| (mean.seconds, mean.error)).collect();
        let colour = colour(method);
        // Only the settings that no other of the method beats are joined.
        let mut front = points.clone();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut least = f64::INFINITY;
        front.retain(|point| {
            let is_better = point.1 < least;
            least = least.min(point.1);
            is_better
        });
        chart
            .draw_series(LineSeries::new(front, colour.stroke_width(2)))?
            .label(*method)
            .legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
        chart.draw_series(points.iter().map(|&point| Circle::new(point, 4, colour.filled())))?;
    }
    legend!(chart, SeriesLabelPosition::UpperRight);
    Ok(())
}

fn hulls_error(area: &Area<'_>, results: &Results<'_>) -> Result<()> {
    let means = means(results);
    let all = means.iter().flat_map(|(_, list)| list);
    let (x, y) = (room(all.clone().map(|m| m.error)), room(all.map(|m| m.hulls)));
    let mut chart = log_chart!(area, x, y, "Hausdorff error / diagonal", "hulls");
    for (method, list) in &means {
        let mut points: Vec<(f64, f64)> =
            list.iter().map(|mean| (mean.error, mean.hulls)).collect();
        let colour = colour(method);
        chart.draw_series(points.iter().map(|&point| Circle::new(point, 4, colour.filled())))?;
        let mut least = f64::INFINITY;
        points.retain(|point| {
            let is_better = point.1 < least;
            least = least.min(point.1);
            is_better
        });
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
            .label(*method)
            .legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
    }
    legend!(chart, SeriesLabelPosition::UpperRight);
    Ok(())
}

/// Scaling: each method's default setting, and the power law fitted to it.
fn time_triangles(results: &Results<'_>) -> Result<(String, String)> {
    let mut clouds: Vec<(&str, Vec<(f64, f64)>)> = Vec::new();
    let triangles: BTreeMap<&str, usize> = results
        .rows
        .iter()
        .filter_map(|row| Some((row.mesh.as_str(), row.worked.as_ref()?.triangles)))
        .filter(|(_, triangles)| *triangles > 0)
        .collect();
    for ((method, setting), rows) in results.variants() {
        if Run::parse(method, setting).is_some_and(|run| run.is_default()) {
            let point = |row: &&Row| {
                let seconds = row.done()?.0.seconds.max(LEAST);
                Some((*triangles.get(row.mesh.as_str())? as f64, seconds))
            };
            clouds.push((method, rows.iter().filter_map(point).collect()));
        }
    }
    let all = || clouds.iter().flat_map(|(_, cloud)| cloud);
    let (x, y) = (decades(all().map(|p| p.0)), decades(all().map(|p| p.1)));
    let mut svg = String::new();
    let mut slopes = Vec::new();
    {
        let area = SVGBackend::with_string(&mut svg, LARGE).into_drawing_area();
        area.fill(&WHITE)?;
        let mut chart = log_chart!(&area, x.clone(), y, "triangles", SECONDS);
        for (method, cloud) in &clouds {
            let colour = colour(method);
            let dots = cloud.iter().map(|&p| Circle::new(p, 3, colour.mix(0.5).filled()));
            let mut name = (*method).to_owned();
            let drawn = chart.draw_series(dots)?;
            if let Some((slope, value)) = power_law(cloud) {
                name = format!("{method}: slope {slope:.2}");
                slopes.push(name.clone());
                drawn.label(name).legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
                let ends = [x.start, x.end].map(|x| (x, value * x.powf(slope)));
                chart.draw_series(LineSeries::new(ends, colour.stroke_width(1)))?;
            } else {
                drawn.label(name).legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
            }
        }
        legend!(chart, SeriesLabelPosition::UpperLeft);
        area.present()?;
    }
    let note = format!(
        "Each method's default setting; lines are least squares in logarithms ({}).",
        slopes.join(", ")
    );
    Ok((svg, note))
}

/// For each method its stages in the order of the work, with mean seconds.
fn stage_seconds<'a>(results: &Results<'a>) -> Vec<(&'a str, Vec<(String, f64)>)> {
    let mut found = Vec::new();
    for ((method, setting), rows) in results.variants() {
        if !Run::parse(method, setting).is_some_and(|run| run.is_default()) {
            continue;
        }
        let done: Vec<_> = rows.iter().filter_map(|row| row.done()).collect();
        let mut sums: Vec<(String, f64)> = Vec::new();
        for (name, seconds) in done.iter().flat_map(|(worked, _)| &worked.stages) {
            let share = seconds / done.len() as f64;
            match sums.iter_mut().find(|(other, _)| other == name) {
                Some((_, sum)) => *sum += share,
                None => sums.push((name.clone(), share)),
            }
        }
        if !sums.is_empty() {
            found.push((method, sums));
        }
    }
    found
}

/// Bars of one unit of height, one per method, a gap below each.
fn stages(area: &Area<'_>, results: &Results<'_>) -> Result<()> {
    const BAR: f64 = 0.6;
    const SHADES: [RGBColor; 9] = [
        RGBColor(86, 180, 233),
        RGBColor(0, 114, 178),
        RGBColor(0, 158, 115),
        RGBColor(240, 228, 66),
        RGBColor(230, 159, 0),
        RGBColor(213, 94, 0),
        RGBColor(204, 121, 167),
        RGBColor(120, 120, 120),
        RGBColor(60, 60, 60),
    ];
    let bars = stage_seconds(results);
    let mut names: Vec<String> = Vec::new();
    for (name, _) in bars.iter().flat_map(|(_, stages)| stages) {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    let total = |stages: &[(String, f64)]| stages.iter().map(|(_, seconds)| seconds).sum::<f64>();
    let longest = bars.iter().map(|(_, stages)| total(stages)).fold(0.0, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(12)
        .build_cartesian_2d(0.0..longest * 1.25, 0.0..bars.len() as f64)?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .light_line_style(WHITE)
        .y_labels(0)
        .x_desc("mean seconds")
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 14))
        .draw()?;
    for (place, name) in names.iter().enumerate() {
        let shade = SHADES[place % SHADES.len()];
        let mut boxes = Vec::new();
        for (row, (_, stages)) in bars.iter().rev().enumerate() {
            let before = stages.iter().take_while(|(other, _)| other != name).map(|(_, s)| s).sum();
            let Some((_, seconds)) = stages.iter().find(|(other, _)| other == name) else {
                continue;
            };
            let low = row as f64 + 0.1;
            boxes.push(Rectangle::new(
                [(before, low), (before + seconds, low + BAR)],
                shade.filled(),
            ));
        }
        chart
            .draw_series(boxes)?
            .label(name.clone())
            .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 12, y + 5)], shade.filled()));
    }
    let style = ("sans-serif", 14).into_font();
    chart.draw_series(bars.iter().rev().enumerate().map(|(row, (method, _))| {
        Text::new((*method).to_owned(), (longest * 0.005, row as f64 + BAR + 0.3), style.clone())
    }))?;
    legend!(chart, SeriesLabelPosition::UpperRight);
    Ok(())
}
