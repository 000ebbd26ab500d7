//! Bodies that break: nothing is lost, nothing is pushed, and what is drawn stays what it was.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;
use crate::engine::*;

/// No gravity, and nothing that slows a body.
fn weightless() -> impl Bundle {
    (RigidBody::Dynamic, GravityScale(0.0))
}

/// Breaks an entity; the bodies in its place.
fn broken(app: &mut App, entity: Entity, grouping: HullGrouping) -> Vec<Entity> {
    app.world_mut().commands().entity(entity).break_apart(grouping);
    app.world_mut().flush();
    fragments(app)
}

fn fragments(app: &mut App) -> Vec<Entity> {
    let world = app.world_mut();
    world.query_filtered::<Entity, With<Fragment>>().iter(world).collect()
}

/// Meshes of a body and those below it, in its space.
fn drawn(app: &App, body: Entity) -> Vec<(Entity, &Mesh)> {
    let below = app.get::<Children>(body).into_iter().flatten().copied();
    let meshes = app.world().resource::<Assets<Mesh>>();
    let on = |entity| Some((entity, meshes.get(app.get::<Mesh3d>(entity)?)?));
    std::iter::once(body).chain(below).filter_map(on).collect()
}

fn numbers(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Vec<Vec3> {
    match mesh.attribute(attribute) {
        Some(VertexAttributeValues::Float32x3(of)) => of.iter().map(|x| Vec3::from(*x)).collect(),
        Some(VertexAttributeValues::Float32x2(of)) => {
            of.iter().map(|[x, y]| Vec3::new(*x, *y, 0.0)).collect()
        }
        other => panic!("{other:?}"),
    }
}

/// Corners of all triangles.
fn triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let points = numbers(mesh, Mesh::ATTRIBUTE_POSITION);
    let corners: Vec<Vec3> = match mesh.indices() {
        Some(indices) => indices.iter().map(|index| points[index]).collect(),
        None => points,
    };
    corners.as_chunks::<3>().0.to_vec()
}

