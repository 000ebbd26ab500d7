//! Scenes as Bevy's own glTF loader spawns them.

use bevy::gltf::GltfAssetLabel;
use bevy::mesh::morph::MeshMorphWeights;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;

use crate::app::*;
use scenes::HeadlessScenes;

#[path = "../../examples/headless/scenes.rs"]
mod scenes;

/// An app that loads one of the bundled models as a scene, and all its meshes are tagged.
fn app_with_scene(file: &'static str) -> (App, Entity) {
    app_with_scene_in(assets(), file, ConvexDecompositionHierarchy::new(tag()))
}

pub fn app_with_scene_in(
    directory: String,
    file: &str,
    hierarchy: ConvexDecompositionHierarchy,
) -> (App, Entity) {
    let mut app = app_with_gltf(directory, |_| {});
    let scene = GltfAssetLabel::Scene(0).from_asset(file.to_owned());
    let scene = app.world().resource::<AssetServer>().load(scene);
    let body = app
        .world_mut()
        .spawn((
            WorldAssetRoot(scene),
            RigidBody::Dynamic,
            Transform::from_xyz(0.0, 3.0, 0.0),
            hierarchy,
        ))
        .id();
    (app, body)
}

/// An app that loads glTF files as scenes.
pub fn app_with_gltf(directory: String, add: impl FnOnce(&mut App)) -> App {
    app_with_plugins(directory, |app| {
        app.add_plugins(HeadlessScenes);
        add(app);
    })
}

/// Names of nodes that have a component, in alphabetical order.
fn names_with<T: Component>(app: &mut App) -> Vec<String> {
    let world = app.world_mut();
    let mut names: Vec<String> =
        world.query_filtered::<&Name, With<T>>().iter(world).map(|name| name.to_string()).collect();
    names.sort();
    names
}

