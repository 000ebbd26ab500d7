//! Whole scenes: a default, names, exclusions, suffixes and extras; how far they are, and the one
//! event at their end.

use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

/// A node as Bevy's glTF loader spawns it: named, with its primitives as children.
fn node(app: &mut App, parent: Entity, name: &str, meshes: &[&Handle<Mesh>]) -> Entity {
    let node = app.put((Name::new(name.to_owned()), Transform::default(), ChildOf(parent)));
    for mesh in meshes {
        app.world_mut().spawn((Mesh3d((*mesh).clone()), ChildOf(node)));
    }
    node
}

fn root(app: &mut App, hierarchy: ConvexDecompositionHierarchy) -> Entity {
    app.put((Transform::default(), hierarchy))
}

fn is_tagged(app: &App, entity: Entity) -> bool {
    app.get::<ConvexDecomposition>(entity).is_some()
}

fn cube(app: &mut App) -> Handle<Mesh> {
    add(app, unit_cube())
}

fn tag_and_finish(app: &mut App, nodes: &[Entity]) {
    update_times(app, 2);
    update_until_finished(app, nodes);
}

#[test]
fn every_mesh_of_a_scene_gets_a_collider_of_its_own() {
    let mut app = app();
    let (cube, other) = (cube(&mut app), add(&mut app, cuboid([2.0; 3], [3.0; 3])));
    let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    let chair = node(&mut app, root, "chair", &[&cube, &other]);
    let table = node(&mut app, chair, "table", &[&cube]);
    tag_and_finish(&mut app, &[chair, table]);
    // Both primitives of the chair, without the table below it.
    assert_eq!(shape(collider(&app, chair)).as_compound().unwrap().shapes().len(), 2);
    assert!(shape(collider(&app, table)).as_convex_polyhedron().is_some());
    assert_eq!(ready(&app).len(), 2);
}

#[test]
fn names_override_and_exclude() {
    let mut app = app();
    let cube = cube(&mut app);
    let other = tag().with_density(3.0);
    let hierarchy =
        ConvexDecompositionHierarchy::new(tag()).with("table", other.clone()).without("lamp");
    let root = root(&mut app, hierarchy);
    let [chair, table, lamp] =
        ["chair", "table", "lamp"].map(|name| node(&mut app, root, name, &[&cube]));
    update_times(&mut app, 2);
    assert_eq!(app.get::<ConvexDecomposition>(chair), Some(&tag()));
    assert_eq!(app.get::<ConvexDecomposition>(table), Some(&other));
    assert!(!is_tagged(&app, lamp));
}

#[test]
fn an_excluded_mesh_is_no_part_of_the_mesh_above_it() {
    let mut app = app();
    let cube = cube(&mut app);
    let aside = add(&mut app, cuboid([5.0; 3], [6.0; 3]));
    let hierarchy = ConvexDecompositionHierarchy::default().without("lamp");
    let root = root(&mut app, hierarchy);
    let table = node(&mut app, root, "table", &[&cube]);
    node(&mut app, table, "lamp", &[&aside]);
    tag_and_finish(&mut app, &[table]);
    assert_near(bounds(&app, table).1, [1.0; 3], 1e-3);
}

#[test]
fn only_what_is_tagged_by_name_or_artist_if_there_is_no_default() {
    let mut app = app();
    let cube = cube(&mut app);
    let hierarchy = ConvexDecompositionHierarchy::tagged_only().with("table", tag());
    let root = root(&mut app, hierarchy);
    let [chair, table, lamp, copy] = ["chair", "table", "lamp-convdecomp", "lamp-convdecomp.001"]
        .map(|name| node(&mut app, root, name, &[&cube]));
    update_times(&mut app, 2);
    let tagged = [chair, table, lamp, copy].map(|entity| is_tagged(&app, entity));
    assert_eq!(tagged, [false, true, true, true]);
}

