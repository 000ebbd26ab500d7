//! Baked hulls need no work but their shape.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_hullwright::{BakedSceneSettings, DecompositionError};
use hullwright::hulls_format::{BakedMesh, HullScene, HullsFile};
use hullwright::{Control, Parameters, decompose, mass_properties};
use hullwright_formats::read_mesh;

use crate::app::*;
use crate::engine::*;

/// What `hullwright bake` writes of one mesh.
pub fn baked() -> HullScene {
    HullScene::new("u", vec![baked_mesh()])
}

fn baked_mesh() -> BakedMesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/u_prism.glb");
    let mesh = read_mesh(path).unwrap();
    let result = decompose(&mesh, &Parameters::default(), &Control::new()).unwrap();
    let mass = mass_properties(&mesh, &result.hulls, 1.0).unwrap();
    let file = HullsFile::new("u", &result).with_mass_properties(mass);
    BakedMesh::new(&mesh, Parameters::default(), file)
}

/// An app, and the handle of a file with these bytes in its directory of assets.
fn app_loading(bytes: &[u8]) -> (App, Handle<BakedScene>, tempfile::TempDir) {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("it.hullscene"), bytes).unwrap();
    let path = directory.path().to_str().unwrap().to_owned();
    let app = app_with_assets(default(), path);
    let handle = app.load("it.hullscene");
    (app, handle, directory)
}

#[test]
fn a_baked_file_becomes_a_collider_with_its_mass() {
    let (mut app, handle, _directory) = app_loading(&baked().to_bytes().unwrap());
    let scale = Transform::from_scale(Vec3::splat(2.0));
    let baked_body = BakedDecomposition::new(handle).with_density(DENSITY);
    let entity = app.put((baked_body, RigidBody::Dynamic, scale));
    update_until_finished(&mut app, &[entity]);
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Baked));
    assert_eq!(shape(collider(&app, entity)).as_compound().unwrap().shapes().len(), 3);
    let properties = mass(&app, entity);
    let expected = 8.0 * DENSITY * baked_mesh().hulls.mass_properties.unwrap().mass as f32;
    assert!((properties.mass / expected - 1.0).abs() < 1e-2);
    assert_eq!((counters(&app).baked, counters(&app).decomposed), (1, 0));
}

#[test]
fn a_file_of_an_older_algorithm_loads_as_before() {
    let mut older = baked();
    older.meshes[0].hulls.algorithm_version = 1;
    let (mut app, handle, _directory) = app_loading(&older.to_bytes().unwrap());
    let entity = app.put((BakedDecomposition::new(handle), RigidBody::Dynamic));
    update_until_finished(&mut app, &[entity]);
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Baked));
    assert_eq!(shape(collider(&app, entity)).as_compound().unwrap().shapes().len(), 3);
}

#[test]
fn corrupt_cut_off_and_newer_files_fail() {
    let good = baked().to_bytes().unwrap();
    let mut corrupt = good.clone();
    let middle = corrupt.len() / 2;
    corrupt[middle] ^= 1;
    let mut newer = good.clone();
    newer[8] = 99;
    for bytes in [corrupt, good[..good.len() / 2].to_vec(), newer, Vec::new()] {
        let (mut app, handle, _directory) = app_loading(&bytes);
        let entity = app.put(BakedDecomposition::new(handle));
        update_until_finished(&mut app, &[entity]);
        assert!(matches!(status(&app, entity), DecompositionStatus::Failed(_)));
        assert!(!has_collider(&app, entity));
    }
}

#[test]
fn the_mass_of_a_baked_body_may_be_set() {
    let mut app = app();
    let handle = add_scene(&mut app, baked());
    let baked = BakedDecomposition::new(handle).with_mass(5.0);
    let scale = Transform::from_scale(Vec3::splat(3.0));
    let entity = app.put((baked, scale));
    update_until_finished(&mut app, &[entity]);
    let properties = mass(&app, entity);
    assert!((properties.mass - 5.0).abs() < 1e-4);
}

#[test]
fn editors_find_the_assets_by_reflection() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let found = registry.get_with_type_path("hullwright::BakedScene").expect("registered");
    assert!(found.data::<bevy::asset::ReflectAsset>().is_some());
}

fn add_scene(app: &mut App, scene: HullScene) -> Handle<BakedScene> {
    app.world_mut().resource_mut::<Assets<BakedScene>>().add(BakedScene::new(scene))
}

#[test]
fn a_mesh_of_several_is_named_and_without_its_name_the_error_lists_them() {
    let mut app = app();
    let mut other = baked_mesh();
    other.names = vec!["other".into(), "node".into()];
    let scene = add_scene(&mut app, HullScene::new("two", vec![baked_mesh(), other]));
    let baked = BakedDecomposition::new(scene);
    let named = app.put(baked.clone().with_mesh("node"));
    let unknown = app.put(baked.clone().with_mesh("nobody"));
    let unnamed = app.put(baked);
    update_until_finished(&mut app, &[named, unknown, unnamed]);
    assert_eq!(status(&app, named), DecompositionStatus::Ready(HullSource::Baked));
    for entity in [unknown, unnamed] {
        let DecompositionStatus::Failed(error) = status(&app, entity) else { panic!() };
        assert!(matches!(error, DecompositionError::NotBaked { .. }));
        let text = error.to_string();
        assert!(text.contains("`u`, `other`, `node`"), "{text}");
    }
}

