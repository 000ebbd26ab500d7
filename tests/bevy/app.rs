//! An app without a window, and meshes to put into it.

use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use bevy::asset::{AssetPath, AssetPlugin, RenderAssetUsages};
use bevy::ecs::component::Mutable;
use bevy::mesh::{Indices, Mesh, PrimitiveTopology};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_hullwright::prelude::*;
use hullwright_formats::read_mesh;
use hullwright_parry::parry3d::shape::SharedShape;

use crate::engine::*;

pub const DENSITY: f32 = 1000.0;

const FRAME: Duration = Duration::from_micros(16_667);

/// No job of these tests takes anywhere near this long; then something hangs.
const PATIENCE: Duration = Duration::from_secs(60);

pub fn app() -> App {
    app_with(HullwrightSettings::default())
}

pub fn app_with(settings: HullwrightSettings) -> App {
    app_with_assets(settings, assets())
}

/// With a directory to load assets from, and more plugins.
#[cfg(feature = "bevy_gltf")]
pub fn app_with_plugins(file_path: String, add: impl FnOnce(&mut App)) -> App {
    start(new_app(default(), file_path, add))
}

/// With a directory to load assets from.
pub fn app_with_assets(settings: HullwrightSettings, file_path: String) -> App {
    start(new_app(settings, file_path, |_| {}))
}

fn new_app(settings: HullwrightSettings, file_path: String, add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin { file_path, ..default() },
        TransformPlugin,
        physics(),
        hullwright(settings),
    ));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(FRAME));
    app.init_resource::<Seen>();
    app.add_observer(|event: On<DecompositionReady>, mut seen: ResMut<Seen>| {
        seen.ready.push((event.entity, event.hulls));
    });
    app.add_observer(|event: On<DecompositionFailed>, mut seen: ResMut<Seen>| {
        seen.failed.push((event.entity, event.error.to_string()));
    });
    app.add_observer(|event: On<DecompositionSkipped>, mut seen: ResMut<Seen>| {
        seen.skipped.push((event.entity, event.reason));
    });
    app.add_observer(|event: On<DecompositionCancelled>, mut seen: ResMut<Seen>| {
        seen.cancelled.push(event.entity);
    });
    app.add_observer(|event: On<ColliderReady>, mut seen: ResMut<Seen>| {
        seen.with_collider.push((event.entity, event.made_of));
    });
    app.add_observer(|event: On<ColliderAbsent>, mut seen: ResMut<Seen>| {
        seen.without_collider.push((event.entity, event.reason.clone()));
    });
    register_for_saves(&mut app);
    add(&mut app);
    app
}

fn start(mut app: App) -> App {
    app.finish();
    app.cleanup();
    // Engines make their worlds in the first frame.
    app.update();
    app
}

/// What tests do with entities, in few words.
pub trait Entities {
    fn put(&mut self, bundle: impl Bundle) -> Entity;
    fn edit(&mut self, entity: Entity) -> EntityWorldMut<'_>;
    fn get<C: Component>(&self, entity: Entity) -> Option<&C>;
    fn change<C: Component<Mutability = Mutable>>(&mut self, entity: Entity) -> Mut<'_, C>;
    fn load<A: Asset>(&self, path: impl Into<AssetPath<'static>>) -> Handle<A>;
}

impl Entities for App {
    fn put(&mut self, bundle: impl Bundle) -> Entity {
        self.world_mut().spawn(bundle).id()
    }

    fn edit(&mut self, entity: Entity) -> EntityWorldMut<'_> {
        self.world_mut().entity_mut(entity)
    }

    fn get<C: Component>(&self, entity: Entity) -> Option<&C> {
        self.world().get(entity)
    }

    fn change<C: Component<Mutability = Mutable>>(&mut self, entity: Entity) -> Mut<'_, C> {
        self.world_mut().get_mut(entity).unwrap()
    }

    fn load<A: Asset>(&self, path: impl Into<AssetPath<'static>>) -> Handle<A> {
        self.world().resource::<AssetServer>().load(path)
    }
}

pub fn assets() -> String {
    concat!(env!("CARGO_MANIFEST_DIR"), "/assets").into()
}

/// The events so far.
#[derive(Resource, Default)]
pub struct Seen {
    pub ready: Vec<(Entity, usize)>,
    pub failed: Vec<(Entity, String)>,
    pub skipped: Vec<(Entity, SkipReason)>,
    pub cancelled: Vec<Entity>,
    pub with_collider: Vec<(Entity, MadeOf)>,
    pub without_collider: Vec<(Entity, AbsentReason)>,
}

impl Seen {
    /// Events of all kinds. For each there is one that says whether there is a collider.
    pub fn all(&self) -> usize {
        let all = self.ready.len() + self.failed.len() + self.skipped.len() + self.cancelled.len();
        assert_eq!(self.with_collider.len() + self.without_collider.len(), all);
        all
    }
}

