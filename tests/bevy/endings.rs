//! One answer to "is the collider there?": events, status, counters, the hierarchy's report and the
//! collider itself agree, however a tag ends. No collider of another mesh or size stays behind an
//! ending that says there is none.

use bevy::mesh::Indices;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

fn broken() -> Mesh {
    let mut cube = unit_cube();
    cube.insert_indices(Indices::U32(vec![0, 1, 99]));
    cube
}

/// A node of a scene with one mesh.
fn node(app: &mut App, root: Entity, mesh: &Handle<Mesh>, name: &str, more: impl Bundle) -> Entity {
    let node = (Name::new(name.to_owned()), Mesh3d(mesh.clone()), Transform::from_xyz(1., 0., 0.));
    let node = app.put((node, ChildOf(root)));
    app.edit(node).insert(more);
    node
}

#[test]
fn events_status_counters_and_report_agree_over_all_endings() {
    let skip = SkipSettings { min_size: 0.1, hidden: true, focus_radius: Some(100.0), ..default() };
    let mut app = app_with(skipping(skip));
    app.world_mut().spawn((Transform::default(), DecompositionFocus));
    let [cube, bad] = [unit_cube(), broken()].map(|mesh| add(&mut app, mesh));
    let never = app.world().resource::<Assets<Mesh>>().reserve_handle();
    let hierarchy = ConvexDecompositionHierarchy::new(automatic())
        .with("hulls", tag())
        .with("box", tag().with_shape(DecompositionShape::Cuboid))
        .with("triangles", tag().with_shape(DecompositionShape::Triangles));
    let root = app.put((Transform::default(), hierarchy));
    let mut expected: Vec<(Entity, Result<MadeOf, AbsentReason>)> = Vec::new();
    let skipped = |reason| Err(AbsentReason::Skipped(reason));
    let at = Transform::from_xyz;
    for (name, made_of) in [
        ("hulls", MadeOf::Hulls(1)),
        ("box", MadeOf::Primitive),
        ("triangles", MadeOf::Triangles),
        ("no body", MadeOf::Triangles),
    ] {
        expected.push((node(&mut app, root, &cube, name, ()), Ok(made_of)));
    }
    let fixed = node(&mut app, root, &cube, "fixed", FIXED);
    expected.push((fixed, Ok(MadeOf::Triangles)));
    let own = node(&mut app, root, &cube, "own", ball(0.5));
    expected.push((own, Ok(MadeOf::Existing)));
    let small = at(1.0, 0.0, 0.0).with_scale(Vec3::splat(0.01));
    let small = node(&mut app, root, &cube, "small", small);
    expected.push((small, skipped(SkipReason::TooSmall)));
    let far = node(&mut app, root, &cube, "far", at(500.0, 0.0, 0.0));
    expected.push((far, skipped(SkipReason::TooFar)));
    #[cfg(feature = "bevy_gltf")]
    {
        let hidden = node(&mut app, root, &cube, "hidden", Visibility::Hidden);
        expected.push((hidden, skipped(SkipReason::Hidden)));
    }
    let cancelled = node(&mut app, root, &never, "cancelled", ());
    expected.push((cancelled, Err(AbsentReason::Cancelled)));
    let failed = node(&mut app, root, &bad, "failed", ());

    update_times(&mut app, 5);
    app.edit(cancelled).remove::<ConvexDecomposition>();
    update_until(&mut app, |app| app.get::<HierarchyStatus>(root).unwrap().is_finished());
    let DecompositionStatus::Failed(error) = status(&app, failed) else { panic!() };
    expected.push((failed, Err(AbsentReason::Failed(error))));

    let (with, without): (Vec<_>, Vec<_>) = expected.iter().partition(|(_, it)| it.is_ok());
    let seen = seen(&app);
    assert_eq!(seen.all(), expected.len());
    for (entity, answer) in &expected {
        let has_collider = answer.is_ok();
        match answer {
            Ok(made_of) => {
                assert!(seen.with_collider.contains(&(*entity, *made_of)), "{made_of:?}")
            }
            Err(reason) => {
                assert!(seen.without_collider.contains(&(*entity, reason.clone())), "{reason}");
            }
        }
        assert_eq!(status(&app, *entity).has_collider(), Some(has_collider), "{answer:?}");
        assert_eq!(app.get::<Collider>(*entity).is_some(), has_collider, "{answer:?}");
    }
    let counters = counters(&app);
    assert_eq!((counters.with_collider, counters.without_collider), (with.len(), without.len()));
    let Some(HierarchyStatus::Finished(report)) = app.get(root) else { panic!() };
    assert_eq!((report.with_collider, report.without_collider), (with.len(), without.len()));
    let all = report.ready + report.skipped + report.failed + report.cancelled;
    assert_eq!(all, expected.len());
}

