//! Grouping by HACD [4.2], hierarchical approximate convex decomposition (Mamou and Ghorbel 2009),
//! which the paper compares its own grouping with: a dual graph with one node per triangle, and
//! half-edge collapses, the cheapest first, until none costs less than β.
//!
//! The cost of an edge is equation (4) for the union S of the surfaces at its ends,
//!
//! cost(S) = max over M in S of ‖M − P_S(M)‖ / D_S + α E_shape(S), α = β ℓ / (10 D_S),
//! E_shape(S) = ρ²(S) / (4 π σ(S))
//!
//! with the perimeter ρ, the area σ and the diagonal D_S.
//!
//! Where the paper is silent:
//! - **β** is not given.
//! - **α** is one over a length in the paper, added to a share of a length, so the result would
//!   depend on the unit of the mesh. Here it is multiplied by ℓ, the average diagonal of the
//!   mesh's triangles: α starts at about β / 10, as in the first publication of HACD, and falls while
//!   surfaces grow. The diagonal of the mesh can't be meant: then hardly any two triangles of a
//!   fine mesh could be joined.
//! - The node with more triangles remains; of equal costs the pair with the lower numbers goes
//!   first.
//!
//! A collapse changes the costs of the edges at the node that remains, and no other. Of those an
//! edge enters the queue with a lower bound that takes little time: the shape factor's part, and
//! the depth that a vertex had before, in one of the surfaces or when the edge was judged last. Only an
//! edge that comes to the front is judged, and goes back with its cost. That is the same order of
//! collapses as if all were judged at once. Costs of at least β are not needed, so they are not
//! computed to the end and not kept: an edge that is too costly stays so until one of its ends
//! changes.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use super::cost::{distance_to_exit, is_cancelled};
use crate::control::Control;
use crate::error::Error;
use crate::geometry::plane::Plane;
use crate::geometry::vector::{Vector, area_normal, as_arrays, bounds, diagonal, squared};
use crate::hull::{ConvexHull, DEFAULT_TOLERANCE, HullBuilder, Shape};
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::grouping::{Grouping, corners};

/// The part of β that the shape factor of a disc of diameter ℓ has, as in equation (4).
const SHAPE_SHARE: f64 = 0.1;

/// Collapses between two checks of the control: fewer would cost time, more would delay a stop.
const COLLAPSES_PER_CHECK: usize = 64;

/// Depths below this share of the hull's extent are rounding: a hundredth of the hull's tolerance.
const NEGLIGIBLE: f64 = DEFAULT_TOLERANCE / 100.0;

/// How much a hull may lack of another within it, of its extent: by its tolerance.
const HULL_SLACK: f64 = 4.0 * DEFAULT_TOLERANCE;

/// Groups the triangles of a mesh; groups count up in the order of their first triangles. Fewer
/// collapses than triangles, and at least one judgement for each, at O(vertices · hull faces) of
/// the union.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn group(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    concavity_threshold: f64,
    control: &Control,
) -> Result<Grouping, Error> {
    let mut graph = DualGraph::new(mesh, adjacency, concavity_threshold);
    let mut collapses: usize = 0;
    while let Some((edge, judgement)) = graph.cheapest() {
        graph.collapse(edge, judgement);
        collapses += 1;
        if collapses.is_multiple_of(COLLAPSES_PER_CHECK) {
            control.check()?;
        }
    }
    Ok(graph.grouping())
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
    border: f64,
    /// Once the edge is judged: the vertex that is deepest in the hull of both.
    deepest: Option<Deepest>,
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

/// The border to a neighbour.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Border {
    neighbour: u32,
    length: f64,
    /// A vertex that is at least so deep in the hull of both: what was the deepest one when both
    /// were judged last. While they grow the hull is farther to leave, unless the normal changes.
    deep: Deepest,
}

struct DualGraph<'a> {
    mesh: &'a TriangleMesh,
    /// β.
    threshold: f64,
    /// ℓ, in the mesh's space.
    length: f64,
    surfaces: Vec<Surface>,
    /// For each node its borders, in the order of the neighbours.
    borders: Vec<Vec<Border>>,
    versions: Vec<u32>,
    queue: BinaryHeap<Reverse<Edge>>,
    builder: HullBuilder,
}

