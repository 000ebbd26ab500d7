//! A triangle of a growing hull, and the side of its plane on which a point lies.
//!
//! The side is decided by the floating-point determinant where that is certain, and by Shewchuk's
//! adaptive predicate ("Adaptive precision floating-point arithmetic and fast robust geometric
//! predicates", 1997) where it is not. So a hull can never tear or fold, however nearly coplanar
//! its points are.

use robust::{Coord3D, orient3d};

use crate::geometry::vector::{Vector, cross, dot, length_squared, scale, subtract};

/// No point, face or half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// Rounding errors of a face's height, in units of `f64::EPSILON` times the largest coordinate
/// times the product of the lengths of the two edges that the normal is made of. The normal
/// contributes less than 12, the two scalar products and their difference less than 7, moving the
/// face's corner and the point to the centre less than 2; the rest is margin.
const HEIGHT_ERROR: f64 = 32.0;

/// The square of the longest edge between points whose coordinates are at most 1.
const LONGEST_SQUARED: f64 = 12.0;

/// A point this far behind a face, as a share of the extent, is certainly not in front of it.
/// Closer ones are kept until all faces are known.
pub(super) const CERTAINLY_BEHIND: f64 = 1e-12;

/// An edge between a face that a new point sees and one that it does not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Horizon {
    pub start: u32,
    pub end: u32,
    /// The edge in the face that stays.
    pub outside: u32,
}

/// The plane of a face.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    /// Points outward; as long as twice the area of the face.
    pub normal: Vector,
    /// The plane's points have this scalar product with the normal.
    pub offset: f64,
}

/// One triangle of the hull, its plane and its neighbours. It fills a line of the cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Face {
    pub plane: Plane,
    /// One over the length of the normal, 0 for a face without area. Not known before the hull
    /// has stopped growing.
    pub inverse: f64,
    /// Counter-clockwise seen from outside.
    pub vertices: [u32; 3],
    /// The same edge in the neighbour: `4 * face + edge`. Edge k runs from vertex k to k + 1.
    pub twins: [u32; 3],
}

/// What goes on at a face while a hull grows: kept apart, so that questions read less memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    /// Height of the point `furthest`.
    pub height: f64,
    /// The highest of the waiting points that are farther out than the tolerance.
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
        Self { height: 0.0, furthest: NONE, first: NONE, stamp, generation }
    }
}

/// Bounds on heights that spare most questions about the distance, which takes a root.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Heights {
    /// Largest coordinate of a point.
    pub reach: f64,
    /// Square of the tolerance.
    squared_tolerance: f64,
    /// Bound on the rounding error of any height.
    pub error: f64,
    /// Who is higher over any face is certainly in front of it by more than the tolerance.
    pub high: f64,
    /// Who is lower over any face is certainly behind it.
    pub low: f64,
}

impl Heights {
    /// For points whose coordinates are at most `reach` in size.
    pub(super) fn new(reach: f64, tolerance: f64) -> Self {
        let longest_normal = LONGEST_SQUARED * reach * reach;
        let error = f64::EPSILON * HEIGHT_ERROR * reach * longest_normal;
        Self {
            reach,
            squared_tolerance: tolerance * tolerance,
            error,
            high: error.max(tolerance * longest_normal),
            low: -error.max(CERTAINLY_BEHIND * longest_normal),
        }
    }

    /// Whether a height over a face is a distance of more than the tolerance.
    #[inline]
    pub(super) fn is_beyond(&self, height: f64, plane: &Plane) -> bool {
        height > self.high || self.is_farther(height, plane, self.squared_tolerance)
    }

    /// Whether a height over a face is a distance of more than what can be told from none.
    #[inline]
    pub(super) fn is_in_front(&self, height: f64, plane: &Plane) -> bool {
        self.is_farther(height, plane, CERTAINLY_BEHIND * CERTAINLY_BEHIND)
    }

    /// Whether a height over a face is not a distance behind it, as far as that can be told from none.
    #[inline]
    pub(super) fn is_not_behind(&self, height: f64, plane: &Plane) -> bool {
        self.is_farther(height, plane, -CERTAINLY_BEHIND * CERTAINLY_BEHIND)
    }

    #[inline]
    fn is_farther(&self, height: f64, plane: &Plane, squared_distance: f64) -> bool {
        height * height.abs() > squared_distance * length_squared(plane.normal)
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
    plane: Plane { normal: [0.0; 3], offset: f64::INFINITY },
    inverse: 0.0,
    vertices: [NONE; 3],
    twins: [NONE; 3],
};

impl Plane {
    /// Six times the volume of the tetrahedron between the face and a point: positive in front of
    /// the plane, and the distance to it times the doubled area.
    #[inline]
    pub(super) fn height(&self, point: Vector) -> f64 {
        let [x, y, z] = self.normal;
        // In pairs as they were written: a processor waits for what it has not yet written.
        (x * point[0] + y * point[1]) + (z * point[2] - self.offset)
    }
}

impl Face {
    /// A face, without neighbours, from the edges that lead from its last vertex to the first and
    /// the second.
    #[inline]
    pub(super) fn spanned(vertices: [u32; 3], [a, b]: [Vector; 2], last: Vector) -> Self {
        let normal = cross(a, b);
        let plane = Plane { normal, offset: dot(normal, last) };
        Self { plane, inverse: 0.0, vertices, twins: [NONE; 3] }
    }

