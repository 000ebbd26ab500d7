//! Parameters of the paper's method, by its symbols, and of HACD within its frame.

use std::str::FromStr;

use crate::error::Error;
use crate::parameters::{
    DEFAULT_MAX_VERTICES, Field, Length, NONE, ParseError, check_max_vertices, limit_text, parse,
    parse_limit,
};

/// The unit in which the paper's thresholds fit its own meshes: Princeton's segmentation
/// benchmark has bounding-box diagonals of 1.0 to 3.0 with a median of 2.24.
const PAPER_UNIT: Length = Length::Share(1.0 / 2.24);

/// β of HACD. The paper gives no value; this is that of ε. Over Princeton's meshes it costs about
/// as much as the paper's own method (`crates/lab/reports/paper/paper-experiments.md`).
const DEFAULT_CONCAVITY_THRESHOLD: f64 = 0.05;

/// Parameters of the paper's method, by its symbols.
///
/// | parameter | raise it | lower it |
/// |---|---|---|
/// | R, [`maximum_resolutions`](Self::maximum_resolutions) | finer pieces, more time | less time |
/// | p, [`planar_thresholds`](Self::planar_thresholds) | fewer pieces that are less convex | more pieces |
/// | a, [`angular_threshold`](Self::angular_threshold) | groups grow over sharper dents | more pieces |
/// | ε, [`concavity_cost_threshold`](Self::concavity_cost_threshold) | fewer pieces that are less convex | more pieces |
/// | β, [`concavity_threshold`](Self::concavity_threshold) | of HACD: fewer pieces that are less convex | more pieces |
/// | μ, [`resolution_cut_off`](Self::resolution_cut_off) | less time for simple shapes | higher resolutions are tried |
///
/// The search takes time in proportion to the sum of R times the number of p times the size of
/// groups; simplification O(n log n) in the n triangles of the input. HACD takes up to a hundred
/// times as long as the search for one p.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct SurfaceParameters {
    /// Q: the simplification target is the triangle count times Q, repeated until it is at most r
    /// (section 3.2). The time that takes is in proportion to 1 / (1 - Q). Limits: above 0, at most
    /// 1, which means no simplification. Paper: 0.8.
    pub simplification_quality: f64,
    /// R: maximum resolutions (section 3.5). Unit: triangles. Limits: at least one, none 0. Paper:
    /// 250, 500, 1000, 2000, 3000.
    pub maximum_resolutions: Vec<usize>,
    /// p: planar thresholds (equation 2). Unit: [`unit`](Self::unit). Limits: at least one, none
    /// negative. Paper: 0.01, 0.2, 0.4, 0.6, 0.8, 1.
    pub planar_thresholds: Vec<f64>,
    /// a: angular threshold (section 3.4.1). Unit: [`unit`](Self::unit). Limits: not negative.
    /// Paper: 0.01.
    pub angular_threshold: f64,
    /// ε: the concavity cost under which a decomposition is good enough (section 3.4.2). Unit: a
    /// group's own diagonal. Limits: above 0. Paper: 0.05.
    pub concavity_cost_threshold: f64,
    /// β: the surface is grouped by HACD, a collapse of which must cost less than this (section
    /// 4.2, equation 4), and p, a, ε and their unit are not used. Unit: a surface's own diagonal.
    /// Limits: above 0. Default: `None`, the paper's own grouping; 0.05 in
    /// [`hacd`](Self::hacd), since the paper gives no number.
    pub concavity_threshold: Option<f64>,
    /// μ: once a resolution of at least 500 gives fewer pieces than this, higher ones are
    /// skipped (sections 3.5 and 4.3). Limits: 0 never skips. Paper: 5.
    pub resolution_cut_off: usize,
    /// The length that counts as 1 for p and a. Limits: above 0. Default: 1 / 2.24 of the mesh's
    /// diagonal.
    ///
    /// The paper has none: its thresholds are in the meshes' own units, which is
    /// `Length::Units(1.0)`, and so is its Table 1. The default is the same on the median of the
    /// paper's meshes, and gives the same result for a mesh in any scale.
    pub unit: Length,
    /// A group of one or two polygons is merged only if its bounding-box diagonal is smaller than
    /// this (section 3.6). Unit: the mesh's diagonal. Limits: not negative. Default: 0.1, since the
    /// paper gives no number.
    pub significant_diagonal: f64,
    /// The largest number of vertices of a hull; `None` for no limit. Limits: at least 8. Default:
    /// 64; `None` in [`paper`](Self::paper).
    pub max_vertices: Option<usize>,
}

