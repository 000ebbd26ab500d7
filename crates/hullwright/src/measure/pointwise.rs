//! The errors of [`measure`](super::measure()) point by point, for those who choose the points:
//! what draws errors as colours, or compares many sets of hulls with one mesh.

use super::hulls::{MeasuredHull, Union};
use crate::bvh::Bvh;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds};
use crate::geometry::{Bounds, MeshView};
use crate::mesh::Normalization;
use crate::openings::prepare::prepare_closed;
use crate::openings::{ClosedMesh, OpeningSettings};
use crate::parallel;
use crate::parameters::Parameters;
#[cfg(feature = "fill")]
use crate::probe::{FilledSurface, filled};
use crate::probe::{Probe, ProbeSettings};

/// A point nearer to the surface than this fraction of the diagonal is on it: rounding of hulls to
/// `f32`.
const ON_SURFACE: f64 = 1e-6;

/// The solid that hulls are measured against: the mesh's own, and what a probe leaves of the space
/// around it.
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
            settings.check_starts(&bvh, |point| bvh.is_inside(point))?;
            let bounds = bounds(points.iter().copied());
            Probe::new(&bvh, bounds, &settings, bound, control)
        };
        let probe = probe.map(new).transpose()?;
        Ok(Self { bvh, probe })
    }

    /// How far a point outside protrudes that is so far from the mesh: that, or how far balls are
    /// entered there, whichever is less.
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

/// A mesh with its openings closed, and the solid that it encloses. Points and lengths are in the
/// mesh's units.
///
/// ```
/// use hullwright::measure::{MeasuredHulls, MeasuredMesh};
/// use hullwright::{Control, Parameters, TriangleMesh, decompose};
///
/// # fn main() -> Result<(), hullwright::Error> {
/// let mesh = TriangleMesh::new(
///     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// );
/// let (parameters, control) = (Parameters::default(), Control::new());
/// let solid = MeasuredMesh::new(&mesh, &parameters, &control)?;
/// let hulls = MeasuredHulls::new(&decompose(&mesh, &parameters, &control)?.hulls, &solid)?;
/// assert!(solid.contains([0.1; 3]) && hulls.contains([0.1; 3]));
/// let outside = [0.1, 0.1, -0.5];
/// assert!((solid.distance(outside) - 0.5).abs() < 1e-6);
/// assert!((hulls.distance(outside, f64::INFINITY) - 0.5).abs() < 1e-6);
/// # Ok(())
/// # }
/// ```
pub struct MeasuredMesh {
    closed: ClosedMesh,
    normalization: Normalization,
    solid: MeasuredSolid,
}

impl std::fmt::Debug for MeasuredMesh {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("MeasuredMesh").finish_non_exhaustive()
    }
}

impl MeasuredMesh {
    /// Repairs a mesh and closes its openings, as
    /// [`close_openings`](crate::openings::close_openings). O(n log n).
    ///
    /// # Errors
    /// As [`close_openings`](crate::openings::close_openings).
    pub fn new<'a>(
        mesh: impl Into<MeshView<'a>>,
        parameters: &Parameters,
        control: &Control,
    ) -> Result<Self, Error> {
        parameters.validate()?;
        parallel::with(control.is_parallel(), || {
            let settings = OpeningSettings::from(parameters);
            let closed = prepare_closed(mesh.into(), &settings, control)?;
            let prepared = &closed.prepared;
            let normalization = prepared.normalization;
            let Parameters { max_error, probe_radius, probe_from, .. } = parameters;
            let bound = max_error.of_diagonal(normalization.diagonal) / normalization.diagonal;
            let probe = ProbeSettings::new(*probe_radius, probe_from, &normalization);
            let (points, triangles) = (prepared.mesh.points(), prepared.triangles_of_solid());
            let solid = MeasuredSolid::new(points, &triangles, probe, bound, control)?;
            Ok(Self { closed: closed.into(), normalization, solid })
        })
    }

    /// The surface with its caps.
    pub fn closed(&self) -> &ClosedMesh {
        &self.closed
    }

    /// Centre of the bounding box of the vertices that triangles use.
    pub fn centre(&self) -> [f64; 3] {
        self.normalization.centre.to_array()
    }

    /// Diagonal of the same box.
    pub fn diagonal(&self) -> f64 {
        self.normalization.diagonal
    }

    /// Whether a point is in the solid. O(log n).
    pub fn contains(&self, point: [f64; 3]) -> bool {
        self.solid.bvh.is_inside(self.normalization.normalize(point.into()))
    }

    /// How far a point is outside the solid: 0 inside, and within 1e-6 of the diagonal of its
    /// surface. With a [probe](Parameters::probe_radius), that or how far balls are entered there,
    /// whichever is less. O(log n).
    pub fn distance(&self, point: [f64; 3]) -> f64 {
        let point = self.normalization.normalize(point.into());
        let closest = self.solid.bvh.closest_point(point, f64::INFINITY);
        let distance = closest.map_or(0.0, |closest| closest.distance);
        if distance <= ON_SURFACE || self.solid.bvh.is_inside(point) {
            return 0.0;
        }
        self.solid.protrusion(point, distance) * self.normalization.diagonal
    }

    /// The surface of what a ball of the [probe's radius](Parameters::probe_radius) can't touch
    /// outside the solid, where that is off the mesh: what hulls may fill, for display. `None`
    /// without a probe. Where nothing is filled it is empty, and so it is around voids that are
    /// closed on all sides.
    ///
    /// It is approximate: a net over a grid whose cells are a sixth of the radius, or 1.25 % of the
    /// diagonal if that is less; larger where the grid would have more than 200,000 samples.
    /// Nothing nearer than half a cell to the mesh is drawn. What hulls must keep to is not this
    /// surface, but [`distance`](Self::distance).
    ///
    /// O(samples): on one thread tenths of a second, up to two seconds for the largest grid.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    #[cfg(feature = "fill")]
    pub fn filled(&self, control: &Control) -> Result<Option<FilledSurface>, Error> {
        let filled = parallel::with(control.is_parallel(), || self.solid.filled(control))?;
        Ok(filled.map(|mut filled| {
            for position in &mut filled.mesh.positions {
                *position = self.normalization.restore((*position).into()).to_array();
            }
            filled.cell *= self.normalization.diagonal;
            filled
        }))
    }
}

