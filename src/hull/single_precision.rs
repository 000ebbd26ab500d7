//! Hulls in `f32`, still convex.
//!
//! Rounding moves vertices by half a unit in the last place, which may dent flat sides, fold
//! slivers, and flatten what lies far from the origin. So the rounded points get a hull of their
//! own: what is returned is convex as it stands, and has volume.

use super::builder::HullBuilder;
use super::convex_hull::ConvexHull;
use super::simplex::Shape;
use super::thickness::solid_hull;
use crate::error::Error;

/// A hull far from the origin keeps at least this many units in the last place of its largest
/// coordinate as thickness, so that its volume survives the next rounding too.
const LEAST_ULPS: f64 = 4.0;

/// Thickness is rounded as well, so it may take a few goes; each doubles it.
const ATTEMPTS: usize = 4;

/// Vertices and triangles in `f32`.
pub type SinglePrecisionHull = (Vec<[f32; 3]>, Vec<[u32; 3]>);

impl ConvexHull {
    /// Vertices and triangles in single precision, as physics engines want them: the hull of the
    /// rounded vertices, so that it is convex and has volume as it stands. O(n log n).
    ///
    /// # Errors
    /// [`Error::NoHull`] if a coordinate is beyond the range of `f32`.
    ///
    /// ```
    /// # let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.1; 3]];
    /// let (points, triangles) = hullwright::convex_hull(&points)?.to_single_precision()?;
    /// assert_eq!((points.len(), triangles.len()), (4, 4));
    /// # Ok::<(), hullwright::Error>(())
    /// ```
    pub fn to_single_precision(&self) -> Result<SinglePrecisionHull, Error> {
        single_precision(&self.points, &mut HullBuilder::new())
    }
}

/// The hull of the points rounded to `f32`, with volume and wound outward. Convex up to the
/// tolerance of [`HullBuilder`], which is less than 1e-6 of the diagonal. O(n log n).
///
/// ```
/// use hullwright::hull::{HullBuilder, single_precision};
///
/// # fn main() -> Result<(), hullwright::Error> {
/// let tetrahedron = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.1]];
/// let (points, triangles) = single_precision(&tetrahedron, &mut HullBuilder::new())?;
/// assert_eq!((points.len(), triangles.len()), (4, 4));
/// assert!(points.contains(&[0.0, 0.0, 0.1_f32]));
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`Error::NoHull`] if a coordinate is beyond the range of `f32`, or nothing is left.
pub fn single_precision(
    points: &[[f64; 3]],
    builder: &mut HullBuilder,
) -> Result<SinglePrecisionHull, Error> {
    let mut points = rounded(points)?;
    let largest = points.iter().flatten().fold(0.0f64, |largest, x| largest.max(x.abs()));
    let mut least_thickness = LEAST_ULPS * f64::from(f32::EPSILON) * largest;
    for _ in 0..ATTEMPTS {
        let (solid, _) = solid_hull(builder, &points, [0.0; 3], least_thickness)?;
        points = rounded(&solid.points)?;
        if builder.build(&points) == Shape::Solid {
            let (points, triangles) = builder.extract();
            return Ok((
                points.into_iter().map(|point| point.map(|x| x as f32)).collect(),
                triangles,
            ));
        }
        least_thickness *= 2.0;
    }
    Err(Error::NoHull { reason: "rounding to f32 leaves no volume" })
}

fn rounded(points: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, Error> {
    let round = |point: &[f64; 3]| point.map(|x| f64::from(x as f32));
    let points: Vec<_> = points.iter().map(round).collect();
    if points.iter().flatten().all(|x| x.is_finite()) {
        Ok(points)
    } else {
        Err(Error::NoHull { reason: "a coordinate is beyond the range of f32" })
    }
}
