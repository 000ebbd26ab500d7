//! Hulls that `bake --into` has written into a glTF file: the colliders that the meshes would have
//! had, without any work, and what an artist edits wins.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use hullwright_formats::bake::{BakeOptions, bake_jobs};
use hullwright_formats::gltf_hulls::{HullForm, HullsInFile, MeshHulls};
use serde_json::{Value, json};

use crate::app::*;
use crate::artists::node;
use crate::engine::*;
use crate::gltf::app_with_gltf;

/// The document and the binary data of a GLB.
fn parts(glb: &[u8]) -> (Value, &[u8]) {
    let length = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    let end = 20 + length(12);
    (serde_json::from_slice(&glb[20..end]).unwrap(), &glb[end + 8..end + 8 + length(end)])
}

fn glb(document: &Value, data: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF".to_vec();
    let number = |glb: &mut Vec<u8>, number: usize| glb.extend((number as u32).to_le_bytes());
    number(&mut glb, 2);
    number(&mut glb, 12 + 8 + json.len() + 8 + data.len());
    number(&mut glb, json.len());
    glb.extend(b"JSON");
    glb.extend(json);
    number(&mut glb, data.len());
    glb.extend(b"BIN\0");
    glb.extend(data);
    glb
}

fn changed(file: &[u8], change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut document, data) = parts(file);
    change(&mut document);
    glb(&document, data)
}

/// A level of so many nodes, which show the bundled props, turned, scaled and mirrored.
fn level(count: usize) -> Vec<u8> {
    let props = std::fs::read(format!("{}/props.glb", assets())).unwrap();
    changed(&props, |document| {
        let meshes = document["meshes"].as_array().unwrap().len();
        let nodes: Vec<Value> = (0..count)
            .map(|at| {
                let scale = [[1.0, 1.0, 1.0], [0.7, 0.7, 0.7], [1.3, 0.9, 2.1], [-1.0, 1.1, 1.0]];
                json!({
                    "name": format!("prop {at}"), "mesh": at % meshes,
                    "translation": [at % 10 * 3, 0, at / 10 * 3],
                    "rotation": [0, 0.6, 0, 0.8],
                    "scale": scale[at / meshes % 4],
                })
            })
            .collect();
        document["scenes"] = json!([{"nodes": (0..count).collect::<Vec<_>>()}]);
        document["nodes"] = json!(nodes);
    })
}

fn baked(file: &[u8], form: HullForm) -> Vec<u8> {
    let meshes = hullwright_formats::read_scene_from_bytes(file).unwrap();
    let jobs = bake_jobs(meshes, &BakeOptions::default());
    let in_file = HullsInFile::from_bytes(file).unwrap();
    let hulls: Vec<MeshHulls> = jobs
        .iter()
        .map(|job| MeshHulls {
            nodes: &job.gltf_nodes,
            baked: job.run(&hullwright::Control::new()).unwrap(),
        })
        .collect();
    in_file.write(form, &hulls).unwrap()
}

/// An app that has loaded such a file, and what became of its meshes.
fn load(file: &[u8], root: impl Bundle) -> (App, HierarchyReport) {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("it.glb"), file).unwrap();
    let mut app = app_with_gltf(directory.path().display().to_string(), |_| {});
    let scene = app.load(GltfAssetLabel::Scene(0).from_asset("it.glb"));
    let root = app.put((WorldAssetRoot(scene), root));
    update_until(&mut app, |app| {
        app.get::<HierarchyStatus>(root).is_some_and(HierarchyStatus::is_finished)
    });
    let status = app.get::<HierarchyStatus>(root).copied();
    let Some(HierarchyStatus::Finished(report)) = status else { panic!("{status:?}") };
    (app, report)
}

fn hierarchy() -> ConvexDecompositionHierarchy {
    ConvexDecompositionHierarchy::new(tag())
}

