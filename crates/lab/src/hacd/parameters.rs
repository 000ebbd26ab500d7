//! The parameters of HACD, and their check.

use hullwright::Error;
use hullwright::surface::SurfaceParameters;

/// Parameters of [`decompose`](super::decompose).
#[derive(Debug, Clone, PartialEq)]
pub struct HacdParameters {
    /// β: a collapse must cost less than this; a depth as a share of a surface's own diagonal.
    /// Positive. The paper gives no value.
    pub concavity_threshold: f64,
    /// Q, R, μ, the guard of group merging and the limit on vertices, which are the same as in the paper's own
    /// method. p, a, ε and their unit are not used.
    pub surface: SurfaceParameters,
}

/// ε of the paper's own method, for want of another value.
const DEFAULT_CONCAVITY_THRESHOLD: f64 = 0.05;

impl Default for HacdParameters {
    fn default() -> Self {
        Self {
            concavity_threshold: DEFAULT_CONCAVITY_THRESHOLD,
            surface: SurfaceParameters::paper(),
        }
    }
}

impl HacdParameters {
    /// # Errors
    /// [`Error::InvalidParameter`] names the first field whose value means nothing.
    pub fn validate(&self) -> Result<(), Error> {
        let threshold = self.concavity_threshold;
        if !(threshold.is_finite() && threshold > 0.0) {
            let reason = format!("must be positive, not {threshold}");
            return Err(Error::InvalidParameter { name: "concavity_threshold", reason });
        }
        self.surface.validate()
    }
}
