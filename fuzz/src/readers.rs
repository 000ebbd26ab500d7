//! Bytes as files of every format: as they are, and made into what gets past the first checks.

use arbitrary::{Result, Unstructured};
use hullwright::Error;
use hullwright::hulls_format::{FORMAT_VERSION, HullsFile};
use hullwright_formats::{Format, MeshFile, read_mesh_from_bytes, read_scene_from_bytes};

/// What is read names only what is there; what is refused says why.
fn read(format: Format, bytes: &[u8]) {
    if format == Format::Gltf {
        let _ = read_scene_from_bytes(bytes);
    }
    match read_mesh_from_bytes(format, bytes) {
        Ok(file) => assert_sound(&file),
        Err(Error::File { source, .. }) => {
            let reason = source.to_string();
            assert!(!reason.is_empty() && !reason.contains('\n'), "{reason}");
        }
        Err(error) => panic!("an unexpected kind of error: {error}"),
    }
}

fn assert_sound(file: &MeshFile) {
    let vertices = file.mesh.positions.len();
    assert!(file.mesh.triangles.iter().flatten().all(|vertex| (*vertex as usize) < vertices));
    let mut end = 0;
    for object in &file.objects {
        assert_eq!(object.triangles.start, end);
        assert!(object.triangles.end > end);
        end = object.triangles.end;
    }
    assert_eq!(end, file.mesh.triangles.len());
    assert!(file.notes.iter().all(|note| note.count > 0));
}

/// Reads the bytes, and text of a format's own words that the bytes choose.
fn read_text(format: Format, bytes: &[u8], words: &[&str]) {
    read(format, bytes);
    let text: Vec<&str> =
        bytes.iter().map(|byte| words[usize::from(*byte) % words.len()]).collect();
    read(format, text.concat().as_bytes());
}

/// Bytes as text of UTF-16, with its mark.
fn utf_16(bytes: &[u8]) -> Vec<u8> {
    [0xff, 0xfe].into_iter().chain(bytes.iter().flat_map(|byte| [*byte, 0])).collect()
}

pub fn obj(bytes: &[u8]) {
    const WORDS: &[&str] = &[
        "\n",
        " ",
        "\nv ",
        "\nf ",
        "\no a",
        "\ng b",
        "\nl ",
        "\nvn ",
        "\nvt ",
        "/",
        "//",
        "-1",
        "1 ",
        "2 ",
        "3 ",
        "4 ",
        "0 ",
        "-2",
        "1e9 ",
        "nan ",
        "inf ",
        "0.5 ",
        "\\\n",
        "#",
        "1e400 ",
        "99999999999 ",
        "1 2 3 ",
        "0 0 0 ",
        "1 0 0 ",
        "0 1 0 ",
        "0 0 1 ",
        "\r\n",
        "-1.#IND ",
        "-nan(ind) ",
    ];
    read_text(Format::Obj, bytes, WORDS);
    read(Format::Obj, &utf_16(bytes));
}

pub fn off(bytes: &[u8]) {
    const WORDS: &[&str] = &[
        "OFF\n",
        "COFF\n",
        "STOFF\n",
        "4OFF ",
        "nOFF ",
        "BINARY",
        "\n",
        " ",
        "#",
        "3 1 0\n",
        "4 4 6\n",
        "0 ",
        "1 ",
        "2 ",
        "3 ",
        "4 ",
        "-1 ",
        "1e30 ",
        "nan ",
        "0 0 0\n",
        "1 0 0\n",
        "0 1 0\n",
        "0 0 1\n",
        "3 0 1 2\n",
        "4 0 1 2 3\n",
        "3 0 2 9\n",
        "99999999999 ",
        ".5 ",
        "off ",
        "1.#INF ",
    ];
    read_text(Format::Off, bytes, WORDS);
    let text = [b"OFF\n".as_slice(), bytes].concat();
    read(Format::Off, &text);
}

/// Three kinds: as they are, with a header that the bytes choose, and binary after such a header.
pub fn ply(bytes: &[u8]) {
    read(Format::Ply, bytes);
    let _ = shaped_ply(Unstructured::new(bytes));
}

fn shaped_ply(mut bytes: Unstructured<'_>) -> Result<()> {
    const TYPES: [&str; 9] =
        ["float", "double", "uchar", "char", "ushort", "short", "uint", "int", "float32"];
    let format = *bytes.choose(&["ascii", "binary_little_endian", "binary_big_endian"])?;
    let end = *bytes.choose(&["\n", "\r", "\r\n", "\n \t"])?;
    let mut header = format!("ply\nformat {format} 1.0\n");
    for _ in 0..bytes.int_in_range(0..=3)? {
        let element = *bytes.choose(&["vertex", "face", "edge", "tristrips"])?;
        let count = *bytes.choose(&[0_u64, 1, 3, 4, 200, u64::MAX, 4_294_967_297])?;
        header += &format!("element {element} {count}\n");
        for _ in 0..bytes.int_in_range(0..=5)? {
            let name =
                *bytes.choose(&["x", "y", "z", "vertex_indices", "vertex_index", "red", "x"])?;
            let of = *bytes.choose(&TYPES)?;
            if bytes.ratio(1, 3)? {
                header += &format!("property list {} {of} {name}\n", bytes.choose(&TYPES)?);
            } else {
                header += &format!("property {of} {name}\n");
            }
        }
    }
    header += "end_header\n";
    let kind = *bytes.choose(&["face", "tristrips"])?;
    let rest = bytes.take_rest();
    read(Format::Ply, &[header.replace('\n', end).as_bytes(), rest].concat());
    // The same with vertices and faces as they should be, so that the values are reached.
    let vertices = rest.len().min(8);
    let header = format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement {kind} 3\nproperty list uchar int vertex_indices\nend_header\n"
    );
    read(Format::Ply, &[header.as_bytes(), rest].concat());
    Ok(())
}