/// All numbers of a node's collider and its mass, bit for bit.
fn bits(app: &mut App, name: &str) -> (Vec<u32>, Vec<[u32; 3]>) {
    let node = node(app, name);
    let shape = shape(collider(app, node));
    let parts = shape.as_compound().map_or_else(
        || vec![shape.clone()],
        |parts| parts.shapes().iter().map(|(_, part)| part.clone()).collect(),
    );
    let (mut numbers, mut triangles) = (Vec::new(), Vec::new());
    for part in parts {
        let (points, faces) = part.as_convex_polyhedron().unwrap().to_trimesh();
        numbers.extend(points.iter().flat_map(|point| point.to_array().map(f32::to_bits)));
        triangles.extend(faces);
    }
    let mass = mass(app, node);
    let mass_numbers = [mass.mass].into_iter().chain(mass.centre.to_array());
    numbers.extend(mass_numbers.chain(mass.moments.to_array()).map(f32::to_bits));
    (numbers, triangles)
}

#[test]
fn a_level_of_a_hundred_nodes_has_the_same_colliders_to_the_bit_and_nothing_is_decomposed() {
    let plain = level(100);
    let (mut before, report) = load(&plain, hierarchy());
    assert_eq!((report.ready, report.from_file), (100, 0));
    assert!(counters(&before).decomposed > 0);
    for form in [HullForm::Physics, HullForm::Ucx] {
        let (mut after, report) = load(&baked(&plain, form), hierarchy());
        assert_eq!((report.ready, report.from_file, report.edited), (100, 100, 0), "{form:?}");
        assert_eq!(counters(&after).decomposed, 0);
        for at in 0..100 {
            let name = format!("prop {at}");
            assert_eq!(bits(&mut before, &name), bits(&mut after, &name), "{form:?} {name}");
        }
    }
}

#[test]
fn what_never_moves_keeps_its_triangles_and_what_moves_has_the_hulls_of_the_file() {
    let file = baked(&level(1), HullForm::Ucx);
    let (mut app, report) = load(&file, ConvexDecompositionHierarchy::default());
    assert_eq!((report.skipped, report.from_file), (1, 0));
    let prop = node(&mut app, "prop 0");
    assert!(shape(collider(&app, prop)).as_trimesh().is_some());
    let root = (RigidBody::Dynamic, ConvexDecompositionHierarchy::default());
    let (mut app, report) = load(&file, root);
    assert_eq!((report.ready, report.from_file, counters(&app).decomposed), (1, 1, 0));
    update_times(&mut app, 20);
    let prop = node(&mut app, "prop 0");
    assert!(app.get::<GlobalTransform>(prop).unwrap().translation().y < -0.05);
}

#[test]
fn hulls_of_another_bound_or_another_mesh_are_stale_and_made_anew() {
    Log::install();
    let file = baked(&level(2), HullForm::Physics);
    let finer = ConvexDecompositionHierarchy::new(tag().with_max_error(0.01));
    let (app, report) = load(&file, finer);
    assert_eq!((report.ready, report.from_file, report.stale), (2, 0, 2));
    assert_eq!(counters(&app).decomposed, 2);
    assert!(!Log::lines_with("the glTF file of").is_empty());
    // The second prop shows the first one's mesh: the hulls below it are another's.
    let other = changed(&file, |document| {
        document["nodes"][1]["mesh"] = document["nodes"][0]["mesh"].clone();
    });
    let (app, report) = load(&other, hierarchy());
    assert_eq!((report.ready, report.from_file, report.stale), (2, 1, 1));
    assert_eq!(counters(&app).decomposed, 1);
}

#[test]
fn hulls_in_the_file_are_not_drawn() {
    let (mut app, _) = load(&baked(&level(1), HullForm::Ucx), hierarchy());
    let mut meshes =
        app.world_mut().query_filtered::<(Option<&Visibility>, &ChildOf), With<Mesh3d>>();
    let world = app.world();
    let (mut drawn, mut hidden) = (0, 0);
    for (visibility, parent) in meshes.iter(world) {
        let is_hull = world.get::<Name>(parent.0).unwrap().starts_with("UCX_");
        assert_eq!(is_hull, visibility == Some(&Visibility::Hidden));
        *(if is_hull { &mut hidden } else { &mut drawn }) += 1;
    }
    assert!(drawn > 0 && hidden > 0);
}

/// The first child of the group of a node's hulls, and the group.
fn first_hull(document: &Value, at: usize) -> (usize, usize) {
    let group = document["nodes"][at]["children"][0].as_u64().unwrap() as usize;
    (document["nodes"][group]["children"][0].as_u64().unwrap() as usize, group)
}

