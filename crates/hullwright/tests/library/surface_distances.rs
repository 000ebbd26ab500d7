//! How far two surfaces are from each other: known answers, and samples.

use hullwright::{
    Control, Error, HiddenTriangles, Length, MeasuredSurface, MeshView, SurfaceDistance,
    SurfaceDistances, TriangleMesh, simplify_surface, surface_distances,
};

use crate::common::{Mesh, Point, Random, ball, bundled_models, cuboid, join, torus};
use crate::independent::nearest::Tree;
use crate::independent::oracle::{Triangle, cross, middle, minus, norm};
use crate::independent::sampling::spread;

fn measured<'a, 'b>(
    a: impl Into<MeshView<'a>>,
    b: impl Into<MeshView<'b>>,
    hidden: HiddenTriangles<'_>,
) -> SurfaceDistances {
    surface_distances(a, b, hidden, &Control::new()).unwrap()
}

fn owned((positions, triangles): Mesh) -> TriangleMesh {
    TriangleMesh::new(positions, triangles)
}

/// A square of this side, as high as that.
fn square(side: f64, height: f64) -> TriangleMesh {
    let corners = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]];
    let positions = corners.map(|[x, y]| [x, y, height]).to_vec();
    TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]])
}

/// Checks the enclosure of a known distance.
#[track_caller]
fn assert_is(found: SurfaceDistance, expected: f64) {
    let SurfaceDistance { at_most, at_least, .. } = found;
    assert!(at_most >= expected && at_least <= expected * (1.0 + 1e-12), "{found:?}, {expected}");
    let most = expected * (1.0 + SurfaceDistances::RESOLUTION) + 1e-10;
    assert!(at_most <= most, "{found:?}, {expected}");
}

#[test]
fn parallel_squares_are_as_far_from_each_other_as_their_planes() {
    for height in [1e-9, 0.001, 0.3, 50.0] {
        let found = measured(&square(1.0, 0.0), &square(1.0, height), HiddenTriangles::Found);
        assert_is(found.from_a_to_b, height);
        assert_is(found.from_b_to_a, height);
        assert_eq!(found.diagonal, 2_f64.sqrt());
        assert!(found.hidden_of_a.is_empty() && found.hidden_of_b.is_empty());
    }
}

#[test]
fn a_part_is_at_no_distance_from_the_whole_which_is_far_from_the_part() {
    let (whole, part) = (square(2.0, 0.0), square(1.0, 0.0));
    let found = measured(&whole, &part, HiddenTriangles::Found);
    assert_is(found.from_a_to_b, 2_f64.sqrt());
    assert_is(found.from_b_to_a, 0.0);
    assert_eq!(found.hausdorff(), found.from_a_to_b.at_most);
    let back = measured(&part, &whole, HiddenTriangles::Found);
    assert_eq!(back.from_b_to_a, found.from_a_to_b);
    assert_eq!(back.from_a_to_b, found.from_b_to_a);
}

/// The unit cube, and the same without one corner up to the middles of its edges.
fn cut_cube() -> [TriangleMesh; 2] {
    let cube = owned(cuboid([0.0; 3], [1.0; 3]));
    let mut positions = cube.positions.clone();
    positions.extend([[0.5, 1.0, 1.0], [1.0, 0.5, 1.0], [1.0, 1.0, 0.5]]);
    positions.retain(|position| *position != [1.0; 3]);
    let hull = hullwright::convex_hull(&positions).unwrap();
    [cube, TriangleMesh::new(hull.points, hull.triangles)]
}

#[test]
fn a_cube_without_a_corner_is_short_by_the_height_of_the_corner() {
    let [cube, cut] = cut_cube();
    let found = measured(&cube, &cut, HiddenTriangles::Found);
    // The height of the corner above the middle of the cut.
    assert_is(found.from_a_to_b, 0.5 / 3_f64.sqrt());
    // The middle of the cut, from the three faces.
    assert_is(found.from_b_to_a, 1.0 / 6.0);
}

#[test]
fn a_bulge_between_corners_that_touch_is_found() {
    // The chord of a sphere is far from it in the middle only.
    let sphere = owned(ball(96, 192));
    let radius = norm(sphere.positions[sphere.positions.len() / 2]);
    let at = |axis: usize| {
        let along = |p: &Point| p[axis];
        *sphere.positions.iter().max_by(|a, b| along(a).total_cmp(&along(b))).unwrap()
    };
    let chord = TriangleMesh::new(vec![at(0), at(1), at(2)], vec![[0, 1, 2]]);
    let found = measured(&chord, &sphere, HiddenTriangles::Kept).from_a_to_b;
    let expected = radius * (1.0 - 1.0 / 3_f64.sqrt());
    assert!((found.at_most / expected - 1.0).abs() < 0.02, "{found:?}, {expected}");
}

