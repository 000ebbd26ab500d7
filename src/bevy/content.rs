//! Names results by the content that they are made from.

use bevy::asset::AssetId;

use crate::hulls_format::MeshHash;
use crate::{ALGORITHM_VERSION, Parameters};

use super::baked::BakedHulls;
use super::mesh_data::MeshData;
use super::parameters::hash_parameters;

/// Names a collider's geometry by what it is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum ContentKey {
    Mesh {
        mesh: MeshHash,
        /// What is made of it: see [`goal_hash`].
        goal: [u8; 32],
    },
    Baked(AssetId<BakedHulls>),
}

impl ContentKey {
    /// Hashes what determines a result. O(size).
    pub(super) fn of_mesh(data: &MeshData, parameters: Option<&Parameters>) -> Self {
        Self::Mesh { mesh: MeshHash::of(data.view()), goal: goal_hash(parameters) }
    }
}

/// Hash of what is made of a mesh, whichever mesh that is: hulls by these parameters or, without
/// parameters, the triangles as they are.
pub(super) fn goal_hash(parameters: Option<&Parameters>) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&ALGORITHM_VERSION.to_le_bytes());
    hasher.update(&[u8::from(parameters.is_some())]);
    if let Some(parameters) = parameters {
        hash_parameters(parameters, &mut hasher);
    }
    *hasher.finalize().as_bytes()
}
