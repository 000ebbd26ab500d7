//! Shapes, mass properties and colliders made of hulls, for the plugin and without it.

use hullwright::rapier::ColliderError;
use hullwright::{ConvexHull, MeshView, TriangleMesh, rapier};
use rapier3d::parry::shape::TriMeshFlags;

use crate::world::Prop;

#[test]
fn several_hulls_are_a_compound_and_one_is_a_polyhedron() {
    let prism = Prop::model("u_prism");
    let hulls = &prism.decomposition.hulls;
    let shape = rapier::shape(hulls, [1.0; 3]).unwrap();
    assert_eq!(shape.as_compound().unwrap().shapes().len(), hulls.len());
    let shape = rapier::shape(&hulls[..1], [1.0; 3]).unwrap();
    let polyhedron = shape.as_convex_polyhedron().unwrap();
    assert_eq!(polyhedron.points().len(), hulls[0].shape.points.len());
}

#[test]
fn scale_and_mirror_are_in_the_points() {
    let prism = Prop::model("u_prism");
    let hulls = &prism.decomposition.hulls;
    let bounds = |scale| {
        let bounds = rapier::shape(hulls, scale).unwrap().compute_local_aabb();
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
    let prism = Prop::model("u_prism");
    let (hulls, properties) = (&prism.decomposition.hulls, prism.mass_properties());
    let collider = rapier::collider(hulls, &properties, [2.0; 3]).unwrap();
    let collider = collider.build();
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
        assert!(is_refused(rapier::shape(hulls, scale).unwrap_err()));
    }
    let huge = [[0.0; 3], [1e38, 0.0, 0.0], [0.0, 1e38, 0.0], [0.0, 0.0, 1e38]];
    let result = rapier::shape_from_points(&[huge], [10.0; 3]);
    assert!(matches!(result, Err(ColliderError::UnusableHull { hull: 0, .. })));
    assert!(is_refused(rapier::mass_properties(&properties, flat).unwrap_err()));
    let refused = rapier::collider(hulls, &properties, flat);
    assert!(refused.is_err_and(is_refused));
    let nothing = rapier::shape(&[], [1.0; 3]).unwrap_err();
    assert!(matches!(nothing, ColliderError::NoHulls));
}

#[test]
fn parrys_shapes_become_ours_and_back() {
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Parry numbers vertices in the order of their first use.
    let mesh = MeshView::new(&positions, &[[0, 1, 2], [0, 2, 3]]);
    let shape = rapier::triangle_mesh(mesh, TriMeshFlags::FIX_INTERNAL_EDGES).unwrap();
    assert_eq!(TriangleMesh::from(&shape), mesh.to_owned());
    let hull = hullwright::convex_hull(&positions.map(|point| point.map(f64::from))).unwrap();
    let polyhedron = rapier::convex_polyhedron(&hull).unwrap();
    assert_eq!(ConvexHull::from(&polyhedron).points.len(), 4);
}
