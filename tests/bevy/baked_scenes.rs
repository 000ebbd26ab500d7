//! Scenes from baked files: meshes are found by their content, and what is not there is decomposed
//! and told.

use std::path::{Path, PathBuf};

use bevy::asset::RenderAssetUsages;
use bevy::gltf::{GltfAssetLabel, GltfLoaderSettings};
use bevy::prelude::*;
use bevy_hullwright::BakedSceneSettings;
use bevy_hullwright::prelude::*;
use hullwright::hulls_format::HullScene;
use hullwright::{Control, Length, Parameters};
use hullwright_formats::bake::{BakeOptions, bake_jobs, bake_triangles};
use hullwright_formats::bake_surfaces::surface_jobs;
use hullwright_formats::read_scene;

use crate::app::*;
use crate::engine::*;
use crate::gltf::{app_with_gltf, app_with_scene_in, update_until_ready};

/// What `hullwright bake` writes.
fn bake(scene: &Path, options: &BakeOptions) -> HullScene {
    let jobs = bake_jobs(read_scene(scene).unwrap(), options);
    // Some real files have meshes without any usable triangle.
    let meshes = jobs.iter().filter_map(|job| job.run(&Control::new()).ok()).collect();
    HullScene::new(scene.file_stem().unwrap().to_string_lossy(), meshes)
}

/// A directory with a scene, and beside it what is baked of it.
fn place(scene: &Path, baked: &[u8]) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    std::fs::copy(scene, place.path().join("scene.glb")).unwrap();
    std::fs::write(place.path().join("scene.hullscene"), baked).unwrap();
    place
}

fn bundled(name: &str) -> PathBuf {
    Path::new(&assets()).join(name)
}

/// Loads the scene of a place with its baked hulls, until it is finished.
fn load(
    place: &tempfile::TempDir,
    hierarchy: ConvexDecompositionHierarchy,
) -> (App, HierarchyReport) {
    let directory = place.path().display().to_string();
    let (mut app, root) = app_with_scene_in(directory, "scene.glb", hierarchy);
    let baked = app.load("scene.hullscene");
    app.change::<ConvexDecompositionHierarchy>(root).baked = Some(baked);
    update_until(&mut app, |app| app.get::<HierarchyStatus>(root).unwrap().is_finished());
    match app.get::<HierarchyStatus>(root) {
        Some(HierarchyStatus::Finished(report)) => {
            let report = *report;
            (app, report)
        }
        _ => unreachable!(),
    }
}

