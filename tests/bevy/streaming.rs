//! A world that is streamed in and out leaves nothing behind.

use std::collections::VecDeque;

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;

use crate::app::*;

const FRAMES: usize = 1000;

/// Streamed in per frame: 10,000 in all.
const ENTITIES: usize = 10;

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
        cache_bytes: CACHE_BYTES,
        disk_cache: Some(directory.path().into()),
        disk_cache_bytes: DISK_BYTES,
        ..default()
    });
    app.update();
    let entities_before = app.world().entities().count_spawned();
    let mut living: Vec<VecDeque<Entity>> = LIVES.map(|_| VecDeque::new()).into();
    let mut mesh = None;
    for number in 0..FRAMES * ENTITIES {
        if number % REPEATS == 0 {
            let size = 1.0 + number as f32 / 1000.0;
            mesh = Some(add(&mut app, cuboid([0.0; 3], [size, 1.0, 1.0])));
        }
        let place = Transform::from_xyz(10.0 * (number % 97) as f32, 0.0, number as f32);
        let mesh = mesh.as_ref().unwrap();
        let entity = spawn_with(&mut app, mesh, (RigidBody::Dynamic, place));
        living[number % LIVES.len()].push_back(entity);
        if number % ENTITIES < ENTITIES - 1 {
            continue;
        }
        app.update();
        if (number / ENTITIES) % BREATH == BREATH - 1 {
            let present: Vec<Entity> = living.iter().flatten().copied().collect();
            update_until_finished(&mut app, &present);
        }
        for (living, life) in living.iter_mut().zip(LIVES) {
            while living.len() > life * ENTITIES / LIVES.len() {
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
