//! Names and extras by which artists ask for colliders, in files that Bevy's glTF loader reads.

use bevy::gltf::GltfMeshName;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use serde_json::{Value, json};

use crate::app::*;
use crate::engine::*;
use crate::gltf::{INTEGER, app_with_gltf, float_accessor, gltf_file, update_until_ready};

/// A file with one node per name, each with the same mesh, an L, and perhaps extras.
fn file(nodes: &[(&str, Option<&str>)]) -> String {
    let nodes = nodes.iter().enumerate().map(|(at, (name, extras))| {
        let mut node = json!({"name": name, "mesh": 0, "translation": [3 * at, 0, 0]});
        if let Some(extras) = extras {
            node["extras"] = serde_json::from_str(extras).unwrap();
        }
        node
    });
    let roots = (0..nodes.len()).collect();
    file_of(nodes.collect(), roots)
}

/// A file with such nodes, some of which are the scene's own. Their mesh 0 is an L of extent 2.
pub fn file_of(nodes: Vec<Value>, roots: Vec<usize>) -> String {
    let l = model("l_prism");
    let positions = l.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
    let indices: Vec<u32> = l.indices().unwrap().iter().map(|index| index as u32).collect();
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
    let file = json!({
        "scenes": [{"nodes": roots}],
        "nodes": nodes,
        "meshes": [{"name": "L", "primitives": [primitive]}],
    });
    let indices = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    let positions = float_accessor(positions.as_flattened(), "VEC3");
    gltf_file(&[positions, (indices, INTEGER, "SCALAR")], file)
}

/// An app in which such a file is loaded below a root with a dynamic body, and all its colliders
/// are ready.
pub fn app_with_nodes(
    nodes: &[(&str, Option<&str>)],
    hierarchy: ConvexDecompositionHierarchy,
    add: impl FnOnce(&mut App),
) -> (App, tempfile::TempDir) {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("it.gltf"), file(nodes)).unwrap();
    let mut app = app_with_gltf(directory.path().display().to_string(), add);
    let scene = GltfAssetLabel::Scene(0).from_asset("it.gltf");
    let scene = app.load(scene);
    app.world_mut().spawn((
        WorldAssetRoot(scene),
        RigidBody::Dynamic,
        GravityScale(0.0),
        hierarchy,
    ));
    let count = nodes.len();
    let mut meshes = app.world_mut().query::<&GltfMeshName>();
    update_until(&mut app, |app| {
        meshes.update_archetypes(app.world());
        meshes.iter_manual(app.world()).count() == count
    });
    update_times(&mut app, 2);
    update_until_ready(&mut app);
    (app, directory)
}

/// An app that has loaded such a file below an entity with these components, once all tags have
/// ended.
pub fn app_with_file(file: String, root: impl Bundle) -> (App, tempfile::TempDir) {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("it.gltf"), file).unwrap();
    let mut app = app_with_gltf(directory.path().display().to_string(), |_| {});
    let scene = app.load(GltfAssetLabel::Scene(0).from_asset("it.gltf"));
    app.put((WorldAssetRoot(scene), root));
    update_until_ready(&mut app);
    update_times(&mut app, 3);
    (app, directory)
}

pub fn node(app: &mut App, name: &str) -> Entity {
    let mut names = app.world_mut().query::<(Entity, &Name, Has<Mesh3d>)>();
    let found = names.iter(app.world()).find(|(_, found, _)| found.as_str() == name);
    found.unwrap_or_else(|| panic!("no node {name}")).0
}

/// What became of a node: its shape in a word, and whether its mesh is drawn.
fn outcome(app: &mut App, name: &str) -> (&'static str, bool) {
    let node = node(app, name);
    let shape = match app.get::<Collider>(node).map(shape) {
        None => "none",
        Some(shape) => {
            let parts = shape.as_compound().map_or(1, |compound| compound.shapes().len());
            let first = shape.as_compound().map_or(shape, |compound| &compound.shapes()[0].1);
            match (parts, first) {
                (1, first) if first.as_trimesh().is_some() => "triangles",
                (1, first) if first.as_cuboid().is_some() => "box",
                (1, first) if first.as_ball().is_some() => "ball",
                (1, first) if first.as_capsule().is_some() => "capsule",
                (1, _) => "hull",
                _ => "hulls",
            }
        }
    };
    let primitive = app.get::<Children>(node).unwrap()[0];
    let is_hidden = |entity| app.get(entity) == Some(&Visibility::Hidden);
    (shape, !is_hidden(primitive) && !is_hidden(node))
}