/// One of the bundled models.
pub fn model(name: &str) -> Mesh {
    let file = read_mesh(format!("{}/{name}.glb", assets())).unwrap().mesh;
    let positions: Vec<[f32; 3]> =
        file.positions.iter().map(|point| point.map(|x| x as f32)).collect();
    mesh(positions, file.triangles.iter().flatten().copied().collect())
}

pub fn mesh(positions: Vec<[f32; 3]>, indices: Vec<u32>) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices))
}

/// A box from `low` to `high`.
pub fn cuboid(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let at = |index: usize, bit: usize, axis: usize| {
        if index >> bit & 1 == 1 { high[axis] } else { low[axis] }
    };
    let corner = |index: usize| [at(index, 0, 0), at(index, 1, 1), at(index, 2, 2)];
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let indices = quads.iter().flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d]).collect();
    mesh((0..8).map(corner).collect(), indices)
}

pub fn unit_cube() -> Mesh {
    cuboid([0.0; 3], [1.0; 3])
}

pub fn assert_is_unit_cube(app: &App, entity: Entity) {
    assert_bounds(app, entity, [0.0; 3], [1.0; 3], 1e-3);
}

/// An app, and a mesh in it.
pub fn with_mesh(mut app: App, mesh: Mesh) -> (App, Handle<Mesh>) {
    let handle = add(&mut app, mesh);
    (app, handle)
}

pub fn add(app: &mut App, mesh: Mesh) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// Hulls, also without a body.
pub fn tag() -> ConvexDecomposition {
    automatic().with_shape(DecompositionShape::Hulls)
}

/// Hulls of what moves, triangles of all else.
pub fn automatic() -> ConvexDecomposition {
    ConvexDecomposition::default().with_density(DENSITY)
}

pub fn spawn(app: &mut App, mesh: &Handle<Mesh>) -> Entity {
    spawn_with(app, mesh, ())
}

/// A tagged mesh with more components; a tag among them takes the place of the usual one.
pub fn spawn_with(app: &mut App, mesh: &Handle<Mesh>, more: impl Bundle) -> Entity {
    app.world_mut().spawn((Mesh3d(mesh.clone()), tag())).insert(more).id()
}

/// A tagged mesh that has ended, however.
pub fn finish(app: &mut App, mesh: &Handle<Mesh>, more: impl Bundle) -> Entity {
    let entity = spawn_with(app, mesh, more);
    update_until_finished(app, &[entity]);
    entity
}

/// The same in an app of its own.
pub fn finished(mesh: Mesh, more: impl Bundle) -> (App, Entity) {
    finished_with(default(), mesh, more)
}

pub fn finished_with(settings: HullwrightSettings, mesh: Mesh, more: impl Bundle) -> (App, Entity) {
    let (mut app, mesh) = with_mesh(app_with(settings), mesh);
    let entity = finish(&mut app, &mesh, more);
    (app, entity)
}

pub fn set_scale(app: &mut App, entity: Entity, scale: Vec3) {
    app.change::<Transform>(entity).scale = scale;
}

/// At most so many decompositions at once.
pub fn with_jobs(max_jobs: usize) -> HullwrightSettings {
    HullwrightSettings { budget: BudgetSettings { max_jobs, ..default() }, ..default() }
}

/// With a cache on disk.
pub fn with_disk_cache(directory: &Path) -> HullwrightSettings {
    let disk = Some(directory.into());
    HullwrightSettings { cache: CacheSettings { disk, ..default() }, ..default() }
}

pub fn skipping(skip: SkipSettings) -> HullwrightSettings {
    HullwrightSettings { skip, ..default() }
}

/// One step of one job per frame on the main thread, so that each frame has one possible outcome.
pub fn sliced() -> HullwrightSettings {
    HullwrightSettings {
        budget: BudgetSettings {
            execution: Execution::Slices,
            frame_time: Duration::ZERO,
            ..default()
        },
        scale_delay: Duration::ZERO,
        ..default()
    }
}

pub fn status(app: &App, entity: Entity) -> DecompositionStatus {
    app.get::<DecompositionStatus>(entity).unwrap().clone()
}

pub fn is_ready(app: &App, entity: Entity) -> bool {
    matches!(status(app, entity), DecompositionStatus::Ready(_))
}

/// Entities that became ready so far, and how many hulls they got.
pub fn ready(app: &App) -> &[(Entity, usize)] {
    &app.world().resource::<Seen>().ready
}

/// Entities that failed so far, and why.
pub fn failed(app: &App) -> &[(Entity, String)] {
    &app.world().resource::<Seen>().failed
}

pub fn seen(app: &App) -> &Seen {
    app.world().resource::<Seen>()
}

pub fn counters(app: &App) -> DecompositionCounters {
    app.world().resource::<DecompositionCounters>().clone()
}

pub fn collider(app: &App, entity: Entity) -> &Collider {
    app.get::<Collider>(entity).expect("a collider")
}

