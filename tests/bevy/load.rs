//! Random worlds: whatever happens to entities and meshes, in any order and while jobs are at work,
//! in the end each collider is what a fresh app makes of that world, and nothing is left behind.

use std::collections::VecDeque;

use bevy::ecs::entity::EntityHashMap;
use bevy::ecs::entity_disabling::Disabled;
use bevy::mesh::Mesh;
use bevy::prelude::*;
use bevy_hullwright::HullSource;
use bevy_hullwright::prelude::*;
use hullwright::hulls_format::HullsFile;

use crate::app::*;
use crate::engine::*;

/// Worlds in each run, every second of which does its work on threads.
const WORLDS: u64 = 20;

/// As many of them are enough for each time, with two engines.
const WORLDS_EACH_TIME: u64 = 10;
const FRAMES: usize = 500;

/// At a time.
const ENTITIES: usize = 40;
const MESHES: usize = 8;

/// Xorshift (Marsaglia 2003).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }

    /// From 1/2 to 4, in steps that tell sizes apart.
    fn size(&mut self) -> f32 {
        (1 + self.below(8)) as f32 / 2.0
    }
}

/// A box, or an L of the same extents: a mesh of one hull or two.
fn body(size: f32, is_l: bool) -> Mesh {
    if !is_l {
        return cuboid([0.0; 3], [size; 3]);
    }
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let at = |z: f32| outline.map(|[x, y]: [f32; 2]| [x * size / 2.0, y * size / 2.0, z]);
    let fill = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let bottom = fill.iter().flat_map(|&[a, b, c]| [a, c, b]);
    let top = fill.iter().flat_map(|&[a, b, c]| [a + 6, b + 6, c + 6]);
    let walls = (0..6).flat_map(|a| {
        let b = (a + 1) % 6;
        [a, b, b + 6, a, b + 6, a + 6]
    });
    let positions = at(0.0).into_iter().chain(at(size)).collect();
    mesh(positions, bottom.chain(top).chain(walls).collect())
}

/// What the game itself has tagged, and not a hierarchy.
#[derive(Component, Reflect, Clone, Default)]
#[reflect(Component, Default, Clone)]
struct TaggedByGame;

/// The mesh of an entity by its number, which a save has.
#[derive(Component, Reflect, Clone, Copy, Default)]
#[reflect(Component, Default, Clone)]
struct MeshNumber(usize);

/// The game itself has put the collider there. A save has neither.
#[derive(Component, Clone, Default)]
struct GamesCollider;

/// The last word about an entity's collider.
#[derive(Resource, Default)]
struct Last(EntityHashMap<bool>);

struct RandomWorld {
    app: App,
    random: Random,
    meshes: Vec<Handle<Mesh>>,
    /// Despawned ones among them.
    entities: Vec<Entity>,
    /// What happened, for whoever looks for a cause.
    log: Vec<String>,
}

