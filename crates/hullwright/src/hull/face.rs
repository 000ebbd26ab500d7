//! A triangle of a growing hull, and the side of its plane on which a point lies.
//!
//! The floating-point determinant decides where it is certain, Shewchuk's adaptive predicate
//! ("Adaptive precision floating-point arithmetic and fast robust geometric predicates", 1997)
//! elsewhere. So a hull can never tear or fold, however nearly coplanar its points are.

use robust::{Coord3D, orient3d};

use crate::geometry::vector::{Vector, as_arrays};

/// No point, face or half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// The plane of a face.
#[derive(Debug, Clone, Copy)]
pub(super) struct FacePlane {
    /// Points outward; as long as twice the area of the face.
    pub normal: Vector,
    /// The plane's points have this scalar product with the normal.
    pub offset: f64,
}

impl FacePlane {
    /// Six times the volume of the tetrahedron between the face and a point: positive in front of
    /// the plane, and the distance to it times the doubled area.
    #[inline]
    pub(super) fn height(&self, point: Vector) -> f64 {
        let [x, y, z] = self.normal.to_array();
        // Loads the fields in the pairs in which they were stored, so that stores are forwarded.
        (x * point[0] + y * point[1]) + (z * point[2] - self.offset)
    }
}

/// One triangle of the hull, its plane and its neighbours. It fills a cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Face {
    pub plane: FacePlane,
    /// One over the length of the normal, 0 for a face without area. Set when the hull has stopped
    /// growing.
    pub inverse: f64,
    /// Counter-clockwise seen from outside.
    pub vertices: [u32; 3],
    /// The same edge in the neighbour, a half-edge `4 * face + edge`. Edge k runs from vertex k to
    /// k + 1.
    pub twins: [u32; 3],
}

impl Face {
    /// A place without a face: no point lies in front of it.
    pub(super) const RETIRED: Self = Self {
        plane: FacePlane { normal: Vector::ZERO, offset: f64::INFINITY },
        inverse: 0.0,
        vertices: [NONE; 3],
        twins: [NONE; 3],
    };

    /// A face, without neighbours, from the edges that lead from its last vertex to the first and
    /// the second.
    #[inline]
    pub(super) fn spanned(vertices: [u32; 3], [a, b]: [Vector; 2], last: Vector) -> Self {
        let normal = a.cross(b);
        let plane = FacePlane { normal, offset: normal.dot(last) };
        Self { plane, inverse: 0.0, vertices, twins: [NONE; 3] }
    }

    /// Distance of a point in front of the plane, negative behind it, once the hull has stopped
    /// growing.
    #[inline]
    pub(super) fn distance(&self, point: Vector) -> f64 {
        self.plane.height(point) * self.inverse
    }

    /// Whether the face is visible from a point at `height` over it: exact for the points as given,
    /// of which `largest` is the largest coordinate.
    pub(super) fn is_visible(
        &self,
        eye: u32,
        height: f64,
        given: GivenPoints,
        largest: f64,
    ) -> bool {
        let [a, b, c] = self.vertices;
        // The product of the edges' lengths is bounded by the mean of the squares, without roots.
        let [first, second] = [a, b].map(|end| given.edge(c, end).length_squared());
        let error = f64::EPSILON * HEIGHT_ERROR * largest * 0.5 * (first + second);
        if height > error {
            true
        } else if height < -error {
            false
        } else {
            given.is_in_front(self.vertices, eye)
        }
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

/// The next edge of the same face.
#[inline]
pub(super) fn after(edge: usize) -> usize {
    if edge >= 2 { 0 } else { edge + 1 }
}

/// The previous edge of the same face.
#[inline]
pub(super) fn before(edge: usize) -> usize {
    if edge == 0 { 2 } else { edge - 1 }
}

/// Rounding errors of a face's height, in units of `f64::EPSILON` times the largest coordinate
/// times the product of the lengths of the two edges that span the normal. The normal contributes
/// less than 12, the two scalar products and their difference less than 7, moving the face's corner
/// and the point to the centre less than 2; the rest is margin.
const HEIGHT_ERROR: f64 = 32.0;

/// The square of the longest edge between points whose coordinates are at most 1.
const LONGEST_SQUARED: f64 = 12.0;

/// A point this far behind a face, as a fraction of the extent, is certainly not in front of it.
/// Closer ones are kept until all faces are known.
pub(super) const CERTAINLY_BEHIND: f64 = 1e-12;

/// Heights over any face beyond which a side is certain. They spare most distances, which take a
/// root.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Margins {
    /// Largest coordinate of a point.
    pub largest: f64,
    /// Square of the tolerance.
    squared_tolerance: f64,
    /// Bound on the rounding error of any height.
    pub error: f64,
    /// A higher point is certainly in front of the face by more than the tolerance.
    pub high: f64,
    /// A lower point is certainly behind the face.
    pub low: f64,
}

impl Margins {
    /// For points whose coordinates are at most `largest` in size.
    fn new(largest: f64, tolerance: f64) -> Self {
        let longest_normal = LONGEST_SQUARED * largest * largest;
        let error = f64::EPSILON * HEIGHT_ERROR * largest * longest_normal;
        Self {
            largest,
            squared_tolerance: tolerance * tolerance,
            error,
            high: error.max(tolerance * longest_normal),
            low: -error.max(CERTAINLY_BEHIND * longest_normal),
        }
    }

