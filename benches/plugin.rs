//! What the Bevy plugin costs the main thread: `cargo bench --ignore-rust-version --bench plugin`.
//!
//! Other programs interrupt frames by milliseconds. On Linux, `chrt --fifo 10` before the program
//! that `cargo bench --ignore-rust-version --no-run` names keeps them away.
//!
//! Measured is what lies between the first and the last of the plugin's systems, with the commands
//! that they issue and the observers that they run; Rapier's own come after them. Beside it, for
//! the same 200 meshes, the frame in which a system calls Parry's V-HACD as bevy_rapier's
//! `AsyncCollider` does. That component itself needs Bevy's renderer.

use std::hint::black_box;
use std::time::{Duration, Instant};

use bevy::asset::{AssetPlugin, RenderAssetUsages};
use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy::tasks::AsyncComputeTaskPool;
use bevy_hullwright::prelude::*;
use bevy_rapier3d::geometry::VHACDParameters;
use bevy_rapier3d::prelude::*;
use hullwright::hulls_format::{BakedMesh, HullScene, HullsFile};
use hullwright::{Control, TriangleMesh, mass_properties};
use hullwright_formats::read_mesh;

const MODELS: [&str; 10] =
    ["mug", "table", "chair", "lamp", "bowl", "plus", "torus", "gear", "l_prism", "u_prism"];

/// Entities that are finished.
const IDLE_ENTITIES: usize = 1000;

const IDLE_FRAMES: usize = 2000;

/// Fewer, since Rapier's step is a part of them.
const FALLING_FRAMES: usize = 300;

/// Meshes that are tagged in one frame.
const MESHES: usize = 200;

/// A frame of a game, about.
const PAUSE: Duration = Duration::from_millis(4);

/// When the plugin's systems began, and how long they took.
#[derive(Resource)]
struct Watch {
    start: Instant,
    taken: Duration,
    /// The same by the processor's clock, which stands still while another program runs; where
    /// Linux has it and it is switched on.
    by_processor: bool,
    processor_start: Duration,
    processor_taken: Duration,
}

/// Time that the processor has given to this thread.
fn processor_time() -> Duration {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let first = text.split_whitespace().next().and_then(|word| word.parse().ok());
    Duration::from_nanos(first.unwrap_or_default())
}

impl Watch {
    fn begin(mut watch: ResMut<Self>) {
        if watch.by_processor {
            watch.processor_start = processor_time();
        }
        watch.start = Instant::now();
    }

    fn end(mut watch: ResMut<Self>) {
        watch.taken = watch.start.elapsed();
        if watch.by_processor {
            watch.processor_taken = processor_time() - watch.processor_start;
        }
    }
}

/// All, or those whose names begin as an argument does.
fn main() {
    let all: [(&str, fn()); 11] = [
        ("idle", idle),
        ("falling", falling),
        ("known mesh", known_mesh),
        ("many meshes", many_meshes),
        ("baked props", baked_props),
        ("look-up", look_up),
        ("breaking", breaking),
        ("pulsing scales", || [30, 500].into_iter().for_each(pulsing)),
        ("tasks of Bevy's", bevys_own_tasks),
        ("Rapier's own", rapiers_own),
        ("level", level),
    ];
    let wanted: Vec<String> = std::env::args().skip(1).filter(|arg| arg != "--bench").collect();
    for (name, measure) in all {
        if wanted.is_empty() || wanted.iter().any(|wanted| name.starts_with(wanted)) {
            measure();
        }
    }
}

fn app() -> App {
    app_with(|_| {})
}

/// As in a game: with Rapier's plugin, so that bodies are frozen and fall.
fn app_with_bodies() -> App {
    let mut app = app_with(|app| {
        app.add_plugins((TransformPlugin, RapierPhysicsPlugin::<NoUserData>::default()));
    });
    // Rapier makes its context in the first frame.
    app.update();
    app
}

fn app_with(add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), HullwrightPlugin::default()));
    add(&mut app);
    app.insert_resource(Watch {
        start: Instant::now(),
        taken: Duration::ZERO,
        by_processor: false,
        processor_start: Duration::ZERO,
        processor_taken: Duration::ZERO,
    });
    // One after the other, so that nothing else runs between the two that look at the clock.
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    app.add_systems(
        PostUpdate,
        (
            Watch::begin.before(HullwrightSystems::DetectChanges),
            Watch::end.after(HullwrightSystems::Attach).before(PhysicsSet::SyncBackend),
        ),
    );
    app.finish();
    app.cleanup();
    app
}

