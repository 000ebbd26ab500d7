//! Scenes as Bevy's own glTF loader spawns them.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::VisibilityClass;
use bevy::gltf::{
    GltfAssetLabel, GltfExtras, GltfMaterialName, GltfMeshExtras, GltfMeshName, GltfPlugin,
    GltfSceneName,
};
use bevy::image::{CompressedImageFormatSupport, CompressedImageFormats, ImagePlugin};
use bevy::prelude::*;
use bevy::transform::components::TransformTreeChanged;
use bevy::world_serialization::WorldSerializationPlugin;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;

use crate::app::*;

/// An app that loads one of the bundled models as a scene.
fn app_with_scene(file: &'static str) -> (App, Entity) {
    let mut app = app_with_plugins(default(), |app| {
        app.insert_resource(CompressedImageFormatSupport(CompressedImageFormats::NONE))
            .add_plugins((
                ImagePlugin::default(),
                bevy::mesh::MeshPlugin,
                WorldSerializationPlugin,
                GltfPlugin::default(),
            ))
            // `DefaultPlugins` and Bevy's feature `reflect_auto_register` do that elsewhere.
            .register_type::<Name>()
            .register_type::<Transform>()
            .register_type::<GlobalTransform>()
            .register_type::<TransformTreeChanged>()
            .register_type::<ChildOf>()
            .register_type::<Children>()
            .register_type::<Mesh3d>()
            .register_type::<Aabb>()
            .register_type::<Visibility>()
            .register_type::<InheritedVisibility>()
            .register_type::<ViewVisibility>()
            .register_type::<VisibilityClass>()
            .register_type::<GltfExtras>()
            .register_type::<GltfMaterialName>()
            .register_type::<GltfMeshExtras>()
            .register_type::<GltfMeshName>()
            .register_type::<GltfSceneName>();
    });
    let scene = GltfAssetLabel::Scene(0).from_asset(file);
    let scene = app.world().resource::<AssetServer>().load(scene);
    let body = app
        .world_mut()
        .spawn((
            WorldAssetRoot(scene),
            RigidBody::Dynamic,
            Transform::from_xyz(0.0, 3.0, 0.0),
            ConvexDecompositionHierarchy::new(tag()),
        ))
        .id();
    (app, body)
}

fn update_until_ready(app: &mut App) {
    let mut statuses = app.world_mut().query::<&DecompositionStatus>();
    update_until(app, |app| {
        statuses.update_archetypes(app.world());
        let mut all = statuses.iter_manual(app.world()).peekable();
        all.peek().is_some() && all.all(DecompositionStatus::is_finished)
    });
}

#[test]
fn a_lamp_of_four_materials_is_one_input() {
    let (mut app, body) = app_with_scene("lamp.glb");
    update_until_ready(&mut app);
    let ready = &app.world().resource::<Seen>().ready;
    assert_eq!(ready.len(), 1);
    let (lamp, hulls) = ready[0];
    assert!(hulls > 1);
    assert_ne!(lamp, body);
    assert_eq!(app.world().get::<Children>(lamp).map(|children| children.len()), Some(4));
    update_times(&mut app, 30);
    assert!(app.world().get::<Transform>(body).unwrap().translation.y < 2.9);
}

#[test]
fn a_chair_of_ten_nodes_is_one_body() {
    let (mut app, body) = app_with_scene("chair.glb");
    update_until_ready(&mut app);
    let ready = app.world().resource::<Seen>().ready.clone();
    assert_eq!(ready.len(), 10);
    // The ten nodes stretch one cube: one decomposition.
    assert_eq!(counters(&app).decomposed, 1);
    app.update();
    let world = app.world_mut();
    let handle = world.get::<RapierRigidBodyHandle>(body).unwrap().0;
    let colliders = world.query::<&RapierContextColliders>().single(world).unwrap();
    for (entity, _) in ready {
        let collider = world.get::<RapierColliderHandle>(entity).unwrap().0;
        assert_eq!(colliders.colliders[collider].parent(), Some(handle));
    }
}
