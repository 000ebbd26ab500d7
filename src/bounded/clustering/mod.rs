//! Vertex clustering: a closed mesh of very many triangles is searched through a reduced one
//! (Rossignac and Borrel, "Multi-resolution 3D Approximations for Rendering Complex Scenes", 1993).
//! Only repair, the hulls of patches and verification read all of its triangles.
//!
//! | file | contents |
//! |---|---|
//! | `vertex_clusters` | which vertices are merged |
//! | `quadric` | which vertex of a cluster replaces the others |
//! | `index_lists` | lists of indices in flat arrays |
//!
//! No point moves farther than [`Clustered::displacement`]. So the reduced surface is that close to
//! the source everywhere, and what is inside the reduced solid is inside the source or that close
//! to it, since the winding number about a point changes only when the surface moves across it.
//! (The converse fails for spikes and ribbons that are smaller than cells and vanish.)

mod index_lists;
mod quadric;
mod vertex_clusters;

use std::sync::Arc;

use crate::bounded::refine::refine;
use crate::bounded::settings::Settings;
use crate::bvh::closest_point::closest_point_on_triangle;
use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, distance, length_squared, subtract};
use crate::mesh::{PreparedMesh, TriangleMesh};
use crate::parallel;
use index_lists::IndexLists;
use vertex_clusters::VertexClusters;

/// Meshes of fewer triangles are not clustered: they take well under a second without.
const MIN_TRIANGLES: usize = 100_000;

/// Side of a cell, in bounds. Vertices move by about as much along the surface, and by far less
/// away from it. Cells of 0.3 bounds cost 10 % more time, of 0.22 bounds 30 %; hulls are as many.
const CELL: f64 = 0.4;

/// Clustering must leave less than this share of the triangles to be worth its own time.
const MAX_KEPT_SHARE: f64 = 0.5;

/// A triangle with a side longer than this, in cells, does not collapse: it cannot lie within one
/// cell (whose diagonal is 1.73), so that collapsing it would cut off a feature.
const LONG: f64 = 2.0;

/// Clusters of more vertices or triangles are not used, unless they are a small share of the mesh: each query
/// for a distance looks through three of them. Such clusters arise from a detailed object in a large scene.
const MAX_CLUSTER: usize = 4096;

/// A cluster may hold this share of a mesh's triangles: so many are at the pole of a sphere of ten million.
const MAX_CLUSTER_SHARE: f64 = 1.0 / 64.0;

/// If the triangles around the nearest vertex are farther away than expected by this factor, all
/// triangles of the clusters are looked through.
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

/// The reduced mesh of a prepared one that needs it. Where cavities are kept there is none: a
/// narrow cavity could close.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn cluster(
    prepared: &PreparedMesh,
    settings: &Settings,
    control: &Control,
) -> Result<Option<Arc<Clustered>>, Error> {
    if settings.keep_cavities {
        return Ok(None);
    }
    let clustered = Clustered::new(
        prepared,
        settings.bound.protrusion(),
        settings.bound.longest_edge(),
        control,
    )?;
    Ok(clustered.map(Arc::new))
}

impl Clustered {
    /// `None` where the mesh has few triangles, would keep most of them, is not closed, or has
    /// sheets of triangles in both orientations. O(n log n) for n vertices.
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
        Self::of_clusters(prepared, surface, parents, &clusters, control)
    }

    fn of_clusters(
        prepared: &PreparedMesh,
        surface: TriangleMesh,
        parents: Vec<u32>,
        clusters: &VertexClusters,
        control: &Control,
    ) -> Result<Option<Self>, Error> {
        let VertexClusters { of, count } = clusters;
        let of_vertices = || (0..).zip(of).map(|(vertex, &cluster)| (cluster, vertex));
        let of_triangles = || {
            (0..).zip(&surface.triangles).flat_map(|(index, triangle)| {
                let [a, b, c] = triangle.map(|vertex| of[vertex as usize]);
                let second = (b != a).then_some(b);
                let third = (c != a && c != b).then_some(c);
                [Some(a), second, third].into_iter().flatten().map(move |corner| (corner, index))
            })
        };
        let (chosen, (vertices, around)) = parallel::join(
            || quadric::representatives(&surface, clusters, control),
            || (IndexLists::new(*count, of_vertices), IndexLists::new(*count, of_triangles)),
        );
        let chosen = chosen?;
        control.check()?;
        let share = (MAX_CLUSTER_SHARE * surface.triangles.len() as f64) as usize;
        if vertices.longest().max(around.longest()) > MAX_CLUSTER.max(share) {
            return Ok(None);
        }
        let position = |vertex: u32| surface.positions[vertex as usize];
        let positions: Vec<Vector> = chosen.iter().map(|&vertex| position(vertex)).collect();
        let moved = |(vertex, &cluster): (usize, &u32)| {
            distance(surface.positions[vertex], positions[cluster as usize])
        };
        let displacement = of.iter().enumerate().map(moved).fold(0.0, f64::max);
        let (triangles, representatives) = reduced(&surface, clusters);
        let components = (0..).zip(&surface.triangles).filter(|(_, t)| clusters.keeps(t));
        let components = components
            .map(|(index, _): (usize, _)| prepared.components[parents[index] as usize])
            .collect();
        control.check()?;
        Ok(Some(Self {
            surface: Arc::new(surface),
            parents: Arc::new(parents),
            mesh: TriangleMesh { positions, triangles, ..TriangleMesh::default() },
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
            for &vertex in self.vertices.of(cluster) {
                let away = subtract(self.surface.positions[vertex as usize], point);
                let squared = length_squared(away);
                if squared < nearest.0 {
                    nearest = (squared, vertex, cluster);
                }
            }
        }
        // Where triangles are small, the nearest vertex belongs to the nearest one.
        let (_, vertex, cluster) = nearest;
        let has_vertex =
            |&&triangle: &&u32| self.surface.triangles[triangle as usize].contains(&vertex);
        let at_vertex = self.around.of(cluster).iter().filter(has_vertex);
        let found = self.closest_of(at_vertex, point);
        if found.0 <= EXPECTED * expected {
            return found;
        }
        self.closest_of(vertices.iter().flat_map(|&cluster| self.around.of(cluster)), point)
    }

    fn closest_of<'a>(
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
        let [a, b, c] =
            corners.map(|vertex| subtract(self.surface.positions[vertex as usize], point));
        length_squared(closest_point_on_triangle(a, b, c))
    }
}

/// The triangles that do not collapse, and for each triangle of `surface` the one that represents
/// it: itself, or one that is left at a cluster of its corners.
fn reduced(surface: &TriangleMesh, clusters: &VertexClusters) -> (Vec<[u32; 3]>, Vec<u32>) {
    let VertexClusters { of, count } = clusters;
    let mut triangles = Vec::new();
    // For each cluster the last triangle that is left there.
    let mut left = vec![u32::MAX; *count];
    let mut representatives = vec![u32::MAX; surface.triangles.len()];
    for (index, triangle) in surface.triangles.iter().enumerate() {
        if clusters.keeps(triangle) {
            let corners = triangle.map(|vertex| of[vertex as usize]);
            let new = triangles.len() as u32;
            representatives[index] = new;
            corners.iter().for_each(|&corner| left[corner as usize] = new);
            triangles.push(corners);
        }
    }
    for (representative, corners) in representatives.iter_mut().zip(&surface.triangles) {
        if *representative == u32::MAX {
            let left = corners.map(|corner| left[of[corner as usize] as usize]);
            *representative = left.into_iter().min().unwrap_or(u32::MAX);
        }
    }
    (triangles, representatives)
}

#[cfg(test)]
mod tests;
