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
