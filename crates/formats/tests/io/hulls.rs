//! What hulls in a glTF file promise, read by the crate `gltf` and by this one.

use std::collections::BTreeSet;

use gltf::{Gltf, Node};
use hullwright::hulls_format::{BakedMesh, HullsFile, MeshHash};
use hullwright::{Control, Error, Length, Method, Parameters};
use hullwright_formats::bake::{BakeJob, BakeOptions, bake_jobs};
use hullwright_formats::conventions::{HullsRecord, WrittenHull};
use hullwright_formats::gltf_hulls::{FoundHulls, HullForm, HullsInFile, MeshHulls};
use hullwright_formats::{Format, read_mesh_from_bytes, read_scene_from_bytes};
use serde_json::{Map, Value, json};

use crate::glb::{glb, parts};

fn asset(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../../assets/{name}.glb", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn coarse() -> Method {
    Parameters::default().with_max_error(Length::share(0.2)).into()
}

fn jobs_by(bytes: &[u8], method: Method) -> Vec<BakeJob> {
    let options = BakeOptions::new(method).with_written(true);
    bake_jobs(read_scene_from_bytes(bytes).unwrap(), &options)
}

fn jobs(bytes: &[u8]) -> Vec<BakeJob> {
    jobs_by(bytes, Method::default())
}

fn found(bytes: &[u8]) -> Vec<FoundHulls> {
    let file = HullsInFile::from_bytes(bytes).unwrap();
    jobs(bytes).iter().map(|job| file.found(job)).collect()
}

/// As `hullwright bake --into` does it. What is in the file as before is not made again.
fn bake_by(bytes: &[u8], form: HullForm, method: Method) -> Vec<u8> {
    write(&HullsInFile::from_bytes(bytes).unwrap(), form, &jobs_by(bytes, method))
}

fn write(file: &HullsInFile, form: HullForm, jobs: &[BakeJob]) -> Vec<u8> {
    let baked = |job: &BakeJob| -> BakedMesh {
        file.found(job).baked.unwrap_or_else(|| job.run(&Control::new()).unwrap())
    };
    let meshes = jobs.iter().map(|job| MeshHulls { nodes: &job.gltf_nodes, baked: baked(job) });
    file.write(form, &meshes.collect::<Vec<_>>()).unwrap()
}

fn bake(bytes: &[u8], form: HullForm) -> Vec<u8> {
    bake_by(bytes, form, Method::default())
}

const FORMS: [HullForm; 2] = [HullForm::Physics, HullForm::Ucx];

/// A document with binary data after it, changed.
fn changed(bytes: &[u8], change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut document, chunk) = parts(bytes);
    change(&mut document);
    glb(&document, chunk)
}

/// The JSON of a GLB as it is written.
fn json_text(bytes: &[u8]) -> String {
    let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    String::from_utf8(bytes[20..end].to_vec()).unwrap().trim_end().to_owned()
}

fn points(document: &Gltf, blob: &[u8], mesh: &gltf::Mesh<'_>) -> WrittenHull {
    let primitive = mesh.primitives().next().unwrap();
    assert_eq!((mesh.primitives().len(), primitive.mode()), (1, gltf::mesh::Mode::Triangles));
    assert_eq!(document.buffers().len(), 1);
    let reader = primitive.reader(|_| Some(blob));
    let points: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let bounds = primitive.bounding_box();
    for axis in 0..3 {
        let of_axis = points.iter().map(|point| point[axis]);
        assert_eq!(of_axis.clone().reduce(f32::min), Some(bounds.min[axis]));
        assert_eq!(of_axis.reduce(f32::max), Some(bounds.max[axis]));
    }
    assert!(primitive.material().name().unwrap().starts_with("hullwright_hull_"));
    let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    WrittenHull { points, triangles: corners.as_chunks().0.to_vec() }
}