impl<'a> DualGraph<'a> {
    fn new(mesh: &'a TriangleMesh, adjacency: &Adjacency, threshold: f64) -> Self {
        let count = mesh.triangles.len();
        let nodes = 0..count as u32;
        let of_one = |triangle| diagonal(corners(mesh, triangle));
        let mut graph = Self {
            mesh,
            threshold,
            length: nodes.clone().map(of_one).sum::<f64>() / count.max(1) as f64,
            surfaces: nodes.clone().map(|triangle| Surface::triangle(mesh, triangle)).collect(),
            borders: nodes.clone().map(|triangle| sides(mesh, adjacency, triangle)).collect(),
            versions: vec![0; count],
            queue: BinaryHeap::new(),
            builder: HullBuilder::new(),
        };
        nodes.for_each(|node| graph.enqueue_edges(node, |other| other > node));
        graph
    }

    /// Puts the edges to the chosen neighbours of a node into the queue.
    fn enqueue_edges(&mut self, node: u32, is_chosen: impl Fn(u32) -> bool) {
        for &Border { neighbour, length: border, deep } in &self.borders[node as usize] {
            if !is_chosen(neighbour) {
                continue;
            }
            let [first, second] = [node, neighbour].map(|node| &self.surfaces[node as usize]);
            let (diagonal, shape) = self.shape_cost(first, second, border);
            let slack = HULL_SLACK * diagonal;
            let depth = first.least_joint_depth(second).max(deep.depth) - slack;
            let cost = depth.max(0.0) / diagonal + shape;
            // Not where it is not a number either, as for surfaces without area.
            if cost < self.threshold {
                let nodes = [node.min(neighbour), node.max(neighbour)];
                let versions = nodes.map(|node| self.versions[node as usize]);
                self.queue.push(Reverse(Edge { cost, nodes, versions, border, deepest: None }));
            }
        }
    }

    /// Takes out the cheapest edge that still holds.
    fn cheapest(&mut self) -> Option<(Edge, Deepest)> {
        while let Some(Reverse(edge)) = self.queue.pop() {
            if edge.versions != edge.nodes.map(|node| self.versions[node as usize]) {
                continue;
            }
            match edge.deepest {
                Some(deepest) => return Some((edge, deepest)),
                None => self.judge(edge),
            }
        }
        None
    }

    /// Puts an edge back with its cost by equation (4), unless that is at least β.
    fn judge(&mut self, edge: Edge) {
        let [first, second] = edge.nodes.map(|node| &self.surfaces[node as usize]);
        let (diagonal, shape) = self.shape_cost(first, second, edge.border);
        let limit = (self.threshold - shape) * diagonal;
        let hull = joint_hull(&mut self.builder, first, second);
        let deepest = joint_deepest(self.mesh, first, second, hull.as_ref(), limit);
        for [node, neighbour] in [edge.nodes, [edge.nodes[1], edge.nodes[0]]] {
            let borders = &mut self.borders[node as usize];
            if let Ok(place) = place_of(borders, neighbour) {
                borders[place].deep = deepest;
            }
        }
        if deepest.depth < limit {
            let cost = deepest.depth / diagonal + shape;
            self.queue.push(Reverse(Edge { cost, deepest: Some(deepest), ..edge }));
        }
    }

    /// D_S and α E_shape(S) for the union S of two surfaces.
    fn shape_cost(&self, first: &Surface, second: &Surface, border: f64) -> (f64, f64) {
        let diagonal = first.joint_diagonal(second);
        let alpha = SHAPE_SHARE * self.threshold * self.length / diagonal;
        (diagonal, alpha * first.joint_shape_factor(second, border))
    }

