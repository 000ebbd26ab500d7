//! Baked hulls need no work but their shape.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;
use hullwright::bevy::{BakedHulls, HullSource};
use hullwright::hulls_format::HullsFile;
use hullwright::io::read_mesh;
use hullwright::{Control, Parameters, decompose, mass_properties};

use crate::app::*;

pub fn baked() -> HullsFile {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/u_prism.glb");
    let mesh = read_mesh(path).unwrap();
    let result = decompose(&mesh, &Parameters::default(), &Control::new()).unwrap();
    let mass = mass_properties(&mesh, &result.hulls, DENSITY.into()).unwrap();
    HullsFile::new("u", &result).with_mass_properties(mass)
}

/// An app, and the handle of a file with these bytes in its directory of assets.
fn app_loading(bytes: &[u8]) -> (App, Handle<BakedHulls>, tempfile::TempDir) {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("it.hulls"), bytes).unwrap();
    let path = directory.path().to_str().unwrap().to_owned();
    let app = app_with_assets(default(), path);
    let handle = app.load("it.hulls");
    (app, handle, directory)
}

#[test]
fn a_baked_file_becomes_a_collider_with_its_mass() {
    let (mut app, handle, _directory) = app_loading(&baked().to_bytes().unwrap());
    let scale = Transform::from_scale(Vec3::splat(2.0));
    let entity = app.put((BakedDecomposition::new(handle), RigidBody::Dynamic, scale));
    update_until_finished(&mut app, &[entity]);
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Baked));
    assert_eq!(collider(&app, entity).as_compound().unwrap().shapes().count(), 3);
    let properties = mass(&app, entity);
    let expected = 8.0 * baked().mass_properties.unwrap().mass as f32;
    assert!((properties.mass / expected - 1.0).abs() < 1e-2);
    assert_eq!((counters(&app).baked, counters(&app).decomposed), (1, 0));
}

#[test]
fn a_file_of_an_older_algorithm_loads_as_before() {
    let mut older = baked();
    older.algorithm_version = 1;
    let (mut app, handle, _directory) = app_loading(&older.to_bytes().unwrap());
    let entity = app.put((BakedDecomposition::new(handle), RigidBody::Dynamic));
    update_until_finished(&mut app, &[entity]);
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Baked));
    assert_eq!(collider(&app, entity).as_compound().unwrap().shapes().count(), 3);
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
    let handle = app.world_mut().resource_mut::<Assets<BakedHulls>>().add(BakedHulls(baked()));
    let baked = BakedDecomposition { mass: Some(5.0), ..BakedDecomposition::new(handle) };
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
    for path in ["hullwright::BakedHulls", "hullwright::BakedScene"] {
        let found = registry.get_with_type_path(path).unwrap_or_else(|| panic!("no {path}"));
        assert!(found.data::<bevy::asset::ReflectAsset>().is_some(), "{path}");
    }
}
