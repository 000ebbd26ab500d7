//! Hulls that physics engines can take: with volume, also in `f32`.
//!
//! Groups of a mesh are often flat, and physics engines lose or flatten plates that are thinner
//! than about 6e-4 of their diagonal. Such a set is pushed against its normal, into the solid that
//! it is the surface of, until it is [`MINIMUM_THICKNESS`] thick: its outer side stays in place.
//!
//! Rounding to `f32` moves vertices by half a unit in the last place, which may dent flat sides,
//! fold slivers, and flatten what lies far from the origin. So the rounded points get a hull of their
//! own.

use super::builder::HullBuilder;
use super::convex_hull::ConvexHull;
use super::point_set::{Shape, is_finite};
use crate::error::Error;
use crate::geometry::vector::{Vector, as_arrays, as_vectors, diagonal};

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
        * diagonal(as_vectors(points).iter().copied().filter(is_finite)))
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
    let mut points: Vec<Vector> = points.iter().copied().filter(is_finite).collect();
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
    /// Less than this cosine and the surface's normal says nothing about the side.
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

/// Vertices and triangles in `f32`.
pub type SinglePrecisionHull = (Vec<[f32; 3]>, Vec<[u32; 3]>);

impl ConvexHull {
    /// Vertices and triangles in single precision: the hull of the rounded vertices, so that it is
    /// convex and has volume as it stands. O(n log n).
    ///
    /// # Errors
    /// [`Error::NoHull`] if a coordinate is beyond the range of `f32`.
    pub fn to_single_precision(&self) -> Result<SinglePrecisionHull, Error> {
        single_precision(&self.points, &mut HullBuilder::new())
    }
}

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
        let (solid, _) = solid_hull(builder, as_arrays(&points), [0.0; 3], least_thickness)?;
        points = rounded(solid.points())?;
        if builder.build(as_arrays(&points)) == Shape::Solid {
            let hull = ConvexHull::from(builder.extract());
            return Ok((hull.points_as().collect(), hull.triangles));
        }
        least_thickness *= 2.0;
    }
    Err(Error::NoHull { reason: "rounding to f32 leaves no volume" })
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
