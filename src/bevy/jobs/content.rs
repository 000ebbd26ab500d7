//! Names results by the content that they are made from.

use bevy::asset::AssetId;
use sha2::{Digest, Sha256};

use crate::ALGORITHM_VERSION;
use crate::hulls_format::MeshHash;

use crate::bevy::jobs::baked::BakedHulls;
use crate::bevy::jobs::mesh_data::MeshData;
use crate::bevy::tag::parameters::Goal;

/// Names a collider's geometry by what it is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ContentKey {
    Mesh {
        mesh: MeshHash,
        /// What is made of it: see [`goal_hash`].
        goal: [u8; 32],
    },
    Baked(AssetId<BakedHulls>),
}

impl ContentKey {
    /// Hashes what determines a result. O(size).
    pub(crate) fn of_mesh(data: &MeshData, goal: &Goal) -> Self {
        Self::Mesh { mesh: MeshHash::of(data.view()), goal: goal_hash(goal) }
    }
}

/// Hash of what is made of a mesh, whichever mesh that is.
pub(crate) fn goal_hash(goal: &Goal) -> [u8; 32] {
    let mut hasher = Sha256::new_with_prefix(ALGORITHM_VERSION.to_le_bytes());
    goal.hash(&mut hasher);
    hasher.finalize().into()
}
