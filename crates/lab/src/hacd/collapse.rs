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
//! A collapse changes the costs of the edges at the node that remains, and no other. Of those an
//! edge enters the queue with a lower bound that is cheap to have: the shape factor's part, and the
//! depth that a vertex had in one of its surfaces. Only an edge that comes to the front is judged, and goes back with its true cost. That is the same
//! order of collapses as if all were judged at once. Costs of at least β are never needed, so they
//! are not computed to the end and not kept: an edge that is too costly stays so until one of its
//! ends changes.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use hullwright::{Control, Error, TriangleMesh};

use super::surface::{Depth, Judge, Surface};
use super::{Neighbours, corners};

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

/// An edge of the dual graph.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    /// A lower bound until the edge is judged.
    cost: f64,
    nodes: [u32; 2],
    /// How often each node had changed when the edge entered the queue.
    versions: [u32; 2],
    /// Length of the border between the surfaces.
    length: f64,
    /// Known once the edge is judged.
    depth: Option<Depth>,
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

/// A neighbour, and the length of the border to it.
type Border = (u32, f64);

/// The dual graph.
struct DualGraph<'a> {
    mesh: &'a TriangleMesh,
    threshold: Threshold,
    surfaces: Vec<Surface>,
    /// For each node its borders, in the order of the neighbours.
    borders: Vec<Vec<Border>>,
    versions: Vec<u32>,
    queue: BinaryHeap<Reverse<Edge>>,
    judge: Judge<'a>,
}

/// Groups the triangles of a mesh: the group of each, and the number of groups. There are fewer collapses than triangles, and at least one
/// judgement for each, at O(vertices · hull faces) of the union.
pub(super) fn collapse(
    mesh: &TriangleMesh,
    neighbours: &Neighbours,
    threshold: Threshold,
    control: &Control,
) -> Result<(Vec<u32>, usize), Error> {
    let mut graph = DualGraph::new(mesh, neighbours, threshold);
    let mut collapses: usize = 0;
    while let Some((edge, depth)) = graph.cheapest() {
        graph.collapse(edge, depth);
        collapses += 1;
        if collapses.is_multiple_of(COLLAPSES_PER_CHECK) {
            if control.is_cancelled() {
                return Err(Error::Cancelled);
            }
            if control.is_past_deadline() {
                return Err(Error::DeadlineExceeded);
            }
        }
    }
    Ok(graph.groups())
}

impl<'a> DualGraph<'a> {
    fn new(mesh: &'a TriangleMesh, neighbours: &Neighbours, threshold: Threshold) -> Self {
        let count = mesh.triangles.len();
        let surfaces = (0..count as u32).map(|t| Surface::triangle(mesh, t)).collect();
        let borders = (0..count as u32).map(|t| sides(mesh, neighbours, t)).collect();
        let mut graph = Self {
            mesh,
            threshold,
            surfaces,
            borders,
            versions: vec![0; count],
            queue: BinaryHeap::new(),
            judge: Judge::new(mesh),
        };
        for node in 0..count as u32 {
            graph.enqueue_edges_of(node, |other| other > node);
        }
        graph
    }

    /// Puts the edges to the chosen neighbours of a node into the queue.
    fn enqueue_edges_of(&mut self, node: u32, is_chosen: impl Fn(u32) -> bool) {
        for &(neighbour, length) in &self.borders[node as usize] {
            if !is_chosen(neighbour) {
                continue;
            }
            let [first, second] = [node, neighbour].map(|node| &self.surfaces[node as usize]);
            let (diagonal, shape) = self.threshold.shape_cost(first, second, length);
            let cost = first.least_joint_depth(second) / diagonal + shape;
            // Not where it is not a number either, as for surfaces without area.
            if cost < self.threshold.concavity {
                let nodes = [node.min(neighbour), node.max(neighbour)];
                let versions = nodes.map(|node| self.versions[node as usize]);
                self.queue.push(Reverse(Edge { cost, nodes, versions, length, depth: None }));
            }
        }
    }

    /// Takes out the cheapest edge that still holds.
    fn cheapest(&mut self) -> Option<(Edge, Depth)> {
        while let Some(Reverse(edge)) = self.queue.pop() {
            if edge.versions != edge.nodes.map(|node| self.versions[node as usize]) {
                continue;
            }
            match edge.depth {
                Some(depth) => return Some((edge, depth)),
                None => self.judge(edge),
            }
        }
        None
    }