#[test]
fn a_collider_of_another_size_does_not_stay_behind_one_that_is_too_small() {
    let mut app = app_with(HullwrightSettings {
        scale_delay: std::time::Duration::ZERO,
        ..skipping(SkipSettings { min_size: 0.5, ..default() })
    });
    let cube = add(&mut app, unit_cube());
    let entity = finish(&mut app, &cube, Transform::default());
    assert!(is_ready(&app, entity));
    set_scale(&mut app, entity, Vec3::splat(0.1));
    update_until(&mut app, |app| {
        status(app, entity) == DecompositionStatus::Skipped(SkipReason::TooSmall)
    });
    update_times(&mut app, 2);
    assert!(!has_collider(&app, entity));
    assert!(!has_mass(&app, entity));
    // Large enough again.
    set_scale(&mut app, entity, Vec3::ONE);
    update_until(&mut app, |app| is_ready(app, entity));
    assert_is_unit_cube(&app, entity);
}

#[test]
fn a_collider_of_another_mesh_does_not_stay_behind_one_that_fails() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let entity = finish(&mut app, &cube, ());
    let bad = add(&mut app, broken());
    app.edit(entity).insert(Mesh3d(bad));
    update_until(&mut app, |app| matches!(status(app, entity), DecompositionStatus::Failed(_)));
    update_times(&mut app, 2);
    assert!(!has_collider(&app, entity));
    app.edit(entity).insert(Mesh3d(cube));
    update_until(&mut app, |app| is_ready(app, entity));
    assert_is_unit_cube(&app, entity);
}

#[test]
fn a_tag_that_is_removed_while_a_new_collider_is_made_leaves_the_old_one_and_says_so() {
    let (mut app, cube) = with_mesh(app_with(sliced()), unit_cube());
    let entity = finish(&mut app, &cube, ());
    let despawned = finish(&mut app, &cube, ());
    let other = add(&mut app, model("u_prism"));
    for entity in [entity, despawned] {
        app.edit(entity).insert(Mesh3d(other.clone()));
    }
    update_times(&mut app, 2);
    assert!(!status(&app, entity).is_finished());
    app.edit(entity).remove::<ConvexDecomposition>();
    app.world_mut().despawn(despawned);
    update_times(&mut app, 3);
    assert_eq!(status(&app, entity), DecompositionStatus::Skipped(SkipReason::HasCollider));
    assert_is_unit_cube(&app, entity);
    assert_eq!(seen(&app).with_collider.last(), Some(&(entity, MadeOf::Existing)));
    assert_eq!(seen(&app).without_collider, [(despawned, AbsentReason::Cancelled)]);
    assert_eq!(seen(&app).all(), 4);
}

#[test]
fn a_fallback_does_not_stay_behind_one_that_is_too_small() {
    let mut settings = sliced();
    settings.fallback_collider = FallbackCollider::BoundingBox;
    settings.skip.min_size = 0.5;
    let (mut app, mesh) = with_mesh(app_with(settings), model("u_prism"));
    let entity = spawn(&mut app, &mesh);
    update_until(&mut app, |app| has_collider(app, entity));
    assert!(!status(&app, entity).is_finished());
    set_scale(&mut app, entity, Vec3::splat(0.01));
    app.edit(entity).insert(tag());
    update_times(&mut app, 5);
    assert_eq!(status(&app, entity), DecompositionStatus::Skipped(SkipReason::TooSmall));
    assert!(!has_collider(&app, entity));
}
