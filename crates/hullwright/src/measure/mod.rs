//! Measures any set of hulls, of this library or another tool, against the mesh that they stand
//! for.
//!
//! [`measure`] says how far the hulls are outside of the solid (*protrusion*: objects stop before
//! they touch), how far the mesh's surface lies outside the hulls (*uncovered distance*: objects
//! sink in), and how much of the solid no hull holds (*uncovered volume*). All lengths are relative
//! to the diagonal of the bounding box of the vertices that the mesh's triangles use.
//!
//! # What counts as what
//!
//! - The **solid** is that of [`decompose`](crate::decompose): where the generalized winding number
//!   of the repaired mesh is above 0.5. Neighbours are turned so that they agree, and closed parts
//!   outward; what is there both ways round, and open parts of a mesh that is inside out as a
//!   whole, enclose nothing. Openings are closed as [`MeasureOptions::openings`] says. So holes,
//!   open sheets, self-intersections and cavities are no obstacle.
//! - The **surface** is the mesh's triangles, except those without area: what is thinner than 1e-6
//!   of the diagonal in two directions is a line, which repair drops and nothing has to cover.
//! - A **hull** is the convex hull of its points: that is what a physics engine collides with,
//!   whatever its triangles. These are checked on their own: see [`HullCheck`].
//! - A point is **in** a hull up to a tolerance of 1e-6, and **inside** it beyond the same
//!   tolerance. So hulls that touch leave no gap, and do not swallow each other's faces.
//! - The **boundary** of the hulls is the surface of all hulls without what is inside another.
//!
//! # Sampling
//!
//! Points are the same on every run, on any number of threads: evenly spread sequences, not random
//! numbers, unless [`MeasureOptions::random_seed`] is set. A maximum is that of the sampled points;
//! the true one may be higher, by more the sharper the spike: [`verify()`] bounds it from above.
//! [`MeasureOptions`] has the numbers of
//! points, [`Measurement::samples`] says what became of them. For points of your own there are
//! [`MeasuredMesh`] and [`MeasuredHulls`].
//!
//! | file | contents |
//! |---|---|
//! | `mod` | the measurement, and how figures follow from samples |
//! | `options` | how closely hulls are looked at, and what counts as solid |
//! | `sampling` | evenly spread points on a surface and in a box |
//! | `hulls` | each hull on its own, and the union of all |
//! | `pointwise` | the solid that they are measured against; errors of points that the caller chooses |
//! | `verify` | upper bounds instead of samples |

mod hulls;
mod options;
mod pointwise;
mod sampling;
mod verify;

use crate::bvh::{Bvh, INSIDE};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::geometry::vector::{Vector, bounds};
use crate::mesh::repair::Survey;
use crate::mesh::{Normalization, TriangleMesh};
use crate::openings::prepare::prepare_closed;
use crate::parallel::{self, map_indices};
use crate::probe::ProbeSettings;
use crate::sorting::sort_by;
use hulls::{Edges, MeasuredHull, NONE_USABLE, Union};
use pointwise::MeasuredSolid;
use sampling::{SampledSurface, in_unit_cube};

#[cfg(feature = "fill")]
pub use crate::probe::FilledSurface;
pub use hulls::HullCheck;
pub use options::MeasureOptions;
pub use pointwise::{MeasuredHulls, MeasuredMesh};
pub use verify::{VerifiedDistances, verify};

/// Distances of sampled points, as fractions of the mesh's diagonal.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Distances {
    /// Their average.
    pub mean: f64,
    /// The distance that 1 % of the points exceed.
    pub p99: f64,
    /// The greatest.
    pub max: f64,
}

impl Distances {
    fn of(mut values: Vec<f64>) -> Self {
        const HUNDREDTHS: usize = 99;

        sort_by(&mut values, f64::total_cmp);
        let Some(&max) = values.last() else {
            return Self::default();
        };
        let p99 = values[(values.len() - 1) * HUNDREDTHS / 100];
        Self { mean: values.iter().sum::<f64>() / values.len() as f64, p99, max }
    }
}

