//! Every knob, with the paper's symbol and default, and its checks.

use crate::error::Error;

/// Which method decomposes the mesh.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "bevy", derive(bevy::reflect::Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Method {
    /// Hullwright's own: the paper's groups, merged, grown and dissolved into few hulls under a
    /// bound on the error that is verified against the source.
    #[default]
    Bounded,
    /// The paper's surface-based method: groups of the simplified surface, chosen by concavity
    /// cost over all thresholds and resolutions.
    Surface,
}

impl Method {
    /// The method's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bounded => "bounded",
            Self::Surface => "surface",
        }
    }
}

/// A length: relative to the mesh, or in its own units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy::reflect::Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Unit {
    /// This many bounding-box diagonals.
    Diagonals(f64),
    /// This many of the input's units.
    Absolute(f64),
}

/// The unit in which the paper's thresholds fit its own meshes: Princeton's segmentation
/// benchmark has bounding-box diagonals of 1.0 to 3.0 with a median of 2.24. At the paper's own p
/// and r this gives its numbers of pieces best (`docs/paper.md`, Calibration).
pub(crate) const PAPER_UNIT: Unit = Unit::Diagonals(1.0 / 2.24);

/// Parameters of the paper's surface-based method, *A surface-based approach for 3D approximate
/// convex decomposition*, by its symbols.
///
/// The search takes time in proportion to the sum of R times the number of p times the size of
/// groups; simplification O(n log n) in the n triangles of the input.
///
/// ```
/// let mut parameters = hullwright::Parameters::paper();
/// parameters.surface.maximum_resolutions = vec![500];
/// parameters.surface.unit = hullwright::Unit::Absolute(1.0);
/// assert!(parameters.validate().is_ok());
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy::reflect::Reflect))]
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
    /// in the meshes' own units, which is `Unit::Absolute(1.0)`. Default 1 / 2.24 of the mesh's
    /// diagonal, the same on the median of the paper's meshes, and the same result for a mesh
    /// in any scale.
    pub unit: Unit,
    /// A group of one or two polygons is merged only if its bounding-box diagonal is smaller
    /// than this share of the mesh's diagonal. Not negative. The paper names the rule but no
    /// number (section 3.6). Default 0.1.
    pub significant_diagonal: f64,
}

impl SurfaceParameters {
    /// The paper's values, and the defaults where it names none.
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

    fn validate(&self) -> Result<(), Error> {
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
        let (Unit::Diagonals(unit) | Unit::Absolute(unit)) = self.unit;
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

/// How much work the bounded method puts into few hulls. All keep the bound.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "bevy", derive(bevy::reflect::Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Preset {
    /// Coarser seeds and no dissolving: about a fifth more hulls in two thirds of the time. More of a solid
    /// may stay empty inside.
    Fast,
    /// Few hulls, in a tenth of a second for most meshes.
    #[default]
    Balanced,
    /// Three divisions of the surface are tried, and the one with the fewest hulls is taken: some
    /// hulls fewer, in about three times the time.
    Fine,
}

impl Preset {
    /// The preset's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "fast",
            Self::Balanced => "balanced",
            Self::Fine => "fine",
        }
    }
}

/// Parameters of the bounded method.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy::reflect::Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct BoundedParameters {
    /// The bound: no point on the boundary of the hulls' union is farther than this outside the
    /// solid, and no point of the surface farther than this outside every hull. The solid is
    /// where the generalized winding number is above one half, and the surface itself. Triangles without
    /// area are no surface. Positive; less than 0.001 % of the diagonal counts as that, more than half as
    /// half. Below 0.1 % it may take seconds. Default 2 % of the diagonal.
    pub max_error: Unit,
    /// How much work is put into few hulls.
    pub preset: Preset,
    /// Most hulls, at least 1; `None` for no cap. A cap, not a budget: where it forces hulls to
    /// join beyond the bound, those that stand out least do, and
    /// [`BoundedReport::phantom_max`](crate::BoundedReport::phantom_max) says how far.
    pub max_hulls: Option<usize>,
    /// Whether cavities stay empty that can only be reached through mouths narrower than the
    /// bound, or not at all. Otherwise a hull may swallow them, since nothing from outside can
    /// tell. Those nowhere deeper than the bound always may fill. Default false.
    pub keep_cavities: bool,
}

/// What things may stand apart or sink in before a player sees it.
const DEFAULT_MAX_ERROR: Unit = Unit::Diagonals(0.02);

impl BoundedParameters {
    fn validate(&self) -> Result<(), Error> {
        if self.max_hulls == Some(0) {
            let reason = "must be at least 1".into();
            return Err(Error::InvalidParameter { name: "max_hulls", reason });
        }
        let (Unit::Diagonals(error) | Unit::Absolute(error)) = self.max_error;
        if error.is_finite() && error > 0.0 {
            return Ok(());
        }
        let reason = format!("must be positive, not {error}");
        Err(Error::InvalidParameter { name: "max_error", reason })
    }
}

impl Default for BoundedParameters {
    fn default() -> Self {
        Self {
            max_error: DEFAULT_MAX_ERROR,
            preset: Preset::Balanced,
            max_hulls: None,
            keep_cavities: false,
        }
    }
}

/// What [`decompose`](crate::decompose) is asked to do.
///
/// Start from [`Parameters::default`] or [`Parameters::paper`] and set fields:
///
/// ```
/// let mut parameters = hullwright::Parameters::default();
/// parameters.max_vertices = Some(32);
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy::reflect::Reflect))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct Parameters {
    /// The method.
    pub method: Method,
    /// Parameters of [`Method::Bounded`].
    pub bounded: BoundedParameters,
    /// Parameters of [`Method::Surface`].
    pub surface: SurfaceParameters,
    /// Most vertices that a hull may have, at least 8; `None` for no cap. A hull over the cap is
    /// replaced by one that contains it and little more or, where the bounded method's bound
    /// forbids that, by one that leaves out what stands out least, or by several;
    /// [`Hull::cap_growth`](crate::Hull::cap_growth) says by how much it grew. Default 64; `None`
    /// in [`Parameters::paper`].
    pub max_vertices: Option<usize>,
    /// Whether independent parts of the work run on rayon's current pool (feature `parallel`).
    /// The result does not depend on it. Default true.
    pub parallel: bool,
}

/// A physics engine's cost grows with the vertices of a hull, and 64 still follow a round shape.
const DEFAULT_MAX_VERTICES: usize = 64;

/// With fewer vertices not even a box would do.
const LEAST_MAX_VERTICES: usize = 8;

impl Parameters {
    /// Exactly the paper: its method, its values, hulls as they are.
    pub fn paper() -> Self {
        Self {
            method: Method::Surface,
            bounded: BoundedParameters::default(),
            surface: SurfaceParameters::paper(),
            max_vertices: None,
            parallel: true,
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] names the first field whose value means nothing.
    pub fn validate(&self) -> Result<(), Error> {
        if let Some(cap) = self.max_vertices
            && cap < LEAST_MAX_VERTICES
        {
            return Err(Error::InvalidParameter {
                name: "max_vertices",
                reason: format!("must be at least {LEAST_MAX_VERTICES}, not {cap}"),
            });
        }
        self.bounded.validate()?;
        self.surface.validate()
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self { method: Method::Bounded, max_vertices: Some(DEFAULT_MAX_VERTICES), ..Self::paper() }
    }
}
