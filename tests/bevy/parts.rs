//! From a hull or a triangle to the mesh that it is made of.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_hullwright::{subshape_at, triangle_mesh};
use hullwright::hulls_format::{BakedMesh, HullScene, HullsFile, MeshPart};
use hullwright::{Control, Parameters, TriangleMesh, decompose, mass_properties, part_shares};

use crate::app::*;
use crate::engine::{FIXED, below, shape};

/// Two cubes apart, along x.
const AT: [f32; 2] = [0.0, 3.0];

fn cubes(app: &mut App) -> [Handle<Mesh>; 2] {
    AT.map(|x| add(app, cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])))
}

/// An entity with a mesh on each of its children.
fn spawn_parts(app: &mut App, of: impl Bundle, meshes: &[Handle<Mesh>]) -> (Entity, Vec<Entity>) {
    let world = app.world_mut();
    let whole = world.spawn((of, Transform::default())).id();
    let parts = meshes.iter().map(|mesh| world.spawn((Mesh3d(mesh.clone()), ChildOf(whole))).id());
    (whole, parts.collect())
}

fn parts(app: &App, entity: Entity) -> &ColliderParts {
    app.get::<ColliderParts>(entity).unwrap()
}

/// Asserts that each of two hulls leads to the cube where it is.
fn assert_hulls_lead_to(app: &App, whole: Entity, expected: &[Entity]) {
    let hulls = hulls(app, whole);
    assert_eq!(hulls.len(), 2);
    for (index, hull) in (0..).zip(&hulls) {
        let is_second = hull[0].x > 2.0;
        let part = expected[usize::from(is_second)];
        assert_eq!(parts(app, whole).part(index), Some(part));
        assert_eq!(parts(app, whole).shares(index).collect::<Vec<_>>(), [(part, 1.0)]);
        let middle = hull.iter().sum::<Vec3>() / hull.len() as f32 + Vec3::Z * 0.5;
        assert_eq!(subshape_at(shape(collider(app, whole)), middle), index);
    }
    assert_eq!(parts(app, whole).part(2), None);
}

#[test]
fn a_hull_leads_to_the_mesh_that_it_is_made_of() {
    let mut app = app();
    let meshes = cubes(&mut app);
    let (first, of_first) = spawn_parts(&mut app, tag(), &meshes);
    // The same meshes make the same hulls of other entities.
    let (second, of_second) = spawn_parts(&mut app, tag(), &meshes);
    update_until_finished(&mut app, &[first, second]);
    assert_hulls_lead_to(&app, first, &of_first);
    assert_hulls_lead_to(&app, second, &of_second);
    assert_eq!(parts(&app, first).entities(), of_first);
}

#[test]
fn a_triangle_leads_to_the_mesh_that_it_is_of() {
    let mut app = app();
    let meshes = cubes(&mut app);
    let (whole, of_whole) = spawn_parts(&mut app, automatic(), &meshes);
    update_until_finished(&mut app, &[whole]);
    let found: Vec<_> = (0..25).map(|triangle| parts(&app, whole).part(triangle)).collect();
    let expected = [[Some(of_whole[0]); 12], [Some(of_whole[1]); 12]].concat();
    assert_eq!(found[..24], expected);
    assert_eq!(found[24], None);
    let on_second = Vec3::new(3.4, 0.5, 1.0);
    let triangle = subshape_at(shape(collider(&app, whole)), on_second);
    assert_eq!(parts(&app, whole).part(triangle), Some(of_whole[1]));
}

#[test]
fn a_ray_leads_to_the_mesh_that_it_meets() {
    for tag in [tag(), automatic()] {
        let mut app = app();
        let meshes = cubes(&mut app);
        let turned = Transform::from_rotation(Quat::from_rotation_y(1.0));
        let (whole, of_whole) = spawn_parts(&mut app, (tag, FIXED), &meshes);
        app.world_mut().entity_mut(whole).insert(turned);
        update_until_finished(&mut app, &[whole]);
        update_times(&mut app, 3);
        for (x, part) in AT.into_iter().zip(of_whole) {
            let above = turned.transform_point(Vec3::new(x + 0.4, 5.0, 0.5));
            let (entity, subshape) = below(&mut app, above).unwrap();
            assert_eq!(entity, whole);
            assert_eq!(parts(&app, whole).part(subshape), Some(part));
        }
    }
}

#[test]
fn a_collider_of_one_mesh_is_made_of_that() {
    let (app, entity) = finished(model("mug"), ());
    let count = hulls(&app, entity).len() as u32;
    assert!((0..count).all(|hull| parts(&app, entity).part(hull) == Some(entity)));
    assert_eq!(parts(&app, entity).part(count), None);
}