fn assert_outcomes(
    expected: &[(&str, (&'static str, bool))],
    hierarchy: ConvexDecompositionHierarchy,
) -> App {
    let nodes: Vec<(&str, Option<&str>)> = expected.iter().map(|(name, _)| (*name, None)).collect();
    let (mut app, _directory) = app_with_nodes(&nodes, hierarchy, |_| {});
    for (name, expected) in expected {
        assert_eq!(outcome(&mut app, name), *expected, "{name}");
    }
    app
}

#[test]
fn godots_suffixes_and_ours_say_what_a_mesh_becomes_and_whether_it_is_drawn() {
    let app = assert_outcomes(
        &[
            ("plain", ("none", true)),
            ("a-col", ("triangles", true)),
            ("b_CONVCOL", ("hull", true)),
            ("c$colonly", ("triangles", false)),
            ("d-ConvColOnly.001", ("hull", false)),
            ("e-convdecomp", ("hulls", true)),
            ("f-convdecomponly", ("hulls", false)),
            ("g-noimp", ("none", false)),
            ("h-navmesh", ("none", false)),
        ],
        ConvexDecompositionHierarchy::tagged_only(),
    );
    assert_eq!(ready(&app).len(), 4);
    assert_eq!(seen(&app).skipped.len(), 2);
}

#[test]
fn a_rigid_suffix_makes_a_body_of_one_hull() {
    let mut app = assert_outcomes(
        &[("crate-rigid", ("hull", true))],
        ConvexDecompositionHierarchy::tagged_only(),
    );
    let body = node(&mut app, "crate-rigid");
    assert_eq!(app.get(body), Some(&RigidBody::Dynamic));
}

#[test]
fn extras_make_bodies_that_move_on_their_own() {
    let body = |kind: &str| format!(r#"{{"collider": "convex_decomposition", "body": "{kind}"}}"#);
    let [dynamic, fixed, kinematic] = ["dynamic", "fixed", "kinematic"].map(body);
    let (mut app, _directory) = app_with_nodes(
        &[
            ("prop", Some(&dynamic)),
            ("wall", Some(&fixed)),
            ("lift", Some(&kinematic)),
            ("piece", Some(r#"{"collider": "hulls"}"#)),
        ],
        ConvexDecompositionHierarchy::new(automatic()),
        // The engine may see new bodies before Bevy has computed where they are.
        |app| {
            app.configure_sets(PostUpdate, HullwrightSystems::DetectChanges.before(BEFORE));
        },
    );
    for (at, (name, body, shape)) in (0u8..).zip([
        ("prop", Some(RigidBody::Dynamic), "hulls"),
        ("wall", Some(FIXED), "triangles"),
        ("lift", Some(KINEMATIC), "hulls"),
        ("piece", None, "hulls"),
    ]) {
        let node = node(&mut app, name);
        assert_eq!(translation(&app, node).x, 3.0 * f32::from(at), "{name}");
        assert_eq!(app.get::<RigidBody>(node).copied(), body, "{name}");
        assert_eq!(outcome(&mut app, name).0, shape, "{name}");
    }
    // Each ended once: no body came after its collider.
    assert_eq!(seen(&app).all(), 4);
    update_times(&mut app, 30);
    let [prop, piece] = ["prop", "piece"].map(|name| node(&mut app, name));
    assert!(translation(&app, prop).y < -0.1);
    assert_eq!(translation(&app, piece).y, 0.0);
}

#[test]
fn unreals_prefixes_make_pieces_that_are_not_drawn() {
    let app = assert_outcomes(
        &[
            ("chair", ("none", true)),
            ("UCX_chair_01", ("hull", false)),
            ("UBX_chair_seat", ("box", false)),
            ("USP_chair", ("ball", false)),
            ("UCP_chair_2.001", ("capsule", false)),
            ("lamp", ("hulls", true)),
        ],
        ConvexDecompositionHierarchy::new(tag()),
    );
    assert_eq!(ready(&app).len(), 5);
}

#[test]
fn names_are_names_if_artists_are_not_followed() {
    let hierarchy = ConvexDecompositionHierarchy {
        follows_artists: false,
        ..ConvexDecompositionHierarchy::new(tag())
    };
    let expected = [("a-colonly", ("hulls", true)), ("UCX_b", ("hulls", true))];
    assert_eq!(ready(&assert_outcomes(&expected, hierarchy)).len(), 2);
}

#[test]
fn a_hidden_mesh_is_drawn_again_when_the_scene_says_so() {
    let mut app = assert_outcomes(
        &[("a-convcolonly", ("hull", false))],
        ConvexDecompositionHierarchy::new(tag()),
    );
    let mut scenes = app.world_mut().query::<&mut ConvexDecompositionHierarchy>();
    scenes.single_mut(app.world_mut()).unwrap().follows_artists = false;
    update_times(&mut app, 2);
    update_until_ready(&mut app);
    assert_eq!(outcome(&mut app, "a-convcolonly"), ("hulls", true));
}

#[test]
fn extras_choose_and_tune_the_collider() {
    let (mut app, _directory) = app_with_nodes(
        &[
            (
                "tuned",
                Some(r#"{"collider": "convex_decomposition", "max_error": 0.01, "density": 500}"#),
            ),
            ("metres", Some(r#"{"collider": "hulls", "max_error": "0.02m", "mass": 3}"#)),
            ("box", Some(r#"{"collider": "cuboid"}"#)),
            ("none", Some(r#"{"collider": "none"}"#)),
            ("silent", Some(r#"{"hp": 3}"#)),
        ],
        ConvexDecompositionHierarchy::new(tag().with_mass(9.0)),
        |_| {},
    );
    let tag_of = |app: &mut App, name: &str| {
        let node = node(app, name);
        app.get::<ConvexDecomposition>(node).cloned()
    };
    let base = tag().with_mass(9.0);
    let tuned = tag().with_max_error(0.01).with_density(500.0);
    assert_eq!(tag_of(&mut app, "tuned"), Some(tuned));
    let metres = base.clone().with_max_error(MaxError::Metres(0.02)).with_mass(3.0);
    assert_eq!(tag_of(&mut app, "metres"), Some(metres));
    assert_eq!(tag_of(&mut app, "none"), None);
    assert_eq!(tag_of(&mut app, "silent"), Some(base));
    assert_eq!(outcome(&mut app, "box"), ("box", true));
}

#[test]
fn what_other_programs_put_beside_the_collider_is_no_mistake() {
    Log::install();
    let extras = r#"{"collider": "hulls", "loot_table_of_this_test": "chest", "hp": 30}"#;
    let hierarchy = ConvexDecompositionHierarchy::tagged_only();
    let (mut app, _directory) = app_with_nodes(&[("chest", Some(extras))], hierarchy, |_| {});
    assert_eq!(outcome(&mut app, "chest").0, "hulls");
    assert!(Log::lines_with("loot_table_of_this_test").is_empty());
}

#[test]
fn wrong_extras_are_logged_once_with_the_nodes_name_and_the_keys() {
    Log::install();
    let (mut app, _directory) = app_with_nodes(
        &[
            ("misspelt", Some(r#"{"collider": "hulls", "maxerrror": 0.01}"#)),
            ("absurd", Some(r#"{"collider": "hulls", "max_error": -0.125}"#)),
        ],
        ConvexDecompositionHierarchy::tagged_only(),
        |_| {},
    );
    for (name, key) in [("misspelt", "maxerrror"), ("absurd", "-0.125")] {
        let lines = Log::lines_with(key);
        assert_eq!(lines.len(), 1, "{lines:?}");
        for text in [name, "max_error", "density", "fallback"] {
            assert!(lines[0].contains(text), "{lines:?}");
        }
        // The rest holds.
        assert_eq!(outcome(&mut app, name).0, "hulls");
    }
}
