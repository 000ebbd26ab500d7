//! Planar groups: triangles that are connected and in one plane, from the largest triangle on.

use crate::geometry::vector::{Vector, area_normal, distance, dot, length, scale};
use crate::mesh::TriangleMesh;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};

/// Cosine of the greatest angle between a triangle and its group's plane. Slivers are in the plane
/// by their vertices, whatever their normal.
const MIN_COSINE: f64 = 0.9;

/// A triangle of a smaller height, in flatnesses, is a sliver.
const SLIVER: f64 = 2.0;

/// A plane: points p with normal · p = offset.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub normal: Vector,
    pub offset: f64,
}

impl Plane {
    #[inline]
    pub(super) fn height(&self, point: Vector) -> f64 {
        dot(self.normal, point) - self.offset
    }
}

/// Groups, and their planes.
pub(super) struct PlanarGroups {
    /// For each triangle its group.
    pub labels: Vec<u32>,
    /// For each group its plane, with the normal outward.
    pub planes: Vec<Plane>,
    /// For each group its vertices.
    pub vertices: Vec<Vec<u32>>,
}

/// Groups triangles by planes. O(n log n).
pub(super) fn planar_groups(
    mesh: &TriangleMesh,
    adjacency: &Adjacency,
    flatness: f64,
) -> PlanarGroups {
    let count = mesh.triangles.len();
    let corners = |t: usize| mesh.triangles[t].map(|vertex| mesh.positions[vertex as usize]);
    let normals: Vec<Vector> = (0..count)
        .map(|t| {
            let [a, b, c] = corners(t);
            area_normal(a, b, c)
        })
        .collect();
    let areas: Vec<f64> = normals.iter().map(|&normal| length(normal)).collect();
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_by(|&a, &b| areas[b as usize].total_cmp(&areas[a as usize]).then(a.cmp(&b)));
    let mut groups =
        PlanarGroups { labels: vec![u32::MAX; count], planes: Vec::new(), vertices: Vec::new() };
    let mut stack = Vec::new();
    for start in order {
        if groups.labels[start as usize] != u32::MAX {
            continue;
        }
        let label = groups.planes.len() as u32;
        let normal =
            scale(normals[start as usize], 1.0 / areas[start as usize].max(f64::MIN_POSITIVE));
        let [a, ..] = corners(start as usize);
        let plane = Plane { normal, offset: dot(normal, a) };
        let mut vertices = Vec::new();
        groups.labels[start as usize] = label;
        stack.push(start);
        while let Some(triangle) = stack.pop() {
            vertices.extend(mesh.triangles[triangle as usize]);
            for other in adjacency.triangle_neighbours(triangle) {
                if other == NO_NEIGHBOUR || groups.labels[other as usize] != u32::MAX {
                    continue;
                }
                let points = corners(other as usize);
                let is_flat = points.iter().all(|&point| plane.height(point).abs() <= flatness);
                let cosine_by_area = dot(normals[other as usize], normal);
                let area = areas[other as usize];
                if is_flat
                    && (cosine_by_area >= MIN_COSINE * area || is_sliver(points, area, flatness))
                {
                    groups.labels[other as usize] = label;
                    stack.push(other);
                }
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        groups.planes.push(plane);
        groups.vertices.push(vertices);
    }
    groups
}

/// Whether a triangle's height over its longest side is so small that its normal says little.
fn is_sliver([a, b, c]: [Vector; 3], doubled_area: f64, flatness: f64) -> bool {
    let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
    doubled_area <= SLIVER * flatness * longest
}