#[test]
fn an_entity_takes_hulls_of_another_version_if_the_files_meta_says_so() {
    let mut older = baked();
    older.meshes[0].hulls.algorithm_version = 1;
    let meta = |accepts: bool| {
        format!(
            r#"(meta_format_version: "1.0", asset: Load(loader: "hullwright::HullSceneLoader",
            settings: (accepts_other_versions: {accepts})))"#
        )
    };
    for (accepts, expected) in [(true, HullSource::Baked), (false, HullSource::Decomposed)] {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("it.hullscene");
        std::fs::write(&path, older.to_bytes().unwrap()).unwrap();
        std::fs::write(path.with_extension("hullscene.meta"), meta(accepts)).unwrap();
        let mut app = app_with_assets(default(), directory.path().display().to_string());
        let scene = FromBakedScene(app.load("it.hullscene"));
        let mesh = add(&mut app, model("u_prism"));
        let tag = ConvexDecomposition::default().with_shape(DecompositionShape::Hulls);
        let entity = finish(&mut app, &mesh, (tag, scene));
        assert_eq!(status(&app, entity), DecompositionStatus::Ready(expected), "{accepts}");
    }
    assert!(!BakedSceneSettings::default().accepts_other_versions);
}

/// The hulls of one mesh, edited by hand: a single one.
fn edited() -> HullScene {
    let mut scene = baked();
    scene.meshes[0].hulls.hulls.truncate(1);
    scene
}

#[test]
fn a_file_that_changes_while_the_game_runs_takes_effect() {
    let mut app = app();
    let scene = add_scene(&mut app, baked());
    let mesh = add(&mut app, model("u_prism"));
    let tag = ConvexDecomposition::default().with_shape(DecompositionShape::Hulls);
    let by_mesh = finish(&mut app, &mesh, (tag, FromBakedScene(scene.clone())));
    let by_name = app.put(BakedDecomposition::new(scene.clone()));
    update_until_finished(&mut app, &[by_name]);
    for entity in [by_mesh, by_name] {
        assert_eq!(hulls(&app, entity).len(), 3);
    }
    let mut all = app.world_mut().resource_mut::<Assets<BakedScene>>();
    *all.get_mut(&scene).unwrap() = BakedScene::new(edited());
    update_until_ready_times(&mut app, 4);
    for entity in [by_mesh, by_name] {
        assert_eq!(hulls(&app, entity).len(), 1);
        assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Baked));
    }
    assert_eq!(counters(&app).decomposed, 0);
}

#[test]
fn hulls_of_a_file_win_over_those_in_memory_whichever_came_first() {
    let mut app = app();
    let mesh = add(&mut app, model("u_prism"));
    let tag = || ConvexDecomposition::default().with_shape(DecompositionShape::Hulls);
    let first = finish(&mut app, &mesh, tag());
    assert_eq!(hulls(&app, first).len(), 3);
    // A file that is given later, to a new entity and to one that has its collider.
    let scene = add_scene(&mut app, edited());
    let second = finish(&mut app, &mesh, (tag(), FromBakedScene(scene.clone())));
    app.edit(first).insert(FromBakedScene(scene));
    update_until_ready_times(&mut app, 3);
    for entity in [first, second] {
        assert_eq!(hulls(&app, entity).len(), 1);
    }
    // Without the file the decomposition is still there.
    let third = finish(&mut app, &mesh, tag());
    assert_eq!(status(&app, third), DecompositionStatus::Ready(HullSource::Shared));
    assert_eq!(hulls(&app, third).len(), 3);
}

#[test]
fn a_file_that_could_not_be_loaded_takes_effect_when_it_is_there() {
    let mut app = app();
    let scene: Handle<BakedScene> = app.load("nowhere.hullscene");
    let mesh = add(&mut app, model("u_prism"));
    let tag = ConvexDecomposition::default().with_shape(DecompositionShape::Hulls);
    let entity = finish(&mut app, &mesh, (tag, FromBakedScene(scene.clone())));
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Decomposed));
    let mut all = app.world_mut().resource_mut::<Assets<BakedScene>>();
    all.insert(scene.id(), BakedScene::new(edited())).unwrap();
    update_until_ready_times(&mut app, 2);
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Baked));
    assert_eq!(hulls(&app, entity).len(), 1);
}

/// The program of the documentation has nothing but these.
#[test]
fn a_baked_body_without_a_transform_falls() {
    let mut app = app();
    let handle = add_scene(&mut app, baked());
    let body = app.put((RigidBody::Dynamic, BakedDecomposition::new(handle)));
    update_until_finished(&mut app, &[body]);
    update_times(&mut app, 30);
    assert!(translation(&app, body).y < -0.5);
}

#[test]
fn a_baked_scene_beside_no_tag_is_logged() {
    Log::install();
    let mut app = app();
    let scene = add_scene(&mut app, baked());
    app.put((Name::new("forgot its tag"), FromBakedScene(scene.clone())));
    app.put((Name::new("has its tag"), FromBakedScene(scene), ConvexDecomposition::default()));
    update_times(&mut app, 3);
    assert_eq!(Log::lines_with("forgot its tag").len(), 1);
    assert!(Log::lines_with("has its tag").is_empty());
}
