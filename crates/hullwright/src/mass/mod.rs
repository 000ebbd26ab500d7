//! Mass, centre and inertia of the source mesh.
//!
//! Hulls overlap, so their masses must not be summed: engines that do so count overlaps twice.
//! What is taken instead is said by [`MassSource`]:
//!
//! 1. A mesh whose components are all closed: what it encloses, exactly, by the divergence
//!    theorem. Cavities are taken off.
//! 2. Where such a mesh overlaps itself, as a handle that is stuck into a mug, the overlap counts
//!    once, by the winding number along columns through the mesh.
//! 3. A mesh whose openings are closed is taken with them closed. Another open mesh has no inside:
//!    the union of its hulls is taken, by columns too.
//! 4. Without hulls, its convex hull.

mod moments;

use moments::{Moments, moments_of_union};
#[cfg(feature = "nalgebra")]
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};

use crate::control::Control;
use crate::decomposition::Hull;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::geometry::vector::{Vector, cubed, squared};
use crate::hull::{HullBuilder, solid_hull};
use crate::mesh::{Normalization, PreparedMesh};
use crate::openings::OpeningSettings;
use crate::openings::prepare::prepare_closed;
use crate::parameters::{Parameters, check_positive};
#[cfg(feature = "nalgebra")]
use crate::sorting::sort_by;

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

impl MassSource {
    /// All of them.
    pub const ALL: &'static [Self] =
        &[Self::Mesh, Self::MeshUnion, Self::HullUnion, Self::ConvexHull];

    /// Its name in files of text.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::MeshUnion => "mesh_union",
            Self::HullUnion => "hull_union",
            Self::ConvexHull => "convex_hull",
        }
    }
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

/// A closed mesh with less volume than this, as a fraction of the cubed diagonal, is a folded
/// sheet.
const LEAST_VOLUME: f64 = 1e-9;

/// Mass properties of a mesh with a uniform `density` (mass per cubed unit). `hulls` are its
/// decomposition, used only where the mesh is not closed; they may be empty. [`MassSource`] says
/// what they were computed from: the closed mesh, its overlaps counted once; else the union of the
/// hulls; without hulls, the mesh's convex hull. O(triangles log triangles).
///
/// `hullwright_rapier::mass_properties` converts the result to Rapier's type.
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
    check_positive("density", density)?;
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
        let corners: Vec<_> = solid.iter().map(|&triangle| mesh.corners(triangle)).collect();
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
            inertia: trace_less(central, 1.0)
                .map(|row| row * (mass * squared(unit)))
                .map(Into::into),
            source,
        }
    }
}

/// The inertia tensor of central second moments, their trace times the identity minus the moments;
/// and with half the trace the moments of a tensor.
fn trace_less(matrix: [Vector; 3], share: f64) -> [Vector; 3] {
    let trace = (matrix[0][0] + matrix[1][1] + matrix[2][2]) * share;
    let mut result = matrix.map(|row| -row);
    for (i, row) in result.iter_mut().enumerate() {
        row[i] += trace;
    }
    result
}

impl MassProperties {
    /// Mass, centre, and inertia about the centre, as they are.
    pub const fn new(
        mass: f64,
        centre: [f64; 3],
        inertia: [[f64; 3]; 3],
        source: MassSource,
    ) -> Self {
        Self { mass, centre, inertia, source }
    }

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
        let mut second = trace_less(self.inertia.map(Into::into), 0.5);
        for i in 0..3 {
            for j in 0..3 {
                second[i][j] *= volume * scale[i] * scale[j];
            }
            self.centre[i] *= scale[i];
        }
        self.mass *= volume;
        self.inertia = trace_less(second, 1.0).map(Into::into);
        self
    }

    /// Principal moments of inertia and their axes.
    #[cfg(feature = "nalgebra")]
    pub fn principal_inertia(&self) -> PrincipalInertia {
        principal_inertia(self.inertia.map(Into::into))
    }
}

/// Principal moments of inertia, and the frame of their axes.
#[cfg(feature = "nalgebra")]
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PrincipalInertia {
    /// Moments about the principal axes, ascending; none negative.
    pub moments: [f64; 3],
    /// The axes, unit vectors that form a right-handed frame in this order.
    pub axes: [[f64; 3]; 3],
    /// The rotation that takes the coordinate axes to `axes`, as a quaternion (x, y, z, w).
    pub rotation: [f64; 4],
}

