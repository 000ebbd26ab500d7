//! A mug falls, and is a mug: `cargo window minimal`.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;
use hullwright_demos::Stage;

fn main() -> AppExit {
    App::new()
        .add_plugins((hullwright_demos::plugins(), Stage { size: 3.0 }))
        .add_systems(Startup, setup)
        .run()
}

fn setup(
    mut commands: Commands,
    server: Res<AssetServer>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mug = GltfAssetLabel::Primitive { mesh: 0, primitive: 0 }.from_asset("mug.glb");
    commands.spawn((
        Mesh3d(server.load(mug)),
        MeshMaterial3d(materials.add(Color::srgb(0.8, 0.45, 0.3))),
        // The mug is small; ten times as large it is seen better.
        Transform::from_xyz(0.0, 2.0, 0.0)
            .with_scale(Vec3::splat(10.0))
            .with_rotation(Quat::from_rotation_z(1.0)),
        RigidBody::Dynamic,
        ConvexDecomposition::default(),
    ));
}
