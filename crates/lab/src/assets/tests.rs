//! Promises about the bundled models.

use hullwright::Repairs;
use hullwright::inspect::{Inspection, inspect};
use hullwright_formats::{Format, read_mesh_from_bytes};

use super::shape::Shape;
use super::*;

fn committed(name: &str) -> Vec<u8> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn named(name: &str) -> Model {
    models().into_iter().find(|model| model.name == name).unwrap()
}

fn inspected(shape: &Shape, triangles: Vec<[u32; 3]>) -> Inspection {
    let positions = shape.positions.iter().map(|place| place.to_array()).collect();
    inspect(&TriangleMesh::new(positions, triangles)).unwrap()
}

#[test]
fn the_committed_files_are_what_the_code_makes_and_small() {
    for model in models() {
        let name = format!("{}.glb", model.name);
        let file = committed(&name);
        assert!(file == glb::glb(&model), "{name}: run `cargo lab assets`");
        assert!(file.len() < 200_000, "{name}: {} bytes", file.len());
    }
}

#[test]
fn the_read_me_holds_the_line_of_each_model() {
    let text = String::from_utf8(committed("README.md")).unwrap();
    for model in models() {
        let row = table_row(&model);
        assert!(text.lines().any(|line| line == row), "missing: {row}");
    }
}

#[test]
fn a_gltf_reader_sees_every_triangle_in_its_place_and_a_normal_at_each_corner() {
    for model in models() {
        let bytes = glb::glb(&model);
        let file = gltf::Gltf::from_slice(&bytes).unwrap();
        for primitive in file.meshes().flat_map(|mesh| mesh.primitives()) {
            let reader = primitive.reader(|_| file.blob.as_deref());
            let positions = reader.read_positions().unwrap().count();
            assert_eq!(reader.read_normals().unwrap().count(), positions, "{}", model.name);
        }
        let mesh = read_mesh_from_bytes(Format::Gltf, &bytes).unwrap().mesh;
        let expected = model.flattened();
        assert_eq!(mesh.triangles.len(), expected.triangles.len(), "{}", model.name);
        let shape = Shape {
            positions: mesh.positions.into_iter().map(Into::into).collect(),
            ..Shape::default()
        };
        let (bounds, expected) = (shape.bounds(), expected.bounds());
        for axis in 0..3 {
            assert!((bounds.0[axis] - expected.0[axis]).abs() < 1e-5, "{}", model.name);
            assert!((bounds.1[axis] - expected.1[axis]).abs() < 1e-5, "{}", model.name);
        }
    }
}

#[test]
fn closed_models_are_closed_and_face_outward() {
    for model in models().into_iter().filter(|model| model.closed) {
        for shape in &model.meshes {
            let found = inspected(shape, shape.triangles.clone());
            assert!(found.is_closed(), "{}", model.name);
            assert_eq!(found.repairs, Repairs::default(), "{}", model.name);
        }
    }
}

#[test]
fn closed_models_have_the_expected_parts_and_holes() {
    // Parts, and handles as a topologist counts them: V - E + F = 2 (parts - handles).
    let expected = [
        ("mug", 2, 0),
        ("table", 1, 0),
        ("teapot", 4, 0),
        ("lamp", 1, 0),
        ("bowl", 1, 0),
        ("dog", 1, 0),
        ("torus", 1, 1),
        ("gear", 1, 1),
        ("spring", 1, 0),
        ("l_prism", 1, 0),
        ("u_prism", 1, 0),
        ("plus", 1, 0),
    ];
    for (name, parts, handles) in expected {
        let shape = named(name).flattened();
        assert_eq!(inspected(&shape, shape.triangles.clone()).components, parts, "{name}");
        let euler = shape.positions.len() as i64 - shape.triangles.len() as i64 / 2;
        assert_eq!(euler, 2 * (parts as i64 - handles), "{name}");
    }
}

#[test]
fn the_leaf_is_an_open_sheet_of_one_piece() {
    let shape = named("leaf").flattened();
    let Inspection { components, repairs, .. } = inspected(&shape, shape.triangles.clone());
    assert_eq!((components, repairs.flipped_triangles, repairs.non_manifold_edges), (1, 0, 0));
    assert!(repairs.open_edges > 20);
}

#[test]
fn each_primitive_of_the_lamp_alone_is_open() {
    let model = named("lamp");
    let shape = &model.meshes[0];
    for material in 0..4 {
        let triangles = shape.triangles.iter().zip(&shape.materials);
        let own = triangles.filter(|(_, other)| **other == material).map(|(triangle, _)| *triangle);
        assert!(!inspected(shape, own.collect()).is_closed());
    }
    let file = gltf::Gltf::from_slice(&glb::glb(&model)).unwrap();
    assert_eq!(file.meshes().next().unwrap().primitives().len(), 4);
}

#[test]
fn the_props_are_tagged_by_suffix_prefix_and_extra_and_one_is_not() {
    let file = gltf::Gltf::from_slice(&glb::glb(&named("props"))).unwrap();
    let names: Vec<&str> = file.nodes().filter_map(|node| node.name()).collect();
    assert_eq!(&names[..5], ["mug-convdecomp", "lamp", "leaf", "table", "UCX_table_01"]);
    assert_eq!(names.iter().filter(|name| name.starts_with("UCX_table_")).count(), 5);
    let extras = |node: &gltf::Node| node.extras().as_ref().map(|text| text.get().to_owned());
    let with_extras: Vec<_> = file.nodes().filter(|node| extras(node).is_some()).collect();
    assert_eq!(with_extras.len(), 1);
    assert_eq!(with_extras[0].name(), Some("lamp"));
    let expected = r#"{"collider":"convex_decomposition"}"#;
    assert_eq!(extras(&with_extras[0]).as_deref(), Some(expected));
}

#[test]
fn every_model_stands_on_the_ground() {
    for model in models() {
        let (min, _) = model.flattened().bounds();
        assert!(min[1].abs() < 1e-6, "{}: {}", model.name, min[1]);
    }
}

#[test]
fn no_triangle_is_a_needle_without_area() {
    for model in models() {
        for corners in model.flattened().corners() {
            let [a, b, c] = corners;
            assert!((b - a).cross(c - a).length() > 1e-10, "{}: {corners:?}", model.name);
        }
    }
}
