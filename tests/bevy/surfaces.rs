//! Friction, sensors, groups and events that the extras of glTF files say.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use serde_json::{Value, json};

use crate::app::*;
use crate::artists::{app_with_file, file_of, node};
use crate::engine::*;

/// A file with extras of its scene and of its mesh, an L.
fn file_with(nodes: Vec<Value>, roots: Vec<usize>, of_scene: Value, of_mesh: Value) -> String {
    let mut file: Value = serde_json::from_str(&file_of(nodes, roots)).unwrap();
    file["scenes"][0]["extras"] = of_scene;
    file["meshes"][0]["extras"] = of_mesh;
    file.to_string()
}

fn mesh(name: &str, extras: Value) -> Value {
    json!({"name": name, "mesh": 0, "extras": extras})
}

fn hulls() -> ConvexDecompositionHierarchy {
    ConvexDecompositionHierarchy::new(tag())
}

#[test]
fn extras_alone_set_the_surface_of_a_collider() {
    let ice = json!({
        "friction": 0.05, "friction_combine_rule": "min",
        "restitution": 0.5, "restitution_combine_rule": "max",
        "collision_groups": "1 2 / 3", "active_events": "collision_events", "contact_skin": 0.01,
    });
    let file = file_of(
        vec![mesh("ice", ice), mesh("gate", json!({"sensor": true})), mesh("plain", json!({}))],
        vec![0, 1, 2],
    );
    let (mut app, _directory) = app_with_file(file, hulls());
    let [ice, gate, plain] = ["ice", "gate", "plain"].map(|name| node(&mut app, name));
    assert_eq!(friction_of(&app, ice), Some((0.05, "min".into())));
    assert_eq!(restitution_of(&app, ice), Some((0.5, "max".into())));
    assert_eq!(groups_of(&app, ice), Some((0b11, 0b100)));
    assert!(sends_collisions(&app, ice) && !sends_collisions(&app, plain));
    assert_eq!(skin_of(&app, ice), Some(0.01));
    assert!(app.get::<Sensor>(gate).is_some() && app.get::<Sensor>(plain).is_none());
    assert_eq!((friction_of(&app, plain), groups_of(&app, plain)), (None, None));
    for collider in [ice, gate, plain] {
        assert!(has_collider(&app, collider));
    }
}

#[test]
fn a_sensor_has_hulls_where_what_is_solid_has_triangles() {
    let file =
        file_of(vec![mesh("zone", json!({"sensor": true})), mesh("wall", json!({}))], vec![0, 1]);
    let (mut app, _directory) = app_with_file(file, ConvexDecompositionHierarchy::new(automatic()));
    let [zone, wall] = ["zone", "wall"].map(|name| node(&mut app, name));
    let is_triangles = |entity| shape(collider(&app, entity)).as_trimesh().is_some();
    assert!(!is_triangles(zone) && is_triangles(wall));
}

#[test]
fn what_is_nearer_wins_from_the_node_to_its_mesh_to_what_is_above_to_the_scene() {
    let group = json!({"name": "group", "extras": {"friction": 0.3}, "children": [1, 2]});
    let nodes = vec![
        group,
        mesh("own", json!({"friction": 0.1})),
        json!({"name": "of mesh", "mesh": 0}),
        json!({"name": "alone", "mesh": 0}),
    ];
    for (of_mesh, expected) in
        [(json!({"friction": 0.2}), [0.1, 0.2, 0.2]), (json!({"hp": 3}), [0.1, 0.3, 0.4])]
    {
        let scene = json!({"friction": 0.4, "restitution": 0.25});
        let file = file_with(nodes.clone(), vec![0, 3], scene, of_mesh);
        let (mut app, _directory) = app_with_file(file, hulls());
        for (name, expected) in ["own", "of mesh", "alone"].into_iter().zip(expected) {
            let node = node(&mut app, name);
            assert_eq!(friction_of(&app, node).map(|of| of.0), Some(expected), "{name}");
            assert_eq!(restitution_of(&app, node).map(|of| of.0), Some(0.25), "{name}");
        }
    }
}

#[test]
fn what_the_game_has_put_on_a_body_yields_to_what_the_file_says() {
    let file = file_of(
        vec![mesh("ice", json!({"friction": 0.0})), json!({"name": "stone", "mesh": 0})],
        vec![0, 1],
    );
    let (mut app, _directory) = app_with_file(file, (RigidBody::Dynamic, friction(0.9), hulls()));
    let [ice, stone] = ["ice", "stone"].map(|name| node(&mut app, name));
    assert_eq!(friction_of(&app, ice).map(|of| of.0), Some(0.0));
    assert_eq!(friction_of(&app, stone).map(|of| of.0), Some(0.9));
}

#[test]
fn what_the_game_changes_later_stays() {
    let file = file_of(vec![mesh("ice", json!({"friction": 0.05}))], vec![0]);
    let (mut app, _directory) = app_with_file(file, hulls());
    let ice = node(&mut app, "ice");
    app.edit(ice).remove::<Friction>();
    let mut scenes = app.world_mut().query::<&mut ConvexDecompositionHierarchy>();
    scenes.single_mut(app.world_mut()).unwrap().by_name.insert("another".into(), None);
    update_times(&mut app, 3);
    assert_eq!(friction_of(&app, ice), None);
}

#[test]
fn surfaces_are_left_alone_if_artists_are_not_followed() {
    let file = file_of(vec![mesh("ice", json!({"friction": 0.05, "sensor": true}))], vec![0]);
    let hierarchy = ConvexDecompositionHierarchy { follows_artists: false, ..hulls() };
    let (mut app, _directory) = app_with_file(file, hierarchy);
    let ice = node(&mut app, "ice");
    assert_eq!((friction_of(&app, ice), app.get::<Sensor>(ice)), (None, None));
}

#[test]
fn a_wrong_value_is_logged_and_one_of_somebody_else_is_not() {
    Log::install();
    let file = file_of(
        vec![
            mesh("wrong", json!({"collision_groups": "1 / 77", "friction": 0.5})),
            mesh("others", json!({"friction": "as on the sheet of this test", "sensor": "lidar"})),
        ],
        vec![0, 1],
    );
    let (mut app, _directory) = app_with_file(file, hulls());
    let lines = Log::lines_with("1 / 77");
    assert!(lines.len() == 1 && lines[0].contains("wrong"), "{lines:?}");
    let wrong = node(&mut app, "wrong");
    assert_eq!(friction_of(&app, wrong).map(|of| of.0), Some(0.5));
    assert!(Log::lines_with("as on the sheet of this test").is_empty());
    assert!(Log::lines_with("lidar").is_empty());
}