#[test]
fn pieces_made_by_the_artist_stand_for_the_mesh_that_they_name() {
    let (mut app, mesh) = with_mesh(app(), model("u_prism"));
    let root = root(&mut app, ConvexDecompositionHierarchy::default());
    let whole = node(&mut app, root, "chair", &[&mesh]);
    let piece = node(&mut app, root, "UCX_chair_01", &[&mesh]);
    update_times(&mut app, 2);
    assert!(!is_tagged(&app, whole));
    update_until_finished(&mut app, &[piece]);
    assert!(shape(collider(&app, piece)).as_convex_polyhedron().is_some());
}

#[test]
fn what_comes_later_is_tagged_too_and_own_tags_stay() {
    let mut app = app();
    let cube = cube(&mut app);
    let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    update_times(&mut app, 3);
    let late = node(&mut app, root, "late", &[&cube]);
    let own = node(&mut app, root, "own", &[&cube]);
    let own_tag = tag().with_density(5.0);
    app.edit(own).insert(own_tag.clone());
    update_times(&mut app, 2);
    assert!(is_tagged(&app, late));
    assert_eq!(app.get::<ConvexDecomposition>(own), Some(&own_tag));
}

#[test]
fn colliders_below_a_body_move_with_it_and_feel_like_it() {
    let mut app = app();
    let cube = cube(&mut app);
    let groups = layers();
    let body = app.put((
        Transform::from_xyz(0.0, 5.0, 0.0),
        RigidBody::Dynamic,
        friction(0.9),
        groups,
        Sensor,
        surface(),
        ConvexDecompositionHierarchy::new(tag()),
    ));
    let left = node(&mut app, body, "left", &[&cube]);
    let right = node(&mut app, body, "right", &[&cube]);
    let own = friction(0.1);
    app.edit(right).insert((Transform::from_xyz(3.0, 0.0, 0.0), own));
    tag_and_finish(&mut app, &[left, right]);
    app.update();
    for (entity, friction) in [(left, friction(0.9)), (right, own)] {
        assert_eq!(app.get::<Friction>(entity), Some(&friction));
        assert_eq!(app.get::<Layers>(entity), Some(&groups));
        assert!(app.get::<Sensor>(entity).is_some());
        assert!(has_surface(&app, entity));
    }
    for collider in [left, right] {
        assert_eq!(body_in_engine(&mut app, collider), Some(body));
    }
    let (mass, centre) = mass_of_whole(&mut app, body);
    assert!((mass / (2.0 * DENSITY) - 1.0).abs() < 1e-2);
    assert_near(centre, [2.0, 0.5, 0.5], 1e-2);
    let before = translation(&app, body).y;
    update_times(&mut app, 30);
    assert!(app.get::<Transform>(body).unwrap().translation.y < before - 0.5);
    assert_near(app.get::<Transform>(right).unwrap().translation, [3.0, 0.0, 0.0], 1e-5);
}

#[cfg(feature = "bevy_gltf")]
#[test]
fn extras_tag_nodes_and_meshes() {
    use bevy::gltf::{GltfExtras, GltfMeshExtras};
    let mut app = app();
    let cube = cube(&mut app);
    let root = root(&mut app, ConvexDecompositionHierarchy::tagged_only());
    let yes = || r#"{"collider": "convex_decomposition"}"#.to_owned();
    let [by_node, by_mesh, neither] =
        ["a", "b", "c"].map(|name| node(&mut app, root, name, &[&cube]));
    app.edit(by_node).insert(GltfExtras { value: yes() });
    let primitive = app.get::<Children>(by_mesh).unwrap()[0];
    app.edit(primitive).insert(GltfMeshExtras { value: yes() });
    app.edit(neither).insert(GltfExtras { value: "{".into() });
    update_times(&mut app, 2);
    let tagged = [by_node, by_mesh, neither].map(|entity| is_tagged(&app, entity));
    assert_eq!(tagged, [true, true, false]);
}

