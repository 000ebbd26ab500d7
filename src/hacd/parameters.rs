//! The knobs of HACD, and its checks.

use crate::error::Error;
use crate::parameters::{SurfaceParameters, Unit};

/// The length ℓ that counts as 1 in α, where the paper gives none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ShapeLength {
    /// The average diagonal of the bounding boxes of the simplified mesh's triangles. α starts at
    /// about β / 10, as in the method's first publication, and falls while surfaces grow.
    TriangleDiagonal,
    /// A length that does not depend on the resolution.
    Fixed(Unit),
}

/// Parameters of [`decompose`](super::decompose).
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct HacdParameters {
    /// β: a collapse must cost less than this; a depth as a share of a surface's own diagonal.
    /// Positive. The paper gives no value.
    pub concavity_threshold: f64,
    /// ℓ in α = β ℓ / (10 D_S).
    pub shape_length: ShapeLength,
    /// Q, R, μ and the guard of group merging, which are the same as in the paper's own method.
    /// p, a, ε and their unit are not used.
    pub surface: SurfaceParameters,
    /// Most vertices that a hull may have, as in
    /// [`Parameters::max_vertices`](crate::Parameters::max_vertices).
    pub max_vertices: Option<usize>,
    /// Whether resolutions run on rayon's current pool. The result does not depend on it.
    pub parallel: bool,
}

/// ε of the paper's own method, for want of another value.
const DEFAULT_CONCAVITY_THRESHOLD: f64 = 0.05;

impl Default for HacdParameters {
    fn default() -> Self {
        Self {
            concavity_threshold: DEFAULT_CONCAVITY_THRESHOLD,
            shape_length: ShapeLength::TriangleDiagonal,
            surface: SurfaceParameters::paper(),
            max_vertices: None,
            parallel: true,
        }
    }
}

impl HacdParameters {
    /// # Errors
    /// [`Error::InvalidParameter`] names the first field whose value means nothing.
    pub fn validate(&self) -> Result<(), Error> {
        let check = |name, value: f64| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            let reason = format!("must be positive, not {value}");
            Err(Error::InvalidParameter { name, reason })
        };
        check("concavity_threshold", self.concavity_threshold)?;
        if let ShapeLength::Fixed(Unit::Diagonals(length) | Unit::Absolute(length)) =
            self.shape_length
        {
            check("shape_length", length)?;
        }
        let mut shared = crate::parameters::Parameters::paper();
        shared.surface = self.surface.clone();
        shared.max_vertices = self.max_vertices;
        shared.validate()
    }
}
