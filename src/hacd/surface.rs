//! A surface of HACD: what a node of the dual graph stands for, and what equation (4) asks of it.

use crate::hull::{ConvexHull, HullBuilder, Shape};
use crate::mesh::TriangleMesh;
use crate::vector::{
    Vector, add, area_normal, distance, dot, length, maximum, minimum, normalize, subtract,
};

/// A plane that the ray runs along cannot be left through it.
const PARALLEL: f64 = 1e-9;

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
    /// The vertex that lay deepest when the surface was last judged: it likely still does.
    pub deepest: u32,
    /// ρ(S): length of the border.
    pub perimeter: f64,
    /// σ(S).
    pub area: f64,
    pub low: Vector,
    pub high: Vector,
}

impl Surface {
    pub(super) fn triangle(mesh: &TriangleMesh, triangle: u32) -> Self {
        let corners = mesh.triangles[triangle as usize];
        let [a, b, c] = corners.map(|vertex| mesh.positions[vertex as usize]);
        let normal = area_normal(a, b, c);
        let mut vertices = corners.map(|vertex| (vertex, normal)).to_vec();
        vertices.sort_unstable_by_key(|&(vertex, _)| vertex);
        Self {
            triangles: vec![triangle],
            vertices,
            hull_points: vec![a, b, c],
            deepest: corners[0],
            perimeter: distance(a, b) + distance(b, c) + distance(c, a),
            area: length(normal) / 2.0,
            low: minimum(minimum(a, b), c),
            high: maximum(maximum(a, b), c),
        }
    }

    /// D_S of the union with another surface.
    pub(super) fn joint_diagonal(&self, other: &Self) -> f64 {
        length(subtract(maximum(self.high, other.high), minimum(self.low, other.low)))
    }

    /// E_shape of the union with another surface, along a border of the given length: 1 for a
    /// flat disc, more for what is long or ragged, 0 for what is closed.
    pub(super) fn joint_shape_factor(&self, other: &Self, shared: f64) -> f64 {
        let perimeter = (self.perimeter + other.perimeter - 2.0 * shared).max(0.0);
        perimeter * perimeter / (4.0 * std::f64::consts::PI * (self.area + other.area))
    }

    /// Takes in another surface. `joint` is the hull of both, or nothing where both are flat.
    pub(super) fn absorb(
        &mut self,
        other: Self,
        shared: f64,
        hull_points: Option<Vec<Vector>>,
        deepest: u32,
    ) {
        self.vertices = union(&self.vertices, &other.vertices).collect();
        self.hull_points = match hull_points {
            Some(points) => points,
            None => {
                let mut points = std::mem::take(&mut self.hull_points);
                points.extend(other.hull_points);
                points.sort_unstable_by(|a, b| {
                    a.iter()
                        .zip(b)
                        .map(|(a, b)| a.total_cmp(b))
                        .find(|o| o.is_ne())
                        .unwrap_or(std::cmp::Ordering::Equal)
                });
                points.dedup();
                points
            }
        };
        self.triangles.extend(other.triangles);
        self.deepest = deepest;
        self.perimeter = (self.perimeter + other.perimeter - 2.0 * shared).max(0.0);
        self.area += other.area;
        self.low = minimum(self.low, other.low);
        self.high = maximum(self.high, other.high);
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
            Some((a, add(normal, other)))
        }
        (Some((a, _)), Some((b, _))) if a < b => first.next().copied(),
        (_, Some(_)) => second.next().copied(),
        (_, None) => first.next().copied(),
    })
}

/// The depth of a union: the greatest distance of a vertex to its projection on the hull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Depth {
    pub depth: f64,
    pub deepest: u32,
}

/// argmax over M in S of ‖M − P_S(M)‖ for the union S of two surfaces, or `None` as soon as it is
/// known to be at least `limit`. 0 where the union is flat. O(vertices · hull faces).
pub(super) fn joint_depth(
    mesh: &TriangleMesh,
    first: &Surface,
    second: &Surface,
    limit: f64,
    builder: &mut HullBuilder,
    scratch: &mut Vec<Vector>,
) -> Option<Depth> {
    let mut found = Depth { depth: 0.0, deepest: first.deepest };
    let Some(hull) = joint_hull(first, second, builder, scratch) else {
        return (limit > 0.0).then_some(found);
    };
    let planes = hull.planes();
    let mut judge = |vertex: u32, normal: Vector| {
        let point = mesh.positions[vertex as usize];
        let depth = distance_to_exit(point, normalize(normal), &planes, found.depth);
        if depth > found.depth {
            found = Depth { depth, deepest: vertex };
        }
        found.depth < limit
    };
    // The deepest so far come first: the deeper the start, the less is left to do for the others.
    for &vertex in &[first.deepest, second.deepest] {
        let of = |surface: &Surface| {
            let place = surface.vertices.binary_search_by_key(&vertex, |&(vertex, _)| vertex);
            place.map_or([0.0; 3], |place| surface.vertices[place].1)
        };
        if !judge(vertex, add(of(first), of(second))) {
            return None;
        }
    }
    for (vertex, normal) in union(&first.vertices, &second.vertices) {
        if !judge(vertex, normal) {
            return None;
        }
    }
    Some(found)
}

/// The hull of two surfaces, from the vertices of their hulls. `None` where they are flat.
pub(super) fn joint_hull(
    first: &Surface,
    second: &Surface,
    builder: &mut HullBuilder,
    scratch: &mut Vec<Vector>,
) -> Option<ConvexHull> {
    scratch.clear();
    scratch.extend(&first.hull_points);
    scratch.extend(&second.hull_points);
    (builder.build(scratch) == Shape::Solid).then(|| builder.extract().into())
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
        let towards = dot(normal, direction);
        if towards > PARALLEL {
            nearest = nearest.min(((offset - dot(normal, point)) / towards).max(0.0));
            if nearest <= enough {
                return nearest;
            }
        }
    }
    // A vertex whose triangles cancel out has no normal, and so no distance.
    if nearest.is_finite() { nearest } else { 0.0 }
}
