//! Error against time as SVG: one line per method through its settings.

use std::collections::BTreeMap;
use std::error::Error;
use std::ops::Range;

use plotters::prelude::*;

use super::summary::{METHODS, Results};
use crate::harness::Row;
use crate::plots::{FONT, INK, LABEL_SIZE, LINE, PAPER, QUIET, SIZE, TITLE_SIZE, for_dark_pages};
use crate::report::Plot;
use crate::statistics::{geometric_mean, range};

const TITLE: &str = "Error against time";

/// One per method, in the order of [`METHODS`]: distinct for colour-blind eyes too (Okabe and Ito).
/// Then the method's name for people.
const COLOURS: [(RGBColor, &str); 6] = [
    (RGBColor(213, 94, 0), "Hullwright"),
    (RGBColor(0, 114, 178), "surface (the paper's)"),
    (RGBColor(0, 158, 115), "HACD in its frame"),
    (RGBColor(204, 121, 167), "V-HACD in Parry"),
    (RGBColor(180, 140, 0), "CoACD (files)"),
    (RGBColor(86, 180, 233), "CuACD (files, on an H100)"),
];

/// What lies on a logarithmic axis is at least this.
const LEAST: f64 = 1e-5;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

pub fn plot(results: &Results<'_>) -> std::result::Result<Plot, String> {
    let note = "Every run (dots). Large dots are geometric means over the meshes that all settings shown have done; \
                lines join those that no other setting of the method beats.";
    let svg = draw(results).map_err(|error| format!("a plot: {error}"))?;
    Ok(Plot { file: "error-time.svg", title: TITLE, note: note.into(), svg })
}

/// A setting's geometric means over meshes.
struct Mean {
    seconds: f64,
    error: f64,
}

/// For each method its settings' means, by error, over the meshes that all of these settings have
/// done. Methods that ran on few meshes are left out: their means would be those of other meshes.
fn means<'a>(results: &Results<'a>) -> Vec<(&'a str, Vec<Mean>)> {
    let done = |rows: &[&'a Row]| -> BTreeMap<&'a str, &'a Row> {
        let done = rows.iter().filter(|row| row.is_done());
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
        let pair = of(|row| row.seconds).zip(of(|row| row.hausdorff));
        let Some((seconds, error)) = pair else { continue };
        match means.iter_mut().find(|(other, _)| other == method) {
            Some((_, list)) => list.push(Mean { seconds, error }),
            None => means.push((method, vec![Mean { seconds, error }])),
        }
    }
    for (_, list) in &mut means {
        list.sort_by(|a, b| a.error.total_cmp(&b.error));
    }
    means
}

/// The settings that no other of the method beats, by time: those are joined by a line.
fn front(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut least = f64::INFINITY;
    points.retain(|point| {
        let is_better = point.1 < least;
        least = least.min(point.1);
        is_better
    });
    points
}

fn draw(results: &Results<'_>) -> Result<String> {
    let colour = |method: &str| {
        let place = METHODS.iter().position(|&other| other == method);
        place.and_then(|place| COLOURS.get(place)).copied().unwrap_or((QUIET, "another"))
    };
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&PAPER)?;
        let style = (FONT, TITLE_SIZE).into_font().style(FontStyle::Bold).color(&INK);
        area.draw_text(TITLE, &style, (16, 14))?;
        let (_, area) = area.split_vertically(40);

        let runs = results.rows.iter().filter(|row| row.is_done());
        let runs: Vec<(&str, (f64, f64))> = runs
            .filter_map(|row| Some((row.method.as_str(), row.seconds.zip(row.hausdorff)?)))
            .map(|(method, (x, y))| (method, (x.max(LEAST), y.max(LEAST))))
            .collect();
        let means = means(results);
        let (x, y) =
            (decades(runs.iter().map(|run| run.1.0)), decades(runs.iter().map(|run| run.1.1)));
        let quiet = |size: i32| (FONT, size).into_font().color(&QUIET);
        let mut chart = ChartBuilder::on(&area)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(62)
            .build_cartesian_2d(x.log_scale(), y.log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(PAPER)
            .bold_line_style(LINE)
            .axis_style(LINE)
            .x_desc("seconds, one thread (CoACD: as many as it chooses)")
            .y_desc("error: Hausdorff distance / diagonal")
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .label_style(quiet(LABEL_SIZE))
            .axis_desc_style(quiet(LABEL_SIZE))
            .draw()?;
        let mut named: Vec<&str> = means.iter().map(|(method, _)| *method).collect();
        for &(method, point) in &runs {
            let (colour, name) = colour(method);
            let drawn = chart.draw_series([Circle::new(point, 2, colour.mix(0.25).filled())])?;
            // What ran on few meshes has no means, and no other name.
            if !named.contains(&method) {
                named.push(method);
                let dot = move |(x, y)| Circle::new((x + 8, y), 2, colour.filled());
                drawn.label(name).legend(dot);
            }
        }
        for (method, list) in &means {
            let points: Vec<(f64, f64)> = list.iter().map(|m| (m.seconds, m.error)).collect();
            let (colour, name) = colour(method);
            chart
                .draw_series(LineSeries::new(front(points.clone()), colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
            chart.draw_series(points.iter().map(|&at| Circle::new(at, 4, colour.filled())))?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .background_style(TRANSPARENT)
            .border_style(TRANSPARENT)
            .label_font(quiet(LABEL_SIZE + 1))
            .draw()?;
        area.present()?;
    }
    Ok(for_dark_pages(&svg))
}

/// Powers of ten around all values.
fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = range(values.filter(|value| value.is_finite() && *value > 0.0));
    if low > high {
        return 0.1..10.0;
    }
    let floor = 10.0_f64.powf(low.log10().floor());
    let ceiling = 10.0_f64.powf(high.log10().ceil());
    floor..if ceiling > floor { ceiling } else { 10.0 * floor }
}

/// A number on a logarithmic axis; nothing where numbers would stand too close.
fn label(value: &f64) -> String {
    let digit = value / 10_f64.powf(value.log10().floor());
    // By rounding a power of ten may come out as ten times the one before.
    if ![1.0, 2.0, 5.0, 10.0].iter().any(|labelled| (digit - labelled).abs() < 0.01) {
        return String::new();
    }
    match *value {
        value if value >= 1e4 => format!("{value:.0e}"),
        value if value >= 1.0 => format!("{value:.0}"),
        value => format!("{}", (value * 1e6).round() / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_says_its_title_and_is_dark_where_that_is_preferred() {
        let svg = draw(&Results::new(&[])).unwrap();
        assert!(svg.starts_with("<svg") && svg.contains(TITLE));
        assert!(svg.contains("prefers-color-scheme: dark") && svg.contains("#15181d"));
    }

    #[test]
    fn labels_are_few_enough_to_be_read() {
        let labels = [0.001, 0.002, 0.003, 0.009, 0.5, 1.0, 7.0, 20.0].map(|value| label(&value));
        assert_eq!(labels, ["0.001", "0.002", "", "", "0.5", "1", "", "20"]);
    }
}
