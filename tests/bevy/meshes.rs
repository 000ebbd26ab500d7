//! Every kind of mesh is handled or fails clearly, never with a panic.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
use bevy::prelude::*;
use bevy_hullwright::{DecompositionError, DecompositionShape, DecompositionStatus};
use hullwright::Error;

use crate::app::*;

fn failure_of(mesh: Mesh) -> DecompositionError {
    let (app, entity) = finished(mesh, ());
    let DecompositionStatus::Failed(failure) = status(&app, entity) else {
        panic!("it did not fail");
    };
    assert_eq!(failed(&app), [(entity, failure.to_string())]);
    assert!(ready(&app).is_empty());
    assert_eq!(counters(&app).failed, 1);
    failure
}

fn assert_is_read_as_unit_cube(mesh: Mesh) {
    let (app, entity) = finished(mesh, ());
    assert_is_unit_cube(&app, entity);
}

fn empty(topology: PrimitiveTopology) -> Mesh {
    Mesh::new(topology, RenderAssetUsages::default())
}

#[test]
fn a_mesh_that_is_on_the_gpu_only_fails() {
    let mut mesh = unit_cube();
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    // What Bevy's renderer does with such a mesh.
    mesh.take_gpu_data().unwrap();
    assert_eq!(failure_of(mesh), DecompositionError::RenderWorldOnly);
}

#[test]
fn a_mesh_without_positions_fails() {
    assert_eq!(failure_of(empty(PrimitiveTopology::TriangleList)), DecompositionError::NoPositions);
}

#[test]
fn positions_that_are_not_three_floats_fail() {
    // Bevy panics itself on positions of another format, so they come under another name.
    let mesh = empty(PrimitiveTopology::TriangleList)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0_f32; 3]; 3]);
    assert_eq!(failure_of(mesh), DecompositionError::NoPositions);
}

#[test]
fn lines_and_points_fail() {
    for topology in
        [PrimitiveTopology::LineList, PrimitiveTopology::LineStrip, PrimitiveTopology::PointList]
    {
        let mesh = empty(topology)
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 6]);
        assert!(matches!(failure_of(mesh), DecompositionError::NotTriangles(_)));
    }
}

#[test]
fn a_mesh_without_triangles_fails() {
    let failure = failure_of(mesh(vec![[0.0; 3]; 3], Vec::new()));
    assert!(matches!(failure, DecompositionError::Mesh(Error::EmptyMesh { .. })));
}

#[test]
fn a_mesh_of_one_spot_fails() {
    let failure = failure_of(mesh(vec![[1.0; 3]; 3], vec![0, 1, 2]));
    assert!(matches!(failure, DecompositionError::Mesh(Error::NothingUsable { .. })));
}

#[test]
fn a_mesh_of_nothing_finite_fails() {
    let failure = failure_of(mesh(vec![[f32::NAN; 3]; 3], vec![0, 1, 2]));
    assert!(matches!(failure, DecompositionError::Mesh(Error::NothingUsable { .. })));
}

#[test]
fn an_index_out_of_range_fails() {
    let failure = failure_of(mesh(vec![[0.0; 3]; 3], vec![0, 1, 7]));
    assert!(matches!(failure, DecompositionError::Mesh(Error::IndexOutOfRange { index: 7, .. })));
}

#[test]
fn a_density_that_means_nothing_fails() {
    let (mut app, mesh) = with_mesh(app(), unit_cube());
    for shape in [DecompositionShape::Hulls, DecompositionShape::Ball] {
        for tag in [tag().with_density(0.0), tag().with_mass(-1.0)] {
            let tag = tag.with_shape(shape);
            let entity = app.put((Mesh3d(mesh.clone()), tag));
            update_until_finished(&mut app, &[entity]);
            assert!(matches!(status(&app, entity), DecompositionStatus::Failed(_)));
            assert!(!has_collider(&app, entity));
        }
    }
}

#[test]
fn sixteen_bit_indices_are_read() {
    let mut mesh = unit_cube();
    let Some(Indices::U32(indices)) = mesh.indices().cloned() else { unreachable!() };
    mesh.insert_indices(Indices::U16(indices.into_iter().map(|i| i as u16).collect()));
    assert_is_read_as_unit_cube(mesh);
}

#[test]
fn a_mesh_without_indices_is_read() {
    assert_is_read_as_unit_cube(unit_cube().with_duplicated_vertices());
}

#[test]
fn a_strip_is_read() {
    // A well-known strip around a cube; the bits of a number are the coordinates of a corner.
    let strip = [6, 7, 4, 5, 1, 7, 3, 6, 2, 4, 0, 1, 2, 3];
    let positions = strip.map(|corner| [0, 1, 2].map(|axis| (corner >> axis & 1) as f32)).to_vec();
    let count = positions.len() as u16;
    let plain = empty(PrimitiveTopology::TriangleStrip)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    assert_is_read_as_unit_cube(plain.clone());
    assert_is_read_as_unit_cube(plain.with_inserted_indices(Indices::U16((0..count).collect())));
}

#[test]
fn a_skinned_mesh_is_taken_in_its_rest_pose() {
    let mesh = unit_cube()
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            bevy::mesh::VertexAttributeValues::Uint16x4(vec![[0; 4]; 8]),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0_f32, 0., 0., 0.]; 8]);
    assert_is_read_as_unit_cube(mesh);
}

#[cfg(feature = "bevy_gltf")]
#[test]
fn a_mesh_with_morph_targets_is_taken_without_them() {
    let mut mesh = unit_cube();
    let moved = bevy::mesh::morph::MorphAttributes { position: Vec3::splat(5.0), ..default() };
    mesh.set_morph_targets(vec![moved; 8]);
    assert_is_read_as_unit_cube(mesh);
}

#[cfg(feature = "bevy_gltf")]
#[test]
fn a_mesh_with_morph_targets_that_is_on_the_gpu_only_fails() {
    let mut mesh = unit_cube();
    mesh.set_morph_targets(vec![bevy::mesh::morph::MorphAttributes::default(); 8]);
    mesh.asset_usage = RenderAssetUsages::RENDER_WORLD;
    mesh.take_gpu_data().unwrap();
    assert_eq!(failure_of(mesh), DecompositionError::RenderWorldOnly);
}