    /// Joins the two surfaces of an edge in the node with more triangles.
    fn collapse(&mut self, edge: Edge, deepest: Deepest) {
        let [low, high] = edge.nodes;
        let [first, second] = edge.nodes.map(|node| &self.surfaces[node as usize]);
        let hull = joint_hull(&mut self.builder, first, second);
        let is_first_larger = first.triangles.len() >= second.triangles.len();
        let (kept, gone) = if is_first_larger { (low, high) } else { (high, low) };
        let (keep, go) = (kept as usize, gone as usize);
        let absorbed = std::mem::take(&mut self.surfaces[go]);
        let mut borders = std::mem::take(&mut self.borders[go]);
        absorbed.forget_depths_at_corners(&mut self.borders[keep]);
        self.surfaces[keep].forget_depths_at_corners(&mut borders);
        self.versions[keep] += 1;
        self.versions[go] += 1;
        remove(&mut self.borders[keep], gone);
        for border in borders.into_iter().filter(|border| border.neighbour != kept) {
            remove(&mut self.borders[border.neighbour as usize], gone);
            add(&mut self.borders[keep], border);
        }
        for border in self.borders[keep].clone() {
            let others = &mut self.borders[border.neighbour as usize];
            remove(others, kept);
            add(others, Border { neighbour: kept, ..border });
        }
        self.surfaces[keep].absorb(absorbed, edge.border, hull, deepest);
        self.enqueue_edges(kept, |_| true);
    }

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

/// The borders of a triangle.
fn sides(mesh: &TriangleMesh, adjacency: &Adjacency, triangle: u32) -> Vec<Border> {
    let corners = corners(mesh, triangle);
    let mut borders = Vec::with_capacity(3);
    for (side, neighbour) in adjacency.triangle_neighbours(triangle).into_iter().enumerate() {
        if neighbour != NO_NEIGHBOUR && neighbour != triangle {
            let length = corners[side].distance(corners[(side + 1) % 3]);
            add(&mut borders, Border { neighbour, length, deep: Deepest::default() });
        }
    }
    borders
}

fn place_of(borders: &[Border], neighbour: u32) -> Result<usize, usize> {
    borders.binary_search_by_key(&neighbour, |border| border.neighbour)
}

fn remove(borders: &mut Vec<Border>, neighbour: u32) {
    if let Ok(place) = place_of(borders, neighbour) {
        borders.remove(place);
    }
}

/// Two borders to the same neighbour are one, as long as both together.
fn add(borders: &mut Vec<Border>, border: Border) {
    match place_of(borders, border.neighbour) {
        Ok(place) => {
            let known = &mut borders[place];
            known.length += border.length;
            if border.deep.depth > known.deep.depth {
                known.deep = border.deep;
            }
        }
        Err(place) => borders.insert(place, border),
    }
}

/// A vertex, and how far it is from its projection on the hull.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Deepest {
    depth: f64,
    vertex: u32,
}

/// A vertex of a surface: the sum of the unit normals of the surface's own triangles at it, which
/// is the direction of its normal with respect to the surface, and the number of them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Corner {
    vertex: u32,
    normal: Vector,
    count: f64,
}

/// What a node stands for: adjacent triangles.
#[derive(Debug, Clone, Default, PartialEq)]
struct Surface {
    triangles: Vec<u32>,
    /// Ascending by vertex.
    corners: Vec<Corner>,
    /// Vertices of the convex hull: all that a larger hull needs of this one. All vertices while
    /// the surface is flat.
    hull_points: Vec<Vector>,
    /// It likely is the deepest vertex of a larger surface too.
    deepest: Deepest,
    /// ρ(S): length of the border.
    perimeter: f64,
    /// σ(S).
    area: f64,
    low: Vector,
    high: Vector,
}

impl Surface {
    fn triangle(mesh: &TriangleMesh, triangle: u32) -> Self {
        let points @ [a, b, c] = corners(mesh, triangle);
        let doubled = area_normal(a, b, c);
        let normal = doubled.normalize_or_zero();
        let vertices = mesh.triangles[triangle as usize];
        let mut corners = vertices.map(|vertex| Corner { vertex, normal, count: 1.0 }).to_vec();
        corners.sort_unstable_by_key(|corner| corner.vertex);
        let (low, high) = bounds(points);
        Self {
            triangles: vec![triangle],
            corners,
            hull_points: points.to_vec(),
            deepest: Deepest { depth: 0.0, vertex: vertices[0] },
            perimeter: a.distance(b) + b.distance(c) + c.distance(a),
            area: doubled.length() / 2.0,
            low,
            high,
        }
    }

    /// D_S of the union with another surface.
    fn joint_diagonal(&self, other: &Self) -> f64 {
        self.high.max(other.high).distance(self.low.min(other.low))
    }

    fn joint_perimeter(&self, other: &Self, border: f64) -> f64 {
        (self.perimeter + other.perimeter - 2.0 * border).max(0.0)
    }

    /// E_shape of the union with another surface, along a border of the given length: 1 for a
    /// flat disc, more for what is long or ragged, 0 for what is closed.
    fn joint_shape_factor(&self, other: &Self, border: f64) -> f64 {
        squared(self.joint_perimeter(other, border)) / (4.0 * PI * (self.area + other.area))
    }

