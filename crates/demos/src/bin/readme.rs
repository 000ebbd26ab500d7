//! The program of README.md, as it stands there; `.ci/run` compares them.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, HullwrightPlugin::default()))
        .add_plugins(RapierPhysicsPlugin::<NoUserData>::default())
        .add_systems(Startup, setup)
        .run();
}

fn setup(mut commands: Commands, server: Res<AssetServer>) {
    let mug = GltfAssetLabel::Primitive { mesh: 0, primitive: 0 }.from_asset("mug.glb");
    let clay = MeshMaterial3d(server.add(StandardMaterial::from(Color::srgb(0.8, 0.45, 0.3))));
    let start = Transform::from_rotation(Quat::from_rotation_z(1.0)).with_scale(Vec3::splat(10.0));
    let tag = ConvexDecomposition::default().with_max_error(0.01);
    commands.spawn((Mesh3d(server.load(mug)), clay.clone(), start, RigidBody::Dynamic, tag));
    let floor = Mesh3d(server.add(Mesh::from(Cuboid::new(4.0, 0.2, 4.0))));
    commands.spawn((floor, clay, Transform::from_xyz(0., -2., 0.), Collider::cuboid(2., 0.1, 2.)));
    let eye = Transform::from_xyz(0.0, 1.0, 5.0).looking_at(Vec3::NEG_Y, Vec3::Y);
    commands.spawn((Camera3d::default(), DirectionalLight::default(), eye));
}
