//! The plugin in a browser: a game without a window, whose page counts and times the frames.
//!
//! 300 props take baked hulls by their names, 50 are decomposed, and 8 pieces of ground are
//! simplified; or all have boxes instead, for comparison.
#![cfg(all(target_family = "wasm", target_os = "unknown"))]

use std::cell::Cell;
use std::f32::consts::{PI, TAU};
use std::time::Duration;

use bevy::app::TaskPoolPlugin;
use bevy::asset::{AssetPlugin, RenderAssetUsages};
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy::time::TimePlugin;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::prelude::*;
use serde_json::json;
use wasm_bindgen::prelude::wasm_bindgen;
use web_time::Instant;

/// The baked props have the numbers up to this as names.
const BAKED: usize = 300;

const DECOMPOSED: usize = 50;

/// Pieces of ground, which never move.
const GROUNDS: usize = 8;

/// How far the ground that is touched may be from the one that is seen, in metres.
const GROUND_BOUND: f32 = 0.02;

/// A cache in which some results have room.
const SMALL_CACHE: u64 = 64 << 10;

/// So far from each other that they never touch: Rapier's work is the same in all modes.
const DISTANCE: f32 = 10.0;

/// A game. Its page calls `update` for every frame.
#[wasm_bindgen]
pub struct Game {
    app: App,
}

#[wasm_bindgen]
impl Game {
    /// `mode` is `worker`, `slices`, `cached` for workers and a cache, `cached-some` for one that
    /// is too small, or `boxes` for no decomposition. The files for workers are in `folder`.
    #[wasm_bindgen(constructor)]
    pub fn new(mode: &str, folder: &str) -> Game {
        let mut app = App::new();
        app.add_plugins((TaskPoolPlugin::default(), TimePlugin, AssetPlugin::default()));
        app.add_plugins((TransformPlugin, HullwrightPlugin::default()));
        app.add_plugins(RapierPhysicsPlugin::<NoUserData>::default());
        let mut settings = app.world_mut().resource_mut::<HullwrightSettings>();
        settings.budget.worker_folder = folder.into();
        match mode {
            "slices" => settings.budget.execution = Execution::Slices,
            "cached" => settings.cache.disk = Some("hullwright".into()),
            "cached-some" => {
                settings.cache.disk = Some("hullwright".into());
                settings.cache.disk_bytes = SMALL_CACHE;
            }
            _ => {}
        }
        app.add_systems(
            PostUpdate,
            (
                begin.before(HullwrightSystems::DetectChanges),
                end.after(HullwrightSystems::Attach).before(PhysicsSet::SyncBackend),
            ),
        );
        app.finish();
        app.cleanup();
        app.update();
        let is_boxes = mode == "boxes";
        let scene = app.world().resource::<AssetServer>().load("props.hullscene");
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        let meshes: Vec<_> = (0..DECOMPOSED).map(|number| meshes.add(bumpy_ring(number))).collect();
        for number in 0..BAKED + DECOMPOSED {
            let place = Transform::from_xyz(DISTANCE * number as f32, 0.0, 0.0);
            // What falls fast costs Rapier more with hulls than with a box: it weighs each hull in
            // each step.
            let body = (RigidBody::Dynamic, GravityScale(0.0), place);
            let mut prop = app.world_mut().spawn(body);
            match number.checked_sub(BAKED) {
                _ if is_boxes => prop.insert(Collider::cuboid(0.5, 0.5, 0.5)),
                None => prop
                    .insert(BakedDecomposition::new(scene.clone()).with_mesh(number.to_string())),
                Some(number) => {
                    let mesh = meshes.get(number).cloned().unwrap_or_default();
                    prop.insert((Mesh3d(mesh), ConvexDecomposition::default()))
                }
            };
        }
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        let grounds: Vec<_> = (0..GROUNDS).map(|number| meshes.add(ground(number))).collect();
        for (number, mesh) in grounds.into_iter().enumerate() {
            let place = Transform::from_xyz(DISTANCE * number as f32, -20.0, 0.0);
            let mut ground = app.world_mut().spawn((RigidBody::Fixed, place));
            match is_boxes {
                true => ground.insert(Collider::cuboid(4.0, 0.1, 4.0)),
                false => ground.insert((
                    Mesh3d(mesh),
                    ConvexDecomposition::default().with_level_bound(GROUND_BOUND),
                )),
            };
        }
        Game { app }
    }

