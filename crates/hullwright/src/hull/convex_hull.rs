//! A convex polyhedron, the convex hull of a set of points, and hulls that physics engines can
//! take: with volume, also in `f32`.
//!
//! Groups of a mesh are often flat, and physics engines lose or flatten plates that are thinner
//! than about 6e-4 of their diagonal. Such a set is pushed against its normal, into the solid that
//! it is the surface of, until it is [`MINIMUM_THICKNESS`] thick: its outer side stays in place.
//!
//! Rounding to `f32` moves vertices by half a unit in the last place, which may dent flat sides,
//! fold slivers, and flatten what lies far from the origin. So the rounded points get a hull of
//! their own.

use super::growing_hull::{DEFAULT_TOLERANCE, HullBuilder};
use super::quickhull::Shape;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::error::Error;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{
    Vector, area_normal, as_arrays, as_vectors, bounds, diagonal, larger, smaller,
};
use crate::geometry::{Bounds, MeshView};

/// A closed convex polyhedron of triangles, wound counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ConvexHull {
    /// Vertices, each used by a triangle.
    pub points: Vec<[f64; 3]>,
    /// Triangles over `points`.
    pub triangles: Vec<[u32; 3]>,
}

/// The convex hull of points, in their units. O(n log n) expected.
///
/// No point lies farther than [`DEFAULT_TOLERANCE`](super::DEFAULT_TOLERANCE) of their extent
/// outside the hull. Points that are not finite are ignored.
///
/// # Errors
/// [`Error::NoHull`] if the points lie in a plane, on a line or on a spot up to the tolerance;
/// [`solid_hull`](super::solid_hull) gives such points a thickness instead, with
/// `solid_hull(&mut HullBuilder::new(), points, [0.0; 3], 0.0)`.
///
/// ```
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.1; 3]];
/// let hull = hullwright::convex_hull(&points)?;
/// assert_eq!((hull.points.len(), hull.triangles.len()), (4, 4));
/// # Ok::<(), hullwright::Error>(())
/// ```
pub fn convex_hull(points: &[[f64; 3]]) -> Result<ConvexHull, Error> {
    let mut builder = HullBuilder::new();
    let reason = match builder.build(points) {
        Shape::Solid => return Ok(builder.extract().into()),
        Shape::Flat => "the points lie in a plane",
        Shape::Linear => "the points lie on a line",
        Shape::Point => "there are no two distinct finite points",
    };
    Err(Error::NoHull { reason })
}

impl From<(Vec<[f64; 3]>, Vec<[u32; 3]>)> for ConvexHull {
    fn from((points, triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>)) -> Self {
        Self { points, triangles }
    }
}

impl<'a> From<&'a ConvexHull> for MeshView<'a> {
    fn from(hull: &'a ConvexHull) -> Self {
        Self::new(&hull.points, &hull.triangles)
    }
}

impl ConvexHull {
    /// The vertices as any type of point that is made from an array, such as those of glam, mint
    /// and nalgebra, in single precision: rounded, and so convex only up to rounding.
    pub fn points_as<P: From<[f32; 3]>>(&self) -> impl ExactSizeIterator<Item = P> + '_ {
        self.points().iter().map(|point| P::from(point.as_vec3().to_array()))
    }

    /// Vertices and triangles in single precision: the hull of the rounded vertices, so that it is
    /// convex and has volume as it stands. O(n log n).
    ///
    /// # Errors
    /// [`Error::NoHull`] if a coordinate is beyond the range of `f32`.
    pub fn to_single_precision(&self) -> Result<SinglePrecisionHull, Error> {
        single_precision(&self.points, &mut HullBuilder::new())
    }

    /// The corners of each triangle. Triangles with an index out of range are left out.
    pub fn corners(&self) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
        self.triangles.iter().filter_map(|triangle| {
            let [a, b, c] = triangle.map(|index| self.points.get(index as usize).copied());
            Some([a?, b?, c?])
        })
    }

    /// The vertices as vectors.
    #[inline]
    pub(crate) fn points(&self) -> &[Vector] {
        as_vectors(&self.points)
    }

    /// The corners of each triangle as vectors.
    pub(crate) fn faces(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        self.corners().map(|corners| corners.map(Vector::from))
    }

    /// Enclosed volume, in cubed units. O(triangles).
    pub fn volume(&self) -> f64 {
        // Seen from a vertex, so that far from the origin no digits are lost.
        let Some(&apex) = self.points().first() else {
            return 0.0;
        };
        let volumes = self.faces().map(|[a, b, c]| (a - apex).dot((b - apex).cross(c - apex)));
        volumes.sum::<f64>() / 6.0
    }

    /// Axis-aligned bounding box; `None` without points. O(points).
    pub fn bounds(&self) -> Option<Bounds> {
        let (min, max) = bounds(self.points().iter().copied());
        (!self.points.is_empty()).then_some(Bounds { min: min.to_array(), max: max.to_array() })
    }

    /// The unit normal and offset of each triangle's plane; zero for triangles without area.
    pub fn planes(&self) -> Vec<([f64; 3], f64)> {
        let planes = self.face_planes().into_iter();
        planes.map(|Plane { normal, offset }| (normal.to_array(), offset)).collect()
    }

    /// The same, with vectors.
    pub(crate) fn face_planes(&self) -> Vec<Plane> {
        self.faces().map(Plane::of).collect()
    }

    /// Distance of a point to the hull, 0 inside. `planes` are the hull's. O(triangles).
    pub(super) fn distance_outside(&self, planes: &[Plane], point: Vector) -> f64 {
        // The nearest point is on a face that the point is in front of.
        let visible = self.faces().zip(planes).filter(|(_, plane)| plane.height(point) > 0.0);
        let distances = visible.map(|(corners, _)| {
            let [a, b, c] = corners.map(|corner| corner - point);
            closest_point_on_triangle(a, b, c).length()
        });
        distances.min_by(f64::total_cmp).unwrap_or(0.0)
    }

    /// Whether no vertex of another hull is in front of a face, up to the rounding of tests.
    #[cfg(test)]
    pub(super) fn holds(&self, other: &Self) -> bool {
        let planes = self.face_planes();
        planes.iter().all(|plane| other.points().iter().all(|&point| plane.height(point) <= 1e-9))
    }
}

