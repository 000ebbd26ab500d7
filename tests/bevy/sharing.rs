//! Work that is skipped, shared or cached, and limits on what runs.

use std::time::Duration;

use bevy::prelude::*;
use bevy_hullwright::HullSource;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

#[test]
fn entities_with_the_same_mesh_share_one_job_while_it_is_in_flight() {
    let (mut app, mesh) = with_mesh(app(), model("gear"));
    let entities: Vec<Entity> = (0..10).map(|_| spawn(&mut app, &mesh)).collect();
    update_until_finished(&mut app, &entities);
    let counters = counters(&app);
    assert_eq!((counters.decomposed, counters.shared), (1, 9));
    assert_eq!(status(&app, entities[0]), DecompositionStatus::Ready(HullSource::Decomposed));
    assert_eq!(status(&app, entities[9]), DecompositionStatus::Ready(HullSource::Shared));
    assert_eq!(ready(&app).len(), 10);
}

#[test]
fn meshes_with_the_same_content_and_entities_of_several_scales_share_one_decomposition() {
    for (max_jobs, is_one_mesh) in [(1, false), (4, false), (4, true)] {
        let (mut app, mesh) = with_mesh(app_with(with_jobs(max_jobs)), model("gear"));
        let entities = [1.0, 2.0, 3.0, 4.0].map(|scale| match is_one_mesh {
            true => spawn_with(&mut app, &mesh, Transform::from_scale(Vec3::splat(scale))),
            false => {
                let copy = add(&mut app, model("gear"));
                spawn(&mut app, &copy)
            }
        });
        update_until_finished(&mut app, &entities);
        let counters = counters(&app);
        assert_eq!(counters.decomposed, 1);
        assert!(is_one_mesh || counters.shared == 3);
    }
}

#[test]
fn other_parameters_are_another_decomposition() {
    let (mut app, mesh) = with_mesh(app(), model("u_prism"));
    let first = spawn(&mut app, &mesh);
    let second = spawn_with(&mut app, &mesh, tag().with_preset(DecompositionPreset::Fast));
    update_until_finished(&mut app, &[first, second]);
    assert_eq!(counters(&app).decomposed, 2);
}

#[test]
fn a_known_mesh_has_its_collider_after_one_frame() {
    let (mut app, mesh) = with_mesh(app(), model("gear"));
    let first = finish(&mut app, &mesh, ());
    let second = spawn(&mut app, &mesh);
    app.update();
    assert_eq!(status(&app, second), DecompositionStatus::Ready(HullSource::Shared));
    // One shape for both.
    let raw = |entity| std::sync::Arc::as_ptr(&shape(collider(&app, entity)).0).cast::<u8>();
    assert_eq!(raw(first), raw(second));
}

#[test]
fn a_cache_without_room_keeps_nothing() {
    let mut app = app_with(HullwrightSettings {
        cache: CacheSettings { memory_bytes: 0, ..default() },
        ..default()
    });
    let mesh = add(&mut app, model("u_prism"));
    for _ in 0..2 {
        let entity = finish(&mut app, &mesh, ());
        assert!(has_collider(&app, entity));
    }
    let counters = counters(&app);
    assert_eq!((counters.decomposed, counters.cached, counters.cached_bytes), (2, 0, 0));
}

#[test]
fn a_small_cache_drops_what_was_not_used_for_longest() {
    let (mut app, _) = finished(model("u_prism"), ());
    let one = counters(&app).cached_bytes;
    assert!(one > 0);
    app.world_mut().resource_mut::<HullwrightSettings>().cache.memory_bytes = one + one / 2;
    let other = add(&mut app, unit_cube());
    let _ = finish(&mut app, &other, ());
    let after = counters(&app);
    assert!(after.cached_bytes <= one + one / 2);
    assert!(after.cached >= 1);
}

#[test]
fn the_cache_on_disk_spares_the_next_start_the_work() {
    let directory = tempfile::tempdir().unwrap();
    let settings = with_disk_cache(&directory.path().join("cache"));
    let mut found = Vec::new();
    for expected in [HullSource::Decomposed, HullSource::Disk] {
        let (app, entity) = finished_with(settings.clone(), model("u_prism"), ());
        assert_eq!(status(&app, entity), DecompositionStatus::Ready(expected));
        assert_eq!(counters(&app).from_disk, usize::from(expected == HullSource::Disk));
        found.push((hulls(&app, entity), mass(&app, entity)));
    }
    assert_eq!(found[0], found[1]);
}

