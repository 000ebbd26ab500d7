//! Names results by the content that they are made from.

use bevy::asset::AssetId;

use crate::ALGORITHM_VERSION;

use super::baked::BakedHulls;
use super::mesh_data::MeshData;
use super::parameters::Goal;

/// Names a collider's geometry by what it is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum ContentKey {
    /// Hash of a mesh, of what is made of it and of the algorithm's version.
    Mesh([u8; 32]),
    Baked(AssetId<BakedHulls>),
}

impl ContentKey {
    /// Hashes what determines a result. O(size).
    pub(super) fn of_mesh(data: &MeshData, goal: &Goal) -> Self {
        let mut hasher = blake3::Hasher::new();
        hash_goal(goal, &mut hasher);
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
pub(super) fn goal_hash(goal: &Goal) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hash_goal(goal, &mut hasher);
    *hasher.finalize().as_bytes()
}

fn hash_goal(goal: &Goal, hasher: &mut blake3::Hasher) {
    hasher.update(&ALGORITHM_VERSION.to_le_bytes());
    goal.hash(hasher);
}