    /// Puts an edge back with its cost by equation (4), unless that is at least β.
    fn judge(&mut self, edge: Edge) {
        let [first, second] = edge.nodes.map(|node| &self.surfaces[node as usize]);
        let (diagonal, shape) = self.threshold.shape_cost(first, second, edge.length);
        let limit = (self.threshold.concavity - shape) * diagonal;
        let hull = self.judge.joint_hull(first, second);
        let depth = self.judge.joint_depth(first, second, hull.as_ref(), limit);
        if depth.depth < limit {
            let cost = depth.depth / diagonal + shape;
            self.queue.push(Reverse(Edge { cost, depth: Some(depth), ..edge }));
        }
    }

    /// Joins the two surfaces of an edge in the node with more triangles.
    fn collapse(&mut self, edge: Edge, depth: Depth) {
        let [low, high] = edge.nodes;
        let [first, second] = edge.nodes.map(|node| &self.surfaces[node as usize]);
        let hull = self.judge.joint_hull(first, second);
        let (kept, gone) =
            if first.triangles.len() >= second.triangles.len() { (low, high) } else { (high, low) };
        let (keep, go) = (kept as usize, gone as usize);
        let absorbed = std::mem::take(&mut self.surfaces[go]);
        let borders = std::mem::take(&mut self.borders[go]);
        self.versions[keep] += 1;
        self.versions[go] += 1;
        remove(&mut self.borders[keep], gone);
        for (neighbour, length) in borders.into_iter().filter(|border| border.0 != kept) {
            remove(&mut self.borders[neighbour as usize], gone);
            add(&mut self.borders[neighbour as usize], (kept, length));
            add(&mut self.borders[keep], (neighbour, length));
        }
        self.surfaces[keep].absorb(absorbed, edge.length, hull, depth);
        self.enqueue_edges_of(kept, |_| true);
    }

    /// Labels in the order of each surface's first triangle.
    fn groups(&self) -> (Vec<u32>, usize) {
        let mut groups: Vec<&[u32]> =
            self.surfaces.iter().map(|s| &s.triangles[..]).filter(|t| !t.is_empty()).collect();
        groups.sort_unstable_by_key(|triangles| triangles.iter().min().copied());
        let mut labels = vec![0; self.mesh.triangles.len()];
        for (label, triangles) in (0..).zip(&groups) {
            for &triangle in *triangles {
                labels[triangle as usize] = label;
            }
        }
        (labels, groups.len())
    }
}

impl Threshold {
    /// D_S and α E_shape(S) for the union S of two surfaces.
    pub(super) fn shape_cost(&self, first: &Surface, second: &Surface, shared: f64) -> (f64, f64) {
        let diagonal = first.joint_diagonal(second);
        let alpha = SHAPE_SHARE * self.concavity * self.length / diagonal;
        (diagonal, alpha * first.joint_shape_factor(second, shared))
    }
}

/// The borders of a triangle.
fn sides(mesh: &TriangleMesh, neighbours: &Neighbours, triangle: u32) -> Vec<Border> {
    let corners = corners(mesh, triangle);
    let mut borders = Vec::with_capacity(3);
    for (side, neighbour) in neighbours[triangle as usize].into_iter().enumerate() {
        if let Some(neighbour) = neighbour.filter(|&neighbour| neighbour != triangle) {
            let length = corners[side].distance(corners[(side + 1) % 3]);
            add(&mut borders, (neighbour, length));
        }
    }
    borders
}

fn place_of(borders: &[Border], neighbour: u32) -> Result<usize, usize> {
    borders.binary_search_by_key(&neighbour, |border| border.0)
}

fn remove(borders: &mut Vec<Border>, neighbour: u32) {
    if let Ok(place) = place_of(borders, neighbour) {
        borders.remove(place);
    }
}

/// Two borders to the same neighbour are one, as long as both together.
fn add(borders: &mut Vec<Border>, border: Border) {
    match place_of(borders, border.0) {
        Ok(place) => borders[place].1 += border.1,
        Err(place) => borders.insert(place, border),
    }
}
