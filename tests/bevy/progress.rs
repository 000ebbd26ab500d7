//! What a loading screen looks at: progress from 0 to 1, run conditions, and the one event of a scene.

use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use hullwright::bevy::prelude::*;

use crate::app::*;

#[derive(Resource, Default)]
struct Finished(Vec<(Entity, HierarchyReport)>);

fn observed(app: &mut App) {
    app.init_resource::<Finished>();
    app.add_observer(|event: On<HierarchyFinished>, mut finished: ResMut<Finished>| {
        finished.0.push((event.entity, event.report));
    });
}

fn finished(app: &App) -> Vec<(Entity, HierarchyReport)> {
    app.world().resource::<Finished>().0.clone()
}

fn progress(app: &App) -> DecompositionProgress {
    *app.world().resource::<DecompositionProgress>()
}

fn all_done(app: &mut App) -> bool {
    let pending = app.world_mut().run_system_once(decompositions_pending).unwrap();
    let done = app.world_mut().run_system_once(all_decompositions_done).unwrap();
    assert_ne!(done, pending);
    done
}

fn scene(app: &mut App, meshes: &[(&str, &Handle<Mesh>)]) -> Entity {
    let hierarchy = ConvexDecompositionHierarchy::new(tag()).without("lamp");
    let root = app.world_mut().spawn((Transform::default(), hierarchy)).id();
    for (name, mesh) in meshes {
        let node = (Name::new((*name).to_owned()), Transform::default(), ChildOf(root));
        let node = app.world_mut().spawn(node).id();
        app.world_mut().spawn((Mesh3d((*mesh).clone()), ChildOf(node)));
    }
    root
}

#[test]
fn progress_goes_from_0_to_1_and_never_back() {
    let mut app = app_with(sliced());
    assert!(all_done(&mut app) && progress(&app).is_done());
    for round in 0..2 {
        let meshes = ["u_prism", "l_prism"].map(|name| add(&mut app, model(name)));
        for mesh in &meshes {
            spawn_with(&mut app, mesh, tag().with_max_error(0.02 + 0.001 * round as f32));
        }
        // Already before the plugin's systems have seen them.
        assert!(!all_done(&mut app));
        let mut seen = Vec::new();
        while !all_done(&mut app) {
            app.update();
            let now = progress(&app);
            assert_eq!(now.total, 2);
            assert!(now.finished <= 2 && now.is_done() == all_done(&mut app));
            seen.push(now.fraction);
        }
        assert!(seen.is_sorted() && seen[0] < 0.5, "{seen:?}");
        assert!(seen.iter().filter(|fraction| **fraction == 1.0).count() == 1, "{seen:?}");
        assert!(seen.len() > 4);
    }
}

#[test]
fn despawned_entities_do_not_hold_progress_back() {
    let mut app = app_with(sliced());
    let mesh = add(&mut app, model("dog"));
    let entities =
        [1.0, 2.0].map(|x| spawn_with(&mut app, &mesh, Transform::from_xyz(x, 0.0, 0.0)));
    update_times(&mut app, 3);
    assert!(!progress(&app).is_done());
    for entity in entities {
        app.world_mut().despawn(entity);
    }
    update_times(&mut app, 2);
    assert!(all_done(&mut app) && progress(&app).is_done() && progress(&app).fraction == 1.0);
}

#[test]
fn a_scene_ends_in_one_event_with_its_counts() {
    let mut app = app();
    observed(&mut app);
    let good = add(&mut app, model("u_prism"));
    let bad = add(&mut app, mesh(vec![[1.0; 3]; 3], vec![0, 1, 2]));
    let meshes = [("chair", &good), ("table", &good), ("broken", &bad), ("lamp", &good)];
    let root = scene(&mut app, &meshes);
    let other = scene(&mut app, &[("mug", &good)]);
    update_until(&mut app, |app| finished(app).len() == 2);
    update_times(&mut app, 20);
    let mut found = finished(&app);
    found.sort_by_key(|(entity, _)| *entity != root);
    assert_eq!(found.len(), 2);
    let (entity, report) = found[0];
    assert_eq!(entity, root);
    let counts = [report.ready, report.skipped, report.failed, report.cancelled, report.left_out];
    assert_eq!(counts, [2, 0, 1, 0, 1]);
    assert_eq!((found[1].0, found[1].1.ready), (other, 1));
    assert!(report.time > std::time::Duration::ZERO && !report.is_lost);
    assert_eq!(app.world().get::<HierarchyStatus>(root), Some(&HierarchyStatus::Finished(report)));
}

#[test]
fn a_scene_ends_again_only_when_something_is_added() {
    let mut app = app();
    observed(&mut app);
    let mesh = add(&mut app, model("u_prism"));
    let root = scene(&mut app, &[("chair", &mesh)]);
    update_until(&mut app, |app| finished(app).len() == 1);
    let node = (Name::new("late"), Transform::default(), ChildOf(root));
    let node = app.world_mut().spawn(node).id();
    app.world_mut().spawn((Mesh3d(mesh.clone()), ChildOf(node)));
    update_until(&mut app, |app| finished(app).len() == 2);
    assert_eq!(finished(&app)[1].1.ready, 2);
}

#[test]
fn a_scene_without_meshes_yet_is_waited_for() {
    let mut app = app();
    observed(&mut app);
    let root = scene(&mut app, &[]);
    update_times(&mut app, 5);
    assert_eq!(app.world().get::<HierarchyStatus>(root), Some(&HierarchyStatus::Waiting));
    assert!(!all_done(&mut app) && !progress(&app).is_done());
    app.world_mut().despawn(root);
    update_times(&mut app, 2);
    assert!(all_done(&mut app) && progress(&app).is_done());
}

#[test]
fn despawned_meshes_of_a_scene_count_as_cancelled() {
    let mut app = app_with(sliced());
    observed(&mut app);
    let mesh = add(&mut app, model("dog"));
    let root = scene(&mut app, &[("dog", &mesh), ("other", &mesh)]);
    update_times(&mut app, 3);
    let dog = app.world().get::<Children>(root).unwrap()[0];
    app.world_mut().despawn(dog);
    update_until(&mut app, |app| finished(app).len() == 1);
    let report = finished(&app)[0].1;
    assert_eq!((report.ready, report.cancelled), (1, 1));
}
