//! A surface of HACD: what a node of the dual graph stands for, and what equation (4) asks of it.

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

/// How far a vertex is from its projection on the hull.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Depth {
    pub depth: f64,
    pub vertex: u32,
}

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

    /// The depth that a union with another surface has at least: a larger hull, which may lack a little of a
    /// smaller one, is farther to leave, unless the other surface changes the normal.
    pub(super) fn least_joint_depth(&self, other: &Self) -> f64 {
        let kept = |surface: &Self, other: &Self| match other.place(surface.deepest.vertex) {
            Some(_) => 0.0,
            None => surface.deepest.depth,
        };
        (kept(self, other).max(kept(other, self)) - HULL_SLACK).max(0.0)
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
                points.sort_unstable_by(|a, b| {
                    a.to_array().map(f64::to_bits).cmp(&b.to_array().map(f64::to_bits))
                });
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

/// What judges unions: memory that is reused, and the mesh.
pub(super) struct Judge<'a> {
    mesh: &'a TriangleMesh,
    builder: HullBuilder,
    points: Vec<[f64; 3]>,
}

impl<'a> Judge<'a> {
    pub(super) fn new(mesh: &'a TriangleMesh) -> Self {
        Self { mesh, builder: HullBuilder::new(), points: Vec::new() }
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
        &self,
        first: &Surface,
        second: &Surface,
        hull: Option<&ConvexHull>,
        limit: f64,
    ) -> Depth {
        let mut found = Depth { depth: 0.0, vertex: first.deepest.vertex };
        let Some(hull) = hull else { return found };
        let planes: Vec<(Vector, f64)> =
            hull.planes().into_iter().map(|(normal, offset)| (normal.into(), offset)).collect();
        // The deepest so far come first: the deeper the start, the less is left for the others.
        let deepest = [first, second].map(|surface| surface.deepest.vertex);
        let deepest =
            deepest.map(|vertex| (vertex, first.normal_at(vertex) + second.normal_at(vertex)));
        for (vertex, normal) in deepest.into_iter().chain(union(&first.vertices, &second.vertices))
        {
            let point = self.mesh.positions[vertex as usize].into();
            let enough = found.depth.max(NEGLIGIBLE);
            let depth = distance_to_exit(point, normal.normalize_or_zero(), &planes, enough);
            if depth > found.depth {
                found = Depth { depth, vertex };
            }
            if found.depth >= limit {
                break;
            }
        }
        found
    }
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
