//! A tag may come before the mesh, sit above it, and go away again.

use bevy::prelude::*;
use bevy_hullwright::WaitReason;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

#[test]
fn a_tag_before_the_mesh_is_loaded_or_before_there_is_any_waits_for_it() {
    for is_reserved in [true, false] {
        let mut app = app();
        let handle = app.world().resource::<Assets<Mesh>>().reserve_handle();
        let entity = app.put((Transform::default(), tag()));
        if is_reserved {
            app.edit(entity).insert(Mesh3d(handle.clone()));
        }
        update_times(&mut app, 5);
        assert_eq!(status(&app, entity), DecompositionStatus::Waiting(WaitReason::ForMesh));
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        meshes.insert(handle.id(), model("u_prism")).unwrap();
        app.edit(entity).insert_if_new(Mesh3d(handle));
        update_until_finished(&mut app, &[entity]);
        assert!(has_collider(&app, entity));
    }
}

#[test]
fn all_meshes_below_a_tag_are_one_input() {
    let mut app = app();
    // The two halves of a box, each an open fragment, one of them moved into its place.
    let halves = [cuboid([0.0; 3], [1.0; 3]), cuboid([0.0, -1.0, 0.0], [1.0, 0.0, 1.0])];
    let [lower, upper] = halves.map(|whole| {
        let positions = whole.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
        let indices: Vec<u32> = whole.indices().unwrap().iter().map(|index| index as u32).collect();
        let half = if positions[0][1] == 0.0 { &indices[..18] } else { &indices[18..] };
        mesh(positions.to_vec(), half.to_vec())
    });
    let (lower, upper) = (add(&mut app, lower), add(&mut app, upper));
    let parent = app.put((Transform::default(), tag(), RigidBody::Dynamic));
    app.world_mut().spawn((Mesh3d(lower), ChildOf(parent)));
    app.world_mut().spawn((Mesh3d(upper), Transform::from_xyz(0., 1., 0.), ChildOf(parent)));
    update_until_finished(&mut app, &[parent]);
    assert!(shape(collider(&app, parent)).as_convex_polyhedron().is_some());
    let properties = mass(&app, parent);
    // Known to be closed only together.
    assert!((properties.mass / DENSITY - 1.0).abs() < 1e-3);
}

#[test]
fn what_has_a_tag_or_a_body_of_its_own_or_is_left_out_is_not_part_of_the_input() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let parent = app.put((Mesh3d(cube.clone()), tag()));
    let aside = |x| Transform::from_xyz(x, 0.0, 0.0);
    let own = app.put((Mesh3d(cube.clone()), aside(5.), tag(), ChildOf(parent)));
    app.world_mut().spawn((Mesh3d(cube.clone()), aside(7.), RigidBody::Dynamic, ChildOf(parent)));
    app.world_mut().spawn((Mesh3d(cube), aside(9.), NoConvexDecomposition, ChildOf(parent)));
    update_until_finished(&mut app, &[parent, own]);
    for entity in [parent, own] {
        assert_is_unit_cube(&app, entity);
    }
}

/// Such as hulls that a game draws over the model when they are ready.
#[test]
fn meshes_that_are_left_out_do_not_start_the_work_anew_when_they_come() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let parent = finish(&mut app, &cube, ());
    let excluded = app.put((NoConvexDecomposition, ChildOf(parent)));
    app.world_mut().spawn((Mesh3d(cube.clone()), ChildOf(excluded)));
    app.world_mut().spawn((Mesh3d(cube.clone()), RigidBody::Dynamic, ChildOf(parent)));
    update_times(&mut app, 5);
    assert!(is_ready(&app, parent));
    assert_eq!(ready(&app).len(), 1);
    // Any other is part of the input.
    app.world_mut().spawn((Mesh3d(cube), Transform::from_xyz(1.0, 0.0, 0.0), ChildOf(parent)));
    update_until_ready_times(&mut app, 2);
    assert_near(bounds(&app, parent).1, [2.0, 1.0, 1.0], 1e-3);
}

#[test]
fn the_status_says_that_others_go_first() {
    let mut app = app_with(sliced());
    let meshes = ["u_prism", "l_prism"].map(|name| add(&mut app, model(name)));
    let [first, second] = [&meshes[0], &meshes[1]].map(|mesh| spawn(&mut app, mesh));
    update_times(&mut app, 3);
    assert!(matches!(status(&app, first), DecompositionStatus::Running { .. }));
    assert_eq!(status(&app, second), DecompositionStatus::Waiting(WaitReason::InQueue));
    assert_eq!((counters(&app).running, counters(&app).queued), (1, 1));
    update_until_finished(&mut app, &[first, second]);
    assert!(is_ready(&app, second));
}

/// An app in which a job is at work on an entity.
fn app_at_work() -> (App, Entity) {
    let (mut app, mesh) = with_mesh(app(), model("dog"));
    let entity = spawn(&mut app, &mesh);
    update_until(&mut app, |app| counters(app).running == 1);
    (app, entity)
}

#[test]
fn progress_rises_and_never_falls() {
    let (mut app, entity) = app_at_work();
    let mut all: Vec<f32> = Vec::new();
    update_until(&mut app, |app| {
        if let DecompositionStatus::Running { progress } = status(app, entity) {
            assert!((0.0..=1.0).contains(&progress));
            assert!(all.last().is_none_or(|last| progress >= *last));
            all.push(progress);
        }
        status(app, entity).is_finished()
    });
    all.dedup();
    assert!(all.len() > 3, "only {all:?} was seen");
}

#[test]
fn removing_the_tag_or_despawning_cancels_the_work() {
    for is_despawned in [false, true] {
        let (mut app, entity) = app_at_work();
        if is_despawned {
            app.world_mut().despawn(entity);
        } else {
            app.edit(entity).remove::<ConvexDecomposition>();
            assert_eq!(status(&app, entity), DecompositionStatus::Cancelled);
        }
        app.update();
        let counters = counters(&app);
        assert_eq!((counters.cancelled, counters.running), (1, 0));
        update_times(&mut app, 20);
        assert!(app.get::<Collider>(entity).is_none());
    }
}

#[test]
fn changing_the_tag_begins_anew() {
    let (mut app, entity) = app_at_work();
    app.edit(entity).insert(tag().with_max_hulls(1));
    update_until_finished(&mut app, &[entity]);
    assert!(shape(collider(&app, entity)).as_convex_polyhedron().is_some());
    assert_eq!(ready(&app), [(entity, 1)]);
}

#[test]
fn the_collider_stays_when_the_tag_is_removed_later() {
    let (mut app, entity) = finished(unit_cube(), ());
    let before = status(&app, entity);
    app.edit(entity).remove::<ConvexDecomposition>();
    update_times(&mut app, 3);
    assert!(has_collider(&app, entity));
    assert_eq!(status(&app, entity), before);
}
