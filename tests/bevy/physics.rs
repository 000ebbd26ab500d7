//! The physics extensions of glTF files: `KHR_physics_rigid_bodies` with `KHR_implicit_shapes`, and
//! OMI's. The files have what the specifications' public samples have, by kind.

use bevy::asset::{LoadState, UntypedAssetId};
use bevy::gltf::GltfLoaderSettings;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use serde_json::{Value, json};

use crate::app::*;
use crate::artists::{app_with_file, file_of, node};
use crate::engine::*;
use crate::gltf::app_with_gltf;

const KHR: &str = "KHR_physics_rigid_bodies";
const OMI: &str = "OMI_physics_body";

/// A file of such nodes, whose mesh 0 is an L of extent 2, and such shapes, materials and filters.
fn file(extension: &str, nodes: Vec<Value>, roots: Vec<usize>, more: &Value) -> String {
    let mut file: Value = serde_json::from_str(&file_of(nodes, roots)).unwrap();
    let shapes = if extension == KHR { "KHR_implicit_shapes" } else { "OMI_physics_shape" };
    file["extensionsUsed"] = json!([extension, shapes]);
    file["extensions"] = json!({
        shapes: {"shapes": more["shapes"]},
        extension: {"physicsMaterials": more["materials"], "collisionFilters": more["filters"]},
    });
    file.to_string()
}

fn khr(name: &str, at: [f32; 3], physics: Value) -> Value {
    json!({"name": name, "translation": at, "extensions": {KHR: physics}})
}

fn shape_collider(shape: usize) -> Value {
    json!({"collider": {"geometry": {"shape": shape}}})
}

/// An app that has loaded such a file, by the extension of Khronos.
fn load_khr(nodes: Vec<Value>, roots: Vec<usize>, more: &Value) -> (App, tempfile::TempDir) {
    load(file(KHR, nodes, roots, more))
}

/// A scene without any mesh to tag is there after some frames.
fn load(file: String) -> (App, tempfile::TempDir) {
    load_below(file, ConvexDecompositionHierarchy::new(automatic()))
}

fn load_below(file: String, root: impl Bundle) -> (App, tempfile::TempDir) {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("it.gltf"), file).unwrap();
    let mut app = app_with_gltf(directory.path().display().to_string(), |_| {});
    let scene = app.load(GltfAssetLabel::Scene(0).from_asset("it.gltf"));
    let root = app.put((WorldAssetRoot(scene), root));
    update_until(&mut app, |app| {
        app.get::<HierarchyStatus>(root).is_some_and(HierarchyStatus::is_finished)
    });
    update_times(&mut app, 3);
    (app, directory)
}

/// The size of an entity's collider in the engine.
fn size(app: &mut App, name: &str) -> Vec3 {
    let node = node(app, name);
    let (_, shape) = in_engine(app, node);
    Vec3::from(shape.compute_local_aabb().extents().to_array())
}

fn boxes() -> Value {
    json!({"shapes": [{"type": "box", "box": {"size": [1, 1, 1]}}]})
}

#[test]
fn every_shape_by_its_measures_is_a_collider_of_that_size() {
    let capsule = |top: f32| json!({"height": 1, "radiusTop": top, "radiusBottom": 0.5});
    let shapes = json!({"shapes": [
        {"type": "box", "box": {"size": [1, 2, 3]}},
        {"type": "sphere", "sphere": {"radius": 0.5}},
        {"type": "capsule", "capsule": capsule(0.5)},
        {"type": "capsule", "capsule": capsule(0.25)},
        {"type": "cylinder", "cylinder": capsule(0.5)},
        {"type": "cylinder", "cylinder": capsule(0.25)},
        {"type": "cylinder", "cylinder": capsule(0.0)},
        {"type": "plane", "plane": {"sizeX": 4, "sizeZ": 6}},
    ]});
    let sizes = [
        [1.0, 2.0, 3.0],
        [1.0, 1.0, 1.0],
        [1.0, 2.0, 1.0],
        [1.0, 1.75, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, 1.0, 1.0],
        [4.0, 0.0, 6.0],
    ];
    for scale in [1.0, 2.0, -1.0] {
        let mut nodes: Vec<Value> = (0..sizes.len())
            .map(|at| khr(&format!("shape {at}"), [10.0 * at as f32, 0.0, 0.0], shape_collider(at)))
            .collect();
        nodes.iter_mut().for_each(|node| node["scale"] = json!([scale, scale, scale]));
        let roots = (0..nodes.len()).collect();
        let (mut app, _directory) = load_khr(nodes, roots, &shapes);
        for (at, expected) in sizes.into_iter().enumerate() {
            let name = format!("shape {at}");
            let expected = Vec3::from(expected) * f32::abs(scale);
            assert_near(size(&mut app, &name), expected, 0.02 * expected.max_element());
        }
        assert_eq!(counters(&app).decomposed, 0);
    }
}