impl RandomWorld {
    fn new(seed: u64) -> Self {
        let mut settings = match seed % 2 {
            0 => sliced(),
            _ => with_jobs(2),
        };
        settings.scale_delay = std::time::Duration::ZERO;
        // So little that it is full all the time.
        settings.cache.memory_bytes = 8 << 10;
        let mut app = app_with(settings);
        app.init_resource::<Last>();
        app.register_type::<TaggedByGame>().register_type::<MeshNumber>();
        app.add_observer(|event: On<ColliderReady>, mut last: ResMut<Last>| {
            last.0.insert(event.entity, true);
        });
        app.add_observer(|event: On<ColliderAbsent>, mut last: ResMut<Last>| {
            last.0.insert(event.entity, false);
        });
        // The multiplier tells the seeds' bits apart.
        let mut random = Random((seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let meshes = (0..MESHES).map(|_| {
            let mesh = body(random.size(), random.below(2) == 0);
            add(&mut app, mesh)
        });
        let meshes = meshes.collect();
        Self { app, random, meshes, entities: Vec::new(), log: Vec::new() }
    }

    fn put(&mut self, bundle: impl Bundle) -> Entity {
        let entity = self.app.put(bundle);
        self.entities.push(entity);
        entity
    }

    fn mesh(&mut self) -> (Mesh3d, MeshNumber) {
        let number = self.random.below(MESHES);
        (Mesh3d(self.meshes[number].clone()), MeshNumber(number))
    }

    fn transform(&mut self) -> Transform {
        let x = self.random.below(4) as f32;
        let turn = Quat::from_rotation_y(self.random.below(3) as f32);
        let scale = Vec3::splat(self.random.size());
        match self.random.below(4) {
            // By which primitives of one mesh are known.
            0 => Transform::IDENTITY,
            _ => Transform { translation: Vec3::new(x, 1.0, 0.0), rotation: turn, scale },
        }
    }

    fn tag(&mut self) -> ConvexDecomposition {
        let shapes =
            [DecompositionShape::Auto, DecompositionShape::Hulls, DecompositionShape::Cuboid];
        let bounds = [MaxError::Share(0.02), MaxError::Share(0.04), MaxError::Metres(0.05)];
        let fallbacks = [FallbackCollider::None, FallbackCollider::BoundingBox];
        tag()
            .with_shape(shapes[self.random.below(3)])
            .with_max_error(bounds[self.random.below(3)])
            .with_density((1 + self.random.below(3)) as f32)
            .with_fallback_collider(fallbacks[self.random.below(2)])
    }

    /// A body that stays where it is and meets nothing: heaps take the engine's time, not the
    /// plugin's.
    fn body(&mut self) -> impl Bundle + use<> {
        let kinds = [RigidBody::Dynamic, KINEMATIC, FIXED];
        let alone = alone();
        (kinds[self.random.below(3)], GravityScale(0.0), alone)
    }

    fn spawn(&mut self) {
        let (place, tag) = (self.transform(), self.tag());
        let top = match self.random.below(3) {
            0 => {
                let (mesh, body) = (self.mesh(), self.body());
                self.put((mesh, tag, TaggedByGame, place, body))
            }
            1 => {
                let body = self.body();
                self.put((tag, TaggedByGame, place, body))
            }
            _ => self.put((ConvexDecompositionHierarchy::new(tag), place)),
        };
        if self.random.below(6) == 0 && ALLOWS_DISABLING {
            self.app.edit(top).insert(Disabled);
        }
        for number in 0..self.random.below(4) {
            let (mesh, place) = (self.mesh(), self.transform());
            self.put((mesh, place, Name::new(format!("part {number}")), ChildOf(top)));
        }
        self.log.push(format!("spawn {top}"));
    }

    /// One of those that are there.
    fn any(&mut self) -> Option<Entity> {
        let world = self.app.world();
        self.entities.retain(|entity| world.get_entity(*entity).is_ok());
        let index = self.random.below(self.entities.len());
        self.entities.get(index).copied()
    }

    fn event(&mut self) {
        let Some(entity) = self.any() else { return self.spawn() };
        let kind = self.random.below(20);
        if kind < 3 && self.entities.len() < ENTITIES {
            return self.spawn();
        }
        let above = self.app.get::<ChildOf>(entity).map(ChildOf::parent);
        self.log.push(format!("{kind} {entity} below {above:?}"));
        let is_tagged = self.app.get::<TaggedByGame>(entity).is_some();
        let is_scene = self.app.get::<ConvexDecompositionHierarchy>(entity).is_some();
        let has_mesh = self.app.get::<Mesh3d>(entity).is_some();
        match kind {
            0..=2 => _ = self.app.world_mut().despawn(entity),
            3 if ALLOWS_OTHER_PARENTS => {
                let above = self.any().expect("that one at least");
                let is_below = |mut below| loop {
                    if below == entity {
                        return true;
                    }
                    match self.app.get::<ChildOf>(below) {
                        Some(of) => below = of.parent(),
                        None => return false,
                    }
                };
                // A body below a body that moves is moved twice by bevy_rapier.
                let is_body = self.app.get::<RigidBody>(entity).is_some();
                match is_body || is_below(above) {
                    true => _ = self.app.edit(entity).remove::<ChildOf>(),
                    false => _ = self.app.edit(entity).insert(ChildOf(above)),
                }
            }
            // bevy_rapier panics where the mass of a disabled body changes.
            4 if ALLOWS_DISABLING && !is_scene && self.app.get::<RigidBody>(entity).is_none() => {
                _ = self.app.edit(entity).insert(Disabled)
            }
            5 | 6 => _ = self.app.edit(entity).remove::<Disabled>(),
            7 if self.entities.len() < ENTITIES => {
                let clone = clone_of(&mut self.app, entity);
                self.entities.push(clone);
            }
            8 if ALLOWS_OTHER_PARENTS => {
                let saved = saved(&self.app, entity);
                let children = self.app.get::<Children>(entity).map(|all| all.to_vec());
                self.app.edit(entity).detach_all_children();
                self.app.world_mut().despawn(entity);
                let loaded = load(&mut self.app, &saved);
                self.app.edit(loaded).remove::<Children>();
                if let Some(MeshNumber(number)) = self.app.get(loaded).copied() {
                    let mesh = Mesh3d(self.meshes[number].clone());
                    self.app.edit(loaded).insert(mesh);
                }
                // Avian despawns the colliders of a body with it.
                let world = self.app.world_mut();
                for child in children.unwrap_or_default() {
                    if let Ok(mut child) = world.get_entity_mut(child) {
                        child.insert(ChildOf(loaded));
                    }
                }
                self.entities.push(loaded);
            }
            9 => {
                let scale = Vec3::splat(self.random.size());
                set_scale(&mut self.app, entity, scale);
            }
            10 => self.app.change::<Transform>(entity).scale.x *= -1.0,
            11 if is_tagged => {
                let tag = self.tag();
                self.app.edit(entity).insert(tag);
            }
            12 if is_tagged => {
                let tag = self.app.get::<ConvexDecomposition>(entity).cloned().expect("a tag");
                self.app.edit(entity).insert(tag);
            }
            13 if is_tagged => {
                _ = self.app.edit(entity).remove::<(ConvexDecomposition, TaggedByGame)>();
            }
            13 if self.app.get::<ConvexDecomposition>(entity).is_none() => {
                let tag = self.tag();
                self.app.edit(entity).remove::<NoConvexDecomposition>().insert((tag, TaggedByGame));
            }
            14 if has_mesh => {
                let mesh = self.mesh();
                self.app.edit(entity).insert(mesh);
            }
            15 => {
                let number = self.random.below(MESHES);
                let mesh = body(self.random.size(), self.random.below(2) == 0);
                let mut assets = self.app.world_mut().resource_mut::<Assets<Mesh>>();
                *assets.get_mut(&self.meshes[number]).expect("a mesh") = mesh;
            }
            16 => {
                let place = self.transform();
                *self.app.change::<Transform>(entity) = place;
            }
            17 => match self.random.below(3) {
                0 if has_mesh => _ = self.app.edit(entity).remove::<(Mesh3d, MeshNumber)>(),
                1 => {
                    let mesh = self.mesh();
                    self.app.edit(entity).insert(mesh);
                }
                _ => {
                    if self.app.get::<ConvexDecomposition>(entity).is_none() {
                        _ = self.app.edit(entity).insert(NoConvexDecomposition);
                    }
                }
            },
            18 if is_tagged => match self.random.below(2) {
                0 => _ = self.app.edit(entity).insert((ball(0.25), GamesCollider)),
                _ => _ = self.app.edit(entity).remove::<(Collider, GamesCollider)>(),
            },
            19 if is_scene => {
                let tag = self.tag();
                self.app.edit(entity).insert(ConvexDecompositionHierarchy::new(tag));
            }
            _ => {
                // Moved as a whole: no reason for anything.
                let mut transform = self.app.change::<Transform>(entity);
                transform.translation.y += 1.0;
            }
        }
    }

    /// The same world in an app in which nothing has happened yet, with what became of each entity.
    fn fresh(&self) -> (App, EntityHashMap<Entity>) {
        let mut app = app();
        let copies: EntityHashMap<Entity> =
            self.entities.iter().map(|entity| (*entity, app.put(()))).collect();
        let meshes: Vec<Handle<Mesh>> = self
            .meshes
            .iter()
            .map(|mesh| {
                let mesh = self.app.world().resource::<Assets<Mesh>>().get(mesh).expect("a mesh");
                add(&mut app, mesh.clone())
            })
            .collect();
        // Children in their order.
        let mut order: Vec<Entity> = self.entities.clone();
        order.sort_by_key(|entity| {
            let of = self.app.get::<ChildOf>(*entity);
            let siblings = of.and_then(|of| self.app.get::<Children>(of.parent()));
            siblings.and_then(|all| all.iter().position(|other| other == *entity))
        });
        for entity in order {
            let copy = copies[&entity];
            macro_rules! copy {
                ($($component:ty),*) => {$(
                    if let Some(component) = self.app.get::<$component>(entity) {
                        app.edit(copy).insert(component.clone());
                    }
                )*};
            }
            copy!(
                Transform,
                RigidBody,
                GravityScale,
                Layers,
                Name,
                Disabled,
                NoConvexDecomposition,
                ConvexDecompositionHierarchy
            );
            if let Some(MeshNumber(number)) = self.app.get(entity).copied() {
                app.edit(copy).insert(Mesh3d(meshes[number].clone()));
            }
            if let Some(of) = self.app.get::<ChildOf>(entity) {
                app.edit(copy).insert(ChildOf(copies[&of.parent()]));
            }
            if self.app.get::<GamesCollider>(entity).is_some() {
                app.edit(copy).insert(ball(0.25));
            }
            if self.has_tag_of_its_own(entity) {
                copy!(ConvexDecomposition);
            }
        }
        (app, copies)
    }

    /// What a hierarchy has tagged keeps its tag where it is put elsewhere.
    fn has_tag_of_its_own(&self, entity: Entity) -> bool {
        self.app.get::<TaggedByGame>(entity).is_some() || !self.is_in_scene(entity)
    }

    /// Whether there is a hierarchy on an entity or above it, and nothing disabled between.
    fn is_in_scene(&self, entity: Entity) -> bool {
        let parent = |entity| self.app.get::<ChildOf>(entity).map(ChildOf::parent);
        let mut above = std::iter::successors(Some(entity), |entity| parent(*entity))
            .take_while(|entity| self.app.get::<Disabled>(*entity).is_none());
        above.any(|entity| self.app.get::<ConvexDecompositionHierarchy>(entity).is_some())
    }

    /// How many colliders were compared.
    fn assert_is_as_a_fresh_one(&mut self) -> usize {
        let mut compared = 0;
        settle(&mut self.app);
        self.any();
        let (mut fresh, copies) = self.fresh();
        settle(&mut fresh);
        let last = &self.app.world().resource::<Last>().0;
        for (entity, copy) in &copies {
            if self.app.get(*entity) == Some(&HierarchyStatus::Running) {
                // For a scene within that has no meshes yet.
                assert_eq!(fresh.get(*copy), Some(&HierarchyStatus::Running), "{entity}");
            }
            let tagged = [(&self.app, *entity), (&fresh, *copy)]
                .map(|(app, entity)| app.get::<ConvexDecomposition>(entity).is_some());
            let is_disabled = self.app.get::<Disabled>(*entity).is_some();
            if is_disabled || tagged == [false, false] {
                continue;
            }
            assert_eq!(tagged[0], tagged[1], "{entity}: tagged here, and in a fresh app");
            let (found, expected) = (status(&self.app, *entity), status(&fresh, *copy));
            assert!(
                std::mem::discriminant(&found) == std::mem::discriminant(&expected),
                "{entity} is {found:?}, not {expected:?}"
            );
            assert_eq!(has_collider(&self.app, *entity), has_collider(&fresh, *copy), "{entity}");
            if found.is_finished() {
                assert_eq!(
                    found.has_collider(),
                    Some(has_collider(&self.app, *entity)),
                    "{entity}"
                );
                assert_eq!(last.get(entity).copied(), found.has_collider(), "{entity}");
            }
            if has_collider(&fresh, *copy) && self.app.get::<GamesCollider>(*entity).is_none() {
                self.assert_same_collider(*entity, &fresh, *copy);
                compared += 1;
            }
        }
        let counted = counters(&self.app);
        assert_eq!(counted.with_collider + counted.without_collider, seen(&self.app).all());
        compared
    }

    fn assert_same_collider(&self, entity: Entity, fresh: &App, copy: Entity) {
        let kind = |app: &App, entity| {
            let shape = shape(collider(app, entity));
            let parts = shape.as_compound().map_or(1, |compound| compound.shapes().len());
            (shape.shape_type() as u32, parts)
        };
        assert_eq!(kind(&self.app, entity), kind(fresh, copy), "{entity}: kind and parts");
        let (found, expected) = (bounds(&self.app, entity), bounds(fresh, copy));
        let size = expected.0.distance(expected.1);
        for (found, expected) in [(found.0, expected.0), (found.1, expected.1)] {
            assert!(found.distance(expected) < 1e-2 * size, "{entity}: {found}, not {expected}");
        }
        let [found, expected] = [(&self.app, entity), (fresh, copy)]
            .map(|(app, entity)| some_mass(app, entity).unwrap_or_default());
        assert!(
            (found - expected).abs() <= 1e-2 * expected,
            "{entity}: mass {found}, not {expected}"
        );
    }

    fn assert_nothing_is_left(&mut self) {
        for entity in std::mem::take(&mut self.entities) {
            self.app.world_mut().try_despawn(entity).ok();
        }
        update_times(&mut self.app, 5);
        update_until(&mut self.app, |app| {
            let left = counters(app);
            left.running == 0 && left.queued == 0
        });
        assert_eq!(counters(&self.app).waiting_for_mesh, 0);
        assert!(self.app.world().resource::<DecompositionProgress>().is_done());
        let world = self.app.world_mut();
        assert_eq!(world.query::<&Collider>().iter(world).count(), 0);
        assert_eq!(world.query::<&DecompositionStatus>().iter(world).count(), 0);
        // The engine holds none either.
        assert_eq!(held_by_engine(&mut self.app).1, 0);
    }
}

/// Until nothing changes any more: nothing runs, and who waits has no mesh.
fn settle(app: &mut App) {
    for _ in 0..3 {
        // In slices one entity is looked at in a frame.
        update_times(app, 2 * ENTITIES);
        update_until(app, |app| {
            let left = counters(app);
            left.running == 0 && left.queued == 0
        });
    }
}

/// How many colliders were there in the end.
fn play(seed: u64, frames: usize) -> usize {
    let mut world = RandomWorld::new(seed);
    let played = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        for _ in 0..frames {
            for _ in 0..world.random.below(3) {
                world.event();
            }
            world.app.update();
        }
        let compared = world.assert_is_as_a_fresh_one();
        world.assert_nothing_is_left();
        compared
    }));
    played.unwrap_or_else(|_| {
        if std::env::var_os("WORLD").is_some() {
            eprintln!("{}", world.log.join("\n"));
        }
        let last = world.log.len().saturating_sub(60);
        panic!("world {seed}, {frames} frames; what happened last: {:?}", &world.log[last..])
    })
}

