//! What hulls are made of, from a glTF file to a `.hulls` or `.hullscene` file.

use std::path::PathBuf;

use hullwright::hulls_format::{HullScene, HullsFile, MeshPart};
use hullwright::{Control, Hull, Parameters, PartShare, decompose};
use hullwright_formats::bake::{BakeOptions, bake_jobs};
use hullwright_formats::{
    Format, MeshFile, read_mesh_from_bytes, read_scene, read_scene_from_bytes,
};
use serde_json::{Value, json};

use crate::glb::glb;

/// A box, as eight vertices and twelve triangles.
fn cuboid([low, high]: [[f32; 3]; 2]) -> (Vec<[f32; 3]>, Vec<[u16; 3]>) {
    let corner = |index: usize| {
        std::array::from_fn(|axis| if index >> axis & 1 == 0 { low[axis] } else { high[axis] })
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    ((0..8).map(corner).collect(), triangles.collect())
}

/// Two boxes apart: `left` of oak, `right` of steel with a top of rubber, which has a fifth of its
/// area. The materials of `right` stand before the one of `left`.
fn boxes() -> (Value, Vec<u8>) {
    let (mut positions, mut triangles) = cuboid([[2.0, 0.0, 0.0], [4.0, 1.0, 1.0]]);
    // The two at the greatest z are the second side.
    let (top, rest) = (triangles[2..4].to_vec(), [&triangles[..2], &triangles[4..]].concat());
    let (left_positions, left) = cuboid([[0.0; 3], [1.0; 3]]);
    positions.extend(left_positions);
    let left: Vec<[u16; 3]> = left.iter().map(|triangle| triangle.map(|v| v + 8)).collect();
    let counts = [rest.len(), top.len(), left.len()];
    triangles = [rest, top, left].concat();
    let mut chunk: Vec<u8> =
        positions.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    chunk.extend(triangles.as_flattened().iter().flat_map(|index| index.to_le_bytes()));
    let mut offset = 0;
    let mut accessors = vec![
        json!({ "bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3" }),
    ];
    for count in counts {
        accessors.push(json!({
            "bufferView": 1, "byteOffset": offset, "componentType": 5123, "count": 3 * count,
            "type": "SCALAR",
        }));
        offset += 6 * count;
    }
    let primitive = |indices: u32, material: u32| json!({ "attributes": { "POSITION": 0 }, "indices": indices, "material": material });
    let mut points = primitive(1, 0);
    points["mode"] = 0.into();
    let document = json!({
        "asset": { "version": "2.0" },
        "nodes": [{ "mesh": 1, "name": "a" }, { "mesh": 0, "name": "b" }],
        "meshes": [
            { "name": "right", "primitives": [points, primitive(1, 0), primitive(2, 1)] },
            { "name": "left", "primitives": [primitive(3, 2)] },
        ],
        "materials": [{ "name": "steel" }, { "name": "rubber" }, { "name": "oak" }],
        "accessors": accessors,
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 12 * positions.len() },
            { "buffer": 0, "byteOffset": 12 * positions.len(), "byteLength": offset },
        ],
        "buffers": [{ "byteLength": chunk.len() }],
    });
    (document, chunk)
}

fn steel() -> MeshPart {
    MeshPart::new("right", 1, "steel")
}

fn rubber() -> MeshPart {
    MeshPart::new("right", 2, "rubber")
}

fn oak() -> MeshPart {
    MeshPart::new("left", 0, "oak")
}

fn read((document, chunk): &(Value, Vec<u8>)) -> MeshFile {
    read_mesh_from_bytes(Format::Gltf, &glb(document, chunk)).unwrap()
}

fn hulls_of(file: &MeshFile) -> HullsFile {
    let made = decompose(file, &Parameters::default(), &Control::new()).unwrap();
    let shares = file.parts.shares(file, &made.hulls).unwrap();
    HullsFile::new("boxes", &made).with_parts(file.parts.list.clone(), shares)
}

/// The shares of the hull around x, by their materials.
fn made_of(hulls: &HullsFile, x: f64) -> Vec<(&str, f64)> {
    let is_around = |hull: &Hull| {
        let points = || hull.shape.points.iter().map(|point| point[0]);
        points().any(|other| other < x) && points().any(|other| other > x)
    };
    let hull = hulls.hulls.iter().position(is_around).unwrap();
    let named = |share: &PartShare| {
        let material = hulls.parts[share.part as usize].material.as_str();
        (material, (share.share * 1e6).round() / 1e6)
    };
    hulls.shares(hull).iter().map(named).collect()
}

#[test]
fn hulls_of_a_gltf_file_know_their_primitives_and_materials() {
    let file = read(&boxes());
    // In the order of the nodes.
    assert_eq!(file.parts.list, [oak(), steel(), rubber()]);
    let counts: Vec<usize> =
        file.parts.of_triangles.chunk_by(|a, b| a == b).map(<[_]>::len).collect();
    assert_eq!((counts, file.parts.of_triangles[0]), (vec![12, 10, 2], 0));
    let hulls = hulls_of(&file);
    let hulls = HullsFile::from_bytes(&hulls.to_bytes().unwrap()).unwrap();
    assert_eq!(made_of(&hulls, 0.5), [("oak", 1.0)]);
    assert_eq!(made_of(&hulls, 3.0), [("steel", 0.8), ("rubber", 0.2)]);
}