fn taken(app: &App) -> Duration {
    app.world().resource::<Watch>().taken
}

fn microseconds(duration: Duration) -> f64 {
    1e6 * duration.as_secs_f64()
}

/// A model, stretched so that it is another for each number.
fn mesh(number: usize) -> Mesh {
    let name = MODELS[number % MODELS.len()];
    let path = format!("{}/assets/{name}.glb", env!("CARGO_MANIFEST_DIR"));
    let mut file = read_mesh(path).unwrap().mesh;
    let stretch = 1.0 + 0.02 * (number / MODELS.len()) as f64;
    file.positions.iter_mut().for_each(|point| point[0] *= stretch);
    to_bevy(&file)
}

fn to_bevy(mesh: &TriangleMesh) -> Mesh {
    let positions: Vec<[f32; 3]> =
        mesh.positions.iter().map(|point| point.map(|x| x as f32)).collect();
    let indices = mesh.triangles.iter().flatten().copied().collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices))
}

fn add(app: &mut App, mesh: Mesh) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

fn spawn(app: &mut App, mesh: &Handle<Mesh>) {
    let tag = ConvexDecomposition::default().with_shape(DecompositionShape::Hulls);
    app.world_mut().spawn((Mesh3d(mesh.clone()), tag));
}

/// Far enough from the others that they never touch.
fn spawn_body(app: &mut App, mesh: &Handle<Mesh>, number: usize) {
    let place = Transform::from_xyz(10.0 * number as f32, 0.0, 0.0);
    let body = (RigidBody::Dynamic, GravityScale(1.0), place);
    app.world_mut().spawn((Mesh3d(mesh.clone()), body, ConvexDecomposition::default()));
}

fn is_finished(app: &mut App) -> bool {
    let world = app.world_mut();
    world.query::<&DecompositionStatus>().iter(world).all(DecompositionStatus::is_finished)
}

