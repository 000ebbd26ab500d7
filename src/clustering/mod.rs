//! Vertex clustering: a closed mesh of very many triangles is searched through a reduced one
//! (Rossignac and Borrel, "Multi-resolution 3D Approximations for Rendering Complex Scenes", 1993).
//! Only repair, the hulls of patches and verification read all of its triangles.
//!
//! No point moves farther than [`Clustered::displacement`]. So the reduced surface is that close to
//! the source everywhere, and what is inside the reduced solid is inside the source or that close
//! to it, since the winding number about a point changes only when the surface moves across it.
//! (The converse fails for spikes and ribbons that are smaller than cells and vanish.)
//!
//! Takes the repaired mesh, gives the reduced one, if it is needed. O(n log n) for n vertices.

mod vertex_clusters;

use std::sync::Arc;

use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, into_arrays};
use crate::mesh::refine::refine;
use crate::mesh::{PreparedMesh, TriangleMesh};
use crate::parallel;
use vertex_clusters::{VertexClusters, representatives};

/// Meshes of fewer triangles are not clustered: they take well under a second without.
const MIN_TRIANGLES: usize = 100_000;

/// Side of a cell, as a fraction of the bound. Vertices move by about as much along the surface, and by far less
/// away from it. Cells of 0.3 cost 10 % more time, of 0.22 30 %; hulls are as many.
const CELL: f64 = 0.4;

/// Clustering must leave less than this share of the triangles to be worth its own time.
const MAX_KEPT_SHARE: f64 = 0.5;

/// A triangle with a side longer than this, as a multiple of a cell's side, does not collapse: it cannot lie within one
/// cell (whose diagonal is 1.73), so that collapsing it would cut off a feature.
const LONG: f64 = 2.0;

/// Clusters of more vertices or triangles are not used, unless they are a small share of the mesh: each distance
/// query visits three of them. Such clusters arise from a detailed object in a large scene.
const MAX_CLUSTER: usize = 4096;

/// A cluster may hold this share of a mesh's triangles: so many are at the pole of a sphere of ten million.
const MAX_CLUSTER_SHARE: f64 = 1.0 / 64.0;

/// If the triangles around the nearest vertex are farther away than expected by this factor, all
/// triangles of the clusters are visited.
const EXPECTED: f64 = 1.01;

/// A reduced mesh, and the surface that it represents.
pub(crate) struct Clustered {
    /// The source, its long triangles halved.
    pub surface: Arc<TriangleMesh>,
    /// For each triangle of `surface` the prepared mesh's triangle that it is a part of.
    pub parents: Arc<Vec<u32>>,
    /// The reduced mesh.
    pub mesh: TriangleMesh,
    /// For each triangle of `mesh` the source's component.
    pub components: Vec<u32>,
    /// For each triangle of `surface` the triangle of `mesh` that represents it.
    pub representatives: Vec<u32>,
    /// For each vertex of `mesh` the vertices of `surface` that became it.
    vertices: IndexLists,
    /// For each vertex of `mesh` the triangles of `surface` around those.
    around: IndexLists,
    /// No point of `surface` has moved farther than this.
    pub displacement: f64,
}

/// The reduced mesh of a prepared one that needs it.
pub(crate) fn cluster(
    prepared: &PreparedMesh,
    bound: f64,
    longest_edge: f64,
    control: &Control,
) -> Result<Option<Arc<Clustered>>, Error> {
    let clustered = Clustered::new(prepared, bound, longest_edge, control)?;
    Ok(clustered.map(Arc::new))
}

impl Clustered {
    /// `None` where the mesh has few triangles, would keep most of them, is not closed, or has
    /// sheets of triangles in both orientations.
    fn new(
        prepared: &PreparedMesh,
        bound: f64,
        longest_edge: f64,
        control: &Control,
    ) -> Result<Option<Self>, Error> {
        // Where the surface ends, the winding number changes without crossing it.
        let is_closed = prepared.closed.iter().all(|&closed| closed);
        if prepared.mesh.triangles.len() < MIN_TRIANGLES
            || !is_closed
            || prepared.is_both_ways.contains(&true)
        {
            return Ok(None);
        }
        let mut surface = prepared.mesh.clone();
        let parents = refine(&mut surface, longest_edge);
        control.check()?;
        let size = CELL * bound;
        let Some(mut clusters) = VertexClusters::new(&surface, size, control)? else {
            return Ok(None);
        };
        control.check()?;
        clusters.separate_long(&surface, LONG * size);
        clusters.separate_lost(&surface, control)?;
        control.check()?;
        let kept = surface.triangles.iter().filter(|&triangle| clusters.keeps(triangle)).count();
        if kept as f64 > MAX_KEPT_SHARE * surface.triangles.len() as f64 {
            return Ok(None);
        }
        Self::from_clusters(prepared, surface, parents, &clusters, control)
    }

