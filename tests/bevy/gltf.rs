//! Scenes as Bevy's own glTF loader spawns them.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use bevy::gltf::GltfAssetLabel;
use bevy::mesh::morph::MeshMorphWeights;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use serde_json::{Value, json};

use crate::app::*;
use crate::engine::*;
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
    let scene = app.load(scene);
    let body = app.put((
        WorldAssetRoot(scene),
        RigidBody::Dynamic,
        Transform::from_xyz(0.0, 3.0, 0.0),
        hierarchy,
    ));
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
    assert_eq!(app.get::<Children>(lamp).map(|children| children.len()), Some(4));
    update_times(&mut app, 30);
    assert!(app.get::<Transform>(body).unwrap().translation.y < 2.9);
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
    for (entity, _) in ready {
        assert_eq!(body_in_engine(&mut app, entity), Some(body));
    }
}

#[test]
fn a_scene_that_is_tagged_once_it_is_there_ends_in_a_report_too() {
    let mut app = app_with_gltf(assets(), |_| {});
    let scene = app.load(GltfAssetLabel::Scene(0).from_asset("lamp.glb"));
    let lamp = app.put((WorldAssetRoot(scene), RigidBody::Dynamic));
    update_until(&mut app, |app| app.get::<Children>(lamp).is_some());
    update_times(&mut app, 3);
    app.world_mut().entity_mut(lamp).insert(ConvexDecompositionHierarchy::new(tag()));
    update_until(&mut app, |app| {
        app.get::<HierarchyStatus>(lamp).is_some_and(HierarchyStatus::is_finished)
    });
    assert_eq!(ready(&app).len(), 1);
}

#[test]
fn a_scene_that_can_not_be_loaded_ends_in_a_report_that_says_so() {
    let hierarchy = ConvexDecompositionHierarchy::default();
    let (mut app, root) = app_with_scene_in(assets(), "nowhere.glb", hierarchy);
    update_until(&mut app, |app| app.get::<HierarchyStatus>(root).unwrap().is_finished());
    let status = app.get::<HierarchyStatus>(root);
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
        let name = app.get::<Name>(parent.parent()).unwrap().to_string();
        assert_eq!(*visibility == Visibility::Hidden, pieces.contains(&name), "{name}");
    }

    // The pieces are one hull each, and nothing is decomposed for them; the mug and the lamp are
    // concave.
    assert_eq!(counters(&app).decomposed, 2);
    let ready = ready(&app).to_vec();
    for (entity, hulls) in ready {
        let name = app.get::<Name>(entity).unwrap().to_string();
        assert_eq!(hulls == 1, pieces.contains(&name), "{name}: {hulls} hulls");
    }
    update_times(&mut app, 30);
    assert!(app.get::<Transform>(body).unwrap().translation.y < 2.9);
}

#[test]
fn morph_targets_and_skins_of_a_file_are_taken_as_modelled_and_a_skin_that_moves_them_is_logged() {
    Log::install();
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
    assert_bounds(&app, entity, [0.0; 3], [1.0; 3], 1e-3);
    update_times(&mut app, 30);
    assert!(app.get::<Transform>(body).unwrap().translation.y < 2.9);
    // The joint is far away, and said so once.
    let lines = Log::lines_with("the joints of a skin move or scale the mesh of");
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("cube.gltf#Mesh0"), "{lines:?}");
}

#[test]
fn a_skin_at_rest_is_said_to_be_none_that_moves_and_not_where_a_shape_is_chosen() {
    Log::install();
    let at_rest = morphing_and_skinned_cube().replace("[50.0,0.0,0.0]", "[0.0,0.0,0.0]");
    for (name, shape, lines) in [
        ("unchosen.gltf", DecompositionShape::Auto, 1),
        ("preferred.gltf", DecompositionShape::Capsule, 0),
    ] {
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join(name), &at_rest).unwrap();
        let path = directory.path().display().to_string();
        let hierarchy = ConvexDecompositionHierarchy::new(tag().with_shape(shape));
        let (mut app, _) = app_with_scene_in(path, name, hierarchy);
        update_until_ready(&mut app);
        update_times(&mut app, 3);
        let found = Log::lines_with(name);
        assert_eq!(found.len(), lines, "{found:?}");
        assert!(found.iter().all(|line| line.contains("Capsule")), "{found:?}");
    }
}

const FLOAT: u32 = 5126;
const BYTE: u32 = 5121;
const SHORT: u32 = 5123;
pub const INTEGER: u32 = 5125;

/// A file of these nodes, meshes and skins, whose accessors are given by bytes, type of number and
/// type.
pub fn gltf_file(accessors: &[(Vec<u8>, u32, &str)], mut file: Value) -> String {
    let (mut bytes, mut views, mut written) = (Vec::new(), Vec::new(), Vec::new());
    for (index, (part, number, kind)) in accessors.iter().enumerate() {
        let numbers = [("SCALAR", 1), ("VEC3", 3), ("VEC4", 4), ("MAT4", 16)];
        let numbers = numbers.iter().find(|(name, _)| name == kind).unwrap().1;
        let size = [(BYTE, 1), (SHORT, 2)].iter().find(|(name, _)| name == number);
        let count = part.len() / numbers / size.map_or(4, |(_, size)| *size);
        let mut accessor =
            json!({"bufferView": index, "componentType": number, "type": kind, "count": count});
        if *kind == "VEC3" {
            let bound = |pick: fn(f32, f32) -> f32| {
                let floats =
                    part.chunks_exact(4).map(|x| f32::from_le_bytes(x.try_into().unwrap()));
                [0, 1, 2].map(|axis| floats.clone().skip(axis).step_by(3).reduce(pick).unwrap())
            };
            (accessor["min"], accessor["max"]) = (json!(bound(f32::min)), json!(bound(f32::max)));
        }
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len()}));
        written.push(accessor);
        bytes.extend(part);
    }
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    file["asset"] = json!({"version": "2.0"});
    file["scene"] = json!(0);
    file["accessors"] = json!(written);
    file["bufferViews"] = json!(views);
    file["buffers"] = json!([{"byteLength": bytes.len(), "uri": uri}]);
    file.to_string()
}

pub fn float_accessor<'a>(values: &[f32], kind: &'a str) -> (Vec<u8>, u32, &'a str) {
    (values.iter().flat_map(|x| x.to_le_bytes()).collect(), FLOAT, kind)
}

/// A unit cube whose one morph target, fully applied, and whose one joint both move it far away.
fn morphing_and_skinned_cube() -> String {
    let cube = unit_cube();
    let positions = cube.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
    let indices = cube.indices().unwrap().iter().flat_map(|i| (i as u16).to_le_bytes());
    let accessors = [
        float_accessor(positions.as_flattened(), "VEC3"),
        float_accessor(&[5.0; 24], "VEC3"),
        (vec![0; 32], BYTE, "VEC4"),
        float_accessor(&[1.0, 0.0, 0.0, 0.0].repeat(8), "VEC4"),
        float_accessor(&Mat4::IDENTITY.to_cols_array(), "MAT4"),
        (indices.collect(), SHORT, "SCALAR"),
    ];
    let attributes = json!({"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3});
    let primitive = json!({"attributes": attributes, "targets": [{"POSITION": 1}], "indices": 5});
    let joint = json!({"name": "joint", "translation": [50.0, 0.0, 0.0]});
    let file = json!({
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"name": "cube", "mesh": 0, "skin": 0}, joint],
        "skins": [{"joints": [1], "inverseBindMatrices": 4}],
        "meshes": [{"weights": [0.5], "primitives": [primitive]}],
    });
    gltf_file(&accessors, file)
}
