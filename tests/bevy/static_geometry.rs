//! What never moves gets its triangles, all else hulls.

use bevy::prelude::*;
use bevy_rapier3d::prelude::*;
use bevy_rapier3d::rapier::parry::shape::TriMeshFlags;
use hullwright::bevy::prelude::*;

use crate::app::*;

/// Whether an entity with this ends with triangles, and why.
fn triangles_of(more: impl Bundle) -> Option<SkipReason> {
    triangles_by(automatic(), more)
}

fn triangles_by(tag: ConvexDecomposition, more: impl Bundle) -> Option<SkipReason> {
    let (app, entity) = finished(model("u_prism"), (tag, more));
    let reason = reason(&app, entity);
    let is_mesh = reason.is_some();
    let counters = counters(&app);
    assert_eq!(
        (counters.triangle_meshes, counters.decomposed),
        (usize::from(is_mesh), usize::from(!is_mesh))
    );
    reason
}

fn reason(app: &App, entity: Entity) -> Option<SkipReason> {
    let is_mesh = collider(app, entity).as_trimesh().is_some();
    match status(app, entity) {
        DecompositionStatus::Skipped(reason) if is_mesh => Some(reason),
        DecompositionStatus::Ready(_) if !is_mesh => None,
        other => panic!("{other:?}, and triangles: {is_mesh}"),
    }
}

#[test]
fn triangles_without_a_body_and_on_a_fixed_one_hulls_for_all_that_moves() {
    assert_eq!(triangles_of(()), Some(SkipReason::NoBody));
    assert_eq!(triangles_of(RigidBody::Fixed), Some(SkipReason::FixedBody));
    for body in
        [RigidBody::Dynamic, RigidBody::KinematicPositionBased, RigidBody::KinematicVelocityBased]
    {
        assert_eq!(triangles_of(body), None);
    }
}

#[test]
fn a_sensor_gets_hulls_whatever_its_body() {
    assert_eq!(triangles_of((RigidBody::Fixed, Sensor)), None);
    assert_eq!(triangles_of(Sensor), None);
}

#[test]
fn a_tag_may_ask_for_either() {
    let shaped = |shape| automatic().with_shape(shape);
    assert_eq!(triangles_by(shaped(DecompositionShape::Hulls), RigidBody::Fixed), None);
    let asked = triangles_by(shaped(DecompositionShape::Triangles), RigidBody::Dynamic);
    assert_eq!(asked, Some(SkipReason::TrianglesRequested));
}

#[test]
fn the_settings_may_want_hulls_everywhere() {
    let settings = HullwrightSettings { exact_static_colliders: false, ..default() };
    let (mut app, entity) = finished_with(settings, model("u_prism"), automatic());
    let mesh = add(&mut app, model("l_prism"));
    let fixed = finish(&mut app, &mesh, (automatic(), RigidBody::Fixed));
    assert_eq!([entity, fixed].map(|entity| reason(&app, entity)), [None; 2]);
}

#[test]
fn bodies_and_sensors_that_come_and_go_change_it() {
    let mut app = app();
    let mesh = add(&mut app, model("u_prism"));
    let above = app.world_mut().spawn(Transform::default()).id();
    let entity = finish(&mut app, &mesh, (automatic(), ChildOf(above)));
    let mut expect = |changed, change: fn(&mut EntityWorldMut), expected| {
        change(&mut app.world_mut().entity_mut(changed));
        update_until(&mut app, |app| {
            status(app, entity).is_finished()
                && collider(app, entity).as_trimesh().is_some() == expected
        });
        assert!(expected || app.world().get::<ColliderMassProperties>(entity).is_some());
    };
    expect(above, |_| {}, true);
    expect(above, |body| _ = body.insert(RigidBody::Dynamic), false);
    expect(above, |body| _ = body.insert(RigidBody::Fixed), true);
    expect(entity, |collider| _ = collider.insert(Sensor), false);
    expect(entity, |collider| _ = collider.remove::<Sensor>(), true);
    expect(above, |body| _ = body.insert(RigidBody::Dynamic), false);
    expect(above, |body| _ = body.remove::<RigidBody>(), true);
    expect(above, |body| _ = body.insert(RigidBody::Dynamic), false);
    expect(entity, |collider| _ = collider.remove::<ChildOf>(), true);
}

#[test]
fn internal_edges_are_fixed() {
    let (app, entity) = finished(unit_cube(), automatic());
    let flags = collider(&app, entity).raw.as_trimesh().unwrap().flags();
    assert!(flags.contains(TriMeshFlags::FIX_INTERNAL_EDGES));
}

/// A floor of small triangles at height 0, wound one way or the other.
fn floor(is_turned: bool) -> Mesh {
    const SIDE: u32 = 20;
    let positions = (0..SIDE * SIDE)
        .map(|i| [(i % SIDE) as f32 * 0.5 - 2.0, 0.0, (i / SIDE) as f32 * 0.5 - 5.0]);
    let squares = (0..SIDE - 1).flat_map(|z| (0..SIDE - 1).map(move |x| z * SIDE + x));
    let triangles = squares.flat_map(|a| {
        let (b, c, d) = (a + SIDE, a + 1, a + SIDE + 1);
        if is_turned { [a, c, b, c, d, b] } else { [a, b, c, c, b, d] }
    });
    mesh(positions.collect(), triangles.collect())
}

#[test]
fn a_box_slides_over_a_floor_of_triangles_without_a_bump() {
    for is_turned in [false, true] {
        let (mut app, _) = finished(floor(is_turned), (automatic(), Friction::coefficient(0.0)));
        let half = 0.2;
        let sliding = (
            RigidBody::Dynamic,
            Collider::cuboid(half, half, half),
            Friction::coefficient(0.0),
            Velocity::linear(Vec3::X * 3.0),
            Transform::from_xyz(0.0, half, 0.0),
        );
        let body = app.world_mut().spawn(sliding).id();
        for _ in 0..60 {
            app.update();
            let at = translation(&app, body);
            assert!((at.y - half).abs() < 0.02, "turned: {is_turned}, at {at}");
        }
        assert!((translation(&app, body).x - 3.0).abs() < 0.2);
    }
}
