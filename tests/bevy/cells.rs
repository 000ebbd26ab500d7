//! What never moves: few triangles within a bound, and one collider for all in a cell of a scene.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;
use crate::skipping::floor;

/// The side of a cell.
const SIZE: f32 = 10.0;

/// A fixed scene whose cells have colliders, with cubes of one metre at these places.
fn scene(app: &mut App, places: &[[f32; 3]]) -> (Entity, Vec<Entity>) {
    let hierarchy = ConvexDecompositionHierarchy::default().with_cells(SIZE);
    let root = app.put((Transform::default(), FIXED, hierarchy));
    let cube = add(app, unit_cube());
    let cubes = places.iter().map(|place| put(app, root, &cube, *place)).collect();
    (root, cubes)
}

fn put(app: &mut App, root: Entity, mesh: &Handle<Mesh>, place: [f32; 3]) -> Entity {
    app.put((Mesh3d(mesh.clone()), Transform::from_translation(place.into()), ChildOf(root)))
}

/// Updates until all have their colliders, also those that are made anew.
fn settle(app: &mut App, entities: &[Entity]) {
    update_times(app, 3);
    update_until_finished(app, entities);
    update_until(app, |app| app.world().resource::<DecompositionProgress>().is_done());
    update_times(app, 3);
}

fn cells(app: &mut App) -> Vec<Entity> {
    let world = app.world_mut();
    world.query_filtered::<Entity, With<LevelCell>>().iter(world).collect()
}

fn colliders(app: &mut App) -> usize {
    let world = app.world_mut();
    world.query::<&Collider>().iter(world).count()
}

fn cell_of(app: &App, entity: Entity) -> Option<Entity> {
    app.get::<InLevelCell>(entity).map(InLevelCell::cell)
}

/// The entity whose mesh a ray downward meets.
fn met(app: &mut App, x: f32, z: f32) -> Option<Entity> {
    let (collider, subshape) = below(app, Vec3::new(x, 9.0, z))?;
    app.get::<ColliderParts>(collider)?.part(subshape)
}

#[test]
fn small_things_of_a_scene_that_never_move_share_the_collider_of_their_cell() {
    let mut app = app();
    let (root, cubes) = scene(
        &mut app,
        &[[1.0, 0.0, 1.0], [4.0, 0.0, 1.0], [7.0, 0.0, 7.0], [12.0, 0.0, 1.0], [15.0, 0.0, 1.0]],
    );
    let floor = add(&mut app, cuboid([-40.0, -1.0, -40.0], [40.0, 0.0, 40.0]));
    let floor = put(&mut app, root, &floor, [0.0; 3]);
    let all = [&cubes[..], &[floor]].concat();
    settle(&mut app, &all);
    assert_eq!(cells(&mut app).len(), 2);
    assert_eq!(colliders(&mut app), 3);
    assert_eq!(counters(&app).level_cells, 2);
    assert!(has_collider(&app, floor) && !has_collider(&app, cubes[0]));
    assert_eq!(cell_of(&app, cubes[0]), cell_of(&app, cubes[2]));
    assert_ne!(cell_of(&app, cubes[0]), cell_of(&app, cubes[3]));
    let of_cell = app.get::<LevelCell>(cell_of(&app, cubes[3]).unwrap()).unwrap();
    assert_eq!(of_cell.entities(), &cubes[3..]);
    for &entity in &all {
        assert_eq!(status(&app, entity), DecompositionStatus::Skipped(SkipReason::FixedBody));
        assert!(seen(&app).with_collider.contains(&(entity, MadeOf::Triangles)));
    }
    // A ray says which of them it meets, on whichever side.
    for (entity, x, z) in [(cubes[0], 1.5, 1.5), (cubes[2], 7.2, 7.7), (cubes[4], 15.9, 1.1)] {
        assert_eq!(met(&mut app, x, z), Some(entity));
    }
    assert_eq!(met(&mut app, -5.0, -5.0), Some(floor));
}

