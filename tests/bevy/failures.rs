//! Failures are logged once, and retried when their cause changes.

use std::time::Duration;

use bevy::asset::AssetPlugin;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::Error;
use hullwright::bevy::prelude::*;
use hullwright::bevy::{BakedHulls, DecompositionError, HullSource};

use crate::app::*;
use crate::baked::baked;
use crate::log::Log;

fn failure(app: &App, entity: Entity) -> DecompositionError {
    match status(app, entity) {
        DecompositionStatus::Failed(failure) => failure,
        other => panic!("it did not fail: {other:?}"),
    }
}

/// A cube with an index that is out of range.
fn broken_cube() -> Mesh {
    let mut cube = cuboid([0.0; 3], [1.0; 3]);
    cube.insert_indices(Indices::U32(vec![0, 1, 99]));
    cube
}

fn repair(app: &mut App, handle: &Handle<Mesh>) {
    let whole = cuboid([0.0; 3], [1.0; 3]);
    let indices = whole.indices().unwrap().clone();
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.get_mut(handle).unwrap().insert_indices(indices);
}

/// Rapier's plugin may bring Bevy's for meshes, which marks entities whose mesh changed; a server
/// has neither, and the plugin alone must detect it.
fn app_without_rapier() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), HullwrightPlugin::default()));
    app
}

/// No time limit per frame, so that all of one kind fail in the same.
fn unhurried() -> HullwrightSettings {
    HullwrightSettings {
        frame_budget: Duration::from_secs(60),
        max_attached_per_frame: usize::MAX,
        ..default()
    }
}

#[test]
fn a_mesh_that_is_repaired_is_decomposed() {
    let mut app = app_without_rapier();
    let handle = add(&mut app, broken_cube());
    let entities = [spawn(&mut app, &handle), spawn(&mut app, &handle)];
    update_until_finished(&mut app, &entities);
    for entity in entities {
        assert!(matches!(failure(&app, entity), DecompositionError::Mesh(_)));
    }
    repair(&mut app, &handle);
    update_until(&mut app, |app| {
        entities.iter().all(|entity| matches!(status(app, *entity), DecompositionStatus::Ready(_)))
    });
    for entity in entities {
        assert_near(bounds(&app, entity).1, [1.0; 3], 1e-3);
    }
}

#[test]
fn what_failed_without_a_tag_is_left_alone() {
    let mut app = app_without_rapier();
    let handle = add(&mut app, broken_cube());
    let entity = finish(&mut app, &handle, ());
    app.world_mut().entity_mut(entity).remove::<ConvexDecomposition>();
    repair(&mut app, &handle);
    update_times(&mut app, 5);
    assert!(matches!(failure(&app, entity), DecompositionError::Mesh(_)));
    assert!(!has_collider(&app, entity));
}

#[test]
fn a_body_without_mass_gets_its_triangles_when_it_becomes_fixed() {
    let mut app = app();
    let handle = add(&mut app, unit_cube());
    let tag = automatic().with_density(0.0);
    let entity = app.world_mut().spawn((Mesh3d(handle), tag, RigidBody::Dynamic)).id();
    update_until_finished(&mut app, &[entity]);
    assert!(matches!(failure(&app, entity), DecompositionError::Collider(_)));
    app.world_mut().entity_mut(entity).insert(RigidBody::Fixed);
    update_until(&mut app, |app| has_collider(app, entity));
    assert!(collider(&app, entity).as_trimesh().is_some());
}

#[test]
fn a_mesh_that_can_not_be_loaded_fails_and_recovers_when_it_is_there() {
    let mut app = app();
    let handle: Handle<Mesh> = app.world().resource::<AssetServer>().load("nowhere.mesh");
    let entity = finish(&mut app, &handle, ());
    assert_eq!(failure(&app, entity), DecompositionError::NotLoaded);
    let cube = cuboid([0.0; 3], [1.0; 3]);
    app.world_mut().resource_mut::<Assets<Mesh>>().insert(handle.id(), cube).unwrap();
    update_until(&mut app, |app| {
        status(app, entity) == DecompositionStatus::Ready(HullSource::Decomposed)
    });
}