/// As they are, as words, and binary with a count that is true.
pub fn stl(bytes: &[u8]) {
    const FACET: usize = 50;
    const WORDS: &[&str] = &[
        "solid",
        " a\n",
        "facet normal ",
        "0 0 1\n",
        "outer loop\n",
        "vertex ",
        "1 0 0\n",
        "endloop\n",
        "endfacet\n",
        "endsolid",
        "\n",
        "nan ",
        "1e39 ",
        "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n",
        " ",
        "-",
        "\nend ",
        "loop",
        "facet",
        "\nsolid a\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\n",
    ];
    read_text(Format::Stl, bytes, WORDS);
    // A header that reads as text, before bytes that seldom are a whole number of triangles.
    let mut file = b"solid facet vertex endsolid".to_vec();
    file.resize(80, b' ');
    file.extend(((bytes.len() / FACET) as u32).to_le_bytes());
    file.extend(bytes);
    read(Format::Stl, &file);
}

/// As they are, and as a GLB whose JSON the bytes choose and whose data they are.
pub fn gltf(bytes: &[u8]) {
    read(Format::Gltf, bytes);
    let _ = shaped_gltf(Unstructured::new(bytes));
}

fn shaped_gltf(mut bytes: Unstructured<'_>) -> Result<()> {
    let mut json = gltf_json(&mut bytes)?.to_string().into_bytes();
    let mut data = bytes.take_rest().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    data.resize(data.len().next_multiple_of(4), 0);
    let mut file = b"glTF".to_vec();
    file.extend(2_u32.to_le_bytes());
    file.extend(((28 + json.len() + data.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &data)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    read(Format::Gltf, &file);
    Ok(())
}

fn gltf_json(bytes: &mut Unstructured<'_>) -> Result<serde_json::Value> {
    use serde_json::{Value, json};
    let number = |bytes: &mut Unstructured<'_>| -> Result<Value> {
        Ok(json!(*bytes.choose(&[0_u64, 1, 2, 3, 4, 8, 12, 36, 60, 255, 65_536, 4_294_967_295])?))
    };
    let mut views = Vec::new();
    for _ in 0..bytes.int_in_range(1..=3)? {
        let mut view = json!({ "buffer": 0, "byteLength": number(bytes)? });
        if bytes.arbitrary()? {
            view["byteOffset"] = number(bytes)?;
        }
        if bytes.ratio(1, 3)? {
            view["byteStride"] = number(bytes)?;
        }
        if bytes.ratio(1, 6)? {
            let mode = *bytes.choose(&["ATTRIBUTES", "TRIANGLES", "INDICES"])?;
            let filter = *bytes.choose(&["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"])?;
            view["extensions"] = json!({ "EXT_meshopt_compression": {
                "buffer": 0, "byteOffset": number(bytes)?, "byteLength": number(bytes)?,
                "byteStride": number(bytes)?, "count": number(bytes)?, "mode": mode, "filter": filter,
            }});
        }
        views.push(view);
    }
    let mut accessors = Vec::new();
    for _ in 0..bytes.int_in_range(1..=3)? {
        let component = *bytes.choose(&[5126_u32, 5125, 5123, 5121, 5120, 5122])?;
        let kind = *bytes.choose(&["VEC3", "SCALAR", "VEC2", "VEC4", "MAT4"])?;
        let mut accessor =
            json!({ "componentType": component, "count": number(bytes)?, "type": kind });
        if bytes.ratio(7, 8)? {
            accessor["bufferView"] = json!(bytes.int_in_range(0..=3)?);
        }
        if bytes.ratio(1, 4)? {
            accessor["byteOffset"] = number(bytes)?;
        }
        if bytes.ratio(1, 6)? {
            accessor["sparse"] = json!({ "count": number(bytes)?,
                "indices": { "bufferView": 0, "componentType": 5123 }, "values": { "bufferView": 1 } });
        }
        accessors.push(accessor);
    }
    let mut primitive = json!({ "attributes": { "POSITION": bytes.int_in_range(0..=3)? } });
    if bytes.ratio(1, 4)? {
        primitive["attributes"]["JOINTS_0"] = json!(bytes.int_in_range(0..=3)?);
        primitive["attributes"]["WEIGHTS_0"] = json!(bytes.int_in_range(0..=3)?);
        primitive["targets"] = json!([{}]);
    }
    if bytes.arbitrary()? {
        primitive["indices"] = json!(bytes.int_in_range(0..=3)?);
    }
    if bytes.ratio(1, 3)? {
        primitive["mode"] = json!(bytes.int_in_range(0..=7)?);
    }
    if bytes.ratio(1, 6)? {
        primitive["extensions"] = json!({ "KHR_draco_mesh_compression": {
            "bufferView": bytes.int_in_range(0..=3)?, "attributes": { "POSITION": 0 } } });
    }
    let mut nodes = Vec::new();
    for _ in 0..bytes.int_in_range(1..=3)? {
        let mut node = json!({ "mesh": bytes.int_in_range(0..=1)? });
        if bytes.arbitrary()? {
            node["children"] = json!([bytes.int_in_range(0..=3)?]);
        }
        if bytes.ratio(1, 3)? {
            node["scale"] = json!([bytes.arbitrary::<i8>()?, 1, 1e-30]);
        }
        if bytes.ratio(1, 4)? {
            node["skin"] = json!(bytes.int_in_range(0..=1)?);
        }
        if bytes.ratio(1, 4)? {
            let accessor = bytes.int_in_range(0..=3)?;
            let attribute = *bytes.choose(&["TRANSLATION", "ROTATION", "SCALE"])?;
            node["extensions"] = json!({
                "EXT_mesh_gpu_instancing": { "attributes": { attribute: accessor } },
                "KHR_node_visibility": { "visible": bytes.arbitrary::<bool>()? },
            });
        }
        if bytes.ratio(1, 6)? {
            node["matrix"] =
                json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, bytes.arbitrary::<i8>()?, 0, 1e30, 0, 0, 1]);
        }
        nodes.push(node);
    }
    let length = number(bytes)?;
    let skin = json!({ "joints": [bytes.int_in_range(0..=3)?, 0], "inverseBindMatrices": bytes.int_in_range(0..=3)? });
    Ok(json!({
        "asset": { "version": "2.0" }, "scene": 0,
        "scenes": [{ "nodes": [0, bytes.int_in_range(0..=2)?] }], "nodes": nodes,
        "meshes": [{ "primitives": [primitive] }], "skins": [skin],
        "buffers": [{ "byteLength": length }], "bufferViews": views, "accessors": accessors,
    }))
}

