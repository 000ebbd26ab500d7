//! Which triangles share edges: half-edges sorted by edge, the neighbours of triangles, and the
//! components and shells that edges connect.
//!
//! [`Adjacency`] is the paper's data structure [3.3]: triangles with normals and the list of 3n neighbours. Its
//! lists of the triangles at each vertex are there to find neighbours, which half-edges sorted by
//! vertex do ([`SortedHalfEdges`]).
//!
//! The paper gives every triangle three neighbours. Real meshes have open edges, which have no
//! neighbour here, and edges with more than two triangles. There the surface that a triangle
//! belongs to goes on with the triangle that bends least: of the pairs of half-edges in opposite
//! directions, the flattest becomes neighbours first, then the flattest of the rest; what is left
//! over has no neighbour. Two triangles that run the same way along an edge that they have to
//! themselves are neighbours too: that is how a surface without two sides (a Möbius strip) closes.
//!
//! A *component* is connected over shared edges of any kind. A *shell* is connected over manifold
//! edges alone, those with exactly two triangles: only there it is clear which triangle goes on
//! with which, so winding is made consistent within a shell and not beyond. Two boxes that share
//! an edge are one component of two shells.

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, area_normal};
use crate::sorting::sort_by_key;

/// All half-edges, sorted by edge without a hash map.
///
/// Half-edge `3 t + k` runs from vertex `k` of triangle `t` to its next vertex.
///
/// Half-edges are sorted by the smaller vertex of their edge (by counting), then by the larger
/// one, then by their own number (in short runs, by comparison). Time O(n log v) for n triangles
/// and at most v half-edges at a vertex; memory 24 bytes per triangle and 4 per vertex.
pub(crate) struct SortedHalfEdges {
    /// For each vertex the start of the half-edges whose smaller vertex it is, and the end.
    offsets: Vec<u32>,
    /// The larger vertex in the upper half, the half-edge in the lower.
    entries: Vec<u64>,
}

impl SortedHalfEdges {
    pub(crate) fn new(triangles: &[[u32; 3]], vertices: usize) -> Self {
        let mut offsets = vec![0_u32; vertices + 1];
        for triangle in triangles {
            for k in 0..3 {
                offsets[triangle[k].min(triangle[(k + 1) % 3]) as usize] += 1;
            }
        }
        let mut sum = 0;
        for offset in &mut offsets {
            sum += *offset;
            *offset = sum;
        }
        let mut entries = vec![0_u64; 3 * triangles.len()];
        for (t, triangle) in triangles.iter().enumerate().rev() {
            for k in (0..3).rev() {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                let offset = &mut offsets[a.min(b) as usize];
                *offset -= 1;
                entries[*offset as usize] = u64::from(a.max(b)) << 32 | (3 * t + k) as u64;
            }
        }
        for range in offsets.windows(2) {
            entries[range[0] as usize..range[1] as usize].sort_unstable();
        }
        Self { offsets, entries }
    }

    /// Calls `visit` with the half-edges of each edge, in ascending order; edges ascend too.
    pub(crate) fn for_each_edge<'a>(&'a self, mut visit: impl FnMut(Edge<'a>)) {
        for range in self.offsets.windows(2) {
            let bucket = &self.entries[range[0] as usize..range[1] as usize];
            for entries in bucket.chunk_by(|a, b| a >> 32 == b >> 32) {
                visit(Edge { entries });
            }
        }
    }
}

/// An edge: all half-edges between its two vertices.
#[derive(Clone, Copy)]
pub(crate) struct Edge<'a> {
    entries: &'a [u64],
}

impl Edge<'_> {
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// The `i`th half-edge.
    #[inline]
    pub(crate) fn half_edge(&self, i: usize) -> u32 {
        self.entries[i] as u32
    }

    pub(crate) fn half_edges(&self) -> impl Iterator<Item = u32> {
        self.entries.iter().map(|&entry| entry as u32)
    }

    /// The half-edges that run one way more often than the other, as many as there are more.
    pub(crate) fn unpaired(&self, triangles: &[[u32; 3]]) -> impl Iterator<Item = u32> {
        let ascending = self.half_edges().filter(|&half_edge| ascends(triangles, half_edge));
        let up = ascending.count();
        let down = self.len() - up;
        let runs_as_most = move |&half_edge: &u32| ascends(triangles, half_edge) == (up > down);
        self.half_edges().filter(runs_as_most).take(up.abs_diff(down))
    }
}

