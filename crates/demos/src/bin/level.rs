//! What never moves, with its triangles drawn: as it was modelled, and within a bound. Boxes slide
//! over both: `cargo window level`.

use bevy::asset::RenderAssetUsages;
use bevy::light::NotShadowCaster;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright_demos::orbit::Orbit;
use hullwright_demos::{ShownHulls, Stage};

/// The bounds of the two slopes, in metres; 0 for the triangles as they were modelled.
const BOUNDS: [f32; 2] = [0.0, 0.02];

/// Width and length of a slope, in metres.
const SIZE: Vec2 = Vec2::new(2.2, 3.4);

/// Squares along each.
const SQUARES: [u32; 2] = [66, 102];

/// Rocks on each slope: where, how large.
const ROCKS: [(Vec2, f32); 7] = [
    (Vec2::new(-0.85, -1.2), 0.16),
    (Vec2::new(-0.65, -0.3), 0.10),
    (Vec2::new(0.80, -0.9), 0.20),
    (Vec2::new(0.95, 0.2), 0.09),
    (Vec2::new(-0.90, 0.7), 0.22),
    (Vec2::new(0.60, 1.1), 0.13),
    (Vec2::new(-0.30, 1.45), 0.08),
];

const GRASS: Color = Color::srgb(0.55, 0.66, 0.42);
const STONE: Color = Color::srgb(0.62, 0.60, 0.58);
const CRATE: Color = Color::srgb(0.80, 0.45, 0.30);
const LINES: Color = Color::srgb(0.10, 0.16, 0.24);

fn main() -> AppExit {
    let stage = Stage {
        caption: "Colliders of what never moves: all triangles, and those that 2 cm allow. Boxes slide over both.",
        width: 6.0,
        view: Orbit::new(Vec3::new(0.0, 0.35, 0.0), 2.5).from_angles(0.0, 0.75),
    };
    App::new()
        .insert_resource(ShownHulls(false))
        .add_plugins((hullwright_demos::plugins("What never moves"), stage))
        .add_systems(Startup, set_up)
        .add_systems(Update, draw_triangles)
        .run()
}

fn set_up(mut commands: Commands, server: Res<AssetServer>) {
    let [grass, stone, paint] =
        [GRASS, STONE, CRATE].map(|colour| server.add(StandardMaterial::from(colour)));
    let ground = server.add(ground());
    let rock = server.add(Sphere::new(1.0).mesh().build());
    let crate_mesh = server.add(Cuboid::from_length(0.22).mesh().build());
    for (side, bound) in [-1.0, 1.0].into_iter().zip(BOUNDS) {
        let place = Transform::from_xyz(side * (SIZE.x / 2.0 + 0.1), 0.0, 0.0);
        let tag = ConvexDecomposition::default().with_level_bound(bound);
        // The rocks of a metre share a collider.
        let cells = (bound > 0.0).then_some(1.0);
        let scene = ConvexDecompositionHierarchy::new(tag).with_cells(cells);
        let slope = (RigidBody::Fixed, place, Visibility::default(), Friction::new(0.1), scene);
        let slope = commands.spawn(slope).id();
        let (mesh, material) = (Mesh3d(ground.clone()), MeshMaterial3d(grass.clone()));
        commands.spawn((mesh, material, Transform::default(), ChildOf(slope)));
        for (at, radius) in ROCKS {
            let place = Transform::from_xyz(at.x, height(at) + 0.3 * radius, at.y);
            let (mesh, material) = (Mesh3d(rock.clone()), MeshMaterial3d(stone.clone()));
            let place = place.with_scale(Vec3::new(radius, 0.8 * radius, radius));
            commands.spawn((mesh, material, place, ChildOf(slope)));
        }
        for x in [-0.35, 0.25] {
            let at = Vec2::new(x, -1.45);
            let box_at = place.translation + Vec3::new(at.x, height(at) + 0.16, at.y);
            commands.spawn((
                Mesh3d(crate_mesh.clone()),
                MeshMaterial3d(paint.clone()),
                Transform::from_translation(box_at),
                RigidBody::Dynamic,
                Collider::cuboid(0.11, 0.11, 0.11),
                Friction::new(0.1),
                Damping { linear_damping: 0.4, angular_damping: 1.0 },
                Name::new("box"),
            ));
        }
    }
}

/// A slope down to the front, with waves.
fn height(at: Vec2) -> f32 {
    let down = 0.5 - at.y / SIZE.y;
    let waves = 0.05 * (3.1 * at.x + 1.0).sin() * (2.3 * at.y).cos();
    0.05 + 0.95 * down * down + waves * (1.0 - down * down)
}

fn ground() -> Mesh {
    let [across, along] = SQUARES;
    let row = across + 1;
    let share = |index: u32, of: u32| index as f32 / of as f32 - 0.5;
    let points: Vec<[f32; 3]> = (0..row * (along + 1))
        .map(|index| Vec2::new(share(index % row, across), share(index / row, along)) * SIZE)
        .map(|at| [at.x, height(at), at.y])
        .collect();
    let squares = (0..along).flat_map(|z| (0..across).map(move |x| z * row + x));
    let triangles = squares.flat_map(|a| [a, a + row, a + 1, a + 1, a + row, a + row + 1]);
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, points)
        .with_inserted_indices(Indices::U32(triangles.collect()))
        .with_computed_normals()
}

/// Draws the triangles of new colliders.
fn draw_triangles(
    mut commands: Commands,
    server: Res<AssetServer>,
    // In the frame after the one in which they came, when their places are known.
    new: Query<(Entity, &Collider, &GlobalTransform), Added<Collider>>,
) {
    let material = StandardMaterial { unlit: true, ..LINES.into() };
    for (entity, collider, place) in &new {
        let Some(mesh) = collider.raw.as_trimesh() else { continue };
        info!("{entity}: {} triangles", mesh.indices().len());
        let points: Vec<Vec3> = mesh
            .triangles()
            .flat_map(|triangle| {
                [triangle.a, triangle.b, triangle.b, triangle.c, triangle.c, triangle.a]
            })
            .map(|point| Vec3::from(point.to_array()) + 0.006 * Vec3::Y)
            .collect();
        let lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, points);
        // The scale is in the points.
        let place = place.compute_transform().with_scale(Vec3::ONE);
        commands.spawn((
            Mesh3d(server.add(lines)),
            MeshMaterial3d(server.add(material.clone())),
            NotShadowCaster,
            place,
        ));
    }
}
