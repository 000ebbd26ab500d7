//! Hulls, error and time over the size of a disturbance.

use super::tables::{Rows, error};
use crate::harness::Row;
use crate::plots::{Series, log_lines};
use crate::report::Plot;
use crate::statistics::{geometric_mean, range};
use crate::tools::variations::Variation;

/// Disturbances of the shape, by the size of what changes.
const SHAPE: &[&str] = &["jittered, welded", "jittered", "walls", "slivers"];
/// Disturbances of the place, which leave the shape but for rounding.
const PLACE: &[&str] = &["moved", "moved, single", "scaled"];

const SHAPE_SIZE: &str = "share of the diagonal; of slivers, height over length";
const PLACE_SIZE: &str = "diagonals from the origin; the factor of the size";

/// What is drawn of the runs of one size.
#[derive(Clone, Copy)]
enum Figure {
    Hulls,
    Error,
    Time,
}

/// File and title, the lines, what is drawn, and the name of the x axis.
const PLOTS: [(&str, &str, &[&str], Figure, &str); 6] = [
    ("hulls-shape.svg", "Hulls: the shape disturbed", SHAPE, Figure::Hulls, SHAPE_SIZE),
    ("error-shape.svg", "Error: the shape disturbed", SHAPE, Figure::Error, SHAPE_SIZE),
    ("time-shape.svg", "Time: the shape disturbed", SHAPE, Figure::Time, SHAPE_SIZE),
    ("hulls-place.svg", "Hulls: moved and scaled", PLACE, Figure::Hulls, PLACE_SIZE),
    ("error-place.svg", "Error: moved and scaled", PLACE, Figure::Error, PLACE_SIZE),
    ("time-place.svg", "Time: moved and scaled", PLACE, Figure::Time, PLACE_SIZE),
];

impl Figure {
    fn name(self) -> &'static str {
        match self {
            Self::Hulls => "hulls over those of the mesh as it is, geometric mean",
            Self::Error => "largest error over the bound",
            Self::Time => "time over that of the mesh as it is, geometric mean",
        }
    }

    /// `None` of no runs, and of an error of nothing, which a logarithm can't show.
    fn value(self, all: &Rows<'_>, rows: &[&Row]) -> Option<f64> {
        match self {
            Self::Hulls => geometric_mean(rows.iter().filter_map(|row| all.hulls(row))),
            Self::Time => geometric_mean(rows.iter().filter_map(|row| all.time(row))),
            Self::Error => {
                let most = range(rows.iter().filter_map(|row| error(row))).1;
                (most > 0.0).then_some(most)
            }
        }
    }
}

impl Rows<'_> {
    /// The plots of a method, except those that have no point.
    pub fn plots(&self, method: &str) -> Result<Vec<Plot>, String> {
        let mut plots = Vec::new();
        for (file, title, names, figure, x) in PLOTS {
            let line = |&name: &&str| {
                let sizes = Variation::all().into_iter().filter_map(|variation| {
                    let (_, size) = variation.size().filter(|of| of.0 == name)?;
                    Some((size, figure.value(self, &self.of(method, variation))?))
                });
                Series { name: name.to_owned(), points: sizes.collect() }
            };
            let series = names.iter().map(line).collect();
            if let Some(svg) = log_lines(title, x, figure.name(), series)? {
                let note = format!("{title}: {}.", figure.name());
                plots.push(Plot { file, title, note, svg });
            }
        }
        Ok(plots)
    }
}
