//! Which triangles share edges: half-edges sorted by edge, and the components and patches that they connect.
//!
//! A *component* is connected over shared edges of any kind. A *patch* is connected over manifold
//! edges alone, those with exactly two triangles: only there it is clear which triangle goes on
//! with which, so winding is made consistent within a patch and not beyond. Two boxes that share
//! an edge are one component of two patches.

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
}

/// Whether a half-edge runs from the smaller to the larger of its vertices.
#[inline]
pub(crate) fn ascends(triangles: &[[u32; 3]], half_edge: u32) -> bool {
    let triangle = triangles[half_edge as usize / 3];
    let k = half_edge as usize % 3;
    triangle[k] < triangle[(k + 1) % 3]
}

/// The patches and components of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Connectivity {
    /// For each triangle its patch; patches are numbered by their first triangle.
    pub patches: Vec<u32>,
    /// For each triangle whether it is wound against the first triangle of its patch.
    pub reversed: Vec<bool>,
    /// For each patch what kind it is.
    pub kinds: Vec<PatchKind>,
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
pub(crate) enum PatchKind {
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

        let (patches, reversed, patch_count) = forest.label();
        let mut kinds = vec![PatchKind::Closed; patch_count];
        for &triangle in &on_open_edge {
            kinds[patches[triangle as usize] as usize] = PatchKind::Open;
        }
        for edge in &non_manifold {
            open_unbalanced_patches(triangles, &patches, &reversed, *edge, &mut kinds);
        }
        for triangle in on_twisted_edge {
            kinds[patches[triangle as usize] as usize] = PatchKind::Twisted;
        }

        let mut patch_forest = ParityForest::new(patch_count);
        for edge in &non_manifold {
            let first = patches[edge.half_edge(0) as usize / 3];
            for half_edge in edge.half_edges() {
                patch_forest.join(first, patches[half_edge as usize / 3], false);
            }
        }
        let (component_of_patch, _, component_count) = patch_forest.label();
        let mut closed = vec![true; component_count];
        for (patch, &kind) in kinds.iter().enumerate() {
            closed[component_of_patch[patch] as usize] &= kind == PatchKind::Closed;
        }
        for edge in &non_manifold {
            let patch = patches[edge.half_edge(0) as usize / 3];
            closed[component_of_patch[patch as usize] as usize] = false;
        }
        let components = patches.iter().map(|&patch| component_of_patch[patch as usize]).collect();
        Self {
            patches,
            reversed,
            kinds,
            components,
            closed,
            open_edges: on_open_edge.len(),
            non_manifold_edges: non_manifold.len(),
        }
    }
}

/// At a non-manifold edge, a patch whose own triangles do not cancel has a border.
fn open_unbalanced_patches(
    triangles: &[[u32; 3]],
    patches: &[u32],
    reversed: &[bool],
    edge: Edge<'_>,
    kinds: &mut [PatchKind],
) {
    let mut ways: Vec<(u32, i32)> = edge
        .half_edges()
        .map(|half_edge| {
            let triangle = half_edge as usize / 3;
            let forward = ascends(triangles, half_edge) != reversed[triangle];
            (patches[triangle], if forward { 1 } else { -1 })
        })
        .collect();
    ways.sort_unstable();
    for own in ways.chunk_by(|a, b| a.0 == b.0) {
        if own.iter().map(|&(_, way)| way).sum::<i32>() != 0 {
            kinds[own[0].0 as usize] = PatchKind::Open;
        }
    }
}

/// Disjoint sets that also record whether each element is turned against the first of its set.
struct ParityForest {
    /// For each element its parent; the highest bit says whether it is turned against it.
    links: Vec<u32>,
}

/// The number of triangles is limited so that the highest bit is free.
const TURNED: u32 = 1 << 31;