fn all_hulls(app: &mut App) -> Vec<(String, Vec<Vec<Vec3>>)> {
    let world = app.world_mut();
    let mut nodes = world.query_filtered::<(Entity, &Name), With<ConvexDecomposition>>();
    let nodes: Vec<(Entity, String)> =
        nodes.iter(world).map(|(entity, name)| (entity, name.to_string())).collect();
    let mut all: Vec<_> =
        nodes.into_iter().map(|(entity, name)| (name, hulls(app, entity))).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

#[test]
fn a_scene_starts_from_its_baked_file_without_a_decomposition_and_with_the_same_hulls() {
    for name in ["lamp.glb", "chair.glb", "props.glb"] {
        let baked = bake(&bundled(name), &BakeOptions::default()).to_bytes().unwrap();
        let hierarchy = ConvexDecompositionHierarchy::default;
        let (mut app, report) = load(&place(&bundled(name), &baked), hierarchy());
        assert_eq!(counters(&app).decomposed, 0, "{name}");
        assert_eq!((report.stale, report.missing, report.failed), (0, 0, 0), "{name}");
        assert!(report.ready > 0 && report.from_baked == report.ready, "{name}: {report:?}");

        let none = HullScene::new("none", Vec::new()).to_bytes().unwrap();
        let (mut decomposed, report) = load(&place(&bundled(name), &none), hierarchy());
        assert_eq!((report.from_baked, report.missing), (0, report.ready), "{name}");
        assert!(counters(&decomposed).decomposed > 0);
        assert_eq!(all_hulls(&mut app), all_hulls(&mut decomposed), "{name}");
    }
}

#[test]
fn what_was_baked_with_other_settings_is_decomposed_and_the_log_says_so() {
    Log::install();
    let fine = BakeOptions::new(Parameters::default().with_max_error(Length::share(0.013)));
    let baked = bake(&bundled("lamp.glb"), &fine).to_bytes().unwrap();
    let place = place(&bundled("lamp.glb"), &baked);
    let (app, report) = load(&place, ConvexDecompositionHierarchy::default());
    assert_eq!((report.ready, report.stale, report.from_baked), (1, 1, 0));
    assert_eq!(counters(&app).decomposed, 1);
    let lines = Log::lines_with("max_error=1.3%");
    assert!(lines.iter().any(|line| line.contains("scene.hullscene") && line.contains("lamp")));

    let tag = ConvexDecomposition::default().with_max_error(0.013);
    let (app, report) = load(&place, ConvexDecompositionHierarchy::new(tag));
    assert_eq!((report.from_baked, counters(&app).decomposed), (1, 0));
}

#[test]
fn a_changed_mesh_an_older_algorithm_and_a_missing_mesh_are_told_apart() {
    Log::install();
    let baked = bake(&bundled("props.glb"), &BakeOptions::default());
    let total = baked.meshes.len();
    let mut scene = baked.clone();
    // The names of the leaf with the content of another mesh, an old mug, and no lamp.
    let has = |name: &'static str| {
        move |mesh: &hullwright::hulls_format::BakedMesh| {
            mesh.names.iter().any(|own| own.contains(name))
        }
    };
    scene.meshes.retain(|mesh| !has("lamp")(mesh));
    let other = scene.meshes.iter().find(|mesh| has("UCX_table")(mesh)).unwrap().hash;
    for mesh in &mut scene.meshes {
        if has("leaf")(mesh) {
            mesh.hash = other;
        } else if has("mug")(mesh) {
            mesh.hulls.algorithm_version -= 1;
        }
    }
    let place = place(&bundled("props.glb"), &scene.to_bytes().unwrap());
    let (app, report) = load(&place, ConvexDecompositionHierarchy::default());
    assert_eq!((report.stale, report.missing), (2, 1), "{report:?} of {total}");
    assert_eq!(counters(&app).decomposed, 3);
    for text in ["the mesh has changed", "another version of Hullwright", "it is not in the file"] {
        assert!(!Log::lines_with(text).is_empty(), "{text}");
    }
}

#[test]
fn a_damaged_or_older_kind_of_file_is_told_and_all_is_decomposed() {
    Log::install();
    let baked = bake(&bundled("lamp.glb"), &BakeOptions::default());
    let single = baked.meshes[0].hulls.to_bytes().unwrap();
    for bytes in [baked.to_bytes().unwrap()[..100].to_vec(), single] {
        let place = place(&bundled("lamp.glb"), &bytes);
        let (app, report) = load(&place, ConvexDecompositionHierarchy::default());
        assert_eq!((report.ready, report.missing, report.from_baked), (1, 1, 0));
        assert_eq!(counters(&app).decomposed, 1);
    }
    assert!(Log::lines_with("could not be loaded").len() >= 2);
}

/// Loads the scene of a place with its baked hulls, all its meshes for the GPU only. It is tagged
/// at once, or when their data is gone.
fn load_for_gpu_only(place: &tempfile::TempDir, body: RigidBody, is_late: bool) -> (App, Entity) {
    let mut app = app_with_gltf(place.path().display().to_string(), |app| {
        app.add_systems(Last, take_gpu_data);
    });
    let server = app.world().resource::<AssetServer>();
    let settings =
        |settings: &mut GltfLoaderSettings| settings.load_meshes = RenderAssetUsages::RENDER_WORLD;
    let scene = GltfAssetLabel::Scene(0).from_asset("scene.glb");
    let scene = server.load_builder().with_settings(settings).load(scene);
    let hierarchy = ConvexDecompositionHierarchy::default().with_baked(app.load("scene.hullscene"));
    let root = app.put((WorldAssetRoot(scene), body));
    let are_gone = |app: &App| {
        let mut meshes = app.world().resource::<Assets<Mesh>>().iter().peekable();
        meshes.peek().is_some()
            && meshes.all(|(_, mesh)| mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).is_err())
    };
    if is_late {
        update_until(&mut app, are_gone);
    }
    app.edit(root).insert(hierarchy);
    update_until_ready(&mut app);
    assert!(are_gone(&app));
    (app, root)
}