#[test]
fn a_surface_is_at_no_distance_from_itself_however_it_is_cut() {
    for (name, mesh) in bundled_models() {
        let found = measured(&mesh, &mesh, HiddenTriangles::Found);
        assert!(found.hausdorff() < 1e-11 * found.diagonal, "{name}: {found:?}");
    }
    let fine = |n: u32| {
        let share = |i: u32| f64::from(i) / f64::from(n);
        let row = move |j: u32| (0..=n).map(move |i| [share(i), share(j), 0.3 * share(i)]);
        let positions = (0..=n).flat_map(row).collect();
        let cell = |k: u32| {
            let a = k / n * (n + 1) + k % n;
            [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
        };
        TriangleMesh::new(positions, (0..n * n).flat_map(cell).collect())
    };
    let found = measured(&fine(1), &fine(70), HiddenTriangles::Found);
    assert!(found.hausdorff() < 2e-8, "{found:?}");
}

#[test]
fn no_distance_is_measured_from_hidden_triangles_as_of_simplification_or_as_listed() {
    let floor = cuboid([-2.0, -2.0, -1.0], [3.0, 3.0, 0.0]);
    let sunk = cuboid([0.0, 0.0, -0.8], [1.0, 1.0, -0.2]);
    let level = owned(join(&[floor.clone(), sunk]));
    let floor = owned(floor);
    let simplified = simplify_surface(&level, Length::share(0.001), &Control::new()).unwrap();
    let found = measured(&level, &floor, HiddenTriangles::Found);
    assert_eq!(found.hidden_of_a, simplified.hidden);
    assert_is(found.from_a_to_b, 0.0);
    let kept = measured(&level, &floor, HiddenTriangles::Kept);
    assert!(kept.hidden_of_a.is_empty());
    assert_is(kept.from_a_to_b, 0.5);
    let listed = measured(&level, &floor, HiddenTriangles::Listed([&simplified.hidden, &[99]]));
    assert_eq!(listed, found);
    let all: Vec<u32> = (0..12).collect();
    let nothing = HiddenTriangles::Listed([&[], &all]);
    let refused = surface_distances(&level, &floor, nothing, &Control::new());
    assert!(matches!(refused, Err(Error::NothingUsable { degenerate: 0, .. })), "{refused:?}");
}

#[test]
fn points_have_their_distance() {
    let surface = MeasuredSurface::new(&square(2.0, 0.0), &Control::new()).unwrap();
    assert!((surface.distance([0.0, 2.0, 1.0]) - 1.0).abs() < 1e-12);
    assert!((surface.distance([3.0, 3.0, 1.0]) - 3_f64.sqrt()).abs() < 1e-12);
    assert!(surface.distance([f64::INFINITY, 0.0, 0.0]).is_infinite());
    let refused = MeasuredSurface::new(&TriangleMesh::default(), &Control::new());
    assert!(matches!(refused, Err(Error::EmptyMesh { .. })));
}

#[test]
fn a_result_that_sinks_into_a_solid_is_measured_to_but_not_from() {
    // A box on a floor, and the same a little lower: then it is hidden.
    let floor = cuboid([-2.0, -2.0, -1.0], [3.0, 3.0, 0.0]);
    let level = owned(join(&[floor.clone(), cuboid([0.0, 0.0, -0.5], [1.0, 1.0, 0.01])]));
    let sunk = owned(join(&[floor, cuboid([0.0, 0.0, -0.5], [1.0, 1.0, -0.01])]));
    let found = measured(&level, &sunk, HiddenTriangles::Found);
    assert!(found.hidden_of_a.len() < found.hidden_of_b.len(), "{found:?}");
    // The sides reach below the floor. They are at no distance from the hidden sides.
    assert_is(found.from_a_to_b, 0.01);
    assert_is(found.from_b_to_a, 0.0);
}

fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.corners;
    0.5 * norm(cross(minus(b, a), minus(c, a)))
}

/// The greatest distance that samples find of one surface from another.
fn sampled(of: &TriangleMesh, from: &TriangleMesh, count: f64) -> f64 {
    let [of, from] = [of, from].map(|mesh| Triangle::all(&mesh.positions, &mesh.triangles));
    let area: f64 = of.iter().map(area).sum();
    let special = of.iter().flat_map(|triangle| {
        let [a, b, c] = triangle.corners;
        [a, b, c, middle(a, b), middle(b, c), middle(c, a), triangle.centre]
    });
    let points: Vec<Point> = special.chain(spread(&of, count / area)).collect();
    let tree = Tree::new(from);
    points.into_iter().map(|point| tree.distance(point)).fold(0.0, f64::max)
}

/// Samples find nothing beyond the upper bound, and nearly the lower one.
#[track_caller]
fn assert_encloses(found: SurfaceDistance, sampled: f64, size: f64, what: &str) {
    let SurfaceDistance { at_most, at_least, .. } = found;
    assert!(sampled <= at_most + 1e-10 * size, "{what}: {found:?}, {sampled}");
    assert!(at_least <= at_most, "{what}: {found:?}");
    let most = at_least * (1.0 + SurfaceDistances::RESOLUTION) + 1e-8 * size;
    assert!(at_most <= most, "{what}: {found:?}");
    assert!(sampled >= 0.8 * at_least - 1e-10 * size, "{what}: {found:?}, {sampled}");
}

