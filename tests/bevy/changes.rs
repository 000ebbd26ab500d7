//! What starts work anew and what does not: a collider follows what it is made of, and nothing
//! else.

use bevy::ecs::entity_disabling::Disabled;
use bevy::prelude::*;
use bevy_hullwright::DecompositionError;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

/// A box from 0 to 1 that begins at `x`.
fn cube_at(app: &mut App, x: f32) -> Handle<Mesh> {
    add(app, cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]))
}

fn part(app: &mut App, mesh: &Handle<Mesh>, above: Entity) -> Entity {
    app.put((Mesh3d(mesh.clone()), Transform::default(), ChildOf(above)))
}

/// A tagged parent of two boxes, side by side, that has its collider.
fn two_parts() -> (App, Entity, [Entity; 2]) {
    let mut app = app();
    let meshes = [0.0, 2.0].map(|x| cube_at(&mut app, x));
    let above = app.put((Transform::default(), tag(), RigidBody::Dynamic, GravityScale(0.0)));
    let parts = meshes.map(|mesh| part(&mut app, &mesh, above));
    update_until_finished(&mut app, &[above]);
    assert_near(bounds(&app, above).1, [3.0, 1.0, 1.0], 1e-3);
    (app, above, parts)
}

fn all_done(app: &App) -> bool {
    app.world().resource::<DecompositionProgress>().is_done()
}

/// What is seen of a change, also by all that is left to do.
fn settle(app: &mut App) {
    update_times(app, 3);
    update_until(app, all_done);
    // A changed scale or place has to rest first.
    std::thread::sleep(std::time::Duration::from_millis(120));
    update_times(app, 3);
    update_until(app, all_done);
}

#[test]
fn what_is_spawned_disabled_gets_its_collider_when_it_is_enabled() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let pooled = spawn_with(&mut app, &cube, (RigidBody::Dynamic, Disabled));
    settle(&mut app);
    assert!(!has_collider(&app, pooled));
    app.edit(pooled).remove::<Disabled>();
    update_until(&mut app, |app| is_ready(app, pooled));
    assert_is_unit_cube(&app, pooled);
}

#[test]
fn what_is_disabled_while_its_job_runs_goes_on_when_it_is_enabled() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let pooled = spawn_with(&mut app, &mesh, RigidBody::Dynamic);
    update_times(&mut app, 3);
    assert!(matches!(status(&app, pooled), DecompositionStatus::Running { .. }));
    app.edit(pooled).insert(Disabled);
    // Nothing waits for it meanwhile, and it has not ended.
    update_until(&mut app, all_done);
    update_times(&mut app, 100);
    assert_eq!(seen(&app).all(), 0);
    app.edit(pooled).remove::<Disabled>();
    update_until(&mut app, |app| is_ready(app, pooled));
    assert_eq!((seen(&app).all(), counters(&app).decomposed), (1, 1));
    assert_eq!(hulls(&app, pooled).len(), 3);
}

#[test]
fn a_tag_that_is_despawned_while_it_is_disabled_is_cancelled() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let pooled = spawn(&mut app, &mesh);
    update_times(&mut app, 3);
    app.edit(pooled).insert(Disabled);
    update_times(&mut app, 3);
    app.world_mut().despawn(pooled);
    update_times(&mut app, 3);
    assert_eq!(seen(&app).cancelled, [pooled]);
}

#[test]
fn a_part_that_is_disabled_is_no_part_until_it_is_enabled() {
    let (mut app, above, [_, part]) = two_parts();
    app.edit(part).insert(Disabled);
    settle(&mut app);
    assert_is_unit_cube(&app, above);
    app.edit(part).remove::<Disabled>();
    settle(&mut app);
    assert_near(bounds(&app, above).1, [3.0, 1.0, 1.0], 1e-3);
}

#[test]
fn a_tag_that_is_written_each_frame_with_equal_values_changes_nothing() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let entity = spawn(&mut app, &mesh);
    for frame in 0..400 {
        match frame % 2 {
            0 => _ = app.edit(entity).insert((tag(), Mesh3d(mesh.clone()))),
            _ => *app.change::<ConvexDecomposition>(entity) = tag(),
        }
        app.update();
    }
    assert!(is_ready(&app, entity));
    assert_eq!(seen(&app).all(), 1);
}

#[test]
fn only_what_differs_in_what_the_collider_is_made_of_starts_anew() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let entity = finish(&mut app, &cube, FIXED);
    // Hulls are hulls, whatever was to be there meanwhile.
    app.edit(entity).insert(tag().with_fallback_collider(FallbackCollider::BoundingBox));
    app.edit(entity).insert((FIXED, Name::new("same"), friction(0.2)));
    settle(&mut app);
    assert_eq!(seen(&app).all(), 1);
    app.edit(entity).insert(tag().with_density(3.0));
    update_until_ready_times(&mut app, 2);
    assert!((mass(&app, entity).mass - 3.0).abs() < 1e-3);
    assert_eq!(counters(&app).decomposed, 1);
}

