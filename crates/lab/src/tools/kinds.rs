//! What is wrong with a mesh as it is given, in the words of Thingi10K's statistics (Zhou and
//! Jacobson 2016).

use std::collections::HashMap;

use hullwright::TriangleMesh;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Any of the others.
pub const NOT_SOLID: &str = "not solid";
/// Two triangles meet elsewhere than in a common edge or vertex, by exact predicates. Overlaps in
/// one plane are seen between triangles that share an edge.
pub const SELF_INTERSECTING: &str = "self-intersecting";
/// Over common vertices. Such a mesh may be solid.
pub const SEVERAL_COMPONENTS: &str = "several components";
/// An edge with more than two triangles.
pub const NON_MANIFOLD: &str = "non-manifold";
/// A triangle without area, or with a vertex that is not there.
pub const DEGENERATE: &str = "degenerate faces";
/// An edge with one triangle.
pub const OPEN: &str = "open";
/// Triangles run along an edge more often one way than the other, though it is not open.
pub const NOT_ORIENTED: &str = "not oriented";

pub const ALL: [&str; 7] = [
    NOT_SOLID,
    SELF_INTERSECTING,
    NON_MANIFOLD,
    DEGENERATE,
    OPEN,
    NOT_ORIENTED,
    SEVERAL_COMPONENTS,
];

/// All kinds of a mesh whose vertices at the same place are one. O(n log n) beside the pairs of
/// triangles whose boxes overlap along an axis.
pub fn kinds(mesh: &TriangleMesh) -> Vec<&'static str> {
    let (points, triangles, mut is_degenerate) = welded(mesh);
    let at = |vertex: u32| points[vertex as usize];
    is_degenerate |= triangles.iter().any(|triangle| is_line(triangle.map(at)));
    let edges = edges(&triangles);
    let is = |test: fn(&[i32]) -> bool| edges.values().any(|directions| test(directions));
    let sum = |directions: &[i32]| directions.iter().sum::<i32>();
    let faults = [
        (SELF_INTERSECTING, intersects_itself(&points, &triangles)),
        (NON_MANIFOLD, is(|directions| directions.len() > 2)),
        (DEGENERATE, is_degenerate),
        (OPEN, is(|directions| directions.len() == 1)),
        (NOT_ORIENTED, edges.values().any(|all| all.len() > 1 && sum(all) != 0)),
    ];
    let mut kinds: Vec<_> = faults.iter().filter(|fault| fault.1).map(|fault| fault.0).collect();
    if !kinds.is_empty() || triangles.is_empty() {
        kinds.insert(0, NOT_SOLID);
    }
    if components(points.len(), &triangles) > 1 {
        kinds.push(SEVERAL_COMPONENTS);
    }
    kinds
}

type Point = [f64; 3];

/// Points, triangles with three different ones of them, and whether there are others.
fn welded(mesh: &TriangleMesh) -> (Vec<Point>, Vec<[u32; 3]>, bool) {
    let mut places: HashMap<[u64; 3], u32> = HashMap::new();
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for triangle in &mesh.triangles {
        let corners = triangle.map(|vertex| mesh.positions.get(vertex as usize).copied());
        let [Some(a), Some(b), Some(c)] = corners else { continue };
        if ![a, b, c].as_flattened().iter().all(|x| x.is_finite()) {
            continue;
        }
        let [a, b, c] = [a, b, c].map(|point| {
            // Both zeros are one place.
            let bits = point.map(|x| (x + 0.0).to_bits());
            *places.entry(bits).or_insert_with(|| {
                points.push(point);
                points.len() as u32 - 1
            })
        });
        if a != b && b != c && c != a {
            triangles.push([a, b, c]);
        }
    }
    let has_others = triangles.len() < mesh.triangles.len();
    (points, triangles, has_others)
}

/// The directions of all triangles along each edge.
fn edges(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], Vec<i32>> {
    let mut edges: HashMap<[u32; 2], Vec<i32>> = HashMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let direction = if from < to { 1 } else { -1 };
            edges.entry([from.min(to), from.max(to)]).or_default().push(direction);
        }
    }
    edges
}

fn components(vertices: usize, triangles: &[[u32; 3]]) -> usize {
    fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
        while parents[vertex as usize] != vertex {
            let parent = parents[vertex as usize];
            parents[vertex as usize] = parents[parent as usize];
            vertex = parent;
        }
        vertex
    }
    let mut parents: Vec<u32> = (0..vertices as u32).collect();
    for &[a, b, c] in triangles {
        for other in [b, c] {
            let (a, other) = (root(&mut parents, a), root(&mut parents, other));
            parents[a as usize] = other;
        }
    }
    let mut roots: Vec<u32> =
        triangles.iter().map(|triangle| root(&mut parents, triangle[0])).collect();
    roots.sort_unstable();
    roots.dedup();
    roots.len()
}

fn is_line(corners: [Point; 3]) -> bool {
    (0..3).all(|axis| {
        let flat = corners.map(|p| Coord { x: p[axis], y: p[(axis + 1) % 3] });
        orient2d(flat[0], flat[1], flat[2]) == 0.0
    })
}

fn side([a, b, c]: [Point; 3], point: Point) -> f64 {
    let [a, b, c, d] = [a, b, c, point].map(|[x, y, z]| Coord3D { x, y, z });
    orient3d(a, b, c, d)
}