#[test]
fn what_leaves_its_cell_is_no_part_of_it_any_more() {
    let mut app = app();
    let places = [[0.0; 3], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0], [6.0, 0.0, 0.0]];
    let (_, cubes) = scene(&mut app, &places);
    settle(&mut app, &cubes);
    let [gone, moved, thrown, stays] = cubes[..].try_into().unwrap();
    let cell = cell_of(&app, stays).unwrap();
    app.world_mut().despawn(gone);
    app.change::<Transform>(moved).translation.z = 5.0;
    app.edit(thrown).insert(RigidBody::Dynamic);
    settle(&mut app, &[moved, thrown, stays]);
    assert_eq!(app.get::<LevelCell>(cell).unwrap().entities(), &[stays]);
    assert_eq!([moved, thrown].map(|entity| cell_of(&app, entity)), [None; 2]);
    assert_eq!([moved, thrown].map(|entity| has_collider(&app, entity)), [true; 2]);
    assert!(is_ready(&app, thrown) && !is_ready(&app, moved));
    assert_eq!(met(&mut app, 0.5, 0.5), None);
    assert_eq!(met(&mut app, 2.5, 0.5), None);
    assert_eq!(met(&mut app, 2.5, 5.5), Some(moved));
    assert_eq!(met(&mut app, 6.5, 0.5), Some(stays));
    // It goes on moving by itself, without a new cell for each step.
    let made = counters(&app).level_cells;
    app.change::<Transform>(moved).translation.z = 7.0;
    update_times(&mut app, 5);
    assert_eq!(met(&mut app, 2.5, 7.5), Some(moved));
    assert_eq!(counters(&app).level_cells, made);
}

#[test]
fn an_empty_cell_goes_and_so_do_those_of_a_scene_that_goes() {
    let mut app = app();
    let (root, cubes) = scene(&mut app, &[[0.0; 3], [20.0, 0.0, 0.0]]);
    settle(&mut app, &cubes);
    assert_eq!((cells(&mut app).len(), colliders(&mut app)), (2, 2));
    app.world_mut().despawn(cubes[0]);
    update_times(&mut app, 3);
    assert_eq!((cells(&mut app).len(), colliders(&mut app)), (1, 1));
    // The same place has a cell again.
    let cube = add(&mut app, unit_cube());
    let again = put(&mut app, root, &cube, [0.0; 3]);
    settle(&mut app, &[again]);
    assert_eq!(met(&mut app, 0.5, 0.5), Some(again));
    app.world_mut().despawn(root);
    update_times(&mut app, 3);
    assert_eq!((cells(&mut app).len(), colliders(&mut app)), (0, 0));
}

#[test]
fn what_comes_later_comes_to_its_cell_and_what_changes_its_mesh_stays_there() {
    let mut app = app();
    let (root, mut cubes) = scene(&mut app, &[[0.0; 3]]);
    settle(&mut app, &cubes);
    let flat = add(&mut app, cuboid([0.0; 3], [1.0, 0.5, 1.0]));
    cubes.push(put(&mut app, root, &flat, [3.0, 0.0, 0.0]));
    settle(&mut app, &cubes);
    assert_eq!(cell_of(&app, cubes[0]), cell_of(&app, cubes[1]));
    app.edit(cubes[0]).insert(Mesh3d(flat));
    settle(&mut app, &cubes);
    let cell = cell_of(&app, cubes[0]).unwrap();
    let (low, high) = bounds(&app, cell);
    assert_near(high - low, [4.0, 0.5, 1.0], 1e-3);
    assert_eq!((cells(&mut app).len(), counters(&app).level_cells), (1, 3));
}

#[test]
fn a_scene_that_moves_takes_its_cells_along_and_one_that_grows_has_them_anew() {
    let mut app = app();
    let (root, cubes) = scene(&mut app, &[[0.0; 3], [2.0, 0.0, 0.0]]);
    // Rapier puts a fixed body back.
    app.edit(root).remove::<RigidBody>();
    settle(&mut app, &cubes);
    let cell = cell_of(&app, cubes[1]).unwrap();
    app.change::<Transform>(root).translation = Vec3::new(100.0, 0.0, 0.0);
    update_times(&mut app, 5);
    assert_eq!(cell_of(&app, cubes[1]), Some(cell));
    assert_near(app.get::<GlobalTransform>(cell).unwrap().translation(), [105.0, 5.0, 5.0], 1e-3);
    assert_eq!(counters(&app).level_cells, 1);
    set_scale(&mut app, root, Vec3::splat(2.0));
    update_until(&mut app, |app| counters(app).level_cells == 2);
    update_times(&mut app, 3);
    let (low, high) = bounds(&app, cell);
    assert_near(high - low, [6.0, 2.0, 2.0], 1e-3);
}

