//! What the glTF reader promises, on documents made by hand.

use hullwright::Error;
use hullwright_formats::{
    Format, MeshFile, Note, NoteKind, read_hulls, read_mesh, read_mesh_from_bytes,
    read_scene_from_bytes,
};
use serde_json::{Value, json};

use crate::glb::glb;

/// Three vertices of a triangle whose normal is +z, then a fourth, then the indices 0 1 2 3 as
/// bytes, 16-bit and 32-bit integers.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    let vertices = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    bytes.extend(vertices.iter().flatten().flat_map(|number| number.to_le_bytes()));
    bytes.extend([0_u8, 1, 2, 3]);
    bytes.extend((0..4_u16).flat_map(u16::to_le_bytes));
    bytes.extend((0..4_u32).flat_map(u32::to_le_bytes));
    bytes
}

/// A document with one mesh on one node. Accessor 0 has the positions, 1 to 3 have indices.
fn document() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "thing" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR" },
            { "bufferView": 1, "byteOffset": 4, "componentType": 5123, "count": 3, "type": "SCALAR" },
            { "bufferView": 1, "byteOffset": 12, "componentType": 5125, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 28 },
        ],
        "buffers": [{ "byteLength": 76 }],
    })
}

fn read(document: &Value) -> Result<MeshFile, Error> {
    read_mesh_from_bytes(Format::Gltf, &glb(document, &buffer()))
}

fn reason(document: &Value) -> String {
    read(document).unwrap_err().to_string()
}

fn kinds(notes: &[Note]) -> Vec<(NoteKind, usize)> {
    notes.iter().map(|note| (note.kind, note.count)).collect()
}

/// Twice the vector area of all triangles.
fn area_normal(file: &MeshFile) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for triangle in &file.mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| file.mesh.positions[vertex as usize]);
        let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        sum[0] += u[1] * v[2] - u[2] * v[1];
        sum[1] += u[2] * v[0] - u[0] * v[2];
        sum[2] += u[0] * v[1] - u[1] * v[0];
    }
    sum
}