fn update_until_finished(app: &mut App) {
    while !is_finished(app) {
        app.update();
        std::thread::sleep(PAUSE);
    }
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

fn idle() {
    let mut app = app();
    let handle = add(&mut app, mesh(9));
    (0..IDLE_ENTITIES).for_each(|_| spawn(&mut app, &handle));
    update_until_finished(&mut app);
    let cost = cost_per_frame(&mut app, IDLE_FRAMES);
    println!("idle: {IDLE_ENTITIES} finished entities cost {cost:.1} µs per frame (target 5)");
}

/// Every one has a new transform in every frame, whose scale is looked at.
fn falling() {
    let mut app = app_with_bodies();
    let handle = add(&mut app, mesh(9));
    (0..IDLE_ENTITIES).for_each(|number| spawn_body(&mut app, &handle, number));
    update_until_finished(&mut app);
    let cost = cost_per_frame(&mut app, FALLING_FRAMES);
    println!("falling: {IDLE_ENTITIES} finished bodies cost {cost:.1} µs per frame");
}

/// The median, in microseconds.
fn cost_per_frame(app: &mut App, frames: usize) -> f64 {
    let mut times: Vec<Duration> = (0..frames)
        .map(|_| {
            app.update();
            taken(app)
        })
        .collect();
    microseconds(median(&mut times))
}

fn known_mesh() {
    let mut app = app();
    let handle = add(&mut app, mesh(7));
    spawn(&mut app, &handle);
    update_until_finished(&mut app);
    let mut times: Vec<Duration> = (0..IDLE_ENTITIES)
        .map(|_| {
            spawn(&mut app, &handle);
            app.update();
            assert!(is_finished(&mut app), "not in the next frame");
            taken(&app)
        })
        .collect();
    let median = microseconds(median(&mut times));
    println!("known mesh: its collider is there in the next frame, in {median:.1} µs (target 20)");
}

fn many_meshes() {
    let meshes: Vec<Mesh> = (0..MESHES).map(mesh).collect();
    let mut app = app_with_bodies();
    for (number, mesh) in meshes.into_iter().enumerate() {
        let handle = add(&mut app, mesh);
        spawn_body(&mut app, &handle, number);
    }
    app.world_mut().resource_mut::<Watch>().by_processor = true;
    let mut processor_times = Vec::new();
    let start = Instant::now();
    let mut times = Vec::new();
    while !is_finished(&mut app) {
        app.update();
        times.push(taken(&app));
        processor_times.push(app.world().resource::<Watch>().processor_taken);
        std::thread::sleep(PAUSE);
    }
    let seconds = start.elapsed().as_secs_f64();
    let frames = times.len();
    let median = microseconds(median(&mut times)) / 1e3;
    let longest = microseconds(times.pop().unwrap_or_default()) / 1e3;
    let slowest = (processor_times.iter().enumerate()).max_by_key(|(_, time)| **time);
    let (frame, worked) = slowest.map_or((0, 0.0), |(i, time)| (i, microseconds(*time) / 1e3));
    println!(
        "{MESHES} meshes tagged in one frame: ready after {seconds:.1} s and {frames} frames; the \
         plugin's systems take {median:.3} ms in the median frame, {longest:.3} ms in the longest \
         (target 0.5), {worked:.3} ms by the processor's clock, in frame {frame}"
    );
}

/// Meshes of a baked file.
const PROPS: usize = 300;

fn baked_props() {
    let tag = || ConvexDecomposition::default().with_preset(DecompositionPreset::Fast);
    let method = tag().to_parameters();
    let meshes: Vec<Mesh> = (0..PROPS).map(mesh).collect();
    let baked = meshes.iter().enumerate().map(|(number, mesh)| {
        let mesh = bevy_hullwright::triangle_mesh(mesh).unwrap();
        let made = method.decompose(&mesh, &Control::new()).unwrap();
        let mass = mass_properties(&mesh, &made.hulls, 1.0).unwrap();
        let file = HullsFile::new(number.to_string(), &made).with_mass_properties(mass);
        BakedMesh::new(&mesh, method.clone(), file)
    });
    let scene = HullScene::new("props", baked.collect());
    for (name, execution, max_jobs, is_by_name) in [
        ("in the background", Execution::Background, 0, false),
        ("with one job", Execution::Background, 1, false),
        ("in slices, found by their meshes", Execution::Slices, 0, false),
        ("in slices, found by their names", Execution::Slices, 0, true),
    ] {
        let mut app = app_with_bodies();
        let mut settings = app.world_mut().resource_mut::<HullwrightSettings>();
        (settings.budget.execution, settings.budget.max_jobs) = (execution, max_jobs);
        if execution == Execution::Slices {
            // The default where there are no threads.
            settings.budget.frame_time = Duration::from_millis(4);
        }
        let mut scenes = app.world_mut().resource_mut::<Assets<BakedScene>>();
        let scene = scenes.add(BakedScene::new(scene.clone()));
        for (number, mesh) in meshes.iter().enumerate() {
            let place = Transform::from_xyz(10.0 * number as f32, 0.0, 0.0);
            let body = (RigidBody::Dynamic, place);
            if is_by_name {
                let baked = BakedDecomposition::new(scene.clone()).with_mesh(number.to_string());
                app.world_mut().spawn((body, baked));
            } else {
                let mesh = Mesh3d(add(&mut app, mesh.clone()));
                app.world_mut().spawn((body, mesh, tag(), FromBakedScene(scene.clone())));
            }
        }
        let mut frames = 0;
        while !is_finished(&mut app) {
            app.update();
            frames += 1;
            std::thread::sleep(PAUSE);
        }
        let counters = app.world().resource::<DecompositionCounters>();
        assert_eq!((counters.baked, counters.decomposed), (PROPS, 0));
        println!("{PROPS} baked props {name}: all are ready after {frames} frames (target 20)");
    }
}

/// The bound of a level's triangles, and the sides of its cells, in metres.
const LEVEL_BOUND: f32 = 0.02;
const CELLS: [f32; 2] = [10.0, 60.0];

/// A level that never moves, of which an argument names the file, as `cargo lab level DIR -o REPORT
/// --write LEVEL.glb` writes it.
fn level() {
    let Some(path) = std::env::args().find(|argument| argument.ends_with(".glb")) else {
        println!("level: not without the file of one, LEVEL.glb");
        return;
    };
    let scene = hullwright_formats::read_scene(path).unwrap();
    for (name, bound, cell) in [
        ("as it was modelled", None, None),
        ("within 2 cm", Some(LEVEL_BOUND), None),
        ("within 2 cm, cells of 10 m", Some(LEVEL_BOUND), Some(CELLS[0])),
        ("within 2 cm, cells of 60 m", Some(LEVEL_BOUND), Some(CELLS[1])),
    ] {
        let mut app = app_with_bodies();
        app.world_mut().resource_mut::<HullwrightSettings>().level_bound = bound;
        let mut hierarchy = ConvexDecompositionHierarchy::default();
        if let Some(cell) = cell {
            hierarchy = hierarchy.with_cells(cell);
        }
        let root = app.world_mut().spawn((Transform::default(), RigidBody::Fixed, hierarchy)).id();
        for mesh in &scene {
            let handle = add(&mut app, to_bevy(&mesh.mesh));
            for node in &mesh.nodes {
                let columns = node.transform.unwrap_or_default();
                let [x, y, z, place] = columns.map(|column| Vec3::from(column.map(|x| x as f32)));
                let affine =
                    bevy::math::Affine3A::from_cols(x.into(), y.into(), z.into(), place.into());
                let transform = Transform::from_matrix(affine.into());
                app.world_mut().spawn((Mesh3d(handle.clone()), transform, ChildOf(root)));
            }
        }
        app.world_mut().resource_mut::<Watch>().by_processor = true;
        let (start, mut times, mut longest) = (Instant::now(), Vec::new(), Duration::ZERO);
        // The tags of the hierarchy come in the first frame.
        while times.is_empty() || !is_finished(&mut app) {
            app.update();
            times.push(taken(&app));
            longest = longest.max(app.world().resource::<Watch>().processor_taken);
            std::thread::sleep(PAUSE);
        }
        let (seconds, frames) = (start.elapsed().as_secs_f64(), times.len());
        let world = app.world_mut();
        let colliders = world.query::<&Collider>().iter(world).count();
        let [wall, longest] = [times.iter().max().copied().unwrap_or_default(), longest]
            .map(|time| microseconds(time) / 1e3);
        println!(
            "level {name}: {colliders} colliders after {seconds:.1} s and {frames} frames; the plugin's \
             systems take {longest:.2} ms in the longest by the processor's clock, {wall:.2} ms on \
             the wall (target 4)"
        );
    }
}

/// From the index of a hull, or of a triangle, to the entity with its mesh: in a query by entity,
/// as after a ray.
fn look_up() {
    let (hulls, triangles) = (DecompositionShape::Hulls, DecompositionShape::Triangles);
    for (name, shape) in [("hull", hulls), ("triangle", triangles)] {
        let mut app = app();
        let tag = ConvexDecomposition::default().with_shape(shape);
        let whole = app.world_mut().spawn((tag, Transform::default())).id();
        for number in 0..MODELS.len() {
            let mesh = Mesh3d(add(&mut app, mesh(number)));
            let place = Transform::from_xyz(number as f32, 0.0, 0.0);
            app.world_mut().spawn((mesh, place, ChildOf(whole)));
        }
        update_until_finished(&mut app);
        let mut parts = app.world_mut().query::<&ColliderParts>();
        let start = Instant::now();
        let mut found = 0;
        for number in 0..LOOK_UPS {
            let of = parts.get(app.world(), whole).unwrap();
            found += usize::from(of.part(black_box(number % MOST_SUBSHAPES)).is_some());
        }
        let each = microseconds(start.elapsed()) * 1e3 / f64::from(LOOK_UPS);
        assert_eq!(found, LOOK_UPS as usize);
        println!("look-up: from a {name} to its part in {each:.0} ns (target 1000)");
    }
}

const LOOK_UPS: u32 = 1_000_000;

/// Fewer than ten models have hulls together.
const MOST_SUBSHAPES: u32 = 16;

fn breaking() {
    for (number, name) in MODELS.iter().enumerate() {
        let mut times: Vec<Duration> = (0..BROKEN)
            .map(|_| {
                let mut app = app_with_bodies();
                let mesh = add(&mut app, mesh(number));
                spawn_body(&mut app, &mesh, 0);
                update_until_finished(&mut app);
                let world = app.world_mut();
                let mut bodies = world.query_filtered::<Entity, With<ConvexDecomposition>>();
                let body = bodies.single(world).unwrap();
                let start = Instant::now();
                world.commands().entity(body).break_apart(HullGrouping::EachHull);
                world.flush();
                start.elapsed()
            })
            .collect();
        let each = microseconds(median(&mut times)) / 1e3;
        println!("breaking: {name} into a body for each hull in {each:.2} ms");
    }
}

/// Each model is broken so many times.
const BROKEN: usize = 9;

const PULSES: usize = 120;

/// A frame, and how long all of it takes.
fn timed_update(app: &mut App) -> Duration {
    let start = Instant::now();
    app.update();
    let taken = start.elapsed();
    std::thread::sleep(PAUSE);
    taken
}

/// How late colliders are whose scale changes in each frame, and what that costs.
fn pulsing(count: usize) {
    let mut app = app_with_bodies();
    let meshes: Vec<Handle<Mesh>> =
        (0..MODELS.len()).map(|number| add(&mut app, mesh(number))).collect();
    for number in 0..count {
        spawn_body(&mut app, &meshes[number % meshes.len()], number);
    }
    // What falls ever faster costs Rapier more in each frame.
    let world = app.world_mut();
    world.query::<&mut GravityScale>().iter_mut(world).for_each(|mut scale| scale.0 = 0.0);
    update_until_finished(&mut app);
    let mut at_rest: Vec<Duration> = (0..PULSES).map(|_| timed_update(&mut app)).collect();
    let mut all = app.world_mut().query::<(&mut Transform, &Collider)>();
    // What Bevy and Rapier do where a game moves all of it.
    let mut moved: Vec<Duration> = (0..PULSES)
        .map(|_| {
            all.iter_mut(app.world_mut()).for_each(|(mut place, _)| place.translation.y += 0.01);
            timed_update(&mut app)
        })
        .collect();
    let height = |collider: &Collider| collider.raw.compute_local_aabb().extents().y;
    let before: Vec<f32> = all.iter(app.world()).map(|(_, of)| height(of)).collect();
    let (mut scales, mut own, mut frames, mut latest) = (vec![1.0], Vec::new(), Vec::new(), 0);
    let is_near = |found: f32, scale: f32| (found / scale - 1.0).abs() < 2e-3;
    for frame in 1..=PULSES {
        let scale = 1.0 + 0.01 * frame as f32;
        scales.push(scale);
        all.iter_mut(app.world_mut()).for_each(|(mut place, _)| place.scale = Vec3::splat(scale));
        frames.push(timed_update(&mut app));
        own.push(taken(&app));
        for ((_, collider), before) in all.iter(app.world()).zip(&before) {
            let found = height(collider) / before;
            let at = scales.iter().rposition(|scale| is_near(found, *scale));
            latest = latest.max(at.map_or(frame, |at| frame - at));
        }
    }
    let start = Instant::now();
    let last = scales.last().copied().unwrap_or(1.0);
    let mut late = 0;
    while !all.iter(app.world()).zip(&before).all(|((_, of), by)| is_near(height(of) / by, last)) {
        timed_update(&mut app);
        late += 1;
    }
    let seconds = start.elapsed().as_secs_f64();
    let [at_rest, moved, own, pulsing] = [&mut at_rest, &mut moved, &mut own, &mut frames]
        .map(|times| microseconds(median(times)) / 1e3);
    println!(
        "{count} pulsing scales: colliders are {latest} frames behind at most (target 1), and right {seconds:.2} s and \
         {late} frames after the last change (target 0.5 s); the plugin takes {own:.2} ms, and the whole frame \
         {pulsing:.2} ms, {:.2} ms more than at rest (target 2) and {:.2} ms more than where all of it is moved",
        pulsing - at_rest,
        pulsing - moved
    );
}

/// A sphere with bumps, of about `triangles` triangles.
fn bumpy_sphere(triangles: usize) -> Mesh {
    let rings = ((triangles / 4) as f32).sqrt() as u32;
    let segments = 2 * rings;
    let point = |ring: u32, segment: u32| {
        let (up, around) = (
            std::f32::consts::PI * ring as f32 / rings as f32,
            std::f32::consts::TAU * segment as f32 / segments as f32,
        );
        let radius = 1.0 + 0.15 * (8.0 * up).sin() * (8.0 * around).sin();
        [up.sin() * around.cos(), up.cos(), up.sin() * around.sin()].map(|x| radius * x)
    };
    let all = (0..=rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment)));
    let positions: Vec<[f32; 3]> = all.map(|(ring, segment)| point(ring, segment)).collect();
    let at = |ring: u32, segment: u32| ring * segments + segment % segments;
    let quads = (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment)));
    let indices = quads.flat_map(|(ring, segment)| {
        let [a, b] = [at(ring, segment), at(ring, segment + 1)];
        let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
        [a, b, c, b, d, c]
    });
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(indices.collect()))
}

