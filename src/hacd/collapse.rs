//! The algorithm of HACD [4.2]: a dual graph with one node per triangle, and half-edge collapses,
//! the cheapest first, until none costs less than β.
//!
//! The cost of an edge is equation (4) for the union S of the surfaces at its ends,
//!
//! cost(S) = max over M in S of ‖M − P_S(M)‖ / D_S + α E_shape(S), α = β ℓ / (10 D_S)
//!
//! where ℓ is the length that counts as 1: the paper's α is one over a length, so that without it
//! the result would depend on the mesh's units.
//!
//! A collapse changes the costs of the edges at the node that remains, and no other. Costs of at
//! least β are never needed, so they are not computed to the end and not kept: an edge that is
//! too costly stays so until one of its ends changes.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::surface::{Depth, Surface, joint_depth, joint_hull};
use crate::hull::HullBuilder;
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::surface::grouping::Grouping;
use crate::vector::{Vector, distance};
use crate::{Control, Error};

/// The share of β that the shape factor of a disc of diameter ℓ has, as in equation (4).
const SHAPE_SHARE: f64 = 0.1;

/// Collapses between two looks at the control: fewer would cost time, more would delay a stop.
const COLLAPSES_PER_CHECK: usize = 64;

/// β, and ℓ in the mesh's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Threshold {
    pub concavity: f64,
    pub length: f64,
}

/// An edge of the dual graph with its cost at the time when it was judged.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    cost: f64,
    nodes: [u32; 2],
    /// How often each node had changed by then.
    versions: [u32; 2],
    deepest: u32,
}

impl Eq for Edge {}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        let rest = |edge: &Self| (edge.nodes, edge.versions);
        self.cost.total_cmp(&other.cost).then_with(|| rest(self).cmp(&rest(other)))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The dual graph.
struct DualGraph<'a> {
    mesh: &'a TriangleMesh,
    threshold: Threshold,
    surfaces: Vec<Surface>,
    /// For each node its neighbours, ascending, with the length of the border to each.
    neighbours: Vec<Vec<(u32, f64)>>,
    versions: Vec<u32>,
    queue: BinaryHeap<Reverse<Edge>>,
    builder: HullBuilder,
    scratch: Vec<Vector>,
}

/// Groups the triangles of a mesh. The number of collapses is at most that of triangles; each
/// judges the edges of one node anew, at O(vertices · hull faces) of the union.
pub(super) fn collapse(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    threshold: Threshold,
    control: &Control,
) -> Result<Grouping, Error> {
    let mut graph = DualGraph::new(mesh, adjacency, threshold);
    let mut collapses: usize = 0;
    while let Some(edge) = graph.cheapest() {
        graph.collapse(edge);
        collapses += 1;
        if collapses.is_multiple_of(COLLAPSES_PER_CHECK) {
            control.check()?;
            if control.is_past_deadline() {
                return Err(Error::DeadlineExceeded);
            }
        }
    }
    Ok(graph.grouping())
}

impl<'a> DualGraph<'a> {
    fn new(mesh: &'a TriangleMesh, adjacency: &Adjacency, threshold: Threshold) -> Self {
        let count = mesh.triangles.len();
        let surfaces = (0..count as u32).map(|t| Surface::triangle(mesh, t)).collect();
        let neighbours = (0..count as u32).map(|t| dual_edges(mesh, adjacency, t)).collect();
        let mut graph = Self {
            mesh,
            threshold,
            surfaces,
            neighbours,
            versions: vec![0; count],
            queue: BinaryHeap::new(),
            builder: HullBuilder::new(),
            scratch: Vec::new(),
        };
        for node in 0..count as u32 {
            graph.judge_edges_of(node, |other| other > node);
        }
        graph
    }

    /// Puts the edges to the chosen neighbours of a node into the queue.
    fn judge_edges_of(&mut self, node: u32, is_chosen: impl Fn(u32) -> bool) {
        for place in 0..self.neighbours[node as usize].len() {
            let (other, shared) = self.neighbours[node as usize][place];
            if is_chosen(other)
                && let Some((cost, deepest)) = self.cost(node, other, shared)
            {
                let nodes = [node.min(other), node.max(other)];
                let versions = nodes.map(|node| self.versions[node as usize]);
                self.queue.push(Reverse(Edge { cost, nodes, versions, deepest }));
            }
        }
    }

