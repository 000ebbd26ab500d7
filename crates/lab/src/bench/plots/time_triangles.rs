//! Time against triangles.

use std::collections::BTreeMap;

use plotters::prelude::*;

use super::chart::{LEAST, Result, SECONDS, colour, decades, label, legend, log_chart};
use crate::bench::summary::Results;
use crate::runs::methods::Run;
use crate::runs::record::Row;
use crate::statistics::power_law;

/// Scaling: each method's default setting, and the power law fitted to it.
pub(super) fn time_triangles(results: &Results<'_>, size: (u32, u32)) -> Result<(String, String)> {
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
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
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