/// How long a trivial task on Bevy's pool waits beside decompositions.
fn bevys_own_tasks() {
    let thirty = || (0..30).map(|number| mesh(10 * number)).collect::<Vec<_>>();
    for (name, meshes) in
        [("30 decompositions", thirty()), ("one of 93,000 triangles", vec![bumpy_sphere(93_000)])]
    {
        let mut app = app();
        for mesh in meshes {
            let mesh = add(&mut app, mesh);
            spawn(&mut app, &mesh);
        }
        let mut waits = Vec::new();
        while !is_finished(&mut app) {
            app.update();
            let start = Instant::now();
            let task = AsyncComputeTaskPool::get().spawn(async move { start.elapsed() });
            waits.push(bevy::tasks::block_on(task));
            std::thread::sleep(PAUSE);
        }
        let longest = 1e3 * waits.iter().max().map_or(0.0, Duration::as_secs_f64);
        let middle = 1e3 * median(&mut waits).as_secs_f64();
        println!(
            "a task of Bevy's own beside {name}: starts within {middle:.2} ms in the median, \
             {longest:.2} ms at most (target 5)"
        );
    }
}

/// Frames until each of the meshes has a collider, with Rapier's plugin and without ours.
fn blocking_decomposition(meshes: &[Mesh]) {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), TransformPlugin));
    app.init_asset::<Mesh>().add_plugins(RapierPhysicsPlugin::<NoUserData>::default());
    app.add_systems(Update, decompose_in_a_system);
    app.finish();
    app.cleanup();
    // Rapier makes its context in the first frame.
    app.update();
    for mesh in meshes {
        let mesh = Mesh3d(add(&mut app, mesh.clone()));
        app.world_mut().spawn(mesh);
    }
    let mut longest = Duration::ZERO;
    let mut frames = 0;
    loop {
        let start = Instant::now();
        app.update();
        longest = longest.max(start.elapsed());
        frames += 1;
        let world = app.world_mut();
        let mut missing = world.query_filtered::<(), (With<Mesh3d>, Without<Collider>)>();
        if missing.iter(world).next().is_none() {
            break;
        }
    }
    let (seconds, count) = (longest.as_secs_f64(), meshes.len());
    println!(
        "Parry's V-HACD in a system: {count} meshes in {frames} frames, the longest takes \
         {seconds:.1} s"
    );
}

/// What `Collider::from_bevy_mesh` does.
fn decompose_in_a_system(
    mut commands: Commands,
    meshes: Res<Assets<Mesh>>,
    tagged: Query<(Entity, &Mesh3d), Without<Collider>>,
) {
    for (entity, mesh) in &tagged {
        let Some(mesh) = meshes.get(mesh) else { continue };
        let (positions, triangles) = parts(mesh);
        let parameters = VHACDParameters::default();
        let collider =
            Collider::convex_decomposition_with_params(&positions, &triangles, &parameters);
        commands.entity(entity).insert(collider);
    }
}

fn rapiers_own() {
    let meshes: Vec<Mesh> = (0..MESHES).map(mesh).collect();
    blocking_decomposition(&meshes);
}

fn parts(mesh: &Mesh) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|p| p.as_float3()).unwrap();
    let indices: Vec<u32> = mesh.indices().unwrap().iter().map(|i| i as u32).collect();
    let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    (positions.iter().map(|p| Vec3::from(*p)).collect(), triangles)
}
