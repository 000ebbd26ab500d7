//! What the plots share: colours, axes and the legend.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::bench::summary::METHODS;
use crate::statistics::range;

pub(super) type Result<T> = std::result::Result<T, Box<dyn Error>>;
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Of the viewer's pages: what is behind everything, letters, quiet letters, lines.
const PAPER: RGBColor = RGBColor(245, 246, 249);
const INK: RGBColor = RGBColor(28, 32, 39);
const QUIET: RGBColor = RGBColor(90, 98, 112);
const LINE: RGBColor = RGBColor(217, 221, 229);

/// The same colours for dark pages, which a picture can't ask for: it follows the reader's own choice.
const DARK: [(RGBColor, &str); 4] =
    [(PAPER, "#15181d"), (INK, "#eceff4"), (QUIET, "#9aa4b2"), (LINE, "#323843")];

const FONT: &str = "sans-serif";

/// What `sans-serif` becomes in the file: the letters of the reader's own system.
const FONTS: &str = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', sans-serif";

/// Sizes of letters. A plot of 560 pixels is shown at about that width in a README.
const TITLE_SIZE: i32 = 17;
pub(super) const LABEL_SIZE: i32 = 13;

/// Height of the line with the title, and the width of a letter of it in the median, in pixels: so many
/// fit a line.
const TITLE_LINE: i32 = 24;
const TITLE_LETTER: f64 = 8.6;

/// An SVG of a size in pixels, with what it says above it.
pub(super) fn draw(
    size: (u32, u32),
    title: &str,
    paint: impl Fn(&Area<'_>) -> Result<()>,
) -> Result<String> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        area.fill(&PAPER)?;
        let lines = wrapped(title, (f64::from(size.0 - 28) / TITLE_LETTER) as usize);
        let style = (FONT, TITLE_SIZE).into_font().style(FontStyle::Bold).color(&INK);
        for (place, line) in (0..).zip(&lines) {
            area.draw_text(line, &style, (16, 14 + TITLE_LINE * place))?;
        }
        let (_, rest) = area.split_vertically(16 + TITLE_LINE * lines.len() as i32);
        paint(&rest)?;
        area.present()?;
    }
    Ok(for_dark_pages(&svg))
}

/// Words in lines of at most so many letters.
fn wrapped(text: &str, letters: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= letters => {
                *line += " ";
                *line += word;
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The same picture, dark where the reader prefers that.
fn for_dark_pages(svg: &str) -> String {
    let mut style = String::from("<style>@media (prefers-color-scheme: dark) {");
    for (RGBColor(r, g, b), dark) in DARK {
        let light = format!("#{r:02X}{g:02X}{b:02X}");
        for property in ["fill", "stroke"] {
            style += &format!("[{property}=\"{light}\"]{{{property}:{dark}}}");
        }
    }
    style += "}</style>\n";
    let svg = svg.replace(&format!("font-family=\"{FONT}\""), &format!("font-family=\"{FONTS}\""));
    match svg.split_once(">\n") {
        Some((head, rest)) => format!("{head}>\n{style}{rest}"),
        None => svg,
    }
}

/// One per method, in the order of [`METHODS`]: distinct for colour-blind eyes too (Okabe and Ito).
const COLOURS: [RGBColor; 7] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(150, 105, 75),
    RGBColor(230, 159, 0),
    RGBColor(180, 140, 0),
];

pub(super) fn colour(method: &str) -> RGBColor {
    let place = METHODS.iter().position(|&other| other == method);
    place.map_or(QUIET, |place| COLOURS[place % COLOURS.len()])
}

/// A method's name for people.
pub(super) fn display_name(method: &str) -> &str {
    match method {
        "bounded" => "Hullwright",
        "surface" => "surface (the paper's)",
        "hacd" => "HACD",
        "vhacd" => "V-HACD in Parry",
        "vhacd4" => "V-HACD 4",
        "coacd" => "CoACD",
        "coacd-files" => "CoACD (files)",
        other => other,
    }
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

/// A number on a logarithmic axis; nothing where numbers would stand too close.
pub(super) fn label(value: &f64) -> String {
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

/// The style of axes and their labels.
pub(super) fn quiet(size: i32) -> TextStyle<'static> {
    (FONT, size).into_font().color(&QUIET)
}

pub(super) const GRID: RGBColor = LINE;
pub(super) const BACKGROUND: RGBColor = PAPER;

/// A chart with two logarithmic axes.
macro_rules! log_chart {
    ($area:expr, $x:expr, $y:expr, $x_name:expr, $y_name:expr) => {{
        let mut chart = ChartBuilder::on($area)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(62)
            .build_cartesian_2d($x.log_scale(), $y.log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(BACKGROUND)
            .bold_line_style(GRID)
            .axis_style(GRID)
            .x_desc($x_name)
            .y_desc($y_name)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .label_style(quiet(LABEL_SIZE))
            .axis_desc_style(quiet(LABEL_SIZE))
            .draw()?;
        chart
    }};
}

/// The names of the series.
macro_rules! legend {
    ($chart:expr, $position:expr) => {
        $chart
            .configure_series_labels()
            .position($position)
            .background_style(TRANSPARENT)
            .border_style(TRANSPARENT)
            .label_font(quiet(LABEL_SIZE + 1))
            .draw()?
    };
}

pub(super) use {legend, log_chart};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_says_its_title_and_is_dark_where_that_is_preferred() {
        let svg = draw((560, 360), "ten words are more than fit one line of this plot", |area| {
            area.fill(&WHITE).map_err(Into::into)
        })
        .unwrap();
        assert!(svg.starts_with("<svg"));
        assert!(svg.contains("prefers-color-scheme: dark") && svg.contains("#15181d"));
        assert!(svg.contains("ten words"));
    }

    #[test]
    fn labels_are_few_enough_to_be_read() {
        let labels = [0.001, 0.002, 0.003, 0.009, 0.5, 1.0, 7.0, 20.0].map(|value| label(&value));
        assert_eq!(labels, ["0.001", "0.002", "", "", "0.5", "1", "", "20"]);
    }

    #[test]
    fn lines_break_between_words() {
        assert_eq!(wrapped("one two three", 7), ["one two", "three"]);
        assert_eq!(wrapped("longer than that", 3), ["longer", "than", "that"]);
    }
}
