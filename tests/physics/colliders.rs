//! Shapes, mass properties and colliders made of hulls, for the plugin and without it.

use hullwright::rapier::ColliderError;
use hullwright::{Control, Decomposition, Parameters, decompose, rapier};

/// A concave prism and the mass properties of its mesh at a density of 1000.
fn prism() -> (Decomposition, hullwright::MassProperties) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/u_prism.glb");
    let file = hullwright::io::read_mesh(path).unwrap();
    let parameters = Parameters::default();
    let result = decompose(&file, &parameters, &Control::new()).unwrap();
    let mass = hullwright::mass_properties(&file, &result.hulls, 1000.0);
    (result, mass.unwrap())
}

#[test]
fn several_hulls_are_a_compound_and_one_is_a_polyhedron() {
    let (prism, _) = prism();
    let shape = rapier::shape(&prism.hulls, [1.0; 3]).unwrap();
    assert_eq!(shape.as_compound().unwrap().shapes().len(), prism.hulls.len());
    let shape = rapier::shape(&prism.hulls[..1], [1.0; 3]).unwrap();
    let polyhedron = shape.as_convex_polyhedron().unwrap();
    assert_eq!(polyhedron.points().len(), prism.hulls[0].shape.points.len());
}

#[test]
fn scale_and_mirror_are_in_the_points() {
    let (prism, _) = prism();
    let bounds = |scale| {
        let bounds = rapier::shape(&prism.hulls, scale).unwrap().compute_local_aabb();
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
    let (_, properties) = prism();
    let own = rapier::mass_properties(&properties, [1.0; 3]).unwrap();
    let expected = properties.mass as f32;
    assert!((own.mass() / expected - 1.0).abs() < 1e-5);
    for (found, expected) in own.local_com.to_array().iter().zip(properties.centre) {
        assert!((f64::from(*found) - expected).abs() < 1e-5);
    }
    // The trace of the inertia is the same in every frame.
    let moments: f32 = own.principal_inertia().to_array().iter().sum();
    let trace: f64 = (0..3).map(|axis| properties.inertia[axis][axis]).sum();
    assert!((f64::from(moments) / trace - 1.0).abs() < 1e-4);
    let scaled = rapier::mass_properties(&properties, [-2.0, 3.0, 0.5]).unwrap();
    assert!((scaled.mass() / (3.0 * expected) - 1.0).abs() < 1e-5);
}

#[test]
fn a_collider_has_the_shape_and_the_mass_of_the_mesh() {
    let (prism, properties) = prism();
    let collider = rapier::collider(&prism.hulls, &properties, [2.0; 3]).unwrap();
    let collider = collider.build();
    let shapes = collider.shape().as_compound().unwrap().shapes().len();
    assert_eq!(shapes, prism.hulls.len());
    let expected = 8.0 * properties.mass as f32;
    assert!((collider.mass() / expected - 1.0).abs() < 1e-5);
}

#[test]
fn what_leaves_no_body_is_an_error() {
    let (prism, properties) = prism();
    let flat = [1.0, 0.0, 1.0];
    let is_refused = |error: ColliderError| matches!(error, ColliderError::InvalidScale { .. });
    assert!(is_refused(rapier::shape(&prism.hulls, flat).unwrap_err()));
    assert!(is_refused(rapier::mass_properties(&properties, flat).unwrap_err()));
    let refused = rapier::collider(&prism.hulls, &properties, flat);
    assert!(refused.is_err_and(is_refused));
    let nothing = rapier::shape(&[], [1.0; 3]).unwrap_err();
    assert!(matches!(nothing, ColliderError::NoHulls));
}
