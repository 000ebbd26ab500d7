//! The edges where a surface ends, and how fast the winding number changes near them.
//!
//! The gradient of the winding number is that of the solid angle of the boundary curve. It is the
//! field of a current along that curve (Biot and Savart): each edge adds at most its length over
//! its squared distance, and at most two over its distance, over 4π. What triangles lie between the
//! edges does not matter, nor how many, nor which way they face. So the sum over the edges bounds
//! the gradient anywhere, but on the surface, where the number jumps.
//!
//! Edges far away count by groups: a sum takes O(log n) typically.
//!
//! Of few edges the winding number itself is known, except for rounding. From a point, an edge that
//! is swept to infinity in a direction is a spherical triangle of the edge's ends and the
//! direction. Its angle jumps where the ray the other way passes the edge, and so do the
//! [crossings](crate::bvh::Bvh::crossings) of that ray with the triangles that end there: together
//! they are the winding number of an open surface. Very near the jump neither is known.

use std::f64::consts::TAU;

use crate::bvh::{Edge, EdgeTree, SLOPES};
use crate::geometry::Turns;
use crate::geometry::vector::Vector;
use crate::mesh::adjacency::SortedHalfEdges;

/// Edges at most, each as often as it counts, whose shares of the winding number are summed up, one
/// by one. The expansion takes as long as a hundred.
const FEW_EDGES: usize = 72;

/// A full solid angle.
const FULL: f64 = 2.0 * TAU;

/// The boundary of a surface. See the module.
#[derive(Default)]
pub(crate) struct Boundary {
    /// Edges that more triangles run along one way than the other, by how many more, over a full
    /// solid angle. `None` if there are none.
    edges: Option<EdgeTree>,
    /// The edges, each as often as it counts, if they are few.
    swept: Option<Vec<SweptEdges>>,
}

impl Boundary {
    /// Indices must be those of positions. O(n log n).
    pub(crate) fn new(positions: &[Vector], triangles: &[[u32; 3]]) -> Self {
        let mut edges = Vec::new();
        let mut repeated = Vec::new();
        SortedHalfEdges::new(triangles, positions.len()).for_each_edge(|edge| {
            let mut unpaired = edge.unpaired(triangles);
            let Some(half_edge) = unpaired.next() else { return };
            let count = 1 + unpaired.count();
            let (corners, k) = (triangles[half_edge as usize / 3], half_edge as usize % 3);
            let ends = [k, (k + 1) % 3].map(|k| positions[corners[k] as usize]);
            if ends[0] != ends[1] {
                edges.push(Edge { ends, weight: count as f64 / FULL });
                // More than a few are never swept.
                repeated.extend((0..count.min(FEW_EDGES + 1 - repeated.len())).map(|_| ends));
            }
        });
        let swept = (repeated.len() <= FEW_EDGES).then(|| SweptEdges::all(&repeated));
        Self { edges: (!edges.is_empty()).then(|| EdgeTree::new(&edges)), swept }
    }

    /// Whether the surface ends nowhere: then the winding number is whole, and changes only across
    /// the surface.
    pub(crate) fn is_empty(&self) -> bool {
        self.edges.is_none()
    }

    /// The winding number about a point of what continues the surface from its boundary to
    /// infinity, the opposite way of [the ray's](crate::bvh::Bvh::crossings): together they are
    /// closed. `None` if that ray hits the boundary, or the edges are many. O(n) for n edges.
    pub(crate) fn winding_number_beyond(&self, point: Vector) -> Option<f64> {
        swept_winding_number(self.swept.as_ref()?, point)
    }

    /// The slope of the winding number at a point; where its gradient is above `limit`, any
    /// gradient above that. `nearest` is a lower bound on the distance to the surface.
    pub(crate) fn slope(&self, point: Vector, nearest: f64, limit: f64) -> Slope {
        let Some(edges) = &self.edges else {
            return Slope { gradient: 0.0, clearance: f64::INFINITY };
        };
        let [gradient, clearance] = edges.slope(point, nearest, limit);
        Slope { gradient, clearance }
    }
}

/// How the winding number changes around a point, as long as the surface is not crossed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slope {
    /// At least the gradient.
    pub gradient: f64,
    /// At most the distance to the boundary.
    clearance: f64,
}

impl Slope {
    /// Over a way of a length the number changes by no more than this. The distance to an edge
    /// falls by no more than the way's length: this is the integral of one over its square.
    pub(crate) fn change(&self, way: f64) -> f64 {
        let left = 1.0 - way / self.clearance;
        if left > 0.0 { self.gradient * way / left } else { f64::INFINITY }
    }

    /// Over any way up to this length the number changes by no more than `change`.
    pub(crate) fn way_within(&self, change: f64) -> f64 {
        // On an edge it is not a number.
        (change / (self.gradient + change / self.clearance)).max(0.0)
    }

    /// The slope at a point that is so far away.
    pub(crate) fn at_distance(&self, way: f64) -> Self {
        let left = (1.0 - way / self.clearance).max(0.0);
        Self { gradient: self.gradient / (left * left), clearance: left * self.clearance }
    }
}

/// Edges at once.
const LANES: usize = 4;

/// An edge that is this near to the ray, in radians, may be on either side of it: far more than
/// rounding.
const ON_RAY: f64 = 1e-9;

/// Where edges that fill up the lanes are behind the ray's start, as a multiple of the ray's
/// direction: their angle is zero.
const FAR_BEHIND: f64 = -1e3;

/// Edges that are swept. Axis by axis.
#[derive(Debug, Clone)]
#[repr(align(64))]
struct SweptEdges {
    start: [[f64; LANES]; 3],
    end: [[f64; LANES]; 3],
}

