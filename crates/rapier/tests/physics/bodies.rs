//! Shapes, mass properties and colliders made of hulls, and Rapier's bodies made of these.

use std::f64::consts::{PI, TAU};

use hullwright::{MassSource, MeshView, Parameters, TriangleMesh};
use hullwright_formats::read_mesh;
use hullwright_rapier::ColliderError;
use rapier3d::parry::shape::TriMeshFlags;
use rapier3d::prelude::*;

use crate::common::ring;
use crate::world::{DENSITY, Prop, World};

fn assert_close(found: f64, expected: f64, share: f64) {
    assert!((found - expected).abs() < share * expected.abs(), "{found}, not {expected}");
}

#[test]
fn rapier_gets_a_toruss_mass_and_inertia_within_a_hundredth() {
    let (large, small) = (0.5, 0.2);
    let prop = Prop::mesh(ring(large, small, 96, 48));
    assert!(prop.decomposition.hulls.len() > 3);
    let mut world = World::new(1.0);
    let body = world.dynamic_at([0.0; 3], prop.collider());
    world.0.gravity = Vector::ZERO;
    world.0.step();
    let body = world.body(body);

    let mass = DENSITY * TAU * PI * large * small * small;
    let along = mass * (large * large + 0.75 * small * small);
    let across = mass * (large * large / 2.0 + 0.625 * small * small);
    assert_close(f64::from(body.mass()), mass, 0.01);
    assert!(body.center_of_mass().length() < 1e-4);
    let properties = body.mass_properties().local_mprops;
    let mut moments = properties.principal_inertia().to_array().map(f64::from);
    moments.sort_by(f64::total_cmp);
    for (found, expected) in moments.into_iter().zip([across, across, along]) {
        assert_close(found, expected, 0.01);
    }
    // The hulls overlap and stand out: their sum is not the torus.
    let sum: f64 = prop.decomposition.hulls.iter().map(|hull| hull.shape.volume() * DENSITY).sum();
    assert!(sum > 1.02 * mass, "{sum} of {mass}");
}

#[test]
fn a_turned_tensor_reaches_rapier_turned() {
    // An L has no principal axis along its arms.
    let prop = Prop::model("l_prism");
    let properties = prop.mass_properties();
    let converted = hullwright_rapier::mass_properties(&properties, [1.0; 3]).unwrap();
    let tensor = converted.reconstruct_inertia_matrix();
    for (i, row) in properties.inertia.iter().enumerate() {
        for (j, expected) in row.iter().enumerate() {
            let found = f64::from(tensor.col(j)[i]);
            assert!((found - expected).abs() < 1e-4 * properties.inertia[2][2], "{i} {j}");
        }
    }
    // Three half-metre cubes in an L.
    assert_close(f64::from(converted.mass()), DENSITY * 0.375, 1e-4);
}

#[test]
fn every_model_becomes_a_body_at_any_scale() {
    for name in ["mug", "chair", "teapot", "lamp", "dog", "leaf", "gear", "spring"] {
        let prop = Prop::model(name);
        for scale in [[1.0; 3], [0.01; 3], [300.0; 3], [-1.0, 4.0, 0.25], [1.0, 1.0, 0.001]] {
            let collider = prop.scaled_collider(scale).build();
            let shape = collider.shape();
            let parts = shape.as_compound().map_or(1, |compound| compound.shapes().len());
            assert_eq!(parts, prop.decomposition.hulls.len(), "{name}");
            if let Some(compound) = shape.as_compound() {
                for (_, part) in compound.shapes() {
                    assert!(part.as_convex_polyhedron().is_some(), "{name} {scale:?}");
                }
            }
            assert!(collider.mass() > 0.0 && collider.mass().is_finite());
        }
    }
}

#[test]
fn an_open_mesh_has_the_mass_of_its_hulls_union() {
    let leaf = Prop::model("leaf");
    let properties = leaf.mass_properties();
    assert_eq!(properties.source, MassSource::HullUnion);
    let sum: f64 = leaf.decomposition.hulls.iter().map(|hull| hull.shape.volume()).sum();
    assert!(properties.mass > 0.0 && properties.mass < 1.01 * sum * DENSITY);
}

#[test]
fn the_same_collider_in_one_call() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/u_prism.glb");
    let file = read_mesh(path).unwrap();
    let parameters = Parameters::default();
    let collider = hullwright_rapier::collider_from_mesh(&file, DENSITY, &parameters);
    let expected = Prop::model("u_prism").collider().build();
    let found = collider.unwrap().build();
    assert_eq!(found.mass(), expected.mass());
    assert_eq!(found.compute_aabb(), expected.compute_aabb());

    let nothing =
        hullwright_rapier::collider_from_mesh(&TriangleMesh::default(), DENSITY, &parameters);
    assert!(matches!(nothing.err(), Some(ColliderError::Mesh(_))));
}