/// The group below a node, and the nodes that hold its hulls' meshes.
fn group<'a>(document: &'a Gltf, node: &Node<'a>) -> (Node<'a>, HullsRecord, Vec<Node<'a>>) {
    let group = node.children().last().unwrap();
    let record = HullsRecord::from_extras(group.extras().as_ref().unwrap().get()).unwrap().unwrap();
    let shown = |hull: Node<'a>| {
        let Some(physics) = hull.extension_value("KHR_physics_rigid_bodies") else { return hull };
        let geometry = &physics["collider"]["geometry"];
        assert_eq!((hull.mesh().map(|_| ()), &geometry["convexHull"]), (None, &json!(true)));
        document.nodes().nth(geometry["node"].as_u64().unwrap() as usize).unwrap()
    };
    let shown = group.children().map(shown).collect();
    (group, record, shown)
}

#[test]
fn another_reader_finds_the_hulls_of_each_mesh_at_the_nodes_that_show_it() {
    for form in FORMS {
        let original = asset("props");
        let bytes = bake(&original, form);
        let file = Gltf::from_slice(&bytes).unwrap();
        let blob = file.blob.clone().unwrap();
        let used: Vec<&str> = file.extensions_used().collect();
        match form {
            HullForm::Physics => {
                assert_eq!(used, ["KHR_physics_rigid_bodies", "KHR_implicit_shapes"]);
            }
            _ => assert!(used.is_empty()),
        }
        assert_eq!(file.extensions_required().count(), 0);
        let mut hulls_found = 0;
        for job in jobs(&original) {
            let baked = job.run(&Control::new()).unwrap();
            for index in &job.gltf_nodes {
                let node = file.nodes().nth(*index as usize).unwrap();
                let name = node.name().unwrap();
                let (group, record, shown) = group(&file, &node);
                assert_eq!(group.name(), Some(format!("{name}_hulls").as_str()));
                for (number, hull) in group.children().enumerate() {
                    let expected = match form {
                        HullForm::Physics => format!("{name}_hull_{number:02}"),
                        _ => format!("UCX_{name}_{number:02}"),
                    };
                    assert_eq!(hull.name(), Some(expected.as_str()));
                    assert_eq!(hull.transform().matrix(), Node::transform(&group).matrix());
                }
                let hulls: Vec<WrittenHull> =
                    shown.iter().map(|of| points(&file, &blob, &of.mesh().unwrap())).collect();
                let expected: Vec<WrittenHull> = baked
                    .hulls
                    .hulls
                    .iter()
                    .map(|hull| WrittenHull::of(&hull.shape).unwrap())
                    .collect();
                assert_eq!(hulls, expected);
                assert_eq!(record, HullsRecord::new(&baked, &hulls));
                let read = record.read_back(name, &hulls).unwrap();
                assert!(!read.edited && read.left_out.is_empty());
                let read = read.baked;
                assert_eq!((read.hash, &read.parameters), (baked.hash, &baked.parameters));
                // As a file of hulls would hold them, but the hulls, which are in single precision.
                let mut kept = HullsFile::from_bytes(&baked.hulls.to_bytes().unwrap()).unwrap();
                (kept.name, kept.hulls) = (name.to_owned(), read.hulls.hulls.clone());
                assert_eq!(read.hulls, kept);
                hulls_found += hulls.len();
            }
        }
        assert!(hulls_found > 30);
        // Nothing draws a collider: its shape is in no scene.
        let in_scenes = file.scenes().flat_map(|scene| scene.nodes());
        let mut open: Vec<Node<'_>> = in_scenes.collect();
        let mut drawn = 0;
        while let Some(node) = open.pop() {
            drawn += usize::from(node.mesh().is_some());
            open.extend(node.children());
        }
        let expected = if form == HullForm::Physics { 9 } else { 9 + hulls_found };
        assert_eq!(drawn, expected);
    }
}

#[test]
fn colours_are_shared_by_all_meshes() {
    let (document, _) = parts(&bake(&asset("props"), HullForm::Physics)).into_owned();
    let names: Vec<&str> = document["materials"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|material| material["name"].as_str())
        .filter(|name| name.starts_with("hullwright"))
        .collect();
    let unique: BTreeSet<&&str> = names.iter().collect();
    assert_eq!(unique.len(), names.len());
    // As many as the mesh with the most hulls has.
    let most = found(&bake(&asset("props"), HullForm::Physics));
    let most = most.iter().map(|found| found.baked.as_ref().unwrap().hulls.hulls.len()).max();
    assert_eq!(Some(names.len()), most);
}

