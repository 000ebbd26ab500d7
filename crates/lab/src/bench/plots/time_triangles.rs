//! Time against triangles.

use plotters::prelude::*;

use super::chart::{
    Area, BACKGROUND, GRID, LABEL_SIZE, LEAST, Result, SECONDS, colour, decades, display_name,
    draw, label, legend, log_chart, quiet,
};
use crate::bench::summary::Results;
use crate::harness::Row;
use crate::statistics::power_law;

/// Scaling: each method's default setting, and the power law fitted to it.
pub(super) fn time_triangles(results: &Results<'_>, size: (u32, u32)) -> Result<(String, String)> {
    let mut clouds: Vec<(&str, Vec<(f64, f64)>)> = Vec::new();
    for (method, rows) in results.defaults() {
        let point = |row: &&Row| Some((row.triangles? as f64, row.seconds?.max(LEAST)));
        clouds.push((method, rows.iter().filter_map(point).collect()));
    }
    let laws: Vec<Option<(f64, f64)>> = clouds.iter().map(|(_, cloud)| power_law(cloud)).collect();
    let named = || clouds.iter().zip(&laws).filter_map(|((name, _), law)| Some((*name, (*law)?)));
    let title = match named().find(|(name, _)| *name == "bounded") {
        Some((_, (slope, _))) => {
            let times = 10_f64.powf(slope);
            format!("Ten times the triangles take Hullwright {times:.1} times as long")
        }
        None => "Time against triangles".into(),
    };
    let svg = draw(size, &title, |area| paint(area, &clouds, &laws))?;
    let slopes: Vec<String> =
        named().map(|(name, (slope, _))| format!("{name}: slope {slope:.2}")).collect();
    let note = format!(
        "Each method's default setting; lines are least squares in logarithms ({}).",
        slopes.join(", ")
    );
    Ok((svg, note))
}

/// Dots of each method, and the line of its power law.
fn paint(
    area: &Area<'_>,
    clouds: &[(&str, Vec<(f64, f64)>)],
    laws: &[Option<(f64, f64)>],
) -> Result<()> {
    let all = || clouds.iter().flat_map(|(_, cloud)| cloud);
    let (x, y) = (decades(all().map(|p| p.0)), decades(all().map(|p| p.1)));
    let mut chart = log_chart!(area, x.clone(), y, "triangles", SECONDS);
    for ((method, cloud), law) in clouds.iter().zip(laws) {
        let colour = colour(method);
        let dots = cloud.iter().map(|&p| Circle::new(p, 3, colour.mix(0.5).filled()));
        let name = match law {
            Some((slope, _)) => format!("{}: slope {slope:.2}", display_name(method)),
            None => display_name(method).to_owned(),
        };
        chart
            .draw_series(dots)?
            .label(name)
            .legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
        if let Some((slope, value)) = law {
            let ends = [x.start, x.end].map(|x| (x, value * x.powf(*slope)));
            chart.draw_series(LineSeries::new(ends, colour.stroke_width(1)))?;
        }
    }
    legend!(chart, SeriesLabelPosition::UpperLeft);
    Ok(())
}
