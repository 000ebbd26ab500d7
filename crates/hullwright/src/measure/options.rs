//! How closely hulls are looked at, and what counts as solid.

use crate::error::Error;
use crate::openings::OpeningSettings;
use crate::parameters::{Length, Openings, Parameters, UpAxis, check_positive};

/// How closely [`measure()`](super::measure()) looks.
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
    /// Farthest that a vertex of a convex hull may lie in front of a face of it, as a fraction of
    /// the mesh's diagonal. Default 1e-6: what rounding to `f32` does.
    pub convexity_tolerance: f64,
    /// Where it is given, points are independent random ones with this seed. That shows how far
    /// figures of other tools scatter, most of which sample so. Default `None`: evenly spread.
    pub random_seed: Option<u64>,
    /// What becomes of openings. Take what the hulls were made with: everything is judged against
    /// the mesh with those closed that are. Default [`Openings::Auto`].
    pub openings: Openings,
    /// How far an opening's vertices may be from a plane. Take the bound that the hulls were made
    /// with. Default 2 % of the diagonal.
    pub flatness: Length,
    /// Which axis points up: see [`Parameters::up_axis`](crate::Parameters::up_axis).
    pub up_axis: UpAxis,
    /// Whether closed components that nothing can reach stay: see
    /// [`Parameters::keep_cavities`](crate::Parameters::keep_cavities). Default false.
    pub keep_cavities: bool,
    /// What moves in the scene: protrusion is then how far such balls are entered, or the distance
    /// from the solid where that is less. See
    /// [`Parameters::probe_radius`](crate::Parameters::probe_radius). Default `None`.
    pub probe_radius: Option<Length>,
    /// Where it starts beside the outside: see
    /// [`Parameters::probe_from`](crate::Parameters::probe_from). Default none.
    pub probe_from: Vec<[f64; 3]>,
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
            probe_radius: None,
            probe_from: Vec::new(),
        }
    }
}

/// Judges against the mesh as a decomposition with these parameters sees it.
impl From<&Parameters> for MeasureOptions {
    fn from(parameters: &Parameters) -> Self {
        let &Parameters { openings, max_error: flatness, up_axis, keep_cavities, .. } = parameters;
        let (probe_radius, probe_from) = (parameters.probe_radius, parameters.probe_from.clone());
        Self {
            openings,
            flatness,
            up_axis,
            keep_cavities,
            probe_radius,
            probe_from,
            ..Self::default()
        }
    }
}

impl MeasureOptions {
    pub(super) fn of_openings(&self) -> OpeningSettings {
        let &Self { openings, flatness, up_axis, keep_cavities, .. } = self;
        // A probe may start in a cavity.
        let keep_cavities = keep_cavities || !self.probe_from.is_empty();
        OpeningSettings { openings, flatness, up_axis, keep_cavities }
    }

    pub(super) fn validate(&self) -> Result<(), Error> {
        for (name, count) in
            [("hull_samples", self.hull_samples), ("mesh_samples", self.mesh_samples)]
        {
            if count == 0 {
                return Err(Error::parameter(name, "must not be 0"));
            }
        }
        if let Some(radius) = self.probe_radius {
            check_positive("probe_radius", radius.value())?;
        }
        let tolerance = self.convexity_tolerance;
        if tolerance.is_finite() && tolerance >= 0.0 {
            return Ok(());
        }
        Err(Error::parameter("convexity_tolerance", format!("must be at least 0, not {tolerance}")))
    }
}
