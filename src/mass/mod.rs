//! Mass, centre and inertia of the source mesh.
//!
//! Hulls overlap, so their masses must not be summed: engines that do so count overlaps twice.
//! What is taken instead is said by [`MassSource`]:
//!
//! 1. A mesh whose components are all closed: what it encloses, exactly, by the divergence
//!    theorem. Cavities are taken off.
//! 2. Where such a mesh overlaps itself, as a handle that is stuck into a mug, the overlap counts
//!    once, by the winding number along columns through the mesh.
//! 3. A mesh whose openings are closed is taken with them closed. Another open mesh has no inside. The union of its hulls is taken, by columns too.
//! 4. Without hulls, its convex hull.

mod moments;
#[cfg(feature = "nalgebra")]
mod principal;

use moments::{Moments, moments_of_union};

#[cfg(feature = "nalgebra")]
pub use principal::PrincipalInertia;

use crate::control::Control;
use crate::decomposition::Hull;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::geometry::vector::{Vector, cubed, squared};
use crate::hull::{HullBuilder, solid_hull};
use crate::mesh::{Normalization, PreparedMesh};
use crate::openings::OpeningSettings;
use crate::openings::prepare::prepare_closed;
use crate::parameters::Parameters;

/// What mass properties were computed from.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum MassSource {
    /// The closed mesh, exactly.
    Mesh,
    /// The closed mesh, each overlap of it counted once; within about 1 %.
    MeshUnion,
    /// The union of the hulls, since the mesh is open; within about 1 % of that union.
    HullUnion,
    /// The convex hull of the mesh, since it is open and there are no hulls.
    ConvexHull,
}

/// How a rigid body resists being pushed and turned, for a uniform density.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MassProperties {
    /// Density times volume; positive.
    pub mass: f64,
    /// Centre of mass, in the input's units.
    pub centre: [f64; 3],
    /// Inertia tensor about the centre along the input's axes, symmetric, in mass times squared
    /// units.
    pub inertia: [[f64; 3]; 3],
    /// What it was computed from.
    pub source: MassSource,
}

/// Columns along each side of the grid that looks for overlaps.
const CHECK_RESOLUTION: usize = 64;

/// Columns along each side where they are the result. Errors of round bodies stay under 0.2 %.
const RESOLUTION: usize = 192;

/// The volume by columns may differ by this share before it counts as an overlap: on thin walls
/// the coarse grid is no better. Mass properties then still agree within about 1 %.
const OVERLAP: f64 = 0.01;

/// A closed mesh with less volume than this, in cubed diagonals, is a folded sheet.
const LEAST_VOLUME: f64 = 1e-9;

/// Mass properties of a mesh with a uniform `density` (mass per cubed unit). `hulls` are its
/// decomposition, used only where the mesh is not closed; they may be empty. [`MassSource`] says
/// what they were computed from: the closed mesh, its overlaps counted once; else the union of the
/// hulls; without hulls, the mesh's convex hull. O(triangles log triangles).
///
/// With the feature `rapier`, `rapier::mass_properties` converts the result to Rapier's type.
///
/// # Errors
/// As [`decompose`](crate::decompose) for a mesh without any usable triangle, and
/// [`Error::InvalidParameter`] for a density that is not positive.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// let properties = hullwright::mass_properties(&mesh, &[], 600.0)?;
/// assert!((properties.mass - 100.0).abs() < 1e-9);
/// assert!((properties.centre[0] - 0.25).abs() < 1e-9);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn mass_properties<'a>(
    mesh: impl Into<MeshView<'a>>,
    hulls: &[Hull],
    density: f64,
) -> Result<MassProperties, Error> {
    mass_properties_with(mesh, hulls, density, &Parameters::default())
}

/// The same with the parameters that the hulls were made with: openings depend on them.
///
/// # Errors
/// As [`mass_properties`].
pub fn mass_properties_with<'a>(
    mesh: impl Into<MeshView<'a>>,
    hulls: &[Hull],
    density: f64,
    parameters: &Parameters,
) -> Result<MassProperties, Error> {
    check_density(density)?;
    // What a body is made of does not depend on what can get into it.
    let settings = OpeningSettings { keep_cavities: true, ..OpeningSettings::from(parameters) };
    let closed = prepare_closed(mesh.into(), &settings, &Control::new())?;
    of_prepared(&closed.prepared, hulls, density)
}