/// Two surfaces against dense samples.
#[track_caller]
fn assert_as_sampled(a: &TriangleMesh, b: &TriangleMesh, what: &str) {
    let found = measured(a, b, HiddenTriangles::Kept);
    let size = a.positions.iter().chain(&b.positions).map(|&p| norm(p)).fold(0.0, f64::max);
    assert_encloses(found.from_a_to_b, sampled(a, b, 20_000.0), size, what);
    assert_encloses(found.from_b_to_a, sampled(b, a, 20_000.0), size, what);
}

#[test]
fn samples_are_never_beyond_and_find_nearly_as_much() {
    let [cube, cut] = cut_cube();
    assert_as_sampled(&cube, &cut, "a cut cube");
    assert_as_sampled(&owned(torus()), &cube, "a torus and a cube");
    for (name, mesh) in bundled_models() {
        let simplified = simplify_surface(&mesh, Length::share(0.01), &Control::new()).unwrap();
        assert_as_sampled(&mesh, &simplified.mesh, &name);
    }
    let mut random = Random(11);
    for number in 0..40 {
        let mut soup = |count: u32| {
            let positions = (0..3 * count).map(|_| random.point()).collect();
            let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            TriangleMesh::new(positions, triangles)
        };
        let (a, b) = (soup(1 + number % 7), soup(1 + number % 11));
        assert_as_sampled(&a, &b, &format!("soup {number}"));
    }
}

#[test]
fn what_simplification_reports_is_what_is_measured() {
    for (name, mesh) in bundled_models() {
        let simplified = simplify_surface(&mesh, Length::share(0.01), &Control::new()).unwrap();
        let report = simplified.report;
        let found =
            measured(&simplified.mesh, &mesh, HiddenTriangles::Listed([&[], &simplified.hidden]));
        let least = 1e-10 * found.diagonal;
        assert!(found.from_a_to_b.at_least <= report.from_source + least, "{name}: {found:?}");
        assert!(found.from_b_to_a.at_least <= report.to_source + least, "{name}: {found:?}");
    }
}

#[test]
fn sizes_and_places_far_apart_do_no_harm() {
    for scale in [1e-200, 1e-12, 1e12, 1e150] {
        let scaled = |mut mesh: TriangleMesh| {
            mesh.positions.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
            mesh
        };
        let found =
            measured(&scaled(square(1.0, 0.0)), &scaled(square(1.0, 0.5)), HiddenTriangles::Found);
        assert!((found.from_a_to_b.at_most / scale - 0.5).abs() < 1e-9, "{found:?}");
        // Beside a unit square.
        let found = measured(&square(1.0, 0.0), &scaled(square(1.0, 0.0)), HiddenTriangles::Found);
        let most = 2_f64.sqrt() * (scale - 1.0).abs();
        let larger = found.hausdorff();
        assert!((larger / most - 1.0).abs() < 0.011, "{scale}: {found:?}");
    }
}

#[test]
fn threads_and_the_order_of_triangles_do_not_matter() {
    let (torus, sphere) = (owned(torus()), owned(ball(16, 32)));
    let found = measured(&torus, &sphere, HiddenTriangles::Found);
    let alone = Control::new().with_parallel(false);
    let again = surface_distances(&torus, &sphere, HiddenTriangles::Found, &alone).unwrap();
    assert_eq!(again, found);
    let mut reversed = torus;
    reversed.triangles.reverse();
    let again = measured(&reversed, &sphere, HiddenTriangles::Found);
    assert_eq!(again.from_a_to_b, found.from_a_to_b);
}

#[test]
fn either_mesh_that_can_not_be_measured_is_refused() {
    let (square, empty) = (square(1.0, 0.0), TriangleMesh::default());
    let point = TriangleMesh::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]);
    let control = Control::new();
    let refused = |a: &TriangleMesh, b: &TriangleMesh, control: &Control| {
        surface_distances(a, b, HiddenTriangles::Found, control).unwrap_err()
    };
    for (a, b) in [(&square, &empty), (&empty, &square)] {
        assert!(matches!(refused(a, b, &control), Error::EmptyMesh { .. }));
    }
    for (a, b) in [(&square, &point), (&point, &square)] {
        assert!(matches!(refused(a, b, &control), Error::NothingUsable { .. }));
    }
    let large = owned(cuboid([0.0; 3], [1.0; 3]));
    let limited = Control::new().with_max_triangles(10);
    assert!(matches!(refused(&square, &large, &limited), Error::TooLarge { .. }));
    control.cancel();
    assert_eq!(refused(&square, &square, &control), Error::Cancelled);
}