/// The least width of a hull, as a fraction of the diagonal of its own bounding box. Parry flattens
/// plates thinner than about 6e-4 of their diagonal; this leaves room for rounding to `f32`.
pub const MINIMUM_THICKNESS: f64 = 1e-3;

/// A hull's least thickness as a fraction of the mesh's diagonal: very small hulls keep a volume
/// that single precision can represent.
pub(crate) const LEAST_THICKNESS: f64 = 1e-6;

/// A width below the minimum by less than this fraction of it is accepted, so that a thickened hull
/// is not thickened again.
const SLACK: f64 = 1e-3;

/// The width of a hull is at least its first tetrahedron's height divided by this, so that the
/// exact width of most hulls is not computed.
const HEIGHT_PER_WIDTH: f64 = 8.0;

/// Each pass adds one dimension: point to rod, rod to plate, plate to solid.
const DIMENSIONS: usize = 3;

/// The convex hull of points, with at least [`MINIMUM_THICKNESS`] times the diagonal of their
/// bounding box, or `least_thickness` in units if that is more, in every direction.
///
/// `outward` is the mean normal of the surface that the points come from: thickness is added
/// against it. Zero if there is none; then it is added on both sides. The second value is the
/// thickness that was added, in units, 0 for most hulls: no point of the hull is farther than
/// that (times the square root of 3 for spots) from the hull of the points.
///
/// # Errors
/// [`Error::NoHull`] if no point is finite, or if all are one spot and `least_thickness` is 0.
pub fn solid_hull(
    builder: &mut HullBuilder,
    points: &[[f64; 3]],
    outward: [f64; 3],
    least_thickness: f64,
) -> Result<(ConvexHull, f64), Error> {
    let shape = builder.build(points);
    let wanted = (MINIMUM_THICKNESS
        * diagonal(as_vectors(points).iter().copied().filter(|point| point.is_finite())))
    .max(least_thickness);
    if shape == Shape::Solid && builder.simplex_height() >= HEIGHT_PER_WIDTH * wanted {
        return Ok((builder.extract().into(), 0.0));
    }
    thicken(builder, shape, as_vectors(points), Vector::from(outward), wanted)
}

/// The hull of two hulls.
///
/// # Errors
/// As [`solid_hull`].
pub(crate) fn joint_hull(
    builder: &mut HullBuilder,
    first: &ConvexHull,
    second: &ConvexHull,
) -> Result<ConvexHull, Error> {
    let points: Vec<Vector> = first.points().iter().chain(second.points()).copied().collect();
    Ok(solid_hull(builder, as_arrays(&points), [0.0; 3], 0.0)?.0)
}

#[cold]
fn thicken(
    builder: &mut HullBuilder,
    mut shape: Shape,
    points: &[Vector],
    outward: Vector,
    wanted: f64,
) -> Result<(ConvexHull, f64), Error> {
    let mut points: Vec<Vector> =
        points.iter().copied().filter(|point| point.is_finite()).collect();
    if points.is_empty() {
        return Err(Error::NoHull { reason: "no point is finite" });
    }
    let outward = outward.normalize_or_zero();
    let mut added: f64 = 0.0;
    for _ in 0..=DIMENSIONS {
        let (width, direction) = thin_direction(builder, shape, &points, outward);
        if shape == Shape::Solid && width >= wanted * (1.0 - SLACK) {
            return Ok((builder.extract().into(), added));
        }
        let missing = wanted - width;
        added = added.max(missing);
        points = pushed(&points, direction, outward, missing);
        shape = builder.build(as_arrays(&points));
    }
    match shape {
        Shape::Solid => Ok((builder.extract().into(), added)),
        _ => Err(Error::NoHull { reason: "the points are one spot" }),
    }
}

