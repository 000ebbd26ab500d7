//! What the writers of hull sets promise.

use std::path::PathBuf;

use hullwright::TriangleMesh;
use hullwright_formats::palette::{colour, linear};
use hullwright_formats::{
    NamedMesh, check_mesh_output, check_output, read_hulls, read_mesh, write_hulls, write_meshes,
};

use crate::glb::parts;

pub fn tetrahedron(corner: [f64; 3], size: f64) -> NamedMesh {
    let [x, y, z] = corner;
    NamedMesh {
        name: String::new(),
        mesh: TriangleMesh::new(
            vec![corner, [x + size, y, z], [x, y + size, z], [x, y, z + size]],
            vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ),
    }
}

/// A folder, and a file in it that hulls have been written to.
fn written(name: &str, hulls: &[NamedMesh]) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    write_hulls(&path, hulls).unwrap();
    (directory, path)
}

fn two_hulls() -> Vec<NamedMesh> {
    vec![tetrahedron([0.1, -0.2, 1.0 / 3.0], 0.7), tetrahedron([1e-9, 2e5, 3.0], 1e3)]
}

#[test]
fn obj_reads_back_bit_for_bit() {
    let hulls = two_hulls();
    let (_directory, path) = written("hulls.obj", &hulls);
    let back = read_hulls(path).unwrap();
    assert_eq!(back.len(), 2);
    for (index, (hull, back)) in hulls.iter().zip(&back).enumerate() {
        assert_eq!(back.name, format!("hull_{index}"));
        let corners = |hull: &NamedMesh| -> Vec<[f64; 3]> {
            hull.mesh.triangles.iter().flatten().map(|v| hull.mesh.positions[*v as usize]).collect()
        };
        assert_eq!(corners(hull), corners(back));
    }
}

#[test]
fn glb_reads_back_with_names_winding_and_places() {
    let hulls = two_hulls();
    let (_directory, path) = written("hulls.glb", &hulls);
    let file = read_mesh(path).unwrap();
    let names: Vec<&str> = file.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["hull_0", "hull_1"]);
    assert_eq!(file.mesh.triangles[..4], hulls[0].mesh.triangles);
    for (written, read) in
        hulls.iter().flat_map(|hull| &hull.mesh.positions).zip(&file.mesh.positions)
    {
        for axis in 0..3 {
            assert!((written[axis] - read[axis]).abs() < 0.01, "{written:?} {read:?}");
        }
    }
}

#[test]
fn glb_keeps_the_shape_of_hulls_far_from_the_origin() {
    let (_directory, path) = written("far.glb", &[tetrahedron([1e7, -2e7, 3e7], 1.0)]);
    let back = &read_hulls(path).unwrap()[0];
    let corner = back.mesh.positions[0];
    for position in &back.mesh.positions {
        for axis in 0..3 {
            let side = (position[axis] - corner[axis]).abs();
            assert!(side < 1e-6 || (side - 1.0).abs() < 1e-6, "{side}");
        }
    }
}

#[test]
fn glb_states_bounds_and_one_colour_per_hull() {
    let (_directory, path) = written("hulls.glb", &two_hulls());
    let bytes = std::fs::read(path).unwrap();
    let (document, _) = parts(&bytes);
    assert_eq!(bytes.len() % 4, 0);
    assert_eq!(document["asset"]["version"], "2.0");
    for index in 0..2 {
        let accessor = &document["accessors"][2 * index];
        assert_eq!(accessor["type"], "VEC3");
        assert_eq!(accessor["min"].as_array().unwrap().len(), 3);
        assert_eq!(accessor["max"].as_array().unwrap().len(), 3);
        let color = &document["materials"][index]["pbrMetallicRoughness"]["baseColorFactor"];
        for (part, expected) in linear(colour(index)).into_iter().enumerate() {
            // The test's parser may be off in the last place.
            assert_eq!(color[part].as_f64().map(|part| part as f32), Some(expected));
        }
    }
}