/// What Bevy's renderer does after each frame.
fn take_gpu_data(mut events: MessageReader<AssetEvent<Mesh>>, mut meshes: ResMut<Assets<Mesh>>) {
    for event in events.read() {
        if let AssetEvent::Added { id } = event
            && let Some(mesh) = meshes.get_mut_untracked(*id)
            && mesh.asset_usage == RenderAssetUsages::RENDER_WORLD
        {
            mesh.take_gpu_data().unwrap();
        }
    }
}

/// The masses of all bodies and pieces of them, in the order of their names.
fn all_masses(app: &mut App) -> Vec<(String, f32)> {
    let world = app.world_mut();
    let mut nodes = world.query_filtered::<(Entity, &Name), With<ConvexDecomposition>>();
    let nodes: Vec<(Entity, String)> =
        nodes.iter(world).map(|(entity, name)| (entity, name.to_string())).collect();
    let of = |(entity, name)| (name, mass(app, entity).mass);
    let mut all: Vec<_> = nodes.into_iter().map(of).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// A scene with the name of the file in a place.
fn baked_as_scene(name: &str) -> HullScene {
    let mut baked = bake(&bundled(name), &BakeOptions::default());
    baked.name = "scene".into();
    baked
}

#[test]
fn meshes_on_the_gpu_only_have_their_hulls_and_mass_from_the_baked_file() {
    for name in ["lamp.glb", "chair.glb", "props.glb"] {
        let place = place(&bundled(name), &baked_as_scene(name).to_bytes().unwrap());
        for is_late in [false, true] {
            let (mut app, _) = load_for_gpu_only(&place, RigidBody::Dynamic, is_late);
            assert_eq!((counters(&app).decomposed, counters(&app).failed), (0, 0), "{name}");
            assert_eq!(counters(&app).baked, ready(&app).len());
            let (mut by_content, _) = load(&place, ConvexDecompositionHierarchy::default());
            assert_eq!(all_hulls(&mut app), all_hulls(&mut by_content), "{name}");
            assert_eq!(all_masses(&mut app), all_masses(&mut by_content), "{name}");
        }
    }
}

#[test]
fn a_mesh_on_the_gpu_only_that_differs_from_the_baked_one_fails_and_says_in_what() {
    type Change = fn(&mut HullScene);
    let changes: [(Change, &str); 6] = [
        (|scene| scene.meshes[0].hulls.source_triangles += 1, "number of triangles"),
        (|scene| scene.meshes[0].bounds.as_mut().unwrap()[1][2] += 1.0, "bounding box"),
        (|scene| scene.meshes[0].bounds = None, "bounding box"),
        (|scene| scene.meshes[0].gltf_meshes = vec![9], "label"),
        (|scene| scene.meshes[0].hulls.algorithm_version -= 1, "another version"),
        (|scene| scene.name = "another".into(), "asset path"),
    ];
    for (change, expected) in changes {
        let mut scene = baked_as_scene("lamp.glb");
        change(&mut scene);
        let place = place(&bundled("lamp.glb"), &scene.to_bytes().unwrap());
        let (app, _) = load_for_gpu_only(&place, RigidBody::Dynamic, true);
        let [(_, why)] = failed(&app) else { panic!("{expected}: {:?}", failed(&app)) };
        assert!(why.contains("GPU only") && why.contains(expected), "{why}");
    }
}

#[test]
fn what_never_moves_and_is_on_the_gpu_only_has_its_triangles_from_the_baked_file() {
    let sizes = |app: &mut App| {
        let mut colliders = app.world_mut().query::<&Collider>();
        let sizes = colliders.iter(app.world()).map(|collider| {
            let mesh = shape(collider).as_trimesh().expect("triangles");
            let bounds = mesh.local_aabb();
            (
                mesh.indices().len(),
                mesh.vertices().len(),
                bounds.mins.to_array(),
                bounds.maxs.to_array(),
            )
        });
        let mut sizes: Vec<_> = sizes.collect();
        sizes.sort_by(|a, b| a.partial_cmp(b).unwrap());
        sizes
    };
    for name in ["lamp.glb", "chair.glb"] {
        let options = BakeOptions::default().with_triangles(true);
        let triangles = bake_triangles(&read_scene(bundled(name)).unwrap(), &options);
        let with = baked_as_scene(name).with_triangles(triangles).to_bytes().unwrap();
        let place = place(&bundled(name), &with);
        let (mut by_content, _) = app_with_scene_in(
            place.path().display().to_string(),
            "scene.glb",
            ConvexDecompositionHierarchy::default(),
        );
        let mut roots = by_content.world_mut().query_filtered::<Entity, With<WorldAssetRoot>>();
        let root = roots.single(by_content.world()).unwrap();
        by_content.edit(root).insert(FIXED);
        update_until_ready(&mut by_content);
        let expected = sizes(&mut by_content);
        assert!(!expected.is_empty());
        for is_late in [false, true] {
            let (mut app, _) = load_for_gpu_only(&place, FIXED, is_late);
            assert_eq!((counters(&app).failed, failed(&app)), (0, &[][..]), "{name}");
            assert_eq!(sizes(&mut app), expected, "{name}");
        }
    }
}

#[test]
fn triangles_that_were_not_baked_fail_and_say_how_to_bake_them() {
    let place = place(&bundled("lamp.glb"), &baked_as_scene("lamp.glb").to_bytes().unwrap());
    let (app, _) = load_for_gpu_only(&place, FIXED, true);
    let [(_, why)] = failed(&app) else { panic!("{:?}", failed(&app)) };
    assert!(why.contains("--triangles"), "{why}");
}

#[test]
fn the_report_of_a_scene_on_the_gpu_only_counts_what_was_baked() {
    let place = place(&bundled("props.glb"), &baked_as_scene("props.glb").to_bytes().unwrap());
    let (mut app, root) = load_for_gpu_only(&place, RigidBody::Dynamic, false);
    update_until(&mut app, |app| app.get::<HierarchyStatus>(root).unwrap().is_finished());
    let Some(HierarchyStatus::Finished(report)) = app.get::<HierarchyStatus>(root) else {
        unreachable!()
    };
    assert!(report.ready > 0 && report.from_baked == report.ready, "{report:?}");
    assert_eq!((report.stale, report.missing, report.failed), (0, 0, 0), "{report:?}");
}

#[test]
fn meshes_are_found_by_label_and_not_hashed_where_the_files_settings_say_so() {
    let mut scene = baked_as_scene("lamp.glb");
    scene.meshes[0].hash = hullwright::hulls_format::MeshHash::from_bytes([0; 32]);
    for (by_label, expected) in [(true, HullSource::Baked), (false, HullSource::Decomposed)] {
        let directory = assets();
        let (mut app, root) =
            app_with_scene_in(directory, "lamp.glb", ConvexDecompositionHierarchy::default());
        scene.name = "lamp".into();
        let settings = BakedSceneSettings { by_label, ..default() };
        let scene = BakedScene::with_settings(scene.clone(), settings);
        let handle = app.world_mut().resource_mut::<Assets<BakedScene>>().add(scene);
        app.change::<ConvexDecompositionHierarchy>(root).baked = Some(handle);
        update_until_ready(&mut app);
        let (lamp, _) = ready(&app)[0];
        assert_eq!(status(&app, lamp), DecompositionStatus::Ready(expected));
    }
}

/// Files that nobody here made: `HULLWRIGHT_SCENES` names a folder of GLB files. With the features
/// `bevy/png,bevy/jpeg` none is refused for its textures.
#[test]
fn meshes_of_real_files_are_found() {
    let Some(folder) = std::env::var_os("HULLWRIGHT_SCENES") else { return };
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|suffix| suffix == "glb"));
    files.sort();
    let (mut ready, mut failed, mut refused) = (0, 0, 0);
    for path in &files {
        let baked = bake(path, &BakeOptions::default()).to_bytes().unwrap();
        let (mut app, report) = load(&place(path, &baked), ConvexDecompositionHierarchy::default());
        let name = path.display();
        if is_refused_by_bevy(&mut app) {
            refused += 1;
            continue;
        }
        assert_eq!((report.stale, report.missing), (0, 0), "{name}: {report:?}");
        assert_eq!((report.from_baked, counters(&app).decomposed), (report.ready, 0), "{name}");
        assert!(report.ready + report.failed > 0, "{name}: {report:?}");
        (ready, failed) = (ready + report.ready, failed + report.failed);
    }
    println!(
        "{} files, {refused} refused by Bevy; {ready} meshes from their baked files, {failed} failed",
        files.len()
    );
    assert!(ready > 0);
}