trait IntoOwned {
    fn into_owned(self) -> (Value, Vec<u8>);
}

impl IntoOwned for (Value, &[u8]) {
    fn into_owned(self) -> (Value, Vec<u8>) {
        (self.0, self.1.to_vec())
    }
}

/// What stands in both documents, of arrays the beginning: the original must be left.
fn without_what_was_added(mut written: Value, original: &Value) -> Value {
    let root = written.as_object_mut().unwrap();
    let keys: Vec<String> = root.keys().cloned().collect();
    for key in keys {
        let Some(before) = original.get(&key) else {
            root.shift_remove(&key);
            continue;
        };
        if let (Some(array), Some(before)) = (root[&key].as_array_mut(), before.as_array()) {
            array.truncate(before.len());
        }
    }
    let nodes = root["nodes"].as_array_mut().unwrap();
    let count = nodes.len() as u64;
    for (node, before) in nodes.iter_mut().zip(original["nodes"].as_array().unwrap()) {
        let node: &mut Map<String, Value> = node.as_object_mut().unwrap();
        if before.get("children").is_none() {
            node.shift_remove("children");
        } else if let Some(children) = node["children"].as_array_mut() {
            children.retain(|child| child.as_u64().unwrap() < count);
        }
    }
    if let Some(buffer) = root.get_mut("buffers").and_then(|buffers| buffers.get_mut(0)) {
        buffer["byteLength"] = original["buffers"][0]["byteLength"].clone();
    }
    written
}

#[test]
fn all_else_of_the_file_stays_as_it_was() {
    let odd = changed(&asset("props"), |document| {
        document["extensionsUsed"] = json!(["EXT_unknown", "KHR_implicit_shapes"]);
        document["extensions"] =
            json!({"EXT_unknown": {"z": [1.0, 0.1, 1e-7], "a": null, "n": -0.0}});
        document["nodes"][1]["extras"]["zeta"] = json!({"b": 1, "a": [true, "ß\n"]});
        document["nodes"][1]["extensions"] = json!({"EXT_unknown": {}});
        document["extras"] = json!({"number": 0.30000000000000004, "big": u64::MAX});
    });
    // A chunk of someone else's.
    let other = [&8_u32.to_le_bytes(), &b"XTRA"[..], b"anything"].concat();
    let mut odd = [odd, other.clone()].concat();
    let length = odd.len() as u32;
    odd[8..12].copy_from_slice(&length.to_le_bytes());
    let end = odd.len() - other.len();
    let (before, chunk) = parts(&odd[..end]);
    for form in FORMS {
        let bytes = bake(&odd, form);
        assert_eq!(bytes[8..12], (bytes.len() as u32).to_le_bytes());
        assert!(bytes.ends_with(&other));
        let (after, binary) = parts(&bytes[..bytes.len() - other.len()]);
        assert!(binary.starts_with(chunk));
        assert_eq!(without_what_was_added(after, &before).to_string(), before.to_string());
        // And all of it is still so after other hulls.
        let again = bake_by(&bytes, form, coarse());
        assert!(again.ends_with(&other) && again != bytes);
        let (after, binary) = parts(&again[..again.len() - other.len()]);
        assert!(binary.starts_with(chunk));
        assert_eq!(without_what_was_added(after, &before).to_string(), before.to_string());
    }
}

#[test]
fn the_same_again_gives_the_same_bytes_and_makes_nothing_anew() {
    for name in ["l_prism", "props", "chair"] {
        for form in FORMS {
            let bytes = bake(&asset(name), form);
            for found in found(&bytes) {
                assert!(found.baked.is_some() && found.edited.is_empty());
            }
            assert_eq!(bake(&bytes, form), bytes);
            // Also where all is made anew.
            let file = HullsInFile::from_bytes(&bytes).unwrap();
            let jobs = jobs(&bytes);
            let anew = jobs.iter().map(|job| MeshHulls {
                nodes: &job.gltf_nodes,
                baked: job.run(&Control::new()).unwrap(),
            });
            assert_eq!(file.write(form, &anew.collect::<Vec<_>>()).unwrap(), bytes);
        }
    }
}