pub fn has_collider(app: &App, entity: Entity) -> bool {
    app.get::<Collider>(entity).is_some()
}

/// The points of each hull of a collider.
pub fn hulls(app: &App, entity: Entity) -> Vec<Vec<Vec3>> {
    let shape = shape(collider(app, entity));
    let points =
        |shape: &SharedShape| shape.as_convex_polyhedron().expect("a hull").points().to_vec();
    match shape.as_compound() {
        Some(compound) => compound.shapes().iter().map(|(_, part)| points(part)).collect(),
        None => vec![points(shape)],
    }
}

/// Whether normals are at right angles to the faces of all hulls.
pub fn assert_faces_are_right(app: &App, entity: Entity) {
    let shape = shape(collider(app, entity));
    for (_, part) in shape.as_compound().unwrap().shapes() {
        let hull = part.as_convex_polyhedron().unwrap();
        for face in hull.faces() {
            let first = face.first_vertex_or_edge as usize;
            let count = face.num_vertices_or_edges as usize;
            let corners = &hull.vertices_adj_to_face()[first..first + count];
            let points: Vec<Vec3> =
                corners.iter().map(|corner| hull.points()[*corner as usize]).collect();
            for edge in points.windows(2).map(|pair| pair[1] - pair[0]) {
                let cosine = edge.normalize_or_zero().dot(face.normal);
                assert!(cosine.abs() < 0.05, "{cosine}");
            }
        }
    }
}

/// Mass properties of an entity's collider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassOf {
    pub mass: f32,
    pub centre: Vec3,
    pub moments: Vec3,
}

pub fn translation(app: &App, entity: Entity) -> Vec3 {
    app.get::<Transform>(entity).expect("a transform").translation
}

/// The corners of a collider's bounding box.
pub fn bounds(app: &App, entity: Entity) -> (Vec3, Vec3) {
    let bounds = shape(collider(app, entity)).compute_local_aabb();
    (bounds.mins, bounds.maxs)
}

pub fn assert_bounds(
    app: &App,
    entity: Entity,
    low: impl Into<Vec3>,
    high: impl Into<Vec3>,
    tolerance: f32,
) {
    let found = bounds(app, entity);
    assert_near(found.0, low, tolerance);
    assert_near(found.1, high, tolerance);
}

pub fn assert_near(found: Vec3, expected: impl Into<Vec3>, tolerance: f32) {
    let expected = expected.into();
    assert!(found.distance(expected) <= tolerance, "{found} is not {expected}");
}

/// Updates until something holds.
pub fn update_until(app: &mut App, mut holds: impl FnMut(&App) -> bool) {
    let start = Instant::now();
    while !holds(app) {
        assert!(
            start.elapsed() < PATIENCE,
            "it never came true; ready {:?}, failed {:?}, {:?}",
            app.world().get_resource::<Seen>().map(|seen| &seen.ready),
            app.world().get_resource::<Seen>().map(|seen| &seen.failed),
            counters(app)
        );
        app.update();
        std::thread::sleep(Duration::from_micros(200));
    }
}

pub fn update_until_finished(app: &mut App, entities: &[Entity]) {
    update_until(app, |app| entities.iter().all(|entity| status(app, *entity).is_finished()));
}

pub fn update_until_ready_times(app: &mut App, times: usize) {
    update_until(app, |app| ready(app).len() == times);
}

pub fn update_times(app: &mut App, times: usize) {
    (0..times).for_each(|_| app.update());
}

/// What a save has of an entity: the components that reflection knows.
pub fn saved(app: &App, entity: Entity) -> Vec<Box<dyn PartialReflect>> {
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let entity = app.world().entity(entity);
    let all = registry.iter().filter_map(|it| it.data::<ReflectComponent>());
    all.filter_map(|component| component.reflect(entity)?.to_dynamic().ok()).collect()
}

/// As scenes are loaded: what is computed is not.
pub fn load(app: &mut App, saved: &[Box<dyn PartialReflect>]) -> Entity {
    let loaded = app.put(());
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    for component in saved {
        let info = component.get_represented_type_info().expect("a type");
        let data = registry.get_type_data::<ReflectComponent>(info.type_id()).expect("a component");
        if !info.type_path().contains("GlobalTransform") {
            data.insert(&mut app.edit(loaded), &**component, &registry);
        }
    }
    loaded
}

/// Keeps what is logged, by all tests together.
pub struct Log;

static LINES: Mutex<Vec<String>> = Mutex::new(Vec::new());

impl Log {
    pub fn install() {
        // Only the first succeeds, and one is enough.
        let _ = log::set_logger(&Self).map(|()| log::set_max_level(log::LevelFilter::Warn));
    }

    pub fn lines_with(text: &str) -> Vec<String> {
        LINES.lock().unwrap().iter().filter(|line| line.contains(text)).cloned().collect()
    }
}

impl log::Log for Log {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        LINES.lock().unwrap().push(record.args().to_string());
    }

    fn flush(&self) {}
}