    fn from_clusters(
        prepared: &PreparedMesh,
        surface: TriangleMesh,
        parents: Vec<u32>,
        clusters: &VertexClusters,
        control: &Control,
    ) -> Result<Option<Self>, Error> {
        let VertexClusters { labels, count } = clusters;
        let vertices_by_cluster = || (0..).zip(labels).map(|(vertex, &cluster)| (cluster, vertex));
        let triangles_by_cluster = || {
            (0..).zip(&surface.triangles).flat_map(|(index, triangle)| {
                let [a, b, c] = triangle.map(|vertex| labels[vertex as usize]);
                let second = (b != a).then_some(b);
                let third = (c != a && c != b).then_some(c);
                [Some(a), second, third].into_iter().flatten().map(move |corner| (corner, index))
            })
        };
        let (chosen, (vertices, around)) = parallel::join(
            || representatives(&surface, clusters, control),
            || {
                (
                    IndexLists::new(*count, vertices_by_cluster),
                    IndexLists::new(*count, triangles_by_cluster),
                )
            },
        );
        let chosen = chosen?;
        control.check()?;
        let share = (MAX_CLUSTER_SHARE * surface.triangles.len() as f64) as usize;
        if vertices.longest().max(around.longest()) > MAX_CLUSTER.max(share) {
            return Ok(None);
        }
        let position = |vertex: u32| surface.points()[vertex as usize];
        let positions: Vec<Vector> = chosen.iter().map(|&vertex| position(vertex)).collect();
        let moved = |(vertex, &cluster): (usize, &u32)| {
            surface.points()[vertex].distance(positions[cluster as usize])
        };
        let displacement = labels.iter().enumerate().map(moved).fold(0.0, f64::max);
        let (triangles, representatives) = reduced(&surface, clusters);
        let components = (0..).zip(&surface.triangles).filter(|(_, t)| clusters.keeps(t));
        let components = components
            .map(|(index, _): (usize, _)| prepared.components[parents[index] as usize])
            .collect();
        control.check()?;
        Ok(Some(Self {
            surface: Arc::new(surface),
            parents: Arc::new(parents),
            mesh: TriangleMesh {
                positions: into_arrays(positions),
                triangles,
                ..TriangleMesh::default()
            },
            components,
            representatives,
            vertices,
            around,
            displacement,
        }))
    }

    /// An upper bound on the distance from a point near three vertices of `mesh` to `surface`, and
    /// the triangle of `surface` that attains it. It should hardly exceed `expected`.
    pub(crate) fn closest_around(
        &self,
        vertices: [u32; 3],
        point: Vector,
        expected: f64,
    ) -> (f64, u32) {
        let mut nearest = (f64::INFINITY, u32::MAX, u32::MAX);
        for cluster in vertices {
            for &vertex in self.vertices.list(cluster) {
                let away = self.surface.points()[vertex as usize] - point;
                let squared = away.length_squared();
                if squared < nearest.0 {
                    nearest = (squared, vertex, cluster);
                }
            }
        }
        // Where triangles are small, the nearest vertex belongs to the nearest one.
        let (_, vertex, cluster) = nearest;
        let has_vertex =
            |&&triangle: &&u32| self.surface.triangles[triangle as usize].contains(&vertex);
        let at_vertex = self.around.list(cluster).iter().filter(has_vertex);
        let found = self.closest_among(at_vertex, point);
        if found.0 <= EXPECTED * expected {
            return found;
        }
        self.closest_among(vertices.iter().flat_map(|&cluster| self.around.list(cluster)), point)
    }