    /// The depth that a union with another surface has at least: a larger hull is farther to leave,
    /// unless the other surface changes the normal.
    fn least_joint_depth(&self, other: &Self) -> f64 {
        let kept = |surface: &Self, other: &Self| match other.corner(surface.deepest.vertex) {
            Some(_) => 0.0,
            None => surface.deepest.depth,
        };
        kept(self, other).max(kept(other, self))
    }

    /// Drops what is known of vertices whose normals change when their surface grows by this one.
    fn forget_depths_at_corners(&self, borders: &mut [Border]) {
        for border in borders {
            if self.corner(border.deep.vertex).is_some() {
                border.deep = Deepest::default();
            }
        }
    }

    fn corner(&self, vertex: u32) -> Option<Corner> {
        let place = self.corners.binary_search_by_key(&vertex, |corner| corner.vertex).ok()?;
        self.corners.get(place).copied()
    }

    /// Takes in another surface. `hull` is that of both, or nothing where both are flat.
    fn absorb(&mut self, other: Self, border: f64, hull: Option<ConvexHull>, deepest: Deepest) {
        self.perimeter = self.joint_perimeter(&other, border);
        self.corners = union(&self.corners, &other.corners).collect();
        match hull {
            Some(hull) => self.hull_points = hull.points().to_vec(),
            None => self.hull_points.extend(other.hull_points),
        }
        self.triangles.extend(other.triangles);
        self.deepest = deepest;
        self.area += other.area;
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }
}

/// The corners of two surfaces, ascending, each vertex once, with its normal with respect to both.
fn union<'a>(first: &'a [Corner], second: &'a [Corner]) -> impl Iterator<Item = Corner> + 'a {
    let (mut first, mut second) = (first.iter().peekable(), second.iter().peekable());
    std::iter::from_fn(move || match (first.peek(), second.peek()) {
        (Some(a), Some(b)) => match a.vertex.cmp(&b.vertex) {
            Ordering::Less => first.next().copied(),
            Ordering::Greater => second.next().copied(),
            Ordering::Equal => Some(sum(*first.next()?, *second.next()?)),
        },
        (Some(_), None) => first.next().copied(),
        (None, _) => second.next().copied(),
    })
}

/// A vertex with the triangles of both surfaces at it.
fn sum(first: Corner, second: Corner) -> Corner {
    let Corner { vertex, normal, count } = first;
    Corner { vertex, normal: normal + second.normal, count: count + second.count }
}

/// The hull of two surfaces, from the vertices of their hulls. `None` where they are flat.
fn joint_hull(builder: &mut HullBuilder, first: &Surface, second: &Surface) -> Option<ConvexHull> {
    let points = [&first.hull_points[..], &second.hull_points].concat();
    let shape = builder.build(as_arrays(&points));
    (shape == Shape::Solid).then(|| builder.extract().into())
}

/// The deepest vertex of the union of two surfaces in their hull, or any vertex that lies at least
/// `limit` deep. 0 where the union is flat, and so has no hull.
/// O(hull faces · vertices that are not the hull's).
fn joint_deepest(
    mesh: &TriangleMesh,
    first: &Surface,
    second: &Surface,
    hull: Option<&ConvexHull>,
    limit: f64,
) -> Deepest {
    let mut found = Deepest { depth: 0.0, vertex: first.deepest.vertex };
    let Some(hull) = hull else { return found };
    let planes: Vec<Plane> = hull.face_planes();
    let negligible = NEGLIGIBLE * first.joint_diagonal(second);
    // The deepest so far come first: the deeper the start, the less is left for the others.
    let deepest = [first, second].into_iter().filter_map(|surface| {
        let vertex = surface.deepest.vertex;
        match (first.corner(vertex), second.corner(vertex)) {
            (Some(a), Some(b)) => Some(sum(a, b)),
            (a, b) => a.or(b),
        }
    });
    for Corner { vertex, normal, count } in deepest.chain(union(&first.corners, &second.corners)) {
        if is_cancelled(normal, count) {
            continue;
        }
        let point = mesh.points()[vertex as usize];
        let enough = found.depth.max(negligible);
        let depth = distance_to_exit(point, normal.normalize_or_zero(), &planes, enough);
        if depth > enough {
            found = Deepest { depth, vertex };
        }
        if found.depth >= limit {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests;