/// Far more steps than three rows ever took; an unbounded loop could hang on what is not finite.
#[cfg(feature = "nalgebra")]
const MOST_STEPS: usize = 1000;

/// By nalgebra's symmetric eigendecomposition, in double precision.
#[cfg(feature = "nalgebra")]
fn principal_inertia(inertia: [Vector; 3]) -> PrincipalInertia {
    let matrix = Matrix3::from_fn(|i, j| (inertia[i][j] + inertia[j][i]) / 2.0);
    let size = matrix.amax();
    // A diagonal tensor needs no turning: noise would turn it.
    let eigen = (size.is_finite() && size > 0.0)
        .then(|| SymmetricEigen::try_new(matrix / size, f64::EPSILON, MOST_STEPS))
        .flatten();
    let (values, vectors) = match eigen {
        Some(eigen) => (eigen.eigenvalues * size, eigen.eigenvectors),
        None => (matrix.diagonal(), Matrix3::identity()),
    };
    let mut order = [0, 1, 2];
    sort_by(&mut order, |&a, &b| values[a].total_cmp(&values[b]));
    let mut columns = order.map(|index| vectors.column(index).into_owned());
    for column in &mut columns[..2] {
        // Of the two directions of an axis, the one along the coordinate axis that is nearest.
        if column[column.iamax()] < 0.0 {
            *column = -*column;
        }
    }
    columns[2] = columns[0].cross(&columns[1]);
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns));
    let quaternion = UnitQuaternion::from_rotation_matrix(&rotation);
    PrincipalInertia {
        moments: order.map(|index| values[index].max(0.0)),
        axes: columns.map(Into::into),
        rotation: quaternion.coords.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decompose::decompose;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, hemisphere, join, turn};
    use crate::parameters::{Openings, Parameters};

    /// A density that is not 1, so that a forgotten one shows.
    const DENSITY: f64 = 3.0;

    fn of(mesh: &TriangleMesh) -> MassProperties {
        mass_properties(mesh, &[], DENSITY).unwrap()
    }

    fn assert_close(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() <= tolerance, "{found}, not {expected}");
    }

    /// Mass and inertia within `share`, everything off the diagonal next to 0.
    fn assert_properties(found: &MassProperties, volume: f64, inertia: Vector, share: f64) {
        assert_close(found.mass, DENSITY * volume, share * DENSITY * volume);
        for (i, row) in found.inertia.into_iter().enumerate() {
            let size = DENSITY * inertia[i];
            for (j, found) in row.into_iter().enumerate() {
                assert_close(found, if i == j { size } else { 0.0 }, share * size);
            }
        }
    }

    fn box_inertia(Vector { x, y, z }: Vector) -> Vector {
        let mass = x * y * z;
        Vector::from_array(
            [y * y + z * z, x * x + z * z, x * x + y * y].map(|sum| mass * sum / 12.0),
        )
    }

    #[test]
    fn a_cavity_is_taken_off() {
        let hollow = join(&[cuboid([-2.0; 3], [2.0; 3]), turn(cuboid([-1.5; 3], [1.5; 3]))]);
        let found = of(&hollow);
        assert_eq!(found.source, MassSource::Mesh);
        let [outer, inner] = [4.0, 3.0].map(|side| box_inertia(Vector::splat(side))[0]);
        assert_properties(&found, 64.0 - 27.0, Vector::splat(outer - inner), 1e-9);
    }

    #[test]
    fn winding_does_not_matter() {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
        let (found, turned) = (of(&mesh), of(&turn(mesh)));
        assert_close(found.mass, turned.mass, 1e-12);
    }

    #[test]
    fn an_overlap_counts_once() {
        let bars = [
            cuboid([-2.0, -0.5, -0.5], [2.0, 0.5, 0.5]),
            cuboid([-0.5, -2.0, -0.5], [0.5, 2.0, 0.5]),
        ];
        let found = of(&join(&bars));
        assert_eq!(found.source, MassSource::MeshUnion);
        let sides = [Vector::new(4.0, 1.0, 1.0), Vector::new(1.0, 4.0, 1.0), Vector::ONE];
        let bar = sides.map(box_inertia);
        let inertia = Vector::from_array([0, 1, 2].map(|i| bar[0][i] + bar[1][i] - bar[2][i]));
        assert_properties(&found, 7.0, inertia, 0.01);
    }

    #[test]
    fn an_open_mesh_takes_the_union_of_its_hulls_or_its_own() {
        let mut bar = cuboid([0.0; 3], [2.0, 1.0, 1.0]);
        bar.triangles.pop();
        let keep = Parameters::default().with_openings(Openings::Keep);
        let of_shell =
            |mesh, hulls: &[Hull]| mass_properties_with(mesh, hulls, DENSITY, &keep).unwrap();
        let found = of_shell(&bar, &[]);
        assert_eq!(found.source, MassSource::ConvexHull);
        assert_properties(&found, 2.0, box_inertia(Vector::new(2.0, 1.0, 1.0)), 1e-9);

        let hull = |low, high| {
            decompose(&cuboid(low, high), &Parameters::default(), &Control::new()).unwrap().hulls
        };
        let hulls =
            [hull([0.0; 3], [1.5, 1.0, 1.0]), hull([0.5, 0.0, 0.0], [2.0, 1.0, 1.0])].concat();
        let found = of_shell(&bar, &hulls);
        assert_eq!(found.source, MassSource::HullUnion);
        assert_properties(&found, 2.0, box_inertia(Vector::new(2.0, 1.0, 1.0)), 0.01);

        assert_eq!(of_shell(&hemisphere(16), &[]).source, MassSource::ConvexHull);
        assert_eq!(of(&bar).source, MassSource::Mesh, "its flat opening is closed");
    }

    #[test]
    fn scaling_the_properties_is_scaling_the_mesh() {
        let mut mesh =
            join(&[cuboid([0.0; 3], [1.0, 2.0, 3.0]), cuboid([2.0; 3], [3.0, 2.5, 4.0])]);
        let scale = [-2.0, 0.5, 3.0];
        let expected = of(&mesh).scaled(scale);
        for point in &mut mesh.positions {
            *point = [0, 1, 2].map(|i| point[i] * scale[i]);
        }
        let found = of(&mesh);
        assert_close(found.mass, expected.mass, 1e-9);
        for i in 0..3 {
            assert_close(found.centre[i], expected.centre[i], 1e-9);
            for j in 0..3 {
                assert_close(found.inertia[i][j], expected.inertia[i][j], 1e-8);
            }
        }
        let heavier = found.with_mass(2.0 * found.mass);
        assert_close(heavier.inertia[0][1], 2.0 * found.inertia[0][1], 1e-9);
    }

    #[test]
    fn a_density_of_nothing_is_an_error() {
        let mesh = cuboid([0.0; 3], [1.0; 3]);
        for density in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let result = mass_properties(&mesh, &[], density);
            assert!(matches!(result, Err(Error::InvalidParameter { name: "density", .. })));
        }
    }

    #[cfg(feature = "nalgebra")]
    #[test]
    fn a_turned_box_finds_its_axes_again() {
        let turned = Rotation3::from_euler_angles(0.3, -0.7, 1.1);
        let wanted = [1.0, 2.0, 5.0];
        let diagonal = Matrix3::from_diagonal(&wanted.into());
        let tensor = turned.matrix() * diagonal * turned.matrix().transpose();
        let rows = [0, 1, 2].map(|i| Vector::from([0, 1, 2].map(|j| tensor[(i, j)])));
        let found = principal_inertia(rows);
        for (moment, expected) in found.moments.into_iter().zip(wanted) {
            assert!((moment - expected).abs() < 1e-12);
        }
        for (axis, column) in found.axes.into_iter().zip(turned.matrix().column_iter()) {
            assert!((column.dot(&nalgebra::Vector3::from(axis)).abs() - 1.0).abs() < 1e-12);
        }
        let quaternion =
            UnitQuaternion::from_quaternion(nalgebra::Quaternion::from(found.rotation));
        for (axis, unit) in found.axes.into_iter().zip(Matrix3::identity().column_iter()) {
            assert!((quaternion * unit - nalgebra::Vector3::from(axis)).norm() < 1e-12);
        }
    }

    #[cfg(feature = "nalgebra")]
    #[test]
    fn what_is_round_or_has_no_size_still_gets_a_frame() {
        for tensor in [[Vector::ZERO; 3], [Vector::NAN; 3]] {
            let found = principal_inertia(tensor);
            assert!((found.rotation.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
        }
        let round = principal_inertia(
            [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(Vector::from),
        );
        assert_eq!((round.moments, round.rotation), ([2.0; 3], [0.0, 0.0, 0.0, 1.0]));
    }
}
