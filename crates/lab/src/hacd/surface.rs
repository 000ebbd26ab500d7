//! A surface of HACD: what a node of the dual graph stands for, and what equation (4) asks of it.

use std::collections::HashMap;

use hullwright::TriangleMesh;
use hullwright::hull::{ConvexHull, HullBuilder, Shape};

use super::corners;
use crate::shapes::Vector;

/// A plane that the ray runs along cannot be left through it.
const PARALLEL: f64 = 1e-9;

/// Depths below this are noise: a hundredth of the hull's tolerance.
const NEGLIGIBLE: f64 = 1e-9;

/// How much a hull may lack of another within it, by its tolerance, in a mesh of diagonal 1.
const HULL_SLACK: f64 = 1e-6;

/// A set of adjacent triangles.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Surface {
    pub triangles: Vec<u32>,
    /// Vertices, ascending, each with the sum of the area normals of the surface's own triangles
    /// at it: the direction of its normal with respect to the surface.
    pub vertices: Vec<(u32, Vector)>,
    /// Vertices of the convex hull: all that a larger hull needs of this one. All vertices while
    /// the surface is flat.
    pub hull_points: Vec<Vector>,
    /// Its deepest vertex, which likely is that of a larger surface too.
    pub deepest: Depth,
    /// ρ(S): length of the border.
    pub perimeter: f64,
    /// σ(S).
    pub area: f64,
    pub low: Vector,
    pub high: Vector,
}

impl Surface {
    pub(super) fn triangle(mesh: &TriangleMesh, triangle: u32) -> Self {
        let [a, b, c] = corners(mesh, triangle);
        let normal = (b - a).cross(c - a);
        let corners = mesh.triangles[triangle as usize];
        let mut vertices = corners.map(|vertex| (vertex, normal)).to_vec();
        vertices.sort_unstable_by_key(|&(vertex, _)| vertex);
        Self {
            triangles: vec![triangle],
            vertices,
            hull_points: vec![a, b, c],
            deepest: Depth { depth: 0.0, vertex: corners[0] },
            perimeter: a.distance(b) + b.distance(c) + c.distance(a),
            area: normal.length() / 2.0,
            low: a.min(b).min(c),
            high: a.max(b).max(c),
        }
    }

    /// D_S of the union with another surface.
    pub(super) fn joint_diagonal(&self, other: &Self) -> f64 {
        self.high.max(other.high).distance(self.low.min(other.low))
    }

    /// E_shape of the union with another surface, along a border of the given length: 1 for a
    /// flat disc, more for what is long or ragged, 0 for what is closed.
    pub(super) fn joint_shape_factor(&self, other: &Self, shared: f64) -> f64 {
        let perimeter = (self.perimeter + other.perimeter - 2.0 * shared).max(0.0);
        perimeter * perimeter / (4.0 * std::f64::consts::PI * (self.area + other.area))
    }

    /// The depth that a union with another surface has at least: a larger hull is farther to
    /// leave, unless the other surface changes the normal.
    pub(super) fn least_joint_depth(&self, other: &Self) -> Depth {
        let [first, second] = [(self, other), (other, self)].map(|(surface, other)| {
            if other.contains(surface.deepest.vertex) { Depth::NONE } else { surface.deepest }
        });
        first.greater(second)
    }

    pub(super) fn contains(&self, vertex: u32) -> bool {
        self.place(vertex).is_some()
    }

    fn place(&self, vertex: u32) -> Option<usize> {
        self.vertices.binary_search_by_key(&vertex, |&(vertex, _)| vertex).ok()
    }

    /// The sum of area normals at a vertex; none where it is not the surface's.
    fn normal_at(&self, vertex: u32) -> Vector {
        self.place(vertex).map_or(Vector::ZERO, |place| self.vertices[place].1)
    }

