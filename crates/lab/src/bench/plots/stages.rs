//! Time by stage.

use plotters::prelude::*;

use super::chart::{Area, BACKGROUND, GRID, LABEL_SIZE, Result, display_name, legend, quiet};
use crate::bench::summary::Results;

/// For each method its stages in the order of the work, with mean seconds.
pub(super) fn stage_seconds<'a>(results: &Results<'a>) -> Vec<(&'a str, Vec<(String, f64)>)> {
    let mut found = Vec::new();
    for (method, done) in results.defaults() {
        let mut sums: Vec<(String, f64)> = Vec::new();
        for (name, seconds) in done.iter().flat_map(|row| &row.stages) {
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

/// What the plot says: where most of our time goes.
pub(super) fn title(results: &Results<'_>) -> String {
    let all = stage_seconds(results);
    let ours = all.iter().find(|(method, _)| *method == "bounded");
    let longest = ours.and_then(|(_, stages)| stages.iter().max_by(|a, b| a.1.total_cmp(&b.1)));
    let (Some((_, stages)), Some((name, seconds))) = (ours, longest) else {
        return "Time by stage".into();
    };
    let total: f64 = stages.iter().map(|(_, seconds)| seconds).sum();
    format!("Hullwright's longest stage is {name}: {:.0} % of its time", 100.0 * seconds / total)
}

/// Height of a bar; the rest is gap and the name of the method.
const BAR: f64 = 0.6;
/// One per stage: distinct for colour-blind eyes too (Okabe and Ito).
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

/// Bars of one unit of height, one per method, a gap below each.
pub(super) fn stages(area: &Area<'_>, results: &Results<'_>) -> Result<()> {
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
        .light_line_style(BACKGROUND)
        .bold_line_style(GRID)
        .axis_style(GRID)
        .y_labels(0)
        .x_desc("mean seconds")
        .label_style(quiet(LABEL_SIZE))
        .axis_desc_style(quiet(LABEL_SIZE))
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
    let style = quiet(LABEL_SIZE + 1);
    chart.draw_series(bars.iter().rev().enumerate().map(|(row, (method, _))| {
        Text::new(
            display_name(method).to_owned(),
            (longest * 0.005, row as f64 + BAR + 0.3),
            style.clone(),
        )
    }))?;
    legend!(chart, SeriesLabelPosition::UpperRight);
    Ok(())
}
