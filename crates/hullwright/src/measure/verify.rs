//! Upper bounds on the errors of anybody's hulls: whole faces and whole triangles are judged, not
//! samples of them.

use super::MeasureOptions;
use super::hulls::MeasuredHull;
use crate::bounded::verifier::Verifier;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::hull::{ConvexHull, convex_hull};
use crate::mesh::Normalization;
use crate::mesh::repair::Survey;
use crate::openings::prepare::prepare_closed;
use crate::parallel;
use crate::parameters::{Length, Parameters};

/// How far hulls and a mesh are from each other at most, as fractions of
/// [`diagonal`](Self::diagonal).
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VerifiedDistances {
    /// No point of a hull's surface is farther than this outside the solid.
    pub protrusion_max: f64,
    /// No point of the mesh's surface is farther than this outside every hull.
    pub uncovered_max: f64,
    /// The larger of the two is above the true one by about this at most. The other is not resolved
    /// below 3 % of the larger one.
    pub resolution: f64,
    /// Diagonal of the bounding box of the vertices that triangles use, in the mesh's units.
    pub diagonal: f64,
}

/// A distance that is at least this share of the bound that it was resolved for is well resolved.
/// A smaller one is resolved again, for itself.
const RESOLVED: f64 = 0.8;

/// Distances are resolved to this share of themselves, and to the second one just below the bound.
const RESOLUTIONS: [f64; 2] = [0.04, 0.01];

/// Distances below this fraction of the diagonal are what single precision leaves of a hull.
const LEAST: f64 = 1e-5;

/// Bounds both errors of hulls from above, hulls of any tool, each taken as the convex hull of its
/// points. What counts as solid, surface and hull is as in [`measure`](super::measure()), and of
/// `options` the numbers of points, the convexity tolerance and the seed have no effect. Hulls
/// that can't be judged are left out. One that is flat protrudes, and covers nothing.
///
/// Where [`measure`](super::measure()) counts the boundary of all hulls, each hull counts whole
/// here, also within another.
///
/// O((n + p) log n) for n triangles and p parts into which faces are divided until each is decided:
/// tens of milliseconds for most props, seconds for hulls of many thousands of faces.
///
/// # Errors
/// As [`measure`](super::measure()).
///
/// ```
/// use hullwright::measure::{MeasureOptions, verify};
/// use hullwright::{Control, TriangleMesh};
///
/// # fn main() -> Result<(), hullwright::Error> {
/// let mesh = TriangleMesh::new(
///     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// );
/// let mut hull = mesh.clone();
/// hull.positions[3][2] = 1.1;
/// let found = verify(&mesh, &[hull], &MeasureOptions::default(), &Control::new())?;
/// let in_units = found.protrusion_max * found.diagonal;
/// assert!((0.1..0.102).contains(&in_units));
/// # Ok(())
/// # }
/// ```
pub fn verify<'a, 'h, H>(
    mesh: impl Into<MeshView<'a>>,
    hulls: &'h [H],
    options: &MeasureOptions,
    control: &Control,
) -> Result<VerifiedDistances, Error>
where
    &'h H: Into<MeshView<'h>>,
{
    options.validate()?;
    let mesh = mesh.into();
    let hulls: Vec<MeshView<'_>> = hulls.iter().map(Into::into).collect();
    parallel::with(control.is_parallel(), || bound(mesh, &hulls, options, control))
}

fn bound(
    mesh: MeshView<'_>,
    hulls: &[MeshView<'_>],
    options: &MeasureOptions,
    control: &Control,
) -> Result<VerifiedDistances, Error> {
    let prepared = prepare_closed(mesh, &options.of_openings(), control)?.prepared;
    if hulls.is_empty() {
        return Err(Error::NoHulls);
    }
    let normalization = &prepared.normalization;
    let usable = hulls.iter().filter_map(|hull| shape(hull, normalization));
    let (flat, solid): (Vec<_>, Vec<_>) = usable.partition(|(_, is_flat)| *is_flat);
    if flat.is_empty() && solid.is_empty() {
        return Err(Error::UnusableHull { hull: 0, reason: super::NONE_USABLE });
    }
    let whole = || solid.iter().map(|(hull, _)| hull);
    let all: Vec<&ConvexHull> = whole().chain(flat.iter().map(|(hull, _)| hull)).collect();
    let mut bound = options.flatness.of_diagonal(normalization.diagonal) / normalization.diagonal;
    let (mut protrusion, mut uncovered) = (f64::INFINITY, f64::INFINITY);
    let mut is_coarse = true;
    loop {
        bound = bound.max(LEAST);
        let verifier = Verifier::new(&prepared, &options.resolving(bound), control)?;
        let protrusions = parallel::map(&all, |hull| verifier.protrusion(hull, control));
        let mut farthest = 0.0_f64;
        for found in protrusions {
            farthest = farthest.max(found?);
        }
        protrusion = protrusion.min(farthest);
        uncovered = uncovered.min(verifier.uncovered(whole(), control)?);
        let largest = protrusion.max(uncovered);
        let [coarse, fine] = RESOLUTIONS;
        if largest < RESOLVED * bound && bound > LEAST {
            bound = largest;
        } else if is_coarse && largest > LEAST {
            // What is certain to be reached, and a little more: does it hold as a bound?
            is_coarse = false;
            bound = largest * (1.0 + 0.6 * fine) / (1.0 + coarse);
        } else {
            let is_fine = largest <= bound * (1.0 + fine);
            let resolution = if is_fine { fine } else { coarse } * largest.max(bound);
            let diagonal = Survey::new(mesh).normalization.diagonal;
            let scale = normalization.diagonal / diagonal;
            return Ok(VerifiedDistances {
                protrusion_max: protrusion * scale,
                uncovered_max: uncovered * scale,
                resolution: resolution * scale,
                diagonal,
            });
        }
    }
}

/// The convex hull of a hull's points, or its own triangles where that is flat, and whether it is.
/// `None` if it can't be judged.
fn shape(hull: &MeshView<'_>, normalization: &Normalization) -> Option<(ConvexHull, bool)> {
    let judged = MeasuredHull::new(hull, normalization)?;
    let points: Vec<[f64; 3]> = judged.points.iter().map(|&point| point.into()).collect();
    match judged.check.is_flat {
        true => Some((ConvexHull { points, triangles: judged.triangles }, true)),
        false => Some((convex_hull(&points).ok()?, false)),
    }
}

impl MeasureOptions {
    /// Parameters under which errors of about a bound are resolved, as a fraction of the diagonal.
    fn resolving(&self, bound: f64) -> Parameters {
        Parameters {
            max_error: Length::Share(bound),
            keep_cavities: self.keep_cavities,
            probe_radius: self.probe_radius,
            probe_from: self.probe_from.clone(),
            ..Parameters::default()
        }
    }
}