#[test]
fn a_damaged_cache_on_disk_is_as_good_as_none() {
    let directory = tempfile::tempdir().unwrap();
    let settings = with_disk_cache(directory.path());
    for _ in 0..2 {
        let (app, entity) = finished_with(settings.clone(), model("u_prism"), ());
        assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Decomposed));
        for file in std::fs::read_dir(directory.path()).unwrap() {
            std::fs::write(file.unwrap().path(), b"no hulls").unwrap();
        }
    }
}

#[test]
fn no_more_jobs_run_than_allowed() {
    let mut app = app_with(with_jobs(2));
    let entities: Vec<Entity> = (1..12)
        .map(|size| {
            let mesh = add(&mut app, cuboid([0.0; 3], [size as f32; 3]));
            spawn(&mut app, &mesh)
        })
        .collect();
    let mut most = 0;
    update_until(&mut app, |app| {
        most = most.max(counters(app).running);
        entities.iter().all(|entity| status(app, *entity).is_finished())
    });
    assert_eq!((most, counters(&app).decomposed), (2, 11));
}

#[test]
fn the_nearest_to_a_focus_goes_first() {
    let mut app = app_with(with_jobs(1));
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    app.world_mut().spawn((at(10.0), DecompositionFocus));
    let entities: Vec<Entity> = [0.0, 30.0, 12.0, 9.0]
        .into_iter()
        .map(|x| {
            let mesh = add(&mut app, cuboid([0.0; 3], [1.0 + x; 3]));
            app.put((Mesh3d(mesh), at(x), tag()))
        })
        .collect();
    update_until_finished(&mut app, &entities);
    let ready: Vec<Entity> = ready(&app).iter().map(|(entity, _)| *entity).collect();
    let [first, second, third, fourth] = entities[..] else { unreachable!() };
    assert_eq!(ready, [fourth, third, first, second]);
}

#[test]
fn no_more_colliders_are_attached_per_frame_than_allowed() {
    let mut app = app_with(HullwrightSettings {
        budget: BudgetSettings { max_attached_per_frame: 3, ..default() },
        ..default()
    });
    let mesh = add(&mut app, model("u_prism"));
    let _ = finish(&mut app, &mesh, ());
    let entities: Vec<Entity> = (0..7).map(|_| spawn(&mut app, &mesh)).collect();
    let finished = |app: &App| entities.iter().filter(|e| status(app, **e).is_finished()).count();
    let mut before = 0;
    while before < entities.len() {
        app.update();
        let now = finished(&app);
        assert!(now > before && now - before <= 3);
        before = now;
    }
}

#[test]
fn without_threads_the_work_goes_on_in_slices() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let entity = spawn(&mut app, &mesh);
    let mut frames = 0;
    update_until(&mut app, |app| {
        frames += 1;
        status(app, entity).is_finished()
    });
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Decomposed));
    assert!(frames > 4, "one slice did all");
}

#[test]
fn what_takes_no_decomposition_does_not_wait_for_what_does() {
    const MESHES: usize = 300;
    let frame_time = Duration::from_secs(9);
    for (max_jobs, execution) in
        [(0, Execution::Background), (1, Execution::Background), (0, Execution::Slices)]
    {
        let budget = BudgetSettings { max_jobs, execution, frame_time, ..default() };
        let mut app = app_with(HullwrightSettings { budget, ..default() });
        for number in 0..MESHES {
            let mesh = add(&mut app, cuboid([0.0; 3], [1.0 + number as f32, 1.0, 1.0]));
            spawn_with(&mut app, &mesh, automatic());
        }
        let mut frames = 0;
        while seen(&app).skipped.len() < MESHES {
            app.update();
            std::thread::sleep(Duration::from_millis(4));
            frames += 1;
        }
        assert!(frames <= 20, "{frames} frames with {max_jobs} jobs, {execution:?}");
    }
}

#[test]
fn a_decomposition_in_slices_does_not_hold_up_what_takes_none() {
    let (mut app, slow) = with_mesh(app_with(sliced()), model("dog"));
    let slow = spawn(&mut app, &slow);
    update_times(&mut app, 2);
    let quick: Vec<Entity> = (0..3)
        .map(|number| {
            let mesh = add(&mut app, cuboid([0.0; 3], [2.0 + number as f32, 1.0, 1.0]));
            spawn_with(&mut app, &mesh, automatic())
        })
        .collect();
    update_times(&mut app, quick.len() + 3);
    assert!(quick.iter().all(|entity| status(&app, *entity).is_finished()));
    assert!(!status(&app, slow).is_finished());
}