#[test]
fn a_part_that_is_despawned_is_no_part_any_more() {
    let (mut app, above, [_, part]) = two_parts();
    app.world_mut().despawn(part);
    settle(&mut app);
    assert_is_unit_cube(&app, above);
    assert!((mass(&app, above).mass / DENSITY - 1.0).abs() < 1e-3);
}

#[test]
fn a_part_that_breaks_off_leaves_no_ghost() {
    let (mut app, above, [_, part]) = two_parts();
    app.edit(part).remove::<ChildOf>().insert((RigidBody::Dynamic, GravityScale(0.0), tag()));
    settle(&mut app);
    assert_is_unit_cube(&app, above);
    assert_near(bounds(&app, part).1, [3.0, 1.0, 1.0], 1e-3);
}

#[test]
fn a_part_that_loses_its_mesh_or_is_left_out_late_is_no_part_any_more() {
    type Change = fn(&mut EntityWorldMut);
    let changes: [Change; 4] = [
        |part| _ = part.remove::<Mesh3d>(),
        |part| _ = part.insert(NoConvexDecomposition),
        |part| _ = part.insert(FIXED),
        |part| _ = part.remove::<ChildOf>(),
    ];
    for change in changes {
        let (mut app, above, [_, part]) = two_parts();
        change(&mut app.edit(part));
        settle(&mut app);
        assert_is_unit_cube(&app, above);
    }
}

#[test]
fn a_part_comes_by_being_put_below_or_let_in() {
    let mut app = app();
    let meshes = [0.0, 2.0, 4.0].map(|x| cube_at(&mut app, x));
    let above = app.put((Transform::default(), tag()));
    part(&mut app, &meshes[0], above);
    let left_out = part(&mut app, &meshes[1], above);
    app.edit(left_out).insert(NoConvexDecomposition);
    // The mesh is a child of what is put below.
    let elsewhere = app.put(Transform::default());
    part(&mut app, &meshes[2], elsewhere);
    update_until_finished(&mut app, &[above]);
    assert_is_unit_cube(&app, above);
    app.edit(left_out).remove::<NoConvexDecomposition>();
    settle(&mut app);
    assert_near(bounds(&app, above).1, [3.0, 1.0, 1.0], 1e-3);
    app.edit(elsewhere).insert(ChildOf(above));
    settle(&mut app);
    assert_near(bounds(&app, above).1, [5.0, 1.0, 1.0], 1e-3);
}

#[test]
fn without_any_mesh_there_is_no_collider_until_one_comes() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let entity = finish(&mut app, &cube, ());
    app.edit(entity).remove::<Mesh3d>();
    update_times(&mut app, 3);
    assert!(!has_collider(&app, entity));
    assert_eq!(status(&app, entity), DecompositionStatus::Waiting(WaitReason::ForMesh));
    app.edit(entity).insert(Mesh3d(cube));
    update_until(&mut app, |app| is_ready(app, entity));
    assert_is_unit_cube(&app, entity);
}

#[test]
fn a_part_that_moves_takes_its_hulls_along_once_it_rests() {
    let (mut app, above, [_, part]) = two_parts();
    for step in 0..10 {
        app.change::<Transform>(part).translation.x = step as f32;
        app.update();
    }
    // While it moves the collider stays as it was.
    assert_near(bounds(&app, above).1, [3.0, 1.0, 1.0], 1e-3);
    settle(&mut app);
    assert_near(bounds(&app, above).1, [12.0, 1.0, 1.0], 1e-3);
}

#[test]
fn what_is_loaded_from_a_save_has_the_mass_of_its_tag_and_that_of_the_game_stays() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let entity = finish(&mut app, &cube, (RigidBody::Dynamic, GravityScale(0.0)));
    let with_own =
        finish(&mut app, &cube, (RigidBody::Dynamic, GravityScale(0.0), games_mass(7.0)));
    for (entity, is_own) in [(entity, false), (with_own, true)] {
        let saved = saved(&app, entity);
        let loaded = load(&mut app, &saved);
        app.edit(loaded).insert(Mesh3d(cube.clone()));
        update_times(&mut app, 3);
        update_until_finished(&mut app, &[loaded]);
        app.edit(loaded).insert(tag().with_density(0.5 * DENSITY));
        settle(&mut app);
        match is_own {
            true => assert!(has_games_mass(&app, loaded, 7.0)),
            false => assert!((mass(&app, loaded).mass / (0.5 * DENSITY) - 1.0).abs() < 1e-3),
        }
    }
}

