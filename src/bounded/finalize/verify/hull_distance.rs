//! How far points are outside a hull.

use std::sync::OnceLock;

use crate::bvh::Bvh;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::geometry::vector::{Vector, dot, length, subtract};
use crate::hull::ConvexHull;

/// A point less in front of every face than this, in diagonals, is in the hull: the rounding of
/// heights over planes in double precision, with a margin.
pub(super) const ROUNDING: f64 = 1e-9;

/// The plane of a face.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    normal: Vector,
    offset: f64,
    face: u32,
}

impl Plane {
    #[inline]
    pub(super) fn height(&self, point: Vector) -> f64 {
        dot(self.normal, point) - self.offset
    }
}

/// Distances to a hull.
pub(in crate::bounded) struct HullDistance<'a> {
    hull: &'a ConvexHull,
    pub(super) planes: Vec<Plane>,
    /// Built on demand: most hulls never need it.
    bvh: OnceLock<Bvh>,
}

impl<'a> HullDistance<'a> {
    pub(in crate::bounded) fn new(hull: &'a ConvexHull) -> Self {
        let planes = (0..).zip(hull.planes());
        let planes = planes.map(|(face, (normal, offset))| Plane { normal, offset, face });
        Self { hull, planes: planes.collect(), bvh: OnceLock::new() }
    }

    /// The distance from a point to the hull, 0 inside. If it exceeds `limit`, any value above
    /// `limit` may be returned.
    pub(super) fn distance(&self, point: Vector, limit: f64) -> f64 {
        self.distance_by(&self.planes, point, limit)
    }

    /// The same for a point that is behind all planes except some of `planes`.
    pub(super) fn distance_by(&self, planes: &[Plane], point: Vector, limit: f64) -> f64 {
        let (mut beyond, mut face) = (f64::NEG_INFINITY, 0);
        for plane in planes {
            let height = plane.height(point);
            if height > beyond {
                (beyond, face) = (height, plane.face);
            }
        }
        if beyond > limit {
            return beyond;
        }
        if beyond <= ROUNDING {
            return 0.0;
        }
        // Above a face and not beyond its edges, that face is the closest part of the hull.
        let corners = self.hull.triangles[face as usize];
        let [a, b, c] = corners.map(|corner| subtract(self.hull.points[corner as usize], point));
        let to_face = length(closest_point_on_triangle(a, b, c));
        if to_face <= beyond + ROUNDING {
            return to_face;
        }
        let bvh = self.bvh.get_or_init(|| Bvh::new(&self.hull.points, &self.hull.triangles));
        bvh.closest_point(point, f64::INFINITY).map_or(beyond, |closest| closest.distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::convex_hull;
    use crate::mesh::shapes::cuboid;

    fn cube() -> ConvexHull {
        convex_hull(&cuboid([0.0; 3], [1.0; 3]).positions).unwrap()
    }

    #[test]
    fn beyond_an_edge_the_distance_is_to_the_edge_and_beyond_a_corner_to_the_corner() {
        let cube = cube();
        let to_cube = HullDistance::new(&cube);
        for (point, expected) in [
            ([0.5; 3], 0.0),
            ([0.2, 0.7, 1.0], 0.0),
            ([0.2, 0.7, 1.25], 0.25),
            ([1.3, 1.4, 0.5], 0.5),
            ([1.2, -0.4, 1.4], 0.6),
        ] {
            for limit in [expected + 1e-9, 1.0, f64::INFINITY] {
                let found = to_cube.distance(point, limit);
                assert!((found - expected).abs() < 1e-12, "{point:?}: {found}");
            }
        }
    }

    #[test]
    fn what_is_farther_than_the_limit_is_told_to_be() {
        let cube = cube();
        let to_cube = HullDistance::new(&cube);
        // A quarter above two faces, and 0.35 from their edge.
        for limit in [0.0, 0.1, 0.25, 0.3, 0.35] {
            assert!(to_cube.distance([1.25, 1.25, 0.5], limit) > limit, "{limit}");
        }
    }
}
