//! What hulls know: a falling chair leaves marks in the colour of the material that hit the floor,
//! and a vase breaks: `cargo window breaking`.

use std::f32::consts::TAU;

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright_demos::orbit::Orbit;
use hullwright_demos::{ShownHulls, Stage};

const OAK: Color = Color::srgb(0.62, 0.40, 0.22);
const CLOTH: Color = Color::srgb(0.25, 0.45, 0.75);
const GLAZE: Color = Color::srgb(0.30, 0.52, 0.50);
const CLAY: Color = Color::srgb(0.80, 0.45, 0.30);

/// The outside of a vase, from its foot to its rim, then its inside down to the bottom: distances
/// from the axis and heights, in metres.
const PROFILE: [[f32; 2]; 14] = [
    [0.00, 0.00],
    [0.15, 0.00],
    [0.24, 0.12],
    [0.29, 0.30],
    [0.26, 0.48],
    [0.15, 0.62],
    [0.12, 0.70],
    [0.18, 0.80],
    [0.16, 0.80],
    [0.10, 0.70],
    [0.13, 0.61],
    [0.24, 0.47],
    [0.25, 0.30],
    [0.00, 0.05],
];

/// Sides of the vase.
const SIDES: u32 = 28;

fn main() -> AppExit {
    let stage = Stage {
        caption: "A chair leaves marks in the colour of what hit the floor. A vase breaks into its hulls.",
        width: 4.0,
        view: Orbit::new(Vec3::new(0.0, 0.25, 0.0), 1.75).from_angles(0.3, 0.4),
    };
    App::new()
        .insert_resource(ShownHulls(false))
        .add_plugins((hullwright_demos::plugins("What hulls know"), stage))
        .add_systems(Startup, set_up)
        .add_systems(Update, (leave_marks, break_vases))
        .add_observer(paint_cuts)
        .run()
}

/// What a mesh is made of.
#[derive(Component, Clone)]
struct Substance(Handle<StandardMaterial>);

/// It breaks when it hits something.
#[derive(Component)]
struct Vase;

/// Of what a vase is inside.
#[derive(Resource)]
struct Inside(Handle<StandardMaterial>);

fn set_up(mut commands: Commands, server: Res<AssetServer>) {
    let [oak, cloth, glaze, clay] =
        [OAK, CLOTH, GLAZE, CLAY].map(|colour| server.add(StandardMaterial::from(colour)));
    commands.insert_resource(Inside(clay));

    let legs = [[-0.2, -0.2], [0.2, -0.2], [-0.2, 0.2], [0.2, 0.2]]
        .map(|[x, z]| ([0.05, 0.45, 0.05], [x, 0.225, z]));
    let back = [([0.45, 0.5, 0.05], [0.0, 0.75, -0.2]), ([0.45, 0.05, 0.45], [0.0, 0.475, 0.0])];
    let frame = server.add(boxes(&[&legs[..], &back].concat()));
    let cushion = server.add(boxes(&[([0.56, 0.1, 0.52], [0.0, 0.55, 0.06])]));
    commands.spawn((
        RigidBody::Dynamic,
        ConvexDecomposition::default().as_children(HullGrouping::EachHull),
        ActiveEvents::COLLISION_EVENTS,
        Transform::from_xyz(-0.6, 1.1, 0.0).with_rotation(Quat::from_euler(
            EulerRot::XYZ,
            1.9,
            0.3,
            0.5,
        )),
        Visibility::default(),
        Name::new("chair"),
        children![
            (Mesh3d(frame), MeshMaterial3d(oak.clone()), Substance(oak)),
            (Mesh3d(cushion), MeshMaterial3d(cloth.clone()), Substance(cloth)),
        ],
    ));

    commands.spawn((
        Mesh3d(server.add(vase())),
        MeshMaterial3d(glaze),
        RigidBody::Dynamic,
        ConvexDecomposition::default().with_max_error(0.01),
        ActiveEvents::COLLISION_EVENTS,
        Velocity::angular(Vec3::new(0.6, 0.0, -0.9)),
        Transform::from_xyz(0.7, 1.6, 0.0).with_rotation(Quat::from_rotation_z(0.7)),
        Vase,
        Name::new("vase"),
    ));
}

/// A chair's hit leaves a disc on the floor, in the colour of the part that hit it.
fn leave_marks(
    mut hits: MessageReader<CollisionEvent>,
    parts: Query<(&ColliderParts, &GlobalTransform), With<HullCollider>>,
    substances: Query<&Substance>,
    context: ReadRapierContext,
    mut commands: Commands,
    server: Res<AssetServer>,
) -> Result {
    let context = context.single()?;
    for hit in hits.read() {
        let CollisionEvent::Started(first, second, _) = *hit else { continue };
        for (own, other) in [(first, second), (second, first)] {
            let Ok((of, place)) = parts.get(own) else { continue };
            let Some(substance) = of.part(0).and_then(|part| substances.get(part).ok()) else {
                continue;
            };
            let at = context.contact_pair(own, other).and_then(|pair| {
                let (_, point) = pair.find_deepest_contact()?;
                let is_first = pair.collider1() == Some(own);
                Some(if is_first { point.local_p1() } else { point.local_p2() })
            });
            let at = place.transform_point(at.unwrap_or_default());
            commands.spawn((
                Mesh3d(server.add(Cylinder::new(0.09, 0.004).mesh().build())),
                MeshMaterial3d(substance.0.clone()),
                Transform::from_xyz(at.x, 0.002, at.z),
            ));
        }
    }
    Ok(())
}

/// A vase that hits something breaks.
fn break_vases(
    mut hits: MessageReader<CollisionEvent>,
    vases: Query<(), With<Vase>>,
    mut commands: Commands,
) {
    for hit in hits.read() {
        let CollisionEvent::Started(first, second, _) = *hit else { continue };
        for vase in [first, second] {
            if vases.contains(vase) {
                commands.entity(vase).break_apart(HullGrouping::EachHull);
            }
        }
    }
}

fn paint_cuts(cut: On<Add<CutFaces>>, inside: Res<Inside>, mut commands: Commands) {
    commands.entity(cut.entity).insert(MeshMaterial3d(inside.0.clone()));
}

/// Boxes by their sizes and their middles.
fn boxes(all: &[([f32; 3], [f32; 3])]) -> Mesh {
    let one = |(size, middle): &([f32; 3], [f32; 3])| {
        Cuboid::from_size(Vec3::from(*size)).mesh().build().translated_by(Vec3::from(*middle))
    };
    let mut whole = one(&all[0]);
    for more in &all[1..] {
        whole.merge(&one(more)).expect("boxes have the same attributes");
    }
    whole
}

/// A profile turned around an axis.
fn vase() -> Mesh {
    let turns = (0..SIDES).map(|side| Vec2::from_angle(TAU * side as f32 / SIDES as f32));
    let ring = |turn: Vec2| PROFILE.map(|[out, up]| [out * turn.x, up - 0.4, out * turn.y]);
    let positions: Vec<[f32; 3]> = turns.flat_map(ring).collect();
    let rows = PROFILE.len() as u32;
    let mut indices = Vec::new();
    for side in 0..SIDES {
        let (here, next) = (side * rows, (side + 1) % SIDES * rows);
        for row in 0..rows - 1 {
            let [a, b, c, d] = [here + row, here + row + 1, next + row, next + row + 1];
            indices.extend([a, b, d, a, d, c]);
        }
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices))
        .with_computed_smooth_normals()
}