#[test]
fn what_has_a_surface_of_its_own_has_a_collider_of_its_own() {
    let mut app = app();
    let (root, cubes) = scene(&mut app, &[[0.0; 3], [2.0, 0.0, 0.0]]);
    app.edit(cubes[0]).insert(friction(0.1));
    app.edit(root).insert(friction(0.7));
    settle(&mut app, &cubes);
    assert!(has_collider(&app, cubes[0]));
    // The cell has that of the scene.
    let cell = cell_of(&app, cubes[1]).unwrap();
    assert_eq!(app.get::<Friction>(cell), app.get::<Friction>(root));
}

#[test]
fn what_can_not_be_made_costs_no_other_its_collider() {
    let mut app = app();
    let (root, mut cubes) = scene(&mut app, &[[0.0; 3], [2.0, 0.0, 0.0]]);
    let wrong = add(&mut app, mesh(vec![[0.0; 3]; 3], vec![0, 1, 7]));
    cubes.push(put(&mut app, root, &wrong, [4.0, 0.0, 0.0]));
    settle(&mut app, &cubes);
    assert_eq!(met(&mut app, 0.5, 0.5), Some(cubes[0]));
    assert_eq!(met(&mut app, 2.5, 0.5), Some(cubes[1]));
    assert_eq!(failed(&app).len(), 1);
    assert_eq!(failed(&app)[0].0, cubes[2]);
}

#[test]
fn cells_come_and_go_with_the_setting_and_a_clone_has_its_own() {
    let mut app = app();
    let (root, cubes) = scene(&mut app, &[[0.0; 3], [2.0, 0.0, 0.0]]);
    settle(&mut app, &cubes);
    app.change::<ConvexDecompositionHierarchy>(root).cell_size = None;
    settle(&mut app, &cubes);
    assert_eq!((cells(&mut app).len(), colliders(&mut app)), (0, 2));
    app.change::<ConvexDecompositionHierarchy>(root).cell_size = Some(SIZE);
    settle(&mut app, &cubes);
    assert_eq!((cells(&mut app).len(), colliders(&mut app)), (1, 1));
    let clone = app.edit(root).clone_and_spawn_with_opt_out(|builder| {
        builder.linked_cloning(true);
    });
    app.change::<Transform>(clone).translation.x = 50.0;
    settle(&mut app, &[]);
    assert_eq!((cells(&mut app).len(), colliders(&mut app)), (2, 2));
    let of_clone = met(&mut app, 52.5, 0.5).unwrap();
    assert_eq!(app.get::<ChildOf>(of_clone).map(ChildOf::parent), Some(clone));
    assert_eq!(met(&mut app, 2.5, 0.5), Some(cubes[1]));
}

#[test]
fn a_tag_that_is_not_the_scenes_keeps_its_collider() {
    let mut app = app();
    let (root, cubes) = scene(&mut app, &[[0.0; 3]]);
    let cube = add(&mut app, unit_cube());
    let own = put(&mut app, root, &cube, [2.0, 0.0, 0.0]);
    app.edit(own).insert(automatic());
    let sensor = put(&mut app, root, &cube, [4.0, 0.0, 0.0]);
    app.edit(sensor).insert(Sensor);
    settle(&mut app, &[cubes[0], own, sensor]);
    assert!(has_collider(&app, own) && has_collider(&app, sensor));
    assert_eq!(met(&mut app, 0.5, 0.5), Some(cubes[0]));
}

fn triangles(app: &App, entity: Entity) -> usize {
    shape(collider(app, entity)).as_trimesh().unwrap().indices().len()
}