/// Sweeps along the longest axis.
fn intersects_itself(points: &[Point], triangles: &[[u32; 3]]) -> bool {
    let at = |vertex: u32| points[vertex as usize];
    let bounds = |corners: &[Point]| {
        [f64::min, f64::max].map(|pick| {
            [0, 1, 2].map(|k| corners.iter().map(|point| point[k]).reduce(pick).unwrap_or(0.0))
        })
    };
    let [low, high] = bounds(points);
    let extent = [0, 1, 2].map(|k| high[k] - low[k]);
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let mut boxes: Vec<([Point; 2], [u32; 3])> =
        triangles.iter().map(|&triangle| (bounds(&triangle.map(at)), triangle)).collect();
    boxes.sort_by(|a, b| a.0[0][axis].total_cmp(&b.0[0][axis]));
    boxes.iter().enumerate().any(|(index, (a, first))| {
        let near = boxes[index + 1..].iter().take_while(|(b, _)| b[0][axis] <= a[1][axis]);
        let mut overlapping =
            near.filter(|(b, _)| (0..3).all(|k| a[0][k] <= b[1][k] && b[0][k] <= a[1][k]));
        overlapping.any(|&(_, second)| meet(points, *first, second))
    })
}

/// Whether two triangles meet elsewhere than in what they share.
fn meet(points: &[Point], first: [u32; 3], second: [u32; 3]) -> bool {
    let at = |vertex: u32| points[vertex as usize];
    let shared: Vec<u32> = first.into_iter().filter(|vertex| second.contains(vertex)).collect();
    let other = |triangle: [u32; 3]| {
        triangle.into_iter().find(|v| !shared.contains(v)).map_or([0.0; 3], at)
    };
    match shared[..] {
        [_, _, _] => true,
        // Folded flat over each other.
        [a, b] => {
            let [a, b, c, d] = [at(a), at(b), other(first), other(second)];
            side([a, b, c], d) == 0.0 && {
                let normal = |p: Point| {
                    let [u, v] = [b, p].map(|q| [0, 1, 2].map(|k| q[k] - a[k]));
                    [0, 1, 2]
                        .map(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3])
                };
                let (n, m) = (normal(c), normal(d));
                n[0] * m[0] + n[1] * m[1] + n[2] * m[2] > 0.0
            }
        }
        _ => {
            let crosses = |edges: [u32; 3], face: [u32; 3]| {
                (0..3).map(|k| [edges[k], edges[(k + 1) % 3]]).any(|ends| {
                    ends.iter().all(|end| !shared.contains(end))
                        && segment_meets(ends.map(at), face.map(at))
                })
            };
            crosses(first, second) || crosses(second, first)
        }
    }
}

/// Whether a segment that is not in a triangle's plane meets it.
fn segment_meets([p, q]: [Point; 2], face: [Point; 3]) -> bool {
    let (from, to) = (side(face, p), side(face, q));
    if from * to > 0.0
        || (from == 0.0 && to == 0.0)
        || from.signum() == to.signum() && from * to != 0.0
    {
        return false;
    }
    let [a, b, c] = face;
    let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| side([p, q, a], b));
    sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::cuboid;

    fn cube() -> TriangleMesh {
        cuboid([0.0; 3], [1.0; 3])
    }

    fn with(part: &TriangleMesh) -> TriangleMesh {
        crate::shapes::join(&[cube(), part.clone()])
    }

    #[test]
    fn a_mesh_is_of_the_kinds_that_it_was_made_to_be() {
        assert_eq!(kinds(&cube()), [""; 0]);
        let mut open = cube();
        open.triangles.pop();
        assert_eq!(kinds(&open), [NOT_SOLID, OPEN]);
        let mut turned = cube();
        turned.triangles[0].swap(1, 2);
        assert_eq!(kinds(&turned), [NOT_SOLID, NOT_ORIENTED]);
        let mut degenerate = cube();
        degenerate.triangles.push([0, 0, 1]);
        assert_eq!(kinds(&degenerate), [NOT_SOLID, DEGENERATE]);
        let apart = with(&cuboid([2.0; 3], [3.0; 3]));
        assert_eq!(kinds(&apart), [SEVERAL_COMPONENTS]);
        let crossing = with(&cuboid([0.5; 3], [1.5; 3]));
        assert_eq!(kinds(&crossing), [NOT_SOLID, SELF_INTERSECTING, SEVERAL_COMPONENTS]);
        // They share one edge.
        let edge = with(&cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0]));
        assert_eq!(kinds(&edge), [NOT_SOLID, NON_MANIFOLD]);
    }

    #[test]
    fn triangles_that_cross_touch_or_fold_over_intersect_and_neighbours_do_not() {
        let base = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let meets = |points: Vec<Point>, second| {
            let points = [&base[..], &points].concat();
            intersects_itself(&points, &[[0, 1, 2], second])
        };
        assert!(meets(vec![[0.5, 0.5, -1.0], [0.6, 0.5, 1.0], [0.5, 0.6, 1.0]], [3, 4, 5]));
        assert!(meets(vec![[0.5, 0.5, 0.0], [0.6, 0.5, 1.0], [0.5, 0.6, 1.0]], [3, 4, 5]));
        assert!(!meets(vec![[0.5, 0.5, 0.1], [0.6, 0.5, 1.0], [0.5, 0.6, 1.0]], [3, 4, 5]));
        assert!(meets(vec![[0.5, 0.5, -1.0], [0.6, 0.5, 1.0]], [0, 3, 4]));
        assert!(!meets(vec![[-0.5, 0.5, -1.0], [-0.6, 0.5, 1.0]], [0, 3, 4]));
        assert!(meets(vec![[1.0, 1.0, 0.0]], [1, 0, 3]));
        assert!(!meets(vec![[1.0, -1.0, 0.0]], [1, 0, 3]));
        assert!(!meets(vec![[1.0, 1.0, 1.0]], [1, 0, 3]));
    }
}