impl ParityForest {
    fn new(elements: usize) -> Self {
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
    /// `turned` demands.
    fn join(&mut self, a: u32, b: u32, turned: bool) -> bool {
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
    fn label(mut self) -> (Vec<u32>, Vec<bool>, usize) {
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

    #[test]
    fn a_tetrahedron_has_six_edges_of_two_half_edges() {
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mut edges = Vec::new();
        SortedHalfEdges::new(&triangles, 4).for_each_edge(|edge| {
            let (a, b) = (edge.half_edge(0), edge.half_edge(1));
            assert_eq!(edge.len(), 2);
            assert_ne!(ascends(&triangles, a), ascends(&triangles, b));
            let (t, k) = (a as usize / 3, a as usize % 3);
            let (v, w) = (triangles[t][k], triangles[t][(k + 1) % 3]);
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

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    /// A strip of `n` squares whose last edge is glued to the first, with half a turn if `twisted`.
    fn ring(n: u32, twisted: bool) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for i in 0..n {
            let (a, b) = (2 * i, 2 * i + 1);
            let (mut c, mut d) = (2 * ((i + 1) % n), 2 * ((i + 1) % n) + 1);
            if twisted && i + 1 == n {
                std::mem::swap(&mut c, &mut d);
            }
            triangles.extend([[a, c, b], [b, c, d]]);
        }
        triangles
    }

    #[test]
    fn a_tetrahedron_is_one_closed_patch() {
        let connectivity = Connectivity::new(&TETRAHEDRON, 4);
        assert_eq!(connectivity.components, [0; 4]);
        assert_eq!(connectivity.kinds, [PatchKind::Closed]);
        assert_eq!(connectivity.closed, [true]);
        assert_eq!(connectivity.open_edges, 0);
        assert_eq!(connectivity.non_manifold_edges, 0);
    }

    #[test]
    fn a_turned_triangle_is_found() {
        let mut triangles = TETRAHEDRON;
        triangles[2].swap(0, 1);
        let connectivity = Connectivity::new(&triangles, 4);
        assert_eq!(connectivity.reversed, [false, false, true, false]);
        assert_eq!(connectivity.closed, [true]);
    }

    #[test]
    fn a_ring_has_two_sides_and_a_mobius_strip_one() {
        let plain = Connectivity::new(&ring(5, false), 10);
        assert_eq!(plain.kinds, [PatchKind::Open]);
        assert!(!plain.reversed.contains(&true));
        let twisted = Connectivity::new(&ring(5, true), 10);
        assert_eq!(twisted.kinds, [PatchKind::Twisted]);
        assert_eq!(twisted.closed, [false]);
        assert_eq!(twisted.open_edges, 10);
    }

    #[test]
    fn two_tetrahedra_at_an_edge_are_one_component_of_two_patches() {
        let mut triangles = TETRAHEDRON.to_vec();
        let second = TETRAHEDRON.map(|triangle| triangle.map(|v| if v < 2 { v } else { v + 2 }));
        triangles.extend(second);
        let connectivity = Connectivity::new(&triangles, 6);
        assert_eq!(connectivity.components, [0; 8]);
        assert_eq!(connectivity.patches, [0, 0, 0, 0, 1, 1, 1, 1]);
        assert_eq!(connectivity.kinds, [PatchKind::Closed; 2]);
        assert_eq!(connectivity.closed, [false]);
        assert_eq!(connectivity.non_manifold_edges, 1);
    }

    #[test]
    fn two_tetrahedra_at_a_vertex_are_two_components() {
        let mut triangles = TETRAHEDRON.to_vec();
        let second = TETRAHEDRON.map(|triangle| triangle.map(|v| if v < 1 { v } else { v + 3 }));
        triangles.extend(second);
        let connectivity = Connectivity::new(&triangles, 7);
        assert_eq!(connectivity.components, [0, 0, 0, 0, 1, 1, 1, 1]);
        assert_eq!(connectivity.closed, [true, true]);
    }

    #[test]
    fn a_fin_opens_its_component_but_not_the_patch_that_it_stands_on() {
        let mut triangles = TETRAHEDRON.to_vec();
        triangles.push([0, 1, 4]);
        let connectivity = Connectivity::new(&triangles, 5);
        assert_eq!(connectivity.kinds, [PatchKind::Closed, PatchKind::Open], "tetrahedron and fin");
        assert_eq!(connectivity.closed, [false]);
        assert_eq!(connectivity.open_edges, 2);
        assert_eq!(connectivity.non_manifold_edges, 1);
    }
}
