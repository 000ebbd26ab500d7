//! The paper's data structures [3.3]: triangles with normals and the list of 3n neighbours. Its
//! lists of the triangles at each vertex are there to find neighbours, which half-edges sorted by
//! vertex do ([`SortedHalfEdges`]).
//!
//! The paper gives every triangle three neighbours. Real meshes have open edges, which have no
//! neighbour here, and edges with more than two triangles. There the surface that a triangle
//! belongs to goes on with the triangle that bends least: of the pairs of half-edges in opposite
//! directions, the flattest becomes neighbours first, then the flattest of the rest; what is left
//! over has no neighbour. Two triangles that run the same way along an edge that they have to
//! themselves are neighbours too: that is how a surface without two sides (a Möbius strip) closes.

use super::connectivity::{Edge, SortedHalfEdges, ascends};
use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, area_normal};

/// Stands in the neighbour list where an edge has no other triangle.
pub const NO_NEIGHBOUR: u32 = u32::MAX;

/// With more triangles at one edge than this, they are paired in the order of their index and
/// not by angle, since the number of pairs grows with the square.
const MOST_PAIRED_BY_ANGLE: usize = 64;

/// Adjacency of triangles across edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjacency {
    /// For each triangle its unit normal, or zero where it has no area.
    pub normals: Vec<Vector>,
    /// For each triangle `t` the triangles across its edges: entry `3 t + k` is across the edge
    /// from its vertex `k` to the next, or [`NO_NEIGHBOUR`]. Symmetric.
    pub neighbours: Vec<u32>,
}

impl Adjacency {
    /// Linear time, except for the sort of the edges at a vertex.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let triangles = &mesh.triangles;
        let normals: Vec<Vector> = triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|vertex| mesh.points()[vertex as usize]);
                area_normal(a, b, c).normalize_or_zero()
            })
            .collect();
        let neighbours = neighbours(triangles, mesh.positions.len(), &normals);
        Self { normals, neighbours }
    }

    /// The triangles across the three edges of a triangle, or [`NO_NEIGHBOUR`].
    #[inline]
    pub fn triangle_neighbours(&self, triangle: u32) -> [u32; 3] {
        let start = 3 * triangle as usize;
        [self.neighbours[start], self.neighbours[start + 1], self.neighbours[start + 2]]
    }
}

fn neighbours(triangles: &[[u32; 3]], vertices: usize, normals: &[Vector]) -> Vec<u32> {
    let mut neighbours = vec![NO_NEIGHBOUR; 3 * triangles.len()];
    let mut join = |a: u32, b: u32| {
        neighbours[a as usize] = b / 3;
        neighbours[b as usize] = a / 3;
    };
    SortedHalfEdges::new(triangles, vertices).for_each_edge(|edge| match edge.len() {
        0 | 1 => {}
        2 => join(edge.half_edge(0), edge.half_edge(1)),
        _ => pair_flattest_first(triangles, normals, edge, &mut join),
    });
    neighbours
}

