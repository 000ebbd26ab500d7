//! Compressed glTF: Draco and meshoptimizer's codecs, each with quantised attributes too.

use std::path::{Path, PathBuf};

use hullwright::{Control, Parameters, decompose};
use hullwright_formats::{Format, MeshFile, read_mesh, read_mesh_from_bytes, read_own_meshes};
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{
    ExpMode, IndexEncoding, VertexEncoding, decode_index_buffer, encode_filter_exp,
    encode_index_buffer, encode_index_sequence, encode_vertex_buffer,
};
use serde_json::{Value, json};

use crate::glb::{glb, parts};

const EXT: &str = "EXT_meshopt_compression";
const KHR: &str = "KHR_meshopt_compression";

fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Six times the volume inside of a closed surface.
fn volume(file: &MeshFile) -> f64 {
    let determinant = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| file.mesh.positions[vertex as usize]);
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    file.mesh.triangles.iter().map(determinant).sum()
}

#[test]
fn files_of_other_programs_hold_the_surface_that_was_compressed() {
    for (file, source) in [
        ("mug_draco.glb", "mug.glb"),
        ("mug_draco_valence.glb", "mug.glb"),
        ("mug_draco_quantized.glb", "mug.glb"),
        ("leaf_draco_sequential.glb", "leaf.glb"),
        ("mug_meshopt_ext.glb", "mug.glb"),
        ("mug_meshopt_khr.glb", "mug.glb"),
    ] {
        let expected = read_mesh(path("../../assets").join(source)).unwrap();
        let found = read_mesh(path("tests/data").join(file)).unwrap();
        assert_eq!(found.mesh.triangles.len(), expected.mesh.triangles.len(), "{file}");
        // Of 14 bits over 14 cm, rounded in each of three axes.
        let tolerance = 1e-5;
        for place in &expected.mesh.positions {
            let nearest = found.mesh.positions.iter().map(|other| distance(*place, *other));
            assert!(nearest.fold(f64::INFINITY, f64::min) < tolerance, "{file}: {place:?}");
        }
        if source == "mug.glb" {
            let (found, expected) = (volume(&found), volume(&expected));
            assert!((found / expected - 1.0).abs() < 1e-3, "{file}: {found} for {expected}");
        }
    }
}

/// What a view holds, and how it may be compressed.
struct View {
    bytes: Vec<u8>,
    stride: usize,
    stream: Vec<u8>,
    mode: &'static str,
    filter: &'static str,
}

fn workspace() -> Workspace {
    Workspace::default()
}

fn attributes(bytes: Vec<u8>, stride: usize, version: u8) -> View {
    let encoding = VertexEncoding::new(version, 2).unwrap();
    let stream =
        encode_vertex_buffer(&bytes, bytes.len() / stride, stride, encoding, &mut workspace());
    View { stream: stream.unwrap(), bytes, stride, mode: "ATTRIBUTES", filter: "NONE" }
}

/// Indices as 32-bit integers. The codec may begin a triangle at another corner, so what it holds
/// is what it gives back.
fn triangles(indices: &[u32]) -> View {
    let stream = encode_index_buffer(indices, IndexEncoding::DEFAULT, &mut workspace()).unwrap();
    let bytes = decode_index_buffer(indices.len(), 4, &stream, &mut workspace()).unwrap();
    View { stream, bytes, stride: 4, mode: "TRIANGLES", filter: "NONE" }
}

fn sequence(indices: &[u16]) -> View {
    let wide: Vec<u32> = indices.iter().map(|index| u32::from(*index)).collect();
    let stream = encode_index_sequence(&wide, IndexEncoding::DEFAULT, &mut workspace()).unwrap();
    let bytes = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
    View { stream, bytes, stride: 2, mode: "INDICES", filter: "NONE" }
}