/// Where the points are thinnest, and how thin.
fn thin_direction(
    builder: &HullBuilder,
    shape: Shape,
    points: &[Vector],
    outward: Vector,
) -> (f64, Vector) {
    if shape == Shape::Solid {
        return builder.width().unwrap_or((0.0, outward));
    }
    let (first, second) = far_pair(points);
    let along = (second - first).normalize_or_zero();
    let direction = match shape {
        Shape::Flat => {
            let away = |point: &Vector| along.cross(*point - first);
            let longest = points.iter().map(away).max_by(|a, b| a.dot(*a).total_cmp(&b.dot(*b)));
            longest.unwrap_or(outward).normalize_or_zero()
        }
        Shape::Linear => {
            // Across the line, along the surface's normal if that leads across.
            let across = outward - along * outward.dot(along);
            if across.dot(across) > 0.25 { across.normalize_or_zero() } else { any_across(along) }
        }
        _ if outward != Vector::ZERO => outward,
        _ => Vector::Z,
    };
    (0.0, direction)
}

/// The points and their copies, moved against `outward`, or to both sides without one.
fn pushed(points: &[Vector], direction: Vector, outward: Vector, distance: f64) -> Vec<Vector> {
    /// Less than this cosine and the surface's normal does not decide the side.
    const UNCERTAIN: f64 = 1e-3;
    let along = direction.dot(outward);
    let (from, to) = if along > UNCERTAIN {
        (0.0, -distance)
    } else if along < -UNCERTAIN {
        (0.0, distance)
    } else {
        (-0.5 * distance, 0.5 * distance)
    };
    let moved = |by: f64| points.iter().map(move |&point| point + direction * by);
    moved(from).chain(moved(to)).collect()
}

/// Some unit vector at right angles to a unit vector.
pub(super) fn any_across(along: Vector) -> Vector {
    let least = (0..3).min_by(|&a, &b| along[a].abs().total_cmp(&along[b].abs())).unwrap_or(0);
    let mut axis = Vector::ZERO;
    axis[least] = 1.0;
    along.cross(axis).normalize_or_zero()
}

/// A point and the one farthest from it.
fn far_pair(points: &[Vector]) -> (Vector, Vector) {
    let first = points.first().copied().unwrap_or_default();
    let farthest = |from: Vector| {
        let by_distance =
            |a: &&Vector, b: &&Vector| from.distance(**a).total_cmp(&from.distance(**b));
        points.iter().max_by(by_distance).copied().unwrap_or(from)
    };
    let second = farthest(first);
    (farthest(second), second)
}

/// A hull far from the origin keeps at least this many units in the last place of its largest
/// coordinate as thickness, so that its volume survives the next rounding too.
const LEAST_ULPS: f64 = 4.0;

/// Thickness is rounded as well, so it may take a few attempts; each doubles it.
const ATTEMPTS: usize = 4;

/// From about 70 vertices on a hull is built in less time than all heights above its faces are
/// computed.
const MOST_HEIGHTS: usize = 10_000;

/// Vertices and triangles in `f32`.
pub type SinglePrecisionHull = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// The hull of the points rounded to `f32`, with volume and wound outward. Convex up to the
/// tolerance of [`HullBuilder`], which is less than 1e-6 of the diagonal. O(n log n).
///
/// # Errors
/// [`Error::NoHull`] if a coordinate is beyond the range of `f32`, or nothing is left.
pub fn single_precision(
    points: &[[f64; 3]],
    builder: &mut HullBuilder,
) -> Result<SinglePrecisionHull, Error> {
    let mut points = rounded(as_vectors(points))?;
    let largest =
        as_arrays(&points).iter().flatten().fold(0.0f64, |largest, x| largest.max(x.abs()));
    let mut least_thickness = LEAST_ULPS * f64::from(f32::EPSILON) * largest;
    for _ in 0..ATTEMPTS {
        let (solid, added) = solid_hull(builder, as_arrays(&points), [0.0; 3], least_thickness)?;
        if added == 0.0 {
            return Ok((solid.points_as().collect(), solid.triangles));
        }
        points = rounded(solid.points())?;
        if builder.build(as_arrays(&points)) == Shape::Solid {
            let hull = ConvexHull::from(builder.extract());
            return Ok((hull.points_as().collect(), hull.triangles));
        }
        least_thickness *= 2.0;
    }
    Err(Error::NoHull { reason: "rounding to f32 leaves no volume" })
}