fn pair_flattest_first(
    triangles: &[[u32; 3]],
    normals: &[Vector],
    edge: Edge<'_>,
    join: &mut impl FnMut(u32, u32),
) {
    let (forward, backward): (Vec<u32>, Vec<u32>) =
        edge.half_edges().partition(|&half_edge| ascends(triangles, half_edge));
    if edge.len() > MOST_PAIRED_BY_ANGLE {
        for (&a, &b) in forward.iter().zip(&backward) {
            join(a, b);
        }
        return;
    }
    let mut pairs = Vec::with_capacity(forward.len() * backward.len());
    for &a in &forward {
        for &b in &backward {
            let cosine = normals[a as usize / 3].dot(normals[b as usize / 3]);
            pairs.push((cosine, a.min(b), a.max(b)));
        }
    }
    pairs.sort_unstable_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut paired = Vec::with_capacity(edge.len());
    for (_, a, b) in pairs {
        if !paired.contains(&a) && !paired.contains(&b) {
            paired.extend([a, b]);
            join(a, b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::into_arrays;

    fn mesh(positions: &[Vector], triangles: &[[u32; 3]]) -> TriangleMesh {
        TriangleMesh {
            positions: into_arrays(positions.to_vec()),
            triangles: triangles.to_vec(),
            ..TriangleMesh::default()
        }
    }

    fn assert_symmetric(adjacency: &Adjacency) {
        for (entry, &other) in adjacency.neighbours.iter().enumerate() {
            if other != NO_NEIGHBOUR {
                let back = adjacency.triangle_neighbours(other);
                assert!(back.contains(&(entry as u32 / 3)), "{entry} lists {other}");
            }
        }
    }

    #[test]
    fn a_tetrahedron_knows_its_neighbours_edge_by_edge() {
        let tetrahedron = mesh(
            &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::from),
            &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        );
        let adjacency = Adjacency::new(&tetrahedron);
        assert_eq!(
            adjacency.neighbours,
            [3, 2, 1, 0, 2, 3, 0, 3, 1, 0, 1, 2],
            "across (v0, v1), (v1, v2), (v2, v0)"
        );
        assert_eq!(adjacency.normals[0], Vector::new(0.0, 0.0, -1.0));
        assert_eq!(adjacency.normals[1], Vector::new(0.0, -1.0, 0.0));
        assert_symmetric(&adjacency);
    }

    #[test]
    fn open_edges_have_no_neighbour() {
        let square = mesh(
            &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Vector::from),
            &[[0, 1, 2], [0, 2, 3]],
        );
        let none = NO_NEIGHBOUR;
        assert_eq!(Adjacency::new(&square).neighbours, [none, none, 1, 0, none, none]);
    }

    /// Triangles on one common edge from vertex 0 to vertex 1, like pages of a book. A page's
    /// angle is in degrees; a page runs along the edge if `forward`, else against it.
    fn book(pages: &[(f64, bool)]) -> TriangleMesh {
        let mut positions = vec![Vector::ZERO, Vector::Z];
        let mut triangles = Vec::new();
        for &(degrees, forward) in pages {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let outer = positions.len() as u32;
            positions.push(Vector::new(cosine, sine, 0.5));
            triangles.push(if forward { [0, 1, outer] } else { [1, 0, outer] });
        }
        mesh(&positions, &triangles)
    }

    fn partner(adjacency: &Adjacency, page: usize) -> u32 {
        adjacency.neighbours[3 * page]
    }

    #[test]
    fn at_a_fin_the_flattest_pair_are_neighbours() {
        // A floor that bends a little, and a fin that stands on it.
        let adjacency = Adjacency::new(&book(&[(0.0, true), (90.0, false), (170.0, false)]));
        assert_eq!(partner(&adjacency, 0), 2);
        assert_eq!(partner(&adjacency, 1), NO_NEIGHBOUR);
        assert_eq!(partner(&adjacency, 2), 0);
        assert_symmetric(&adjacency);
    }

    #[test]
    fn after_the_flattest_pair_comes_the_flattest_of_the_rest() {
        let pages = [(0.0, true), (90.0, false), (180.0, false), (250.0, true)];
        let adjacency = Adjacency::new(&book(&pages));
        assert_eq!(partner(&adjacency, 0), 2);
        assert_eq!(partner(&adjacency, 1), 3);
        assert_symmetric(&adjacency);
    }

    #[test]
    fn equally_flat_pairs_go_by_index() {
        let pages = [(0.0, true), (90.0, false), (180.0, true), (270.0, false)];
        let adjacency = Adjacency::new(&book(&pages));
        let partners: Vec<u32> = (0..4).map(|page| partner(&adjacency, page)).collect();
        assert_symmetric(&adjacency);
        assert!(partners.iter().all(|&partner| partner != NO_NEIGHBOUR));
    }

    #[test]
    fn where_more_than_two_meet_the_same_direction_is_no_neighbour() {
        let adjacency = Adjacency::new(&book(&[(0.0, true), (120.0, true), (240.0, true)]));
        assert!(adjacency.neighbours.iter().all(|&n| n == NO_NEIGHBOUR));
    }

    #[test]
    fn two_in_the_same_direction_are_neighbours() {
        let adjacency = Adjacency::new(&book(&[(0.0, true), (120.0, true)]));
        assert_eq!(partner(&adjacency, 0), 1);
        assert_eq!(partner(&adjacency, 1), 0);
    }

    #[test]
    fn a_thousand_triangles_at_one_edge_are_paired_too() {
        let pages: Vec<(f64, bool)> =
            (0..1000_u32).map(|page| (f64::from(page) * 0.36, page % 2 == 0)).collect();
        let adjacency = Adjacency::new(&book(&pages));
        assert_symmetric(&adjacency);
        assert!((0..1000).all(|page| partner(&adjacency, page) != NO_NEIGHBOUR));
    }
}
