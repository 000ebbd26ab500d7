//! Parameters of the paper's method, by its symbols.

use super::Length;
use crate::error::Error;

/// The unit in which the paper's thresholds fit its own meshes: Princeton's segmentation
/// benchmark has bounding-box diagonals of 1.0 to 3.0 with a median of 2.24. At the paper's own p
/// and r this gives its numbers of pieces best (`docs/paper.md`, Calibration).
pub(crate) const PAPER_UNIT: Length = Length::Share(1.0 / 2.24);

/// Parameters of the paper's surface-based method, *A surface-based approach for 3D approximate
/// convex decomposition*, by its symbols.
///
/// The search takes time in proportion to the sum of R times the number of p times the size of
/// groups; simplification O(n log n) in the n triangles of the input.
///
/// ```
/// let mut parameters = hullwright::Parameters::paper();
/// parameters.surface.maximum_resolutions = vec![500];
/// parameters.surface.unit = hullwright::Length::units(1.0);
/// assert!(parameters.validate().is_ok());
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct SurfaceParameters {
    /// Q: the simplification target is the triangle count times Q, repeated until it is at most
    /// r. In (0, 1]; 1 means no simplification. Paper: 0.8 (section 3.2).
    pub simplification_quality: f64,
    /// R: maximum resolutions, in triangles. At least one, none zero.
    /// Paper: 250, 500, 1000, 2000, 3000 (section 3.5).
    pub maximum_resolutions: Vec<usize>,
    /// p: planar thresholds, in [`unit`](Self::unit)s. At least one, none negative.
    /// Paper: 0.01, 0.2, 0.4, 0.6, 0.8, 1 (equation 2).
    pub planar_thresholds: Vec<f64>,
    /// a: angular threshold, in [`unit`](Self::unit)s. Not negative. Paper: 0.01 (section 3.4.2).
    pub angular_threshold: f64,
    /// ε: concavity cost under which a decomposition is good enough, as a share of a group's own
    /// diagonal. Positive. Paper: 0.05 (section 3.4.2).
    pub concavity_cost_threshold: f64,
    /// μ: once a resolution of at least 500 gives fewer pieces than this, higher ones are
    /// skipped. 0 never skips. Paper: 5 (sections 3.5 and 4.3).
    pub resolution_cut_off: usize,
    /// The length that counts as 1 for p and a. Positive. The paper has none: its thresholds are
    /// in the meshes' own units, which is `Length::Units(1.0)`. Default 1 / 2.24 of the mesh's
    /// diagonal, the same on the median of the paper's meshes, and the same result for a mesh
    /// in any scale.
    pub unit: Length,
    /// A group of one or two polygons is merged only if its bounding-box diagonal is smaller
    /// than this share of the mesh's diagonal. Not negative. The paper names the rule but no
    /// number (section 3.6). Default 0.1.
    pub significant_diagonal: f64,
}

impl SurfaceParameters {
    /// The paper's values, and the defaults where it names none.
    ///
    /// ```
    /// let paper = hullwright::SurfaceParameters::paper();
    /// assert_eq!(paper.maximum_resolutions, [250, 500, 1000, 2000, 3000]);
    /// ```
    pub fn paper() -> Self {
        Self {
            simplification_quality: 0.8,
            maximum_resolutions: vec![250, 500, 1000, 2000, 3000],
            planar_thresholds: vec![0.01, 0.2, 0.4, 0.6, 0.8, 1.0],
            angular_threshold: 0.01,
            concavity_cost_threshold: 0.05,
            resolution_cut_off: 5,
            unit: PAPER_UNIT,
            significant_diagonal: 0.1,
        }
    }

    pub(super) fn validate(&self) -> Result<(), Error> {
        let invalid = |name, reason: String| Err(Error::InvalidParameter { name, reason });
        let quality = self.simplification_quality;
        if !(quality > 0.0 && quality <= 1.0) {
            return invalid(
                "simplification_quality",
                format!("Q must be above 0 and at most 1, not {quality}"),
            );
        }
        if self.maximum_resolutions.is_empty() {
            return invalid("maximum_resolutions", "R must not be empty".into());
        }
        if self.maximum_resolutions.contains(&0) {
            return invalid("maximum_resolutions", "no r may be 0".into());
        }
        if self.planar_thresholds.is_empty() {
            return invalid("planar_thresholds", "there must be at least one p".into());
        }
        let finite_and_at_least_zero = |value: f64| value.is_finite() && value >= 0.0;
        let finite_and_positive = |value: f64| value.is_finite() && value > 0.0;
        if let Some(p) = self.planar_thresholds.iter().find(|p| !finite_and_at_least_zero(**p)) {
            return invalid("planar_thresholds", format!("p must be at least 0, not {p}"));
        }
        if !finite_and_at_least_zero(self.angular_threshold) {
            let reason = format!("a must be at least 0, not {}", self.angular_threshold);
            return invalid("angular_threshold", reason);
        }
        if !finite_and_positive(self.concavity_cost_threshold) {
            let reason = format!("ε must be positive, not {}", self.concavity_cost_threshold);
            return invalid("concavity_cost_threshold", reason);
        }
        let unit = self.unit.value();
        if !finite_and_positive(unit) {
            return invalid("unit", format!("must be positive, not {unit}"));
        }
        if !finite_and_at_least_zero(self.significant_diagonal) {
            let reason = format!("must be at least 0, not {}", self.significant_diagonal);
            return invalid("significant_diagonal", reason);
        }
        Ok(())
    }
}

impl Default for SurfaceParameters {
    fn default() -> Self {
        Self::paper()
    }
}