/// What became of the sampled points.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SampleCounts {
    /// Points on the surface of all hulls.
    pub hull: usize,
    /// Those of them that are not inside another hull: they give [`Measurement::protrusion`].
    pub boundary: usize,
    /// Points on the mesh: they give [`Measurement::uncovered`].
    pub mesh: usize,
    /// Points in the bounding box of mesh and hulls.
    pub volume: usize,
    /// Those of them in the solid: they give [`Measurement::uncovered_volume`].
    pub solid: usize,
    /// Those of them in a hull: they give [`Measurement::overlap`].
    pub in_hulls: usize,
    /// Those of them in the solid or in a hull: they give [`Measurement::iou`].
    pub union: usize,
}

/// How well hulls stand for a mesh. Lengths are fractions of [`diagonal`](Self::diagonal).
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Measurement {
    /// Hulls that can be judged.
    pub hulls: usize,
    /// Hulls that can't, and are left out: without triangles, with an index out of range, or with
    /// a coordinate that is not finite or farther away than 1e9 times the diagonal.
    pub unusable_hulls: usize,
    /// Vertices of all hulls.
    pub vertices: usize,
    /// Hulls with a vertex in front of one of their own faces by more than
    /// [`MeasureOptions::convexity_tolerance`].
    pub non_convex_hulls: usize,
    /// The farthest that any vertex lies in front of a face of its own hull.
    pub worst_concavity: f64,
    /// Hulls whose triangles do not close up, or are not wound the same way all over.
    pub open_hulls: usize,
    /// Hulls that enclose no or, being wound inward, a negative volume.
    pub non_positive_volumes: usize,
    /// How far the boundary of the hulls lies outside the solid.
    pub protrusion: Distances,
    /// How far the mesh lies outside all hulls.
    pub uncovered: Distances,
    /// The larger of the two maxima.
    pub hausdorff: f64,
    /// Share of the solid that no hull holds. `None` where more than 0.5 % of the mesh's edges
    /// are open, or no point is in the solid.
    pub uncovered_volume: Option<f64>,
    /// Volume that solid and hulls share, over the volume of both together. `None` where more
    /// than 0.5 % of the mesh's edges are open, or no point is in either.
    pub iou: Option<f64>,
    /// Sum of the hulls' volumes over the volume of their union. `None` where no point is in a
    /// hull.
    pub overlap: Option<f64>,
    /// Share of the mesh's edges that only one triangle uses, its vertices welded by position.
    pub open_edges: f64,
    /// Diagonal of the bounding box of the vertices that triangles use, in the mesh's units.
    pub diagonal: f64,
    /// What became of the sampled points.
    pub samples: SampleCounts,
    /// Every hull on its own, in the order given; `None` for those that can't be judged.
    pub checks: Vec<Option<HullCheck>>,
}

/// A mesh with a larger share of open edges has no volume to speak of.
const MOST_OPEN_EDGES: f64 = 0.005;

/// Measures hulls against a mesh. Triangles with a coordinate that is not finite are left out;
/// duplicate and degenerate ones change nothing.
///
/// O((n + s) log n) for n triangles and s samples, times the number of hulls whose bounding boxes
/// overlap.
///
/// # Errors
/// - [`Error::EmptyMesh`], [`Error::IndexOutOfRange`], [`Error::NothingUsable`] or
///   [`Error::TooLarge`] for the mesh.
/// - [`Error::NoHulls`] if there is no hull, [`Error::UnusableHull`] if none can be judged.
/// - [`Error::InvalidParameter`] for options out of their range.
/// - [`Error::Cancelled`], between one kind of sample and the next. A deadline does not count.
///
/// ```
/// use hullwright::measure::{MeasureOptions, measure};
/// use hullwright::{Control, Parameters, TriangleMesh, decompose};
///
/// # fn main() -> Result<(), hullwright::Error> {
/// let mesh = TriangleMesh::new(
///     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// );
/// let control = Control::new();
/// let hulls = decompose(&mesh, &Parameters::default(), &control)?.hulls;
/// let found = measure(&mesh, &hulls, &MeasureOptions::default(), &control)?;
/// assert!(found.protrusion.max < 1e-6 && found.uncovered.max < 1e-6);
/// // Fractions of the diagonal; a report has the mesh's units.
/// let in_units = found.hausdorff * found.diagonal;
/// assert!(in_units < 1e-6);
/// # Ok(())
/// # }
/// ```
pub fn measure<'a, 'h, H>(
    mesh: impl Into<MeshView<'a>>,
    hulls: &'h [H],
    options: &MeasureOptions,
    control: &Control,
) -> Result<Measurement, Error>
where
    &'h H: Into<MeshView<'h>>,
{
    options.validate()?;
    let mesh = mesh.into();
    let hulls: Vec<MeshView<'_>> = hulls.iter().map(Into::into).collect();
    parallel::with(control.is_parallel(), || judge(mesh, &hulls, options, control))
}

