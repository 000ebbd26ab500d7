//! Verification of hulls that are finished, whoever made them: both errors as upper bounds.

use super::settings::Settings;
use super::uncovered::{HullDistance, uncovered_by_any, uncovered_distance};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::centre;
use crate::hull::ConvexHull;
use crate::mesh::simplification::Simplification;
use crate::mesh::{PreparedMesh, TriangleMesh};
use crate::parallel;
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

    /// Some point of a hull is as far from the solid: the greatest of its corners and the middles
    /// of its faces.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn reached(&self, hulls: &[ConvexHull], control: &Control) -> Result<f64, Error> {
        let found = parallel::map(hulls, |hull| {
            control.check()?;
            let middles = hull.faces().map(centre);
            let places = hull.points().iter().copied().chain(middles);
            Ok(places.fold(0.0_f64, |most, place| {
                self.solid.outside(place, most).map_or(most, |found| most.max(found.lower))
            }))
        });
        found.into_iter().try_fold(0.0, |most: f64, found| Ok(most.max(found?)))
    }

    /// No point of the mesh is farther than this outside every hull. Fast, and up to twice the true
    /// distance where narrow cracks between hulls run across large triangles.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn uncovered<'a>(
        &self,
        hulls: impl Iterator<Item = &'a ConvexHull>,
        control: &Control,
    ) -> Result<f64, Error> {
        let distances: Vec<HullDistance<'_>> = hulls.map(HullDistance::new).collect();
        let surface = &self.exact.mesh;
        let all: Vec<(u32, u32)> =
            (0..surface.triangles.len() as u32).map(|triangle| (triangle, 0)).collect();
        let tolerance = self.settings.bound.tolerance();
        let uncovered = uncovered_distance(surface, &all, &distances, tolerance, control)?;
        Ok(uncovered + self.exact.most_moved())
    }

    /// The same, at most 1 % above the true distance, as a rule.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn uncovered_finely(
        &self,
        hulls: &[ConvexHull],
        control: &Control,
    ) -> Result<f64, Error> {
        let distances: Vec<HullDistance<'_>> = hulls.iter().map(HullDistance::new).collect();
        let tolerance = self.settings.bound.tolerance();
        let uncovered = uncovered_by_any(&self.exact.mesh, &distances, tolerance, control)?;
        Ok(uncovered + self.exact.most_moved())
    }
}
