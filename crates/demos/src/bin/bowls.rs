//! Balls are poured into bowls, and stay in them: `cargo window bowls`.

use std::f32::consts::TAU;

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright_demos::Stage;
use hullwright_demos::orbit::Orbit;

/// Each bowl's place on the floor, how many times as large as the model it is, its glaze, and how
/// many balls it gets.
const BOWLS: [(Vec2, f32, Color, usize); 3] = [
    (Vec2::new(-1.75, 0.35), 8.0, Color::srgb(0.93, 0.91, 0.86), 26),
    (Vec2::new(0.25, -0.55), 11.0, Color::srgb(0.30, 0.45, 0.52), 60),
    (Vec2::new(1.65, 0.95), 6.0, Color::srgb(0.78, 0.45, 0.32), 14),
];

/// Radius of a ball, in metres.
const BALL: f32 = 0.105;

/// Balls in a layer of the column that falls into a bowl.
const LAYER: usize = 5;

/// Colours of the balls.
const SWEETS: [Color; 4] = [
    Color::srgb(0.90, 0.36, 0.30),
    Color::srgb(0.96, 0.75, 0.33),
    Color::srgb(0.43, 0.66, 0.52),
    Color::srgb(0.95, 0.93, 0.88),
];

fn main() -> AppExit {
    let stage = Stage {
        caption: "A hundred balls poured into three bowls. A single hull each would have a lid.",
        width: 5.0,
        view: Orbit::new(Vec3::new(0.05, 0.15, 0.15), 2.1).from_angles(0.25, 0.55),
    };
    App::new()
        .add_plugins((hullwright_demos::plugins("Bowls"), stage))
        .add_systems(Startup, set_bowls)
        .add_observer(pour)
        .run()
}

/// How many balls a bowl gets.
#[derive(Component)]
struct Helping(usize);

fn set_bowls(mut commands: Commands, server: Res<AssetServer>) {
    let bowl = GltfAssetLabel::Primitive { mesh: 0, primitive: 0 }.from_asset("bowl.glb");
    for (place, scale, glaze, balls) in BOWLS {
        commands.spawn((
            Mesh3d(server.load(bowl.clone())),
            MeshMaterial3d(server.add(StandardMaterial::from(glaze))),
            Transform::from_xyz(place.x, 0.02, place.y).with_scale(Vec3::splat(scale)),
            RigidBody::Dynamic,
            ConvexDecomposition::default().with_max_error(0.01).with_density(4.0),
            Helping(balls),
        ));
    }
}

/// Once a bowl has its hulls, a column of balls falls into it.
fn pour(
    event: On<DecompositionReady>,
    mut commands: Commands,
    bowls: Query<(&Transform, &Helping)>,
    server: Res<AssetServer>,
) {
    let Ok((bowl, Helping(count))) = bowls.get(event.entity) else { return };
    // A bowl may be ready again, and is full then.
    commands.entity(event.entity).remove::<Helping>();
    let ball = server.add(Sphere::new(BALL).mesh().build());
    let sweets = SWEETS.map(|colour| server.add(StandardMaterial::from(colour)));
    for number in 0..*count {
        let (layer, place) = (number / LAYER, number % LAYER);
        // Each layer is turned, so that no ball stands on another.
        let angle = TAU * (place as f32 + 0.38 * layer as f32) / LAYER as f32;
        let out = 1.75 * BALL * Vec2::from_angle(angle);
        let up = 0.09 * bowl.scale.y + 2.3 * BALL * (1.0 + layer as f32);
        commands.spawn((
            Mesh3d(ball.clone()),
            MeshMaterial3d(sweets[(number + layer) % SWEETS.len()].clone()),
            Transform::from_translation(bowl.translation + Vec3::new(out.x, up, out.y)),
            RigidBody::Dynamic,
            Collider::ball(BALL),
            Damping { linear_damping: 0.3, angular_damping: 1.0 },
        ));
    }
}