/// Without its feature `png` Bevy's loader gives up a whole file for one texture within it.
fn is_refused_by_bevy(app: &mut App) -> bool {
    let mut roots = app.world_mut().query::<&WorldAssetRoot>();
    let server = app.world().resource::<AssetServer>();
    let mut states = roots.iter(app.world()).filter_map(|root| server.get_load_state(&root.0));
    states.any(|state| matches!(state, bevy::asset::LoadState::Failed(_)))
}

/// A node with the `L` at a place, turned and scaled.
fn l_node(name: &str, place: [f32; 3], turn: f32, scale: [f32; 3]) -> serde_json::Value {
    let turn = Quat::from_rotation_y(turn).to_array();
    serde_json::json!({
        "name": name, "mesh": 0, "translation": place, "rotation": turn, "scale": scale,
    })
}

#[test]
fn a_level_starts_from_its_baked_file_without_any_work_on_what_never_moves() {
    // Two cells, one thing that is larger, and below a node one that is mirrored.
    let large = l_node("large", [0.0, 0.0, 0.0], 0.3, [30.0, 1.0, 30.0]);
    let mut nodes = vec![large];
    for i in 0..6_u8 {
        let x = 3.0 * f32::from(i);
        let name = format!("{i}");
        nodes.push(l_node(&name, [x, 1.0, 2.0], 0.7 * x, [1.0, 1.5, 0.5 + 0.2 * x / 3.0]));
    }
    let mut parent = l_node("parent", [5.0, 1.0, 6.0], 1.0, [1.0; 3]);
    parent["children"] = serde_json::json!([nodes.len() + 1]);
    nodes.push(parent);
    nodes.push(l_node("below", [0.3, 0.2, 0.1], 2.0, [-1.0, 1.0, 1.0]));
    let roots = (0..nodes.len() - 1).collect();
    let file = crate::artists::file_of(nodes, roots);

    let options = BakeOptions::default().with_surfaces(0.02, Some(10.0));
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("it.gltf");
    std::fs::write(&path, &file).unwrap();
    let meshes = read_scene(&path).unwrap();
    let jobs = surface_jobs(&meshes, &options);
    let surfaces = jobs.iter().map(|job| job.run(&Control::new()).unwrap()).collect();
    let baked = HullScene::new("it", Vec::new()).with_surfaces(surfaces);
    assert_eq!(baked.surfaces.len(), 3);
    std::fs::write(place.path().join("it.hullscene"), baked.to_bytes().unwrap()).unwrap();

    let mut found = Vec::new();
    for is_baked in [true, false] {
        let mut app = app_with_gltf(place.path().display().to_string(), |_| {});
        app.world_mut().resource_mut::<HullwrightSettings>().level_bound = Some(0.02);
        let scene = app.load(GltfAssetLabel::Scene(0).from_asset("it.gltf"));
        let mut hierarchy = ConvexDecompositionHierarchy::default().with_cells(10.0);
        if is_baked {
            hierarchy = hierarchy.with_baked(app.load("it.hullscene"));
        }
        let root = app.put((WorldAssetRoot(scene), FIXED, hierarchy));
        update_until(&mut app, |app| app.get::<HierarchyStatus>(root).unwrap().is_finished());
        update_times(&mut app, 3);
        let counters = counters(&app);
        assert_eq!((counters.simplified, counters.level_cells), (if is_baked { 0 } else { 3 }, 2));
        // Each triangle leads to the node that it is of, whichever way it came.
        let mut hits = Vec::new();
        for i in 0..40_u8 {
            let from = Vec3::new(0.45 * f32::from(i), 9.0, 2.2);
            let hit = below(&mut app, from).and_then(|(collider, subshape)| {
                app.get::<ColliderParts>(collider)?.part(subshape)
            });
            let node = hit.map(|part| app.get::<ChildOf>(part).unwrap().parent());
            hits.push(node.map(|node| app.get::<Name>(node).unwrap().to_string()));
        }
        let world = app.world_mut();
        let mut all = world.query::<&Collider>();
        let all = all.iter(world);
        let mut triangles: Vec<usize> =
            all.map(|collider| shape(collider).as_trimesh().unwrap().indices().len()).collect();
        triangles.sort_unstable();
        found.push((hits, triangles));
    }
    assert_eq!(found[0], found[1]);
    assert!(found[0].0.iter().flatten().count() > 20);
}
