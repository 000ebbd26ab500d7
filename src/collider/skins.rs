//! Skins: said once for each mesh, since its hulls are of the mesh as it was modelled, and so are
//! baked ones, whatever joints do to it.

use bevy::mesh::VertexAttributeValues;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use super::work::AttachedCollider;
use crate::tag::outcomes::{Descriptions, entities};
use crate::tag::{ConvexDecomposition, DecompositionShape};

/// Reading files, the same on average over all vertices moves all of a mesh.
const LEAST_MOVE_OF_ALL: f32 = 0.1;

/// Logs meshes with skins after their collider is attached, one line a frame of each kind: what
/// became of them where the tag does not choose, and that skins move or scale all of them.
pub(super) fn warn_of_skins(
    attached: Query<(Entity, Option<&ConvexDecomposition>), Added<AttachedCollider>>,
    children: Query<&Children>,
    skinned: Query<(&Mesh3d, &SkinnedMesh)>,
    rest: Rest,
    mut known: Local<HashSet<AssetId<Mesh>>>,
) {
    let (mut at_rest, mut moved) = (Vec::new(), Vec::new());
    for (collider, tag) in &attached {
        let is_chosen = tag.is_none_or(|tag| tag.shape != DecompositionShape::Auto);
        let below = std::iter::once(collider).chain(children.iter_descendants(collider));
        for entity in below {
            let Ok((mesh, skin)) = skinned.get(entity) else { continue };
            if !known.insert(mesh.id()) {
                continue;
            }
            if rest.moves_all(entity, mesh, skin) == Some(true) {
                moved.push((entity, mesh.id()));
            } else if !is_chosen {
                at_rest.push((entity, mesh.id()));
            }
        }
    }
    for (meshes, text) in [
        (
            moved,
            "the joints of a skin move or scale the mesh of {}: its collider is of the mesh as modelled",
        ),
        (
            at_rest,
            "the collider of {} is of the mesh as modelled, and does not move with the joints of its skin; choose \
             DecompositionShape::Capsule or ConvexHull for one body around it, Hulls for hulls at rest, or \
             NoConvexDecomposition for none",
        ),
    ] {
        if let Some((entity, mesh)) = meshes.first() {
            let first = rest.descriptions.entity(*entity, Some(mesh.untyped()));
            log::warn!("{}", text.replace("{}", &entities(meshes.len(), &first)));
        }
    }
}

/// Where joints are, and what they do to vertices.
#[derive(bevy::ecs::system::SystemParam)]
pub(super) struct Rest<'w, 's> {
    transforms: TransformHelper<'w, 's>,
    descriptions: Descriptions<'w, 's>,
    meshes: Res<'w, Assets<Mesh>>,
    inverse_bindposes: Option<Res<'w, Assets<SkinnedMeshInverseBindposes>>>,
}

impl Rest<'_, '_> {
    /// Whether joints move the corners of a mesh's box by much of its diagonal, on average over all
    /// joints. `None` if that is not known. O(vertices and joints).
    fn moves_all(&self, entity: Entity, mesh: &Mesh3d, skin: &SkinnedMesh) -> Option<bool> {
        let global = |entity| Some(self.transforms.compute_global_transform(entity).ok()?.affine());
        let own = global(entity)?;
        let inverse = self.inverse_bindposes.as_ref()?.get(&skin.inverse_bindposes)?;
        let corners = self.corners(mesh)?;
        let diagonal = own.transform_vector3(corners[7] - corners[0]).length();
        let (mut sum, mut count) = (0.0, 0.0);
        for (joint, inverse) in skin.joints.iter().zip(inverse.iter()) {
            let moved = Mat4::from(global(*joint)?) * *inverse;
            for corner in corners {
                sum += own.transform_point3(corner).distance(moved.transform_point3(corner));
                count += 1.0;
            }
        }
        Some(sum > LEAST_MOVE_OF_ALL * diagonal * count)
    }

    fn corners(&self, mesh: &Mesh3d) -> Option<[Vec3; 8]> {
        let positions = self.meshes.get(mesh)?.try_attribute(Mesh::ATTRIBUTE_POSITION).ok()?;
        let VertexAttributeValues::Float32x3(positions) = positions else { return None };
        let nothing = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = positions.iter().fold(nothing, |(low, high), point| {
            (low.min(Vec3::from(*point)), high.max(Vec3::from(*point)))
        });
        let corner =
            |of: usize| Vec3::from_array([0, 1, 2].map(|axis| [low, high][of >> axis & 1][axis]));
        Some([0, 1, 2, 3, 4, 5, 6, 7].map(corner))
    }
}