    fn closest_among<'a>(
        &self,
        triangles: impl Iterator<Item = &'a u32>,
        point: Vector,
    ) -> (f64, u32) {
        let mut nearest = (f64::INFINITY, u32::MAX);
        for &triangle in triangles {
            let squared = self.squared_distance_to(point, triangle);
            if squared < nearest.0 {
                nearest = (squared, triangle);
            }
        }
        (nearest.0.sqrt(), nearest.1)
    }

    /// The squared distance to a triangle of `surface`.
    pub(crate) fn squared_distance_to(&self, point: Vector, triangle: u32) -> f64 {
        let corners = self.surface.triangles[triangle as usize];
        let [a, b, c] = corners.map(|vertex| self.surface.points()[vertex as usize] - point);
        closest_point_on_triangle(a, b, c).length_squared()
    }
}

/// The triangles that do not collapse, and for each triangle of `surface` the one that represents
/// it: itself, or one that is left at a cluster of its corners.
fn reduced(surface: &TriangleMesh, clusters: &VertexClusters) -> (Vec<[u32; 3]>, Vec<u32>) {
    let VertexClusters { labels, count } = clusters;
    let mut triangles = Vec::new();
    // For each cluster the last triangle that is left there.
    let mut left = vec![u32::MAX; *count];
    let mut representatives = vec![u32::MAX; surface.triangles.len()];
    for (index, triangle) in surface.triangles.iter().enumerate() {
        if clusters.keeps(triangle) {
            let corners = triangle.map(|vertex| labels[vertex as usize]);
            let new = triangles.len() as u32;
            representatives[index] = new;
            corners.iter().for_each(|&corner| left[corner as usize] = new);
            triangles.push(corners);
        }
    }
    for (representative, corners) in representatives.iter_mut().zip(&surface.triangles) {
        if *representative == u32::MAX {
            let left = corners.map(|corner| left[labels[corner as usize] as usize]);
            *representative = left.into_iter().min().unwrap_or(u32::MAX);
        }
    }
    (triangles, representatives)
}

