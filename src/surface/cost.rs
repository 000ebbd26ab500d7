//! The concavity cost [3.4.3], equation (3):
//!
//! cost(S) = max over M in S of ‖M − P_S(M)‖ / D_S
//!
//! S are the vertices of a group, P_S(M) is where the ray from M along its normal leaves the
//! convex hull of S, and D_S is the diagonal of the bounding box of S. The normal of M is taken
//! *with respect to the group*: the area-weighted mean of the normals of the group's own
//! triangles at M.

use crate::hull::{ConvexHull, HullBuilder, Shape};
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::Adjacency;
use crate::vector::{Vector, add, area_normal, dot, normalize};

use super::grouping::{corners, diagonal, group_vertices};

/// A plane that the ray runs along cannot be left through it.
const PARALLEL: f64 = 1e-9;

/// Cost of a group, 0 for flat ones: they are their own hull. O(vertices · hull faces).
pub(crate) fn cost(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    labels: &[u32],
    group: &[u32],
    builder: &mut HullBuilder,
) -> f64 {
    let Some(label) = group.first().map(|&triangle| labels[triangle as usize]) else { return 0.0 };
    let vertices = group_vertices(mesh, group);
    let points: Vec<Vector> =
        vertices.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
    if builder.build(&points) != Shape::Solid {
        return 0.0;
    }
    let planes = ConvexHull::from(builder.extract()).planes();
    let mut greatest: f64 = 0.0;
    for (&vertex, &point) in vertices.iter().zip(&points) {
        let normal = normal(mesh, adjacency, labels, label, vertex);
        greatest = greatest.max(distance_to_exit(point, normal, &planes, greatest));
    }
    greatest / diagonal(points.iter().copied())
}

/// The unit normal of a vertex with respect to the group with the given label.
fn normal(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    labels: &[u32],
    label: u32,
    vertex: u32,
) -> Vector {
    let incident = adjacency.vertex_triangles(vertex).iter();
    let own = incident.filter(|&&triangle| labels[triangle as usize] == label);
    normalize(own.fold([0.0; 3], |sum, &triangle| {
        let [a, b, c] = corners(mesh, triangle);
        add(sum, area_normal(a, b, c))
    }))
}

/// How far a ray from a point inside a hull runs until it leaves. Where that is at most `enough`
/// an upper bound that is at most `enough` may be returned, since only the greatest distance counts.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::cuboid;

    fn whole(mesh: &TriangleMesh) -> f64 {
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let labels = vec![0; all.len()];
        cost(mesh, &Adjacency::new(mesh), &labels, &all, &mut HullBuilder::new())
    }

    #[test]
    fn a_convex_group_costs_nothing() {
        assert!(whole(&cuboid([0.0; 3], [1.0; 3])) < 1e-9);
    }

    #[test]
    fn a_flat_group_costs_nothing() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        assert_eq!(whole(&TriangleMesh { positions, triangles }), 0.0);
    }

    #[test]
    fn a_valley_costs_its_depth_over_its_diagonal() {
        // Two unit slopes down to a valley 0.5 deep along y, 2 wide.
        let (depth, width): (f64, f64) = (0.5, 2.0);
        let positions = vec![
            [-1.0, 0.0, depth],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, depth],
            [-1.0, 1.0, depth],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, depth],
        ];
        let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        let diagonal = (width * width + 1.0 + depth * depth).sqrt();
        let cost = whole(&TriangleMesh { positions, triangles });
        // The normal at the valley's ends is not upright, for the triangles differ in number.
        assert!(cost >= depth / diagonal - 1e-9, "{cost}");
        assert!(cost <= 1.2 * depth / diagonal, "{cost}");
    }
}