#[test]
fn an_endless_plane_is_a_half_space_and_a_shape_of_no_scale_is_off() {
    let shapes = json!({"shapes": [{"type": "plane"}, {"type": "sphere"}]});
    let mut nothing = khr("nothing", [0.0; 3], shape_collider(1));
    nothing["scale"] = json!([0, 0, 0]);
    let ground = khr("ground", [0.0; 3], shape_collider(0));
    let (mut app, _directory) = load_khr(vec![ground, nothing], vec![0, 1], &shapes);
    let [ground, nothing] = ["ground", "nothing"].map(|name| node(&mut app, name));
    assert!(shape(collider(&app, ground)).as_halfspace().is_some());
    assert!(!has_collider(&app, nothing));
}

#[test]
fn a_body_has_all_colliders_below_it_up_to_other_bodies() {
    for extension in [KHR, OMI] {
        let body = |physics| json!({extension: physics});
        let motion = if extension == KHR { json!({}) } else { json!({"type": "dynamic"}) };
        let collider = match extension {
            KHR => json!({"geometry": {"shape": 0}}),
            _ => json!({"shape": 0}),
        };
        let nodes = vec![
            json!({"name": "body", "translation": [0, 5, 0], "children": [1, 2],
                "extensions": body(json!({"motion": motion, "collider": collider}))}),
            json!({"name": "arm", "translation": [1, 0, 0],
                "extensions": body(json!({"collider": collider}))}),
            json!({"name": "other body", "translation": [9, 0, 0],
                "extensions": body(json!({"motion": motion, "collider": collider}))}),
            json!({"name": "ground", "translation": [0, -5, 0],
                "extensions": body(json!({"collider": collider}))}),
        ];
        let (mut app, _directory) = load(file(extension, nodes, vec![0, 3], &boxes()));
        let [body, arm, other, ground] =
            ["body", "arm", "other body", "ground"].map(|name| node(&mut app, name));
        assert_eq!(app.get::<RigidBody>(body), Some(&RigidBody::Dynamic));
        assert_eq!(app.get::<RigidBody>(arm), None);
        for (entity, of) in [(body, body), (arm, body), (other, other)] {
            assert_eq!(body_in_engine(&mut app, entity), Some(of), "{extension}");
        }
        update_times(&mut app, 20);
        let height =
            |app: &App, entity| app.get::<GlobalTransform>(entity).unwrap().translation().y;
        assert!(height(&app, body) < 4.9 && height(&app, other) < 4.9);
        assert_eq!(height(&app, ground), -5.0);
    }
}

#[test]
fn meshes_are_hulls_where_they_move_triangles_where_not_and_one_hull_on_request() {
    let own = |is_convex: bool, motion: bool| {
        let mut physics = json!({"collider": {"geometry": {"node": 0, "convexHull": is_convex}}});
        if motion {
            physics["motion"] = json!({});
        }
        physics
    };
    let mut nodes = Vec::new();
    let all = [
        ("wall", false, false),
        ("prop", false, true),
        ("rock", true, false),
        ("stone", true, true),
    ];
    for (at, (name, is_convex, moves)) in all.into_iter().enumerate() {
        let mut node = khr(name, [5.0 * at as f32, 0.0, 0.0], own(is_convex, moves));
        node["mesh"] = json!(0);
        node["extensions"][KHR]["collider"]["geometry"]["node"] = json!(at);
        nodes.push(node);
    }
    nodes.push(json!({"name": "decoration", "mesh": 0}));
    let (mut app, _directory) = load_khr(nodes, vec![0, 1, 2, 3, 4], &json!({}));
    let hulls = |app: &mut App, name: &str| {
        let node = node(app, name);
        let shape = app.get::<Collider>(node).map(shape)?;
        let parts = shape.as_compound().map_or(1, |parts| parts.shapes().len());
        Some((shape.as_trimesh().is_some(), parts))
    };
    assert_eq!(hulls(&mut app, "wall"), Some((true, 1)));
    assert_eq!(hulls(&mut app, "prop"), Some((false, 2)));
    assert_eq!(hulls(&mut app, "rock"), Some((false, 1)));
    assert_eq!(hulls(&mut app, "stone"), Some((false, 1)));
    // The file says what collides, so what it says nothing of does not.
    assert_eq!(hulls(&mut app, "decoration"), None);
}