#[test]
fn a_set_of_no_hulls_is_a_valid_file_without_triangles() {
    let (_directory, path) = written("none.glb", &[]);
    assert!(read_mesh(&path).unwrap().mesh.triangles.is_empty());
    assert!(read_hulls(&path).unwrap_err().to_string().contains("no hulls"));
}

#[test]
fn a_missing_directory_or_another_suffix_is_an_error_that_says_so() {
    let directory = tempfile::tempdir().unwrap();
    let missing = directory.path().join("missing").join("hulls.obj");
    assert!(check_output(&missing).unwrap_err().to_string().contains("does not exist"));
    assert!(write_hulls(&missing, &two_hulls()).is_err());
    for name in ["hulls.stl", "hulls", "hulls.gltf"] {
        let error = write_hulls(directory.path().join(name), &two_hulls()).unwrap_err();
        assert!(error.to_string().contains(".obj or .glb"), "{error}");
    }
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
}

#[test]
fn a_file_is_replaced_at_once_and_nothing_is_left_beside_it() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("hulls.OBJ");
    std::fs::write(&path, "old").unwrap();
    write_hulls(&path, &two_hulls()).unwrap();
    assert_eq!(read_hulls(&path).unwrap().len(), 2);
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
}

#[test]
fn what_fails_leaves_the_old_file_alone() {
    let (directory, path) = written("hulls.glb", &two_hulls());
    let before = std::fs::read(&path).unwrap();
    let too_large = tetrahedron([0.0; 3], 1e300);
    assert!(write_hulls(&path, [&too_large]).unwrap_err().to_string().contains("32-bit"));
    assert_eq!(std::fs::read(&path).unwrap(), before);

    let taken = directory.path().join("directory.obj");
    std::fs::create_dir(&taken).unwrap();
    assert!(write_hulls(&taken, &two_hulls()).is_err());
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 2);
}

/// The corners of all triangles.
fn corners(mesh: &TriangleMesh) -> Vec<[f64; 3]> {
    mesh.triangles.iter().flatten().map(|vertex| mesh.positions[*vertex as usize]).collect()
}

#[test]
fn meshes_in_text_are_read_back_bit_for_bit() {
    let directory = tempfile::tempdir().unwrap();
    let mut meshes = two_hulls();
    meshes[0].name = "roof of\na house".into();
    meshes[1].name = "floor".into();
    let all: Vec<[f64; 3]> = meshes.iter().flat_map(|named| corners(&named.mesh)).collect();
    for (suffix, names) in [
        ("obj", &["roof of a house", "floor"][..]),
        ("stl", &["roof of a house", "floor"]),
        ("off", &[""]),
        ("PLY", &[""]),
    ] {
        let path = directory.path().join(format!("meshes.{suffix}"));
        check_mesh_output(&path).unwrap();
        write_meshes(&path, &meshes).unwrap();
        let file = read_mesh(&path).unwrap();
        assert_eq!(corners(&file.mesh), all, "{suffix}");
        assert!(file.notes.is_empty(), "{suffix}: {:?}", file.notes);
        let read: Vec<&str> = file.objects.iter().map(|object| object.name.as_str()).collect();
        assert_eq!(read, names, "{suffix}");
    }
}

#[test]
fn meshes_are_not_written_to_other_suffixes_or_missing_directories() {
    let directory = tempfile::tempdir().unwrap();
    for name in ["mesh", "mesh.gltf", "mesh.hulls"] {
        let path = directory.path().join(name);
        let error = write_meshes(&path, &two_hulls()).unwrap_err().to_string();
        assert!(error.contains(".obj, .glb, .off, .ply or .stl"), "{error}");
        assert_eq!(check_mesh_output(&path).unwrap_err().to_string(), error);
    }
    let missing = directory.path().join("missing").join("mesh.ply");
    assert!(check_mesh_output(&missing).unwrap_err().to_string().contains("does not exist"));
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
}