    /// Equation (4) and the deepest vertex, or `None` where the cost is at least β.
    fn cost(&mut self, first: u32, second: u32, shared: f64) -> Option<(f64, u32)> {
        let Threshold { concavity, length } = self.threshold;
        let [first, second] = [first, second].map(|node| &self.surfaces[node as usize]);
        let diagonal = first.joint_diagonal(second);
        let alpha = SHAPE_SHARE * concavity * length / diagonal;
        let shape = alpha * first.joint_shape_factor(second, shared);
        // Also where it is not a number, as for surfaces without area.
        if !(shape < concavity) {
            return None;
        }
        let limit = (concavity - shape) * diagonal;
        let (builder, scratch) = (&mut self.builder, &mut self.scratch);
        let Depth { depth, deepest } =
            joint_depth(self.mesh, first, second, limit, builder, scratch)?;
        Some((depth / diagonal + shape, deepest))
    }

    /// The cheapest edge whose cost still holds.
    fn cheapest(&mut self) -> Option<Edge> {
        while let Some(Reverse(edge)) = self.queue.pop() {
            if edge.versions == edge.nodes.map(|node| self.versions[node as usize]) {
                return Some(edge);
            }
        }
        None
    }

    /// Joins the two surfaces of an edge in the node with more triangles.
    fn collapse(&mut self, edge: Edge) {
        let [low, high] = edge.nodes;
        let size = |node: u32| self.surfaces[node as usize].triangles.len();
        let (kept, gone) = if size(low) >= size(high) { (low, high) } else { (high, low) };
        let (keep, go) = (kept as usize, gone as usize);
        let absorbed = std::mem::take(&mut self.surfaces[go]);
        let borders = std::mem::take(&mut self.neighbours[go]);
        self.versions[keep] += 1;
        self.versions[go] += 1;

        let shared = self.neighbours[keep].iter().find(|&&(other, _)| other == gone);
        let shared = shared.map_or(0.0, |&(_, length)| length);
        let (builder, scratch) = (&mut self.builder, &mut self.scratch);
        let hull = joint_hull(&self.surfaces[keep], &absorbed, builder, scratch);
        self.surfaces[keep].absorb(absorbed, shared, hull.map(|hull| hull.points), edge.deepest);

        remove(&mut self.neighbours[keep], gone);
        for (other, length) in borders {
            if other != kept {
                remove(&mut self.neighbours[other as usize], gone);
                add_border(&mut self.neighbours[other as usize], kept, length);
                add_border(&mut self.neighbours[keep], other, length);
            }
        }
        self.judge_edges_of(kept, |_| true);
    }

    /// Labels in the order of each surface's first triangle.
    fn grouping(&self) -> Grouping {
        let mut groups: Vec<&[u32]> =
            self.surfaces.iter().map(|s| &s.triangles[..]).filter(|t| !t.is_empty()).collect();
        groups.sort_unstable_by_key(|triangles| triangles.iter().min().copied());
        let mut labels = vec![0; self.mesh.triangles.len()];
        for (label, triangles) in (0..).zip(&groups) {
            for &triangle in *triangles {
                labels[triangle as usize] = label;
            }
        }
        Grouping { labels, count: groups.len() }
    }
}

/// The neighbours of a triangle, ascending, each once, with the length of the shared sides.
fn dual_edges(mesh: &TriangleMesh, adjacency: &Adjacency, triangle: u32) -> Vec<(u32, f64)> {
    let corners = mesh.triangles[triangle as usize].map(|v| mesh.positions[v as usize]);
    let mut edges = Vec::with_capacity(3);
    for (side, neighbour) in adjacency.triangle_neighbours(triangle).into_iter().enumerate() {
        if neighbour != NO_NEIGHBOUR && neighbour != triangle {
            add_border(&mut edges, neighbour, distance(corners[side], corners[(side + 1) % 3]));
        }
    }
    edges
}

fn remove(borders: &mut Vec<(u32, f64)>, node: u32) {
    if let Ok(place) = borders.binary_search_by_key(&node, |&(other, _)| other) {
        borders.remove(place);
    }
}

fn add_border(borders: &mut Vec<(u32, f64)>, node: u32, length: f64) {
    match borders.binary_search_by_key(&node, |&(other, _)| other) {
        Ok(place) => borders[place].1 += length,
        Err(place) => borders.insert(place, (node, length)),
    }
}