/// As they are, and as the body of a file of each version whose header and checksum are right. What
/// is read is written as it was, and read as it was written.
pub fn hulls_file(bytes: &[u8]) {
    let _ = HullsFile::from_bytes(bytes);
    (1..=FORMAT_VERSION).for_each(|version| hulls_file_of(version, bytes));
}

fn hulls_file_of(version: u32, bytes: &[u8]) {
    let mut file = b"\x89HULLS\r\n".to_vec();
    file.extend(version.to_le_bytes());
    file.extend(7_u32.to_le_bytes());
    file.extend((bytes.len() as u64).to_le_bytes());
    file.extend(bytes);
    file.extend(crc32fast::hash(&file).to_le_bytes());
    if let Ok(read) = HullsFile::from_bytes(&file) {
        for hull in &read.hulls {
            let points = hull.shape.points.len();
            assert!(hull.shape.triangles.iter().flatten().all(|index| (*index as usize) < points));
            assert!(hull.shape.points.iter().flatten().all(|x| x.is_finite()));
            // Whatever they are, engines may ask for this.
            let _ = hull.shape.to_single_precision();
        }
        for (hull, shares) in read.part_shares.iter().enumerate() {
            assert_eq!(read.part(hull).is_none(), shares.is_empty());
            assert!(shares.iter().all(|share| (share.part as usize) < read.parts.len()));
        }
        let written = read.to_bytes().expect("it fitted once");
        // Volumes are computed anew, and may say now that there is none.
        if let Ok(again) = HullsFile::from_bytes(&written) {
            assert_eq!(again, read);
        }
    }
}

/// Names, glTF extras and physics extensions by which artists ask for colliders.
pub fn extras(bytes: &[u8]) {
    use hullwright_formats::conventions::{
        HullsRecord, PhysicsExtensions, mesh_tag, node_tag, read_extras, read_surface,
        without_copy_number,
    };
    let text = String::from_utf8_lossy(bytes);
    let _ = (read_surface(&text), HullsRecord::from_extras(&text));
    if let Ok(serde_json::Value::Object(said)) = serde_json::from_str(&text) {
        // As extensions of a document with three nodes and two meshes, and of one of its nodes.
        let _ = PhysicsExtensions::new(&said, 3, 2).of_node(&said);
    }
    let _ = (read_extras(&text), node_tag(&text), mesh_tag(&text), without_copy_number(&text));
    let escaped = serde_json::Value::from(text.as_ref()).to_string();
    let (tag, complaints) = read_extras(&format!("{{\"collider\": {escaped}}}"));
    assert_eq!(tag.is_none(), !complaints.is_empty(), "a kind is known, or there is a complaint");
    let parameters = tag.and_then(|tag| tag.parameters(&hullwright::Method::default()));
    if let Some(parameters) = parameters {
        parameters.validate().expect("a collider alone asks for nothing that is refused");
    }
}
