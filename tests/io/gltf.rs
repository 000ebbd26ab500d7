//! What the glTF reader promises, on documents made by hand.

use crate::glb::glb;
use hullwright::Error;
use hullwright::io::{Format, MeshFile, read_hulls, read_mesh, read_mesh_from_bytes};
use serde_json::{Value, json};

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
    document["meshes"][0]["primitives"][0]["mode"] = json!(4);
    assert!(reason(&document).contains("4 indices don't make whole triangles"));
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
    document["scene"] = json!(2);
    assert!(reason(&document).contains("there is no scene 2"));
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
    assert!(change("/accessors/0/type", json!("VEC2")).contains("type should be Vec3"));
    assert!(change("/accessors/0/type", json!("VEC9")).contains("type should be Vec3"));
    assert!(change("/accessors/0/componentType", json!(1)).contains("component type is unknown"));
    assert!(change("/accessors/0/componentType", json!(5125)).contains("can't be 32-bit"));
    assert!(change("/accessors/1/componentType", json!(5126)).contains("unsigned integers"));
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
    for hidden in ["EXT_mesh_gpu_instancing", "KHR_mesh_quantization_2"] {
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
    assert!(broken(4, 1).contains("version"));
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