#[test]
fn after_whatever_happens_each_collider_is_what_a_fresh_app_makes_of_that_world() {
    let compared: usize = (0..WORLDS_EACH_TIME).map(|seed| play(seed, FRAMES)).sum();
    assert!(compared > 50, "{compared}");
}

/// `cargo test … --test bevy two_thousand_frames -- --ignored`; `WORLD` and `WORLD_FRAMES` choose
/// one to look into.
#[test]
#[ignore = "it takes minutes"]
fn two_thousand_frames_of_twenty_worlds() {
    let chosen = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let frames = chosen("WORLD_FRAMES").unwrap_or(2_000);
    match chosen("WORLD") {
        Some(seed) => _ = play(seed as u64, frames),
        None => (0..WORLDS).for_each(|seed| _ = play(seed, frames)),
    }
}

/// Decomposes one model with a cache on disk; what became of it.
fn source_with(directory: &std::path::Path) -> DecompositionStatus {
    let (app, entity) = finished_with(with_disk_cache(directory), model("u_prism"), ());
    status(&app, entity)
}

const FRESH: DecompositionStatus = DecompositionStatus::Ready(HullSource::Decomposed);
const CACHED: DecompositionStatus = DecompositionStatus::Ready(HullSource::Disk);

fn entries(directory: &std::path::Path) -> Vec<std::path::PathBuf> {
    let mut entries: Vec<_> =
        std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    entries
}