#[test]
fn a_hull_of_two_materials_has_the_share_of_each() {
    let mut app = app();
    let cube = unit_cube();
    let positions = cube.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap().to_vec();
    let indices: Vec<u32> = cube.indices().unwrap().iter().map(|index| index as u32).collect();
    // Two of its twelve triangles, and the rest.
    let pieces = [&indices[..6], &indices[6..]].map(|of| mesh(positions.clone(), of.to_vec()));
    let pieces = pieces.map(|piece| add(&mut app, piece));
    let (whole, of_whole) = spawn_parts(&mut app, tag(), &pieces);
    update_until_finished(&mut app, &[whole]);
    let shares: Vec<(Entity, f32)> = parts(&app, whole).shares(0).collect();
    let [(most, larger), (least, smaller)] = shares[..] else { panic!("{shares:?}") };
    assert_eq!([least, most], of_whole[..]);
    assert!((smaller - 1.0 / 6.0).abs() < 1e-6 && (larger - 5.0 / 6.0).abs() < 1e-6);
}

#[test]
fn hulls_from_the_disk_lead_to_the_same_meshes() {
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..2 {
        let mut app = app_with(with_disk_cache(folder.path()));
        let meshes = cubes(&mut app);
        let (whole, of_whole) = spawn_parts(&mut app, tag(), &meshes);
        update_until_finished(&mut app, &[whole]);
        assert_hulls_lead_to(&app, whole, &of_whole);
    }
}

#[test]
fn entities_that_take_the_place_of_others_are_the_parts() {
    let mut app = app();
    let meshes = cubes(&mut app);
    let (whole, mut of_whole) = spawn_parts(&mut app, tag(), &meshes);
    update_until_finished(&mut app, &[whole]);
    let world = app.world_mut();
    world.despawn(of_whole[1]);
    of_whole[1] = world.spawn((Mesh3d(meshes[1].clone()), ChildOf(whole))).id();
    for _ in 0..3 {
        app.update();
    }
    update_until_finished(&mut app, &[whole]);
    assert_hulls_lead_to(&app, whole, &of_whole);
}

#[test]
fn with_its_collider_an_entity_loses_its_parts() {
    let (mut app, entity) = finished(unit_cube(), ());
    app.world_mut().entity_mut(entity).remove::<(ConvexDecomposition, Mesh3d)>();
    app.update();
    let has_parts = app.world().get::<ColliderParts>(entity).is_some();
    assert_eq!(has_parts, has_collider(&app, entity));
}

/// A file of two cubes, whose meshes are called ice and wood.
fn baked_cubes() -> HullScene {
    let meshes = AT.map(|x| cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]));
    let mut whole = TriangleMesh::default();
    let mut of_triangles = Vec::new();
    for (part, mesh) in (0..).zip(&meshes) {
        let TriangleMesh { positions, triangles, .. } = triangle_mesh(mesh).unwrap();
        let first = whole.positions.len() as u32;
        of_triangles.extend(triangles.iter().map(|_| part));
        whole.triangles.extend(triangles.iter().map(|triangle| triangle.map(|at| at + first)));
        whole.positions.extend(positions);
    }
    let made = decompose(&whole, &Parameters::default(), &Control::new()).unwrap();
    let mass = mass_properties(&whole, &made.hulls, 1.0).unwrap();
    let shares = part_shares(&whole, &of_triangles, &made.hulls).unwrap();
    let parts = ["ice", "wood"].map(|material| MeshPart::new("crate", 0, material)).to_vec();
    let file = HullsFile::new("crate", &made).with_mass_properties(mass).with_parts(parts, shares);
    let baked = BakedMesh::new(&whole, Parameters::default(), file);
    HullScene::from_bytes(&HullScene::new("crates", vec![baked]).to_bytes().unwrap()).unwrap()
}

#[test]
fn baked_hulls_lead_to_meshes_and_name_materials_also_without_any_mesh() {
    let mut app = app();
    let scene =
        app.world_mut().resource_mut::<Assets<BakedScene>>().add(BakedScene::new(baked_cubes()));
    let of_file = BakedDecomposition::new(scene.clone());
    let meshes = cubes(&mut app);
    let (whole, of_whole) = spawn_parts(&mut app, of_file.clone(), &meshes);
    let (tagged, of_tagged) = spawn_parts(&mut app, (tag(), FromBakedScene(scene)), &meshes);
    let alone = app.put(of_file);
    update_until_finished(&mut app, &[whole, tagged, alone]);
    assert_hulls_lead_to(&app, whole, &of_whole);
    assert_eq!(status(&app, tagged), DecompositionStatus::Ready(HullSource::Baked));
    assert_hulls_lead_to(&app, tagged, &of_tagged);
    for entity in [whole, tagged, alone] {
        for (index, hull) in (0..).zip(&hulls(&app, entity)) {
            let expected = if hull[0].x > 2.0 { "wood" } else { "ice" };
            assert_eq!(parts(&app, entity).baked_part(index).unwrap().material, expected);
        }
        assert_eq!(parts(&app, entity).baked_part(2), None);
    }
    assert_eq!(parts(&app, alone).part(0), None);
}
