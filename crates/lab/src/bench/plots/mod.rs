//! Plots as SVG, each with a title that says what it shows: text in the reader's own sans-serif, so no fonts are needed to draw them.

mod chart;
mod error;
mod stages;
mod time_triangles;

use chart::{Result, draw};

use super::summary::Results;
use crate::report::html_report::Plot;

/// Width and height of the plots in the report, and of the small ones for other pages.
const LARGE: (u32, u32) = (900, 560);
const SMALL: (u32, u32) = (560, 360);

const MEANS: &str = "Large dots are geometric means over the meshes that all settings shown have \
                     done; lines join those that no other setting of the method beats.";

/// All plots of a benchmark, those that have something to show.
pub fn plots(results: &Results<'_>) -> std::result::Result<Vec<Plot>, String> {
    all(results).map_err(|error| format!("a plot: {error}"))
}

fn all(results: &Results<'_>) -> Result<Vec<Plot>> {
    let plot = |file, title, note: &str, svg| Plot {
        file,
        title,
        note: note.into(),
        svg,
        is_extra: false,
    };
    let (by_time, by_hulls) = (error::error_time_title(results), error::hulls_error_title(results));
    let mut plots = vec![
        plot(
            "error-time.svg",
            "Error against time",
            &format!("Every run (dots). {MEANS}"),
            draw(LARGE, &by_time, |area| error::error_time(area, results, true))?,
        ),
        plot(
            "hulls-error.svg",
            "Hulls against error",
            MEANS,
            draw(LARGE, &by_hulls, |area| error::hulls_error(area, results))?,
        ),
    ];
    let (svg, note) = time_triangles::time_triangles(results, LARGE)?;
    plots.push(plot("time-triangles.svg", "Time against triangles", &note, svg));
    if !stages::stage_seconds(results).is_empty() {
        let note = "Mean seconds of each method's default setting, one thread.";
        let svg = draw(LARGE, &stages::title(results), |area| stages::stages(area, results))?;
        plots.push(plot("stages.svg", "Time by stage", note, svg));
    }
    if let Some(shared) = results.shared_with_files() {
        let note = &format!("On the {} meshes of `coacd-files`. {MEANS}", shared.meshes().len());
        let svg = draw(LARGE, &error::error_time_title(&shared), |area| {
            error::error_time(area, &shared, true)
        })?;
        let title = "Error against time where CoACD ran";
        plots.push(plot("error-time-coacd.svg", title, note, svg));
        let svg = draw(LARGE, &error::hulls_error_title(&shared), |area| {
            error::hulls_error(area, &shared)
        })?;
        let title = "Hulls against error where CoACD ran";
        plots.push(plot("hulls-error-coacd.svg", title, note, svg));
    }
    let small = |file, title, svg| Plot { is_extra: true, ..plot(file, title, MEANS, svg) };
    let svg = draw(SMALL, &by_time, |area| error::error_time(area, results, false))?;
    plots.push(small("error-time-small.svg", "Error against time, small", svg));
    let svg = draw(SMALL, &by_hulls, |area| error::hulls_error(area, results))?;
    plots.push(small("hulls-error-small.svg", "Hulls against error, small", svg));
    Ok(plots)
}