#[test]
fn a_file_without_bodies_and_colliders_says_nothing_of_its_meshes() {
    let file = file(KHR, vec![json!({"name": "wall", "mesh": 0})], vec![0], &boxes());
    let (mut app, _directory) = app_with_file(file, ConvexDecompositionHierarchy::default());
    let wall = node(&mut app, "wall");
    assert!(has_collider(&app, wall));
}

#[test]
fn extras_come_before_the_extension_and_neither_is_followed_on_request() {
    let mut node_of = khr("prop", [0.0; 3], shape_collider(0));
    (node_of["mesh"], node_of["extras"]) = (json!(0), json!({"collider": "hulls"}));
    let text = file(KHR, vec![node_of.clone()], vec![0], &boxes());
    let (mut app, _directory) = app_with_file(text, ConvexDecompositionHierarchy::default());
    let prop = node(&mut app, "prop");
    assert_eq!(hulls(&app, prop).len(), 2);
    node_of["extras"] = json!({});
    let text = file(KHR, vec![node_of], vec![0], &boxes());
    let hierarchy = ConvexDecompositionHierarchy {
        follows_artists: false,
        ..ConvexDecompositionHierarchy::new(tag())
    };
    let (mut app, _directory) = app_with_file(text, hierarchy);
    let prop = node(&mut app, "prop");
    assert_eq!(hulls(&app, prop).len(), 2);
}

#[test]
fn a_mesh_elsewhere_makes_a_collider_with_all_below_it_and_is_not_drawn() {
    // Node 1 is in no scene. The mesh is half as large there, and again one to the right.
    let nodes = vec![
        khr("body", [0.0; 3], json!({"motion": {}, "collider": {"geometry": {"node": 1}}})),
        json!({"name": "low poly", "mesh": 0, "translation": [7, 7, 7], "children": [2]}),
        json!({"mesh": 0, "translation": [3, 0, 0], "scale": [0.5, 0.5, 0.5]}),
    ];
    let (mut app, _directory) = load_khr(nodes, vec![0], &json!({}));
    let body = node(&mut app, "body");
    let made = app.get::<Children>(body).unwrap()[0];
    assert_eq!(hulls(&app, made).len(), 4);
    let (low, high) = bounds(&app, made);
    // The L reaches from -0.5 to 0.5 along x.
    assert!((low.x + 0.5).abs() < 1e-4 && (high.x - 3.25).abs() < 1e-4, "{low} {high}");
    assert_eq!(body_in_engine(&mut app, made), Some(body));
    for mesh in app.get::<Children>(made).unwrap() {
        assert_eq!(app.get(*mesh), Some(&Visibility::Hidden));
    }
}

#[test]
fn omis_meshes_are_hulls_or_triangles() {
    let shapes = json!({"shapes": [
        {"type": "convex", "convex": {"mesh": 0}}, {"type": "trimesh", "trimesh": {"mesh": 0}},
    ]});
    let omi = |name: &str, shape: usize| json!({"name": name, "extensions": {OMI: {"collider": {"shape": shape}}}});
    let nodes = vec![omi("convex", 0), omi("concave", 1)];
    let (mut app, _directory) = load(file(OMI, nodes, vec![0, 1], &shapes));
    for (name, is_triangles) in [("convex", false), ("concave", true)] {
        let node = node(&mut app, name);
        let made = app.get::<Children>(node).unwrap()[0];
        assert_eq!(shape(collider(&app, made)).as_trimesh().is_some(), is_triangles, "{name}");
    }
}

#[test]
fn materials_are_surfaces() {
    let more = json!({
        "shapes": [{"type": "box"}],
        "materials": [{"staticFriction": 0.8, "dynamicFriction": 0.25, "restitution": 0.5,
            "frictionCombine": "maximum", "restitutionCombine": "minimum"}],
    });
    let physics = json!({"collider": {"geometry": {"shape": 0}, "physicsMaterial": 0}});
    let (mut app, _directory) = load_khr(vec![khr("floor", [0.0; 3], physics)], vec![0], &more);
    let floor = node(&mut app, "floor");
    assert_eq!(friction_of(&app, floor), Some((0.25, "max".into())));
    assert_eq!(restitution_of(&app, floor), Some((0.5, "min".into())));
}

