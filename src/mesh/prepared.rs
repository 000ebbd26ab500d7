//! A repaired mesh, as all stages after repair take it.

use std::borrow::Cow;

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, bounds};

/// Stands in [`PreparedMesh::source_triangles`] for a triangle that closes an opening.
pub(crate) const CAP: u32 = u32::MAX;

/// The same for one within the solid.
pub(crate) const HIDDEN_CAP: u32 = u32::MAX - 1;

/// The map between the input's units and the space that the pipeline works in, where the bounding
/// box is centred at the origin and its diagonal is 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Normalization {
    /// Centre of the bounding box, in the input's units.
    pub centre: Vector,
    /// Diagonal of the bounding box, in the input's units.
    pub diagonal: f64,
}

impl Normalization {
    /// Without overflow for coordinates up to half the largest number. The diagonal is 0 where its
    /// inverse would not be finite, as for a single point.
    pub(crate) fn of(points: impl Iterator<Item = Vector>) -> Self {
        let (low, high) = bounds(points);
        let extent = high - low;
        let longest = extent[0].max(extent[1]).max(extent[2]);
        if longest < f64::MIN_POSITIVE {
            return Self { centre: Vector::ZERO, diagonal: 0.0 };
        }
        Self {
            centre: low * 0.5 + high * 0.5,
            diagonal: longest * (extent * (1.0 / longest)).length(),
        }
    }

    pub(crate) fn normalize(&self, point: Vector) -> Vector {
        (point - self.centre) * (1.0 / self.diagonal)
    }

    /// A point of the pipeline's space in the input's units.
    pub fn restore(&self, point: Vector) -> Vector {
        point * self.diagonal + self.centre
    }
}

/// What was repaired in the input, as counts.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Repairs {
    /// Vertices that were welded to another.
    pub welded_vertices: usize,
    /// Vertices that no triangle uses.
    pub unused_vertices: usize,
    /// Triangles dropped because they use a coordinate that is not finite.
    pub non_finite_triangles: usize,
    /// Triangles dropped because they have no area.
    pub degenerate_triangles: usize,
    /// Triangles dropped because another has the same vertices.
    pub duplicate_triangles: usize,
    /// Triangles that were turned around.
    pub flipped_triangles: usize,
    /// Edges with more than two triangles, which stay.
    pub non_manifold_edges: usize,
    /// Edges with one triangle, which stay open.
    pub open_edges: usize,
}

/// A repaired mesh, as all stages after repair take it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PreparedMesh {
    /// Welded, oriented, normalised, and in an order of its own.
    pub mesh: TriangleMesh,
    /// From this space to the input's.
    pub normalization: Normalization,
    /// For each triangle its index in the input; the same for both halves where a triangle was split. Those
    /// that close openings have none: `u32::MAX`.
    pub source_triangles: Vec<u32>,
    /// For each vertex its index in the input; of welded ones the first.
    pub source_vertices: Vec<u32>,
    /// For each triangle whether the input has it as often one way round as the other.
    pub is_both_ways: Vec<bool>,
    /// For each triangle its connected component (over shared edges).
    pub components: Vec<u32>,
    /// For each component whether each of its edges has exactly two triangles, which run along
    /// it in opposite directions.
    pub closed: Vec<bool>,
    /// What was changed in the input.
    pub repairs: Repairs,
    /// Triangles that close openings within the solid: they bound the inside, but are no surface.
    pub hidden_caps: Vec<[u32; 3]>,
}

impl PreparedMesh {
    /// The triangles by whose winding number a point is inside: sheets are there both ways round, so that
    /// their winding numbers cancel. Sheets are triangles that the input has both ways, and the open
    /// parts of a mesh that is inside out as a whole: which of their sides is the inside is not clear.
    pub(crate) fn triangles_of_solid(&self) -> Cow<'_, [[u32; 3]]> {
        let triangles = &self.mesh.triangles;
        let is_inside_out = self.mesh.encloses_nothing();
        let is_sheet = |triangle: usize| {
            self.is_both_ways[triangle]
                || is_inside_out && !self.closed[self.components[triangle] as usize]
        };
        let turned: Vec<[u32; 3]> = triangles
            .iter()
            .enumerate()
            .filter(|&(triangle, _)| is_sheet(triangle))
            .map(|(_, &[a, b, c])| [b, a, c])
            .collect();
        if turned.is_empty() && self.hidden_caps.is_empty() {
            Cow::Borrowed(triangles)
        } else {
            Cow::Owned([triangles.as_slice(), &turned, &self.hidden_caps].concat())
        }
    }

    /// Keeps the triangles for which `keeps` holds, by their number in the input and their component.
    /// Vertices and the numbers of components stay.
    pub(crate) fn retain(&mut self, keeps: impl Fn(u32, u32) -> bool) {
        let kept: Vec<usize> = (0..self.mesh.triangles.len())
            .filter(|&t| keeps(self.source_triangles[t], self.components[t]))
            .collect();
        self.mesh.triangles = kept.iter().map(|&t| self.mesh.triangles[t]).collect();
        self.source_triangles = kept.iter().map(|&t| self.source_triangles[t]).collect();
        self.is_both_ways = kept.iter().map(|&t| self.is_both_ways[t]).collect();
        self.components = kept.iter().map(|&t| self.components[t]).collect();
    }
}

/// Renumbers the vertices that triangles use, in their order. Returns for each its old number.
pub(super) fn compact(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut new_numbers = vec![0_u32; vertices];
    for &vertex in triangles.as_flattened() {
        new_numbers[vertex as usize] = 1;
    }
    let mut old_numbers = Vec::new();
    for (old, new) in (0_u32..).zip(&mut new_numbers) {
        if *new == 1 {
            *new = old_numbers.len() as u32;
            old_numbers.push(old);
        }
    }
    for vertex in triangles.as_flattened_mut() {
        *vertex = new_numbers[*vertex as usize];
    }
    old_numbers
}
