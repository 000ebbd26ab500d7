//! A convex polyhedron, and the convex hull of a set of points.

use super::builder::HullBuilder;
use super::point_set::Shape;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::error::Error;
use crate::geometry::vector::{Vector, area_normal, as_vectors, bounds};
use crate::geometry::{Bounds, MeshView};

/// A closed convex polyhedron of triangles, wound counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Default)]
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
        planes.map(|(normal, offset)| (normal.to_array(), offset)).collect()
    }

    /// The same, with vectors.
    pub(crate) fn face_planes(&self) -> Vec<(Vector, f64)> {
        let plane = |[a, b, c]: [Vector; 3]| {
            let normal = area_normal(a, b, c);
            let area = normal.length();
            if area > 0.0 {
                let normal = normal * (1.0 / area);
                (normal, normal.dot(a))
            } else {
                (Vector::ZERO, 0.0)
            }
        };
        self.faces().map(plane).collect()
    }

    /// Distance of a point to the hull, 0 inside. `planes` are the hull's. O(triangles).
    pub(super) fn distance_outside(&self, planes: &[(Vector, f64)], point: Vector) -> f64 {
        // The nearest point is on a face that the point is in front of.
        let visible = self.faces().zip(planes).filter(|(_, plane)| plane.0.dot(point) > plane.1);
        let distances = visible.map(|(corners, _)| {
            let [a, b, c] = corners.map(|corner| corner - point);
            closest_point_on_triangle(a, b, c).length()
        });
        distances.min_by(f64::total_cmp).unwrap_or(0.0)
    }

    /// Whether no vertex of another hull is in front of a face, up to the rounding of tests.
    #[cfg(test)]
    pub(super) fn holds(&self, other: &Self) -> bool {
        self.face_planes().iter().all(|&(normal, offset)| {
            other.points().iter().all(|&point| normal.dot(point) - offset <= 1e-9)
        })
    }
}
