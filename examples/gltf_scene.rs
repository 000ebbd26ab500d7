//! Whole glTF scenes become bodies: a chair of ten nodes, a lamp of four materials, a teapot of
//! four parts: `cargo run --release --example gltf_scene --features window`. Space shows and hides
//! the hulls.

mod window;

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;

/// File, scale, and where it starts.
const PROPS: [(&str, f32, [f32; 3]); 5] = [
    ("chair.glb", 1.0, [-0.9, 0.6, 0.0]),
    ("chair.glb", 1.0, [-0.7, 1.7, 0.1]),
    ("lamp.glb", 1.5, [0.1, 0.4, 0.0]),
    ("teapot.glb", 2.0, [0.8, 0.4, 0.2]),
    ("dog.glb", 0.7, [0.4, 1.2, -0.3]),
];

fn main() {
    App::new()
        .add_plugins((
            DefaultPlugins,
            RapierPhysicsPlugin::<NoUserData>::default(),
            HullwrightPlugin::default(),
            window::Stage { size: 3.0 },
        ))
        .add_systems(Startup, setup)
        .add_observer(on_ready)
        .add_observer(on_failed)
        .run();
}

fn setup(mut commands: Commands, server: Res<AssetServer>) {
    for (file, scale, at) in PROPS {
        commands.spawn((
            WorldAssetRoot(server.load(GltfAssetLabel::Scene(0).from_asset(file))),
            Transform::from_translation(at.into()).with_scale(Vec3::splat(scale)),
            RigidBody::Dynamic,
            // Each mesh below becomes a collider of this one body.
            ConvexDecompositionHierarchy::new(ConvexDecomposition::default()),
        ));
    }
}

fn on_ready(event: On<DecompositionReady>, names: Query<&Name>) {
    let name = names.get(event.entity).map_or("a node", Name::as_str);
    println!("{name}: {} hulls", event.hulls);
}

fn on_failed(event: On<DecompositionFailed>, names: Query<&Name>) {
    let name = names.get(event.entity).map_or("a node", Name::as_str);
    println!("{name} has no collider: {}", event.failure);
}
