//! The solid that hulls are measured against: the mesh's own, and what a probe leaves of the space around it.

use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds};
#[cfg(feature = "fill")]
use crate::probe::{FilledSurface, filled};
use crate::probe::{Probe, ProbeSettings};

pub(super) struct MeasuredSolid {
    pub bvh: Bvh,
    probe: Option<Probe>,
}

impl MeasuredSolid {
    /// O(n log n). `bound` is how far balls may be entered, as a fraction of the diagonal.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::InvalidParameter`] where a probe can't start.
    pub fn new(
        points: &[Vector],
        triangles: &[[u32; 3]],
        probe: Option<ProbeSettings>,
        bound: f64,
        control: &Control,
    ) -> Result<Self, Error> {
        let bvh = Bvh::with_control(points, triangles, control)?;
        let new = |settings: ProbeSettings| {
            settings.check_starts(&bvh, 0.0, |point| bvh.is_inside(point))?;
            let bounds = bounds(points.iter().copied());
            Probe::new(&bvh, bounds, &settings, 0.0, bound, control)
        };
        let probe = probe.map(new).transpose()?;
        Ok(Self { bvh, probe })
    }

    /// How far a point outside protrudes that is so far from the mesh: that, or how far balls are entered there,
    /// whichever is less.
    pub fn protrusion(&self, point: Vector, distance: f64) -> f64 {
        let Some(probe) = &self.probe else { return distance };
        let entered = probe.entered(&self.bvh, point, 0.0, distance);
        entered.map_or(distance, |entered| entered.max(0.0).min(distance))
    }

    /// The surface of what the probe does not reach, if there is one.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    #[cfg(feature = "fill")]
    pub fn filled(&self, control: &Control) -> Result<Option<FilledSurface>, Error> {
        self.probe.as_ref().map(|probe| filled(probe, &self.bvh, control)).transpose()
    }
}