    /// For more points.
    pub(super) fn including(self, points: &[Vector], tolerance: f64) -> Self {
        let larger = |largest: f64, x: &f64| largest.max(x.abs());
        Self::new(as_arrays(points).as_flattened().iter().fold(self.largest, larger), tolerance)
    }

    /// Whether a height over a face is a distance of more than the tolerance.
    #[inline]
    pub(super) fn is_beyond(&self, height: f64, plane: &FacePlane) -> bool {
        height > self.high || is_farther(height, plane, self.squared_tolerance)
    }
}

/// Whether a height over a face is a distance that differs from none.
#[inline]
pub(super) fn is_in_front(height: f64, plane: &FacePlane) -> bool {
    is_farther(height, plane, CERTAINLY_BEHIND * CERTAINLY_BEHIND)
}

/// Whether a height over a face is no distance behind it that differs from none.
#[inline]
pub(super) fn is_not_behind(height: f64, plane: &FacePlane) -> bool {
    is_farther(height, plane, -CERTAINLY_BEHIND * CERTAINLY_BEHIND)
}

#[inline]
fn is_farther(height: f64, plane: &FacePlane, squared_distance: f64) -> bool {
    height * height.abs() > squared_distance * plane.normal.length_squared()
}

/// The points as given, with the power of two that brings them near 1.
///
/// Moving points to their centre rounds them, by next to nothing, but by more than a triangle that
/// is a billion times smaller than the hull can bear. So normals and exact predicates use these.
#[derive(Debug, Clone, Copy)]
pub(super) struct GivenPoints<'a> {
    pub points: &'a [Vector],
    pub factor: f64,
}

impl GivenPoints<'_> {
    /// From one point to another.
    #[inline]
    pub(super) fn edge(&self, start: u32, end: u32) -> Vector {
        self.scaled(end) - self.scaled(start)
    }

    /// Exact: scaling by a power of two rounds nothing.
    #[inline]
    fn scaled(&self, point: u32) -> Vector {
        self.points[point as usize] * self.factor
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
            let [x, y, z] = self.scaled(index).to_array();
            Coord3D { x, y, z }
        };
        orient3d(corner(a), corner(b), corner(c), corner(point))
    }
}

/// One over the root of a number that is not negative; 0 for next to nothing.
///
/// Newton's method from a guess that halves and negates the exponent (Lomont, "Fast inverse square
/// root", 2003): it vectorises and pipelines, which roots and divisions hardly do.
#[inline]
pub(super) fn inverse_root(number: f64) -> f64 {
    /// Lomont's constant for double precision.
    const GUESS: u64 = 0x5FE6_EC85_E7DE_30DA;
    /// The guess is good to 4 bits and more, and each step doubles that.
    const STEPS: usize = 4;
    let mut root = f64::from_bits(GUESS.wrapping_sub(number.to_bits() >> 1));
    for _ in 0..STEPS {
        root *= 1.5 - 0.5 * number * root * root;
    }
    if number > f64::MIN_POSITIVE { root } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Planes of triangles of any size and direction, and a point of each.
    fn planes() -> impl Iterator<Item = (FacePlane, Vector)> {
        let corners = [[0.3, -0.2, 0.1], [-0.4, 0.5, 0.2], [0.1, 0.3, -0.6]].map(Vector::from);
        [1.0, 0.1, 1e-3].into_iter().flat_map(move |size| {
            (0..3).map(move |turn| {
                let [a, b, c] = [0, 1, 2].map(|k| corners[(k + turn) % 3] * size);
                let face = Face::spanned([0, 1, 2], [a - c, b - c], c);
                (face.plane, c)
            })
        })
    }

    #[test]
    fn heights_are_compared_with_distances() {
        for tolerance in [1e-3, 1e-6, 1e-9] {
            let margins = Margins::new(1.0, tolerance);
            assert!(margins.error < margins.high && margins.error < -margins.low);
            // Not much larger than the longest normal requires.
            assert!(margins.high < 100.0 * tolerance && margins.error < 1e-12);
            for (plane, on_it) in planes() {
                let area = plane.normal.length();
                assert!(margins.high / area > tolerance && margins.low / area < -CERTAINLY_BEHIND);
                let unit = plane.normal * (1.0 / area);
                let height_at = |distance: f64| plane.height(on_it + unit * distance);
                for share in [-10.0, -1.0, 0.0, 0.9, 1.1, 10.0] {
                    let is_beyond = margins.is_beyond(height_at(share * tolerance), &plane);
                    assert_eq!(is_beyond, share > 1.0, "{share} tolerances of {tolerance}");
                }
                // Not by way of a point: its coordinates are rounded by more than this.
                for share in [-10.0, -1.1, -0.9, 0.0, 0.9, 1.1, 10.0] {
                    let height = share * CERTAINLY_BEHIND * area;
                    assert_eq!(is_in_front(height, &plane), share > 1.0, "{share}");
                    assert_eq!(is_not_behind(height, &plane), share > -1.0, "{share}");
                }
            }
        }
    }
}