#[test]
fn a_cached_entry_of_another_version_or_another_mesh_is_not_taken() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(source_with(folder.path()), FRESH);
    assert_eq!(source_with(folder.path()), CACHED);
    let entry = entries(folder.path()).remove(0);

    let mut file = HullsFile::read(&entry).unwrap();
    file.algorithm_version -= 1;
    std::fs::write(&entry, file.to_bytes().unwrap()).unwrap();
    assert_eq!(source_with(folder.path()), FRESH);
    // It was replaced.
    assert_eq!(source_with(folder.path()), CACHED);

    // A folder of that name, which nothing can replace.
    std::fs::remove_file(&entry).unwrap();
    std::fs::create_dir(&entry).unwrap();
    assert_eq!(source_with(folder.path()), FRESH);
    assert_eq!(source_with(folder.path()), FRESH);
    assert_eq!(entries(folder.path()), [entry]);
}

#[test]
fn foreign_files_in_the_cache_stay_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let foreign = folder.path().join("notes.txt");
    std::fs::write(&foreign, "mine").unwrap();
    assert_eq!(source_with(folder.path()), FRESH);
    assert_eq!(source_with(folder.path()), CACHED);
    assert_eq!(std::fs::read_to_string(foreign).unwrap(), "mine");
}

#[test]
fn a_cache_that_can_not_be_written_does_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    // A file where the folder should be: fails for every user, also for one whom permissions don't
    // stop.
    let blocked = folder.path().join("file");
    std::fs::write(&blocked, "").unwrap();
    for directory in [blocked.clone(), blocked.join("below")] {
        assert_eq!(source_with(&directory), FRESH);
        assert_eq!(source_with(&directory), FRESH);
    }
}

