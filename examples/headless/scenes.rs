//! What Bevy's glTF loader needs in an app without a window.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{DynamicSkinnedMeshBounds, VisibilityClass};
use bevy::gltf::{
    GltfExtras, GltfMaterialExtras, GltfMaterialName, GltfMeshExtras, GltfMeshName, GltfPlugin,
    GltfSceneExtras, GltfSceneName,
};
use bevy::image::{CompressedImageFormatSupport, CompressedImageFormats, ImagePlugin};
use bevy::mesh::MeshPlugin;
use bevy::mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy::transform::components::TransformTreeChanged;
use bevy::world_serialization::WorldSerializationPlugin;

/// Loads glTF scenes, without textures of compressed formats. `DefaultPlugins` and Bevy's feature
/// `reflect_auto_register` do all of it elsewhere.
pub struct HeadlessScenes;

impl Plugin for HeadlessScenes {
    fn build(&self, app: &mut App) {
        app.insert_resource(CompressedImageFormatSupport(CompressedImageFormats::NONE))
            .add_plugins((
                ImagePlugin::default(),
                MeshPlugin,
                WorldSerializationPlugin,
                GltfPlugin::default(),
            ))
            .register_type::<Name>()
            .register_type::<Transform>()
            .register_type::<GlobalTransform>()
            .register_type::<TransformTreeChanged>()
            .register_type::<ChildOf>()
            .register_type::<Children>()
            .register_type::<Mesh3d>()
            .register_type::<MeshMorphWeights>()
            .register_type::<MorphWeights>()
            .register_type::<SkinnedMesh>()
            .register_type::<Aabb>()
            .register_type::<Visibility>()
            .register_type::<InheritedVisibility>()
            .register_type::<ViewVisibility>()
            .register_type::<VisibilityClass>()
            .register_type::<DynamicSkinnedMeshBounds>()
            .register_type::<GltfExtras>()
            .register_type::<GltfMaterialExtras>()
            .register_type::<GltfMaterialName>()
            .register_type::<GltfMeshExtras>()
            .register_type::<GltfMeshName>()
            .register_type::<GltfSceneExtras>()
            .register_type::<GltfSceneName>();
    }
}
