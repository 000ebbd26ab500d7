//! Tests of `builder`.

use super::*;
use crate::geometry::vector::dot;
use crate::hull::ConvexHull;

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

#[test]
fn of_points_inside_and_outside_only_those_outside_are_kept_and_the_hull_is_that_of_all() {
    let (points, far) = ball();
    let mut whole = HullBuilder::new();
    assert_eq!(whole.build(&points), Shape::Solid);
    let mut sparing = whole.clone();
    let more: Vec<Vector> =
        far.iter().flat_map(|&point| [scale(point, 0.1), point, scale(point, 0.6)]).collect();
    whole.insert(&more);
    sparing.insert_outside(&more);
    assert_eq!(sparing.points.len(), points.len() + far.len());
    let vertices = |builder: &mut HullBuilder| {
        let mut vertices = builder.extract().0;
        vertices.sort_by(|a, b| a.partial_cmp(b).unwrap());
        vertices
    };
    assert_eq!(vertices(&mut sparing), vertices(&mut whole));
    assert!(far.iter().all(|point| vertices(&mut sparing).contains(point)));
}

#[test]
fn the_farthest_of_any_number_of_points_is_as_far_as_one_by_one_over_all_planes() {
    let (points, far) = ball();
    let mut builder = HullBuilder::new();
    assert_eq!(builder.build(&points), Shape::Solid);
    let planes = ConvexHull::from(builder.extract()).planes();
    let height = |point: &Vector| {
        let heights = planes.iter().map(|&(normal, offset)| dot(normal, *point) - offset);
        heights.fold(f64::NEG_INFINITY, f64::max)
    };
    for count in 1..far.len() {
        for some in [&far[..count], &points[..count]] {
            let expected = some.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
            assert!((builder.farthest_outside(some) - expected).abs() < 1e-12, "{count}");
        }
    }
}

#[test]
fn volume_vertices_and_heights_are_those_of_the_points_at_any_scale() {
    let box_of = |size: f64| -> Vec<Vector> {
        let corners = (0..8).map(|i| [0, 1, 2].map(|k| f64::from(i >> k & 1)));
        corners.map(|[x, y, z]| [2.0 * size * x, 3.0 * size * y, 5.0 * size * z]).collect()
    };
    for size in [1e-6, 0.3, 1.0, 1e6] {
        let mut points = box_of(size);
        points.push([size; 3]);
        let mut builder = HullBuilder::new();
        assert_eq!(builder.build(&points), Shape::Solid);
        assert!((builder.volume() / (30.0 * size.powi(3)) - 1.0).abs() < 1e-12, "{size}");
        let above = [size, size, 7.0 * size];
        assert!((builder.farthest_outside(&[above]) / (2.0 * size) - 1.0).abs() < 1e-12, "{size}");
        let mut vertices = builder.vertices_of(&points).unwrap();
        vertices.sort_by(|a, b| a.partial_cmp(b).unwrap());
        points.pop();
        points.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(vertices, points);
        assert!(builder.vertices_of(&points[..3]).is_none(), "a triangle has no hull");
    }
}