/// A document of one mesh: positions in the first view, indices in the second.
fn document(views: &[View], position: &Value, index_type: u32) -> Value {
    let mut accessor = position.clone();
    accessor["bufferView"] = json!(0);
    accessor["count"] = json!(views[0].bytes.len() / views[0].stride);
    accessor["type"] = json!("VEC3");
    json!({
        "asset": { "version": "2.0" },
        "extensionsRequired": ["KHR_mesh_quantization"],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [accessor, {
            "bufferView": 1, "type": "SCALAR", "componentType": index_type,
            "count": views[1].bytes.len() / views[1].stride,
        }],
        "bufferViews": [],
        "buffers": [],
    })
}

fn plain(mut document: Value, views: &[View]) -> Vec<u8> {
    let mut chunk = Vec::new();
    for view in views {
        let mut described = json!({
            "buffer": 0, "byteOffset": chunk.len(), "byteLength": view.bytes.len(),
        });
        if view.mode == "ATTRIBUTES" {
            described["byteStride"] = json!(view.stride);
        }
        document["bufferViews"].as_array_mut().unwrap().push(described);
        chunk.extend(&view.bytes);
        chunk.resize(chunk.len().next_multiple_of(4), 0);
    }
    document["buffers"] = json!([{ "byteLength": chunk.len() }]);
    glb(&document, &chunk)
}

/// The document with streams for views, and its chunk.
fn compressed(mut document: Value, views: &[View], extension: &str) -> (Value, Vec<u8>) {
    let (mut chunk, mut offset) = (Vec::new(), 0);
    for view in views {
        let mut described = json!({
            "buffer": 1, "byteOffset": offset, "byteLength": view.bytes.len(),
            "extensions": { extension: {
                "buffer": 0, "byteOffset": chunk.len(), "byteLength": view.stream.len(),
                "byteStride": view.stride, "count": view.bytes.len() / view.stride,
                "mode": view.mode, "filter": view.filter,
            } },
        });
        if view.mode == "ATTRIBUTES" {
            described["byteStride"] = json!(view.stride);
        }
        document["bufferViews"].as_array_mut().unwrap().push(described);
        offset += view.bytes.len();
        chunk.extend(&view.stream);
        chunk.resize(chunk.len().next_multiple_of(4), 0);
    }
    document["extensionsRequired"].as_array_mut().unwrap().push(json!(extension));
    document["buffers"] = json!([
        { "byteLength": chunk.len() },
        { "byteLength": offset, "extensions": { extension: { "fallback": true } } },
    ]);
    (document, chunk)
}

