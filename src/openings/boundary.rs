//! The boundary of a surface as simple loops.
//!
//! A half-edge is on the boundary where more triangles run along its edge one way than the other. What
//! closes the surface runs the other way: the loops here do. A T-junction, a long edge with
//! vertices of its neighbours on it, is a loop without width.

use crate::geometry::vector::Vector;
use crate::mesh::adjacency::{SortedHalfEdges, ascends};

/// A simple closed polygon along the boundary.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loop {
    /// In the direction in which a cap runs along it.
    pub vertices: Vec<u32>,
    /// For each vertex a triangle of the surface at the edge to the next vertex.
    pub neighbours: Vec<u32>,
}

impl Loop {
    /// In diagonals.
    pub(super) fn length(&self, positions: &[Vector]) -> f64 {
        let next = self.vertices.iter().cycle().skip(1);
        let at = |vertex: &u32| positions[*vertex as usize];
        self.vertices.iter().zip(next).map(|(a, b)| at(a).distance(at(b))).sum()
    }
}

/// A half-edge that would close the surface.
#[derive(Debug, Clone, Copy)]
struct CapEdge {
    from: u32,
    to: u32,
    neighbour: u32,
}

/// The loops of the boundary, each vertex at most once in each. O(n log n) for n triangles.
pub(super) fn boundary_loops(positions: &[Vector], triangles: &[[u32; 3]]) -> Vec<Loop> {
    let edges = cap_edges(positions, triangles);
    let leaving = |vertex: u32| {
        let start = edges.partition_point(|edge| edge.from < vertex);
        let count = edges[start..].iter().take_while(|edge| edge.from == vertex).count();
        start..start + count
    };
    let mut is_used = vec![false; edges.len()];
    let mut place_on_path = vec![usize::MAX; positions.len()];
    let mut loops = Vec::new();
    for first in 0..edges.len() {
        let mut path: Vec<CapEdge> = Vec::new();
        let mut next = (!is_used[first]).then_some(first);
        while let Some(index) = next {
            is_used[index] = true;
            let edge = edges[index];
            place_on_path[edge.from as usize] = path.len();
            path.push(edge);
            let place = place_on_path[edge.to as usize];
            if place != usize::MAX {
                let closed = path.split_off(place);
                closed.iter().for_each(|edge| place_on_path[edge.from as usize] = usize::MAX);
                loops.push(Loop {
                    vertices: closed.iter().map(|edge| edge.from).collect(),
                    neighbours: closed.iter().map(|edge| edge.neighbour).collect(),
                });
            }
            // The sharpest turn: two sides of a crack lie on each other.
            let reached = path.last().copied();
            next = reached.and_then(|last| {
                let open = leaving(last.to).filter(|&index| !is_used[index]);
                open.max_by(|&a, &b| {
                    let turn = |index: usize| sharpness(positions, last, edges[index]);
                    turn(a).total_cmp(&turn(b)).then(b.cmp(&a))
                })
            });
        }
        // As many edges end at a vertex as begin, so a path ends where it began.
        path.iter().for_each(|edge| place_on_path[edge.from as usize] = usize::MAX);
    }
    loops
}

/// The cosine between going back and going on.
fn sharpness(positions: &[Vector], last: CapEdge, next: CapEdge) -> f64 {
    let at = |vertex: u32| positions[vertex as usize];
    let back = (at(last.from) - at(last.to)).normalize_or_zero();
    back.dot((at(next.to) - at(next.from)).normalize_or_zero())
}

/// Ascending by where they begin, then by where they end.
fn cap_edges(positions: &[Vector], triangles: &[[u32; 3]]) -> Vec<CapEdge> {
    let mut edges = Vec::new();
    SortedHalfEdges::new(triangles, positions.len()).for_each_edge(|edge| {
        let ways = |up: bool| edge.half_edges().filter(move |&h| ascends(triangles, h) == up);
        let (up, down) = (ways(true).count(), ways(false).count());
        if up == down {
            return;
        }
        let excess = up.abs_diff(down);
        for half_edge in ways(up > down).take(excess) {
            let (triangle, k) = (half_edge / 3, half_edge as usize % 3);
            let corners = triangles[triangle as usize];
            edges.push(CapEdge { from: corners[(k + 1) % 3], to: corners[k], neighbour: triangle });
        }
    });
    edges.sort_unstable_by_key(|edge| (edge.from, edge.to, edge.neighbour));
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::shapes::{cuboid, join};

    fn loops(mesh: &TriangleMesh) -> Vec<Loop> {
        boundary_loops(mesh.points(), &mesh.triangles)
    }

    #[test]
    fn a_closed_mesh_has_no_boundary() {
        assert_eq!(loops(&cuboid([0.0; 3], [1.0; 3])), []);
    }

    #[test]
    fn a_box_without_a_lid_has_one_loop_that_runs_as_the_lid_would() {
        let mut mesh = cuboid([0.0; 3], [1.0; 3]);
        mesh.triangles.truncate(10);
        let found = loops(&mesh);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].vertices, [4, 5, 7, 6], "counter-clockwise seen from above");
        assert!(found[0].neighbours.iter().all(|&triangle| triangle < 10));
    }

    #[test]
    fn loops_that_touch_are_told_apart() {
        // Two open boxes side by side which share an edge of their rims.
        let mut first = cuboid([0.0; 3], [1.0; 3]);
        let mut second = cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0]);
        first.triangles.truncate(10);
        second.triangles.truncate(10);
        let mut mesh = join(&[first, second]);
        // Vertex 7 of the first is at vertex 4 of the second.
        for vertex in mesh.triangles.as_flattened_mut() {
            if *vertex == 12 {
                *vertex = 7;
            }
        }
        let found = loops(&mesh);
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|found| found.vertices.len() == 4));
    }

    #[test]
    fn a_t_junction_is_a_loop_without_width() {
        let mut mesh = cuboid([0.0; 3], [1.0; 3]);
        // The lid's edge from 4 to 5 has a vertex that the side below does not know.
        mesh.positions.push([0.5, 0.0, 1.0]);
        mesh.triangles[10] = [4, 8, 7];
        mesh.triangles.push([8, 5, 7]);
        let found = loops(&mesh);
        assert_eq!(found.len(), 1);
        let mut vertices = found[0].vertices.clone();
        vertices.sort_unstable();
        assert_eq!(vertices, [4, 5, 8]);
    }
}