/// Whether a half-edge runs from the smaller to the larger of its vertices.
#[inline]
pub(crate) fn ascends(triangles: &[[u32; 3]], half_edge: u32) -> bool {
    let triangle = triangles[half_edge as usize / 3];
    let k = half_edge as usize % 3;
    triangle[k] < triangle[(k + 1) % 3]
}

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

/// The shells and components of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Connectivity {
    /// For each triangle its shell; shells are numbered by their first triangle.
    pub shells: Vec<u32>,
    /// For each triangle whether it is wound against the first triangle of its shell.
    pub reversed: Vec<bool>,
    /// For each shell what kind it is.
    pub kinds: Vec<ShellKind>,
    /// For each triangle its component; components are numbered by their first triangle.
    pub components: Vec<u32>,
    /// For each component whether each of its edges has two triangles, which run along it in
    /// opposite directions once winding is consistent.
    pub closed: Vec<bool>,
    /// Edges with one triangle.
    pub open_edges: usize,
    /// Edges with more than two triangles.
    pub non_manifold_edges: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ShellKind {
    /// At each edge as many of its triangles run one way as the other: it encloses a volume.
    Closed,
    /// It has a border.
    Open,
    /// Its winding can't be made consistent: it has one side, as a Möbius strip.
    Twisted,
}

impl Connectivity {
    #[cfg(test)]
    pub(crate) fn new(triangles: &[[u32; 3]], vertices: usize) -> Self {
        Self::of(triangles, &SortedHalfEdges::new(triangles, vertices))
    }

    /// Almost linear time.
    pub(crate) fn of(triangles: &[[u32; 3]], half_edges: &SortedHalfEdges) -> Self {
        let mut forest = ParityForest::new(triangles.len());
        let mut on_open_edge = Vec::new();
        let mut on_twisted_edge = Vec::new();
        let mut non_manifold = Vec::new();
        half_edges.for_each_edge(|edge| match edge.len() {
            1 => on_open_edge.push(edge.half_edge(0) / 3),
            2 => {
                let (a, b) = (edge.half_edge(0), edge.half_edge(1));
                let same_way = ascends(triangles, a) == ascends(triangles, b);
                if !forest.join(a / 3, b / 3, same_way) {
                    on_twisted_edge.push(a / 3);
                }
            }
            _ => non_manifold.push(edge),
        });

        let (shells, reversed, shell_count) = forest.label();
        let mut kinds = vec![ShellKind::Closed; shell_count];
        for &triangle in &on_open_edge {
            kinds[shells[triangle as usize] as usize] = ShellKind::Open;
        }
        for edge in &non_manifold {
            open_unbalanced_shells(triangles, &shells, &reversed, *edge, &mut kinds);
        }
        for triangle in on_twisted_edge {
            kinds[shells[triangle as usize] as usize] = ShellKind::Twisted;
        }

        let mut shell_forest = ParityForest::new(shell_count);
        for edge in &non_manifold {
            let first = shells[edge.half_edge(0) as usize / 3];
            for half_edge in edge.half_edges() {
                shell_forest.join(first, shells[half_edge as usize / 3], false);
            }
        }
        let (component_of_shell, _, component_count) = shell_forest.label();
        let mut closed = vec![true; component_count];
        for (shell, &kind) in kinds.iter().enumerate() {
            closed[component_of_shell[shell] as usize] &= kind == ShellKind::Closed;
        }
        for edge in &non_manifold {
            let shell = shells[edge.half_edge(0) as usize / 3];
            closed[component_of_shell[shell as usize] as usize] = false;
        }
        let components = shells.iter().map(|&shell| component_of_shell[shell as usize]).collect();
        Self {
            shells,
            reversed,
            kinds,
            components,
            closed,
            open_edges: on_open_edge.len(),
            non_manifold_edges: non_manifold.len(),
        }
    }
}

/// At a non-manifold edge, a shell whose own triangles do not cancel has a border.
fn open_unbalanced_shells(
    triangles: &[[u32; 3]],
    shells: &[u32],
    reversed: &[bool],
    edge: Edge<'_>,
    kinds: &mut [ShellKind],
) {
    let mut ways: Vec<(u32, i32)> = edge
        .half_edges()
        .map(|half_edge| {
            let triangle = half_edge as usize / 3;
            let forward = ascends(triangles, half_edge) != reversed[triangle];
            (shells[triangle], if forward { 1 } else { -1 })
        })
        .collect();
    sort_by_key(&mut ways, |way| *way);
    for own in ways.chunk_by(|a, b| a.0 == b.0) {
        if own.iter().map(|&(_, way)| way).sum::<i32>() != 0 {
            kinds[own[0].0 as usize] = ShellKind::Open;
        }
    }
}

