//! Names results by the content that they are made from.

use bevy::asset::AssetId;

use crate::{ALGORITHM_VERSION, Parameters};

use super::baked::BakedHulls;
use super::mesh_data::MeshData;
use super::parameters::hash_parameters;

/// Names a collider's geometry by what it is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum ContentKey {
    /// Hash of a mesh, the parameters and the algorithm's version.
    Mesh([u8; 32]),
    Baked(AssetId<BakedHulls>),
}

impl ContentKey {
    /// Hashes what determines a result. O(size).
    pub(super) fn of_mesh(data: &MeshData, parameters: Option<&Parameters>) -> Self {
        let mut hasher = blake3::Hasher::new();
        hash_goal(parameters, &mut hasher);
        hasher.update(&(data.positions.len() as u64).to_le_bytes());
        let mut bytes = Vec::with_capacity(12 * data.positions.len().max(data.triangles.len()));
        bytes.extend(data.positions.iter().flatten().flat_map(|x| x.to_le_bytes()));
        hasher.update(&bytes);
        bytes.clear();
        bytes.extend(data.triangles.iter().flatten().flat_map(|x| x.to_le_bytes()));
        hasher.update(&bytes);
        Self::Mesh(*hasher.finalize().as_bytes())
    }
}

/// Hash of what is made of a mesh, whichever mesh that is.
pub(super) fn goal_hash(parameters: Option<&Parameters>) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hash_goal(parameters, &mut hasher);
    *hasher.finalize().as_bytes()
}

/// Hulls by these parameters or, without parameters, the triangles as they are.
fn hash_goal(parameters: Option<&Parameters>, hasher: &mut blake3::Hasher) {
    hasher.update(&ALGORITHM_VERSION.to_le_bytes());
    hasher.update(&[u8::from(parameters.is_some())]);
    if let Some(parameters) = parameters {
        hash_parameters(parameters, hasher);
    }
}
