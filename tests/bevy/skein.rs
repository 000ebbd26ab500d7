//! Components that Skein's form in Blender writes into glTF extras, in exactly its shape, and
//! inserted as its plugin does.

use bevy::ecs::reflect::ReflectCommandExt;
use bevy::gltf::GltfExtras;
use bevy::prelude::*;
use bevy::reflect::serde::ReflectDeserializer;
use bevy_hullwright::prelude::*;
use serde::de::DeserializeSeed;
use serde_json::Value;

use crate::app::*;
use crate::artists::app_with_nodes;

/// A component of a game with what the form writes as an empty list and an empty map.
#[derive(Component, Reflect, Default)]
#[reflect(Component, Default)]
struct Loot {
    items: Vec<String>,
    weights: Vec<f32>,
}

/// What bevy_skein does when extras come: each entry of the list `skein` is one component by its
/// type path.
fn insert_components(
    added: On<Add<GltfExtras>>,
    extras: Query<&GltfExtras>,
    registry: Res<AppTypeRegistry>,
    mut commands: Commands,
) {
    let extras: Value = serde_json::from_str(&extras.get(added.entity).unwrap().value).unwrap();
    for component in extras["skein"].as_array().into_iter().flatten() {
        let registry = registry.read();
        let value = ReflectDeserializer::new(&registry).deserialize(component).unwrap();
        commands.entity(added.entity).insert_reflect(value);
    }
}

/// As the form writes a tag: every field, numbers in single precision, `None` as null, enums by
/// their variant.
const TAG: &str = r#"{"hullwright::ConvexDecomposition": {
    "max_error": {"Share": 0.009999999776482582},
    "preset": "Fast",
    "max_hulls": 8,
    "max_vertices": null,
    "keep_cavities": false,
    "openings": "Auto",
    "shape": "Hulls",
    "density": 500.0,
    "mass": null,
    "fallback_collider": "BoundingBox"
}}"#;

#[test]
fn a_tag_from_skeins_form_is_followed() {
    let chair =
        format!(r#"{{"skein": [{TAG}, {{"game::Loot": {{"items": [], "weights": []}}}}]}}"#)
            .replace("game::Loot", Loot::type_path());
    let metres = TAG.replace(r#"{"Share": 0.009999999776482582}"#, r#"{"Metres": 0.05}"#);
    let house = format!(r#"{{"skein": [{metres}]}}"#);
    let (mut app, _) = app_with_nodes(
        &[
            ("chair", Some(&chair)),
            ("house", Some(&house)),
            ("curtain", Some(r#"{"skein": [{"hullwright::NoConvexDecomposition": {}}]}"#)),
            ("lamp", Some(r#"{"skein": []}"#)),
        ],
        ConvexDecompositionHierarchy::new(tag()),
        |app| {
            app.register_type::<Loot>().add_observer(insert_components);
        },
    );
    let tag_of = |app: &mut App, name: &str| {
        let mut tags = app.world_mut().query::<(&Name, Option<&ConvexDecomposition>)>();
        let found = tags.iter(app.world()).find(|(found, _)| found.as_str() == name);
        found.expect("a node of this name").1.cloned()
    };
    let expected = ConvexDecomposition::default()
        .with_max_error(0.01)
        .with_preset(DecompositionPreset::Fast)
        .with_max_hulls(8)
        .with_max_vertices(None)
        .with_shape(DecompositionShape::Hulls)
        .with_density(500.0)
        .with_fallback_collider(FallbackCollider::BoundingBox);
    assert_eq!(tag_of(&mut app, "chair"), Some(expected.clone()));
    let in_metres = expected.with_max_error(MaxError::Metres(0.05));
    assert_eq!(tag_of(&mut app, "house"), Some(in_metres));
    assert_eq!(tag_of(&mut app, "curtain"), None);
    // An empty list says nothing: the scene's own tag.
    assert_eq!(tag_of(&mut app, "lamp"), Some(tag()));
    assert_eq!(ready(&app).len(), 3);
    assert_eq!(app.world_mut().query::<&Loot>().iter(app.world()).count(), 1);
}