#[test]
fn triangles_are_few_within_a_bound_of_the_world_by_settings_or_tag() {
    let mut app = app_with(HullwrightSettings { level_bound: Some(0.01), ..default() });
    let mut hills = floor(false);
    let heights = |[x, _, z]: [f32; 3]| [x, 0.05 * (3.0 * x).sin(), z];
    let points = hills.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
    let points: Vec<[f32; 3]> = points.iter().copied().map(heights).collect();
    hills.insert_attribute(Mesh::ATTRIBUTE_POSITION, points);
    let hills = add(&mut app, hills);
    let by = |tag: ConvexDecomposition, scale: f32| {
        (tag, FIXED, Transform::from_scale(Vec3::splat(scale)))
    };
    let exact = finish(&mut app, &hills, by(automatic().with_level_bound(0.0), 1.0));
    let by_settings = finish(&mut app, &hills, by(automatic(), 1.0));
    let coarse = finish(&mut app, &hills, by(automatic().with_level_bound(0.2), 1.0));
    let large = finish(&mut app, &hills, by(automatic().with_level_bound(0.2), 100.0));
    assert_eq!(triangles(&app, exact), 722);
    assert!(triangles(&app, by_settings) < 300);
    assert!(triangles(&app, coarse) < 40);
    assert!(triangles(&app, large) > triangles(&app, coarse));
    assert_eq!(status(&app, coarse), DecompositionStatus::Skipped(SkipReason::FixedBody));
    // What moves is decomposed as ever.
    let body = finish(&mut app, &hills, (automatic(), RigidBody::Dynamic));
    assert!(is_ready(&app, body));
    // A bound that is none is an error.
    let wrong = finish(&mut app, &hills, by(automatic().with_level_bound(-1.0), 1.0));
    assert!(
        failed(&app).iter().any(|(entity, text)| *entity == wrong && text.contains("level_bound"))
    );
}

#[test]
fn a_cell_has_few_triangles_of_which_each_leads_to_its_mesh() {
    let settings = HullwrightSettings { level_bound: Some(0.01), ..default() };
    let mut app = app_with(settings);
    let (root, mut all) = scene(&mut app, &[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    // It stands in the second cube, where nothing touches it.
    let hidden = add(&mut app, cuboid([0.3; 3], [0.6; 3]));
    all.push(put(&mut app, root, &hidden, [2.0, 0.0, 0.0]));
    let tiles = add(&mut app, floor(false));
    all.push(put(&mut app, root, &tiles, [2.2, 0.0, 5.1]));
    settle(&mut app, &all);
    let cell = cell_of(&app, all[0]).unwrap();
    assert!(all.iter().all(|entity| cell_of(&app, *entity) == Some(cell)));
    assert_eq!(triangles(&app, cell), 12 + 12 + 2);
    assert_eq!(met(&mut app, 0.5, 0.5), Some(all[0]));
    assert_eq!(met(&mut app, 2.5, 0.5), Some(all[1]));
    assert_eq!(met(&mut app, 3.5, 6.0), Some(all[3]));
}

#[test]
fn a_body_slides_over_the_seams_of_cells_and_of_simplified_triangles() {
    for bound in [None, Some(0.01)] {
        let mut app = app_with(HullwrightSettings { level_bound: bound, ..default() });
        let (root, _) = scene(&mut app, &[]);
        app.edit(root).insert(friction(0.0));
        // Tiles of nine and a half metres, of 722 triangles each, edge to edge.
        let tile = add(&mut app, floor(false));
        let tiles: Vec<Entity> =
            (0..3).map(|i| put(&mut app, root, &tile, [2.0 + 9.5 * i as f32, 0.0, 0.0])).collect();
        settle(&mut app, &tiles);
        assert_eq!(cells(&mut app).len(), 3);
        let half = 0.2;
        let body = app.put((
            RigidBody::Dynamic,
            cuboid_collider(half, half, half),
            friction(0.0),
            velocity(Vec3::X * 6.0, Vec3::ZERO),
            Transform::from_xyz(1.0, half, 0.0),
        ));
        let mut most = 0.0_f32;
        for _ in 0..240 {
            app.update();
            let at = translation(&app, body);
            most = most.max((at.y - half).abs());
        }
        // Rapier holds it for a frame at most of the edges, those of cells or not.
        let least = if bound.is_some() { 24.5 } else { 22.5 };
        assert!(translation(&app, body).x > least, "{bound:?}: {}", translation(&app, body));
        assert!(most < 0.02, "{bound:?}: {most}");
    }
}