#[cfg(feature = "bevy_gltf")]
#[test]
fn a_hierarchy_on_the_node_itself_takes_its_primitives_as_one_input() {
    use bevy::gltf::GltfMeshName;
    let mut app = app();
    let (cube, other) = (cube(&mut app), add(&mut app, cuboid([2.0; 3], [3.0; 3])));
    let gltf_node = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    for mesh in [&cube, &other] {
        let name = GltfMeshName("chair".into());
        app.world_mut().spawn((Mesh3d(mesh.clone()), name, ChildOf(gltf_node)));
    }
    update_times(&mut app, 2);
    assert!(is_tagged(&app, gltf_node));
    update_until_finished(&mut app, &[gltf_node]);
    assert_eq!(shape(collider(&app, gltf_node)).as_compound().unwrap().shapes().len(), 2);
    assert_eq!(ready(&app).len(), 1);
}

#[test]
fn meshes_right_below_the_root_that_are_no_primitives_are_inputs_of_their_own() {
    let mut app = app();
    let (cube, other) = (cube(&mut app), add(&mut app, cuboid([2.0; 3], [3.0; 3])));
    let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    let children = [&cube, &other].map(|mesh| app.put((Mesh3d(mesh.clone()), ChildOf(root))));
    update_times(&mut app, 2);
    assert!(!is_tagged(&app, root));
    update_until_finished(&mut app, &children);
    assert_eq!(ready(&app).len(), 2);
}

#[test]
fn a_mesh_that_comes_later_starts_none_of_the_others_anew() {
    let mut app = app();
    let cube = cube(&mut app);
    let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()).without("lamp"));
    let first = node(&mut app, root, "first", &[&cube]);
    node(&mut app, root, "lamp", &[&cube]);
    tag_and_finish(&mut app, &[first]);
    let late = node(&mut app, root, "late", &[&cube]);
    tag_and_finish(&mut app, &[late]);
    update_times(&mut app, 3);
    assert_eq!(ready(&app), [(first, 1), (late, 1)]);
}

#[test]
fn what_an_observer_of_the_tag_makes_a_body_is_hulls_at_once() {
    let mut app = app();
    app.add_observer(|tagged: On<Add<ConvexDecomposition>>, mut commands: Commands| {
        commands.entity(tagged.entity).insert(RigidBody::Dynamic);
    });
    let mesh = add(&mut app, model("l_prism"));
    let root = root(&mut app, ConvexDecompositionHierarchy::new(automatic()).without("floor"));
    let [chair, table] = ["chair", "table"].map(|name| node(&mut app, root, name, &[&mesh]));
    tag_and_finish(&mut app, &[chair, table]);
    // No triangles came before the body did.
    assert_eq!((ready(&app).len(), seen(&app).all(), counters(&app).triangle_meshes), (2, 2, 0));
    update_times(&mut app, 30);
    assert!(translation(&app, chair).y < -0.1 && translation(&app, table).y < -0.1);
}

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
    let root = root(app, ConvexDecompositionHierarchy::new(tag()).without("lamp"));
    for (name, mesh) in meshes {
        node(app, root, name, &[*mesh]);
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
    let (mut app, mesh) = with_mesh(app_with(sliced()), model("dog"));
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
    assert_eq!(app.get::<HierarchyStatus>(root), Some(&HierarchyStatus::Finished(report)));
}

#[test]
fn a_scene_ends_again_only_when_something_is_added() {
    let mut app = app();
    observed(&mut app);
    let mesh = add(&mut app, model("u_prism"));
    let root = scene(&mut app, &[("chair", &mesh)]);
    update_until(&mut app, |app| finished(app).len() == 1);
    node(&mut app, root, "late", &[&mesh]);
    update_until(&mut app, |app| finished(app).len() == 2);
    assert_eq!(finished(&app)[1].1.ready, 2);
}