#[test]
fn baked_hulls_that_can_not_be_loaded_fail_and_recover_when_they_are_there() {
    let mut app = app();
    let handle = app.world().resource::<AssetServer>().load("nowhere.hulls");
    let entity = app.world_mut().spawn(BakedDecomposition::new(handle.clone())).id();
    update_until_finished(&mut app, &[entity]);
    assert_eq!(failure(&app, entity), DecompositionError::NotLoaded);
    let mut all = app.world_mut().resource_mut::<Assets<BakedHulls>>();
    all.insert(handle.id(), BakedHulls(baked())).unwrap();
    update_until(&mut app, |app| {
        status(app, entity) == DecompositionStatus::Ready(HullSource::Baked)
    });
}

#[test]
fn a_fixed_body_fails_as_clearly_as_others() {
    let nothing_finite = || mesh(vec![[f32::NAN; 3]; 3], vec![0, 1, 2]);
    let lines = || {
        Mesh::new(PrimitiveTopology::LineList, default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 6])
    };
    for (mesh, is_expected) in [
        (broken_cube(), |failure| {
            matches!(failure, DecompositionError::Mesh(Error::IndexOutOfRange { .. }))
        }),
        (nothing_finite(), |failure| {
            matches!(failure, DecompositionError::Mesh(Error::NothingUsable { .. }))
        }),
        (lines(), |failure| matches!(failure, DecompositionError::NotTriangles("lines"))),
    ] as [(Mesh, fn(DecompositionError) -> bool); 3]
    {
        let (app, entity) = finished(mesh, (automatic(), RigidBody::Fixed));
        let failure = failure(&app, entity);
        assert!(is_expected(failure.clone()), "{failure:?}");
        assert!(!has_collider(&app, entity));
        assert_eq!(failed(&app).len(), 1);
        assert_eq!((counters(&app).failed, counters(&app).triangle_meshes), (1, 0));
    }
}

#[test]
fn all_that_share_a_bad_mesh_fail_the_later_at_once_and_one_line_is_logged() {
    Log::install();
    let mut app = app();
    // No other test has a mesh of two vertices, and all share the log.
    let bad = add(&mut app, mesh(vec![[0.0; 3]; 2], Vec::new()));
    let entities: Vec<Entity> = (0..5).map(|_| spawn(&mut app, &bad)).collect();
    update_until_finished(&mut app, &entities);
    assert_eq!((counters(&app).failed, counters(&app).running), (5, 0));
    let later = spawn(&mut app, &bad);
    app.update();
    assert_eq!(status(&app, later), status(&app, entities[0]));
    assert_eq!((counters(&app).failed, failed(&app).len()), (6, 6));
    update_times(&mut app, 20);
    let lines = Log::lines_with("2 vertices");
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(!lines[0].contains('\n'));
}

#[test]
fn all_with_a_bad_density_fail_and_one_line_is_logged() {
    Log::install();
    let mut app = app_with(unhurried());
    let mesh = add(&mut app, unit_cube());
    let _ = finish(&mut app, &mesh, ());
    // No other test has this density: the text says the mass.
    let tag = tag().with_density(-1.25e-7);
    let entities: Vec<Entity> =
        (0..30).map(|_| app.world_mut().spawn((Mesh3d(mesh.clone()), tag.clone())).id()).collect();
    update_until_finished(&mut app, &entities);
    assert_eq!(counters(&app).failed, 30);
    let text = failure(&app, entities[0]).to_string();
    let lines = Log::lines_with(&text);
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("30 entities"), "{lines:?}");
}

#[test]
fn all_whose_mesh_can_not_be_loaded_fail_and_one_line_is_logged() {
    Log::install();
    let mut app = app_with(unhurried());
    let handle: Handle<Mesh> = app.world().resource::<AssetServer>().load("nowhere.mesh");
    // No other test has as many.
    let entities: Vec<Entity> = (0..23).map(|_| spawn(&mut app, &handle)).collect();
    update_until_finished(&mut app, &entities);
    let lines = Log::lines_with(&DecompositionError::NotLoaded.to_string());
    let lines: Vec<_> = lines.iter().filter(|line| line.contains("23 entities")).collect();
    assert_eq!(lines.len(), 1, "{lines:?}");
}
