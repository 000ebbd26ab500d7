//! How closely to look.

use crate::error::Error;
use crate::parameters::{Length, Openings, Parameters, UpAxis};

/// How closely [`measure`](super::measure) looks.
///
/// Start from [`MeasureOptions::default`] and set fields.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
pub struct MeasureOptions {
    /// Points on the surface of all hulls, at least one. Default 50,000.
    pub hull_samples: usize,
    /// Points on the mesh, at least one. Default 50,000.
    pub mesh_samples: usize,
    /// Points in the bounding box of mesh and hulls. Default 200,000.
    pub volume_samples: usize,
    /// Farthest that a vertex of a convex hull may lie in front of a face of it, as a share of the
    /// mesh's diagonal. Default 1e-6: what rounding to `f32` does.
    pub convexity_tolerance: f64,
    /// Where it is given, points are independent random ones with this seed. That shows how far
    /// figures of other tools scatter, which mostly sample so. Default `None`: evenly spread.
    pub random_seed: Option<u64>,
    /// What becomes of openings. Take what the hulls were made with: everything is judged against the mesh
    /// with those closed that are. Default [`Openings::Auto`].
    pub openings: Openings,
    /// How far an opening's vertices may be from a plane. Take the bound that the hulls were made with.
    /// Default 2 % of the diagonal.
    pub flatness: Length,
    /// Which axis points up: see [`Parameters::up_axis`](crate::Parameters::up_axis).
    pub up_axis: UpAxis,
    /// Whether closed components that nothing can reach stay: see
    /// [`Parameters::keep_cavities`](crate::Parameters::keep_cavities). Default false.
    pub keep_cavities: bool,
}

impl Default for MeasureOptions {
    fn default() -> Self {
        Self {
            hull_samples: 50_000,
            mesh_samples: 50_000,
            volume_samples: 200_000,
            convexity_tolerance: 1e-6,
            random_seed: None,
            openings: Openings::Auto,
            flatness: Parameters::default().max_error,
            up_axis: UpAxis::Y,
            keep_cavities: false,
        }
    }
}

impl MeasureOptions {
    pub(super) fn validate(&self) -> Result<(), Error> {
        for (name, count) in
            [("hull_samples", self.hull_samples), ("mesh_samples", self.mesh_samples)]
        {
            if count == 0 {
                return Err(Error::InvalidParameter { name, reason: "must not be 0".into() });
            }
        }
        let tolerance = self.convexity_tolerance;
        if tolerance.is_finite() && tolerance >= 0.0 {
            return Ok(());
        }
        let reason = format!("must be at least 0, not {tolerance}");
        Err(Error::InvalidParameter { name: "convexity_tolerance", reason })
    }
}