#[test]
fn what_the_scene_and_its_extras_say_of_surfaces_holds_for_shapes_too() {
    let mut group = json!({"name": "group", "extras": {"friction": 0.125}, "children": [1]});
    group["extensions"] = json!({});
    let file = file(KHR, vec![group, khr("box", [0.0; 3], shape_collider(0))], vec![0], &boxes());
    let root = (ConvexDecompositionHierarchy::default(), layers());
    let (mut app, _directory) = load_below(file, root);
    let shape = node(&mut app, "box");
    assert_eq!(friction_of(&app, shape).map(|of| of.0), Some(0.125));
    assert_eq!(app.get::<Layers>(shape), Some(&layers()));
}

#[test]
fn filters_let_bodies_through() {
    let more = json!({
        "shapes": [{"type": "box", "box": {"size": [1, 1, 1]}}, {"type": "box", "box": {"size": [9, 1, 9]}}],
        "filters": [
            {"collisionSystems": ["landscape"]},
            {"collisionSystems": ["ghost"], "notCollideWithSystems": ["landscape"]},
            {"collisionSystems": ["picky"], "collideWithSystems": ["ghost"]},
            {"collisionSystems": ["prop"], "collideWithSystems": ["landscape"]},
        ],
    });
    let body = |name: &str, x: f32, filter: Option<usize>| {
        let mut physics = json!({"motion": {}, "collider": {"geometry": {"shape": 0}}});
        if let Some(filter) = filter {
            physics["collider"]["collisionFilter"] = json!(filter);
        }
        khr(name, [x, 1.5, 0.0], physics)
    };
    let floor = json!({"collider": {"geometry": {"shape": 1}, "collisionFilter": 0}});
    let nodes = vec![
        khr("floor", [0.0; 3], floor),
        body("ghost", -3.0, Some(1)),
        body("picky", -1.0, Some(2)),
        body("prop", 1.0, Some(3)),
        body("plain", 3.0, None),
    ];
    let (mut app, _directory) = load_khr(nodes, vec![0, 1, 2, 3, 4], &more);
    update_times(&mut app, 60);
    for (name, stays) in [("ghost", false), ("picky", false), ("prop", true), ("plain", true)] {
        let body = node(&mut app, name);
        let height = translation(&app, body).y;
        assert_eq!(height > 0.9, stays, "{name} at {height}");
    }
    let systems = app.world().resource::<CollisionSystems>();
    assert!(systems.group("landscape").is_some() && systems.group("lava").is_none());
}

#[test]
fn triggers_are_sensors_also_beside_a_collider_and_in_compounds() {
    let more = json!({"shapes": [
        {"type": "box", "box": {"size": [1, 1, 1]}}, {"type": "sphere", "sphere": {"radius": 2}},
    ]});
    let trigger = |shape: usize| json!({"trigger": {"geometry": {"shape": shape}}});
    let mut both = shape_collider(0);
    both["trigger"] = trigger(1)["trigger"].clone();
    let mut compound = khr("compound", [9.0, 0.0, 0.0], json!({"trigger": {"nodes": [3]}}));
    compound["children"] = json!([3]);
    let nodes = vec![
        khr("zone", [0.0; 3], trigger(0)),
        khr("both", [5.0, 0.0, 0.0], both),
        compound,
        khr("part", [0.0; 3], trigger(1)),
    ];
    let (mut app, _directory) = load_khr(nodes, vec![0, 1, 2], &more);
    let is_sensor =
        |app: &App, entity| has_collider(app, entity).then(|| app.get::<Sensor>(entity).is_some());
    let [zone, both, compound, part] =
        ["zone", "both", "compound", "part"].map(|name| node(&mut app, name));
    assert_eq!(is_sensor(&app, zone), Some(true));
    assert_eq!(is_sensor(&app, both), Some(false));
    let beside = app.get::<Children>(both).unwrap()[0];
    assert_eq!(is_sensor(&app, beside), Some(true));
    assert_eq!((is_sensor(&app, compound), is_sensor(&app, part)), (None, Some(true)));
}

