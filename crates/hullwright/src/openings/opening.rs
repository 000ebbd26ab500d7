//! Openings: the boundary of a surface as simple loops, and what became of each.
//!
//! A half-edge is on the boundary where more triangles run along its edge one way than the other.
//! What closes the surface runs the other way: the loops here do. A T-junction, a long edge with
//! vertices of its neighbours on it, is a loop without width.

use crate::geometry::vector::{Vector, mean};
use crate::mesh::PreparedMesh;
use crate::mesh::adjacency::SortedHalfEdges;
use crate::sorting::sort_by_key;

/// A simple closed polygon along the boundary.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loop {
    /// In the direction in which a cap runs along it.
    pub vertices: Vec<u32>,
    /// For each vertex a triangle of the surface at the edge to the next vertex.
    pub neighbours: Vec<u32>,
}

impl Loop {
    /// For each side its triangle of the surface, and its length.
    pub(super) fn sides(&self, positions: &[Vector]) -> impl Iterator<Item = (u32, f64)> {
        let length = |a: u32, b: u32| positions[a as usize].distance(positions[b as usize]);
        let lengths = sides(&self.vertices).map(move |(&a, &b)| length(a, b));
        self.neighbours.iter().copied().zip(lengths)
    }
}

/// The sides of a closed polygon.
pub(super) fn sides<T>(corners: &[T]) -> impl Iterator<Item = (&T, &T)> {
    corners.iter().zip(corners.iter().cycle().skip(1))
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
        for half_edge in edge.unpaired(triangles) {
            let (triangle, k) = (half_edge / 3, half_edge as usize % 3);
            let corners = triangles[triangle as usize];
            edges.push(CapEdge { from: corners[(k + 1) % 3], to: corners[k], neighbour: triangle });
        }
    });
    sort_by_key(&mut edges, |edge| (edge.from, edge.to, edge.neighbour));
    edges
}

/// An opening of the mesh: a loop of open edges, with the loops that are holes in its cap.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Opening {
    /// Open edges around it, those of holes included.
    pub edges: usize,
    /// Area of its cap, in squared units. Where there is no cap, the length of the vector area.
    pub area: f64,
    /// Middle of its vertices, in units.
    pub centre: [f64; 3],
    /// Whether it was closed, or why not.
    pub outcome: OpeningOutcome,
}

/// What became of an opening.
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum OpeningOutcome {
    /// A cap closes it.
    Closed,
    /// A cap closes it, within the solid, where nothing can touch it.
    ClosedWithin,
    /// Left: its vertices are farther from a plane than the bound.
    NotFlat,
    /// Left: its outline crosses itself, or has more than 10,000 vertices.
    NotSimple,
    /// Left: a cap would lie on the surface around it, at less than 30° in the median.
    Sheet,
    /// Left: the surface goes through the cap.
    Cut,
    /// Left: its surface is drawn from both sides, and it does not lie in the lowest plane.
    TwoSided,
    /// Left: the fronts of faces are seen through it, or a way out.
    SeenInto,
    /// Left: what is beyond it is inside already, and would not be with a cap.
    SolidBeyond,
    /// Left: most of the boundary of its component stays open.
    Fragment,
}

impl OpeningOutcome {
    /// Whether a cap closes it.
    pub fn is_closed(self) -> bool {
        matches!(self, Self::Closed | Self::ClosedWithin)
    }

    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::ClosedWithin => "closed within the solid",
            Self::NotFlat => "left: not flat within the bound",
            Self::NotSimple => "left: its outline crosses itself",
            Self::Sheet => "left: a cap would lie on the sheet around it",
            Self::Cut => "left: the surface goes through it",
            Self::TwoSided => "left: drawn from both sides, and not at the bottom",
            Self::SeenInto => "left: the inside is seen through it",
            Self::SolidBeyond => "left: the solid goes on beyond it",
            Self::Fragment => "left: most of the part around it stays open",
        }
    }
}

impl Opening {
    /// Of the vertices around it. The area is normalised.
    pub(super) fn new(
        vertices: impl Iterator<Item = u32>,
        area: f64,
        prepared: &PreparedMesh,
        outcome: OpeningOutcome,
    ) -> Self {
        let points = prepared.mesh.points();
        let points: Vec<Vector> = vertices.map(|vertex| points[vertex as usize]).collect();
        let normalization = &prepared.normalization;
        let area = area * normalization.diagonal * normalization.diagonal;
        let centre = normalization.restore(mean(&points)).to_array();
        Self { edges: points.len(), area, centre, outcome }
    }

    /// Of a loop without a cap.
    pub(super) fn left(own: &Loop, prepared: &PreparedMesh, outcome: OpeningOutcome) -> Self {
        let points: Vec<Vector> =
            own.vertices.iter().map(|&v| prepared.mesh.points()[v as usize]).collect();
        let centre = mean(&points);
        let twice =
            sides(&points).fold(Vector::ZERO, |sum, (&a, &b)| sum + (a - centre).cross(b - centre));
        Self::new(own.vertices.iter().copied(), 0.5 * twice.length(), prepared, outcome)
    }
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
    fn loops_that_touch_stay_apart() {
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
        // The lid's edge from 4 to 5 has a vertex that the side below does not have.
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