    /// Takes in another surface. `hull` is that of both, or nothing where both are flat.
    pub(super) fn absorb(
        &mut self,
        other: Self,
        shared: f64,
        hull: Option<ConvexHull>,
        deepest: Depth,
    ) {
        self.vertices = union(&self.vertices, &other.vertices).collect();
        self.hull_points = match hull {
            Some(hull) => hull.points.into_iter().map(Vector::from).collect(),
            None => {
                let mut points = std::mem::take(&mut self.hull_points);
                points.extend(other.hull_points);
                let order = |a: &Vector, b: &Vector| {
                    let by_axis = |axis: usize| a[axis].total_cmp(&b[axis]);
                    by_axis(0).then_with(|| by_axis(1)).then_with(|| by_axis(2))
                };
                points.sort_unstable_by(order);
                points.dedup();
                points
            }
        };
        self.triangles.extend(other.triangles);
        self.deepest = deepest;
        self.perimeter = (self.perimeter + other.perimeter - 2.0 * shared).max(0.0);
        self.area += other.area;
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }
}

/// The vertices of two surfaces, ascending, each once, with their normals with respect to both.
fn union<'a>(
    first: &'a [(u32, Vector)],
    second: &'a [(u32, Vector)],
) -> impl Iterator<Item = (u32, Vector)> + 'a {
    let (mut first, mut second) = (first.iter().peekable(), second.iter().peekable());
    std::iter::from_fn(move || match (first.peek(), second.peek()) {
        (Some(&&(a, normal)), Some(&&(b, other))) if a == b => {
            first.next();
            second.next();
            Some((a, normal + other))
        }
        (Some((a, _)), Some((b, _))) if a < b => first.next().copied(),
        (_, Some(_)) => second.next().copied(),
        (_, None) => first.next().copied(),
    })
}

/// How far a vertex is from its projection on the hull.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Depth {
    pub depth: f64,
    pub vertex: u32,
}

impl Depth {
    /// Of no vertex, and so no bound for anything.
    pub(super) const NONE: Self = Self { depth: 0.0, vertex: u32::MAX };

    pub(super) fn greater(self, other: Self) -> Self {
        if other.depth > self.depth { other } else { self }
    }

    /// What is left of it in a larger hull, which may lack a little of a smaller one.
    pub(super) fn in_larger_hull(self) -> f64 {
        (self.depth - HULL_SLACK).max(0.0)
    }
}

/// What judges unions: memory that is reused, and the mesh.
pub(super) struct Judge<'a> {
    mesh: &'a TriangleMesh,
    /// The vertex at a position, by the position's bits.
    vertex_at: HashMap<[u64; 3], u32>,
    builder: HullBuilder,
    points: Vec<[f64; 3]>,
    /// For each vertex of the mesh its place in the hull, or [`NOWHERE`]. All are [`NOWHERE`]
    /// between calls.
    places: Vec<u32>,
    /// For each vertex of the hull the end of its faces in `incident`.
    ends: Vec<u32>,
    incident: Vec<u32>,
}

/// Not a vertex of the hull.
const NOWHERE: u32 = u32::MAX;

impl<'a> Judge<'a> {
    pub(super) fn new(mesh: &'a TriangleMesh) -> Self {
        let vertices = (0..).zip(&mesh.positions);
        Self {
            mesh,
            vertex_at: vertices
                .map(|(vertex, &position)| (bits(Vector::from(position)), vertex))
                .collect(),
            builder: HullBuilder::new(),
            points: Vec::new(),
            places: vec![NOWHERE; mesh.positions.len()],
            ends: Vec::new(),
            incident: Vec::new(),
        }
    }

    /// The hull of two surfaces, from the vertices of their hulls. `None` where they are flat.
    pub(super) fn joint_hull(&mut self, first: &Surface, second: &Surface) -> Option<ConvexHull> {
        self.points.clear();
        let points = first.hull_points.iter().chain(&second.hull_points);
        self.points.extend(points.map(Vector::to_array));
        let shape = self.builder.build(&self.points);
        (shape == Shape::Solid).then(|| self.builder.extract().into())
    }

