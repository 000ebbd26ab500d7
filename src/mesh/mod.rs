//! The input as the pipeline works on it: repaired, normalised, simplified.

use crate::Repairs;
use crate::vector::{Vector, add, scale, subtract};

/// Vertices and triangles that index them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct TriangleMesh {
    pub positions: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
}

/// The map between the input's units and the space that the pipeline works in, where the bounding
/// box is centred at the origin and its diagonal is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Normalization {
    pub centre: Vector,
    pub diagonal: f64,
}

impl Normalization {
    pub(crate) fn normalize(&self, point: Vector) -> Vector {
        scale(subtract(point, self.centre), 1.0 / self.diagonal)
    }

    pub(crate) fn restore(&self, point: Vector) -> Vector {
        add(scale(point, self.diagonal), self.centre)
    }
}

/// What repair hands to the stages after it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PreparedMesh {
    /// Welded, oriented, and normalised.
    pub mesh: TriangleMesh,
    pub normalization: Normalization,
    /// For each triangle its index in the input.
    pub source_triangles: Vec<u32>,
    /// For each triangle its connected component (over shared edges).
    pub components: Vec<u32>,
    /// For each component whether it has neither open nor non-manifold edges.
    pub closed: Vec<bool>,
    pub repairs: Repairs,
}
