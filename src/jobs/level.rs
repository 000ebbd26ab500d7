//! Few triangles within a bound, of what never moves: made, or found in a baked scene.

use bevy::math::Affine3A;
use hullwright::hulls_format::{MeshHash, PlacedMesh};
use hullwright::{Control, Error, simplify_surface};
use sha2::{Digest, Sha256};

use super::request::MeshData;
use crate::tag::outcomes::DecompositionError;
use crate::tag::parameters::metres;

/// What simplifying makes of a mesh.
pub(super) struct FewTriangles {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// For each triangle one of the mesh.
    sources: Vec<u32>,
}

impl FewTriangles {
    /// Each of `positions` is a place of the mesh, which is in single precision.
    pub fn new(positions: &[[f64; 3]], triangles: Vec<[u32; 3]>, sources: Vec<u32>) -> Self {
        let positions = positions.iter().map(|point| point.map(|x| x as f32)).collect();
        Self { positions, triangles, sources }
    }

    /// In the order of the parts of the mesh that it was made of. O(n log n) for n triangles.
    pub fn in_parts_of(self, data: &MeshData) -> MeshData {
        let all = self.triangles.into_iter().zip(self.sources);
        let mut triangles: Vec<(usize, [u32; 3])> =
            all.map(|(triangle, source)| (data.part_of(source), triangle)).collect();
        triangles.sort_by_key(|(part, _)| *part);
        let part_ends = (0..data.part_ends.len())
            .map(|part| triangles.partition_point(|(other, _)| *other <= part) as u32)
            .collect();
        let triangles = triangles.into_iter().map(|(_, triangle)| triangle).collect();
        MeshData { positions: self.positions, triangles, part_ends }
    }
}

/// The same surface with few triangles, in the order of its parts. O(n log n) for n triangles.
pub(super) fn simplified(
    data: MeshData,
    bound: f32,
    control: &Control,
) -> Result<MeshData, DecompositionError> {
    let made = match simplify_surface(data.view(), metres(bound), control) {
        // The engine takes what has no area.
        Err(Error::NothingUsable { .. }) => return Ok(data),
        // By the name that it has here.
        Err(Error::InvalidParameter { reason, .. }) => {
            return Err(Error::InvalidParameter { name: "level_bound", reason }.into());
        }
        made => made?,
    };
    let few = FewTriangles::new(&made.mesh.positions, made.mesh.triangles, made.sources);
    Ok(few.in_parts_of(&data))
}

/// A mesh as its asset has it, and where it is in the collider.
pub(super) struct PlacedData {
    pub data: MeshData,
    pub place: Affine3A,
}

impl PlacedData {
    /// What a baked scene calls it. O(triangles).
    pub fn name(&self) -> PlacedMesh {
        let mesh = MeshHash::of(self.data.view());
        let place = self.place.to_cols_array_2d();
        PlacedMesh { mesh, primitives: self.data.part_ends.len() as u32, place }
    }
}

/// One number for some meshes in their places.
pub(super) fn digest(meshes: &[PlacedMesh]) -> MeshHash {
    let mut hasher = Sha256::new();
    for PlacedMesh { mesh, primitives, place } in meshes {
        hasher.update(mesh.as_bytes());
        hasher.update(primitives.to_le_bytes());
        place.as_flattened().iter().for_each(|x| hasher.update(x.to_le_bytes()));
    }
    MeshHash::from_bytes(hasher.finalize().into())
}