#[test]
fn a_mesh_that_is_placed_many_times_has_its_parts_once() {
    let (mut document, chunk) = boxes();
    let mirrored = json!({ "mesh": 1, "translation": [0, 0, 9], "scale": [1, 1, -1] });
    document["nodes"] = json!([{ "mesh": 1 }, { "mesh": 0 }, mirrored]);
    let file = read(&(document, chunk));
    assert_eq!(file.parts.list, [oak(), steel(), rubber()]);
    assert_eq!(file.parts.of_triangles[24..], [0; 12]);
    let hulls = hulls_of(&file);
    assert_eq!(hulls.hulls.len(), 3);
    assert_eq!((0..3).filter(|hull| hulls.part(*hull) == Some(&oak())).count(), 2);
}

#[test]
fn baked_meshes_know_their_own_parts() {
    let (document, chunk) = boxes();
    let meshes = read_scene_from_bytes(&glb(&document, &chunk)).unwrap();
    assert_eq!(meshes[0].parts.list, [steel(), rubber()]);
    assert_eq!(meshes[1].parts.list, [oak()]);
    assert_eq!(meshes[1].parts.of_triangles, [0; 12]);
    let jobs = bake_jobs(meshes, &BakeOptions::default());
    let baked = jobs.iter().map(|job| job.run(&Control::new()).unwrap()).collect();
    let scene = HullScene::new("boxes", baked);
    let scene = HullScene::from_bytes(&scene.to_bytes().unwrap()).unwrap();
    assert_eq!(made_of(&scene.meshes[0].hulls, 3.0), [("steel", 0.8), ("rubber", 0.2)]);
    assert_eq!(made_of(&scene.meshes[1].hulls, 0.5), [("oak", 1.0)]);
}

#[test]
fn of_meshes_with_the_same_content_the_first_has_its_parts_baked() {
    let (mut document, chunk) = boxes();
    let mut other = document["meshes"][1].clone();
    (other["name"], other["primitives"][0]["material"]) = ("copy".into(), 0.into());
    document["meshes"].as_array_mut().unwrap().push(other);
    let meshes = read_scene_from_bytes(&glb(&document, &chunk)).unwrap();
    assert_eq!(meshes[2].parts.list, [MeshPart::new("copy", 0, "steel")]);
    let jobs = bake_jobs(meshes, &BakeOptions::default());
    assert_eq!(jobs.len(), 2);
    assert_eq!((&jobs[1].gltf_meshes[..], &jobs[1].parts.list[..]), (&[1, 2][..], &[oak()][..]));
}

#[test]
fn what_has_no_name_is_called_after_its_number_and_a_name_without_end_is_cut() {
    let (mut document, chunk) = boxes();
    document["meshes"][0]["name"] = Value::Null;
    document["meshes"][1]["name"] = "ä".repeat(1000).into();
    document["materials"] = Value::Null;
    let file = read(&(document, chunk));
    let number = |number| MeshPart::new("mesh_0", number, "");
    assert_eq!(file.parts.list, [MeshPart::new("ä".repeat(128), 0, ""), number(1), number(2)]);
}

#[test]
fn files_that_say_nothing_of_parts_give_hulls_without_any() {
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
               endloop\nendfacet\nendsolid a\n";
    let file = read_mesh_from_bytes(Format::Stl, stl.as_bytes()).unwrap();
    assert_eq!(file.parts, Default::default());
    let hulls = hulls_of(&file);
    assert_eq!((hulls.parts.len(), hulls.part_shares.len()), (0, 0));
}

/// The bundled models, baked.
fn bundled() -> Vec<HullScene> {
    let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets");
    let paths = std::fs::read_dir(assets).unwrap().map(|entry| entry.unwrap().path());
    let is_model = |path: &PathBuf| Format::from_path(path) == Some(Format::Gltf);
    let bake = |path: PathBuf| {
        let jobs = bake_jobs(read_scene(&path).unwrap(), &BakeOptions::default());
        let baked = jobs.iter().map(|job| job.run(&Control::new()).unwrap());
        HullScene::new(path.file_stem().unwrap().to_string_lossy(), baked.collect())
    };
    paths.filter(is_model).map(bake).collect()
}

#[test]
fn parts_make_files_of_the_bundled_models_at_most_a_twentieth_larger() {
    let scenes = bundled();
    assert!(scenes.len() > 10);
    for with_parts in scenes {
        let mut without = with_parts.clone();
        let mut pairs = Vec::new();
        for (with, baked) in with_parts.meshes.iter().zip(&mut without.meshes) {
            assert!((0..with.hulls.hulls.len()).all(|hull| with.hulls.part(hull).is_some()));
            baked.hulls = baked.hulls.clone().with_parts(Vec::new(), Vec::new());
            pairs.push((
                with.hulls.to_bytes().unwrap().len(),
                baked.hulls.to_bytes().unwrap().len(),
            ));
        }
        pairs.push((with_parts.to_bytes().unwrap().len(), without.to_bytes().unwrap().len()));
        for (with, without) in pairs {
            let growth = 100.0 * (with as f64 / without as f64 - 1.0);
            println!("{}: {without} bytes, with parts {with}, {growth:.2} % more", with_parts.name);
            assert!(growth <= 5.0, "{}: {growth} %", with_parts.name);
        }
    }
}
