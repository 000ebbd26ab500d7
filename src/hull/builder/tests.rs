//! Tests of `builder`.

use super::*;

/// Points inside a ball, and points around it.
fn ball() -> (Vec<Vector>, Vec<Vector>) {
    let point = |index: u32, radius: f64| {
        let (height, turn) = (f64::from(index) / 50.0 - 1.0, 2.4 * f64::from(index));
        let across = radius * (1.0 - height * height).max(0.0).sqrt();
        [across * turn.cos(), across * turn.sin(), radius * height]
    };
    let inside = (0..100).flat_map(|index| [point(index, 0.5), point(index, 1.0)]);
    (inside.collect(), (0..100).step_by(9).map(|index| point(index, 1.3)).collect())
}

#[test]
fn without_its_inner_points_a_hull_is_the_same_and_goes_on_growing_the_same_way() {
    let (points, far) = ball();
    let mut whole = HullBuilder::new();
    assert_eq!(whole.build(&points), Shape::Solid);
    let mut forgetful = whole.clone();
    forgetful.forget_inner_points();
    assert_eq!(forgetful.points.len(), forgetful.extract().0.len());
    assert!(forgetful.points.len() < whole.points.len());
    assert_eq!(forgetful.extract(), whole.extract());
    whole.insert_outside(&far);
    forgetful.insert_outside(&far);
    assert_eq!(forgetful.extract(), whole.extract());
    let faces = |builder: &HullBuilder| builder.new_faces().collect::<Vec<_>>();
    assert_eq!(faces(&forgetful), faces(&whole));
}
