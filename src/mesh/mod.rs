//! The input as the pipeline works on it: repaired, normalised, simplified.

use std::borrow::Cow;

pub use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, add, bounds, length, scale, subtract};

pub(crate) mod adjacency;
mod area;
pub(crate) mod canonical_order;
mod caps;
mod components;
mod degenerate;
pub(crate) mod edges;
pub(crate) mod grouping;
mod orientation;
pub(crate) mod refine;
pub(crate) mod repair;
pub mod shapes;
pub(crate) mod simplify;
pub(crate) mod weld;

use repair::Repairs;

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
        let extent = subtract(high, low);
        let longest = extent[0].max(extent[1]).max(extent[2]);
        if longest < f64::MIN_POSITIVE {
            return Self { centre: [0.0; 3], diagonal: 0.0 };
        }
        Self {
            centre: add(scale(low, 0.5), scale(high, 0.5)),
            diagonal: longest * length(scale(extent, 1.0 / longest)),
        }
    }

    pub(crate) fn normalize(&self, point: Vector) -> Vector {
        scale(subtract(point, self.centre), 1.0 / self.diagonal)
    }

    /// A point of the pipeline's space in the input's units.
    pub fn restore(&self, point: Vector) -> Vector {
        add(scale(point, self.diagonal), self.centre)
    }
}

/// What repair hands to the stages after it.
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
    /// Triangles that close openings within the solid: they tell inside from outside, and are no surface.
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
fn compact(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::adjacency::{Adjacency, NO_NEIGHBOUR};
    use super::area::is_degenerate;
    use super::canonical_order::MeshOrder;
    use super::repair::prepare;
    use super::simplify::simplify;
    use super::*;
    use crate::control::Control;
    use crate::error::Error;

    /// Triangles of few points on a coarse grid: full of everything that is wrong with meshes.
    fn soup() -> impl Strategy<Value = TriangleMesh> {
        let point = prop::array::uniform3((0..4_i32).prop_map(f64::from));
        let points = prop::collection::vec(point, 3..20);
        points.prop_flat_map(|positions| {
            let index = 0..positions.len() as u32;
            let triangles = prop::collection::vec(prop::array::uniform3(index), 1..120);
            triangles.prop_map(move |triangles| TriangleMesh::new(positions.clone(), triangles))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), ..Default::default() })]

        #[test]
        fn any_soup_is_repaired_or_refused(soup in soup()) {
            let result = prepare(soup.view(), MeshOrder::Place, &Control::new());
            let prepared = match result {
                Ok(prepared) => prepared,
                Err(error) => {
                    let is_expected = matches!(error, Error::NothingUsable { .. });
                    prop_assert!(is_expected);
                    return Ok(());
                }
            };
            let PreparedMesh { mesh, components, closed, repairs, .. } = prepared;
            prop_assert!(!mesh.triangles.iter().any(|&t| is_degenerate(&mesh.positions, t)));
            prop_assert_eq!(mesh.positions.len(), prepared.source_vertices.len());

            let adjacency = Adjacency::new(&mesh);
            for (entry, &other) in adjacency.neighbours.iter().enumerate() {
                let own = entry as u32 / 3;
                if other == NO_NEIGHBOUR {
                    prop_assert!(!closed[components[own as usize] as usize]);
                } else {
                    prop_assert!(adjacency.triangle_neighbours(other).contains(&own));
                    prop_assert_eq!(components[own as usize], components[other as usize]);
                }
            }
            if closed.iter().all(|&closed| closed) {
                prop_assert_eq!(repairs.open_edges + repairs.non_manifold_edges, 0);
            }

            let simplified = simplify(&mesh, &components, mesh.triangles.len() / 3, &Control::new()).expect("within the limits");
            for component in 0..closed.len() as u32 {
                prop_assert!(simplified.components.contains(&component));
            }
        }

        #[test]
        fn repairing_again_changes_nothing(soup in soup()) {
            let repair = |mesh: &TriangleMesh| {
                prepare(mesh.view(), MeshOrder::Place, &Control::new())
            };
            if let Ok(once) = repair(&soup) {
                let twice = repair(&once.mesh).expect("usable once, usable twice");
                prop_assert_eq!(&twice.mesh.triangles, &once.mesh.triangles);
                prop_assert_eq!(&twice.components, &once.components);
                prop_assert_eq!(&twice.closed, &once.closed);
                prop_assert_eq!(twice.repairs.flipped_triangles, 0);
            }
        }
    }
}
