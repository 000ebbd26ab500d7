//! Error against time, and hulls against error: one line per method through its settings.

use std::collections::BTreeMap;

use plotters::prelude::*;

use super::chart::{
    Area, BACKGROUND, GRID, LABEL_SIZE, LEAST, Result, SECONDS, colour, decades, display_name,
    label, legend, log_chart, quiet, room,
};
use crate::bench::curves::versus;
use crate::bench::summary::Results;
use crate::harness::Row;
use crate::statistics::{geometric_mean, median};

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
        let (Some(seconds), Some(error), Some(hulls)) = (
            of(|row| row.seconds),
            of(|row| row.hausdorff),
            of(|row| row.hulls.map(|hulls| hulls as f64)),
        ) else {
            continue;
        };
        let mean = Mean { seconds, error, hulls };
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

/// The settings that no other of the method beats, by x: those are joined by a line.
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

/// A line of each method through its settings' means, and a dot for each.
macro_rules! lines {
    ($chart:expr, $means:expr, $point:expr) => {
        for (method, list) in $means {
            let points: Vec<(f64, f64)> = list.iter().map($point).collect();
            let colour = colour(method);
            $chart
                .draw_series(LineSeries::new(front(points.clone()), colour.stroke_width(2)))?
                .label(display_name(method))
                .legend(move |(x, y)| Circle::new((x + 8, y), 4, colour.filled()));
            $chart.draw_series(points.iter().map(|&at| Circle::new(at, 4, colour.filled())))?;
        }
    };
}

/// What the axes of errors say.
const ERROR: &str = "error: Hausdorff distance / diagonal";

/// What the plot says: how the medians of our default and of the nearest rival's compare.
pub(super) fn error_time_title(results: &Results<'_>) -> String {
    let defaults = results.defaults();
    let default = |name: &str| {
        let (_, rows) = defaults.iter().find(|(method, _)| *method == name)?;
        let of = |figure: fn(&&&Row) -> Option<f64>| {
            median(rows.iter().filter_map(|row| figure(&row)).collect())
        };
        Some((of(|row| row.hausdorff), of(|row| row.seconds)))
    };
    let rival = RIVALS.iter().find_map(|&(rival, name)| Some((name, default(rival)?)));
    let (Some(ours), Some((name, theirs))) = (default("bounded"), rival) else {
        return "Error against time".into();
    };
    format!(
        "By default {:.2} times the error of {name}, in {:.2} times its time (medians)",
        ours.0 / theirs.0.max(LEAST),
        ours.1 / theirs.1.max(LEAST)
    )
}

/// Who ours is compared with first.
const RIVALS: [(&str, &str); 4] =
    [("vhacd", "V-HACD"), ("vhacd4", "V-HACD 4"), ("coacd", "CoACD"), ("coacd-files", "CoACD")];

/// What the plot says: hulls over those of others at equal error.
pub(super) fn hulls_error_title(results: &Results<'_>) -> String {
    let curves = results.curves();
    let ratio = |rival: &str| {
        let (own, theirs) = (curves.get("bounded")?, curves.get(rival)?);
        let ratios =
            theirs.iter().filter_map(|(mesh, theirs)| versus(own.get(mesh)?, theirs).hulls);
        geometric_mean(ratios)
    };
    let ratios: Vec<String> = RIVALS
        .iter()
        .filter_map(|&(rival, name)| Some(format!("{:.2} × {name}", ratio(rival)?)))
        .collect();
    if ratios.is_empty() {
        return "Hulls against error".into();
    }
    format!("Hulls that Hullwright needs at equal error: {}", ratios.join(", "))
}

/// With or without a dot for every run.
pub(super) fn error_time(area: &Area<'_>, results: &Results<'_>, with_runs: bool) -> Result<()> {
    let runs: Vec<(&str, f64, f64)> = results
        .rows
        .iter()
        .filter(|row| row.is_done())
        .filter_map(|row| {
            let (seconds, error) = row.seconds.zip(row.hausdorff)?;
            Some((row.method.as_str(), seconds.max(LEAST), error.max(LEAST)))
        })
        .collect();
    let means = means(results);
    let all = means.iter().flat_map(|(_, list)| list);
    let (x, y) = if with_runs {
        (decades(runs.iter().map(|run| run.1)), decades(runs.iter().map(|run| run.2)))
    } else {
        (decades(all.clone().map(|m| m.seconds)), room(all.map(|m| m.error)))
    };
    let mut chart = log_chart!(area, x, y, SECONDS, ERROR);
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
                    .label(display_name(method))
                    .legend(move |(x, y)| Circle::new((x + 8, y), 2, colour.filled()));
            }
        }
    }
    lines!(chart, &means, |mean: &Mean| (mean.seconds, mean.error));
    legend!(chart, SeriesLabelPosition::LowerLeft);
    Ok(())
}

pub(super) fn hulls_error(area: &Area<'_>, results: &Results<'_>) -> Result<()> {
    let means = means(results);
    let all = means.iter().flat_map(|(_, list)| list);
    let (x, y) = (room(all.clone().map(|m| m.error)), room(all.map(|m| m.hulls)));
    let mut chart = log_chart!(area, x, y, ERROR, "hulls");
    lines!(chart, &means, |mean: &Mean| (mean.error, mean.hulls));
    legend!(chart, SeriesLabelPosition::LowerLeft);
    Ok(())
}
