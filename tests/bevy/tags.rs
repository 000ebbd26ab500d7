//! What the tag's settings do, and how scenes and editors see them.

use bevy::prelude::*;
use bevy::reflect::enums::DynamicEnum;
use bevy::reflect::structs::DynamicStruct;
use bevy::reflect::tuple::DynamicTuple;
use bevy::reflect::{FromReflect, TypePath};
use hullwright::Parameters;
use hullwright::bevy::prelude::*;
use hullwright::bevy::{BakedHulls, DecompositionError, HullSource, HullsLoader};

use crate::app::*;

/// Hulls of a model by a tag.
fn hulls_by(name: &str, tag: ConvexDecomposition) -> Vec<Vec<Vec3>> {
    let mut app = app();
    let mesh = add(&mut app, model(name));
    let entity = spawn_with(&mut app, &mesh, tag);
    update_until_finished(&mut app, &[entity]);
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Decomposed));
    hulls(&app, entity)
}

#[test]
fn a_larger_error_takes_fewer_hulls_and_a_cap_fewer_still() {
    let count = |tag| hulls_by("bowl", tag).len();
    let (fine, coarse) = (count(tag()), count(tag().with_max_error(0.08)));
    assert!(coarse < fine, "{coarse} hulls within 8 %, {fine} within 2 %");
    assert_eq!(count(tag().with_max_hulls(2)), 2);
}

#[test]
fn no_hull_has_more_vertices_than_the_tag_allows() {
    let most = |tag| hulls_by("torus", tag).iter().map(Vec::len).max().unwrap();
    assert!(most(tag()) > 12);
    assert!(most(tag().with_max_vertices(12)) <= 12);
}

#[test]
fn the_bound_is_the_one_that_the_tag_says() {
    let mut app = app();
    let mesh = add(&mut app, model("u_prism"));
    let tag = tag().with_max_error(0.05);
    let entity = spawn_with(&mut app, &mesh, tag);
    update_until_finished(&mut app, &[entity]);
    assert_eq!(counters(&app).last_bound, Some(0.05));
    assert!(counters(&app).last_protrusion.unwrap() <= 0.05);
}

#[test]
fn a_tag_by_hand_may_have_the_papers_method() {
    let paper = tag().with_parameters(Parameters::paper());
    assert!(hulls_by("l_prism", paper).len() > 1);
}

#[test]
fn a_setting_that_means_nothing_is_an_error_that_names_it() {
    let mut app = app();
    let mesh = add(&mut app, unit_cube());
    for (tag, name) in [
        (tag().with_max_error(-1.0), "max_error"),
        (tag().with_max_hulls(0), "max_hulls"),
        (tag().with_max_vertices(3), "max_vertices"),
    ] {
        let entity = spawn_with(&mut app, &mesh, tag);
        update_until_finished(&mut app, &[entity]);
        let DecompositionStatus::Failed(DecompositionError::Mesh(error)) = status(&app, entity)
        else {
            panic!("{name}: {:?}", status(&app, entity));
        };
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn an_editor_that_knows_some_settings_gets_a_whole_tag() {
    let mut some = DynamicStruct::default();
    some.insert("density", 3.0_f32);
    some.insert("max_hulls", Some(4_u32));
    let mut max_error = DynamicTuple::default();
    max_error.insert(0.01_f32);
    some.insert("max_error", DynamicEnum::new("Share", max_error));
    let read = ConvexDecomposition::from_reflect(&some).expect("a tag");
    let expected =
        ConvexDecomposition::default().with_density(3.0).with_max_hulls(4).with_max_error(0.01);
    assert_eq!(read, expected);
}

#[test]
fn saved_scenes_know_types_by_paths_without_modules() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for name in [
        "BakedDecomposition",
        "ConvexDecomposition",
        "ConvexDecompositionHierarchy",
        "DecompositionCounters",
        "DecompositionFocus",
        "DecompositionOpenings",
        "DecompositionPreset",
        "DecompositionStatus",
        "FallbackCollider",
        "HullwrightSettings",
        "MaxError",
        "NoConvexDecomposition",
    ] {
        let path = format!("hullwright::{name}");
        assert!(registry.get_with_type_path(&path).is_some(), "{path} is not registered");
    }
    assert_eq!(BakedHulls::type_path(), "hullwright::BakedHulls");
    assert_eq!(HullsLoader::type_path(), "hullwright::HullsLoader");
}