/// Hulls together, each as the convex hull of its points. Points and lengths are in the mesh's
/// units.
pub struct MeasuredHulls {
    union: Union,
    min: Vector,
    max: Vector,
    bvh: Bvh,
    normalization: Normalization,
}

impl std::fmt::Debug for MeasuredHulls {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("MeasuredHulls").finish_non_exhaustive()
    }
}

impl MeasuredHulls {
    /// Prepares hulls of any tool. O(n log n) for n vertices.
    ///
    /// # Errors
    /// [`Error::UnusableHull`] for one that has no triangles, an index out of range, or a
    /// coordinate that is not finite or more than 1e9 diagonals away.
    pub fn new<'h, H>(hulls: &'h [H], mesh: &MeasuredMesh) -> Result<Self, Error>
    where
        &'h H: Into<MeshView<'h>>,
    {
        let normalization = mesh.normalization;
        let reason =
            "it has no triangles, an index out of range, or a coordinate that is not finite";
        let part = |(hull, view): (usize, &'h H)| {
            MeasuredHull::new(&view.into(), &normalization)
                .ok_or(Error::UnusableHull { hull, reason })
        };
        let parts = hulls.iter().enumerate().map(part).collect::<Result<Vec<_>, _>>()?;
        let (min, max) = bounds(parts.iter().flat_map(|part| [part.min, part.max]));
        let union = Union::new(parts);
        let (points, triangles) = union.surface();
        let bvh = Bvh::new(points, triangles);
        Ok(Self { union, min, max, bvh, normalization })
    }

    /// The bounding box of all; inside out without any.
    pub fn bounds(&self) -> Bounds {
        let [min, max] =
            [self.min, self.max].map(|corner| self.normalization.restore(corner).into());
        Bounds { min, max }
    }

    /// Whether a point is in a hull, or within 1e-6 of the diagonal of its surface. O(hulls).
    pub fn contains(&self, point: [f64; 3]) -> bool {
        self.union.multiplicity(self.normalization.normalize(point.into())) > 0
    }

    /// How far a point is outside every hull, or `limit` if that is less. The smaller the limit,
    /// the faster. O(hulls + log n).
    pub fn distance(&self, point: [f64; 3], limit: f64) -> f64 {
        let point = self.normalization.normalize(point.into());
        let most = limit / self.normalization.diagonal;
        if (self.min - point).cmpgt(Vector::splat(most)).any()
            || (point - self.max).cmpgt(Vector::splat(most)).any()
        {
            limit
        } else if self.union.multiplicity(point) > 0 {
            0.0
        } else {
            let closest = self.bvh.closest_point(point, most);
            closest.map_or(limit, |closest| closest.distance * self.normalization.diagonal)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, join};

    #[test]
    fn distances_to_two_boxes_are_in_units_and_end_at_the_limit() {
        let boxes = [cuboid([10.0; 3], [12.0; 3]), cuboid([16.0, 10.0, 10.0], [18.0, 12.0, 12.0])];
        let (parameters, control) = (Parameters::default(), Control::new());
        let mesh = MeasuredMesh::new(&join(&boxes), &parameters, &control).unwrap();
        let hulls = MeasuredHulls::new(&boxes, &mesh).unwrap();
        assert_eq!((mesh.centre(), mesh.diagonal()), ([14.0, 11.0, 11.0], 72_f64.sqrt()));
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found}");
        let between = [13.5, 11.0, 11.0];
        near(mesh.distance(between), 1.5);
        near(hulls.distance(between, f64::INFINITY), 1.5);
        assert_eq!(hulls.distance(between, 1.25), 1.25);
        assert_eq!(hulls.distance([0.0; 3], 1.25), 1.25, "far from the box around all");
        assert!(!mesh.contains(between) && !hulls.contains(between));
        for inside in [[11.0; 3], [17.0, 11.0, 11.0]] {
            assert!(mesh.contains(inside) && hulls.contains(inside));
            assert_eq!((mesh.distance(inside), hulls.distance(inside, 9.0)), (0.0, 0.0));
        }
    }

    #[test]
    fn no_hulls_hold_nothing_and_an_unusable_one_is_named() {
        let cube = cuboid([0.0; 3], [1.0; 3]);
        let mesh = MeasuredMesh::new(&cube, &Parameters::default(), &Control::new()).unwrap();
        let none = MeasuredHulls::new::<crate::TriangleMesh>(&[], &mesh).unwrap();
        assert!(!none.contains([0.5; 3]));
        assert_eq!(none.distance([0.5; 3], 2.0), 2.0);
        let error = MeasuredHulls::new(&[cube, Default::default()], &mesh).err();
        assert!(matches!(error, Some(Error::UnusableHull { hull: 1, .. })), "{error:?}");
    }
}
