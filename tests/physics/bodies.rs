//! Rapier's bodies: mass, centre, inertia, shape.

use std::f64::consts::{PI, TAU};

use hullwright::io::read_mesh;
use hullwright::rapier::ColliderError;
use hullwright::{MassSource, Parameters, TriangleMesh, rapier};
use rapier3d::prelude::*;

use crate::world::{DENSITY, Prop, World};

/// A torus around y whose corners lie on the ideal one's surface.
fn torus(large: f64, small: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let (n, m) = (96_u32, 48_u32);
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
            let r = large + small * b.cos();
            positions.push([r * a.cos(), small * b.sin(), r * a.sin()]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
    (positions, triangles)
}

fn assert_close(found: f64, expected: f64, share: f64) {
    assert!((found - expected).abs() < share * expected.abs(), "{found}, not {expected}");
}

#[test]
fn rapier_gets_a_toruss_mass_and_inertia_within_a_hundredth() {
    let (large, small) = (0.5, 0.2);
    let prop = Prop::mesh(torus(large, small));
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
    let converted = rapier::mass_properties(&properties, [1.0; 3]).unwrap();
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
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/u_prism.glb");
    let file = read_mesh(path).unwrap();
    let parameters = Parameters::default();
    let collider = rapier::collider_from_mesh(&file, DENSITY, &parameters);
    let expected = Prop::model("u_prism").collider().build();
    let found = collider.unwrap().build();
    assert_eq!(found.mass(), expected.mass());
    assert_eq!(found.compute_aabb(), expected.compute_aabb());

    let nothing = rapier::collider_from_mesh(&TriangleMesh::default(), DENSITY, &parameters);
    assert!(matches!(nothing.err(), Some(ColliderError::Mesh(_))));
}
