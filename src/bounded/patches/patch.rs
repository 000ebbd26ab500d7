//! A patch of the surface, and all patches with what merging needs to know about them.

use std::ops::Index;
use std::sync::Arc;

use crate::bounded::patch_set::PatchSet;
use crate::geometry::vector::{Vector, bounds, distance};
use crate::mesh::TriangleMesh;

/// A part of the surface that is not divided any further.
#[derive(Debug, Clone, Default)]
pub(crate) struct Patch {
    /// Vertices of its hull, except those nearer to it than the patch tolerance; all of its points
    /// where it is flat.
    pub points: Vec<Vector>,
    /// Two of `points` that are far apart; of coarse meshes the centre, too.
    pub representatives: Vec<Vector>,
    /// Sum of its triangles' area normals, each twice as long as the triangle's area.
    pub outward: Vector,
    pub area: f64,
    pub min: Vector,
    pub max: Vector,
    /// The triangles of [`Patches::surface`] that it represents.
    pub triangles: Vec<u32>,
    /// Their vertices, where the mesh was clustered: collecting so many again would be slow.
    pub surface_points: Vec<Vector>,
    pub component: u32,
}

impl Patch {
    pub(super) fn set_points(&mut self, points: Vec<Vector>) {
        (self.min, self.max) = bounds(points.iter().copied());
        self.representatives = far_pair(&points);
        self.points = points;
    }
}

/// The patches of a surface.
pub(crate) struct Patches {
    pub(super) patches: Vec<Patch>,
    /// Pairs of patches that share an edge.
    pub neighbours: Vec<(u32, u32)>,
    /// A partition of the patches: parts of one group whose joint hull fits. Merging joins them from the start
    /// where there are no conflicts among them.
    pub blocks: Vec<Vec<u32>>,
    /// For each patch those that no hull can contain together with it, by the search's bound. Known once pieces
    /// have merged.
    pub conflicts: Vec<PatchSet>,
    /// The source, its long triangles halved.
    pub surface: Arc<TriangleMesh>,
    /// For each triangle of `surface` the prepared mesh's triangle that it is a part of.
    pub parents: Arc<Vec<u32>>,
    /// The mesh that was divided, and for each of its triangles its patch.
    pub mesh: TriangleMesh,
    pub labels: Vec<u32>,
}

impl Patches {
    pub fn count(&self) -> usize {
        self.patches.len()
    }

    /// The set of all patches.
    pub fn all(&self) -> PatchSet {
        PatchSet::of(self.count(), 0..self.count() as u32)
    }
}

impl Index<u32> for Patches {
    type Output = Patch;

    #[inline]
    fn index(&self, patch: u32) -> &Patch {
        &self.patches[patch as usize]
    }
}

/// Two points that are far apart: the farthest from the first point, and the farthest from that.
pub(super) fn far_pair(points: &[Vector]) -> Vec<Vector> {
    let farthest = |from: Vector| {
        points.iter().copied().max_by(|&a, &b| distance(a, from).total_cmp(&distance(b, from)))
    };
    let first = points.first().and_then(|&point| farthest(point));
    let second = first.and_then(farthest);
    first.into_iter().chain(second).collect()
}
