//! What the tag's settings do, and how scenes and editors see them.

use bevy::prelude::*;
use bevy::reflect::enums::DynamicEnum;
use bevy::reflect::structs::DynamicStruct;
use bevy::reflect::tuple::DynamicTuple;
use bevy::reflect::{FromReflect, TypePath};
use bevy_hullwright::prelude::*;
use bevy_hullwright::{DecompositionError, HullSceneLoader};
use hullwright::surface::SurfaceParameters;

use crate::app::*;
use crate::engine::*;

/// Hulls of a model by a tag.
fn hulls_by(name: &str, tag: ConvexDecomposition) -> Vec<Vec<Vec3>> {
    let (app, entity) = finished(model(name), tag);
    assert_eq!(status(&app, entity), DecompositionStatus::Ready(HullSource::Decomposed));
    hulls(&app, entity)
}

#[test]
fn a_larger_error_takes_fewer_hulls_and_a_cap_fewer_still() {
    let count = |tag| hulls_by("bowl", tag).len();
    let (fine, coarse) = (count(tag()), count(tag().with_max_error(0.08)));
    assert!(coarse < fine, "{coarse} hulls within 8 %, {fine} within 2 %");
    assert_eq!(count(tag().with_max_hulls(2)), 2);
}

#[test]
fn no_hull_has_more_vertices_than_the_tag_allows() {
    let most = |tag| hulls_by("torus", tag).iter().map(Vec::len).max().unwrap();
    assert!(most(tag()) > 12);
    assert!(most(tag().with_max_vertices(12)) <= 12);
}

/// Not what a search for one hull ends with: that of all points.
#[test]
fn one_hull_on_request_is_that_of_all_points_without_a_decomposition() {
    let (mut app, mesh) = with_mesh(app(), model("l_prism"));
    let shape = tag().with_shape(DecompositionShape::ConvexHull);
    let entity = spawn_with(&mut app, &mesh, shape.clone());
    let capped = add(&mut app, model("torus"));
    let capped = spawn_with(&mut app, &capped, shape.with_max_vertices(12));
    update_until_finished(&mut app, &[entity, capped]);
    let model = model("l_prism");
    let points = model.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
    let points: Vec<[f64; 3]> = points.iter().map(|point| point.map(f64::from)).collect();
    let expected = hullwright::convex_hull(&points).unwrap();
    let found = hulls(&app, entity);
    assert_eq!((found.len(), found[0].len()), (1, expected.points.len()));
    for corner in expected.points_as::<Vec3>() {
        assert!(found[0].iter().any(|point| point.distance(corner) < 1e-6), "{corner}");
    }
    let capped = hulls(&app, capped);
    assert!(capped.len() == 1 && capped[0].len() <= 12, "{}", capped[0].len());
    assert_eq!((counters(&app).convex, counters(&app).decomposed), (2, 0));
    // Mass and centre are those of the mesh all the same.
    let (of_hull, of_mesh) = (expected.volume() as f32, mass(&app, entity).mass / DENSITY);
    assert!(of_mesh < 0.9 * of_hull, "{of_mesh} is not less than {of_hull}");
}

#[test]
fn the_bound_is_the_one_that_the_tag_says() {
    let tag = tag().with_max_error(0.05);
    let (app, _) = finished(model("u_prism"), tag);
    assert_eq!(counters(&app).last_bound, Some(0.05));
    assert!(counters(&app).last_protrusion.unwrap() <= 0.05);
}

#[test]
fn a_tag_by_hand_may_have_the_papers_method_or_hacd() {
    let paper = tag().with_parameters(SurfaceParameters::paper());
    assert!(hulls_by("l_prism", paper).len() > 1);
    // To HACD the prism is convex: the corner's only vertices are on its ends.
    let hacd = tag().with_parameters(SurfaceParameters::hacd());
    assert_eq!(hulls_by("l_prism", hacd).len(), 1);
}

