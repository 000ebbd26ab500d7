//! Few hulls: as many as a person would use for simple shapes.

use hullwright::{Parameters, Preset};

use crate::common::{
    ball, both_ways, cuboid, cup, join, l_prism, lathe, plus_prism, torus, u_prism,
};
use crate::judge::{assert_promise, judge, report, run, run_with};

#[test]
fn an_l_prism_is_two_boxes() {
    let mesh = l_prism();
    let result = run(&mesh);
    assert_eq!(result.hulls.len(), 2);
    assert_promise("L", &mesh, &result);
    assert!(judge(&mesh, &result.hulls).iou.unwrap() > 0.97);
}

#[test]
fn a_u_prism_is_three_boxes() {
    let mesh = u_prism();
    let result = run(&mesh);
    assert_eq!(result.hulls.len(), 3);
    assert_promise("U", &mesh, &result);
}

#[test]
fn a_plus_sign_is_two_overlapping_boxes() {
    let mesh = plus_prism();
    let result = run(&mesh);
    assert_eq!(result.hulls.len(), 2);
    assert_promise("plus", &mesh, &result);
}

#[test]
fn a_torus_is_at_most_nine_hulls() {
    let mesh = torus();
    let result = run(&mesh);
    assert!(result.hulls.len() <= 9, "{}", result.hulls.len());
    assert_promise("torus", &mesh, &result);
}

#[test]
fn convex_input_is_one_patch_and_one_hull() {
    let profile = [[0.005, 0.0], [1.0, 0.0], [1.0, 3.0], [0.005, 3.0]];
    let mesh = lathe(&profile, 96);
    let result = run(&mesh);
    assert_eq!(result.hulls.len(), 1);
    assert_eq!(report(&result).patches, 1);
    assert_promise("cylinder", &mesh, &result);
}

#[test]
fn a_ball_of_more_vertices_than_a_hull_may_have_is_one_hull() {
    // A hull of 64 vertices needs nearly all of the bound.
    let ball = ball(40, 80);
    let result = run(&ball);
    assert_eq!(result.hulls.len(), 1);
    assert!(result.hulls[0].shape.points.len() <= 64);
    assert_promise("ball", &ball, &result);
}

#[test]
fn parts_that_do_not_touch_stay_apart() {
    let near = cuboid([0.0; 3], [1.0; 3]);
    let far = cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0]);
    let result = run(&join(&[near, far]));
    assert_eq!(result.hulls.len(), 2);
    assert_eq!(
        result.hulls.iter().map(|hull| hull.provenance.component).collect::<Vec<_>>(),
        [0, 1]
    );
}

#[test]
fn duplicate_triangles_change_nothing() {
    let (positions, mut triangles) = l_prism();
    triangles.extend(triangles.clone());
    assert_eq!(run(&(positions, triangles)).hulls.len(), 2);
}

#[test]
fn hulls_that_verification_divided_join_again() {
    // Without remerging, a cube with both orientations of each triangle is 244 hulls.
    let mesh = both_ways(&cuboid([0.0; 3], [1.0; 3]));
    let result = run(&mesh);
    assert_promise("double cube", &mesh, &result);
    assert!(result.hulls.len() <= 30, "{}", result.hulls.len());
}

#[test]
fn long_needles_are_no_reason_to_divide() {
    // Divided by size, a tube of 300 facets becomes 5,000 patches.
    let tube = lathe(&[[0.2, -0.5], [0.22, -0.5], [0.22, 0.5], [0.2, 0.5]], 300);
    let result = run(&tube);
    let patches = report(&result).patches;
    assert!(patches < 1500, "{patches}");
    assert_promise("tube", &tube, &result);
}

#[test]
fn a_finer_preset_has_no_more_hulls() {
    for mesh in [torus(), cup(), plus_prism()] {
        let counts = [Preset::Fast, Preset::Balanced, Preset::Fine].map(|preset| {
            let mut parameters = Parameters::default();
            parameters.preset = preset;
            run_with(&mesh, &parameters).hulls.len()
        });
        assert!(counts.is_sorted_by(|coarse, fine| coarse >= fine), "{counts:?}");
    }
}