fn judge(
    source: MeshView<'_>,
    hulls: &[MeshView<'_>],
    options: &MeasureOptions,
    control: &Control,
) -> Result<Measurement, Error> {
    let (mesh, normalization) = Mesh::new(source, options, control)?;
    if hulls.is_empty() {
        return Err(Error::NoHulls);
    }
    let parts: Vec<Option<MeasuredHull>> =
        map_indices(hulls.len(), |index| MeasuredHull::new(&hulls[index], &normalization));
    let checks: Vec<Option<HullCheck>> =
        parts.iter().map(|part| part.as_ref().map(|part| part.check)).collect();
    let parts: Vec<MeasuredHull> = parts.into_iter().flatten().collect();
    if parts.is_empty() {
        return Err(Error::UnusableHull { hull: 0, reason: NONE_USABLE });
    }

    let union = Union::new(parts);
    let MeasureOptions { probe_radius, probe_from, flatness, .. } = options;
    let probe = ProbeSettings::new(*probe_radius, probe_from, &normalization);
    let bound = flatness.of_diagonal(normalization.diagonal) / normalization.diagonal;
    let (points, triangles) = (mesh.solid.points(), &mesh.solid.triangles);
    let solid = MeasuredSolid::new(points, triangles, probe, bound, control)?;
    let open_edges = Edges::of(&mesh.positions, &mesh.triangles).open_share;
    let boundary = protrusions(&union, &solid, open_edges > 0.0, options);
    let samples_of_boundary = boundary.len();
    let protrusion = Distances::of(boundary);
    control.check()?;
    let uncovered = uncovered(&mesh, &union, options);
    control.check()?;
    let volumes = Volumes::of(&mesh, &union, &solid.bvh, options);
    let share = |part: usize, of: usize| (of > 0).then(|| part as f64 / of as f64);
    let share_of_closed =
        |part, of| if open_edges > MOST_OPEN_EDGES { None } else { share(part, of) };
    let count = |is: &dyn Fn(&HullCheck) -> bool| checks.iter().flatten().filter(|c| is(c)).count();
    Ok(Measurement {
        hulls: union.parts().len(),
        unusable_hulls: hulls.len() - union.parts().len(),
        vertices: checks.iter().flatten().map(|check| check.vertices).sum(),
        non_convex_hulls: count(&|check| check.concavity > options.convexity_tolerance),
        worst_concavity: checks.iter().flatten().map(|check| check.concavity).fold(0.0, f64::max),
        open_hulls: count(&|check| !check.is_closed),
        non_positive_volumes: count(&|check| check.is_flat || check.volume <= 0.0),
        protrusion,
        uncovered,
        hausdorff: protrusion.max.max(uncovered.max),
        uncovered_volume: share_of_closed(volumes.solid - volumes.shared, volumes.solid),
        iou: share_of_closed(volumes.shared, volumes.union),
        overlap: share(volumes.with_multiplicity, volumes.in_hulls),
        open_edges,
        diagonal: normalization.diagonal,
        samples: SampleCounts {
            hull: options.hull_samples,
            boundary: samples_of_boundary,
            mesh: options.mesh_samples,
            volume: options.volume_samples,
            solid: volumes.solid,
            in_hulls: volumes.in_hulls,
            union: volumes.union,
        },
        checks,
    })
}

/// The mesh's usable triangles in normalised coordinates.
struct Mesh {
    positions: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    /// The same surface, repaired.
    solid: TriangleMesh,
    min: Vector,
    max: Vector,
}

impl Mesh {
    fn new(
        source: MeshView<'_>,
        options: &MeasureOptions,
        control: &Control,
    ) -> Result<(Self, Normalization), Error> {
        let closed = prepare_closed(source, &options.of_openings(), control)?;
        let is_changed = closed.is_changed();
        let prepared = closed.prepared;
        // As repair sees it: nothing else may decide what the diagonal is.
        let Survey { candidates, normalization, .. } = Survey::new(source);
        let triangles = source.triangles();
        let mut usable: Vec<[u32; 3]> = candidates.iter().map(|&t| triangles[t as usize]).collect();
        let corners = usable.iter().flatten().map(|&index| source.at(index));
        let (min, max) = bounds(corners.map(|corner| normalization.normalize(corner)));
        let positions = source.points().map(|point| normalization.normalize(point)).collect();
        if is_changed {
            let in_source = |triangle: &[u32; 3]| {
                triangle.map(|vertex| prepared.source_vertices[vertex as usize])
            };
            usable = prepared.mesh.triangles.iter().map(in_source).collect();
        } else if prepared.repairs.degenerate_triangles > 0 {
            // What repair takes for a line or a spot is no surface that hulls could leave
            // uncovered.
            let mut kept = prepared.source_triangles.clone();
            kept.sort_unstable();
            kept.dedup();
            usable = kept.iter().map(|&triangle| triangles[triangle as usize]).collect();
        }
        let place =
            |&point: &Vector| normalization.normalize(prepared.normalization.restore(point));
        let positions_of_solid = prepared.mesh.points().iter().map(place).map(Into::into).collect();
        let solid =
            TriangleMesh::new(positions_of_solid, prepared.triangles_of_solid().into_owned());
        Ok((Self { positions, triangles: usable, solid, min, max }, normalization))
    }
}

/// How far points on the hulls' boundary lie outside the solid. Where the surface is open, the
/// inside ends where no surface is, and may be nearer than that.
fn protrusions(
    union: &Union,
    solid: &MeasuredSolid,
    is_open: bool,
    options: &MeasureOptions,
) -> Vec<f64> {
    let (positions, triangles) = union.surface();
    let surface = SampledSurface::new(positions, triangles);
    let (bvh, count) = (&solid.bvh, options.hull_samples);
    let distances = map_indices(count, |index| {
        let (point, triangle) = surface.point(index, count, options.random_seed);
        if union.is_inside_another(point, triangle) {
            return None;
        }
        if bvh.is_inside(point) {
            return Some(0.0);
        }
        let to_surface = distance_to_surface(bvh, point);
        let distance =
            if is_open { distance_to_inside(bvh, point, to_surface) } else { to_surface };
        Some(solid.protrusion(point, distance))
    });
    distances.into_iter().flatten().collect()
}

/// Steps of Newton's method along the gradient: the winding number is smooth away from the surface,
/// so that most searches take two or three.
const STEPS: usize = 8;

/// Differences for the gradient, as a fraction of the distance to the surface.
const DIFFERENCE: f64 = 0.01;

/// How far beyond the level of the inside a step aims: a point on it need not count.
const BEYOND: f64 = 0.005;

/// The distance from a point outside to a point inside that is nearer than `limit`, the distance
/// to the surface; `limit` where none is found. An upper bound on the distance to the nearest one.
fn distance_to_inside(bvh: &Bvh, point: Vector, limit: f64) -> f64 {
    let step = DIFFERENCE * limit;
    let mut at = point;
    for _ in 0..STEPS {
        let winding = bvh.winding_number(at);
        if winding > INSIDE {
            return at.distance(point);
        }
        let slope = Vector::from_array([0, 1, 2].map(|axis| {
            let mut beside = at;
            beside[axis] += step;
            (bvh.winding_number(beside) - winding) / step
        }));
        let steepness = slope.length();
        if steepness <= 0.0 {
            return limit;
        }
        let way = ((INSIDE + BEYOND - winding) / steepness).min(0.5 * limit);
        at += slope * (way / steepness);
        if at.distance(point) >= limit {
            return limit;
        }
    }
    limit
}

/// How far the mesh lies outside all hulls.
fn uncovered(mesh: &Mesh, union: &Union, options: &MeasureOptions) -> Distances {
    let surface = SampledSurface::new(&mesh.positions, &mesh.triangles);
    let (positions, triangles) = union.surface();
    let bvh = Bvh::new(positions, triangles);
    let count = options.mesh_samples;
    Distances::of(map_indices(count, |index| {
        let (point, _) = surface.point(index, count, options.random_seed);
        if union.multiplicity(point) > 0 { 0.0 } else { distance_to_surface(&bvh, point) }
    }))
}

/// Distance to a mesh that has triangles, so that there always is one.
fn distance_to_surface(bvh: &Bvh, point: Vector) -> f64 {
    bvh.closest_point(point, f64::INFINITY).map_or(0.0, |closest| closest.distance)
}

/// Counts of points in the joint bounding box.
#[derive(Default)]
struct Volumes {
    solid: usize,
    in_hulls: usize,
    /// In the solid or in a hull.
    union: usize,
    /// In the solid and in a hull.
    shared: usize,
    /// In hulls, counted once for each.
    with_multiplicity: usize,
}

impl Volumes {
    fn of(mesh: &Mesh, union: &Union, bvh: &Bvh, options: &MeasureOptions) -> Self {
        let (mut min, mut max) = (mesh.min, mesh.max);
        for part in union.parts() {
            (min, max) = (min.min(part.min), max.max(part.max));
        }
        let answers = map_indices(options.volume_samples, |index| {
            let point = min + in_unit_cube(index, options.random_seed) * (max - min);
            (union.multiplicity(point), bvh.is_inside(point))
        });
        let mut volumes = Self::default();
        for (multiplicity, is_in_solid) in answers {
            let is_in_hulls = multiplicity > 0;
            volumes.solid += usize::from(is_in_solid);
            volumes.in_hulls += usize::from(is_in_hulls);
            volumes.union += usize::from(is_in_solid || is_in_hulls);
            volumes.shared += usize::from(is_in_solid && is_in_hulls);
            volumes.with_multiplicity += multiplicity;
        }
        volumes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn above_the_mouth_of_a_box_without_a_lid_the_inside_is_nearer_than_the_surface() {
        let corner =
            |i: u32| Vector::from_array([0, 1, 2].map(|axis| f64::from(i >> axis & 1) - 0.5));
        let positions: Vec<Vector> = (0..8).map(corner).collect();
        let walls = [[0, 2, 1], [1, 2, 3], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7]];
        let triangles = [&walls[..], &[[0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]].concat();
        let bvh = Bvh::new(&positions, &triangles);
        let above = Vector::new(0.0, 0.0, 0.51);
        assert!(!bvh.is_inside(above) && bvh.is_inside(Vector::new(0.0, 0.0, 0.49)));
        let to_surface = bvh.closest_point(above, f64::INFINITY).unwrap().distance;
        let to_inside = distance_to_inside(&bvh, above, to_surface);
        assert!(to_surface > 0.49 && (0.01..0.03).contains(&to_inside), "{to_inside}");
        // Beside a wall nothing inside is nearer than the wall.
        let beside = Vector::new(0.6, 0.0, 0.0);
        let to_wall = bvh.closest_point(beside, f64::INFINITY).unwrap().distance;
        assert_eq!(distance_to_inside(&bvh, beside, to_wall), to_wall);
    }
}