#[test]
fn indices_of_every_size_or_none_are_read() {
    for accessor in 1..4 {
        let mut document = document();
        document["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
        assert_eq!(read(&document).unwrap().mesh.triangles, [[0, 1, 2]]);
    }
    let mut document = document();
    document["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 } });
    document["accessors"][0]["count"] = json!(3);
    assert_eq!(read(&document).unwrap().mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn strips_and_fans_become_triangles_of_one_winding() {
    let mut document = document();
    document["accessors"][1]["count"] = json!(4);
    document["meshes"][0]["primitives"][0]["mode"] = json!(5);
    let strip = read(&document).unwrap();
    assert_eq!(strip.mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(area_normal(&strip), [0.0, 0.0, 2.0]);
    document["meshes"][0]["primitives"][0]["mode"] = json!(6);
    assert_eq!(read(&document).unwrap().mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    for lines in 0..4 {
        document["meshes"][0]["primitives"][0]["mode"] = json!(lines);
        assert!(read(&document).unwrap().mesh.triangles.is_empty());
    }
    document["meshes"][0]["primitives"][0]["mode"] = json!(7);
    assert!(reason(&document).contains("its `mode` is 7, and 0 to 6 would be read"));
}

#[test]
fn a_mirrored_node_keeps_outside_outside() {
    let plain = area_normal(&read(&document()).unwrap());
    let mut document = document();
    document["nodes"][0]["scale"] = json!([1.0, 1.0, -1.0]);
    let mirrored = area_normal(&read(&document).unwrap());
    assert_eq!(mirrored, [plain[0], plain[1], -plain[2]]);
    document["nodes"][0]["scale"] = json!([-1.0, 1.0, -1.0]);
    let twice_mirrored = read(&document).unwrap();
    assert_eq!(area_normal(&twice_mirrored), [plain[0], plain[1], -plain[2]]);
    assert_eq!(twice_mirrored.mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn transforms_of_nested_nodes_are_applied_from_the_inside_out() {
    let mut document = document();
    document["nodes"] = json!([
        { "translation": [10.0, 0.0, 0.0], "children": [1] },
        { "rotation": [0.0, 0.0, 1.0, 0.0], "scale": [2.0, 1.0, 1.0], "children": [2] },
        { "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1] },
    ]);
    let file = read(&document).unwrap();
    assert_eq!(file.mesh.positions[0], [0.0, -6.0, 7.0]);
    assert_eq!(file.mesh.positions[1], [-2.0, -6.0, 7.0]);
}

#[test]
fn the_default_scene_counts_or_else_all_scenes_or_else_all_nodes() {
    let mut document = document();
    document["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0 }, { "children": [3] }, { "mesh": 0 }]);
    document["scenes"] = json!([{ "nodes": [0] }, { "nodes": [0, 1] }]);
    document["scene"] = json!(1);
    assert_eq!(read(&document).unwrap().objects.len(), 2);
    document["scene"] = json!(0);
    assert_eq!(read(&document).unwrap().objects.len(), 1);
    for missing in [json!(2), json!(-1), json!("first")] {
        document["scene"] = missing;
        let file = read(&document).unwrap();
        assert_eq!(file.objects.len(), 2);
        assert_eq!(kinds(&file.notes), [(NoteKind::MissingScenes, 1)]);
    }
    document.as_object_mut().unwrap().remove("scene");
    assert_eq!(read(&document).unwrap().objects.len(), 2);
    document.as_object_mut().unwrap().remove("scenes");
    assert_eq!(read(&document).unwrap().objects.len(), 3);
    document.as_object_mut().unwrap().remove("nodes");
    assert_eq!(read(&document).unwrap().objects.len(), 1);
}

#[test]
fn nodes_that_are_no_trees_are_an_error_not_an_endless_walk() {
    let mut document = document();
    document["nodes"] = json!([{ "children": [1] }, { "children": [0] }]);
    assert!(reason(&document).contains("node 0 has two parents or is inside of itself"));
    document["nodes"] = json!([{ "children": [1, 1] }, { "mesh": 0 }]);
    assert!(reason(&document).contains("node 1"));
    document["nodes"] = json!([{ "children": [7] }]);
    assert!(reason(&document).contains("there is no node 7"));
    let deep: Vec<Value> = (1..100_000).map(|child| json!({ "children": [child] })).collect();
    document["nodes"] = Value::Array(deep);
    document["nodes"].as_array_mut().unwrap().push(json!({ "mesh": 0 }));
    assert_eq!(read(&document).unwrap().mesh.triangles.len(), 1);
}

#[test]
fn primitives_that_share_vertices_stay_joined_and_are_one_object() {
    let mut document = document();
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 2 });
    document["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    let file = read(&document).unwrap();
    assert_eq!(file.mesh.positions.len(), 4);
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 1, 2]]);
    assert_eq!(file.objects.len(), 1);
    assert_eq!(file.objects[0].name, "thing");
}

#[test]
fn quantised_positions_are_read() {
    let mut document = document();
    document["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    document["accessors"][0] = json!({ "bufferView": 0, "componentType": 5121, "count": 4, "type": "VEC3", "normalized": true });
    document["bufferViews"][0] = json!({ "buffer": 0, "byteLength": 16, "byteStride": 4 });
    let bytes: Vec<u8> = vec![0, 0, 0, 0, 255, 0, 0, 0, 0, 51, 0, 0, 0, 0, 0, 0];
    let chunk = [bytes, buffer()[16..].to_vec()].concat();
    let file = read_mesh_from_bytes(Format::Gltf, &glb(&document, &chunk)).unwrap();
    assert_eq!(file.mesh.positions[..3], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.2, 0.0]]);
}

#[test]
fn sparse_accessors_change_single_elements() {
    let mut document = document();
    document["accessors"][0]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": 1, "byteOffset": 2, "componentType": 5121 },
        "values": { "bufferView": 0, "byteOffset": 12 },
    });
    assert_eq!(read(&document).unwrap().mesh.positions[2], [1.0, 0.0, 0.0]);
    document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let over_zeros = read(&document).unwrap();
    assert_eq!(over_zeros.mesh.positions, [[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]]);
    document["accessors"][0]["count"] = json!(2);
    assert!(reason(&document).contains("changes number 2"));
}

#[test]
fn accessors_beyond_their_buffer_are_errors_that_name_them() {
    let change = |path: &str, value: Value| {
        let mut document = document();
        *document.pointer_mut(path).expect(path) = value;
        reason(&document)
    };
    let count = |count: u64| change("/accessors/0/count", json!(count));
    for count in [count(5), count(4_000_000_000), count(u64::MAX)] {
        assert!(count.contains("mesh 0, primitive 0: accessor 0: its"), "{count}");
    }
    assert!(change("/bufferViews/0/byteLength", json!(1000)).contains("buffer view 0"));
    assert!(change("/bufferViews/0/byteOffset", json!(u64::MAX)).contains("buffer view 0"));
    assert!(change("/bufferViews/0/buffer", json!(3)).contains("no buffer 3"));
    assert!(change("/buffers/0/byteLength", json!(1000)).contains("buffer 0: it should have 1000"));
    assert!(change("/accessors/0/bufferView", json!(9)).contains("buffer view 9"));
    assert!(
        change("/accessors/0/type", json!("VEC2")).contains("is `VEC2`, and VEC3 would be read")
    );
    assert!(
        change("/accessors/0/type", json!("VEC9")).contains("is `VEC9`, and VEC3 would be read")
    );
    assert!(change("/accessors/0/componentType", json!(1)).contains("`componentType` is 1, and"));
    assert!(change("/accessors/0/componentType", json!(5125)).contains("are 32-bit integers"));
    assert!(
        change("/accessors/1/componentType", json!(5126))
            .contains("unsigned integers would be read")
    );
    assert!(change("/accessors/0/count", json!(2)).contains("index 2 is beyond its 2 vertices"));
    assert!(change("/nodes/0/mesh", json!(9)).contains("there is no mesh 9"));
    assert!(change("/meshes/0/primitives/0/attributes/POSITION", json!(9)).contains("accessor 9"));

    let mut document = document();
    document["bufferViews"][0]["byteStride"] = json!(8);
    assert!(reason(&document).contains("stride of 8 bytes is too short"));
    document["accessors"][0] =
        json!({ "componentType": 5126, "count": 4_000_000_000_u64, "type": "VEC3" });
    assert!(reason(&document).contains("announces 4000000000 elements"));
}

#[test]
fn placing_a_mesh_without_end_is_an_error() {
    let mut document = document();
    let vertices = 9_000;
    document["accessors"][0] = json!({
        "bufferView": 0, "componentType": 5121, "count": vertices, "type": "VEC3",
    });
    document["bufferViews"][0] = json!({ "buffer": 0, "byteLength": vertices * 3 });
    document["buffers"][0] = json!({ "byteLength": vertices * 3 });
    document["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 } });
    document["nodes"] = Value::Array(vec![json!({ "mesh": 0 }); 10_000]);
    document["scenes"][0]["nodes"] = (0..10_000).collect();
    let chunk = vec![0; vertices * 3];
    let error = read_mesh_from_bytes(Format::Gltf, &glb(&document, &chunk)).unwrap_err();
    assert!(error.to_string().contains("the scene has over"), "{error}");
}

#[test]
fn extensions_that_hide_geometry_are_refused_and_others_ignored() {
    let mut document = document();
    document["extensionsRequired"] = json!(["KHR_materials_unlit", "KHR_texture_transform"]);
    assert!(read(&document).is_ok());
    for harmless in [
        "KHR_implicit_shapes",
        "KHR_physics_rigid_bodies",
        "OMI_physics_body",
        "KHR_animation_pointer",
        "KHR_interactivity",
        "KHR_node_visibility",
        "VRMC_vrm",
        "EXT_mesh_features",
        "MSFT_lod",
        "KHR_lights_punctual",
    ] {
        document["extensionsRequired"] = json!([harmless]);
        let file = read(&document).expect(harmless);
        assert_eq!((file.mesh.triangles.len(), file.notes.len()), (1, 0), "{harmless}");
    }
    for hidden in ["EXT_mesh_primitive_restart", "KHR_mesh_quantization_2", "CESIUM_RTC", "MSFT_"] {
        document["extensionsRequired"] = json!([hidden]);
        assert!(reason(&document).contains(&format!("requires the extension `{hidden}`")));
    }
}

#[test]
fn extra_data_of_any_kind_is_skipped() {
    for extras in [json!({ "a": [1] }), json!([1, "b"]), json!("text"), json!(5), json!(null)] {
        let mut document = document();
        document["extras"] = extras.clone();
        document["nodes"][0]["extras"] = extras.clone();
        document["meshes"][0]["primitives"][0]["extras"] = extras;
        assert_eq!(read(&document).unwrap().mesh.triangles.len(), 1);
    }
}

#[test]
fn glb_headers_that_lie_are_errors() {
    let whole = glb(&document(), &buffer());
    let broken = |at: usize, value: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        read_mesh_from_bytes(Format::Gltf, &bytes).unwrap_err().to_string()
    };
    for length in [0, 11, u32::MAX, whole.len() as u32 + 1] {
        assert!(broken(8, length).contains(&format!("announces {length} bytes")));
    }
    assert!(broken(4, 1).contains("it is glTF 1.0, and glTF 2.0 would be read"));
    assert!(broken(4, 3).contains("its version is 3"));
    assert!(broken(16, 0).contains("JSON would be read"));
    assert!(broken(12, u32::MAX).contains("GLB"));
    for length in 0..whole.len() {
        assert!(read_mesh_from_bytes(Format::Gltf, &whole[..length]).is_err());
    }
    let mut longer = whole.clone();
    longer.extend(b"something after the end");
    assert!(read_mesh_from_bytes(Format::Gltf, &longer).is_ok());
}

#[test]
fn buffers_in_data_uris_and_files_beside_are_read() {
    let directory = tempfile::tempdir().unwrap();
    let write = |document: &Value| {
        let path = directory.path().join("mesh.gltf");
        std::fs::write(&path, document.to_string()).unwrap();
        read_mesh(path)
    };
    let mut document = document();
    std::fs::write(directory.path().join("with space.bin"), buffer()).unwrap();
    document["buffers"][0]["uri"] = json!("with%20space.bin");
    assert_eq!(write(&document).unwrap().mesh.triangles, [[0, 1, 2]]);
    assert!(reason(&document).contains("it is in another file, `with space.bin`"));

    let hex: String = buffer().iter().map(|byte| format!("%{byte:02x}")).collect();
    document["buffers"][0]["uri"] = json!(format!("data:application/octet-stream,{hex}"));
    assert_eq!(write(&document).unwrap().mesh.triangles, [[0, 1, 2]]);
    let base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAgD8AAAAA\
                  AAECAwAAAQACAAMAAAAAAAEAAAACAAAAAwAAAA==";
    document["buffers"][0]["uri"] = json!(format!("data:;base64,{base64}"));
    assert_eq!(write(&document).unwrap().mesh.triangles, [[0, 1, 2]]);

    for (uri, expected) in [
        ("missing.bin", "`missing.bin`"),
        (".", "no file"),
        ("data:;base64,AAA!", "base64"),
        ("data:nothing", "comma"),
        ("https://example.org/a.bin", "no path of a file beside"),
        ("data:;base64,AAAA", "it should have 76 bytes, but only 3"),
        ("data:;base64,A%41A\nA", "it should have 76 bytes, but only 3"),
    ] {
        document["buffers"][0]["uri"] = json!(uri);
        let error = write(&document).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// A document that somebody uploads must not read files of the server.
#[test]
fn buffers_outside_of_the_folder_of_the_document_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let inner = directory.path().join("inner");
    std::fs::create_dir_all(inner.join("below")).unwrap();
    for place in [directory.path(), &inner, &inner.join("below")] {
        std::fs::write(place.join("buffer.bin"), buffer()).unwrap();
    }
    let mut document = document();
    let mut read = |uri: &str| {
        document["buffers"][0]["uri"] = json!(uri);
        let path = inner.join("mesh.gltf");
        std::fs::write(&path, document.to_string()).unwrap();
        read_mesh(path)
    };
    for uri in ["buffer.bin", "./buffer.bin", "below/buffer.bin", "below/..buffer.bin"] {
        let is_there = !uri.contains("..");
        assert_eq!(read(uri).is_ok(), is_there, "{uri}");
    }
    let absolute = directory.path().join("buffer.bin");
    for uri in [
        "../buffer.bin",
        "%2e%2e/buffer.bin",
        "%2E%2E%2Fbuffer.bin",
        "below/../../buffer.bin",
        "below/../buffer.bin",
        "..\\buffer.bin",
        "..",
        "\\\\server\\share\\buffer.bin",
        "C:\\buffer.bin",
        "C:buffer.bin",
        "file:///etc/hostname",
        &absolute.display().to_string(),
    ] {
        let error = read(uri).unwrap_err().to_string();
        assert!(error.contains("no path of a file beside or below the document"), "{uri}: {error}");
    }
}

#[test]
fn a_missing_file_that_no_geometry_needs_does_no_harm() {
    let mut document = document();
    document["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "byteLength": 9, "uri": "images.bin" }));
    assert!(read(&document).is_ok());
}

#[test]
fn each_node_with_a_mesh_is_a_hull_of_a_hull_set() {
    let mut document = document();
    document["nodes"] =
        json!([{ "children": [1, 2] }, { "mesh": 0 }, { "mesh": 0, "scale": [2, 2, 2] }]);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("hulls.GLB");
    std::fs::write(&path, glb(&document, &buffer())).unwrap();
    let hulls = read_hulls(path).unwrap();
    assert_eq!(hulls.len(), 2);
    assert_eq!(hulls[1].mesh.positions, [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    assert_eq!(hulls[1].mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn nothing_is_refused_over_what_geometry_does_not_need() {
    let mut document = document();
    document["scenes"] = json!([{ "nodes": [0] }, { "name": "empty" }, { "nodes": null }]);
    document["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": {
            "path": "pointer",
            "extensions": { "KHR_animation_pointer": { "pointer": "/materials/0/alphaCutoff" } },
        } }],
        "samplers": "none",
    }]);
    document["cameras"] = json!({ "a": 1 });
    document["images"] = json!([{ "uri": 5 }]);
    document["materials"] = json!([7, { "alphaMode": {}, "doubleSided": true }]);
    document["meshes"][0]["primitives"][0]["material"] = json!(9);
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!("red");
    document["nodes"][0]["camera"] = json!([]);
    document["skins"] = json!([{}]);
    document["asset"]["minVersion"] = json!(2);
    let file = read(&document).unwrap();
    assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
    assert_eq!(file.notes, []);
}

#[test]
fn what_a_key_should_hold_is_said_in_words_with_its_place() {
    for (at, value, expected) in [
        ("/nodes/0/mesh", json!("a"), "node 0: its `mesh` is `a`, and a whole number from 0"),
        ("/nodes/0", json!({ "mesh": 0, "matrix": [1] }), "node 0: its `matrix` is a list, and"),
        ("/nodes/0", json!({ "children": 3 }), "node 0: its `children` is `3`, and a list"),
        ("/scenes/0/nodes", json!([{}]), "scene 0: in its `nodes` stands an object, and a whole"),
        ("/scenes/0/nodes", json!([4]), "there is no node 4; the file has 0 to 0"),
        ("/meshes/0/primitives", json!({}), "mesh 0: its `primitives` is an object, and a list"),
        ("/accessors/0/count", json!(-1), "accessor 0: its `count` is `-1`, and a whole number"),
        ("/buffers/0", json!({}), "buffer 0: its `byteLength` is missing, and a whole number"),
        ("/meshes", json!({ "m": {} }), "it is glTF 1.0, and glTF 2.0 would be read"),
        ("/accessors", json!("none"), "its `accessors` is `none`, and a list would be read"),
    ] {
        let mut document = document();
        *document.pointer_mut(at).expect(at) = value;
        let reason = reason(&document);
        assert!(reason.contains(expected), "{reason}");
        for word in ["invalid type", "expected a", "sequence", "map", "u32"] {
            assert!(!reason.contains(word), "{reason}");
        }
    }
}

#[test]
fn documents_that_are_none_say_what_they_are() {
    for (text, expected) in [
        ("", "it is empty, and glTF 2.0 would be read"),
        ("[{\"version\": \"2.0\"}]", "the JSON is no object"),
        ("{\"asset\": {\"version\": \"2.0\"},\n}", "line 2, column 1: it is no valid JSON"),
        ("{\"meshes\": []}", "it has no `asset`"),
        ("{\"asset\": {\"version\": \"1.0\"}, \"nodes\": {}}", "it is glTF 1.0"),
        ("version https://git-lfs.github.com/spec/v1\noid 1", "`git lfs pull` fetches"),
        ("\n<!DOCTYPE html><p>", "it is a web page"),
    ] {
        let error = read_mesh_from_bytes(Format::Gltf, text.as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with("glTF in memory: ") && error.contains(expected), "{error}");
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn indices_that_make_no_whole_triangle_are_left_out_and_noted() {
    for (mode, count, triangles) in [(4, 4, 1), (4, 2, 0), (5, 2, 0), (6, 1, 0)] {
        let mut document = document();
        document["accessors"][1]["count"] = json!(count);
        document["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let file = read(&document).unwrap();
        assert_eq!(file.mesh.triangles.len(), triangles);
        assert_eq!(kinds(&file.notes), [(NoteKind::IncompleteTriangles, 1)]);
    }
    let mut document = document();
    document["accessors"][1]["count"] = json!(0);
    assert_eq!(read(&document).unwrap().notes, []);
}

#[test]
fn base64_is_read_without_padding_with_line_breaks_and_escapes() {
    let base64 = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAgD8AAAAA\
                  AAECAwAAAQACAAMAAAAAAAEAAAACAAAAAwAAAA==";
    let unpadded = base64.trim_end_matches('=');
    let broken = format!("{}\r\n {}", &base64[..64], &base64[64..]);
    let escaped = base64.replace('=', "%3D").replace("8A", "%38%41");
    for (data, count) in [(base64, 0), (unpadded, 1), (&broken, 1), (&escaped, 1)] {
        for media_type in ["data:;base64", "data:application/gltf-buffer;Base64 "] {
            let mut document = document();
            document["buffers"][0]["uri"] = json!(format!("{media_type},{data}"));
            let file = read(&document).unwrap();
            assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
            assert_eq!(file.mesh.positions[3], [1.0, 1.0, 0.0]);
            let mended = file.notes.iter().map(|note| note.count).sum::<usize>();
            assert_eq!(mended, count, "{data}");
        }
    }
}

#[test]
fn hidden_nodes_are_left_out_with_all_below_them() {
    let hidden = |visible: bool| json!({ "KHR_node_visibility": { "visible": visible } });
    let mut document = document();
    document["nodes"] = json!([
        { "name": "hidden", "mesh": 0, "children": [1, 2], "extensions": hidden(false) },
        { "name": "below", "mesh": 0, "extensions": hidden(true) },
        { "name": "below", "mesh": 0 },
        { "name": "shown", "mesh": 0, "extensions": hidden(true) },
        { "name": "plain", "mesh": 0, "extensions": { "KHR_node_visibility": {} } },
    ]);
    document["scenes"] = json!([{ "nodes": [0, 3, 4] }]);
    let file = read(&document).unwrap();
    let names: Vec<&str> = file.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["shown", "plain"]);
    assert_eq!(kinds(&file.notes), [(NoteKind::HiddenNodes, 1)]);
    // A game may show them later, so a scene's meshes are all there.
    let scene = read_scene_from_bytes(&glb(&document, &buffer())).unwrap();
    assert_eq!(scene[0].nodes.len(), 5);
}

/// A document with more numbers behind its buffer, each list in an accessor of its own.
fn with_floats(kinds_and_numbers: &[(&str, &[f32])]) -> (Value, Vec<u8>) {
    let (mut document, mut bytes) = (document(), buffer());
    for (kind, numbers) in kinds_and_numbers {
        let components = match *kind {
            "SCALAR" => 1,
            "MAT4" => 16,
            vector => vector[3..].parse().unwrap(),
        };
        let view = document["bufferViews"].as_array().unwrap().len();
        document["bufferViews"].as_array_mut().unwrap().push(
            json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": numbers.len() * 4 }),
        );
        document["accessors"].as_array_mut().unwrap().push(json!({
            "bufferView": view, "componentType": 5126, "count": numbers.len() / components, "type": kind,
        }));
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }
    document["buffers"][0]["byteLength"] = json!(bytes.len());
    (document, bytes)
}

#[test]
fn each_instance_of_a_node_is_placed() {
    let (mut document, bytes) = with_floats(&[
        ("VEC3", &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0]),
        ("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]),
        ("VEC3", &[2.0, 2.0, 2.0, 1.0, 1.0, -1.0]),
    ]);
    let instancing =
        |attributes: Value| json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    let trs = json!({ "TRANSLATION": 4, "ROTATION": 5, "SCALE": 6, "_ID": 9 });
    document["nodes"][0]["extensions"] = instancing(trs);
    document["nodes"][0]["translation"] = json!([0, 0, 7]);
    document["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let read = |document: &Value| read_mesh_from_bytes(Format::Gltf, &glb(document, &bytes));
    let file = read(&document).unwrap();
    assert_eq!(file.objects.len(), 2);
    assert_eq!(file.mesh.positions[1], [2.0, 0.0, 7.0]);
    assert_eq!(file.mesh.positions[5], [9.0, 0.0, 7.0]);
    // The second is mirrored.
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [4, 6, 5]]);

    document["nodes"][0]["extensions"] = instancing(json!({ "TRANSLATION": 4 }));
    assert_eq!(read(&document).unwrap().mesh.positions[5], [11.0, 0.0, 7.0]);
    document["nodes"][0]["extensions"] = instancing(json!({ "_ID": 9 }));
    assert_eq!(read(&document).unwrap().objects.len(), 1);
    document["accessors"][5]["count"] = json!(1);
    document["nodes"][0]["extensions"] = instancing(json!({ "TRANSLATION": 4, "ROTATION": 5 }));
    let error = read(&document).unwrap_err().to_string();
    assert!(
        error.contains("node 0: EXT_mesh_gpu_instancing: its accessors are of different"),
        "{error}"
    );
    document["nodes"][0]["extensions"] = instancing(json!({ "TRANSLATION": 44 }));
    assert!(read(&document).unwrap_err().to_string().contains("there is no accessor 44"));
}

#[test]
fn instances_and_skins_without_end_take_no_time() {
    let many = 1_000_000;
    let mut document = document();
    document["accessors"].as_array_mut().unwrap().extend([
        json!({ "bufferView": 2, "componentType": 5121, "count": many, "type": "VEC3" }),
        json!({ "bufferView": 2, "componentType": 5126, "count": many / 8, "type": "MAT4" }),
    ]);
    document["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 0, "byteOffset": 76, "byteLength": many * 8 }));
    document["buffers"][0]["byteLength"] = json!(76 + many * 8);
    let chunk = [buffer(), vec![0; many * 8]].concat();
    // Nothing to place, any number of times by any number of nodes.
    let mut instanced = document.clone();
    instanced["meshes"][0]["primitives"] = json!([]);
    let extension = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "SCALE": 4 } } });
    instanced["nodes"] = Value::Array(vec![json!({ "mesh": 0, "extensions": extension }); 10_000]);
    instanced["scenes"][0]["nodes"] = (0..10_000).collect();
    let error = read_mesh_from_bytes(Format::Gltf, &glb(&instanced, &chunk)).unwrap_err();
    assert!(error.to_string().contains("used more often than"), "{error}");
    // A skin that every node uses.
    document["meshes"] = Value::Array(vec![document["meshes"][0].clone(); 10_000]);
    document["nodes"] = (0..10_000).map(|mesh| json!({ "mesh": mesh, "skin": 0 })).collect();
    document["scenes"][0]["nodes"] = (0..10_000).collect();
    document["skins"] = json!([{ "joints": [0], "inverseBindMatrices": 5 }]);
    let with_joints = json!({ "joints": vec![0; 100_000] });
    for skin in [document["skins"][0].clone(), with_joints] {
        document["skins"][0] = skin;
        let file = glb(&document, &chunk);
        let read = read_mesh_from_bytes(Format::Gltf, &file).unwrap();
        assert_eq!(read.mesh.triangles.len(), 10_000);
        assert_eq!(read_scene_from_bytes(&file).unwrap().len(), 10_000);
    }
}

/// The document's mesh on a node beside its armature, all vertices bound to the joint below that.
fn skinned(armature: Value, inverse_bind: [f32; 16]) -> (Value, Vec<u8>) {
    let (first, all) = ([0.0; 16], [1.0, 0.0, 0.0, 0.0].repeat(4));
    let (mut document, bytes) =
        with_floats(&[("VEC4", &first), ("VEC4", &all), ("MAT4", &inverse_bind)]);
    let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(4);
    attributes["WEIGHTS_0"] = json!(5);
    document["skins"] = json!([{ "joints": [2], "inverseBindMatrices": 6 }]);
    document["nodes"] = json!([armature, { "name": "body", "mesh": 0, "skin": 0 }, {}]);
    document["nodes"][0]["children"] = json!([2]);
    document["scenes"] = json!([{ "nodes": [0, 1] }]);
    (document, bytes)
}

const IDENTITY: [f32; 16] =
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

#[test]
fn a_skin_is_applied_where_its_joints_scale_or_move_the_mesh_at_rest() {
    for (armature, second) in [
        (json!({ "scale": [0.25, 0.25, 0.25] }), [0.25, 0.0, 0.0]),
        (json!({ "translation": [0, 0, 3] }), [1.0, 0.0, 3.0]),
        (json!({ "rotation": [0, 0, 1, 0] }), [-1.0, 0.0, 0.0]),
    ] {
        let (document, bytes) = skinned(armature, IDENTITY);
        let file = read_mesh_from_bytes(Format::Gltf, &glb(&document, &bytes)).unwrap();
        assert_eq!(file.mesh.positions[1], second);
        assert_eq!(file.mesh.triangles, [[0, 1, 2]]);
        assert_eq!(kinds(&file.notes), [(NoteKind::AppliedSkins, 1)]);
        // A mesh in its own space is as it was modelled, which is said.
        let scene = read_scene_from_bytes(&glb(&document, &bytes)).unwrap();
        assert_eq!(scene[0].mesh.positions[1], [1.0, 0.0, 0.0]);
        assert_eq!(kinds(&scene[0].notes), [(NoteKind::IgnoredSkins, 1)]);
    }
}

#[test]
fn a_skin_that_binds_a_mesh_where_it_stands_changes_no_bit() {
    let mut inverse = IDENTITY;
    for at in [0, 5, 10] {
        inverse[at] = 1.0 / 0.3 + 1e-6;
    }
    let (document, bytes) = skinned(json!({ "scale": [0.3, 0.3, 0.3] }), inverse);
    let file = read_mesh_from_bytes(Format::Gltf, &glb(&document, &bytes)).unwrap();
    assert_eq!(file.mesh.positions[1], [1.0, 0.0, 0.0]);
    assert_eq!(file.notes, []);
    assert_eq!(read_scene_from_bytes(&glb(&document, &bytes)).unwrap()[0].notes, []);
}

#[test]
fn a_mirrored_armature_keeps_outside_outside() {
    let (document, bytes) = skinned(json!({ "scale": [-1, 1, 1] }), IDENTITY);
    let file = read_mesh_from_bytes(Format::Gltf, &glb(&document, &bytes)).unwrap();
    assert_eq!(file.mesh.positions[1], [-1.0, 0.0, 0.0]);
    assert_eq!(file.mesh.triangles, [[0, 2, 1]]);
    assert!(area_normal(&file)[2] > 0.0);
}

#[test]
fn a_pose_is_noted_and_the_mesh_stays_as_it_was_modelled() {
    let (document, bytes) = skinned(json!({ "translation": [0, 0, 0.1] }), IDENTITY);
    let file = read_mesh_from_bytes(Format::Gltf, &glb(&document, &bytes)).unwrap();
    assert_eq!(file.mesh.positions[1], [1.0, 0.0, 0.0]);
    assert_eq!(kinds(&file.notes), [(NoteKind::PosingSkins, 1)]);
    let scene = read_scene_from_bytes(&glb(&document, &bytes)).unwrap();
    assert_eq!(kinds(&scene[0].notes), [(NoteKind::PosingSkins, 1)]);
}

#[test]
fn a_skin_that_can_not_be_read_is_left_out_and_noted() {
    let (sound, bytes) = skinned(json!({ "scale": [0.5, 0.5, 0.5] }), IDENTITY);
    for (at, value) in [
        ("/nodes/1/skin", json!(3)),
        ("/skins/0/joints", json!([9])),
        ("/skins/0/joints", json!([])),
        ("/skins/0/joints", json!("hips")),
        ("/skins/0/inverseBindMatrices", json!(0)),
        ("/accessors/4/count", json!(2)),
        ("/accessors/5/type", json!("VEC3")),
    ] {
        let mut document = sound.clone();
        *document.pointer_mut(at).expect(at) = value;
        let file = read_mesh_from_bytes(Format::Gltf, &glb(&document, &bytes)).expect(at);
        assert_eq!(file.mesh.positions[1], [1.0, 0.0, 0.0], "{at}");
        assert_eq!(kinds(&file.notes), [(NoteKind::UnreadableSkins, 1)], "{at}");
        let scene = read_scene_from_bytes(&glb(&document, &bytes)).unwrap();
        assert_eq!(kinds(&scene[0].notes), [(NoteKind::UnreadableSkins, 1)], "{at}");
    }
}

#[test]
fn vertices_follow_the_weights_of_all_their_joints() {
    let (mut document, bytes) = skinned(json!({ "scale": [0.5, 0.5, 0.5] }), IDENTITY);
    document["nodes"][2]["translation"] = json!([2, 0, 0]);
    document["skins"][0] = json!({ "joints": [2, 0] });
    let mut weights = bytes.clone();
    let at = document["bufferViews"][3]["byteOffset"].as_u64().unwrap() as usize;
    // The second joint has 1, the first 3; then none at all.
    for (slot, weight) in [(4, 3.0_f32), (5, 1.0), (8, 0.0)] {
        weights[at + slot * 4..at + slot * 4 + 4].copy_from_slice(&weight.to_le_bytes());
    }
    let joints = document["bufferViews"][2]["byteOffset"].as_u64().unwrap() as usize + 5 * 4;
    weights[joints..joints + 4].copy_from_slice(&1.0_f32.to_le_bytes());
    let file = read_mesh_from_bytes(Format::Gltf, &glb(&document, &weights)).unwrap();
    assert_eq!(file.mesh.positions[0], [1.0, 0.0, 0.0]);
    assert_eq!(file.mesh.positions[1], [1.25, 0.0, 0.0]);
    assert_eq!(file.mesh.positions[2], [1.0, 0.5, 0.0]);
}

#[test]
fn morph_targets_with_a_weight_at_rest_are_noted() {
    let mut document = document();
    document["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
    for (on_mesh, on_node, count) in [
        (json!([0.0]), json!(null), 0),
        (json!([0.5]), json!(null), 1),
        (json!(null), json!([1]), 1),
    ] {
        document["meshes"][0]["weights"] = on_mesh;
        document["nodes"][0]["weights"] = on_node;
        let notes = read(&document).unwrap().notes;
        assert_eq!(notes.len(), count);
        assert!(notes.iter().all(|note| note.kind == NoteKind::IgnoredMorphTargets));
    }
}
