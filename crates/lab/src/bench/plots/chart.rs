//! What the plots share: colours, axes and the legend.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::bench::summary::METHODS;
use crate::statistics::range;

pub(super) type Result<T> = std::result::Result<T, Box<dyn Error>>;
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// An SVG of a size in pixels.
pub(super) fn draw(size: (u32, u32), paint: impl Fn(&Area<'_>) -> Result<()>) -> Result<String> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    area.fill(&WHITE)?;
    paint(&area)?;
    area.present()?;
    drop(area);
    Ok(svg)
}

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

pub(super) fn colour(method: &str) -> RGBColor {
    let place = METHODS.iter().position(|&other| other == method);
    place.map_or(BLACK, |place| COLOURS[place % COLOURS.len()])
}

/// What lies on a logarithmic axis is at least this.
pub(super) const LEAST: f64 = 1e-5;

/// What the axes of time say.
pub(super) const SECONDS: &str = "seconds, one thread (CoACD and V-HACD 4: as many as they choose)";

/// Powers of ten around all values.
pub(super) fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = range(values.filter(|value| value.is_finite() && *value > 0.0));
    if low > high {
        return 0.1..10.0;
    }
    let floor = 10.0_f64.powf(low.log10().floor());
    let ceiling = 10.0_f64.powf(high.log10().ceil());
    floor..if ceiling > floor { ceiling } else { 10.0 * floor }
}

/// Values with a little room around them.
pub(super) fn room(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = range(values.filter(|value| value.is_finite() && *value > 0.0));
    if low > high {
        return 0.1..10.0;
    }
    // Less than this would leave an axis with a single label.
    const LEAST_SPAN: f64 = 20.0;
    let factor = (LEAST_SPAN / (high / low)).sqrt().max(1.3);
    low / factor..high * factor
}

pub(super) fn label(value: &f64) -> String {
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

/// A box with the names of the series.
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

pub(super) use {legend, log_chart};
