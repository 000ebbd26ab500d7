//! Of several levels of detail the finest makes the collider, below one tag and in a hierarchy.

use bevy::camera::visibility::VisibilityRange;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use serde_json::json;

use crate::app::*;
use crate::artists::{app_with_file, file_of, node};
use crate::engine::*;

#[test]
fn coarser_levels_by_name_make_no_collider_and_add_no_mass() {
    let level = |name: &str| json!({"name": name, "mesh": 0});
    let mut masses = Vec::new();
    for names in [&["tree"][..], &["tree_LOD0", "tree_LOD1", "tree_lod2"], &["tree_LOD2"]] {
        let nodes: Vec<_> = names.iter().map(|name| level(name)).collect();
        let roots = (0..nodes.len()).collect();
        let root = (RigidBody::Dynamic, ConvexDecompositionHierarchy::new(tag()));
        let (mut app, _directory) = app_with_file(file_of(nodes, roots), root);
        let colliders = names.iter().filter(|name| {
            let node = node(&mut app, name);
            has_collider(&app, node)
        });
        assert_eq!(colliders.collect::<Vec<_>>(), [&names[0]]);
        let finest = node(&mut app, names[0]);
        masses.push(mass(&app, finest).mass);
    }
    assert!(masses.iter().all(|mass| *mass == masses[0]), "{masses:?}");
}

#[test]
fn levels_that_the_file_links_make_no_collider() {
    // Exporters put linked nodes into the scene or not.
    let linked = json!({"name": "near", "mesh": 0, "extensions": {"MSFT_lod": {"ids": [1]}}});
    let file = file_of(vec![linked, json!({"name": "far", "mesh": 0})], vec![0, 1]);
    let mut file: serde_json::Value = serde_json::from_str(&file).unwrap();
    file["extensionsUsed"] = json!(["MSFT_lod"]);
    let root = ConvexDecompositionHierarchy::new(tag());
    let (mut app, _directory) = app_with_file(file.to_string(), root);
    let [near, far] = ["near", "far"].map(|name| node(&mut app, name));
    assert!(has_collider(&app, near) && !has_collider(&app, far));
}

#[test]
fn what_is_only_drawn_far_away_makes_no_collider() {
    let range = |start: f32| VisibilityRange::abrupt(start, start + 10.0);
    for is_hierarchy in [true, false] {
        let (mut app, cube) = with_mesh(app(), unit_cube());
        let far_mesh = add(&mut app, cuboid([5.0; 3], [6.0; 3]));
        let root = app.put((Transform::default(), RigidBody::Dynamic));
        match is_hierarchy {
            true => app.edit(root).insert(ConvexDecompositionHierarchy::new(tag())),
            false => app.edit(root).insert(tag()),
        };
        let place = Transform::from_xyz(1.0, 0.0, 0.0);
        let near = app.put((Mesh3d(cube), place, range(0.0), ChildOf(root)));
        let far = app.put((Mesh3d(far_mesh), place, range(10.0), ChildOf(root)));
        let tagged = if is_hierarchy { near } else { root };
        update_times(&mut app, 3);
        update_until_finished(&mut app, &[tagged]);
        let (low, high) = bounds(&app, tagged);
        assert_near(high - low, [1.0; 3], 1e-3);
        assert!(!has_collider(&app, far));
    }
}

#[test]
fn below_one_tag_the_finest_level_is_the_input() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let coarse = add(&mut app, cuboid([0.0; 3], [2.0; 3]));
    let root = app.put((Transform::default(), RigidBody::Dynamic, tag()));
    for (name, mesh) in [("rock_LOD0", cube), ("rock_LOD1", coarse)] {
        app.put((Name::new(name), Mesh3d(mesh), Transform::default(), ChildOf(root)));
    }
    update_until_finished(&mut app, &[root]);
    assert_is_unit_cube(&app, root);
}
