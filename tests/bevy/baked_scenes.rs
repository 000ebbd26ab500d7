//! Scenes from baked files: meshes are found by their content, and what is not there is decomposed and told.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use hullwright::bake::{BakeOptions, bake_jobs};
use hullwright::bevy::prelude::*;
use hullwright::hulls_format::HullScene;
use hullwright::io::read_scene;
use hullwright::{Control, Length, Parameters};

use crate::app::*;
use crate::gltf::app_with_scene_in;

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
    let fine = BakeOptions::new(Parameters::default().max_error(Length::share(0.013)));
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
