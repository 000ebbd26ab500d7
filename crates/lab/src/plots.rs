//! What plots look like, and lines over a parameter. SVG with text in the reader's own sans-serif,
//! so no fonts are needed to draw it.

use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

use crate::statistics::range;

/// Width and height.
pub const SIZE: (u32, u32) = (900, 560);

/// Of the viewer's pages: what is behind everything, letters, quiet letters, lines.
pub const PAPER: RGBColor = RGBColor(245, 246, 249);
pub const INK: RGBColor = RGBColor(28, 32, 39);
pub const QUIET: RGBColor = RGBColor(90, 98, 112);
pub const LINE: RGBColor = RGBColor(217, 221, 229);

/// The same colours for dark pages: the picture follows the reader's own choice.
const DARK: [(RGBColor, &str); 4] =
    [(PAPER, "#15181d"), (INK, "#eceff4"), (QUIET, "#9aa4b2"), (LINE, "#323843")];

pub const FONT: &str = "sans-serif";

/// What `sans-serif` becomes in the file: the letters of the reader's own system.
const FONTS: &str = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', sans-serif";

/// Sizes of letters in pixels.
pub const TITLE_SIZE: i32 = 17;
pub const LABEL_SIZE: i32 = 13;

/// The first are distinct for colour-blind eyes too (Okabe and Ito); of more lines they repeat.
const COLOURS: [RGBColor; 10] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(180, 140, 0),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
    RGBColor(110, 60, 150),
    RGBColor(120, 75, 30),
    RGBColor(150, 190, 60),
];

/// The room to the right for the names of the lines, as a share of their width: those of a
/// logarithmic axis are longer.
const NAMES: f64 = 0.1;
const LONG_NAMES: f64 = 0.25;

/// A line and its name.
pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// Lines with a dot at each point; y is logarithmic.
pub fn lines(title: &str, x: &str, y: &str, series: &[Series]) -> Result<String, String> {
    let (left, right) = range(places(series));
    let across = left..right + NAMES * (right - left);
    draw([title, x, y], series, across, None).map_err(|error| format!("a plot: {error}"))
}

/// The same, x too; nothing without points. Lines without any have no name either.
pub fn log_lines(
    title: &str,
    x: &str,
    y: &str,
    mut series: Vec<Series>,
) -> Result<Option<String>, String> {
    series.retain(|series| !series.points.is_empty());
    if series.is_empty() {
        return Ok(None);
    }
    let (left, right) = range(places(&series));
    // A little to the left, so that rounding does not lose the name of the first power.
    let (left, right) = (0.99 * left, right.max(10.0 * left));
    let across = (left..right * (right / left).powf(LONG_NAMES)).log_scale();
    let power = |x: &f64| format!("{x:.0e}");
    let svg = draw([title, x, y], &series, across, Some(&power));
    svg.map(Some).map_err(|error| format!("a plot: {error}"))
}

fn places(series: &[Series]) -> impl Iterator<Item = f64> {
    series.iter().flat_map(|series| series.points.iter().map(|point| point.0))
}

fn draw<X: AsRangedCoord<Value = f64>>(
    [title, x, y]: [&str; 3],
    series: &[Series],
    across: X,
    format_x: Option<&dyn Fn(&f64) -> String>,
) -> Result<String, Box<dyn std::error::Error>>
where
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let heights = series.iter().flat_map(|series| series.points.iter().map(|point| point.1));
    let (low, high) = range(heights);
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&PAPER)?;
        let style = (FONT, TITLE_SIZE).into_font().style(FontStyle::Bold).color(&INK);
        area.draw_text(title, &style, (16, 14))?;
        let (_, area) = area.split_vertically(40);
        let quiet = (FONT, LABEL_SIZE).into_font().color(&QUIET);
        let mut chart = ChartBuilder::on(&area)
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(62)
            .build_cartesian_2d(across, (low.min(1.0)..1.2 * high.max(2.0)).log_scale())?;
        let mut mesh = chart.configure_mesh();
        if let Some(format_x) = format_x {
            mesh.x_label_formatter(format_x);
        }
        mesh.light_line_style(PAPER)
            .bold_line_style(LINE)
            .axis_style(LINE)
            .x_desc(x)
            .y_desc(y)
            .label_style(quiet.clone())
            .axis_desc_style(quiet.clone())
            .draw()?;
        drop(mesh);
        for (Series { name, points }, colour) in series.iter().zip(COLOURS.iter().cycle()) {
            chart
                .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
            chart.draw_series(points.iter().map(|&at| Circle::new(at, 3, colour.filled())))?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(TRANSPARENT)
            .border_style(TRANSPARENT)
            .label_font(quiet)
            .draw()?;
        area.present()?;
    }
    Ok(for_dark_pages(&svg))
}

/// The same picture, dark where the reader prefers that.
pub fn for_dark_pages(svg: &str) -> String {
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