/// Lists of indices in two flat arrays (compressed sparse rows).
struct IndexLists {
    /// Where each list starts, and where the last one ends.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl IndexLists {
    /// From pairs of a key below `count` and an entry. `pairs` is called twice. O(count + pairs).
    fn new<I: Iterator<Item = (u32, u32)>>(count: usize, pairs: impl Fn() -> I) -> Self {
        let mut starts = vec![0_u32; count + 1];
        pairs().for_each(|(key, _)| starts[key as usize + 1] += 1);
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total;
        }
        let mut next = starts.clone();
        let mut entries = vec![0; total as usize];
        for (key, entry) in pairs() {
            entries[next[key as usize] as usize] = entry;
            next[key as usize] += 1;
        }
        Self { starts, entries }
    }

    /// Length of the longest list.
    fn longest(&self) -> usize {
        self.starts.windows(2).map(|pair| (pair[1] - pair[0]) as usize).max().unwrap_or(0)
    }

    fn list(&self, key: u32) -> &[u32] {
        let [start, end] = [key, key + 1].map(|key| self.starts[key as usize] as usize);
        &self.entries[start..end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Bvh;
    use crate::mesh::Normalization;
    use crate::mesh::canonical_order::MeshOrder;
    use crate::mesh::repair::prepare;
    use crate::mesh::shapes::{cuboid, join, torus, uv_sphere};

    const BOUND: f64 = 0.02;

    fn clustered(mesh: &TriangleMesh) -> Option<Clustered> {
        let control = Control::new();
        let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
        Clustered::new(&prepared, BOUND, 0.08, &control).unwrap()
    }

    #[test]
    fn a_mesh_of_few_triangles_is_not_clustered() {
        assert!(clustered(&torus(100, 40)).is_none());
    }

    #[test]
    fn a_surface_with_a_hole_is_not_clustered() {
        let mut mesh = torus(400, 160);
        mesh.triangles.pop();
        assert!(clustered(&mesh).is_none());
    }

    #[test]
    fn the_many_triangles_at_a_pole_do_not_keep_a_sphere_from_being_clustered() {
        let clustered = clustered(&uv_sphere(800, [0.0; 3], 1.0)).unwrap();
        let longest = clustered.around.longest();
        assert!(longest > MAX_CLUSTER, "{longest}");
    }

    #[test]
    fn the_tip_of_a_needle_stays() {
        // Four cells long, on one triangle of a torus with a diagonal of about 2.6.
        let mut mesh = torus(400, 160);
        let [a, b, c] = mesh.triangles.swap_remove(0);
        let at = mesh.points()[a as usize];
        let out = Vector::new(at[0], at[1], 0.0);
        let tip = at + out * (0.1 / out.length());
        let new = mesh.positions.len() as u32;
        mesh.positions.push(tip.to_array());
        mesh.triangles.extend([[a, b, new], [b, c, new], [c, a, new]]);
        let clustered = clustered(&mesh).unwrap();
        let normalization = Normalization::of(mesh.points().iter().copied());
        let is_tip = |&vertex: &u32| {
            let position = clustered.mesh.points()[vertex as usize];
            normalization.restore(position).distance(tip) < 1e-6
        };
        assert!(clustered.mesh.triangles.as_flattened().iter().any(is_tip));
    }

    #[test]
    fn the_reduced_mesh_is_closed_and_represents_every_triangle() {
        let clustered = clustered(&torus(400, 160)).unwrap();
        let (mesh, surface) = (&clustered.mesh, &clustered.surface);
        assert!(3 * mesh.triangles.len() < surface.triangles.len());
        assert!(clustered.displacement > 0.0 && clustered.displacement < BOUND);
        let mut edges = std::collections::BTreeMap::new();
        for [a, b, c] in &mesh.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((from.min(to), from.max(to))).or_insert(0) +=
                    if from < to { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|&count| count == 0));
        for (triangle, &representative) in surface.triangles.iter().zip(&clustered.representatives)
        {
            let corners =
                mesh.triangles[representative as usize].map(|v| mesh.points()[v as usize]);
            let corner = surface.points()[triangle[0] as usize];
            let nearest = corners.map(|other| corner.distance(other)).into_iter();
            assert!(nearest.fold(f64::INFINITY, f64::min) <= 2.0 * clustered.displacement);
        }
    }

    #[test]
    fn distances_to_the_source_are_exact_or_hardly_too_large() {
        let clustered = clustered(&torus(400, 160)).unwrap();
        let (mesh, surface) = (&clustered.mesh, &clustered.surface);
        let own = Bvh::new(mesh.points(), &mesh.triangles);
        let source = Bvh::new(surface.points(), &surface.triangles);
        for i in 0..2000 {
            // Points all around the surface, at most a bound away from it.
            let from = surface.points()[37 * i % surface.positions.len()];
            let away = Vector::from_array([0, 1, 2].map(|k| ((i * (k + 3)) as f64).sin()));
            let point = from + away * (0.5 * BOUND);
            let near = own.closest_point(point, f64::INFINITY).unwrap();
            let corners = mesh.triangles[near.triangle as usize];
            let (found, triangle) = clustered.closest_around(corners, point, near.distance);
            let exact = source.closest_point(point, f64::INFINITY).unwrap().distance;
            assert!((near.distance - exact).abs() <= clustered.displacement);
            assert!(found >= exact - 1e-9 && found <= exact + 0.01 * BOUND, "{found} {exact}");
            assert_eq!(clustered.squared_distance_to(point, triangle).sqrt(), found);
        }
    }

    #[test]
    fn a_ribbon_narrower_than_a_cell_stays() {
        let ribbon = cuboid([2.0, -1.0, 0.0], [2.001, 1.0, 0.001]);
        let mesh = join(&[torus(400, 160), ribbon]);
        let normalization = Normalization::of(mesh.points().iter().copied());
        let clustered = clustered(&mesh).unwrap();
        let triangles = clustered.mesh.triangles.iter().zip(&clustered.components);
        let of_ribbon = triangles.filter(|(_, component)| **component == 1);
        let ends = of_ribbon.flat_map(|(triangle, _)| triangle);
        let along = ends.map(|&vertex| clustered.mesh.points()[vertex as usize][1]);
        let (low, high) =
            along.fold((0.0, 0.0), |(low, high): (f64, f64), y| (low.min(y), high.max(y)));
        assert!((high - low) * normalization.diagonal > 1.98);
    }
}