/// Disjoint sets that also record whether each element is turned against the first of its set.
pub(super) struct ParityForest {
    /// For each element its parent; the highest bit says whether it is turned against it.
    links: Vec<u32>,
}

/// The number of triangles is limited so that the highest bit is free.
const TURNED: u32 = 1 << 31;

impl ParityForest {
    pub(super) fn new(elements: usize) -> Self {
        Self { links: (0..elements as u32).collect() }
    }

    /// The set's first element, with the bit that says whether `element` is turned against it.
    fn find(&mut self, mut element: u32) -> (u32, u32) {
        let mut turned = 0;
        loop {
            let link = self.links[element as usize];
            let parent = link & !TURNED;
            if parent == element {
                return (element, turned);
            }
            let shortcut = self.links[parent as usize] ^ (link & TURNED);
            self.links[element as usize] = shortcut;
            turned ^= shortcut & TURNED;
            element = shortcut & !TURNED;
        }
    }

    /// Makes one set of two. False if they already are one in which `a` and `b` are not as
    /// `turned` requires.
    pub(super) fn join(&mut self, a: u32, b: u32, turned: bool) -> bool {
        let turned = if turned { TURNED } else { 0 };
        let (first, turned_a) = self.find(a);
        let (second, turned_b) = self.find(b);
        let between = turned ^ turned_a ^ turned_b;
        if first == second {
            return between == 0;
        }
        self.links[first.max(second) as usize] = first.min(second) | between;
        true
    }