    /// Distance of a point in front of the plane, negative behind it, once the hull has stopped
    /// growing.
    #[inline]
    pub(super) fn distance(&self, point: Vector) -> f64 {
        self.plane.height(point) * self.inverse
    }

    /// Whether a point, with its height over the plane, lies strictly in front of it, decided
    /// exactly for the points as they were given.
    pub(super) fn sees(&self, point: u32, height: f64, given: Given, heights: Heights) -> bool {
        let [a, b, c] = self.vertices;
        // The product of the edges' lengths is bounded by the mean of the squares, without roots.
        let [first, second] = [a, b].map(|end| length_squared(given.edge(c, end)));
        let error = f64::EPSILON * HEIGHT_ERROR * heights.reach * 0.5 * (first + second);
        if height > error {
            true
        } else if height < -error {
            false
        } else {
            given.is_in_front(self.vertices, point)
        }
    }
}

/// The points as they were given, with the power of two that brings them near 1.
///
/// Moving them to their centre too rounds them, by next to nothing, but that is more than a
/// triangle that is a billion times smaller than the hull can bear: what a face's direction and
/// the exact answers depend on is taken from here.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given<'a> {
    pub points: &'a [Vector],
    pub factor: f64,
}

impl Given<'_> {
    /// From one point to another, in the scaled space.
    #[inline]
    pub(super) fn edge(&self, start: u32, end: u32) -> Vector {
        subtract(self.scaled(end), self.scaled(start))
    }

    /// A point in the scaled space, but for the move to the centre: rounded by nothing.
    #[inline]
    fn scaled(&self, point: u32) -> Vector {
        scale(self.points[point as usize], self.factor)
    }

    /// Whether a point lies strictly on the outer side of a counter-clockwise triangle, exactly.
    #[cold]
    pub(super) fn is_in_front(&self, triangle: [u32; 3], point: u32) -> bool {
        self.orientation(triangle, point) < 0.0
    }

    /// Whether four points don't lie in a plane, exactly.
    pub(super) fn span_a_volume(&self, [a, b, c, d]: [u32; 4]) -> bool {
        self.orientation([a, b, c], d) != 0.0
    }

    /// Negative for a point in front of a counter-clockwise triangle, 0 in its plane, exactly.
    fn orientation(&self, [a, b, c]: [u32; 3], point: u32) -> f64 {
        let corner = |index: u32| {
            let [x, y, z] = self.scaled(index);
            Coord3D { x, y, z }
        };
        orient3d(corner(a), corner(b), corner(c), corner(point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{add, length};

    /// Planes of triangles of any size and direction, and a point of each.
    fn planes() -> impl Iterator<Item = (Plane, Vector)> {
        let corners = [[0.3, -0.2, 0.1], [-0.4, 0.5, 0.2], [0.1, 0.3, -0.6]];
        [1.0, 0.1, 1e-3].into_iter().flat_map(move |size| {
            (0..3).map(move |turn| {
                let [a, b, c] = [0, 1, 2].map(|k| scale(corners[(k + turn) % 3], size));
                let face = Face::spanned([0, 1, 2], [subtract(a, c), subtract(b, c)], c);
                (face.plane, c)
            })
        })
    }

    #[test]
    fn heights_are_compared_with_distances() {
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let heights = Heights::new(1.0, tolerance);
            for (plane, on_it) in planes() {
                let unit = scale(plane.normal, 1.0 / length(plane.normal));
                let height_at = |distance: f64| plane.height(add(on_it, scale(unit, distance)));
                for share in [-10.0, -1.0, 0.0, 0.9, 1.1, 10.0] {
                    let is_beyond = heights.is_beyond(height_at(share * tolerance), &plane);
                    assert_eq!(is_beyond, share > 1.0, "{share} tolerances of {tolerance}");
                }
                // Not by way of a point: its coordinates are rounded by more than this.
                let height_of = |distance: f64| distance * length(plane.normal);
                for share in [-10.0, -1.1, -0.9, 0.0, 0.9, 1.1, 10.0] {
                    let height = height_of(share * CERTAINLY_BEHIND);
                    assert_eq!(heights.is_in_front(height, &plane), share > 1.0, "{share}");
                    assert_eq!(heights.is_not_behind(height, &plane), share > -1.0, "{share}");
                }
            }
        }
    }

    #[test]
    fn heights_beyond_those_that_spare_questions_need_none() {
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let heights = Heights::new(1.0, tolerance);
            assert!(heights.error < heights.high && heights.error < -heights.low);
            for (plane, _) in planes() {
                let distance = |height: f64| height / length(plane.normal);
                assert!(distance(heights.high) > tolerance);
                assert!(distance(heights.low) < -CERTAINLY_BEHIND);
            }
            // Not much larger than the longest normal asks for.
            assert!(heights.high < 100.0 * tolerance && heights.error < 1e-12);
        }
    }
}