impl SurfaceParameters {
    /// Exactly the paper: its values, hulls as they are, and the defaults where it names none.
    pub fn paper() -> Self {
        Self {
            simplification_quality: 0.8,
            maximum_resolutions: vec![250, 500, 1000, 2000, 3000],
            planar_thresholds: vec![0.01, 0.2, 0.4, 0.6, 0.8, 1.0],
            angular_threshold: 0.01,
            concavity_cost_threshold: 0.05,
            concavity_threshold: None,
            resolution_cut_off: 5,
            unit: PAPER_UNIT,
            significant_diagonal: 0.1,
            max_vertices: None,
        }
    }

    /// HACD, which the paper compares its method with: its grouping takes the place of section 3.4,
    /// and all else is as in the default.
    pub fn hacd() -> Self {
        Self { concavity_threshold: Some(DEFAULT_CONCAVITY_THRESHOLD), ..Self::default() }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] names the first field that is out of its limits.
    pub fn validate(&self) -> Result<(), Error> {
        let invalid = |name, reason: String| Err(Error::InvalidParameter { name, reason });
        check_max_vertices(self.max_vertices)?;
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
        if let Some(beta) = self.concavity_threshold.filter(|&beta| !finite_and_positive(beta)) {
            return invalid("concavity_threshold", format!("β must be positive, not {beta}"));
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

    pub(crate) const KEYS: &'static str = "max_vertices, simplification_quality, \
        maximum_resolutions, planar_thresholds, angular_threshold, concavity_cost_threshold, \
        concavity_threshold, resolution_cut_off, unit, significant_diagonal";

    /// Every field as text.
    pub(crate) fn fields(&self) -> [Field; 10] {
        [
            ("max_vertices", limit_text(self.max_vertices)),
            ("simplification_quality", self.simplification_quality.to_string()),
            ("maximum_resolutions", list_text(&self.maximum_resolutions)),
            ("planar_thresholds", list_text(&self.planar_thresholds)),
            ("angular_threshold", self.angular_threshold.to_string()),
            ("concavity_cost_threshold", self.concavity_cost_threshold.to_string()),
            (
                "concavity_threshold",
                self.concavity_threshold.map_or_else(|| NONE.into(), |beta| beta.to_string()),
            ),
            ("resolution_cut_off", self.resolution_cut_off.to_string()),
            ("unit", self.unit.to_string()),
            ("significant_diagonal", self.significant_diagonal.to_string()),
        ]
    }

    /// Sets a field from text. Whether there is one of that name.
    pub(crate) fn set(&mut self, key: &str, value: &str) -> Result<bool, ParseError> {
        match key {
            "max_vertices" => self.max_vertices = parse_limit(value)?,
            "simplification_quality" => self.simplification_quality = number(value)?,
            "maximum_resolutions" => self.maximum_resolutions = list(value)?,
            "planar_thresholds" => self.planar_thresholds = list(value)?,
            "angular_threshold" => self.angular_threshold = number(value)?,
            "concavity_cost_threshold" => self.concavity_cost_threshold = number(value)?,
            "concavity_threshold" if value == NONE => self.concavity_threshold = None,
            "concavity_threshold" => self.concavity_threshold = Some(number(value)?),
            "resolution_cut_off" => self.resolution_cut_off = number(value)?,
            "unit" => self.unit = value.parse()?,
            "significant_diagonal" => self.significant_diagonal = number(value)?,
            _ => return Ok(false),
        }
        Ok(true)
    }
}

impl Default for SurfaceParameters {
    /// The paper's values, with at most 64 vertices a hull, the limit of physics engines.
    fn default() -> Self {
        Self { max_vertices: Some(DEFAULT_MAX_VERTICES), ..Self::paper() }
    }
}

fn list_text(values: &[impl ToString]) -> String {
    let texts: Vec<String> = values.iter().map(ToString::to_string).collect();
    texts.join(",")
}

fn number<T: FromStr>(text: &str) -> Result<T, ParseError> {
    parse(text, "a number")
}

fn list<T: FromStr>(text: &str) -> Result<Vec<T>, ParseError> {
    text.split(',').map(number).collect()
}