#[test]
fn bodies_begin_and_fall_as_their_motion_says() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let body = |name: &str, x: f32, motion: Value| {
        khr(name, [x, 0.0, 0.0], json!({"motion": motion, "collider": {"geometry": {"shape": 0}}}))
    };
    let mut turned = body("turned", 0.0, json!({"gravityFactor": 0, "linearVelocity": [1, 0, 0]}));
    // A quarter turn around y: x is where -z was.
    turned["rotation"] = json!([0, half, 0, half]);
    let nodes = vec![
        turned,
        body("spinning", 5.0, json!({"gravityFactor": 0, "angularVelocity": [0, 2, 0]})),
        body("rising", 10.0, json!({"gravityFactor": -1})),
        body("lift", 15.0, json!({"isKinematic": true, "linearVelocity": [0, 3, 0]})),
        body("script", 20.0, json!({"isKinematic": true})),
    ];
    let (mut app, _directory) = load_khr(nodes, vec![0, 1, 2, 3, 4], &boxes());
    update_times(&mut app, 30);
    let [turned, spinning, rising, lift, script] =
        ["turned", "spinning", "rising", "lift", "script"].map(|name| node(&mut app, name));
    assert_near(linear_velocity(&app, turned), [0.0, 0.0, -1.0], 1e-3);
    assert_near(angular_velocity(&app, spinning), [0.0, 2.0, 0.0], 1e-2);
    assert!(translation(&app, rising).y > 0.5);
    assert!(translation(&app, lift).y > 0.5, "{}", translation(&app, lift));
    assert_eq!(app.get::<RigidBody>(lift), Some(&KINEMATIC_BY_VELOCITY));
    assert_eq!(app.get::<RigidBody>(script), Some(&KINEMATIC));
    assert_eq!(translation(&app, script).y, 0.0);
}

#[test]
fn masses_and_centres_are_those_of_the_file() {
    let body = |name: &str, x: f32, motion: Value| {
        khr(name, [x, 0.0, 0.0], json!({"motion": motion, "collider": {"geometry": {"shape": 0}}}))
    };
    let mut prop = khr(
        "prop",
        [15.0, 0.0, 0.0],
        json!({"motion": {"mass": 7, "centerOfMass": [0, -1, 0]}, "collider": {"geometry": {"node": 3}}}),
    );
    prop["mesh"] = json!(0);
    let nodes = vec![
        body("plain", 0.0, json!({})),
        body("heavy", 5.0, json!({"mass": 40})),
        body("low", 10.0, json!({"centerOfMass": [0, -0.5, 0], "inertiaDiagonal": [1, 2, 3]})),
        prop,
    ];
    let (mut app, _directory) = load_khr(nodes, vec![0, 1, 2, 3], &boxes());
    update_times(&mut app, 5);
    for (name, mass, centre) in [
        ("plain", 1.0, [0.0; 3]),
        ("heavy", 40.0, [0.0; 3]),
        ("low", 1.0, [0.0, -0.5, 0.0]),
        ("prop", 7.0, [0.0, -1.0, 0.0]),
    ] {
        let body = node(&mut app, name);
        let (found, found_centre) = mass_of_whole(&mut app, body);
        assert!((found - mass).abs() < 1e-3 * mass, "{name} weighs {found}");
        assert_near(found_centre, centre, 1e-4);
    }
}

#[test]
fn a_moment_of_inertia_of_zero_lets_nothing_turn_the_body() {
    let body = |name: &str, x: f32, motion: Value| {
        khr(name, [x, 2.0, 0.0], json!({"motion": motion, "collider": {"geometry": {"shape": 0}}}))
    };
    // Each falls with one edge on a ledge.
    let ledge = |x: f32| khr("ledge", [x - 0.8, 0.0, 0.0], shape_collider(0));
    let nodes = vec![
        body("turns", 0.0, json!({"mass": 1})),
        body("upright", 10.0, json!({"mass": 1, "inertiaDiagonal": [0, 0, 0]})),
        ledge(0.0),
        ledge(10.0),
    ];
    let (mut app, _directory) = load_khr(nodes, vec![0, 1, 2, 3], &boxes());
    update_times(&mut app, 60);
    let turn = |app: &mut App, name: &str| {
        let body = node(app, name);
        app.get::<Transform>(body).unwrap().rotation.angle_between(Quat::IDENTITY)
    };
    assert!(turn(&mut app, "turns") > 0.1);
    assert!(turn(&mut app, "upright") < 1e-3);
}

