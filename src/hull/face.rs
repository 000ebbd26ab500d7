//! A triangle of a growing hull, and the side of its plane on which a point lies.
//!
//! The side is decided by the floating-point determinant where that is certain, and by Shewchuk's
//! adaptive predicate ("Adaptive precision floating-point arithmetic and fast robust geometric
//! predicates", 1997) where it is not. So a hull can never tear or fold, however nearly coplanar
//! its points are.

use robust::{Coord3D, orient3d};

use crate::vector::{Vector, cross, dot, length, length_squared, subtract};

/// No point, face or half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// Rounding errors of a face's height, in units of `f64::EPSILON` times the largest coordinate
/// times the product of the lengths of the two edges that the normal is made of. The normal
/// contributes less than 12, the two scalar products and their difference less than 7; the rest
/// is margin.
const HEIGHT_ERROR: f64 = 32.0;

/// The square of the longest edge between points whose coordinates are at most 1.
const LONGEST_SQUARED: f64 = 12.0;

/// One triangle of the hull, its plane and its neighbours. It fills a line of the cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Face {
    /// Points outward; as long as twice the area.
    pub normal: Vector,
    /// The plane's points have this scalar product with the normal.
    pub offset: f64,
    /// One over the length of the normal, 0 for a face without area.
    pub inverse: f64,
    /// Counter-clockwise seen from outside.
    pub vertices: [u32; 3],
    /// The same edge in the neighbour: `4 * face + edge`. Edge k runs from vertex k to k + 1.
    pub twins: [u32; 3],
}

/// What goes on at a face: kept apart, so that looking for faces reads less memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    /// Greatest distance of a waiting point.
    pub distance: f64,
    /// The waiting point at that distance.
    pub furthest: u32,
    /// First of the linked list of waiting points.
    pub first: u32,
    /// The last search that met this face.
    pub stamp: u32,
    /// The insertion that made this face.
    pub generation: u32,
}

impl Waiting {
    /// Nobody waits.
    #[inline]
    pub(super) fn none(stamp: u32, generation: u32) -> Self {
        Self { distance: 0.0, furthest: NONE, first: NONE, stamp, generation }
    }
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

/// The edge after one in the same face.
#[inline]
pub(super) fn after(edge: usize) -> usize {
    if edge >= 2 { 0 } else { edge + 1 }
}

/// The edge before one in the same face.
#[inline]
pub(super) fn before(edge: usize) -> usize {
    if edge == 0 { 2 } else { edge - 1 }
}

/// A place where there is no face: nothing lies in front of it.
pub(super) const RETIRED: Face = Face {
    normal: [0.0; 3],
    offset: f64::INFINITY,
    inverse: 1.0,
    vertices: [NONE; 3],
    twins: [NONE; 3],
};

/// A bound on the rounding error of the height of any point over any face, if no coordinate is
/// larger than `reach`.
#[inline]
pub(super) fn height_error(reach: f64) -> f64 {
    f64::EPSILON * HEIGHT_ERROR * reach * (LONGEST_SQUARED * reach * reach)
}

impl Face {
    /// A face over three points of `points`, without neighbours.
    pub(super) fn new(vertices: [u32; 3], points: &[Vector]) -> Self {
        let [a, b, c] = vertices.map(|vertex| points[vertex as usize]);
        Self::spanned(vertices, subtract(a, c), subtract(b, c), c)
    }

    /// The same, from the edges that lead from the last vertex to the first and the second.
    #[inline]
    pub(super) fn spanned(vertices: [u32; 3], a: Vector, b: Vector, last: Vector) -> Self {
        let normal = cross(a, b);
        let doubled_area = length(normal);
        Self {
            normal,
            offset: dot(normal, last),
            inverse: if doubled_area > 0.0 { 1.0 / doubled_area } else { 0.0 },
            vertices,
            twins: [NONE; 3],
        }
    }

    /// Six times the volume of the tetrahedron between the face and a point: positive in front of
    /// the plane, and the distance to it times the doubled area.
    #[inline]
    pub(super) fn height(&self, point: Vector) -> f64 {
        dot(self.normal, point) - self.offset
    }

    /// Distance of a point in front of the plane; negative behind it.
    #[inline]
    pub(super) fn distance(&self, point: Vector) -> f64 {
        self.height(point) * self.inverse
    }

    /// Whether the point lies strictly in front of the plane, decided exactly. No coordinate is
    /// larger than `reach`.
    pub(super) fn sees(&self, point: Vector, points: &[Vector], reach: f64) -> bool {
        let corners = self.vertices.map(|vertex| points[vertex as usize]);
        let [a, b, c] = corners;
        // The product of the edges' lengths is bounded by the mean of the squares, without roots.
        let edges = 0.5 * (length_squared(subtract(a, c)) + length_squared(subtract(b, c)));
        let error = f64::EPSILON * HEIGHT_ERROR * reach * edges;
        let height = self.height(point);
        if height > error {
            true
        } else if height < -error {
            false
        } else {
            is_in_front(corners, point)
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