#[test]
fn a_scene_without_meshes_yet_is_waited_for() {
    let mut app = app();
    observed(&mut app);
    let root = scene(&mut app, &[]);
    update_times(&mut app, 5);
    assert_eq!(app.get::<HierarchyStatus>(root), Some(&HierarchyStatus::Waiting));
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
    let dog = app.get::<Children>(root).unwrap()[0];
    app.world_mut().despawn(dog);
    update_until(&mut app, |app| finished(app).len() == 1);
    let report = finished(&app)[0].1;
    assert_eq!((report.ready, report.cancelled), (1, 1));
}

#[test]
fn a_scene_within_a_scene_ends_and_the_outer_one_after_it_with_all_counts() {
    let mut app = app();
    observed(&mut app);
    let mesh = add(&mut app, model("u_prism"));
    // A level that holds nothing but props, and one that has a mesh of its own, each prop with
    // another tag.
    for own in [0, 1] {
        let level = root(&mut app, ConvexDecompositionHierarchy::new(tag().with_density(2.0)));
        for number in 0..own {
            node(&mut app, level, &format!("wall {number}"), &[&mesh]);
        }
        let prop = root(&mut app, ConvexDecompositionHierarchy::new(tag().with_density(7.0)));
        app.edit(prop).insert(ChildOf(level));
        let mug = node(&mut app, prop, "mug", &[&mesh]);
        update_until(&mut app, |app| app.get::<HierarchyStatus>(level).unwrap().is_finished());
        assert_eq!(app.get::<ConvexDecomposition>(mug).unwrap().density, 7.0);
        let ends = finished(&app);
        let [inner, outer] = [prop, level].map(|of| {
            let mut ends = ends.iter().enumerate().filter(|(_, (entity, _))| *entity == of);
            let (at, (_, report)) = ends.next().expect("an end");
            assert!(ends.next().is_none());
            (at, report.ready)
        });
        assert!(inner.0 < outer.0);
        assert_eq!((inner.1, outer.1), (1, 1 + own));
        assert!(progress(&app).is_done() && all_done(&mut app));
        // What comes below the inner one is news of both.
        node(&mut app, prop, "late", &[&mesh]);
        update_until(&mut app, |app| finished(app).len() == ends.len() + 2);
        assert_eq!(finished(&app).last().unwrap().1.ready, 2 + own);
    }
}

#[test]
fn a_scene_whose_hierarchy_is_removed_holds_nothing_back() {
    let mut app = app_with(sliced());
    let mesh = add(&mut app, model("dog"));
    let outer = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    let inner = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    app.edit(inner).insert(ChildOf(outer));
    let dog = node(&mut app, inner, "dog", &[&mesh]);
    let waits = scene(&mut app, &[]);
    update_times(&mut app, 3);
    for scene in [inner, waits] {
        app.edit(scene).remove::<ConvexDecompositionHierarchy>();
        assert!(app.get::<HierarchyStatus>(scene).is_none());
    }
    // What was tagged goes on, and belongs to the scene above.
    update_until_finished(&mut app, &[dog]);
    update_until(&mut app, |app| app.get::<HierarchyStatus>(outer).unwrap().is_finished());
    let Some(HierarchyStatus::Finished(report)) = app.get(outer) else { panic!() };
    assert_eq!(report.ready, 1);
    assert!(all_done(&mut app) && progress(&app).is_done());
}