#[test]
fn what_is_wrong_is_logged_with_the_node_and_the_rest_holds() {
    Log::install();
    let mut cycle = khr("cycle", [0.0; 3], json!({"collider": {"geometry": {"node": 0}}}));
    cycle["children"] = json!([5]);
    let nodes = vec![
        cycle,
        khr("no shape", [0.0; 3], shape_collider(771)),
        khr(
            "no material",
            [0.0; 3],
            json!({"collider": {"geometry": {"shape": 0}, "physicsMaterial": 772}}),
        ),
        khr("no node", [0.0; 3], json!({"trigger": {"geometry": {"node": 773}}})),
        khr("joint of this test", [0.0; 3], json!({"joint": {"connectedNode": 774, "joint": 0}})),
        json!({"name": "empty"}),
    ];
    let (mut app, _directory) = load_khr(nodes, vec![0, 1, 2, 3, 4], &boxes());
    for (text, name) in
        [("shape 771", "no shape"), ("material 772", "no material"), ("node 773", "no node")]
    {
        let lines = Log::lines_with(text);
        assert!(lines.len() == 1 && lines[0].contains(name), "{lines:?}");
    }
    assert!(
        Log::lines_with("joints are not read").iter().any(|line| line.contains("1 is left out"))
    );
    let [fine, wrong] = ["no material", "no shape"].map(|name| node(&mut app, name));
    assert!(has_collider(&app, fine) && !has_collider(&app, wrong));
}

#[test]
fn colliders_that_would_place_millions_of_meshes_are_left_out() {
    Log::install();
    let many = 300;
    let mut nodes: Vec<Value> = (0..many)
        .map(|_| khr("many", [0.0; 3], json!({"collider": {"geometry": {"node": many}}})))
        .collect();
    let children: Vec<usize> = (many + 1..2 * many).collect();
    nodes.push(json!({"name": "all", "children": children}));
    nodes.extend((1..many).map(|_| json!({"mesh": 0})));
    let roots = (0..many).collect();
    let (mut app, _directory) = load_khr(nodes, roots, &json!({}));
    assert!(!Log::lines_with("place too many meshes").is_empty());
    let mut meshes = app.world_mut().query::<&Mesh3d>();
    assert!(meshes.iter(app.world()).count() <= 1 << 16);
}

fn load_with(file: &str, validate: bool) -> (App, Entity, UntypedAssetId) {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("it.gltf"), file).unwrap();
    let mut app = app_with_gltf(directory.path().display().to_string(), |_| {});
    let server = app.world().resource::<AssetServer>().clone();
    let builder = server.load_builder();
    let scene: Handle<WorldAsset> = builder
        .with_settings(move |settings: &mut GltfLoaderSettings| settings.validate = validate)
        .load(GltfAssetLabel::Scene(0).from_asset("it.gltf"));
    let id = scene.id().untyped();
    let root = app.put((WorldAssetRoot(scene), ConvexDecompositionHierarchy::default()));
    update_until(&mut app, |app| {
        app.get::<HierarchyStatus>(root).is_some_and(HierarchyStatus::is_finished)
    });
    (app, root, id)
}

#[test]
fn a_file_that_requires_the_extension_is_read_without_validation_and_the_log_says_how() {
    Log::install();
    let nodes = vec![khr("box", [0.0; 3], shape_collider(0))];
    let mut required: Value = serde_json::from_str(&file(KHR, nodes, vec![0], &boxes())).unwrap();
    required["extensionsRequired"] = required["extensionsUsed"].clone();
    let required = required.to_string();
    let (app, root, _) = load_with(&required, true);
    let status = app.get::<HierarchyStatus>(root);
    assert!(matches!(status, Some(HierarchyStatus::Finished(report)) if report.is_lost));
    let lines = Log::lines_with("validate: false");
    assert!(lines.iter().any(|line| line.contains(&root.to_string())), "{lines:?}");
    let (mut app, _, _) = load_with(&required, false);
    let node = node(&mut app, "box");
    assert!(has_collider(&app, node));
}

#[test]
fn a_broken_file_that_is_not_validated_ends_in_an_error() {
    let nodes = || vec![json!({"name": "box", "mesh": 0})];
    for (key, broken) in [
        ("mesh", json!(9)),
        ("children", json!([77])),
        ("children", json!([0])),
        ("skin", json!(3)),
    ] {
        let mut nodes = nodes();
        nodes[0][key] = broken;
        nodes[0]["extensions"] = json!({KHR: {"collider": {"geometry": {"node": 0}}}});
        let (app, root, id) = load_with(&file(KHR, nodes, vec![0], &boxes()), false);
        let state = app.world().resource::<AssetServer>().get_load_state(id);
        assert!(matches!(state, Some(LoadState::Failed(_))), "{key}: {state:?}");
        let status = app.get::<HierarchyStatus>(root);
        assert!(matches!(status, Some(HierarchyStatus::Finished(report)) if report.is_lost));
    }
}
