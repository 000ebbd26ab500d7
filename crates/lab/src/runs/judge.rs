//! Judges hulls against their mesh: the one place that names the figures of `hullwright::measure`
//! and what the bounded method reports.

use hullwright::measure::{MeasureOptions, Measurement, measure};
use hullwright::{Control, Decomposition, Error, MeshView};
use serde::{Deserialize, Serialize};

/// What `measure` says. Lengths are shares of the mesh's diagonal.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    pub hulls: usize,
    pub vertices: usize,
    pub unusable_hulls: usize,
    pub non_convex_hulls: usize,
    pub non_positive_volumes: usize,
    pub worst_concavity: f64,
    /// How far the hulls reach outside of the solid.
    pub protrusion_mean: f64,
    pub protrusion_p99: f64,
    pub protrusion_max: f64,
    /// How far the surface reaches outside of the hulls.
    pub uncovered_mean: f64,
    pub uncovered_p99: f64,
    pub uncovered_max: f64,
    pub hausdorff: f64,
    /// Share of the solid in no hull.
    pub uncovered_volume: Option<f64>,
    pub iou: Option<f64>,
    pub overlap: Option<f64>,
    pub samples: Samples,
}

/// How many points were asked.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Samples {
    pub hulls: usize,
    /// Those of the hulls that lie on the boundary of all.
    pub boundary: usize,
    pub mesh: usize,
    pub space: usize,
    /// Those in space that lie in the solid or in a hull.
    pub union: usize,
}

impl From<&Measurement> for Judged {
    fn from(found: &Measurement) -> Self {
        let samples = &found.samples;
        Self {
            hulls: found.hulls,
            vertices: found.vertices,
            unusable_hulls: found.unusable_hulls,
            non_convex_hulls: found.non_convex_hulls,
            non_positive_volumes: found.non_positive_volumes,
            worst_concavity: found.worst_concavity,
            protrusion_mean: found.protrusion.mean,
            protrusion_p99: found.protrusion.p99,
            protrusion_max: found.protrusion.max,
            uncovered_mean: found.uncovered.mean,
            uncovered_p99: found.uncovered.p99,
            uncovered_max: found.uncovered.max,
            hausdorff: found.hausdorff,
            uncovered_volume: found.uncovered_volume,
            iou: found.iou,
            overlap: found.overlap,
            samples: Samples {
                hulls: samples.hull,
                boundary: samples.boundary,
                mesh: samples.mesh,
                space: samples.volume,
                union: samples.union,
            },
        }
    }
}

/// Judges hulls of any kind.
pub fn judge<'a, H>(
    mesh: MeshView<'_>,
    hulls: &'a [H],
    options: &MeasureOptions,
) -> Result<Judged, Error>
where
    &'a H: Into<MeshView<'a>>,
{
    Ok(Judged::from(&measure(mesh, hulls, options, &Control::new())?))
}

/// What the bounded method was asked for and has verified, in shares of the mesh's diagonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verified {
    pub bound: f64,
    pub protrusion_max: f64,
    pub uncovered_max: f64,
}

impl Verified {
    pub fn of(Decomposition { run, report, .. }: &Decomposition) -> Self {
        let relative = |length: f64| length / run.diagonal;
        Self {
            bound: relative(report.bound),
            protrusion_max: relative(report.protrusion_max),
            uncovered_max: relative(report.uncovered_max),
        }
    }

    /// Whether more was verified than asked for, or more is sampled than was verified, up to a
    /// tolerance.
    pub fn is_broken(&self, judged: &Judged, tolerance: f64) -> bool {
        let Self { bound, protrusion_max, uncovered_max } = *self;
        [
            (protrusion_max, bound),
            (uncovered_max, bound),
            (judged.protrusion_max, protrusion_max),
            (judged.uncovered_max, uncovered_max),
        ]
        .into_iter()
        .any(|(found, most)| found > most + tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_promise_is_broken_by_what_is_verified_and_by_what_is_sampled() {
        let kept = Verified { bound: 0.02, protrusion_max: 0.019, uncovered_max: 0.001 };
        let judged = Judged { protrusion_max: 0.018, uncovered_max: 0.001, ..Judged::default() };
        assert!(!kept.is_broken(&judged, 1e-6));
        assert!(Verified { protrusion_max: 0.021, ..kept }.is_broken(&judged, 1e-6));
        assert!(Verified { uncovered_max: 0.021, ..kept }.is_broken(&judged, 1e-6));
        assert!(kept.is_broken(&Judged { protrusion_max: 0.0191, ..judged.clone() }, 1e-6));
        assert!(kept.is_broken(&Judged { uncovered_max: 0.0011, ..judged.clone() }, 1e-6));
        assert!(!kept.is_broken(&Judged { uncovered_max: 0.0011, ..judged }, 1e-3));
    }
}