#[test]
fn a_cache_that_can_not_be_written_is_logged_once() {
    Log::install();
    let folder = tempfile::tempdir().unwrap();
    let blocked = folder.path().join("blocked by a file");
    std::fs::write(&blocked, "").unwrap();
    let mut app = app_with(with_disk_cache(&blocked));
    for size in [1.0, 2.0, 3.0] {
        let mesh = add(&mut app, cuboid([0.0; 3], [size; 3]));
        let _ = finish(&mut app, &mesh, ());
    }
    assert_eq!(counters(&app).decomposed, 3);
    assert_eq!(Log::lines_with("blocked by a file").len(), 1);
}

/// Several apps at once stand for several processes: they share nothing but the folder.
#[test]
fn several_apps_may_use_one_cache_at_the_same_time() {
    let folder = tempfile::tempdir().unwrap();
    std::thread::scope(|scope| {
        let apps: Vec<_> = (0..4)
            .map(|_| scope.spawn(|| (0..4).map(|_| source_with(folder.path())).collect()))
            .collect();
        for app in apps {
            let found: Vec<DecompositionStatus> = app.join().unwrap();
            assert!(found.iter().all(|status| *status == FRESH || *status == CACHED), "{found:?}");
            assert_eq!(found.last(), Some(&CACHED));
        }
    });
    // One entry, and no temporary file.
    assert_eq!(entries(folder.path()).len(), 1);
    assert!(HullsFile::read(&entries(folder.path())[0]).is_ok());
}