/// A mesh with positions of 16 bits, as `KHR_mesh_quantization` has them.
fn quantised(version: u8) -> (Value, [View; 2]) {
    let mesh = read_mesh(path("../../assets/mug.glb")).unwrap();
    let numbers = mesh.mesh.positions.iter().flatten();
    let greatest = numbers.fold(0.0_f64, |greatest, number| greatest.max(number.abs()));
    let mut bytes = Vec::new();
    for place in &mesh.mesh.positions {
        let whole = place.map(|number| (number / greatest * 32767.0).round() as i16);
        bytes.extend(whole.iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    let indices: Vec<u32> = mesh.mesh.triangles.iter().flatten().copied().collect();
    let views = [attributes(bytes, 8, version), triangles(&indices)];
    let position = json!({ "componentType": 5122, "normalized": true });
    let mut document = document(&views, &position, 5125);
    document["nodes"][0]["scale"] = json!([greatest, greatest, greatest]);
    (document, views)
}

fn read(bytes: &[u8]) -> MeshFile {
    read_mesh_from_bytes(Format::Gltf, bytes).unwrap()
}

#[test]
fn a_compressed_quantised_mesh_has_the_hulls_of_its_plain_twin() {
    for (extension, version) in [(EXT, 0), (KHR, 1)] {
        let (document, views) = quantised(version);
        let twin = plain(document.clone(), &views);
        let (document, chunk) = compressed(document, &views, extension);
        let small = glb(&document, &chunk);
        assert!(small.len() < twin.len() * 2 / 3, "{} for {}", small.len(), twin.len());
        let files = [read(&twin), read(&small)];
        assert_eq!(files[0], files[1]);
        let [expected, found] = files
            .map(|file| decompose(&file, &Parameters::default(), &Control::new()).unwrap().hulls);
        assert!(expected.len() > 1);
        assert_eq!(found, expected);
    }
}

/// The triangles of a square of the size 1, as floating-point numbers behind a filter.
fn square(indices: &[u16]) -> (Value, [View; 2]) {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let mode = ExpMode::SharedVector;
    let filtered = encode_filter_exp(4, 12, 15, &corners, mode, &mut workspace()).unwrap();
    let bytes = corners.iter().flat_map(|number| number.to_le_bytes()).collect();
    let positions = View { bytes, filter: "EXPONENTIAL", ..attributes(filtered, 12, 0) };
    let views = [positions, sequence(indices)];
    (document(&views, &json!({ "componentType": 5126 }), 5123), views)
}

#[test]
fn filtered_positions_and_index_sequences_are_read() {
    let (document, views) = square(&[0, 1, 2, 3]);
    for extension in [EXT, KHR] {
        let (mut document, chunk) = compressed(document.clone(), &views, extension);
        document["meshes"][0]["primitives"][0]["mode"] = json!(5);
        let file = read(&glb(&document, &chunk));
        assert_eq!(file.mesh.positions[1..], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
        assert_eq!(file.mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
    }
}

#[test]
fn streams_that_are_not_needed_do_no_harm() {
    let (document, mut views) = square(&[0, 1, 2]);
    views[0].stream[0] = 0xff;
    let (mut document, chunk) = compressed(document, &views, EXT);
    document["nodes"][0] = json!({ "name": "shows nothing" });
    assert!(read(&glb(&document, &chunk)).mesh.triangles.is_empty());
}

fn reason(document: &Value, chunk: &[u8]) -> String {
    read_mesh_from_bytes(Format::Gltf, &glb(document, chunk)).unwrap_err().to_string()
}

#[test]
fn a_stream_that_does_not_fit_its_description_is_an_error_that_names_its_view() {
    let (document, views) = square(&[0, 1, 2]);
    let (document, chunk) = compressed(document, &views, EXT);
    let change = |view: usize, key: &str, value: Value| {
        let mut document = document.clone();
        document["bufferViews"][view]["extensions"][EXT][key] = value;
        let reason = reason(&document, &chunk);
        assert!(reason.contains(&format!("buffer view {view}: ")), "{reason}");
        reason
    };
    let undone = "its stream does not decompress to";
    assert!(change(0, "byteLength", json!(views[0].stream.len() - 1)).contains(undone));
    assert!(change(0, "byteLength", json!(0)).contains(undone));
    assert!(change(0, "byteLength", json!(1_000_000)).contains("reaches beyond"));
    assert!(change(0, "byteOffset", json!(u64::MAX)).contains("reaches beyond"));
    assert!(change(0, "buffer", json!(1)).contains("placeholder for compressed data"));
    assert!(change(0, "buffer", json!(7)).contains("no buffer 7"));
    assert!(change(0, "mode", json!("TRIANGLES")).contains("only attributes can have a filter"));
    assert!(change(1, "mode", json!("TRIANGLES")).contains(undone));
    assert!(change(1, "mode", json!("ATTRIBUTES")).contains(undone));
    assert!(change(1, "mode", json!("SOMETHING")).contains("mode `SOMETHING` is unknown"));
    assert!(change(1, "mode", json!(null)).contains("`mode` is missing"));
    assert!(change(1, "filter", json!("SOMETHING")).contains("filter `SOMETHING` is unknown"));
    assert!(change(0, "filter", json!("QUATERNION")).contains(undone));
    assert!(change(0, "count", json!(-1)).contains("a whole number from 0 would be read"));
    assert!(change(0, "count", json!(0)).contains(&format!("{undone} 0")));
    for stride in [0, 1, 3, 257, 260] {
        assert!(change(0, "byteStride", json!(stride)).contains(undone), "{stride}");
    }
    assert!(change(0, "count", json!(1_000_000)).contains(undone));
    for count in [1_000_000_000_u64, u64::MAX] {
        assert!(change(0, "count", json!(count)).contains("may not grow to"));
    }
    let mut other = document.clone();
    other["bufferViews"][0]["byteLength"] = json!(36);
    assert!(reason(&other, &chunk).contains("should have 36 bytes, but 48 were made"));
}

/// A stream that stands for 25 MB, named by a hundred views.
#[test]
fn streams_that_grow_without_end_are_an_error() {
    let count = 100_000;
    let zeros = attributes(vec![0; count * 256], 256, 0);
    let views = [zeros, sequence(&[0, 0, 0])];
    let document = document(&views, &json!({ "componentType": 5126 }), 5123);
    let (mut document, chunk) = compressed(document, &views, EXT);
    assert_eq!(read(&glb(&document, &chunk)).mesh.positions.len(), count);
    for copy in 2..100 {
        let view = document["bufferViews"][0].clone();
        document["bufferViews"].as_array_mut().unwrap().push(view);
        let mut accessor = document["accessors"][0].clone();
        accessor["bufferView"] = json!(copy);
        document["accessors"].as_array_mut().unwrap().push(accessor);
        let primitive = json!({ "attributes": { "POSITION": copy }, "indices": 1 });
        document["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    }
    assert!(reason(&document, &chunk).contains("may not grow to"));
}

/// A file that another program compressed, taken apart.
fn taken_apart(file: &str) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(path("tests/data").join(file)).unwrap();
    let (document, chunk) = parts(&bytes);
    (document, chunk.to_vec())
}

#[test]
fn a_draco_stream_that_does_not_fit_its_description_is_an_error_that_says_what_to_do() {
    let (document, chunk) = taken_apart("mug_draco.glb");
    let change = |at: &str, value: Value| {
        let mut document = document.clone();
        *document.pointer_mut(at).expect(at) = value;
        let reason = reason(&document, &chunk);
        assert!(reason.contains("KHR_draco_mesh_compression"), "{reason}");
        reason
    };
    let extension = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let at = |key: &str| format!("{extension}{key}");
    assert!(change(&at("/attributes/POSITION"), json!(7)).contains("has no attribute 7"));
    assert!(change(&at("/attributes"), json!({})).contains("`POSITION` is missing"));
    assert!(change(&at("/bufferView"), json!("0")).contains("a whole number from 0 would be read"));
    assert!(change(&at(""), json!({})).contains("`bufferView` is missing"));
    let cut = change("/bufferViews/0/byteLength", json!(1000));
    assert!(cut.contains("buffer view 0: its stream can't be decoded"), "{cut}");
    assert!(cut.contains("npx @gltf-transform/cli copy in.glb out.glb"), "{cut}");
    let mut other = document.clone();
    *other.pointer_mut(&at("/bufferView")).unwrap() = json!(9);
    assert!(reason(&other, &chunk).contains("there is no buffer view 9"));
    let mut other = chunk.clone();
    // Behind the header of 11 bytes and the traversal: how many vertices there are, then faces.
    other.splice(12..12, [0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f]);
    let many = reason(&document, &other[..chunk.len()]);
    assert!(many.contains("stream can't be decoded"), "{many}");
}

#[test]
fn a_draco_stream_is_placed_once_for_each_node_and_primitive() {
    let (mut document, chunk) = taken_apart("mug_draco.glb");
    document["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "translation": [1.0, 0.0, 0.0] }]);
    document["scenes"] = json!([{ "nodes": [0, 1] }]);
    let primitive = document["meshes"][0]["primitives"][0].clone();
    document["meshes"][0]["primitives"].as_array_mut().unwrap().push(primitive);
    let file = read(&glb(&document, &chunk));
    let once = read_own_meshes(path("tests/data/mug_draco.glb")).unwrap();
    assert_eq!(file.mesh.positions.len(), 2 * once[0].mesh.positions.len());
    assert_eq!(file.mesh.triangles.len(), 4 * once[0].mesh.triangles.len());
}
