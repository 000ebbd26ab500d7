//! Vertex clustering: a mesh of very many triangles is divided into patches through a reduced one
//! (Rossignac and Borrel, "Multi-resolution 3D Approximations for Rendering Complex Scenes", 1993).
//! The solid is that of all its triangles, and patches end with the hulls of all their points.
//!
//! Takes the repaired mesh, gives the reduced one, if it is needed. O(n log n) for n vertices.

mod vertex_clusters;

use std::sync::Arc;

use crate::control::Control;
use crate::error::Error;
use crate::geometry::vector::{Vector, into_arrays};
use crate::mesh::refine::refine;
use crate::mesh::{PreparedMesh, TriangleMesh};
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
}

impl Clustered {
    /// `None` where the mesh has few triangles or would keep most of them.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn new(
        prepared: &PreparedMesh,
        bound: f64,
        longest_edge: f64,
        control: &Control,
    ) -> Result<Option<Self>, Error> {
        if prepared.mesh.triangles.len() < MIN_TRIANGLES {
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
        Self::from_clusters(prepared, surface, parents, &clusters, control).map(Some)
    }

    fn from_clusters(
        prepared: &PreparedMesh,
        surface: TriangleMesh,
        parents: Vec<u32>,
        clusters: &VertexClusters,
        control: &Control,
    ) -> Result<Self, Error> {
        let chosen = representatives(&surface, clusters, control)?;
        control.check()?;
        let position = |&vertex: &u32| surface.points()[vertex as usize];
        let positions: Vec<Vector> = chosen.iter().map(position).collect();
        let (triangles, representatives) = reduced(&surface, clusters);
        let components = (0..).zip(&surface.triangles).filter(|(_, t)| clusters.keeps(t));
        let components = components
            .map(|(index, _): (usize, _)| prepared.components[parents[index] as usize])
            .collect();
        control.check()?;
        Ok(Self {
            surface: Arc::new(surface),
            parents: Arc::new(parents),
            mesh: TriangleMesh {
                positions: into_arrays(positions),
                triangles,
                ..TriangleMesh::default()
            },
            components,
            representatives,
        })
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

#[cfg(test)]
mod tests {
    use super::*;
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
    fn a_surface_with_a_hole_is_clustered_too() {
        let mut mesh = torus(400, 160);
        mesh.triangles.pop();
        assert!(clustered(&mesh).is_some());
    }

    #[test]
    fn the_many_triangles_at_a_pole_do_not_keep_a_sphere_from_being_clustered() {
        assert!(clustered(&uv_sphere(800, [0.0; 3], 1.0)).is_some());
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
            assert!(nearest.fold(f64::INFINITY, f64::min) <= CELL * BOUND * 3f64.sqrt());
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