#[test]
fn mass_properties_that_the_game_sets_later_are_its_own() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let entity = finish(&mut app, &cube, ());
    app.edit(entity).insert(games_mass(7.0));
    set_scale(&mut app, entity, Vec3::splat(2.0));
    settle(&mut app);
    assert_near(bounds(&app, entity).1, [2.0; 3], 1e-2);
    assert!(has_games_mass(&app, entity, 7.0));
}

#[test]
fn a_body_that_becomes_fixed_keeps_no_mass_of_its_hulls() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let entity = finish(&mut app, &cube, (automatic(), RigidBody::Dynamic));
    app.edit(entity).insert(FIXED);
    settle(&mut app);
    assert!(shape(collider(&app, entity)).as_trimesh().is_some());
    assert!(!has_mass(&app, entity));
}

#[test]
fn a_result_is_attached_at_the_scale_of_then_and_so_is_a_fallback() {
    let mut settings = sliced();
    settings.fallback_collider = FallbackCollider::BoundingBox;
    let (mut app, mesh) = with_mesh(app_with(settings), model("u_prism"));
    let entity = spawn_with(&mut app, &mesh, FIXED);
    update_until(&mut app, |app| has_collider(app, entity));
    let before = bounds(&app, entity);
    assert!(!status(&app, entity).is_finished());
    set_scale(&mut app, entity, Vec3::splat(3.0));
    update_times(&mut app, 3);
    assert!(!status(&app, entity).is_finished(), "it was ready too soon");
    assert_bounds(&app, entity, 3.0 * before.0, 3.0 * before.1, 1e-2);
    while !status(&app, entity).is_finished() {
        app.update();
    }
    // In the very frame in which it is there.
    assert_bounds(&app, entity, 3.0 * before.0, 3.0 * before.1, 0.1);
    assert!(mass(&app, entity).mass > 0.0);
}

#[test]
fn a_mesh_that_is_edited_each_frame_is_followed_and_the_log_says_so_once() {
    Log::install();
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let entity = spawn_with(&mut app, &mesh, Name::new("sculpture"));
    let heights = |app: &App| has_collider(app, entity).then(|| bounds(app, entity).1.y);
    let mut found = Vec::new();
    let edit = |app: &mut App| {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        let mut mesh = meshes.get_mut(&mesh).unwrap();
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
        let higher: Vec<_> = positions.iter().map(|[x, y, z]| [*x, 1.001 * y, *z]).collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, higher);
    };
    for _ in 0..300 {
        edit(&mut app);
        app.update();
        found.extend(heights(&app));
    }
    assert!(found.is_sorted());
    found.dedup();
    assert!(found.len() > 3, "{} colliders", found.len());
    let said = Log::lines_with("sculpture");
    assert_eq!(said.iter().filter(|line| line.contains("faster")).count(), 1, "{said:?}");
    update_until(&mut app, all_done);
    update_times(&mut app, 3);
    update_until(&mut app, all_done);
    let meshes = app.world().resource::<Assets<Mesh>>();
    let points = meshes.get(&mesh).unwrap().attribute(Mesh::ATTRIBUTE_POSITION).unwrap();
    let top = points.as_float3().unwrap().iter().map(|point| point[1]).fold(0.0, f32::max);
    assert!((heights(&app).unwrap() / top - 1.0).abs() < 0.02);
}

#[test]
fn a_body_that_engines_would_turn_by_its_mirrored_scale_fails_and_the_error_says_what_to_do() {
    for scale in [[1.0, -1.0, 1.0], [1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]] {
        let mut app = app();
        let mesh = cube_at(&mut app, 3.0);
        let mirrored = Transform::from_scale(scale.into());
        let mut body_with_child = |of_body: Transform, of_child: Transform| {
            let body = app.put((of_body, RigidBody::Dynamic, GravityScale(0.0)));
            let child = part(&mut app, &mesh, body);
            app.edit(child).insert((tag(), of_child));
            update_until_finished(&mut app, &[child]);
            update_times(&mut app, 5);
            child
        };
        let failed = body_with_child(mirrored, Transform::default());
        // As the error says.
        let child = body_with_child(Transform::default(), mirrored);
        let DecompositionStatus::Failed(error) = status(&app, failed) else { panic!("{scale:?}") };
        assert_eq!(error, DecompositionError::MirroredBody);
        assert!(error.to_string().contains("mirror"), "{error}");
        assert_is_where_it_is_drawn(&mut app, child, Vec3::new(3.5, 0.5, 0.5));
        // It is mirrored while it has its collider.
        set_scale(&mut app, child, Vec3::ONE);
        settle(&mut app);
        assert_is_where_it_is_drawn(&mut app, child, Vec3::new(3.5, 0.5, 0.5));
    }
}