#[test]
fn several_hulls_are_a_compound_and_one_is_a_polyhedron() {
    let prism = Prop::model("u_prism");
    let hulls = &prism.decomposition.hulls;
    let shape = hullwright_rapier::shape(hulls, [1.0; 3]).unwrap();
    assert_eq!(shape.as_compound().unwrap().shapes().len(), hulls.len());
    let shape = hullwright_rapier::shape(&hulls[..1], [1.0; 3]).unwrap();
    let polyhedron = shape.as_convex_polyhedron().unwrap();
    assert_eq!(polyhedron.points().len(), hulls[0].shape.points.len());
}

#[test]
fn scale_and_mirror_are_in_the_points() {
    let prism = Prop::model("u_prism");
    let hulls = &prism.decomposition.hulls;
    let bounds = |scale| {
        let bounds = hullwright_rapier::shape(hulls, scale).unwrap().compute_local_aabb();
        [bounds.mins, bounds.maxs].map(|corner| corner.to_array())
    };
    let [low, high] = bounds([1.0; 3]);
    let scale = [-2.0, 3.0, 0.5];
    let [scaled_low, scaled_high] = bounds(scale);
    for axis in 0..3 {
        let mut ends = [low[axis], high[axis]].map(|x| x * scale[axis]);
        ends.sort_by(f32::total_cmp);
        for (found, expected) in [scaled_low[axis], scaled_high[axis]].iter().zip(ends) {
            assert!((found - expected).abs() < 1e-4, "{found} is not {expected}");
        }
    }
}

#[test]
fn mass_properties_are_the_meshs_own_and_scale_with_the_volume() {
    let properties = Prop::model("u_prism").mass_properties();
    let own = hullwright_rapier::mass_properties(&properties, [1.0; 3]).unwrap();
    let expected = properties.mass as f32;
    assert!((own.mass() / expected - 1.0).abs() < 1e-5);
    for (found, expected) in own.local_com.to_array().iter().zip(properties.centre) {
        assert!((f64::from(*found) - expected).abs() < 1e-5);
    }
    // The trace of the inertia is the same in every frame.
    let moments: f32 = own.principal_inertia().to_array().iter().sum();
    let trace: f64 = (0..3).map(|axis| properties.inertia[axis][axis]).sum();
    assert!((f64::from(moments) / trace - 1.0).abs() < 1e-4);
    let scaled = hullwright_rapier::mass_properties(&properties, [-2.0, 3.0, 0.5]).unwrap();
    assert!((scaled.mass() / (3.0 * expected) - 1.0).abs() < 1e-5);
}

#[test]
fn a_collider_has_the_shape_and_the_mass_of_the_mesh() {
    let prism = Prop::model("u_prism");
    let (hulls, properties) = (&prism.decomposition.hulls, prism.mass_properties());
    let collider = hullwright_rapier::collider(hulls, &properties, [2.0; 3]).unwrap().build();
    let shapes = collider.shape().as_compound().unwrap().shapes().len();
    assert_eq!(shapes, hulls.len());
    let expected = 8.0 * properties.mass as f32;
    assert!((collider.mass() / expected - 1.0).abs() < 1e-5);
}

#[test]
fn what_leaves_no_body_is_an_error() {
    let prism = Prop::model("u_prism");
    let (hulls, properties) = (&prism.decomposition.hulls, prism.mass_properties());
    let flat = [1.0, 0.0, 1.0];
    let is_refused = |error: ColliderError| matches!(error, ColliderError::InvalidScale { .. });
    for scale in [flat, [1.0, f32::NAN, 1.0], [1.0, 1.0, f32::INFINITY]] {
        assert!(is_refused(hullwright_rapier::shape(hulls, scale).unwrap_err()));
    }
    let huge = [[0.0; 3], [1e38, 0.0, 0.0], [0.0, 1e38, 0.0], [0.0, 0.0, 1e38]];
    let result = hullwright_rapier::shape_from_points(&[huge], [10.0; 3]);
    assert!(matches!(result, Err(ColliderError::UnusableHull { hull: 0, .. })));
    assert!(is_refused(hullwright_rapier::mass_properties(&properties, flat).unwrap_err()));
    let refused = hullwright_rapier::collider(hulls, &properties, flat);
    assert!(refused.is_err_and(is_refused));
    let nothing = hullwright_rapier::shape(&[], [1.0; 3]).unwrap_err();
    assert!(matches!(nothing, ColliderError::NoHulls));
}

#[test]
fn parrys_shapes_become_ours_and_back() {
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Parry numbers vertices in the order of their first use.
    let mesh = MeshView::new(&positions, &[[0, 1, 2], [0, 2, 3]]);
    let shape = hullwright_rapier::triangle_mesh(mesh, TriMeshFlags::FIX_INTERNAL_EDGES).unwrap();
    assert_eq!(hullwright_rapier::mesh_from_shape(&shape), mesh.to_owned());
    let hull = hullwright::convex_hull(&positions.map(|point| point.map(f64::from))).unwrap();
    let polyhedron = hullwright_rapier::convex_polyhedron(&hull).unwrap();
    assert_eq!(hullwright_rapier::hull_from_shape(&polyhedron).points.len(), 4);
}
