//! A triangle of a growing hull, and the side of its plane on which a point lies.
//!
//! The side is decided by the floating-point distance where that is certain, and by Shewchuk's
//! adaptive predicate ("Adaptive precision floating-point arithmetic and fast robust geometric
//! predicates", 1997) where it is not. So a hull can never tear or fold, however nearly coplanar
//! its points are.

use robust::{Coord3D, orient3d};

use crate::vector::{Vector, area_normal, dot, length, subtract};

/// No point, face or half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// Rounding errors of a plane's normal, in units of `f64::EPSILON` times the product of the
/// lengths of its edges. The cross product of rounded differences is off by less than 8; the
/// rest is margin.
const NORMAL_ERROR: f64 = 16.0;

/// Rounding errors of a point's distance to a given plane, in units of `f64::EPSILON` times the
/// largest coordinate. Three products and three sums are off by less than 6; the rest is margin.
const DISTANCE_ERROR: f64 = 16.0;

/// One triangle of the hull, its plane, its neighbours, and the points that wait in front of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    /// Unit normal, pointing outward.
    pub normal: Vector,
    /// Distance of the plane from the origin along the normal.
    pub offset: f64,
    /// Below this the sign of a distance is not certain.
    pub error: f64,
    /// Greatest distance of a waiting point.
    pub furthest_distance: f64,
    /// The waiting point at that distance.
    pub furthest: u32,
    /// First of the linked list of waiting points.
    pub waiting: u32,
    /// Counter-clockwise seen from outside.
    pub vertices: [u32; 3],
    /// The same edge in the neighbour: `4 * face + edge`. Edge k runs from vertex k to k + 1.
    pub twins: [u32; 3],
    /// The last insertion that saw this face.
    pub stamp: u32,
    /// The insertion that made this face.
    pub generation: u32,
}

#[inline]
pub(super) fn half_edge(face: u32, edge: u32) -> u32 {
    4 * face + edge
}

#[inline]
pub(super) fn face_of(half_edge: u32) -> u32 {
    half_edge / 4
}

#[inline]
pub(super) fn edge_of(half_edge: u32) -> usize {
    (half_edge % 4) as usize
}

/// A place where there is no face: nothing lies in front of it.
pub(super) const RETIRED: Face = Face {
    normal: [0.0; 3],
    offset: f64::INFINITY,
    error: 0.0,
    furthest_distance: 0.0,
    furthest: NONE,
    waiting: NONE,
    vertices: [NONE; 3],
    twins: [NONE; 3],
    stamp: 0,
    generation: 0,
};

impl Face {
    /// Makes it nothing.
    pub(super) fn retire(&mut self) {
        *self = RETIRED;
    }

    /// A face over three points of `points`, whose coordinates are at most `reach` in size.
    #[inline]
    pub(super) fn new(vertices: [u32; 3], points: &[Vector], reach: f64) -> Self {
        let [a, b, c] = vertices.map(|vertex| points[vertex as usize]);
        let ab = subtract(b, a);
        let ac = subtract(c, a);
        let normal = area_normal(a, b, c);
        let doubled_area = length(normal);
        let inverse = if doubled_area > 0.0 { 1.0 / doubled_area } else { 0.0 };
        let normal = [normal[0] * inverse, normal[1] * inverse, normal[2] * inverse];
        // |ab| |ac| is bounded by the mean of the squares, which saves two roots.
        let edges = 0.5 * (dot(ab, ab) + dot(ac, ac));
        let error = f64::EPSILON * reach * (NORMAL_ERROR * edges * inverse + DISTANCE_ERROR);
        Self {
            normal,
            offset: dot(normal, a),
            // Without area there is no plane, and only the exact predicate may speak.
            error: if doubled_area > 0.0 { error } else { f64::INFINITY },
            furthest_distance: 0.0,
            furthest: NONE,
            waiting: NONE,
            vertices,
            twins: [NONE; 3],
            stamp: 0,
            generation: 0,
        }
    }

    /// Distance of a point in front of the plane; negative behind it.
    #[inline]
    pub(super) fn distance(&self, point: Vector) -> f64 {
        dot(self.normal, point) - self.offset
    }

    /// Whether the point lies strictly in front of the plane, decided exactly.
    #[inline]
    pub(super) fn sees(&self, point: Vector, points: &[Vector]) -> bool {
        let distance = self.distance(point);
        if distance > self.error {
            true
        } else if distance < -self.error {
            false
        } else {
            is_in_front(self.vertices.map(|vertex| points[vertex as usize]), point)
        }
    }
}

/// Whether a point lies strictly on the outer side of a counter-clockwise triangle, exactly.
#[cold]
pub(super) fn is_in_front([a, b, c]: [Vector; 3], point: Vector) -> bool {
    let coordinates = |[x, y, z]: Vector| Coord3D { x, y, z };
    // Shewchuk's sign is positive for points below.
    orient3d(coordinates(a), coordinates(b), coordinates(c), coordinates(point)) < 0.0
}