#[test]
fn other_parameters_and_the_other_form_replace_what_was_written_and_the_file_does_not_grow() {
    let original = asset("props");
    let [physics, ucx] = FORMS.map(|form| bake(&original, form));
    assert_ne!(physics, ucx);
    assert_eq!(bake(&physics, HullForm::Ucx), ucx);
    assert_eq!(bake(&ucx, HullForm::Physics), physics);
    let coarser = bake_by(&physics, HullForm::Physics, coarse());
    assert_eq!(coarser, bake_by(&original, HullForm::Physics, coarse()));
    assert!(coarser.len() < physics.len());
    assert_eq!(bake(&coarser, HullForm::Physics), physics);
    // Hulls of meshes that get none any more are taken out.
    let file = HullsInFile::from_bytes(&physics).unwrap();
    let none = file.write(HullForm::Physics, &[]).unwrap();
    assert_eq!(json_text(&none), json_text(&original));
    assert_eq!(parts(&none), parts(&original));
}

#[test]
fn nodes_that_show_one_mesh_share_its_hulls() {
    let original = asset("chair");
    let nodes = jobs(&original)[0].gltf_nodes.clone();
    assert!(nodes.len() > 3 && jobs(&original).len() == 1);
    for form in FORMS {
        let bytes = bake(&original, form);
        let file = Gltf::from_slice(&bytes).unwrap();
        let (first, _, shown) = group(&file, &file.nodes().nth(nodes[0] as usize).unwrap());
        let meshes =
            |shown: &[Node<'_>]| shown.iter().map(|node| node.mesh().unwrap().index()).collect();
        let first_meshes: Vec<usize> = meshes(&shown);
        for node in &nodes[1..] {
            let (other, _, others) = group(&file, &file.nodes().nth(*node as usize).unwrap());
            assert_ne!(other.index(), first.index());
            assert_eq!(meshes(&others), first_meshes);
            if form == HullForm::Physics {
                assert_eq!(others[0].index(), shown[0].index());
            }
        }
        assert_eq!(file.meshes().len(), 1 + shown.len());
    }
}

/// Doubles the height of the first hull of the first mesh.
fn edit(bytes: &[u8]) -> Vec<u8> {
    let (document, chunk) = parts(bytes);
    let hull = document["meshes"].as_array().unwrap().iter().find(|mesh| {
        let name = mesh["name"].as_str().unwrap_or_default();
        name.starts_with("UCX_") && name.ends_with("_00") || name.ends_with("_hull_00")
    });
    let accessor = hull.unwrap()["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap();
    let accessor = &document["accessors"][accessor as usize];
    let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let offset = |of: &Value| of["byteOffset"].as_u64().unwrap_or_default() as usize;
    let start = offset(accessor) + offset(view);
    let mut chunk = chunk.to_vec();
    for point in 0..accessor["count"].as_u64().unwrap() as usize {
        let y = &mut chunk[start + 12 * point + 4..][..4];
        let doubled = 2.0 * f32::from_le_bytes(y.try_into().unwrap());
        y.copy_from_slice(&doubled.to_le_bytes());
    }
    glb(&document, &chunk)
}

#[test]
fn hulls_that_were_edited_by_hand_stay_whatever_is_written() {
    for form in FORMS {
        let edited = edit(&bake(&asset("props"), form));
        let seen = found(&edited);
        let by_hand: Vec<&FoundHulls> =
            seen.iter().filter(|found| !found.edited.is_empty()).collect();
        let [FoundHulls { baked: None, edited: by_hand, open_nodes: 0, .. }] = by_hand[..] else {
            panic!("{by_hand:?}");
        };
        let read = by_hand[0].read.as_ref().unwrap();
        assert!(read.edited && !by_hand[0].mesh_changed && read.baked.hulls.verified.is_none());
        assert_eq!(bake(&edited, form), edited);

        // Other hulls are replaced, those stay, as does all that stands before what is added.
        for (form, method) in [(form, coarse()), (FORMS[0], coarse()), (FORMS[1], coarse())] {
            let again = bake_by(&edited, form, method);
            let [(before, chunk), (after, binary)] = [parts(&edited), parts(&again)];
            assert!(binary.starts_with(chunk));
            for name in ["meshes", "accessors", "bufferViews", "materials"] {
                let [before, after] =
                    [&before, &after].map(|document| document[name].as_array().unwrap());
                assert_eq!(after[..before.len()], before[..]);
            }
            let still = found(&again);
            let still = still.iter().flat_map(|found| &found.edited).collect::<Vec<_>>();
            assert_eq!(still, by_hand.iter().collect::<Vec<_>>());
            // And what was cut off is nobody's mesh.
            assert_eq!(jobs(&again).len(), jobs(&edited).len());
            assert_eq!(triangles(&again), triangles(&edited));
        }
    }
}

#[test]
fn a_mesh_that_changed_under_edited_hulls_is_said() {
    let edited = edit(&bake(&asset("l_prism"), HullForm::Ucx));
    let moved = |bytes: &[u8]| {
        let (document, chunk) = parts(bytes);
        let mut chunk = chunk.to_vec();
        // The first coordinate of the mesh.
        chunk[..4].copy_from_slice(&0.125_f32.to_le_bytes());
        glb(&document, &chunk)
    };
    assert!(found(&moved(&edited))[0].edited[0].mesh_changed);
    // Hulls that nobody edited are made anew.
    let stale = moved(&bake(&asset("l_prism"), HullForm::Ucx));
    assert_eq!((found(&stale)[0].baked.clone(), found(&stale)[0].open_nodes), (None, 1));
    assert_eq!(bake(&stale, HullForm::Ucx), bake(&moved(&asset("l_prism")), HullForm::Ucx));
}

#[test]
fn a_group_without_hulls_is_written_anew() {
    let bytes = bake(&asset("l_prism"), HullForm::Physics);
    let lost = changed(&bytes, |document| {
        for node in document["nodes"].as_array_mut().unwrap() {
            node.as_object_mut().unwrap().shift_remove("extensions");
        }
    });
    let seen = &found(&lost)[0];
    assert_eq!((seen.baked.is_none(), seen.edited.len(), seen.open_nodes), (true, 0, 1));
    let again = bake(&lost, HullForm::Physics);
    assert!(found(&again)[0].baked.is_some());
    assert_eq!(bake(&again, HullForm::Physics), again);
}

#[test]
fn a_node_with_a_collider_of_its_own_gets_no_hulls() {
    for extension in [
        json!({"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 0}}}}),
        json!({"KHR_physics_rigid_bodies": {"trigger": {"geometry": {"shape": 0}}}}),
        json!({"OMI_physics_body": {"collider": {"shape": 0}}}),
        json!({"OMI_physics_body": {"trigger": {"shape": 0}}}),
    ] {
        let bytes = changed(&asset("l_prism"), |document| {
            document["nodes"][0]["extensions"] = extension;
        });
        assert_eq!(found(&bytes)[0].with_collider, ["l_prism"]);
        assert_eq!(bake(&bytes, HullForm::Physics), bytes);
    }
    // A body that moves is no collider.
    let bytes = changed(&asset("l_prism"), |document| {
        document["nodes"][0]["extensions"] = json!({"KHR_physics_rigid_bodies": {"motion": {}}});
    });
    assert_eq!(found(&bytes)[0].open_nodes, 1);
}

fn triangles(bytes: &[u8]) -> usize {
    read_mesh_from_bytes(Format::Gltf, bytes).unwrap().mesh.triangles.len()
}

#[test]
fn hulls_in_a_file_are_no_part_of_its_mesh_and_no_meshes_of_their_own() {
    for form in FORMS {
        let original = asset("props");
        let bytes = bake(&original, form);
        let whole = |bytes: &[u8]| read_mesh_from_bytes(Format::Gltf, bytes).unwrap();
        assert_eq!(whole(&bytes), whole(&original));
        // Also where no scene says what is drawn.
        let without_scenes = |bytes: &[u8]| {
            changed(bytes, |document| {
                let document = document.as_object_mut().unwrap();
                document.shift_remove("scene");
                document.shift_remove("scenes");
            })
        };
        assert_eq!(triangles(&without_scenes(&bytes)), triangles(&without_scenes(&original)));
        let scene = read_scene_from_bytes(&bytes).unwrap();
        assert_eq!(scene.len(), read_scene_from_bytes(&original).unwrap().len());
        assert!(scene.iter().flat_map(|mesh| &mesh.nodes).any(|node| node.has_hulls));
        assert_eq!(jobs(&bytes), jobs(&original));
        // Their hulls are in the file already, so that no second file needs them.
        assert_eq!(bake_jobs(scene, &BakeOptions::default()), []);
    }
}

#[test]
fn text_files_keep_their_buffers_and_their_indentation() {
    let (mut document, chunk) = parts(&asset("props")).into_owned();
    document["buffers"][0]["uri"] = json!("props.bin");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("props.gltf");
    let mut text = Vec::new();
    let formatter = serde_json::ser::PrettyFormatter::with_indent(b"\t");
    let mut serializer = serde_json::Serializer::with_formatter(&mut text, formatter);
    serde::Serialize::serialize(&document, &mut serializer).unwrap();
    text.push(b'\n');
    std::fs::write(directory.path().join("props.bin"), &chunk).unwrap();
    for form in FORMS {
        std::fs::write(&path, &text).unwrap();
        let bake = |method: Method| {
            let file = HullsInFile::read(&path).unwrap();
            assert_eq!(file.other_files().collect::<Vec<_>>(), ["props.bin"]);
            let options = BakeOptions::new(method).with_written(true);
            let meshes = hullwright_formats::read_scene(&path).unwrap();
            let bytes = write(&file, form, &bake_jobs(meshes, &options));
            std::fs::write(&path, &bytes).unwrap();
            bytes
        };
        let first = bake(Method::default());
        let after: Value = serde_json::from_slice(&first).unwrap();
        let as_text = std::str::from_utf8(&first).unwrap();
        assert!(as_text.starts_with("{\n\t\"asset\"") && as_text.ends_with("}\n"));
        assert_eq!(after["buffers"].as_array().unwrap().len(), 2);
        assert_eq!(without_what_was_added(after, &document).to_string(), document.to_string());
        assert!(Gltf::from_slice(&first).unwrap().buffers().count() == 2);
        assert_eq!(bake(Method::default()), first);
        assert_ne!(bake(coarse()), first);
        assert_eq!(bake(Method::default()), first);
        let file = HullsInFile::read(&path).unwrap();
        assert_eq!(file.write(form, &[]).unwrap(), text);
    }
    assert_eq!(std::fs::read(directory.path().join("props.bin")).unwrap(), chunk);
}

#[test]
fn a_glb_without_binary_data_of_its_own_gets_a_buffer() {
    let (mut document, chunk) = parts(&asset("l_prism")).into_owned();
    let base64 = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &chunk);
    document["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{base64}"));
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((20 + json.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(&json);
    for form in FORMS {
        let first = bake(&bytes, form);
        let end = 20 + u32::from_le_bytes(first[12..16].try_into().unwrap()) as usize;
        assert_eq!(end, first.len(), "no chunk is added");
        let after: Value = serde_json::from_str(&json_text(&first)).unwrap();
        assert_eq!(after["buffers"][0], document["buffers"][0]);
        assert_eq!(after["buffers"].as_array().unwrap().len(), 2);
        assert!(found(&first)[0].baked.is_some());
        assert_eq!(bake(&first, form), first);
        assert_eq!(bake(&bake_by(&first, form, coarse()), form), first);
    }
}

#[test]
fn what_someone_added_later_is_not_shifted() {
    let first = bake(&asset("l_prism"), HullForm::Physics);
    let count = parts(&first).0["nodes"].as_array().unwrap().len();
    let changes: [&dyn Fn(&mut Value); 3] = [
        // Something that refers to a hull, something after the hulls, and another name.
        &|document| document["animations"] = json!([{"channels": [{"sampler": 0, "target": {"node": count - 1, "path": "scale"}}], "samplers": [{"input": 0, "output": 0}]}]),
        &|document| document["nodes"].as_array_mut().unwrap().push(json!({"name": "late"})),
        &|document| document["nodes"][count - 1]["name"] = json!("hulls of a letter"),
    ];
    for change in changes {
        let later = changed(&first, change);
        assert_eq!(bake(&later, HullForm::Physics), later);
        let again = bake_by(&later, HullForm::Physics, coarse());
        let [(before, chunk), (after, binary)] = [parts(&later), parts(&again)];
        assert!(binary.starts_with(chunk));
        for name in ["nodes", "meshes", "accessors", "bufferViews"] {
            let [before, after] = [&before, &after].map(|of| of[name].as_array().unwrap());
            assert_eq!(after[1..before.len()], before[1..], "{name}");
            assert!(after.len() > before.len());
        }
        assert_eq!(after.get("animations"), before.get("animations"));
        assert_eq!(triangles(&again), triangles(&first));
    }
}

#[test]
fn hulls_of_another_version_of_the_method_are_made_anew() {
    let first = bake(&asset("l_prism"), HullForm::Physics);
    let older = changed(&first, |document| {
        let nodes = document["nodes"].as_array_mut().unwrap();
        nodes.last_mut().unwrap()["extras"]["hullwright"]["algorithm_version"] = json!(1);
    });
    assert_eq!(found(&older)[0].baked, None);
    assert_eq!(bake(&older, HullForm::Physics), first);
}

#[test]
fn a_name_of_a_mesh_or_a_number_stands_in_for_a_missing_name() {
    for (mesh, expected) in [(json!("prism"), "prism"), (Value::Null, "node_0")] {
        let bytes = changed(&asset("l_prism"), |document| {
            document["nodes"][0].as_object_mut().unwrap().shift_remove("name");
            document["meshes"][0]["name"] = mesh;
        });
        let after = bake(&bytes, HullForm::Ucx);
        let names: Vec<String> = parts(&after).0["nodes"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|node| node["name"].as_str().map(str::to_owned))
            .collect();
        assert!(names.contains(&format!("UCX_{expected}_00")), "{names:?}");
        assert!(names.contains(&format!("{expected}_hulls")), "{names:?}");
    }
}

/// Documents with groups that are not as they should be.
#[test]
fn hostile_groups_are_refused_or_read_but_never_panic() {
    let sound = bake(&asset("l_prism"), HullForm::Physics);
    let (document, _) = parts(&sound);
    let nodes = document["nodes"].as_array().unwrap().len();
    let group = nodes - 1;
    let hull = nodes - 2;
    type Change<'a> = &'a dyn Fn(&mut Value);
    let geometry = |document: &mut Value, node: Value| {
        document["nodes"][hull]["extensions"]["KHR_physics_rigid_bodies"]["collider"]["geometry"]
            ["node"] = node;
    };
    let refused: [Change; 7] = [
        &|document| geometry(document, json!("a")),
        &|document| geometry(document, json!(-1)),
        &|document| document["nodes"][hull]["children"] = json!(3),
        &|document| document["nodes"][hull]["scale"] = json!([1]),
        &|document| document["meshes"][1]["primitives"][0]["indices"] = json!(99),
        &|document| document["meshes"][1]["primitives"][0]["attributes"]["POSITION"] = json!(99),
        &|document| document["nodes"][0]["mesh"] = json!("a"),
    ];
    for change in refused {
        let bytes = changed(&sound, change);
        match HullsInFile::from_bytes(&bytes) {
            Err(error) => assert!(matches!(error, Error::File { .. }), "{error}"),
            Ok(file) => drop(file.write(HullForm::Physics, &[])),
        }
    }
    let read: [Change; 12] = [
        &|document| geometry(document, json!(u32::MAX)),
        &|document| geometry(document, json!(group)),
        &|document| geometry(document, json!(0)),
        &|document| document["nodes"][hull]["children"] = json!([group, hull, 0, 9999]),
        &|document| document["nodes"][group]["children"] = json!([0, group, hull, hull]),
        &|document| document["nodes"][group]["children"] = json!([]),
        &|document| document["nodes"][group]["extras"]["hullwright"] = json!(null),
        &|document| document["nodes"][group]["extras"]["hullwright"] = json!({"hulls": 1}),
        &|document| document["nodes"][group]["extras"]["hullwright"]["hulls"] = json!([]),
        &|document| document["nodes"][group]["extras"]["hullwright"]["diagonal"] = json!(-1e300),
        &|document| document["nodes"][0]["extras"] = json!({"hullwright": {}}),
        &|document| document["scenes"][0]["nodes"] = json!([group, 0]),
    ];
    for (number, change) in read.into_iter().enumerate() {
        let bytes = changed(&sound, change);
        let file = HullsInFile::from_bytes(&bytes).unwrap();
        let _ = read_mesh_from_bytes(Format::Gltf, &bytes);
        if read_scene_from_bytes(&bytes).is_err() {
            continue;
        }
        for job in jobs(&bytes) {
            let _ = file.found(&job);
        }
        for form in FORMS {
            let written = bake(&bytes, form);
            assert!(HullsInFile::from_bytes(&written).is_ok(), "{number}");
            let _ = bake_by(&written, form, coarse());
        }
    }
}

#[test]
fn a_hull_that_is_placed_without_end_is_refused() {
    let sound = bake(&asset("mug"), HullForm::Ucx);
    let bytes = changed(&sound, |document| {
        let nodes = document["nodes"].as_array_mut().unwrap();
        let (group, first) = (nodes.len() - 1, nodes.len());
        // Its hulls are the whole mesh, of 776 vertices.
        nodes.extend(std::iter::repeat_n(json!({"mesh": 0}), 10_000));
        nodes[group]["children"] = (first..nodes.len()).collect();
    });
    let error = HullsInFile::from_bytes(&bytes).map(drop).unwrap_err();
    assert!(error.to_string().contains("placed here once more"), "{error}");
}

#[test]
fn nodes_and_documents_that_are_none_are_errors() {
    let bytes = asset("l_prism");
    let job = &jobs(&bytes)[0];
    let baked = job.run(&Control::new()).unwrap();
    let file = HullsInFile::from_bytes(&bytes).unwrap();
    let beyond = [MeshHulls { nodes: &[0, 7], baked: baked.clone() }];
    let error = file.write(HullForm::Physics, &beyond).map(drop).unwrap_err();
    assert!(error.to_string().contains("no node 7"), "{error}");
    for (key, value) in [
        ("materials", json!(3)),
        ("extensionsUsed", json!({})),
        ("nodes", json!([{"mesh": 0, "children": 1}])),
        ("buffers", json!([{"byteLength": 99_999_999}])),
    ] {
        let bytes = changed(&bytes, |document| document[key] = value);
        let Ok(file) = HullsInFile::from_bytes(&bytes) else { continue };
        let mesh = [MeshHulls { nodes: &[0], baked: baked.clone() }];
        let error = file.write(HullForm::Physics, &mesh).map(drop).unwrap_err();
        assert!(matches!(error, Error::File { .. }), "{key}: {error}");
    }
    for none in [&b""[..], b"glTF", b"{}", b"o mesh\n", b"{\"asset\": {\"version\": \"1.0\"}}"] {
        assert!(HullsInFile::from_bytes(none).is_err());
    }
    assert!(HullsInFile::read("missing.glb").is_err());
    // Beyond single precision there is no hull to write.
    let mut large = baked;
    large.hulls.hulls[0].shape.points[0] = [1e300; 3];
    let large = [MeshHulls { nodes: &[0], baked: large }];
    assert!(matches!(file.write(HullForm::Physics, &large), Err(Error::NoHull { .. })));
    assert_eq!(MeshHash::of(&job.mesh), MeshHash::of(&jobs(&bytes)[0].mesh));
}