    /// For each element the number of its set and whether it is turned against the set's first;
    /// and the number of sets.
    pub(super) fn label(mut self) -> (Vec<u32>, Vec<bool>, usize) {
        let mut sets = Vec::with_capacity(self.links.len());
        let mut turned = Vec::with_capacity(self.links.len());
        let mut count = 0_u32;
        for element in 0..self.links.len() as u32 {
            let (first, bit) = self.find(element);
            turned.push(bit != 0);
            // The first of a set is the least, so its number is known by now.
            let set = if first == element {
                count += 1;
                count - 1
            } else {
                sets[first as usize]
            };
            sets.push(set);
        }
        (sets, turned, count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::mobius_strip;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn a_tetrahedron_has_six_edges_of_two_half_edges() {
        let mut edges = Vec::new();
        SortedHalfEdges::new(&TETRAHEDRON, 4).for_each_edge(|edge| {
            let (a, b) = (edge.half_edge(0), edge.half_edge(1));
            assert_eq!(edge.len(), 2);
            assert_ne!(ascends(&TETRAHEDRON, a), ascends(&TETRAHEDRON, b));
            let (t, k) = (a as usize / 3, a as usize % 3);
            let (v, w) = (TETRAHEDRON[t][k], TETRAHEDRON[t][(k + 1) % 3]);
            edges.push((v.min(w), v.max(w)));
        });
        assert_eq!(edges, [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]);
    }

    #[test]
    fn half_edges_of_an_edge_ascend() {
        let triangles = [[5, 1, 2], [1, 5, 3], [5, 1, 4], [1, 5, 0]];
        let mut largest = Vec::new();
        SortedHalfEdges::new(&triangles, 6).for_each_edge(|edge| {
            if edge.len() > 2 {
                largest = edge.half_edges().collect();
            }
        });
        assert_eq!(largest, [0, 3, 6, 9]);
    }

    /// The neighbours of a mesh, of which it is asserted that they are mutual.
    fn adjacency(positions: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Adjacency {
        let adjacency = Adjacency::new(&TriangleMesh::new(positions, triangles.to_vec()));
        for (entry, &other) in adjacency.neighbours.iter().enumerate() {
            if other != NO_NEIGHBOUR {
                let back = adjacency.triangle_neighbours(other);
                assert!(back.contains(&(entry as u32 / 3)), "{entry} lists {other}");
            }
        }
        adjacency
    }

    #[test]
    fn neighbours_are_listed_edge_by_edge_and_open_edges_have_none() {
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let tetrahedron = adjacency(corners, &TETRAHEDRON);
        // Across (v0, v1), (v1, v2), (v2, v0).
        assert_eq!(tetrahedron.neighbours, [3, 2, 1, 0, 2, 3, 0, 3, 1, 0, 1, 2]);
        assert_eq!(tetrahedron.normals[..2], [Vector::NEG_Z, Vector::NEG_Y]);
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let square = adjacency(corners, &[[0, 1, 2], [0, 2, 3]]);
        let none = NO_NEIGHBOUR;
        assert_eq!(square.neighbours, [none, none, 1, 0, none, none]);
    }

    /// For each of some triangles on one common edge, like pages of a book, its neighbour across
    /// that. A page's angle is in degrees; a page runs along the edge if `forward`, else against
    /// it.
    fn partners(pages: &[(f64, bool)]) -> Vec<u32> {
        let mut positions = vec![[0.0; 3], [0.0, 0.0, 1.0]];
        let mut triangles = Vec::new();
        for &(degrees, forward) in pages {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let outer = positions.len() as u32;
            positions.push([cosine, sine, 0.5]);
            triangles.push(if forward { [0, 1, outer] } else { [1, 0, outer] });
        }
        adjacency(positions, &triangles).neighbours.into_iter().step_by(3).collect()
    }

    #[test]
    fn at_an_edge_the_flattest_pair_in_opposite_directions_comes_first() {
        let none = NO_NEIGHBOUR;
        let (there, back) = (true, false);
        for (pages, expected) in [
            // A floor that bends a little, and a fin that stands on it.
            (&[(0.0, there), (90.0, back), (170.0, back)][..], &[2, none, 0][..]),
            (&[(0.0, there), (90.0, back), (180.0, back), (250.0, there)], &[2, 3, 0, 1]),
            (&[(0.0, there), (120.0, there), (240.0, there)], &[none; 3]),
            (&[(0.0, there), (120.0, there)], &[1, 0]),
        ] {
            assert_eq!(partners(pages), expected, "{pages:?}");
        }
    }

    #[test]
    fn equally_flat_pairs_and_a_thousand_triangles_at_one_edge_are_paired_too() {
        for count in [4, 1000_u32] {
            let page = |page| (f64::from(page) * 360.0 / f64::from(count), page % 2 == 0);
            let pages: Vec<(f64, bool)> = (0..count).map(page).collect();
            assert!(!partners(&pages).contains(&NO_NEIGHBOUR), "{count}");
        }
    }

    /// Two tetrahedra that have this many vertices in common.
    fn two_tetrahedra(common: u32) -> Vec<[u32; 3]> {
        let moved = |v: u32| if v < common { v } else { v + 4 - common };
        [TETRAHEDRON, TETRAHEDRON.map(|triangle| triangle.map(moved))].concat()
    }

    #[test]
    fn shells_components_and_their_kinds() {
        use ShellKind::{Closed, Open, Twisted};
        let mut turned = TETRAHEDRON;
        turned[2].swap(0, 1);
        let fin = [&TETRAHEDRON[..], &[[0, 1, 4]]].concat();
        let two = [0, 0, 0, 0, 1, 1, 1, 1];
        let ring = [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5], [4, 0, 5], [5, 0, 1]];
        let strip = mobius_strip(5).triangles;
        let find = |triangles: &[[u32; 3]]| Connectivity::new(triangles, 10);
        for (name, triangles, shells, components, kinds, closed, edges) in [
            (
                "a tetrahedron",
                &TETRAHEDRON[..],
                &[0; 4][..],
                &[0; 4][..],
                &[Closed][..],
                &[true][..],
                [0, 0],
            ),
            ("turned", &turned, &[0; 4], &[0; 4], &[Closed], &[true], [0, 0]),
            ("a ring", &ring, &[0; 6], &[0; 6], &[Open], &[false], [6, 0]),
            ("a Möbius strip", &strip, &[0; 10], &[0; 10], &[Twisted], &[false], [10, 0]),
            ("at an edge", &two_tetrahedra(2), &two, &[0; 8], &[Closed; 2], &[false], [0, 1]),
            ("at a vertex", &two_tetrahedra(1), &two, &two, &[Closed; 2], &[true; 2], [0, 0]),
            // The fin opens its component, but not the shell that it stands on.
            ("a fin", &fin, &[0, 0, 0, 0, 1], &[0; 5], &[Closed, Open], &[false], [2, 1]),
        ] {
            let found = find(triangles);
            assert_eq!(found.shells, shells, "{name}");
            assert_eq!(found.components, components, "{name}");
            assert_eq!((&found.kinds[..], &found.closed[..]), (kinds, closed), "{name}");
            assert_eq!([found.open_edges, found.non_manifold_edges], edges, "{name}");
        }
        assert_eq!(find(&turned).reversed, [false, false, true, false]);
        assert!(!find(&ring).reversed.contains(&true));
    }
}
