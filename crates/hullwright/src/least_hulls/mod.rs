//! How few hulls are possible: a lower bound for anybody's result, with points that prove it.
//!
//! Two points of a surface are apart if a point between them is farther from the solid than hulls
//! may be, and in the open: no hull that keeps the bound contains both. Points that are all apart
//! from each other need a hull each. (A set of points none of which sees another is a *hidden set*;
//! it bounds the number of convex pieces from below.)
//!
//! Why that holds where a part of the surface may lie outside the hulls: a point that is uncovered
//! by u at most has a point of some hull within u. If one hull had the points of two that are
//! apart, it had the segment between them too, and on it a point that is within u of the one that
//! lies too far from the solid. So that one has to be farther than the bound and u together.
//!
//! Why the point has to be in the open: a hull may swallow a void whole, as long as its surface
//! keeps the bound. But where a ball as large as the bound gets from outside, so does the surface.
//!
//! | file | contents |
//! |---|---|
//! | `mod` | the public function; points that are spread over the surface |
//! | `open_space` | whether a point is far from the solid, and in the open |
//! | `conflicts` | which points are apart from each other, and many that all are |

mod conflicts;
mod open_space;

use crate::bounded::verifier::Verifier;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::geometry::vector::Vector;
use crate::hulls_format::VerifiedErrors;
use crate::mesh::TriangleMesh;
use crate::mesh::refine::refine;
use crate::openings::OpeningSettings;
use crate::openings::prepare::prepare_closed;
use crate::parallel;
use crate::parameters::{Length, Parameters};
use conflicts::Conflicts;
use open_space::OpenSpace;

/// A lower bound on the number of hulls.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LeastHulls {
    /// No result that keeps the bound has fewer. At least 1.
    pub hulls: usize,
    /// As many points of the surface, no two of which can be in one hull. In the mesh's units.
    pub points: Vec<[f64; 3]>,
}

/// How many hulls are needed at least, whoever makes them, for errors no larger than these: those
/// that a result has, or the bound for both. In the mesh's units. The parameters say what is solid
/// and what moves, as they do for [`decompose`](crate::decompose): openings, the axis that points
/// up, the probe, and by their bound which openings are flat.
///
/// The true least number may be larger. What is found is the same on every run.
///
/// O(n log n) for n triangles, and up to some million queries of the distance: about a second.
///
/// # Errors
/// Those of [`decompose`](crate::decompose); [`Error::InvalidParameter`] if an error is negative or
/// not finite.
///
/// ```
/// use hullwright::hulls_format::VerifiedErrors;
/// use hullwright::{Control, Parameters, TriangleMesh, least_hulls};
///
/// # fn main() -> Result<(), hullwright::Error> {
/// // Two tetrahedra that share a corner, one above the other.
/// let low = [[1., 0., -1.], [0., 1., -1.], [-1., -1., -1.]];
/// let high = low.map(|[x, y, _]| [x, y, 1.]);
/// let mesh = TriangleMesh::new(
///     [&[[0.; 3]], &low[..], &high[..]].concat(),
///     vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2], [0, 5, 4], [0, 6, 5], [0, 4, 6], [4, 5, 6]],
/// );
/// let errors = VerifiedErrors::new(0.05, 0.01);
/// let least = least_hulls(&mesh, errors, &Parameters::default(), &Control::new())?;
/// assert_eq!(least.hulls, 2);
/// # Ok(())
/// # }
/// ```
pub fn least_hulls<'a>(
    mesh: impl Into<MeshView<'a>>,
    errors: VerifiedErrors,
    parameters: &Parameters,
    control: &Control,
) -> Result<LeastHulls, Error> {
    parameters.validate()?;
    let VerifiedErrors { protrusion_max, uncovered_max, .. } = errors;
    for (name, error) in [("protrusion_max", protrusion_max), ("uncovered_max", uncovered_max)] {
        if !(error >= 0.0 && error.is_finite()) {
            return Err(Error::parameter(name, format!("must be at least 0, not {error}")));
        }
    }
    let mesh = mesh.into();
    parallel::with(control.is_parallel(), || {
        let settings = OpeningSettings::from(parameters);
        let prepared = prepare_closed(mesh, &settings, control)?.prepared;
        let normalization = &prepared.normalization;
        let [protrusion, uncovered] =
            [protrusion_max, uncovered_max].map(|error| error / normalization.diagonal);
        let max_error = Length::Share(protrusion.max(f64::MIN_POSITIVE));
        let resolving = Parameters { max_error, ..parameters.clone() };
        let verifier = Verifier::new(&prepared, &resolving, control)?;
        // What the exact surface has moved counts twice: for the points, and for the solid.
        let bound = verifier.settings.bound.verified().max(protrusion);
        let far = bound + uncovered + 2.0 * verifier.solid.moved;
        let space =
            OpenSpace::new(&verifier.solid, verifier.settings.probe.as_ref(), far, control)?;
        let points = spread(verifier.surface());
        let found = Conflicts::new(points, &space, control)?.apart(control)?;
        let points: Vec<[f64; 3]> =
            found.into_iter().map(|point| normalization.restore(point).into()).collect();
        Ok(LeastHulls { hulls: points.len().max(1), points })
    })
}

/// Longest edge of the surface whose vertices are taken, as a fraction of the diagonal.
const LONGEST_EDGE: f64 = 0.03;

/// Points that are looked at, at most.
const MOST_POINTS: usize = 20_000;

/// Points of a surface: its vertices, where the tips of thin parts are, and more along long edges.
fn spread(surface: &TriangleMesh) -> Vec<Vector> {
    let mut surface = surface.clone();
    refine(&mut surface, LONGEST_EDGE);
    let mut is_used = vec![false; surface.positions.len()];
    for &vertex in surface.triangles.as_flattened() {
        is_used[vertex as usize] = true;
    }
    let used: Vec<Vector> = surface
        .points()
        .iter()
        .zip(is_used)
        .filter_map(|(&point, is_used)| is_used.then_some(point))
        .collect();
    let step = used.len().div_ceil(MOST_POINTS).max(1);
    used.into_iter().step_by(step).collect()
}
