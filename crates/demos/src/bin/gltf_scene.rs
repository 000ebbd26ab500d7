//! A scene with an artist's tags: in `props.glb` the name `mug-convdecomp`, the pieces `UCX_table_…` and
//! an extra on the lamp ask for colliders; the leaf has no tag and no collider:
//! `cargo window gltf_scene`.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;
use hullwright_demos::Stage;

/// How high each copy of the scene starts, and how far it is tipped over, in radians.
const COPIES: [(f32, f32); 2] = [(0.3, 0.0), (1.4, 0.6)];

/// Convex pieces made by an artist; they are colliders and not drawn.
const PIECE: &str = "UCX_";

fn main() -> AppExit {
    App::new()
        .add_plugins((hullwright_demos::plugins(), Stage { size: 3.0 }))
        .add_systems(Startup, setup)
        .add_systems(Update, make_bodies)
        .add_observer(on_ready)
        .add_observer(on_failed)
        .run()
}

fn setup(mut commands: Commands, server: Res<AssetServer>) {
    for (height, tip) in COPIES {
        commands.spawn((
            WorldAssetRoot(server.load(GltfAssetLabel::Scene(0).from_asset("props.glb"))),
            Transform::from_xyz(0.0, height, 0.0).with_rotation(Quat::from_rotation_z(tip)),
            // What the file does not tag is left alone.
            ConvexDecompositionHierarchy::tagged_only(),
        ));
    }
}

/// Each tagged node is a body, and a node with pieces below it is one with all of them.
fn make_bodies(
    mut commands: Commands,
    tagged: Query<(Entity, &Name, &ChildOf), Added<ConvexDecomposition>>,
) {
    for (entity, name, parent) in &tagged {
        let body = if name.starts_with(PIECE) { parent.parent() } else { entity };
        commands.entity(body).insert(RigidBody::Dynamic);
    }
}

fn on_ready(event: On<DecompositionReady>, names: Query<&Name>) {
    let name = names.get(event.entity).map_or("a node", Name::as_str);
    println!("{name}: {} hulls", event.hulls);
}

fn on_failed(event: On<DecompositionFailed>, names: Query<&Name>) {
    let name = names.get(event.entity).map_or("a node", Name::as_str);
    println!("{name} has no collider: {}", event.error);
}
