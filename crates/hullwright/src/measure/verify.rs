//! Upper bounds on the errors of anybody's hulls: whole faces and whole triangles are judged, not
//! samples of them.

use super::hulls::{MeasuredHull, NONE_USABLE};
use super::options::MeasureOptions;
use crate::bounded::verifier::Verifier;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::hull::{ConvexHull, convex_hull};
use crate::hulls_format::VerifiedErrors;
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
    /// The true protrusion is at most this much smaller, as a rule 1 to 5 %. So is the true
    /// uncovered distance where it is the larger of the two; it is not resolved below 3 % of the
    /// protrusion.
    pub resolution: f64,
    /// Diagonal of the bounding box of the vertices that triangles use, in the mesh's units.
    pub diagonal: f64,
}

impl VerifiedDistances {
    /// Both in the mesh's units, as [`least_hulls`](crate::least_hulls()) takes them.
    pub fn in_units(&self) -> VerifiedErrors {
        let [protrusion, uncovered] =
            [self.protrusion_max, self.uncovered_max].map(|share| share * self.diagonal);
        VerifiedErrors::new(protrusion, uncovered)
    }
}

/// Distances are known to this share of themselves.
const RESOLUTION: f64 = 0.01;

/// Distances below this fraction of the diagonal are not resolved.
const LEAST: f64 = 1e-4;

/// Bounds that are tried one after the other, at most.
const TRIALS: usize = 16;

/// How much larger the next bound is where the one before says nothing but that it is exceeded.
const STEP: f64 = 1.3;

/// What is found beyond a bound is this multiple of a distance that is reached, as a rule.
const NEARLY: f64 = 1.04;

/// Where a bound is exceeded, by however little, this share of it is reached.
const SURELY: f64 = 0.995;

/// What a hull grows by that is flat, as a fraction of its extent: it is a hull like others then.
const THICKNESS: f64 = 1e-6;

/// Bounds both errors of hulls from above, hulls of any tool, each taken as the convex hull of its
/// points. What counts as solid, surface and hull is as in [`measure`](super::measure()), and of
/// `options` the numbers of points, the convexity tolerance and the seed have no effect. Hulls
/// that can't be judged are left out.
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
    let hulls: Vec<ConvexHull> =
        hulls.iter().filter_map(|hull| shape(hull, normalization)).collect();
    if hulls.is_empty() {
        return Err(Error::UnusableHull { hull: 0, reason: NONE_USABLE });
    }
    let verifier = |bound: f64| Verifier::new(&prepared, &options.resolving(bound), control);
    let farthest = |verifier: &Verifier| {
        let found = parallel::map(&hulls, |hull| verifier.protrusion(hull, control));
        found.into_iter().try_fold(0.0_f64, |farthest, found| Ok::<_, Error>(farthest.max(found?)))
    };
    let flatness = options.flatness.of_diagonal(normalization.diagonal) / normalization.diagonal;
    let reached = verifier(flatness)?.reached(&hulls, control)?;
    // Whether a bound is kept is decided soon, how far it is exceeded may take long: so a bound
    // just above what some point reaches is tried, and larger ones until one is kept.
    let (mut protrusion, mut least) = (f64::INFINITY, reached);
    let mut bound = (1.0 + RESOLUTION) * reached.max(LEAST);
    let mut trial = verifier(bound)?;
    let uncovered = trial.uncovered_finely(&hulls, control)?;
    for _ in 0..TRIALS {
        let found = farthest(&trial)?;
        protrusion = protrusion.min(found);
        if found <= bound {
            break;
        }
        let is_near = found < STEP * bound;
        least = if is_near { least.max(SURELY * bound) } else { least };
        bound = if is_near { (1.0 + RESOLUTION) * bound.max(found / NEARLY) } else { STEP * bound };
        trial = verifier(bound)?;
    }
    let diagonal = Survey::new(mesh).normalization.diagonal;
    let scale = normalization.diagonal / diagonal;
    Ok(VerifiedDistances {
        protrusion_max: protrusion * scale,
        uncovered_max: uncovered * scale,
        resolution: (protrusion - least).max(RESOLUTION * uncovered) * scale,
        diagonal,
    })
}

/// The convex hull of a hull's points; of a flat one with some thickness. `None` if it can't be
/// judged.
fn shape(hull: &MeshView<'_>, normalization: &Normalization) -> Option<ConvexHull> {
    let judged = MeasuredHull::new(hull, normalization)?;
    let mut points: Vec<[f64; 3]> = judged.points.iter().map(|&point| point.into()).collect();
    if judged.check.is_flat {
        let size = THICKNESS * judged.min.distance(judged.max).max(f64::MIN_POSITIVE);
        let around = |point: [f64; 3]| {
            (0..6).map(move |side: usize| {
                let mut beside = point;
                beside[side / 2] += if side.is_multiple_of(2) { size } else { -size };
                beside
            })
        };
        points = points.into_iter().flat_map(around).collect();
    }
    convex_hull(&points).ok()
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
