//! Colliders in children, one for each hull or for each part.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

/// Children with colliders, with the hulls that each has.
fn children(app: &App, entity: Entity) -> Vec<(Entity, Vec<u32>)> {
    let all = app.get::<Children>(entity).into_iter().flatten().copied();
    all.filter_map(|child| Some((child, app.get::<HullCollider>(child)?.hulls.clone()))).collect()
}

fn each_hull() -> ConvexDecomposition {
    tag().as_children(HullGrouping::EachHull)
}

fn with_children(app: &mut App, mesh: &Handle<Mesh>, more: impl Bundle) -> Entity {
    let body = app.put((Mesh3d(mesh.clone()), each_hull(), more));
    update_until_finished(app, &[body]);
    body
}

#[test]
fn each_hull_has_a_child_and_the_body_weighs_and_turns_as_one() {
    for scale in [Vec3::ONE, Vec3::new(1.0, 2.0, 0.5)] {
        let place = Transform::from_xyz(0.0, 5.0, 0.0).with_scale(scale);
        let mut app = app();
        let mesh = add(&mut app, model("chair"));
        let whole = finish(&mut app, &mesh, (RigidBody::Dynamic, place));
        let expected = hulls(&app, whole);
        let body = with_children(&mut app, &mesh, (RigidBody::Dynamic, place));
        assert!(is_ready(&app, body) && !has_collider(&app, body));
        let children = children(&app, body);
        assert_eq!(children.len(), expected.len());
        for (child, own) in &children {
            assert_eq!(hulls(&app, *child), [expected[own[0] as usize].clone()]);
        }
        update_times(&mut app, 3);
        let [(mass, centre), (mass2, centre2)] =
            [whole, body].map(|body| mass_of_whole(&mut app, body));
        assert!((mass2 / mass - 1.0).abs() < 1e-3, "{mass2} of {mass}");
        assert_near(centre2, centre, 1e-4);
        let sensor = app.put(Sensor);
        let sensor = app.edit(sensor).take::<Sensor>().unwrap();
        app.edit(children[0].0).insert(sensor);
        update_times(&mut app, 3);
        let (mass2, _) = mass_of_whole(&mut app, body);
        assert!((mass2 / mass - 1.0).abs() < 1e-3, "with a sensor {mass2} of {mass}");
    }
}

#[test]
fn a_child_knows_its_part_and_may_have_a_surface_of_its_own() {
    #[derive(Component)]
    struct Ice;
    fn slip(
        added: On<Add<HullCollider>>,
        parts: Query<&ColliderParts>,
        ice: Query<(), With<Ice>>,
        mut commands: Commands,
    ) {
        if parts.get(added.entity).unwrap().part(0).is_some_and(|part| ice.contains(part)) {
            commands.entity(added.entity).insert(friction(0.01));
        }
    }
    let mut app = app();
    app.add_observer(slip);
    let meshes = [0.0, 3.0].map(|x| add(&mut app, cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])));
    let tag = tag().as_children(HullGrouping::EachPart);
    let whole = app.put((tag, RigidBody::Dynamic, friction(0.9), Transform::default()));
    let parts = meshes.map(|mesh| app.put((Mesh3d(mesh), Transform::default(), ChildOf(whole))));
    app.edit(parts[1]).insert(Ice);
    update_until_finished(&mut app, &[whole]);
    let children = children(&app, whole);
    assert_eq!(children.len(), 2);
    for (child, _) in children {
        let is_ice = hulls(&app, child)[0][0].x > 2.0;
        let part = parts[usize::from(is_ice)];
        assert_eq!(app.get::<ColliderParts>(child).unwrap().part(0), Some(part));
        let expected = if is_ice { friction(0.01) } else { friction(0.9) };
        assert_eq!(app.get::<Friction>(child), Some(&expected));
    }
}

#[test]
fn children_follow_the_scale_and_go_with_the_tag_that_asked_for_them() {
    let mut app = app();
    let mesh = add(&mut app, model("l_prism"));
    let body = with_children(&mut app, &mesh, RigidBody::Dynamic);
    let expected: Vec<(Vec3, Vec3)> =
        children(&app, body).iter().map(|(child, _)| bounds(&app, *child)).collect();
    set_scale(&mut app, body, Vec3::splat(2.0));
    update_times(&mut app, 2);
    for ((child, _), (low, high)) in children(&app, body).iter().zip(&expected) {
        assert_bounds(&app, *child, *low * 2.0, *high * 2.0, 1e-3);
    }
    update_until_ready_times(&mut app, 2);
    assert_eq!(children(&app, body).len(), expected.len());

    app.edit(body).insert(tag());
    update_until(&mut app, |app| has_collider(app, body));
    assert!(children(&app, body).is_empty());
    app.edit(body).insert(each_hull());
    update_until(&mut app, |app| !has_collider(app, body));
    assert_eq!(children(&app, body).len(), expected.len());
    // What the game puts there is its own.
    app.edit(body).insert(ball(1.0));
    update_times(&mut app, 3);
    assert!(children(&app, body).is_empty() && has_collider(&app, body));
}

#[test]
fn a_clone_has_children_of_its_own() {
    let mut app = app();
    let mesh = add(&mut app, model("l_prism"));
    let body = with_children(&mut app, &mesh, RigidBody::Dynamic);
    let clone = clone_of(&mut app, body);
    update_until(&mut app, |app| children(app, clone).len() == 2);
    update_times(&mut app, 5);
    let [own, others] = [body, clone].map(|body| children(&app, body));
    assert_eq!([own.len(), others.len()], [2, 2]);
    assert!(own.iter().all(|(child, _)| others.iter().all(|(other, _)| other != child)));
}

#[test]
fn a_body_that_breaks_leaves_none_of_them() {
    let mut app = app();
    let mesh = add(&mut app, model("l_prism"));
    let body = with_children(&mut app, &mesh, RigidBody::Dynamic);
    let before = children(&app, body);
    app.world_mut().commands().entity(body).break_apart(HullGrouping::EachHull);
    update_times(&mut app, 2);
    assert!(before.iter().all(|(child, _)| app.world().get_entity(*child).is_err()));
    let world = app.world_mut();
    assert_eq!(world.query::<&Fragment>().iter(world).count(), 2);
}
