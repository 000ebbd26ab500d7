//! Five mugs hang by their handles: `cargo window minimal`.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::plugin::context::RapierContextSimulation;
use bevy_rapier3d::prelude::*;
use hullwright_demos::orbit::Orbit;
use hullwright_demos::{RECYCLED_FOR, Stage};

/// The mug is small; ten times as large it is seen better, and Rapier has larger things to hold.
const SCALE: f32 = 10.0;

/// The middle of the hole in the handle, in the mug's own space.
const HANDLE: Vec3 = Vec3::new(0.054, 0.052, 0.0);

/// Height of the rail, and the way from hook to hook, in metres.
const RAIL: f32 = 2.0;
const STEP: f32 = 1.25;

const GLAZES: [Color; 5] = [
    Color::srgb(0.76, 0.36, 0.25),
    Color::srgb(0.89, 0.72, 0.42),
    Color::srgb(0.93, 0.91, 0.86),
    Color::srgb(0.46, 0.61, 0.55),
    Color::srgb(0.27, 0.40, 0.56),
];

fn main() -> AppExit {
    let stage = Stage {
        caption: "Five mugs hang by their handles: a finger fits through, and so does a hook.",
        width: 7.0,
        view: Orbit::new(Vec3::new(0.1, 0.95, 0.0), 2.3).from_angles(0.3, 0.2),
    };
    App::new()
        .add_plugins((hullwright_demos::plugins("Mugs on a rail"), stage))
        .add_systems(Startup, (hang_mugs, build_rail))
        .add_systems(PostStartup, renew_contacts)
        .run()
}

fn hang_mugs(mut commands: Commands, server: Res<AssetServer>) {
    let mug = GltfAssetLabel::Primitive { mesh: 0, primitive: 0 }.from_asset("mug.glb");
    for (hook, glaze) in GLAZES.into_iter().enumerate() {
        // The handle up, the hook in its hole; the mug falls the last bit, and swings.
        let turn = Quat::from_rotation_z(1.2);
        let hole = turn * (SCALE * HANDLE);
        let place = Vec3::new(hook_at(hook), RAIL, 0.0) - hole;
        commands.spawn((
            Mesh3d(server.load(mug.clone())),
            MeshMaterial3d(server.add(StandardMaterial::from(glaze))),
            Transform::from_translation(place).with_rotation(turn).with_scale(Vec3::splat(SCALE)),
            RigidBody::Dynamic,
            Damping { linear_damping: 0.4, angular_damping: 1.5 },
            ConvexDecomposition::default().with_max_error(0.01),
        ));
    }
}

/// Without it they would swing on.
fn renew_contacts(mut worlds: Query<&mut RapierContextSimulation>) {
    for mut world in &mut worlds {
        world.integration_parameters.normalized_contact_recycle_distance = RECYCLED_FOR;
    }
}

fn hook_at(hook: usize) -> f32 {
    STEP * (hook as f32 - (GLAZES.len() - 1) as f32 / 2.0)
}

/// A board with a peg for each mug.
fn build_rail(mut commands: Commands, server: Res<AssetServer>) {
    let oak = MeshMaterial3d(server.add(StandardMaterial::from(Color::srgb(0.68, 0.50, 0.33))));
    let mut block = |size: Vec3, at: Vec3| {
        let half = size / 2.0;
        commands.spawn((
            Mesh3d(server.add(Mesh::from(Cuboid::from_size(size)))),
            oak.clone(),
            Transform::from_translation(at),
            Collider::cuboid(half.x, half.y, half.z),
        ));
    };
    block(Vec3::new(6.6, 0.5, 0.12), Vec3::new(0.0, RAIL, -0.75));
    for x in [-3.1, 3.1] {
        block(Vec3::new(0.16, RAIL + 0.25, 0.16), Vec3::new(x, (RAIL + 0.25) / 2.0, -0.89));
    }
    for hook in 0..GLAZES.len() {
        block(Vec3::new(0.09, 0.09, 1.3), Vec3::new(hook_at(hook), RAIL - 0.05, -0.1));
        block(Vec3::new(0.12, 0.24, 0.06), Vec3::new(hook_at(hook), RAIL + 0.02, 0.55));
    }
}
