//! A desk that an artist has tagged, and clutter on it: in `props.glb` the name `mug-convdecomp`,
//! the pieces `UCX_table_…` and an extra on the lamp ask for colliders; the leaf has no tag and no
//! collider. What is dropped on the desk is tagged in code: `cargo window gltf_scene`.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright_demos::Stage;
use hullwright_demos::orbit::Orbit;

/// The models are in metres; three times as large they are easier to hold for Rapier.
const SCALE: f32 = 3.0;

/// Convex pieces made by an artist; they are colliders and not drawn.
const PIECE: &str = "UCX_";

/// A model, where its foot is before it falls, in metres of the model, and how it is turned about
/// the vertical and about the axis from left to right, in radians.
const CLUTTER: [(&str, Vec3, [f32; 2]); 9] = [
    ("teapot.glb", Vec3::new(-0.02, 0.76, -0.20), [0.5, 0.0]),
    ("bowl.glb", Vec3::new(0.02, 0.76, 0.16), [0.0, 0.0]),
    ("gear.glb", Vec3::new(0.02, 0.88, 0.16), [0.4, 0.9]),
    ("spring.glb", Vec3::new(0.03, 1.02, 0.17), [0.0, 1.3]),
    ("mug.glb", Vec3::new(-0.36, 0.94, -0.16), [2.6, 0.0]),
    ("mug.glb", Vec3::new(0.40, 0.76, 0.27), [1.2, 0.0]),
    ("bowl.glb", Vec3::new(-0.42, 0.84, 0.24), [0.0, 3.1]),
    ("chair.glb", Vec3::new(0.12, 0.02, 0.78), [2.75, 0.0]),
    ("dog.glb", Vec3::new(-1.02, 0.02, 0.42), [-0.75, 0.0]),
];

/// Things come to rest as in air and on wood.
const CALM: Damping = Damping { linear_damping: 0.3, angular_damping: 2.0 };

/// Books: thickness, turn and colour of each, from the desk up.
const BOOKS: [(f32, f32, Color); 3] = [
    (0.045, 0.12, Color::srgb(0.42, 0.22, 0.20)),
    (0.030, -0.08, Color::srgb(0.85, 0.80, 0.68)),
    (0.050, 0.30, Color::srgb(0.20, 0.33, 0.38)),
];

fn main() -> AppExit {
    let stage = Stage {
        caption: "A desk from a glTF file: names and extras in it ask for colliders. \
                  What falls on it is tagged in code.",
        width: 9.0,
        view: Orbit::new(Vec3::new(-0.35, 1.0, 0.45), 2.85).from_angles(0.42, 0.33),
    };
    App::new()
        .add_plugins((hullwright_demos::plugins("A cluttered desk"), stage))
        .add_systems(Startup, (open_desk, drop_clutter, stack_books))
        .add_systems(Update, make_bodies)
        .add_observer(on_ready)
        .add_observer(on_failed)
        .run()
}

fn open_desk(mut commands: Commands, server: Res<AssetServer>) {
    commands.spawn((
        WorldAssetRoot(server.load(GltfAssetLabel::Scene(0).from_asset("props.glb"))),
        Transform::from_scale(Vec3::splat(SCALE)),
        // What the file does not tag is left alone. With the default bound the mug has a corner
        // under its foot, of a third of a millimetre, and rocks on it for minutes.
        ConvexDecompositionHierarchy::tagged_only().with("mug-convdecomp", clutter_tag()),
    ));
}

type Tagged = (Added<ConvexDecomposition>, Without<Clutter>);

/// Each tagged node of the desk is a body, and a node with pieces below it is one with all of them.
fn make_bodies(mut commands: Commands, tagged: Query<(Entity, &Name, &ChildOf), Tagged>) {
    for (entity, name, parent) in &tagged {
        let body = if name.starts_with(PIECE) { parent.parent() } else { entity };
        commands.entity(body).insert((RigidBody::Dynamic, CALM));
    }
}

/// What falls on the desk as soon as it has its hulls.
#[derive(Component)]
struct Clutter;

fn drop_clutter(mut commands: Commands, server: Res<AssetServer>) {
    for (model, place, [yaw, roll]) in CLUTTER {
        let turn = Quat::from_rotation_y(yaw) * Quat::from_rotation_x(roll);
        commands.spawn((
            Name::new(model),
            Clutter,
            WorldAssetRoot(server.load(GltfAssetLabel::Scene(0).from_asset(model))),
            Transform::from_translation(SCALE * place)
                .with_rotation(turn)
                .with_scale(Vec3::splat(SCALE)),
            // It stays where it is until it has a collider.
            RigidBody::KinematicPositionBased,
            CALM,
            clutter_tag(),
        ));
    }
}

fn clutter_tag() -> ConvexDecomposition {
    ConvexDecomposition::default().with_max_error(0.015)
}

fn stack_books(mut commands: Commands, server: Res<AssetServer>) {
    let mut height = 0.742;
    for (thickness, turn, colour) in BOOKS {
        let size = SCALE * Vec3::new(0.27, thickness, 0.2);
        commands.spawn((
            Mesh3d(server.add(Mesh::from(Cuboid::from_size(size)))),
            MeshMaterial3d(server.add(StandardMaterial::from(colour))),
            Transform::from_translation(SCALE * Vec3::new(-0.38, height + thickness / 2.0, -0.17))
                .with_rotation(Quat::from_rotation_y(turn)),
            RigidBody::Dynamic,
            Collider::cuboid(size.x / 2.0, size.y / 2.0, size.z / 2.0),
        ));
        height += thickness;
    }
}

fn on_ready(
    event: On<DecompositionReady>,
    mut commands: Commands,
    names: Query<(&Name, Has<Clutter>)>,
) {
    let Ok((name, is_clutter)) = names.get(event.entity) else { return };
    println!("{name}: {} hulls", event.hulls);
    if is_clutter {
        commands.entity(event.entity).insert(RigidBody::Dynamic);
    }
}

fn on_failed(event: On<DecompositionFailed>, names: Query<&Name>) {
    let name = names.get(event.entity).map_or("a node", Name::as_str);
    println!("{name} has no collider: {}", event.error);
}