#[test]
fn what_stands_beside_a_scene_is_inherited_also_without_a_body() {
    let mut app = app();
    let cube = cube(&mut app);
    let groups = layers();
    let rough = friction(0.9);
    let root = root(&mut app, ConvexDecompositionHierarchy::new(automatic()));
    app.edit(root).insert((rough, groups, Sensor));
    let [plain, own] = ["plain", "own"].map(|name| node(&mut app, root, name, &[&cube]));
    let slippery = friction(0.1);
    app.edit(own).insert(slippery);
    tag_and_finish(&mut app, &[plain, own]);
    update_times(&mut app, 2);
    assert_eq!(app.get::<Friction>(plain), Some(&rough));
    assert_eq!(app.get::<Friction>(own), Some(&slippery));
    assert_eq!(app.get::<Layers>(plain), Some(&groups));
    assert!(app.get::<Sensor>(plain).is_some());
    // A sensor's triangles would notice nothing inside.
    assert!(shape(collider(&app, plain)).as_convex_polyhedron().is_some());
}

#[test]
fn a_node_that_loses_its_mesh_is_tagged_no_longer_and_one_that_moves_by_its_parent_is() {
    let mut app = app();
    observed(&mut app);
    let cube = cube(&mut app);
    let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    let elsewhere = app.put(Transform::default());
    let chair = node(&mut app, root, "chair", &[&cube]);
    let late = node(&mut app, elsewhere, "late", &[&cube]);
    tag_and_finish(&mut app, &[chair]);
    app.edit(elsewhere).insert(ChildOf(root));
    update_until(&mut app, |app| is_tagged(app, late));
    update_until(&mut app, |app| finished(app).len() == 2);
    let primitive = app.get::<Children>(chair).unwrap()[0];
    app.world_mut().despawn(primitive);
    update_times(&mut app, 3);
    assert!(!is_tagged(&app, chair) && !has_collider(&app, chair));
    assert!(all_done(&mut app) && progress(&app).is_done());
    // What is put elsewhere keeps what it has.
    app.edit(late).remove::<ChildOf>();
    update_times(&mut app, 3);
    assert!(is_tagged(&app, late) && has_collider(&app, late));
}

#[test]
fn a_node_that_has_lost_its_mesh_elsewhere_is_untagged_when_it_comes_back() {
    let mut app = app();
    let cube = cube(&mut app);
    let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    let place = Transform::from_xyz(1.0, 0.0, 0.0);
    let chair = app.put((Mesh3d(cube.clone()), place, ChildOf(root)));
    tag_and_finish(&mut app, &[chair]);
    app.edit(chair).remove::<ChildOf>();
    update_times(&mut app, 2);
    app.edit(chair).remove::<Mesh3d>();
    update_times(&mut app, 2);
    app.edit(chair).insert(ChildOf(root));
    update_times(&mut app, 2);
    assert!(!is_tagged(&app, chair));
    assert!(all_done(&mut app));
}

#[test]
fn a_root_that_loses_its_own_mesh_leaves_its_children_to_themselves() {
    let mut app = app();
    let cube = cube(&mut app);
    let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    let place = Transform::from_xyz(1.0, 0.0, 0.0);
    let chair = app.put((Mesh3d(cube.clone()), place, ChildOf(root)));
    app.edit(root).insert(Mesh3d(cube));
    tag_and_finish(&mut app, &[root, chair]);
    app.edit(root).remove::<Mesh3d>();
    update_times(&mut app, 3);
    assert!(!is_tagged(&app, root) && !has_collider(&app, root));
    assert!(is_ready(&app, chair));
}

#[test]
fn a_scene_whose_meshes_were_there_before_it_takes_back_what_it_tagged() {
    let mut app = app();
    let cube = cube(&mut app);
    let root = app.put(Transform::default());
    let chair = node(&mut app, root, "chair", &[&cube]);
    update_times(&mut app, 3);
    app.edit(root).insert(ConvexDecompositionHierarchy::new(tag()));
    tag_and_finish(&mut app, &[chair]);
    let primitive = app.get::<Children>(chair).unwrap()[0];
    app.edit(primitive).remove::<Mesh3d>();
    update_times(&mut app, 3);
    assert!(!is_tagged(&app, chair) && all_done(&mut app));
}