impl SweptEdges {
    /// Edges from point to point, in lanes.
    fn all(edges: &[[Vector; 2]]) -> Vec<Self> {
        let behind =
            (Vector::new(1.0, SLOPES[0], SLOPES[1]) * FAR_BEHIND).to_array().map(|x| [x; LANES]);
        let mut all: Vec<Self> = Vec::new();
        for (number, [start, end]) in edges.iter().enumerate() {
            if number % LANES == 0 {
                all.push(Self { start: behind, end: behind });
            }
            if let Some(last) = all.last_mut() {
                for axis in 0..3 {
                    last.start[axis][number % LANES] = start[axis];
                    last.end[axis][number % LANES] = end[axis];
                }
            }
        }
        all
    }
}

/// The winding number of swept edges about a point; `None` if the ray hits one. O(n).
fn swept_winding_number(edges: &[SweptEdges], point: Vector) -> Option<f64> {
    let ray = Vector::new(1.0, SLOPES[0], SLOPES[1]);
    let ray_length = ray.length();
    let along = ray * (1.0 / ray_length);
    let mut turns = [Turns::NONE; LANES];
    for edges in edges {
        let (real, imaginary) = half_solid_angles(edges, point, along, 1.0 / ray_length)?;
        for lane in 0..LANES {
            turns[lane].add(real[lane], imaginary[lane]);
            turns[lane].rescale();
        }
    }
    Some(turns.into_iter().fold(Turns::NONE, Turns::joined).total())
}

/// Half the solid angles as the arguments of complex numbers (Van Oosterom and Strackee, "The Solid
/// Angle of a Plane Triangle", 1983); `None` if the ray hits an edge.
#[inline(always)]
fn half_solid_angles(
    edges: &SweptEdges,
    point: Vector,
    along: Vector,
    scale: f64,
) -> Option<([f64; LANES], [f64; LANES])> {
    let (mut real, mut imaginary) = ([0.0; LANES], [0.0; LANES]);
    let mut is_hit = false;
    for lane in 0..LANES {
        let arm =
            |end: &[[f64; LANES]; 3]| Vector::new(end[0][lane], end[1][lane], end[2][lane]) - point;
        let (a, b) = (arm(&edges.start), arm(&edges.end));
        let dot = |a: Vector, b: Vector| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (of_a, of_b) = (dot(a, a).sqrt(), dot(b, b).sqrt());
        let product = of_a * of_b;
        real[lane] = product + dot(a, b) - (dot(a, along) * of_b + dot(b, along) * of_a);
        // As seen along the ray.
        let across = |Vector { x, y, z }: Vector| [y - SLOPES[0] * x, z - SLOPES[1] * x];
        let (a, b) = (across(a), across(b));
        imaginary[lane] = scale * (a[0] * b[1] - a[1] * b[0]);
        let noise = ON_RAY * product;
        is_hit |= (real[lane] <= noise) & (imaginary[lane].abs() <= noise);
    }
    (!is_hit).then_some((real, imaginary))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::grid::ROUNDING;

    /// A sheet of one small square: four edges where the surface ends.
    fn sheet() -> Boundary {
        let corners = [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.01, 0.01, 0.0], [0.0, 0.01, 0.0]]
            .map(Vector::from);
        Boundary::new(&corners, &[[0, 1, 2], [0, 2, 3]])
    }

    fn slope_at(boundary: &Boundary, point: Vector) -> Slope {
        boundary.slope(point, 0.0, f64::INFINITY)
    }

    #[test]
    fn nowhere_within_a_way_is_the_slope_steeper_than_what_is_said_of_it() {
        let boundary = sheet();
        for (from, to) in [
            (Vector::new(0.5, 0.2, 0.1), Vector::ZERO),
            (Vector::new(0.5, 0.2, 0.1), Vector::new(0.5, 0.0, 0.0)),
            (Vector::new(0.02, 0.03, 0.0), Vector::new(0.01, 0.01, 0.0)),
            (Vector::new(-1.0, 0.0, 2.0), Vector::new(0.0, 0.01, 0.0)),
        ] {
            let slope = slope_at(&boundary, from);
            let direction = (to - from).normalize_or_zero();
            for share in [0.01, 0.1, 0.3, 0.5, 0.9] {
                let way = share * slope.clearance;
                let there = slope_at(&boundary, from + direction * way);
                let said = slope.at_distance(way);
                assert!(there.gradient <= said.gradient * (1.0 + ROUNDING), "{from:?} {share}");
                assert!(there.clearance >= said.clearance * (1.0 - ROUNDING), "{from:?} {share}");
            }
        }
    }

    /// A slope of one over the square of the distance, summed up on the way.
    #[test]
    fn the_change_over_a_way_is_the_integral_of_the_slope() {
        const STEPS: usize = 10_000;
        let slope = slope_at(&sheet(), Vector::new(0.5, 0.2, 0.1));
        for share in [0.01, 0.3, 0.9] {
            let way = share * slope.clearance;
            let step = way / STEPS as f64;
            let middles = (0..STEPS).map(|index| (index as f64 + 0.5) * step);
            let sum: f64 = middles.map(|at| slope.at_distance(at).gradient * step).sum();
            assert!((slope.change(way) / sum - 1.0).abs() < 1e-4, "{share}");
            assert!((slope.way_within(slope.change(way)) / way - 1.0).abs() < 1e-12, "{share}");
        }
        assert_eq!(slope.change(slope.clearance), f64::INFINITY);
    }
}