const STREAMED_FRAMES: usize = 1000;

/// Streamed in per frame: 10,000 in all.
const STREAMED: usize = 10;

/// Frames that an entity lives: some are gone before their collider is there.
const LIVES: [usize; 5] = [1, 2, 5, 20, 60];

/// One new mesh per this many entities; the others repeat it.
const REPEATS: usize = 25;

/// Every so many frames the work is waited for, so that some is done on a slow machine too.
const BREATH: usize = 100;

/// Too small for the meshes of a hundred frames.
const CACHE_BYTES: usize = 1 << 20;

const DISK_BYTES: u64 = 1 << 18;

fn count<T: Component>(app: &mut App) -> usize {
    let world = app.world_mut();
    world.query_filtered::<(), With<T>>().iter(world).count()
}

#[test]
fn ten_thousand_entities_streamed_in_and_out_leave_nothing_behind() {
    let directory = tempfile::tempdir().unwrap();
    let mut app = app_with(HullwrightSettings {
        cache: CacheSettings {
            memory_bytes: CACHE_BYTES,
            disk: Some(directory.path().into()),
            disk_bytes: DISK_BYTES,
        },
        ..default()
    });
    app.update();
    let entities_before = app.world().entities().count_spawned();
    let mut living: Vec<VecDeque<Entity>> = LIVES.map(|_| VecDeque::new()).into();
    let mut mesh = None;
    for number in 0..STREAMED_FRAMES * STREAMED {
        if number % REPEATS == 0 {
            let size = 1.0 + number as f32 / 1000.0;
            mesh = Some(add(&mut app, cuboid([0.0; 3], [size, 1.0, 1.0])));
        }
        let place = Transform::from_xyz(10.0 * (number % 97) as f32, 0.0, number as f32);
        let mesh = mesh.as_ref().unwrap();
        let entity = spawn_with(&mut app, mesh, (RigidBody::Dynamic, place));
        living[number % LIVES.len()].push_back(entity);
        if number % STREAMED < STREAMED - 1 {
            continue;
        }
        app.update();
        if (number / STREAMED) % BREATH == BREATH - 1 {
            let present: Vec<Entity> = living.iter().flatten().copied().collect();
            update_until_finished(&mut app, &present);
        }
        for (living, life) in living.iter_mut().zip(LIVES) {
            while living.len() > life * STREAMED / LIVES.len() {
                app.world_mut().despawn(living.pop_front().unwrap());
            }
        }
    }
    let seen = counters(&app);
    assert!(seen.cancelled > 0 && seen.decomposed > 10 && seen.shared > 100, "{seen:?}");
    assert!(seen.cached_bytes <= CACHE_BYTES);

    drop(mesh);
    for entity in living.into_iter().flatten() {
        app.world_mut().despawn(entity);
    }
    // A job that was cancelled at its end may still be writing its file.
    update_times(&mut app, 10);
    let left = counters(&app);
    assert_eq!((left.running, left.queued, left.waiting_for_mesh), (0, 0, 0));
    assert_eq!(app.world().entities().count_spawned(), entities_before);
    assert_eq!(app.world().resource::<Assets<Mesh>>().len(), 0);
    assert_eq!(count::<DecompositionStatus>(&mut app) + count::<Collider>(&mut app), 0);
    assert!(app.world().resource::<DecompositionProgress>().is_done());
    assert_eq!(held_by_engine(&mut app), (0, 0));
    let files = std::fs::read_dir(directory.path()).unwrap();
    let bytes: u64 = files.map(|file| file.unwrap().metadata().unwrap().len()).sum();
    assert!(bytes > 0 && bytes <= DISK_BYTES + DISK_BYTES / 8, "{bytes} bytes on disk");
}
