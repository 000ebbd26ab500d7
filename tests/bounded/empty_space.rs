//! Hulls fill the solid and leave empty what is empty.

use hullwright::Parameters;

use crate::common::{both_ways, cuboid, cup, join, l_prism, plus_prism, torus, turned};
use crate::judge::{assert_promise, contains, judge, run, run_with};

#[test]
fn a_thin_walled_cup_stays_hollow() {
    let mesh = cup();
    let result = run(&mesh);
    assert_promise("cup", &mesh, &result);
    // A marble in the cup touches nothing above the floor.
    for z in [0.5, 1.0, 1.9] {
        for hull in &result.hulls {
            assert!(!contains(hull, [0.0, 0.0, z]), "{z}");
        }
    }
}

#[test]
fn a_solid_has_no_void() {
    for (name, mesh) in [("L", l_prism()), ("torus", torus()), ("plus", plus_prism())] {
        let hollow = judge(&mesh, &run(&mesh).hulls).uncovered_volume.unwrap();
        assert!(hollow <= 0.01, "{name}: {hollow}");
    }
}

#[test]
fn a_box_of_both_orientations_is_a_sheet_and_stays_hollow() {
    // Models whose sides are drawn from both sides have a winding number of 0 everywhere: hulls
    // that fill their inside protrude.
    let mesh = both_ways(&cuboid([0.0; 3], [1.0, 1.2, 1.4]));
    let result = run(&mesh);
    assert_promise("double box", &mesh, &result);
    assert!(result.hulls.iter().all(|hull| !contains(hull, [0.5, 0.6, 0.7])));
}

#[test]
fn a_cavity_fills_unless_it_is_to_be_kept() {
    let hollow = join(&[l_prism(), turned(&cuboid([0.4; 3], [0.6; 3]))]);
    let result = run(&hollow);
    assert_promise("filled", &hollow, &result);
    assert!(result.hulls.iter().any(|hull| contains(hull, [0.5; 3])));
    let mut parameters = Parameters::default();
    parameters.keep_cavities = true;
    let result = run_with(&hollow, &parameters);
    assert_promise("kept", &hollow, &result);
    assert!(result.hulls.iter().all(|hull| !contains(hull, [0.5; 3])));
    // Without cavities, keeping them changes nothing.
    assert_eq!(run_with(&l_prism(), &parameters).hulls, run(&l_prism()).hulls);
}

#[test]
fn plates_and_rods_far_thinner_than_the_bound_keep_their_volume() {
    // All corners but four hardly protrude from the hull of the others, a tetrahedron with a third
    // of the plate's volume.
    for extent in [[1.0, 1.0, 0.001], [1.0, 1.0, 0.0003], [1.0, 0.001, 0.001]] {
        let plate = cuboid([0.0; 3], extent);
        let result = run(&plate);
        assert_eq!(result.hulls.len(), 1);
        let volume: f64 = extent.iter().product();
        assert!(
            result.hulls[0].shape.volume() > 0.95 * volume,
            "{extent:?}: {}",
            result.hulls[0].shape.volume()
        );
    }
}