/// Whether the middle of a collider is where that of its mesh is.
fn assert_is_where_it_is_drawn(app: &mut App, entity: Entity, middle: Vec3) {
    let drawn = app.get::<GlobalTransform>(entity).unwrap().transform_point(middle);
    let (low, high) = bounds(app, entity);
    let (place, _) = in_engine(app, entity);
    assert_near(place.transform_point3((low + high) / 2.0), drawn, 1e-2);
}

#[test]
fn a_collider_that_the_game_puts_there_meanwhile_is_its_own() {
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("u_prism"));
    let entity = spawn(&mut app, &mesh);
    update_times(&mut app, 3);
    assert!(!status(&app, entity).is_finished());
    app.edit(entity).insert(ball(0.5));
    update_times(&mut app, 100);
    assert!(shape(collider(&app, entity)).as_ball().is_some());
    assert_eq!(status(&app, entity), DecompositionStatus::Skipped(SkipReason::HasCollider));
    assert_eq!(seen(&app).all(), 1);
    // Where it goes, the tag has its way.
    app.edit(entity).remove::<Collider>();
    update_until(&mut app, |app| is_ready(app, entity));
    assert_eq!(hulls(&app, entity).len(), 3);
}

#[test]
fn the_games_collider_in_place_of_the_plugins_stays_and_one_that_it_removes_comes_back() {
    let (mut app, cube) = with_mesh(app(), unit_cube());
    let entity = finish(&mut app, &cube, ());
    app.edit(entity).insert(ball(0.5));
    settle(&mut app);
    assert_eq!(status(&app, entity), DecompositionStatus::Skipped(SkipReason::HasCollider));
    set_scale(&mut app, entity, Vec3::splat(2.0));
    settle(&mut app);
    assert!(shape(collider(&app, entity)).as_ball().is_some());
    app.edit(entity).remove::<Collider>();
    settle(&mut app);
    assert!(is_ready(&app, entity));
    app.edit(entity).remove::<Collider>();
    update_times(&mut app, 1);
    assert!(has_collider(&app, entity) || !status(&app, entity).is_finished());
    settle(&mut app);
    assert!(is_ready(&app, entity));
    assert_near(bounds(&app, entity).1, [2.0; 3], 1e-2);
}

#[test]
fn an_animated_scale_is_followed_in_the_same_frame_and_that_of_a_parent_in_the_next() {
    let (mut app, mesh) = with_mesh(app(), model("u_prism"));
    let above = app.put(Transform::default());
    for (is_below, lateness) in [(false, 0), (true, 1)] {
        let entity = finish(&mut app, &mesh, ());
        let scaled = if is_below { above } else { entity };
        if is_below {
            app.edit(entity).insert(ChildOf(above));
            settle(&mut app);
        }
        let events = ready(&app).len();
        let (before, density) = (bounds(&app, entity).1, mass(&app, entity).mass);
        let mut scales = vec![1.0; 2];
        for step in 0..60 {
            let scale = 1.0 + (step as f32 / 5.0).sin() / 2.0;
            scales.push(scale);
            set_scale(&mut app, scaled, Vec3::splat(scale));
            app.update();
            let found = bounds(&app, entity).1.y / before.y;
            let is_near = |scale: &f32| (found - scale).abs() < 1e-2;
            let last = &scales[scales.len() - 1 - lateness..];
            assert!(last.iter().any(is_near), "{found} is none of {last:?}");
            let (_, in_engine) = in_engine(&mut app, entity);
            assert_near(in_engine.compute_local_aabb().maxs, bounds(&app, entity).1, 1e-3);
        }
        let now = bounds(&app, entity).1.y / before.y;
        assert!((mass(&app, entity).mass / density / now.powi(3) - 1.0).abs() < 2e-2);
        // No event for each frame, and one in the end.
        assert!(ready(&app).len() <= events + 1, "{}", ready(&app).len() - events);
    }
}

#[test]
fn faces_of_hulls_that_follow_a_stretch_keep_normals_at_right_angles_to_them() {
    let scale_delay = std::time::Duration::from_secs(3600);
    let settings = HullwrightSettings { scale_delay, ..default() };
    let (mut app, mesh) = with_mesh(app_with(settings), model("torus"));
    let entity = finish(&mut app, &mesh, ());
    let before = bounds(&app, entity).1;
    set_scale(&mut app, entity, Vec3::new(1.0, 4.0, 2.0));
    app.update();
    assert_near(bounds(&app, entity).1, before * Vec3::new(1.0, 4.0, 2.0), 1e-2);
    assert_faces_are_right(&app, entity);
}
