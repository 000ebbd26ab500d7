//! `hullwright bake`, and `.hulls` files in other commands.

use std::path::Path;

use hullwright::hulls_format::{HullScene, HullsFile};
use hullwright_formats::read_own_meshes;
use serde_json::json;

use crate::{Place, asset};

const TETRAHEDRON: &str =
    "v 0 0 0\nv 6 0 0\nv 0 6 0\nv 0 0 6\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// Two nodes that place and stretch one mesh, whose two primitives are a tetrahedron's halves, and
/// another mesh without a name that no node shows.
const GLTF: &str = r#"{
    "asset": { "version": "2.0" },
    "scene": 0,
    "scenes": [{ "nodes": [0, 1] }],
    "nodes": [
        { "name": "left", "mesh": 0, "translation": [-50, 0, 0], "scale": [2, 3, 4] },
        { "name": "right", "mesh": 0, "translation": [50, 0, 0] }
    ],
    "meshes": [
        { "name": "Cube/1", "primitives": [
            { "attributes": { "POSITION": 0 }, "indices": 1 },
            { "attributes": { "POSITION": 0 }, "indices": 2 }
        ] },
        { "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 3 }] }
    ],
    "accessors": [
        { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
          "min": [0, 0, 0], "max": [6, 6, 6] },
        { "bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR" },
        { "bufferView": 1, "byteOffset": 6, "componentType": 5121, "count": 6, "type": "SCALAR" },
        { "bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR" }
    ],
    "bufferViews": [
        { "buffer": 0, "byteLength": 48 },
        { "buffer": 0, "byteOffset": 48, "byteLength": 12 }
    ],
    "buffers": [{ "uri": "two.bin", "byteLength": 60 }]
}"#;

fn place() -> Place {
    let place = Place::new(&[("tetrahedron.obj", TETRAHEDRON), ("two.gltf", GLTF)]);
    let corners = [[0.0_f32; 3], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0]];
    let mut buffer: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    buffer.extend([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]);
    place.write("two.bin", buffer);
    place
}

