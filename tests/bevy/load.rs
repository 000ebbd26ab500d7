//! A storm of changes: whatever happens to entities and meshes while jobs are at work, in the end each
//! collider should be that of its mesh, its tag and its scale, and nothing left behind.

use std::collections::VecDeque;

use bevy::mesh::Mesh;
use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::HullSource;
use hullwright::bevy::prelude::*;
use hullwright::hulls_format::HullsFile;

use crate::app::*;

const EVENTS: usize = 10_000;
const FRAMES: usize = 1_000;

/// At a time.
const ENTITIES: usize = 60;
const MESHES: usize = 12;

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

struct Storm {
    app: App,
    random: Random,
    /// With the size that each has by now.
    meshes: Vec<(Handle<Mesh>, f32)>,
    /// With the number of its mesh.
    entities: Vec<(Entity, usize)>,
}

impl Storm {
    fn new(seed: u64) -> Self {
        let settings = HullwrightSettings {
            scale_delay: std::time::Duration::ZERO,
            // So little that it is full all the time.
            cache: CacheSettings { memory_bytes: 8 << 10, ..default() },
            ..with_jobs(2)
        };
        let mut storm = Self {
            app: app_with(settings),
            random: Random(seed),
            meshes: Vec::new(),
            entities: Vec::new(),
        };
        for _ in 0..MESHES {
            let size = storm.random.size();
            let handle = add(&mut storm.app, body(size, storm.random.below(2) == 0));
            storm.meshes.push((handle, size));
        }
        storm
    }

    fn event(&mut self) {
        let is_full = self.entities.len() >= ENTITIES;
        let kind = self.random.below(8);
        if self.entities.is_empty() || (kind < 2 && !is_full) {
            return self.spawn();
        }
        let index = self.random.below(self.entities.len());
        let entity = self.entities[index].0;
        match kind {
            0 | 1 => {
                self.entities.swap_remove(index);
                self.app.world_mut().despawn(entity);
            }
            2 => {
                self.app.edit(entity).remove::<ConvexDecomposition>();
            }
            3 => {
                let share = [0.01, 0.02, 0.04][self.random.below(3)];
                self.app.edit(entity).insert(tag().with_max_error(share));
            }
            4 => {
                let scale = Vec3::splat(self.random.size());
                self.app.change::<Transform>(entity).scale = scale;
            }
            5 => {
                let number = self.random.below(MESHES);
                let handle = self.meshes[number].0.clone();
                self.app.edit(entity).insert(Mesh3d(handle));
                self.entities[index].1 = number;
            }
            6 => {
                let number = self.random.below(MESHES);
                let size = self.random.size();
                let is_l = self.random.below(2) == 0;
                let mut assets = self.app.world_mut().resource_mut::<Assets<Mesh>>();
                *assets.get_mut(&self.meshes[number].0).unwrap() = body(size, is_l);
                self.meshes[number].1 = size;
            }
            _ => {
                // Moved: no reason for anything.
                let mut transform = self.app.change::<Transform>(entity);
                transform.translation.x += 1.0;
            }
        }
    }

    fn spawn(&mut self) {
        let number = self.random.below(MESHES);
        let scale = Transform::from_scale(Vec3::splat(self.random.size()));
        let body = [RigidBody::Dynamic, RigidBody::KinematicPositionBased][self.random.below(2)];
        let mesh = self.meshes[number].0.clone();
        // It moves in every frame, and nothing is in its way: heaps take Rapier's time, not the plugin's.
        let moves = (GravityScale(0.0), Velocity::linear(Vec3::Y));
        let alone = CollisionGroups::new(Group::NONE, Group::NONE);
        let entity = spawn_with(&mut self.app, &mesh, (scale, body, moves, alone));
        self.entities.push((entity, number));
    }

    /// Of those that are tagged in the end.
    fn assert_colliders_are_those_of_their_meshes(&self) {
        let mut checked = 0;
        for &(entity, number) in &self.entities {
            if self.app.get::<ConvexDecomposition>(entity).is_none() {
                continue;
            }
            assert!(is_ready(&self.app, entity), "{:?}", status(&self.app, entity));
            let scale = self.app.get::<Transform>(entity).unwrap().scale.x;
            let extent = self.meshes[number].1 * scale;
            let (low, high) = bounds(&self.app, entity);
            // A collider that follows its mesh by a hull may be off by a bound.
            assert_near(low, Vec3::ZERO, 1e-3 * extent);
            assert_near(high, Vec3::splat(extent), 1e-3 * extent);
            checked += 1;
        }
        assert!(checked > 10, "{checked}");
    }
}

#[test]
fn after_ten_thousand_changes_each_collider_is_that_of_its_mesh_and_nothing_is_left() {
    for seed in [0x9e37_79b9_7f4a_7c15, 0x2545_f491_4f6c_dd1d] {
        let mut storm = Storm::new(seed);
        for _ in 0..FRAMES {
            for _ in 0..EVENTS / FRAMES {
                storm.event();
            }
            storm.app.update();
        }
        let tagged: Vec<Entity> = storm
            .entities
            .iter()
            .map(|(entity, _)| *entity)
            .filter(|entity| storm.app.get::<ConvexDecomposition>(*entity).is_some())
            .collect();
        // What changed in the last frame is not seen yet.
        update_times(&mut storm.app, 3);
        update_until_finished(&mut storm.app, &tagged);
        update_times(&mut storm.app, 3);
        update_until_finished(&mut storm.app, &tagged);
        storm.assert_colliders_are_those_of_their_meshes();

        let all: Vec<Entity> = storm.entities.drain(..).map(|(entity, _)| entity).collect();
        all.into_iter().for_each(|entity| {
            storm.app.world_mut().despawn(entity);
        });
        update_times(&mut storm.app, 5);
        update_until(&mut storm.app, |app| {
            let left = counters(app);
            left.running == 0 && left.queued == 0
        });
        let world = storm.app.world_mut();
        assert_eq!(world.query::<&Collider>().iter(world).count(), 0);
        assert_eq!(world.query::<&DecompositionStatus>().iter(world).count(), 0);
        // Rapier holds none either.
        let mut sets = world.query::<&RapierContextColliders>();
        assert_eq!(sets.iter(world).map(|set| set.colliders.len()).sum::<usize>(), 0);
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
    file.write(&entry).unwrap();
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
    // A file where the folder should be: fails for every user, also for one whom permissions don't stop.
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
    let world = app.world_mut();
    let (bodies, colliders) =
        world.query::<(&RapierRigidBodySet, &RapierContextColliders)>().single(world).unwrap();
    assert_eq!((bodies.bodies.len(), colliders.colliders.len()), (0, 0));
    let files = std::fs::read_dir(directory.path()).unwrap();
    let bytes: u64 = files.map(|file| file.unwrap().metadata().unwrap().len()).sum();
    assert!(bytes > 0 && bytes <= DISK_BYTES + DISK_BYTES / 8, "{bytes} bytes on disk");
}
