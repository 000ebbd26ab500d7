//! Verification of hulls that are finished, whoever made them: both errors as upper bounds.

use super::settings::Settings;
use super::uncovered::{HullDistance, uncovered_by_any};
use crate::control::Control;
use crate::error::Error;
use crate::hull::ConvexHull;
use crate::mesh::simplification::Simplification;
use crate::mesh::{PreparedMesh, TriangleMesh};
use crate::parameters::Parameters;
use crate::solid::{Solid, protrusion};

/// A mesh that hulls are verified against. Lengths are fractions of the diagonal, as the hulls are.
pub(crate) struct Verifier {
    pub settings: Settings,
    pub solid: Solid,
    exact: Simplification,
}

impl Verifier {
    /// The bound of the parameters says how finely errors are resolved. The solid is built anew:
    /// a decomposition does not keep it.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; [`Error::InvalidParameter`] where a probe can't start.
    pub(crate) fn new(
        prepared: &PreparedMesh,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        let settings = Settings::after_search(parameters, &prepared.normalization);
        let exact = Simplification::exact(prepared, settings.bound.exact(), control)?;
        let solid = Solid::new(&exact, &settings.solid(), control)?;
        Ok(Self { settings, solid, exact })
    }

    /// The mesh, with its coplanar triangles merged.
    pub(crate) fn surface(&self) -> &TriangleMesh {
        &self.exact.mesh
    }

    /// No point of the hull's surface is farther than this from the solid.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn protrusion(&self, hull: &ConvexHull, control: &Control) -> Result<f64, Error> {
        protrusion(hull, &self.solid, self.settings.bound.verified(), f64::INFINITY, control)
    }

    /// No point of the mesh is farther than this outside every hull.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn uncovered<'a>(
        &self,
        hulls: impl Iterator<Item = &'a ConvexHull>,
        control: &Control,
    ) -> Result<f64, Error> {
        let distances: Vec<HullDistance<'_>> = hulls.map(HullDistance::new).collect();
        let tolerance = self.settings.bound.tolerance();
        let uncovered = uncovered_by_any(&self.exact.mesh, &distances, tolerance, control)?;
        Ok(uncovered + self.exact.most_moved())
    }
}