#[test]
fn a_setting_that_means_nothing_is_an_error_that_names_it() {
    let (mut app, mesh) = with_mesh(app(), unit_cube());
    for (tag, name) in [
        (tag().with_max_error(-1.0), "max_error"),
        (tag().with_max_hulls(0), "max_hulls"),
        (tag().with_max_vertices(3), "max_vertices"),
    ] {
        let entity = finish(&mut app, &mesh, tag);
        let DecompositionStatus::Failed(DecompositionError::Mesh(error)) = status(&app, entity)
        else {
            panic!("{name}: {:?}", status(&app, entity));
        };
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn an_editor_that_knows_some_settings_gets_a_whole_tag() {
    let mut some = DynamicStruct::default();
    some.insert("density", 3.0_f32);
    some.insert("max_hulls", Some(4_u32));
    let mut max_error = DynamicTuple::default();
    max_error.insert(0.01_f32);
    some.insert("max_error", DynamicEnum::new("Share", max_error));
    let read = ConvexDecomposition::from_reflect(&some).expect("a tag");
    let expected =
        ConvexDecomposition::default().with_density(3.0).with_max_hulls(4).with_max_error(0.01);
    assert_eq!(read, expected);
}

#[test]
fn saved_scenes_know_types_by_paths_without_modules() {
    let app = app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    for name in [
        "BakedDecomposition",
        "ColliderAbsent",
        "ColliderPieceOf",
        "ColliderPieces",
        "ColliderReady",
        "ConvexDecomposition",
        "ConvexDecompositionHierarchy",
        "DecompositionCounters",
        "DecompositionFocus",
        "DecompositionOpenings",
        "DecompositionPreset",
        "DecompositionCancelled",
        "DecompositionFailed",
        "DecompositionReady",
        "DecompositionShape",
        "DecompositionSkipped",
        "DecompositionStatus",
        "FallbackCollider",
        "HullwrightSettings",
        "MaxError",
        "NoConvexDecomposition",
    ] {
        let path = format!("hullwright::{name}");
        assert!(registry.get_with_type_path(&path).is_some(), "{path} is not registered");
    }
    assert_eq!(BakedScene::type_path(), "hullwright::BakedScene");
    assert_eq!(HullSceneLoader::type_path(), "hullwright::HullSceneLoader");
}

#[test]
fn the_mass_that_a_tag_says_is_that_of_the_world() {
    let scale = Transform::from_scale(Vec3::new(1.0, 2.0, 3.0));
    let (app, entity) = finished(unit_cube(), (tag().with_mass(5.0), scale));
    assert!((mass(&app, entity).mass - 5.0).abs() < 1e-4);
}

#[test]
fn one_hull_or_a_box_ball_or_capsule_on_request() {
    let mut app = app();
    // A box of 1 × 1 × 4, aside.
    let mesh = add(&mut app, cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 4.0]));
    let bowl = add(&mut app, model("bowl"));
    let mut shaped = |mesh, kind| {
        let entity = spawn_with(&mut app, mesh, tag().with_shape(kind).with_mass(2.0));
        update_until_finished(&mut app, &[entity]);
        assert_eq!(ready(&app).last(), Some(&(entity, 1)));
        let shape = shape(collider(&app, entity)).clone();
        shape.as_compound().map_or(shape.clone(), |compound| compound.shapes()[0].1.clone())
    };
    let half = shaped(&mesh, DecompositionShape::Cuboid).as_cuboid().unwrap().half_extents;
    assert_near(half, [0.5, 0.5, 2.0], 1e-5);
    let ball = shaped(&mesh, DecompositionShape::Ball).as_ball().unwrap().radius;
    assert!((ball - 4.5_f32.sqrt()).abs() < 1e-5, "{ball}");
    let capsule = *shaped(&mesh, DecompositionShape::Capsule).as_capsule().unwrap();
    assert!((capsule.radius - 0.5_f32.sqrt()).abs() < 1e-5);
    assert!((capsule.half_height() - (2.0 - capsule.radius)).abs() < 1e-5);
    assert_eq!(capsule.segment.a.truncate(), Vec2::ZERO);
    let hull = shaped(&bowl, DecompositionShape::ConvexHull);
    assert!(hull.as_convex_polyhedron().unwrap().points().len() <= 64);
}

#[test]
fn settings_from_before_the_plugin_stay_unless_it_has_its_own() {
    let slow = || with_jobs(1);
    let max_jobs = |plugin: HullwrightPlugin| {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, bevy::asset::AssetPlugin::default()));
        app.insert_resource(slow()).add_plugins(plugin);
        app.world().resource::<HullwrightSettings>().budget.max_jobs
    };
    assert_eq!(max_jobs(hullwright(default())), 1);
    assert_eq!(max_jobs(hullwright(default()).without_contact_dispatcher()), 1);
    let settings = with_jobs(3);
    assert_eq!(max_jobs(hullwright(settings)), 3);
}

