//! The winding number of edges that are swept to infinity, four at once.
//!
//! From a point, an edge that moves to infinity in a direction is a spherical triangle of the edge's ends and the
//! direction. Its angle jumps where the ray the other way passes the edge, and so do the
//! [crossings](crate::bvh::Bvh::crossings) of that ray with the triangles that end there: together they are the
//! winding number of an open surface, exact but for rounding. Very near the jump neither is known.

use crate::bvh::SLOPES;
use crate::geometry::Turns;
use crate::geometry::vector::{Vector, length, scale};

/// Edges at once.
pub(super) const LANES: usize = 4;

/// An edge that is this near to the ray, in radians, may be on either side of it: far more than rounding.
const ON_RAY: f64 = 1e-9;

/// Where edges that fill up the lanes are, in lengths of the ray, behind the ray's start: their angle is zero.
const FAR_BEHIND: f64 = -1e3;

/// Edges that are swept. Axis by axis.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct SweptEdges {
    start: [[f64; LANES]; 3],
    end: [[f64; LANES]; 3],
}

impl SweptEdges {
    /// Edges from point to point, in lanes.
    pub(super) fn all(edges: impl Iterator<Item = (Vector, Vector)>) -> Vec<Self> {
        let behind = scale([1.0, SLOPES[0], SLOPES[1]], FAR_BEHIND).map(|x| [x; LANES]);
        let mut all: Vec<Self> = Vec::new();
        for (number, (start, end)) in edges.enumerate() {
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

/// The winding number of edges about a point; `None` if the ray hits one. O(n).
pub(super) fn winding_number(edges: &[SweptEdges], point: Vector) -> Option<f64> {
    let ray = [1.0, SLOPES[0], SLOPES[1]];
    let ray_length = length(ray);
    let along = scale(ray, 1.0 / ray_length);
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

/// Half the solid angles as the arguments of complex numbers (Van Oosterom and Strackee, "The Solid Angle of a Plane
/// Triangle", 1983); `None` if the ray hits an edge.
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
        let arm = |end: &[[f64; LANES]; 3]| [0, 1, 2].map(|axis| end[axis][lane] - point[axis]);
        let (a, b) = (arm(&edges.start), arm(&edges.end));
        let dot = |a: Vector, b: Vector| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (of_a, of_b) = (dot(a, a).sqrt(), dot(b, b).sqrt());
        let product = of_a * of_b;
        real[lane] = product + dot(a, b) - (dot(a, along) * of_b + dot(b, along) * of_a);
        // As seen along the ray.
        let across = |[x, y, z]: Vector| [y - SLOPES[0] * x, z - SLOPES[1] * x];
        let (a, b) = (across(a), across(b));
        imaginary[lane] = scale * (a[0] * b[1] - a[1] * b[0]);
        let noise = ON_RAY * product;
        is_hit |= (real[lane] <= noise) & (imaginary[lane].abs() <= noise);
    }
    (!is_hit).then_some((real, imaginary))
}