fn area(mesh: &Mesh) -> f32 {
    triangles(mesh).iter().map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

fn volume(triangles: &[[Vec3; 3]]) -> f32 {
    triangles.iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum()
}

/// The surface without cuts, and the volume, of all that fragments draw.
fn sums(app: &App, fragments: &[Entity]) -> (f32, f32) {
    let (mut outer, mut inside) = (0.0, 0.0);
    for body in fragments {
        let meshes = drawn(app, *body);
        let surfaces = meshes.iter().filter(|(on, _)| app.get::<CutFaces>(*on).is_none());
        outer += surfaces.map(|(_, mesh)| area(mesh)).sum::<f32>();
        inside += volume(&meshes.iter().flat_map(|(_, mesh)| triangles(mesh)).collect::<Vec<_>>());
    }
    (outer, inside)
}

#[test]
fn a_broken_body_leaves_bodies_that_draw_and_weigh_what_it_did() {
    for scale in [Vec3::ONE, Vec3::new(2.0, 0.5, 1.0)] {
        let mut app = app();
        let whole = model("mug");
        let place = Transform::from_xyz(1.0, 2.0, 3.0)
            .with_rotation(Quat::from_rotation_x(0.4))
            .with_scale(scale);
        let mut scaled = whole.clone().scaled_by(scale.abs());
        scaled.duplicate_vertices();
        let expected = (area(&scaled), volume(&triangles(&scaled)));
        let mesh = add(&mut app, whole);
        let mug = finish(&mut app, &mesh, (weightless(), place));
        let mass_before = mass(&app, mug).mass;
        let (low, high) = bounds(&app, mug);
        let fragments = broken(&mut app, mug, HullGrouping::EachHull);
        assert!(app.world().get_entity(mug).is_err());
        assert!(fragments.len() > 10, "{}", fragments.len());
        let found = sums(&app, &fragments);
        assert!((found.0 / expected.0 - 1.0).abs() < 1e-3, "{found:?} of {expected:?}");
        assert!((found.1 / expected.1 - 1.0).abs() < 1e-3, "{found:?} of {expected:?}");
        let masses = fragments.iter().map(|body| some_mass(&app, *body).unwrap());
        let sum: f32 = masses.sum();
        assert!((sum / mass_before - 1.0).abs() < 1e-3, "{sum} of {mass_before}");
        // Where the whole was.
        for body in &fragments {
            let off = place.rotation.inverse() * (translation(&app, *body) - place.translation);
            let is_within = off.cmpge(low - 1e-3).all() && off.cmple(high + 1e-3).all();
            assert!(is_within, "{off} in {low} to {high}");
            assert!(has_collider(&app, *body));
        }
    }
}

/// Half its mass times the square of its speed, of all together, and the largest turn.
fn motion(app: &mut App, bodies: &[Entity]) -> (f32, f32) {
    let of = |body: &Entity| {
        let (linear, angular) = velocities(app, *body);
        (some_mass(app, *body).unwrap() * linear.length_squared() / 2.0, angular.length())
    };
    let all = bodies.iter().map(of);
    all.fold((0.0, 0.0_f32), |(sum, most), (energy, turn)| (sum + energy, most.max(turn)))
}

#[test]
fn what_breaks_is_not_pushed_apart() {
    for name in
        ["bowl", "chair", "dog", "gear", "lamp", "mug", "spring", "table", "teapot", "torus"]
    {
        for (linear, angular) in
            [(Vec3::ZERO, Vec3::ZERO), (Vec3::new(0.3, 0.1, 0.0), Vec3::new(0.5, 1.0, -0.2))]
        {
            let mut app = app();
            let mesh = add(&mut app, model(name));
            let moving = (weightless(), velocity(linear, angular));
            let body = finish(&mut app, &mesh, moving);
            update_times(&mut app, 2);
            let fragments = broken(&mut app, body, HullGrouping::EachHull);
            let places: Vec<Vec3> = fragments.iter().map(|of| translation(&app, *of)).collect();
            let size = places.iter().map(|at| at.distance(places[0])).fold(0.0, f32::max);
            let before = motion(&mut app, &fragments);
            update_times(&mut app, 60);
            let after = motion(&mut app, &fragments);
            // Less than a hundredth of its size in a second counts as rest.
            let still = (0.01 * size).max(PUSHES);
            let whole: f32 = fragments.iter().map(|of| some_mass(&app, *of).unwrap()).sum();
            let rest = whole * still * still / 2.0;
            assert!(
                after.0 <= 1.05 * before.0 + rest,
                "{name}: energy {} to {}",
                before.0,
                after.0
            );
            let speeds: Vec<Vec3> = fragments.iter().map(|of| velocities(&app, *of).0).collect();
            for (first, (at, speed)) in places.iter().zip(&speeds).enumerate() {
                for (other, speed2) in places.iter().zip(&speeds).skip(first + 1) {
                    let parents = angular.cross(*other - *at).length();
                    let apart = (*speed2 - *speed).dot((*other - *at).normalize_or_zero());
                    assert!(apart <= 1.05 * parents + still, "{name}: {apart} for {parents}");
                }
            }
        }
    }
}

#[test]
fn fragments_move_on_as_they_did_in_the_whole() {
    let mut app = app();
    let mesh = add(&mut app, model("chair"));
    let (linear, angular) = (Vec3::new(1.0, 2.0, 0.0), Vec3::new(0.0, 3.0, 0.0));
    let body = finish(&mut app, &mesh, (weightless(), velocity(linear, angular)));
    update_times(&mut app, 5);
    // By now it tumbles.
    let (linear, angular) = velocities(&app, body);
    let (_, centre) = mass_of_whole(&mut app, body);
    let centre = app.get::<Transform>(body).unwrap().transform_point(centre);
    for of in broken(&mut app, body, HullGrouping::EachHull) {
        let expected = linear + angular.cross(translation(&app, of) - centre);
        let (found, turn) = velocities(&app, of);
        assert_near(found, expected, 1e-3);
        assert_near(turn, angular, 1e-3);
        assert_eq!(app.get::<GravityScale>(of), Some(&GravityScale(0.0)));
    }
}

/// Two cubes side by side, each a mesh of its own, one with normals and texture coordinates.
fn two_parts(app: &mut App) -> (Entity, [Entity; 2]) {
    let meshes = [0.0, 1.0].map(|x| {
        let mut cube = cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        cube.duplicate_vertices();
        cube.compute_flat_normals();
        let along = |at: &Vec3| [at.x + at.y, at.z];
        let coordinates: Vec<[f32; 2]> =
            numbers(&cube, Mesh::ATTRIBUTE_POSITION).iter().map(along).collect();
        cube.insert_attribute(Mesh::ATTRIBUTE_UV_0, coordinates);
        add(app, cube)
    });
    let whole = app.put((weightless(), tag(), friction(0.7), Transform::from_xyz(5.0, 0.0, 0.0)));
    let parts = meshes.map(|mesh| app.put((Mesh3d(mesh), Transform::default(), ChildOf(whole))));
    (whole, parts)
}

#[test]
fn values_at_vertices_go_on_over_fragments() {
    let mut app = app();
    let mut slab = model("l_prism");
    slab.duplicate_vertices();
    slab.compute_flat_normals();
    let along = |at: &Vec3| [at.x + at.y, at.z - at.x];
    let of: Vec<[f32; 2]> = numbers(&slab, Mesh::ATTRIBUTE_POSITION).iter().map(along).collect();
    slab.insert_attribute(Mesh::ATTRIBUTE_UV_0, of);
    let mesh = add(&mut app, slab);
    let body = finish(&mut app, &mesh, (weightless(), friction(0.7)));
    let fragments = broken(&mut app, body, HullGrouping::EachHull);
    assert_eq!(fragments.len(), 2);
    let mut cuts = 0;
    for body in fragments {
        assert_eq!(app.get::<Friction>(body), Some(&friction(0.7)));
        let middle = translation(&app, body);
        for (on, mesh) in drawn(&app, body) {
            let normals = numbers(mesh, Mesh::ATTRIBUTE_NORMAL);
            assert!(normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
            for (corners, normal) in
                triangles(mesh).iter().zip(mesh.indices().unwrap().iter().step_by(3))
            {
                let [a, b, c] = corners;
                let face = (b - a).cross(c - a).normalize_or_zero();
                assert!(face.dot(normals[normal]) > 0.999, "{face} and {}", normals[normal]);
            }
            if app.get::<CutFaces>(on).is_some() {
                cuts += 1;
                continue;
            }
            let places = numbers(mesh, Mesh::ATTRIBUTE_POSITION);
            for (at, found) in places.iter().zip(numbers(mesh, Mesh::ATTRIBUTE_UV_0)) {
                let [x, y] = along(&(middle + *at));
                assert_near(found, [x, y, 0.0], 1e-5);
            }
        }
    }
    assert_eq!(cuts, 2);
}

#[test]
fn hulls_of_one_part_stay_together_and_the_game_hears_of_it() {
    let mut app = app();
    #[derive(Resource, Default)]
    struct Heard(Vec<(Entity, usize, bool)>);
    app.init_resource::<Heard>().add_observer(
        |broken: On<BrokenApart>, wholes: Query<&ConvexDecomposition>, mut heard: ResMut<Heard>| {
            let is_there = wholes.contains(broken.entity);
            heard.0.push((broken.entity, broken.fragments.len(), is_there));
        },
    );
    let (whole, parts) = two_parts(&mut app);
    update_until_finished(&mut app, &[whole]);
    let of = broken(&mut app, whole, HullGrouping::EachPart);
    assert!(parts.iter().all(|part| app.world().get_entity(*part).is_err()));
    // Twice is once.
    app.world_mut().commands().entity(whole).break_apart(HullGrouping::EachPart);
    app.world_mut().flush();
    assert_eq!(app.world().resource::<Heard>().0, [(whole, of.len(), true)]);
    let mut hulls: Vec<u32> =
        of.iter().flat_map(|body| app.get::<Fragment>(*body).unwrap().hulls.clone()).collect();
    hulls.sort();
    assert!(!hulls.is_empty() && (0..).zip(&hulls).all(|(index, hull)| index == *hull));
}

#[test]
fn what_has_no_hulls_stays_as_it_is_and_the_log_says_why() {
    Log::install();
    let mut app = app();
    let mesh = add(&mut app, model("l_prism"));
    let still = app.put((Mesh3d(mesh), automatic(), FIXED, Name::new("a wall of triangles")));
    app.world_mut().commands().entity(still).break_apart(HullGrouping::EachHull);
    update_until_finished(&mut app, &[still]);
    assert!(broken(&mut app, still, HullGrouping::EachHull).is_empty());
    assert!(has_collider(&app, still));
    let said = Log::lines_with("can't be broken apart");
    let of_wall = said.iter().filter(|line| line.contains("a wall of triangles"));
    assert_eq!(of_wall.count(), 2, "{said:?}");
}