#[test]
fn an_edited_hull_wins_and_is_reported() {
    for form in [HullForm::Physics, HullForm::Ucx] {
        let file = baked(&level(2), form);
        let (mut before, _) = load(&file, hierarchy());
        let moved = changed(&file, |document| {
            let (hull, _) = first_hull(document, 0);
            document["nodes"][hull]["translation"] = json!([0, 5, 0]);
        });
        let (mut app, report) = load(&moved, hierarchy());
        assert_eq!((report.from_file, report.edited), (2, 1), "{form:?}");
        assert_eq!(counters(&app).decomposed, 0);
        let top = |app: &mut App, name: &str| {
            let node = node(app, name);
            bounds(app, node).1.y
        };
        let (above, as_before) = (top(&mut app, "prop 0"), top(&mut app, "prop 1"));
        assert!(above > top(&mut before, "prop 0") + 4.0);
        assert_eq!(as_before, top(&mut before, "prop 1"));
    }
}

#[test]
fn a_hull_that_is_deleted_is_gone_and_one_that_is_added_is_there() {
    let file = baked(&level(1), HullForm::Ucx);
    let count = |file: &[u8]| {
        let (mut app, report) = load(file, hierarchy());
        let node = node(&mut app, "prop 0");
        (hulls(&app, node).len(), report.edited)
    };
    let (all, _) = count(&file);
    let fewer = changed(&file, |document| {
        let (_, group) = first_hull(document, 0);
        document["nodes"][group]["children"].as_array_mut().unwrap().pop();
    });
    assert_eq!(count(&fewer), (all - 1, 1));
    let more = changed(&file, |document| {
        let (hull, group) = first_hull(document, 0);
        let nodes = document["nodes"].as_array_mut().unwrap();
        let mut copy = nodes[hull].clone();
        copy["translation"] = json!([0, 0, 9]);
        nodes.push(copy);
        let added = json!(nodes.len() - 1);
        document["nodes"][group]["children"].as_array_mut().unwrap().push(added);
    });
    assert_eq!(count(&more), (all + 1, 1));
}

#[test]
fn a_record_that_can_not_be_read_is_logged_and_the_hulls_are_colliders_all_the_same() {
    Log::install();
    let file = baked(&level(1), HullForm::Physics);
    let broken = changed(&file, |document| {
        let (_, group) = first_hull(document, 0);
        document["nodes"][group]["extras"]["hullwright"] = json!(4711);
    });
    let (mut app, report) = load(&broken, hierarchy());
    assert_eq!(report.from_file, 0);
    assert!(!Log::lines_with("4711").is_empty() || !Log::lines_with("can't be read").is_empty());
    let (document, _) = parts(&file);
    let (_, group) = first_hull(&document, 0);
    let expected = document["nodes"][group]["children"].as_array().unwrap().len();
    let mut colliders = app.world_mut().query::<&Collider>();
    assert_eq!(colliders.iter(app.world()).count(), expected);
}

#[test]
fn another_shape_on_request_and_a_tag_of_the_code_come_before_hulls_in_the_file() {
    let file = changed(&baked(&level(2), HullForm::Physics), |document| {
        document["nodes"][0]["extras"] = json!({"collider": "cuboid"});
    });
    let by_name = hierarchy().with("prop 1", tag().with_max_hulls(1));
    let (mut app, report) = load(&file, by_name);
    assert_eq!((report.from_file, report.stale), (0, 1));
    let [cuboid, hull] = ["prop 0", "prop 1"].map(|name| node(&mut app, name));
    for entity in [cuboid, hull] {
        let parts = shape(collider(&app, entity)).as_compound().map_or(1, |of| of.shapes().len());
        assert_eq!(parts, 1);
    }
    assert_eq!(counters(&app).decomposed, 1);
}

#[test]
fn the_mass_of_a_tag_is_that_of_hulls_in_the_file() {
    let file = changed(&baked(&level(1), HullForm::Physics), |document| {
        document["nodes"][0]["extras"] = json!({"collider": "hulls", "mass": 12});
    });
    let (mut app, report) = load(&file, hierarchy());
    assert_eq!(report.from_file, 1);
    let prop = node(&mut app, "prop 0");
    assert!((mass(&app, prop).mass - 12.0).abs() < 1e-3);
}