/// A hull with its vertices multiplied by `scale` and rounded to `f32`, its triangles as they are
/// but wound outward. `None` unless it is convex as it stands, up to the tolerance of
/// [`HullBuilder`], and not thin: then [`single_precision`] builds one. That costs vertices ×
/// triangles, so `None` beyond 10,000 of these too. Whether the triangles close is not looked at.
pub fn rounded_hull(hull: &ConvexHull, scale: [f32; 3]) -> Option<SinglePrecisionHull> {
    if hull.points.len() * hull.triangles.len() > MOST_HEIGHTS {
        return None;
    }
    let scale = Vector::from(scale.map(f64::from));
    let points: Vec<Vector> = hull.points().iter().map(|point| *point * scale).collect();
    let points = rounded(&points).ok()?;
    let extent = diagonal(points.iter().copied());
    let largest =
        as_arrays(&points).as_flattened().iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let thickness =
        (MINIMUM_THICKNESS * extent).max(LEAST_ULPS * f64::from(f32::EPSILON) * largest);
    let is_mirrored = scale.element_product() < 0.0;
    let corner = |vertex: u32| points.get(vertex as usize).copied();
    let is_face = |&[a, b, c]: &[u32; 3]| {
        let [Some(a), Some(b), Some(c)] = [a, b, c].map(corner) else { return false };
        let normal = area_normal(a, b, c).normalize_or_zero();
        let heights = points.iter().map(|point| normal.dot(*point - a));
        let (lowest, highest) =
            heights.fold((0.0, 0.0), |(low, high), x| (smaller(low, x), larger(high, x)));
        highest <= DEFAULT_TOLERANCE * extent && -lowest >= HEIGHT_PER_WIDTH * thickness
    };
    let turned = |&[a, b, c]: &[u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
    let triangles: Vec<[u32; 3]> = hull.triangles.iter().map(turned).collect();
    let points_as = || points.iter().map(|point| point.as_vec3().to_array()).collect();
    triangles.iter().all(is_face).then(|| (points_as(), triangles))
}

fn rounded(points: &[Vector]) -> Result<Vec<Vector>, Error> {
    let round = |point: &Vector| point.map(|x| f64::from(x as f32));
    let points: Vec<_> = points.iter().map(round).collect();
    if as_arrays(&points).iter().flatten().all(|x| x.is_finite()) {
        Ok(points)
    } else {
        Err(Error::NoHull { reason: "a coordinate is beyond the range of f32" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> ConvexHull {
        let corners =
            [0, 1, 2, 3, 4, 5, 6, 7].map(|i| [0, 1, 2].map(|axis| f64::from(i >> axis & 1)));
        convex_hull(&corners).unwrap()
    }

    #[test]
    fn a_rounded_hull_that_is_convex_stays_as_it_is_scaled_and_mirrored() {
        let hull = cube();
        let (points, triangles) = rounded_hull(&hull, [1.0; 3]).unwrap();
        assert!(hull.points_as::<[f32; 3]>().eq(points));
        assert_eq!(triangles, hull.triangles);
        let (points, triangles) = rounded_hull(&hull, [-2.0, 1.0, 3.0]).unwrap();
        let points = points.iter().map(|point| point.map(f64::from)).collect();
        let mirrored = ConvexHull { points, triangles };
        assert!((mirrored.volume() - 6.0).abs() < 1e-6);
    }

    #[test]
    fn a_hull_that_is_dented_thin_or_beyond_single_precision_or_names_no_vertex_does_not() {
        let moved = |vertex: usize, to: [f64; 3]| {
            let mut hull = cube();
            hull.points[vertex] = to;
            rounded_hull(&hull, [1.0; 3])
        };
        let [x, y, z] = cube().points[0];
        assert!(moved(0, [x + 1e-9, y, z]).is_some());
        assert_eq!(moved(0, [0.5, 0.5, 0.5]), None, "dented");
        assert_eq!(moved(0, [f64::NAN, y, z]), None);
        assert_eq!(moved(0, [1e39, y, z]), None);
        assert_eq!(rounded_hull(&cube(), [1.0, 1.0, 1e-3]), None, "thin");
        assert_eq!(rounded_hull(&cube(), [1.0, 1.0, 0.0]), None);
        let mut broken = cube();
        broken.triangles[0][0] = 8;
        assert_eq!(rounded_hull(&broken, [1.0; 3]), None);
        let mut large = cube();
        large.points.resize(1000, [0.5; 3]);
        assert_eq!(rounded_hull(&large, [1.0; 3]), None);
    }
}