fn of_prepared(
    prepared: &PreparedMesh,
    hulls: &[Hull],
    density: f64,
) -> Result<MassProperties, Error> {
    let PreparedMesh { mesh, normalization, .. } = prepared;
    let Normalization { centre: origin, diagonal } = *normalization;
    let finish =
        |moments: Moments, source| Ok(moments.mass_properties(diagonal, origin, density, source));
    if prepared.closed.iter().all(|closed| *closed) {
        let solid = prepared.triangles_of_solid();
        let corners: Vec<_> = solid.iter().map(|t| t.map(|v| mesh.points()[v as usize])).collect();
        let enclosed = Moments::enclosed(corners.iter().copied());
        if enclosed.volume > LEAST_VOLUME {
            let estimate = moments_of_union(&corners, CHECK_RESOLUTION).volume;
            if (estimate - enclosed.volume).abs() <= OVERLAP * enclosed.volume {
                return finish(enclosed, MassSource::Mesh);
            }
            let union = moments_of_union(&corners, RESOLUTION);
            if (union.volume - enclosed.volume).abs() <= OVERLAP * enclosed.volume {
                return finish(enclosed, MassSource::Mesh);
            }
            if union.volume > LEAST_VOLUME {
                return finish(union, MassSource::MeshUnion);
            }
        }
    }
    let of_hull = |hull: &Hull| {
        let points: Vec<Vector> =
            hull.shape.points().iter().map(|&p| normalization.normalize(p)).collect();
        let corner = |vertex: u32| points.get(vertex as usize).copied();
        let corners = |[a, b, c]: [u32; 3]| Some([corner(a)?, corner(b)?, corner(c)?]);
        hull.shape.triangles.iter().filter_map(|&t| corners(t)).collect::<Vec<_>>()
    };
    let of_hulls =
        moments_of_union(&hulls.iter().flat_map(of_hull).collect::<Vec<_>>(), RESOLUTION);
    if of_hulls.volume > 0.0 {
        return finish(of_hulls, MassSource::HullUnion);
    }
    let (hull, _) = solid_hull(&mut HullBuilder::new(), &mesh.positions, [0.0; 3], 0.0)?;
    finish(Moments::enclosed(hull.faces()), MassSource::ConvexHull)
}

impl Moments {
    /// The mass properties of a solid whose coordinates were divided by `unit` after `origin` was
    /// taken off.
    pub fn mass_properties(
        &self,
        unit: f64,
        origin: Vector,
        density: f64,
        source: MassSource,
    ) -> MassProperties {
        let centre = self.first * (1.0 / self.volume);
        let mut central = self.second;
        for i in 0..3 {
            for j in 0..3 {
                central[i][j] -= self.volume * centre[i] * centre[j];
            }
        }
        let mass = density * cubed(unit);
        MassProperties {
            mass: mass * self.volume,
            centre: (centre * unit + origin).to_array(),
            inertia: inertia_of(central).map(|row| row * (mass * squared(unit))).map(Into::into),
            source,
        }
    }
}

/// The inertia tensor of central second moments, and the other way round up to a factor of 2:
/// trace times identity, minus the matrix.
fn inertia_of(second: [Vector; 3]) -> [Vector; 3] {
    let trace = second[0][0] + second[1][1] + second[2][2];
    let mut inertia = second.map(|row| -row);
    for (i, row) in inertia.iter_mut().enumerate() {
        row[i] += trace;
    }
    inertia
}

/// The central second moments of an inertia tensor.
fn second_of(inertia: [Vector; 3]) -> [Vector; 3] {
    let half_trace = (inertia[0][0] + inertia[1][1] + inertia[2][2]) / 2.0;
    let mut second = inertia.map(|row| -row);
    for (i, row) in second.iter_mut().enumerate() {
        row[i] += half_trace;
    }
    second
}

fn check_density(density: f64) -> Result<(), Error> {
    if density.is_finite() && density > 0.0 {
        return Ok(());
    }
    let reason = format!("must be positive, not {density}");
    Err(Error::InvalidParameter { name: "density", reason })
}

impl MassProperties {
    /// The same body of another mass.
    #[must_use]
    pub fn with_mass(mut self, mass: f64) -> Self {
        let factor = mass / self.mass;
        self.inertia = self.inertia.map(|row| row.map(|x| x * factor));
        self.mass = mass;
        self
    }

    /// The body after its coordinates are multiplied by `scale`, at the same density. A negative
    /// factor mirrors it.
    #[must_use]
    pub fn scaled(mut self, scale: [f64; 3]) -> Self {
        let volume = (scale[0] * scale[1] * scale[2]).abs();
        let mut second = second_of(self.inertia.map(Into::into));
        for i in 0..3 {
            for j in 0..3 {
                second[i][j] *= volume * scale[i] * scale[j];
            }
            self.centre[i] *= scale[i];
        }
        self.mass *= volume;
        self.inertia = inertia_of(second).map(Into::into);
        self
    }

    /// Principal moments of inertia and their axes.
    #[cfg(feature = "nalgebra")]
    pub fn principal_inertia(&self) -> PrincipalInertia {
        principal::principal_inertia(self.inertia.map(Into::into))
    }
}

#[cfg(test)]
mod tests;