#[test]
fn a_primitive_of_a_larger_mesh_keeps_its_openings() {
    let mut app = app();
    // A box without a lid, which alone would count as the skin of a solid.
    let open = || {
        let mut cube = unit_cube();
        let indices: Vec<u32> = cube.indices().unwrap().iter().map(|i| i as u32).skip(6).collect();
        cube.insert_indices(bevy::mesh::Indices::U32(indices));
        cube
    };
    let (mesh, lid) = (add(&mut app, open()), add(&mut app, cuboid([3.0; 3], [4.0; 3])));
    let alone = app.put(Transform::default());
    let alone = spawn_with(&mut app, &mesh, (Transform::default(), ChildOf(alone)));
    let node = app.put(Transform::default());
    let among = spawn_with(&mut app, &mesh, (Transform::default(), ChildOf(node)));
    app.world_mut().spawn((Mesh3d(lid), Transform::default(), ChildOf(node)));
    // A neighbour with a place of its own is another mesh.
    let aside = app.put(Transform::default());
    let beside = spawn_with(&mut app, &mesh, (Transform::default(), ChildOf(aside)));
    app.world_mut().spawn((Mesh3d(mesh.clone()), Transform::from_xyz(5., 0., 0.), ChildOf(aside)));
    update_until_finished(&mut app, &[alone, among, beside]);
    let count = |entity| hulls(&app, entity).len();
    assert_eq!((count(alone), count(beside)), (1, 1));
    assert!(count(among) > 1, "it is taken for a solid");
}

#[test]
fn the_table_of_settings_names_every_field() {
    use bevy::reflect::Typed;
    let page = include_str!("../../docs/bevy/settings.md");
    for info in [
        ConvexDecomposition::type_info(),
        BakedDecomposition::type_info(),
        ConvexDecompositionHierarchy::type_info(),
        HullwrightSettings::type_info(),
        BudgetSettings::type_info(),
        CacheSettings::type_info(),
        SkipSettings::type_info(),
    ] {
        for field in info.as_struct().unwrap().iter() {
            let row = format!("\n| `{}` |", field.name());
            assert!(page.contains(&row), "{} of {}", field.name(), info.type_path());
        }
    }
}

#[test]
#[expect(clippy::field_reassign_with_default, reason = "the templates have no names")]
fn components_with_handles_are_made_from_asset_paths_as_in_bsn() {
    use bevy::ecs::template::{FromTemplate, SceneEntityReferences, Template, TemplateContext};
    type Of<T> = <T as FromTemplate>::Template;

    let mut app = app();
    let path = || "mug.hullscene".into();
    let mut by_name = Of::<BakedDecomposition>::default();
    by_name.scene = path();
    let mut by_mesh = Of::<FromBakedScene>::default();
    by_mesh.0 = path();
    let mut hierarchy = Of::<ConvexDecompositionHierarchy>::default();
    hierarchy.baked = Some(path()).into();

    let mut entity = app.world_mut().spawn_empty();
    let mut references = SceneEntityReferences::default();
    let mut context = TemplateContext::new(&mut entity, &mut references);
    let handles = [
        by_name.build_template(&mut context).unwrap().scene,
        by_mesh.build_template(&mut context).unwrap().0,
        hierarchy.build_template(&mut context).unwrap().baked.unwrap(),
    ];
    for handle in handles {
        assert_eq!(handle.path().unwrap().to_string(), "mug.hullscene");
    }
}

#[test]
fn what_bsn_says_nothing_of_has_its_default() {
    use bevy::ecs::template::{FromTemplate, SceneEntityReferences, Template, TemplateContext};
    fn made<T: FromTemplate>(app: &mut App) -> T
    where
        T::Template: Default,
    {
        let mut entity = app.world_mut().spawn_empty();
        let mut references = SceneEntityReferences::default();
        let mut context = TemplateContext::new(&mut entity, &mut references);
        T::Template::default().build_template(&mut context).unwrap()
    }
    let mut app = app();
    assert_eq!(made::<ConvexDecomposition>(&mut app), default());
    assert_eq!(made::<ConvexDecompositionHierarchy>(&mut app), default());
    let baked = made::<BakedDecomposition>(&mut app);
    let expected = BakedDecomposition::default();
    assert_eq!((baked.mesh, baked.density, baked.mass), (None, expected.density, expected.mass));
}

#[test]
fn each_tag_brings_a_place_in_the_world() {
    let mut app = app();
    let tagged = [
        app.put(ConvexDecomposition::default()),
        app.put(BakedDecomposition::default()),
        app.put(ConvexDecompositionHierarchy::default()),
    ];
    for entity in tagged {
        assert!(app.get::<Transform>(entity).is_some());
    }
}
