//! The collider that an entity has until its own is ready.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use hullwright::bevy::prelude::*;

use crate::app::*;

/// An app with a tagged mesh in the queue, while another keeps the only job busy.
fn app_with_one_in_the_queue(
    settings: HullwrightSettings,
    tag: ConvexDecomposition,
) -> (App, Entity) {
    let mut app = app_with(HullwrightSettings { max_jobs: 1, ..settings });
    let busy = add(&mut app, model("dog"));
    spawn(&mut app, &busy);
    update_until(&mut app, |app| counters(app).running == 1);
    let mesh = add(&mut app, model("u_prism"));
    let entity = spawn_with(&mut app, &mesh, (tag, RigidBody::Dynamic));
    (app, entity)
}

/// Waits for the fallback and then for the collider in its place.
fn assert_falls_back(
    settings: HullwrightSettings,
    kind: FallbackCollider,
    is_it: impl Fn(&Collider) -> bool,
) {
    let (mut app, entity) = app_with_one_in_the_queue(settings, tag().with_fallback_collider(kind));
    update_until(&mut app, |app| has_collider(app, entity));
    assert!(!status(&app, entity).is_finished());
    assert!(is_it(collider(&app, entity)));
    let fallback = bounds(&app, entity);
    update_until_finished(&mut app, &[entity]);
    assert_eq!(hulls(&app, entity).len(), 3);
    let (low, high) = bounds(&app, entity);
    assert_near(low, fallback.0, 2e-2);
    assert_near(high, fallback.1, 2e-2);
    assert!(mass(&app, entity).mass > 0.0);
}

#[test]
fn the_bounding_box_is_the_collider_until_the_hulls_are_ready() {
    assert_falls_back(sliced(), FallbackCollider::BoundingBox, |collider| {
        collider.as_compound().is_some_and(|parts| parts.shapes().count() == 1)
    });
}

#[test]
fn the_convex_hull_is_the_collider_until_the_hulls_are_ready() {
    for settings in [sliced(), default()] {
        assert_falls_back(settings, FallbackCollider::ConvexHull, |collider| {
            collider.as_convex_polyhedron().is_some()
        });
    }
}

#[test]
fn there_is_no_fallback_by_default() {
    let (mut app, entity) = app_with_one_in_the_queue(sliced(), tag());
    let mut frames = 0;
    while !is_ready(&app, entity) {
        assert!(!has_collider(&app, entity), "in frame {frames}");
        app.update();
        frames += 1;
    }
    assert!(frames > 3, "it never waited");
}

#[test]
fn a_fallback_is_removed_with_the_tag() {
    let settings =
        HullwrightSettings { fallback_collider: FallbackCollider::BoundingBox, ..sliced() };
    let (mut app, entity) = app_with_one_in_the_queue(settings, tag());
    update_until(&mut app, |app| has_collider(app, entity));
    app.world_mut().entity_mut(entity).remove::<ConvexDecomposition>();
    update_times(&mut app, 2);
    assert!(!has_collider(&app, entity));
    assert!(app.world().get::<ColliderMassProperties>(entity).is_none());
}