#[test]
fn a_scene_that_is_loaded_from_a_save_counts_its_meshes_again() {
    let mut app = app();
    observed(&mut app);
    let mesh = add(&mut app, model("u_prism"));
    let root = scene(&mut app, &[]);
    let chair = app.put((Mesh3d(mesh.clone()), Name::new("chair"), ChildOf(root)));
    update_until(&mut app, |app| finished(app).len() == 1);
    let [of_root, of_chair] = [root, chair].map(|entity| saved(&app, entity));
    app.world_mut().despawn(root);
    update_times(&mut app, 3);
    let root = load(&mut app, &of_root);
    app.edit(root).remove::<Children>();
    let chair = load(&mut app, &of_chair);
    app.edit(chair).insert((Mesh3d(mesh), ChildOf(root)));
    update_until(&mut app, |app| finished(app).len() == 2);
    assert_eq!((finished(&app)[1].0, finished(&app)[1].1.ready), (root, 1));
}

#[test]
fn a_node_that_loses_its_own_tag_is_the_scenes() {
    type Change = fn(&mut EntityWorldMut);
    let changes: [(Change, Change); 3] = [
        (
            |node| _ = node.insert(tag().with_density(5.0)),
            |node| _ = node.remove::<ConvexDecomposition>(),
        ),
        (
            |node| _ = node.insert(BakedDecomposition::default()),
            |node| _ = node.remove::<BakedDecomposition>(),
        ),
        (
            |node| _ = node.insert(NoConvexDecomposition),
            |node| _ = node.remove::<NoConvexDecomposition>(),
        ),
    ];
    for (give, take) in changes {
        let mut app = app();
        observed(&mut app);
        let cube = cube(&mut app);
        let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
        let [other, own] = ["other", "own"].map(|name| node(&mut app, root, name, &[&cube]));
        give(&mut app.edit(own));
        tag_and_finish(&mut app, &[other]);
        update_times(&mut app, 5);
        assert_eq!(finished(&app).iter().map(|(_, of)| of.ready).collect::<Vec<_>>(), [1]);
        take(&mut app.edit(own));
        update_times(&mut app, 2);
        assert_eq!(app.get::<ConvexDecomposition>(own), Some(&tag()));
        update_until_finished(&mut app, &[own]);
        assert!((mass(&app, own).mass / DENSITY - 1.0).abs() < 1e-3);
        update_times(&mut app, 5);
        assert_eq!(finished(&app).iter().map(|(_, of)| of.ready).collect::<Vec<_>>(), [1, 2]);
    }
}

#[test]
fn a_primitive_that_is_moved_is_a_mesh_of_its_own_until_it_is_back() {
    let mut app = app();
    observed(&mut app);
    let (cube, other) = (cube(&mut app), add(&mut app, cuboid([2.0; 3], [3.0; 3])));
    let root = root(&mut app, ConvexDecompositionHierarchy::new(tag()));
    let chair = node(&mut app, root, "chair", &[&cube, &other]);
    let primitive = app.get::<Children>(chair).unwrap()[1];
    tag_and_finish(&mut app, &[chair]);
    assert_near(bounds(&app, chair).1, [3.0; 3], 1e-3);
    for _ in 0..2 {
        *app.change::<Transform>(primitive) = Transform::from_xyz(1.0, 0.0, 0.0);
        tag_and_finish(&mut app, &[chair]);
        update_until_finished(&mut app, &[primitive, chair]);
        assert_is_unit_cube(&app, chair);
        assert_near(bounds(&app, primitive).1, [3.0; 3], 1e-3);
        *app.change::<Transform>(primitive) = Transform::IDENTITY;
        tag_and_finish(&mut app, &[chair]);
        assert!(!is_tagged(&app, primitive) && !has_collider(&app, primitive));
        assert_near(bounds(&app, chair).1, [3.0; 3], 1e-3);
    }
    assert!(finished(&app).iter().all(|(_, report)| report.cancelled == 0));
}