    /// argmax over M in S of ‖M − P_S(M)‖ for the union S of two surfaces and its hull, or any
    /// vertex that lies at least `limit` deep. 0 where the union is flat, and so has no hull.
    /// O(hull faces · vertices that are not the hull's).
    pub(super) fn joint_depth(
        &mut self,
        first: &Surface,
        second: &Surface,
        hull: Option<&ConvexHull>,
        limit: f64,
    ) -> Depth {
        let mut found = Depth { depth: 0.0, vertex: first.deepest.vertex };
        let Some(hull) = hull else { return found };
        let planes: Vec<(Vector, f64)> =
            hull.planes().into_iter().map(|(normal, offset)| (normal.into(), offset)).collect();
        self.index_faces(hull);
        let mut judge = |vertex: u32, normal: Vector| {
            let direction = normal.normalize_or_zero();
            let depth = if self.leaves_at_once(vertex, direction, &planes) {
                0.0
            } else {
                let point = Vector::from(self.mesh.positions[vertex as usize]);
                distance_to_exit(point, direction, &planes, found.depth.max(NEGLIGIBLE))
            };
            if depth > found.depth {
                found = Depth { depth, vertex };
            }
            found.depth < limit
        };
        // The deepest so far come first: the deeper the start, the less is left for the others.
        let _ = [first.deepest, second.deepest].into_iter().all(|Depth { vertex, .. }| {
            let normal = first.normal_at(vertex) + second.normal_at(vertex);
            judge(vertex, normal)
        }) && union(&first.vertices, &second.vertices)
            .all(|(vertex, normal)| judge(vertex, normal));
        for &point in &hull.points {
            if let Some(&vertex) = self.vertex_at.get(&bits(Vector::from(point))) {
                self.places[vertex as usize] = NOWHERE;
            }
        }
        found
    }

    /// Finds each vertex of the hull in the mesh, and its faces.
    fn index_faces(&mut self, hull: &ConvexHull) {
        for (place, &point) in (0..).zip(&hull.points) {
            if let Some(&vertex) = self.vertex_at.get(&bits(Vector::from(point))) {
                self.places[vertex as usize] = place;
            }
        }
        self.ends.clear();
        self.ends.resize(hull.points.len() + 1, 0);
        for &vertex in hull.triangles.as_flattened() {
            self.ends[vertex as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut self.ends {
            sum += *end;
            *end = sum;
        }
        self.incident.clear();
        self.incident.resize(3 * hull.triangles.len(), 0);
        // From its end each list is filled towards its start, which then stands in `ends`.
        for (face, triangle) in (0..).zip(&hull.triangles) {
            for &vertex in triangle {
                let end = &mut self.ends[vertex as usize];
                *end -= 1;
                self.incident[*end as usize] = face;
            }
        }
    }

    /// Whether a ray from a vertex of the hull leaves through one of that vertex's own faces.
    fn leaves_at_once(&self, vertex: u32, direction: Vector, planes: &[(Vector, f64)]) -> bool {
        let place = self.places[vertex as usize];
        if place == NOWHERE {
            return false;
        }
        let range = self.ends[place as usize] as usize..self.ends[place as usize + 1] as usize;
        let mut faces = self.incident[range].iter();
        faces.any(|&face| planes[face as usize].0.dot(direction) > PARALLEL)
    }
}

fn bits(point: Vector) -> [u64; 3] {
    point.to_array().map(f64::to_bits)
}

/// How far a ray from a point inside a hull runs until it leaves, or anything up to `enough`
/// where that is at most `enough`.
fn distance_to_exit(
    point: Vector,
    direction: Vector,
    planes: &[(Vector, f64)],
    enough: f64,
) -> f64 {
    let mut nearest = f64::INFINITY;
    for &(normal, offset) in planes {
        let towards = normal.dot(direction);
        if towards > PARALLEL {
            nearest = nearest.min(((offset - normal.dot(point)) / towards).max(0.0));
            if nearest <= enough {
                return nearest;
            }
        }
    }
    // A vertex whose triangles cancel out has no normal, and so no distance.
    if nearest.is_finite() { nearest } else { 0.0 }
}