pub fn update_until_ready(app: &mut App) {
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
    let ready = ready(&app);
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
    let ready = ready(&app).to_vec();
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

#[test]
fn a_scene_that_can_not_be_loaded_ends_in_a_report_that_says_so() {
    let hierarchy = ConvexDecompositionHierarchy::default();
    let (mut app, root) = app_with_scene_in(assets(), "nowhere.glb", hierarchy);
    update_until(&mut app, |app| app.world().get::<HierarchyStatus>(root).unwrap().is_finished());
    let status = app.world().get::<HierarchyStatus>(root);
    let Some(HierarchyStatus::Finished(report)) = status else { panic!("{status:?}") };
    assert!(report.is_lost && report.ready + report.failed == 0, "{report:?}");
    // A body that waits for such a scene is no reason to stay on the loading screen.
    app.update();
    assert!(app.world().resource::<DecompositionProgress>().is_done());
}

#[test]
fn an_artists_tags_are_followed_and_nothing_else_is_decomposed() {
    let hierarchy = ConvexDecompositionHierarchy::tagged_only();
    let (mut app, body) = app_with_scene_in(assets(), "props.glb", hierarchy);
    update_until_ready(&mut app);
    app.update();
    let pieces: Vec<String> = (1..=5).map(|number| format!("UCX_table_{number:02}")).collect();
    let mut expected = pieces.clone();
    expected.extend(["lamp", "mug-convdecomp"].map(String::from));
    assert_eq!(names_with::<ConvexDecomposition>(&mut app), expected);
    assert_eq!(names_with::<Collider>(&mut app), expected);
    // The table has pieces, and the leaf has no tag.
    let all = names_with::<Name>(&mut app);
    assert!(["leaf", "table"].iter().all(|name| all.iter().any(|other| other == name)));

    // Pieces are not drawn, and all else is.
    let mut drawn = app.world_mut().query_filtered::<(&ChildOf, &Visibility), With<Mesh3d>>();
    for (parent, visibility) in drawn.iter(app.world()) {
        let name = app.world().get::<Name>(parent.parent()).unwrap().to_string();
        assert_eq!(*visibility == Visibility::Hidden, pieces.contains(&name), "{name}");
    }

    // The pieces are one hull each, and nothing is decomposed for them; the mug and the lamp are concave.
    assert_eq!(counters(&app).decomposed, 2);
    let ready = ready(&app).to_vec();
    for (entity, hulls) in ready {
        let name = app.world().get::<Name>(entity).unwrap().to_string();
        assert_eq!(hulls == 1, pieces.contains(&name), "{name}: {hulls} hulls");
    }
    update_times(&mut app, 30);
    assert!(app.world().get::<Transform>(body).unwrap().translation.y < 2.9);
}

#[test]
fn morph_targets_and_skins_of_a_file_are_taken_in_their_rest_pose() {
    let directory = tempfile::tempdir().unwrap();
    let written = morphing_and_skinned_cube();
    std::fs::write(directory.path().join("cube.gltf"), written).unwrap();
    let path = directory.path().display().to_string();
    let hierarchy = ConvexDecompositionHierarchy::new(tag());
    let (mut app, body) = app_with_scene_in(path, "cube.gltf", hierarchy);
    update_until_ready(&mut app);
    let mut meshes = app.world_mut().query::<(&Mesh3d, Has<SkinnedMesh>, Has<MeshMorphWeights>)>();
    let found: Vec<_> = meshes.iter(app.world()).collect();
    assert_eq!(found.len(), 1);
    let (mesh, is_skinned, is_morphed) = found[0];
    assert!(is_skinned && is_morphed);
    assert!(app.world().resource::<Assets<Mesh>>().get(&mesh.0).unwrap().has_morph_targets());

    let ready = ready(&app).to_vec();
    let (entity, hulls) = ready[0];
    assert_eq!((ready.len(), hulls), (1, 1));
    let (low, high) = bounds(&app, entity);
    assert_near(low, [0.0; 3], 1e-3);
    assert_near(high, [1.0; 3], 1e-3);
    update_times(&mut app, 30);
    assert!(app.world().get::<Transform>(body).unwrap().translation.y < 2.9);
}

/// A unit cube whose one morph target, fully applied, and whose one joint both move it far away.
fn morphing_and_skinned_cube() -> String {
    use base64::prelude::{BASE64_STANDARD, Engine as _};
    use serde_json::json;
    const FLOAT: u32 = 5126;
    const BYTE: u32 = 5121;
    const SHORT: u32 = 5123;
    let cube = cuboid([0.0; 3], [1.0; 3]);
    let positions = cube.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let inverse_bind = Mat4::IDENTITY.to_cols_array();
    let parts: [(Vec<u8>, u32, &str, usize); 6] = [
        (floats(positions.as_flattened()), FLOAT, "VEC3", 8),
        (floats(&[5.0; 24]), FLOAT, "VEC3", 8),
        (vec![0; 32], BYTE, "VEC4", 8),
        (floats(&[1.0, 0.0, 0.0, 0.0].repeat(8)), FLOAT, "VEC4", 8),
        (floats(&inverse_bind), FLOAT, "MAT4", 1),
        (
            cube.indices().unwrap().iter().flat_map(|i| (i as u16).to_le_bytes()).collect(),
            SHORT,
            "SCALAR",
            36,
        ),
    ];
    let (mut bytes, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    for (index, (part, component, kind, count)) in parts.into_iter().enumerate() {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len()}));
        let mut accessor =
            json!({"bufferView": index, "componentType": component, "type": kind, "count": count});
        if kind == "VEC3" {
            let (low, high) = if index == 0 { (0.0, 1.0) } else { (5.0, 5.0) };
            (accessor["min"], accessor["max"]) =
                (json!([low, low, low]), json!([high, high, high]));
        }
        accessors.push(accessor);
        bytes.extend(part);
    }
    let data = BASE64_STANDARD.encode(&bytes);
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [
            {"name": "cube", "mesh": 0, "skin": 0},
            {"name": "joint", "translation": [50.0, 0.0, 0.0]},
        ],
        "skins": [{"joints": [1], "inverseBindMatrices": 4}],
        "meshes": [{
            "weights": [0.5],
            "primitives": [{
                "attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3},
                "targets": [{"POSITION": 1}],
                "indices": 5,
            }],
        }],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{data}"),
        }],
    })
    .to_string()
}
