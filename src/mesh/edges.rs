//! The half-edges of a mesh, sorted by edge, without a hash map.

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
}