    /// One frame.
    pub fn update(&mut self) {
        self.app.update();
    }

    /// Despawns all props that are not finished, and spawns another one.
    pub fn replace_unfinished(&mut self) {
        let world = self.app.world_mut();
        let mut props = world.query::<(Entity, &RigidBody, &DecompositionStatus)>();
        let unfinished = props
            .iter(world)
            .filter(|(_, body, status)| **body == RigidBody::Dynamic && !status.is_finished());
        let unfinished: Vec<Entity> = unfinished.map(|(entity, ..)| entity).collect();
        for entity in unfinished {
            world.despawn(entity);
        }
        let mesh = world.resource_mut::<Assets<Mesh>>().add(bumpy_ring(DECOMPOSED));
        world.spawn((RigidBody::Dynamic, Mesh3d(mesh), ConvexDecomposition::default()));
    }

    /// JSON: how many props have their hulls, and where from; pieces of ground that were
    /// simplified, and the triangles of all.
    pub fn counters(&mut self) -> String {
        let counters = self.app.world().resource::<DecompositionCounters>();
        let (baked, decomposed) = (counters.baked, counters.decomposed);
        let (cached, simplified) = (counters.from_disk, counters.simplified);
        let world = self.app.world_mut();
        let mut statuses = world.query::<&DecompositionStatus>();
        let left = statuses.iter(world).filter(|status| !status.is_finished()).count();
        let failed =
            statuses.iter(world).filter(|status| status.has_collider() == Some(false)).count();
        let mut colliders = world.query::<&Collider>();
        let grounds = colliders.iter(world).filter_map(Collider::as_trimesh);
        let triangles: usize = grounds.map(|mesh| mesh.indices().len()).sum();
        let plugin = 1e3 * TAKEN.get().as_secs_f64();
        json!({ "plugin": plugin, "baked": baked, "decomposed": decomposed, "cached": cached, "simplified": simplified, "triangles": triangles, "left": left, "failed": failed })
            .to_string()
    }
}

thread_local! {
    /// When the plugin's systems began.
    static START: Cell<Option<Instant>> = const { Cell::new(None) };
    /// How long they took in the last frame.
    static TAKEN: Cell<Duration> = const { Cell::new(Duration::ZERO) };
}

fn begin() {
    START.set(Some(Instant::now()));
}

fn end() {
    TAKEN.set(START.get().map_or(Duration::ZERO, |start| start.elapsed()));
}

/// A ring with bumps, of 800 to 5,600 triangles.
fn bumpy_ring(number: usize) -> Mesh {
    let (around, across) = (40 + 2 * number as u32, 10 + (number as u32) / 3);
    let bumps = 3.0 + (number % 5) as f32;
    let point = |i: u32, j: u32| {
        let (u, v) = (TAU * i as f32 / around as f32, TAU * j as f32 / across as f32);
        let thick = 0.25 + 0.08 * (bumps * u).sin() * (2.0 * v + PI / 3.0).cos();
        let out = 1.0 + thick * v.cos();
        [out * u.cos(), thick * v.sin(), out * u.sin()]
    };
    let all = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let positions = all.clone().map(|(i, j)| point(i, j)).collect();
    mesh(positions, all, |i, j| (i % around) * across + j % across)
}

/// Hills on a square of 8 m, of 20,000 triangles.
fn ground(number: usize) -> Mesh {
    const CELLS: u32 = 100;
    let point = |i: u32, j: u32| {
        let [x, z] = [i, j].map(|k| 8.0 * k as f32 / CELLS as f32 - 4.0);
        let shift = number as f32;
        [x, 0.3 * (1.3 * x + shift).sin() * (0.9 * z - shift).cos(), z]
    };
    let positions = (0..=CELLS).flat_map(|i| (0..=CELLS).map(move |j| point(i, j))).collect();
    let cells = (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j)));
    mesh(positions, cells, |i, j| i * (CELLS + 1) + j)
}

/// Two triangles for each cell of a grid, whose vertices `at` numbers.
fn mesh(
    positions: Vec<[f32; 3]>,
    cells: impl Iterator<Item = (u32, u32)>,
    at: impl Fn(u32, u32) -> u32,
) -> Mesh {
    let indices = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [a, c, b, a, d, c]
    });
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices.collect()))
}