fn names(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn each_gltf_mesh_gets_a_file_in_its_own_space() {
    let place = place();
    let shown = place.succeed(&["bake", "--per-mesh", "two.gltf", "-o", "new/baked"]);
    assert_eq!(shown.lines().count(), 2);
    assert!(shown.contains("1 hull, 4 vertices"), "{shown}");
    assert_eq!(names(&place.path("new/baked")), ["Cube_1.hulls", "mesh_1.hulls"]);

    let file = HullsFile::read(place.path("new/baked/Cube_1.hulls")).unwrap();
    assert_eq!(file.name, "Cube/1");
    assert!(file.is_current());
    // Both primitives, neither moved nor stretched.
    assert_eq!((file.hulls.len(), file.source_triangles), (1, 4));
    let hull = &file.hulls[0];
    assert!((hull.shape.volume() - 36.0).abs() < 1e-6);
    assert!((hull.shape.bounds().unwrap().max[0] - 6.0).abs() < 1e-6);
    assert!((file.mass_properties.unwrap().mass - 36.0).abs() < 1e-6);
}

#[test]
fn other_formats_are_one_mesh_and_names_stay_unique() {
    let place = place();
    std::fs::create_dir(place.path("more")).unwrap();
    std::fs::copy(place.path("tetrahedron.obj"), place.path("more/Tetrahedron.obj")).unwrap();
    let meshes = ["tetrahedron.obj", "more/Tetrahedron.obj"];
    place
        .succeed(&[&["bake", "--per-mesh", "-o", "baked", "--density", "2"], &meshes[..]].concat());
    assert_eq!(names(&place.path("baked")), ["Tetrahedron_2.hulls", "tetrahedron.hulls"]);
    let file = HullsFile::read(place.path("baked/tetrahedron.hulls")).unwrap();
    assert!((file.mass_properties.unwrap().mass - 72.0).abs() < 1e-6);

    // Again: the same files, not more.
    place.succeed(&[&["bake", "--per-mesh", "-o", "baked"], &meshes[..]].concat());
    assert_eq!(names(&place.path("baked")).len(), 2);
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let place = place();
    let mug = asset("mug.glb");
    place.succeed(&["bake", "--per-mesh", &mug, "-o", "one", "--threads", "1"]);
    place.succeed(&["bake", "--per-mesh", &mug, "-o", "two", "--threads", "2"]);
    let names = names(&place.path("one"));
    assert_eq!(names.len(), read_own_meshes(&mug).unwrap().len());
    for name in names {
        let read = |directory: &str| std::fs::read(place.path(directory).join(&name)).unwrap();
        assert_eq!(read("one"), read("two"));
    }
}

#[test]
fn what_can_not_be_baked_is_named_and_the_rest_is_baked() {
    let place = place();
    place.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let error =
        place.fail(&["bake", "--per-mesh", "flat.obj", "tetrahedron.obj", "-o", "baked"], 1);
    assert!(error.contains("flat.obj") && error.contains("no usable triangle"), "{error}");
    assert_eq!(error.lines().count(), 1);
    assert_eq!(names(&place.path("baked")), ["tetrahedron.hulls"]);

    // All that go wrong are named, in the order of the work.
    place.write("cut.stl", "solid x\nfacet normal 0 0 1\n");
    for more in [&["--per-mesh"][..], &[]] {
        let files = ["bake", "missing.obj", "cut.stl", "tetrahedron.obj", "-o", "rest"];
        let output = place.run(&[&files, more].concat());
        assert_eq!(output.status.code(), Some(1));
        let error = String::from_utf8(output.stderr).unwrap();
        let lines: Vec<&str> = error.lines().collect();
        assert!(lines.len() == 2, "{error}");
        assert!(lines[0].contains("missing.obj") && lines[1].contains("cut.stl"), "{error}");
    }
    assert_eq!(names(&place.path("rest")), ["tetrahedron.hulls", "tetrahedron.hullscene"]);

    let error = place.fail(&["bake", "missing.obj", "-o", "nothing"], 1);
    assert!(error.contains("missing.obj"), "{error}");
    assert!(!place.path("nothing").exists());
    place.fail(&["bake", "-o", "baked"], 2);
    place.fail(&["bake", "tetrahedron.obj", "--density", "2"], 2);
    let density = ["bake", "--per-mesh", "tetrahedron.obj", "-o", "baked", "--density", "-1"];
    let error = place.fail(&density, 2);
    assert!(error.contains("density"), "{error}");
}

#[test]
fn a_scene_is_one_file_beside_it_and_is_kept_where_nothing_changed() {
    let place = place();
    let shown = place.succeed(&["bake", "two.gltf"]);
    // Both meshes of the file have the same triangles.
    assert_eq!(shown, "wrote two.hullscene: 1 mesh, 1 hull, 4 vertices\n");
    let scene = HullScene::read(place.path("two.hullscene")).unwrap();
    assert_eq!(scene.name, "two");
    assert_eq!(scene.meshes[0].names, ["Cube/1", "left", "right", "mesh_1"]);
    // A density is the tags' matter.
    assert!((scene.meshes[0].hulls.mass_properties.unwrap().mass - 36.0).abs() < 1e-6);

    let before = std::fs::read(place.path("two.hullscene")).unwrap();
    let shown = place.succeed(&["bake", "two.gltf"]);
    assert!(shown.contains("1 mesh (1 as before)"), "{shown}");
    assert_eq!(std::fs::read(place.path("two.hullscene")).unwrap(), before);
    let shown = place.succeed(&["bake", "two.gltf", "--max-error", "1%"]);
    assert!(!shown.contains("as before"), "{shown}");
}

#[test]
fn triangles_are_baked_on_request_and_not_of_what_moves_or_has_another_collider() {
    let place = place();
    let shown = place.succeed(&["bake", "two.gltf", "--triangles"]);
    assert_eq!(shown, "wrote two.hullscene: 1 mesh, 1 hull, 4 vertices, 4 triangles\n");
    let scene = HullScene::read(place.path("two.hullscene")).unwrap();
    assert_eq!((scene.meshes[0].gltf_meshes.as_slice(), scene.triangles.len()), (&[0, 1][..], 1));
    let baked = &scene.triangles[0];
    assert_eq!(baked.gltf_meshes, [0, 1]);
    assert_eq!((baked.positions.len(), baked.triangles.len()), (4, 4));
    assert!(
        place.succeed(&["inspect", "two.hullscene"]).contains("triangles for what never moves")
    );

    let text = std::fs::read_to_string(place.path("two.gltf")).unwrap();
    for (name, expected) in [("left-rigid", 1), ("left-convcol", 1), ("left-col", 2)] {
        // No node shows the other mesh.
        let named = ["\"left\"", "\"right\""]
            .iter()
            .fold(text.clone(), |text, node| text.replace(node, &format!("\"{name}\"")));
        std::fs::write(place.path("named.gltf"), named).unwrap();
        place.succeed(&["bake", "named.gltf", "--triangles"]);
        let scene = HullScene::read(place.path("named.hullscene")).unwrap();
        let meshes: usize = scene.triangles.iter().map(|baked| baked.gltf_meshes.len()).sum();
        assert_eq!(meshes, expected, "{name}");
    }
    place.fail(&["bake", "--per-mesh", "two.gltf", "--triangles"], 2);
}

#[test]
fn a_scene_is_baked_as_its_artist_says() {
    let place = place();
    let props = asset("props.glb");
    place.succeed(&["bake", &props, "-o", "all"]);
    place.succeed(&["bake", &props, "-o", "tagged", "--tagged-only"]);
    let read = |directory: &str| {
        let scene = HullScene::read(place.path(directory).join("props.hullscene")).unwrap();
        let nodes = scene.meshes.into_iter().flat_map(|baked| {
            let method = baked.parameters.name();
            baked.names.into_iter().map(move |name| (name, method))
        });
        nodes.collect::<std::collections::BTreeMap<_, _>>()
    };
    let (all, tagged) = (read("all"), read("tagged"));
    assert!(all.contains_key("leaf") && !tagged.contains_key("leaf"));
    let expected = [("mug-convdecomp", "bounded"), ("lamp", "bounded"), ("UCX_table_01", "hull")];
    for (name, method) in expected {
        assert_eq!((all.get(name), tagged.get(name)), (Some(&method), Some(&method)), "{name}");
    }
    // Its pieces stand for it.
    assert!(!all.contains_key("table"));
}

#[test]
fn a_wrong_extra_is_named_and_the_rest_holds() {
    let place = place();
    let extras = r#""name": "left", "extras": { "collider": "hulls", "max_eror": 0.01 },"#;
    place.write("two.gltf", GLTF.replace(r#""name": "left","#, extras));
    let output = place.run(&["bake", "two.gltf"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{error}");
    let expected = r#"warning: two.gltf, extras of `left`: "max_eror" is no setting of a collider"#;
    assert!(error.starts_with(expected) && error.lines().count() == 1, "{error}");
    assert!(place.path("two.hullscene").exists());
}

#[test]
fn a_folder_of_scenes_keeps_its_structure() {
    let place = place();
    std::fs::create_dir_all(place.path("levels/one")).unwrap();
    for name in ["two.gltf", "two.bin", "tetrahedron.obj"] {
        std::fs::copy(place.path(name), place.path("levels/one").join(name)).unwrap();
        std::fs::copy(place.path(name), place.path("levels").join(name)).unwrap();
    }
    let shown = place.succeed(&["bake", "levels", "-o", "baked"]);
    assert_eq!(shown.lines().count(), 2);
    assert_eq!(names(&place.path("baked")), ["one", "two.hullscene"]);
    assert_eq!(names(&place.path("baked/one")), ["two.hullscene"]);

    place.succeed(&["bake", "levels"]);
    assert!(place.path("levels/one/two.hullscene").exists());
    std::fs::create_dir(place.path("empty")).unwrap();
    let error = place.fail(&["bake", "empty"], 1);
    assert!(error.contains("no glTF or GLB file"), "{error}");
    let error = place.fail(&["bake", "two.gltf", "levels/two.gltf", "-o", "baked"], 2);
    assert!(error.contains("two scenes"), "{error}");
}

#[test]
fn what_of_a_scene_can_not_be_baked_is_named_and_the_rest_is_baked() {
    let place = place();
    place.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let error = place.fail(&["bake", "flat.obj", "tetrahedron.obj"], 1);
    assert!(error.contains("flat.obj, mesh `flat`"), "{error}");
    assert!(place.path("tetrahedron.hullscene").exists());
}

/// A tetrahedron of wood with a floor of rubber, and one of wood beside it.
const MATERIALS: &str = "o table\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl rubber\nf 1 3 2\n\
                         usemtl wood\nf 1 2 4\nf 2 3 4\nf 3 1 4\n\
                         o chair\nv 3 0 0\nv 4 0 0\nv 3 1 0\nv 3 0 1\n\
                         f 5 7 6\nf 5 6 8\nf 6 7 8\nf 7 5 8\n";

#[test]
fn what_hulls_are_made_of_is_stored_and_shown() {
    let place = Place::new(&[("set.obj", MATERIALS)]);
    let line = place.json(&["decompose", "set.obj", "-o", "set.hulls"]);
    assert_eq!(line["parts"][1], json!({ "mesh": "table", "primitive": 1, "material": "wood" }));
    let file = HullsFile::read(place.path("set.hulls")).unwrap();
    assert_eq!((file.hulls.len(), file.parts.len()), (2, 3));
    for hull in 0..2 {
        let most = &line["part_shares"][hull][0];
        let share = file.shares(hull)[0];
        assert_eq!(
            (&most["part"], most["share"].as_f64().unwrap() as f32),
            (&share.part.into(), share.share as f32)
        );
        assert_eq!(file.part(hull).unwrap().material, "wood");
    }
    let shown = place.succeed(&["inspect", "set.hulls"]);
    let words = |line: &str| line.split_whitespace().map(String::from).collect::<Vec<_>>();
    let lines: Vec<Vec<String>> = shown.lines().map(words).collect();
    assert!(
        lines.contains(&words("0 table 0 rubber")) && lines.contains(&words("1 chair 0 wood")),
        "{shown}"
    );

    place.succeed(&["bake", "--per-mesh", "set.obj", "-o", "baked"]);
    assert_eq!(HullsFile::read(place.path("baked/set.hulls")).unwrap().parts, file.parts);
}

#[test]
fn a_scene_is_baked_anew_where_a_material_has_another_name() {
    let place = Place::new(&[("set.obj", MATERIALS)]);
    place.succeed(&["bake", "set.obj"]);
    assert!(place.succeed(&["bake", "set.obj"]).contains("1 as before"));
    place.write("set.obj", MATERIALS.replace("wood", "oak"));
    assert!(!place.succeed(&["bake", "set.obj"]).contains("as before"));
    let scene = HullScene::read(place.path("set.hullscene")).unwrap();
    assert_eq!(scene.meshes[0].hulls.part(0).unwrap().material, "oak");
}

#[test]
fn decompose_writes_a_hulls_file_which_measure_and_inspect_read() {
    let place = place();
    let shown = place.succeed(&["decompose", "tetrahedron.obj", "-o", "t.hulls"]);
    assert!(shown.contains("wrote t.hulls: 1 hull, 4 vertices"), "{shown}");
    assert_eq!(HullsFile::read(place.path("t.hulls")).unwrap().name, "tetrahedron");

    assert_eq!(place.json(&["measure", "tetrahedron.obj", "t.hulls"])["hulls"], 1);

    let shown = place.succeed(&["inspect", "t.hulls"]);
    for part in ["tetrahedron", "hulls", "mass", "36"] {
        assert!(shown.contains(part), "{part} in {shown}");
    }

    let mut bytes = std::fs::read(place.path("t.hulls")).unwrap();
    bytes.truncate(100);
    place.write("t.hulls", bytes);
    for command in [&["inspect", "t.hulls"][..], &["measure", "tetrahedron.obj", "t.hulls"]] {
        let error = place.fail(command, 1);
        assert!(error.contains("t.hulls") && error.contains("100 bytes"), "{error}");
    }
}

/// The JSON of a GLB.
fn document(path: &Path) -> serde_json::Value {
    let bytes = std::fs::read(path).unwrap();
    let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..end]).unwrap()
}

#[test]
fn hulls_go_into_the_file_itself_and_again_without_a_change() {
    let place = Place::new(&[]);
    std::fs::copy(asset("props.glb"), place.path("level.glb")).unwrap();
    let shown = place.succeed(&["bake", "--into", "level.glb"]);
    assert_eq!(shown, "wrote level.glb: 4 meshes, 49 hulls, 985 vertices\n");
    assert_eq!(names(&place.path("")), ["level.glb"]);
    let first = std::fs::read(place.path("level.glb")).unwrap();
    let shown = place.succeed(&["bake", "--into=physics", "level.glb", "--threads", "1"]);
    assert_eq!(shown, "wrote level.glb: 4 meshes (4 as before), 49 hulls, 985 vertices\n");
    assert_eq!(std::fs::read(place.path("level.glb")).unwrap(), first);

    // The file has all hulls, so that no second one needs them.
    let shown = place.succeed(&["bake", "level.glb"]);
    assert!(shown.contains("0 meshes"), "{shown}");
    let triangles =
        |path: &str| place.json(&["decompose", path, "--max-hulls", "1"])["triangles"].clone();
    assert_eq!(triangles("level.glb"), triangles(&asset("props.glb")));

    let shown = place.succeed(&["bake", "--into=ucx", "level.glb", "-o", "unreal"]);
    assert!(shown.starts_with("wrote unreal/level.glb: 4 meshes (4 as before)"), "{shown}");
    let nodes = document(&place.path("unreal/level.glb"))["nodes"].to_string();
    assert!(nodes.contains("UCX_lamp_00") && !nodes.contains("KHR_physics"), "{nodes}");
    assert_eq!(std::fs::read(place.path("level.glb")).unwrap(), first);
}

#[test]
fn hulls_go_into_text_too_and_other_files_are_named_where_the_copy_lacks_them() {
    let place = place();
    let shown = place.succeed(&["bake", "--into", "two.gltf", "--tagged-only"]);
    assert_eq!(shown, "wrote two.gltf: 0 meshes, 0 hulls, 0 vertices\n");
    assert_eq!(std::fs::read_to_string(place.path("two.gltf")).unwrap(), GLTF);
    let output = place.run(&["bake", "--into", "two.gltf", "-o", "copy"]);
    let error = String::from_utf8(output.stderr).unwrap();
    let expected = "warning: two.gltf: it names other files, such as two.bin, which are not copied";
    assert_eq!((output.status.code(), error.trim_end()), (Some(0), expected));
    assert_eq!(
        place.succeed(&["bake", "--into", "two.gltf"]),
        "wrote two.gltf: 1 mesh, 1 hull, 4 vertices\n"
    );
    let both = ["two.gltf", "copy/two.gltf"];
    let [beside, copy] = both.map(|path| std::fs::read_to_string(place.path(path)).unwrap());
    assert_eq!(beside, copy);
    assert!(beside.contains("\"left_hulls\"") && beside.contains("\"right_hull_00\""), "{beside}");
    assert!(!beside.contains("mesh_1_hull"), "no node shows it");
}

#[test]
fn hulls_that_an_artist_edited_stay_and_are_named() {
    let place = place();
    place.succeed(&["bake", "--into=ucx", "two.gltf"]);
    // A hull is moved within its group.
    let text = std::fs::read_to_string(place.path("two.gltf")).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let nodes = document["nodes"].as_array_mut().unwrap();
    let hull = nodes.iter_mut().find(|node| node["name"] == "UCX_left_00").unwrap();
    hull["translation"] = json!([0, 0, 1]);
    place.write("two.gltf", document.to_string());
    let output = place.run(&["bake", "--into=ucx", "two.gltf", "--max-error", "1%"]);
    let [shown, error] =
        [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert_eq!(error, "warning: two.gltf, node `left`: its hulls were edited by hand: kept\n");
    assert!(shown.contains("1 mesh (1 edited by hand), 2 hulls"), "{shown}");
    let text = std::fs::read_to_string(place.path("two.gltf")).unwrap();
    assert!(text.contains("\"translation\":[0,0,1]"));
}

#[test]
fn a_node_with_a_collider_of_its_own_is_named_and_the_others_get_hulls() {
    let place = place();
    let collider =
        r#""name": "left", "extensions": { "OMI_physics_body": { "trigger": { "shape": 0 } } },"#;
    place.write("two.gltf", GLTF.replace(r#""name": "left","#, collider));
    let output = place.run(&["bake", "--into", "two.gltf"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && error.contains("node `left`: it has a collider"), "{error}");
    let text = std::fs::read_to_string(place.path("two.gltf")).unwrap();
    assert!(!text.contains("left_hulls") && text.contains("right_hulls"), "{text}");
}

#[test]
fn files_that_take_no_hulls_are_named_and_the_others_get_theirs() {
    let place = place();
    std::fs::create_dir(place.path("levels")).unwrap();
    for name in ["two.gltf", "two.bin"] {
        std::fs::copy(place.path(name), place.path("levels").join(name)).unwrap();
    }
    place.write("cut.glb", b"glTF\x02");
    let output = place.run(&["bake", "--into", "tetrahedron.obj", "cut.glb", "levels"]);
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("tetrahedron.obj: hulls can be written into glTF"), "{error}");
    assert!(error.contains("cut.glb") && error.lines().count() == 2, "{error}");
    let text = std::fs::read_to_string(place.path("levels/two.gltf")).unwrap();
    assert!(text.contains("left_hulls"));
    for wrong in [
        &["--per-mesh"][..],
        &["--triangles"],
        &["--into=obj"],
        &["levels/two.gltf", "two.gltf", "-o", "out"],
    ] {
        place.fail(&[&["bake", "--into", "two.gltf"], wrong].concat(), 2);
    }
}
