//! Promises of convex hulls, and of the primitives in their place.

// The unused rest is for other tests.
#[allow(dead_code)]
#[path = "independent/mod.rs"]
mod independent;

use hullwright::hull::{
    ConvexHull, DEFAULT_TOLERANCE, HullBuilder, MINIMUM_THICKNESS, Primitive, Shape, Slack,
    convex_hull, fit_primitive, solid_hull,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use independent::exact::{Faults, faults};
use independent::oracle::{Convex, cross, dot, minus, norm};

type Point = [f64; 3];

fn diagonal(points: &[Point]) -> f64 {
    let extent = |axis: usize| {
        let of = points.iter().map(|point| point[axis]);
        of.clone().fold(f64::MIN, f64::max) - of.fold(f64::MAX, f64::min)
    };
    norm([extent(0), extent(1), extent(2)])
}

/// Height over longest side; below this a triangle's computed normal is noise.
const SLIVER: f64 = 1e-7;

/// Worst distance of a point in front of a face of the hull that is no sliver.
fn worst_outside(hull: &ConvexHull, points: &[Point]) -> f64 {
    let mut worst = f64::MIN;
    for [a, b, c] in hull.corners() {
        let normal = cross(minus(b, a), minus(c, a));
        let area = norm(normal);
        let side = norm(minus(b, a)).max(norm(minus(c, a))).max(norm(minus(c, b)));
        if area <= SLIVER * side * side {
            continue;
        }
        for &point in points {
            worst = worst.max(dot(normal, minus(point, a)) / area);
        }
    }
    worst
}

fn area([a, b, c]: [Point; 3]) -> f64 {
    0.5 * norm(cross(minus(b, a), minus(c, a)))
}

/// A hull is one closed surface with volume and no unused vertex, and exactly convex.
fn check_closed(hull: &ConvexHull) {
    assert!(hull.volume() > 0.0, "volume {}", hull.volume());
    assert_eq!(faults(&hull.points, &hull.triangles), Faults::default());
}

/// Everything that a hull promises, whatever its points.
fn check(hull: &ConvexHull, points: &[Point]) {
    let size = diagonal(points);
    check_closed(hull);
    let outside = worst_outside(hull, points);
    assert!(outside <= DEFAULT_TOLERANCE * size * 1.01, "a point is outside by {}", outside / size);
    assert!(hull.points.iter().all(|vertex| points.contains(vertex)), "a vertex is invented");
}

fn grid([x, y, z]: [u32; 3]) -> Vec<Point> {
    let point = |i: u32| [i / (y * z), i / z % y, i % z].map(f64::from);
    (0..x * y * z).map(point).collect()
}

#[test]
fn a_box_with_points_all_over_it_has_eight_vertices_and_a_rotated_one_too() {
    let (sin, cos) = 0.7f64.sin_cos();
    let rotated = |[x, y, z]: Point| [cos * x - sin * y, sin * x + cos * y, z + 0.3 * x - 0.1 * y];
    let (plain, volume) = (grid([7, 5, 4]), 6.0 * 4.0 * 3.0);
    let rotated = plain.iter().copied().map(rotated).collect();
    for (points, rounding) in [(plain, 1e-12), (rotated, 1e-10)] {
        let hull = convex_hull(&points).unwrap();
        check(&hull, &points);
        assert_eq!((hull.points.len(), hull.triangles.len()), (8, 12));
        assert!((hull.volume() - volume).abs() < rounding);
    }
}

#[test]
fn duplicates_change_nothing() {
    let mut points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let once = convex_hull(&points).unwrap();
    points.extend(points.clone());
    let twice = convex_hull(&points).unwrap();
    assert_eq!(once, twice);
    assert!((once.volume() - 1.0 / 6.0).abs() < 1e-15);
}

#[test]
fn cospherical_points_are_all_vertices() {
    let angle = |i: u32| f64::from(i) * std::f64::consts::PI / 12.0;
    let point = |azimuth: f64, polar: f64| {
        [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
    };
    let ring = |j| (0..24).map(move |i| point(angle(i), angle(j)));
    let points: Vec<Point> = (1..12).flat_map(ring).collect();
    let hull = convex_hull(&points).unwrap();
    check(&hull, &points);
    assert_eq!(hull.points.len(), points.len());
}

#[test]
fn a_dense_nearly_flat_side_stays_convex() {
    // The case that broke an early quickhull: many points, each barely in front of the others.
    let mut points = vec![[0.0, 0.0, -1.0]];
    points.extend(grid([60, 60, 1]).into_iter().map(|[x, y, _]| {
        let (x, y) = (x / 60.0 - 0.5, y / 60.0 - 0.5);
        [x, y, -1e-6 * (x * x + y * y)]
    }));
    check(&convex_hull(&points).unwrap(), &points);
}

#[test]
fn needles_and_plates_are_hulls_as_long_as_they_are_thicker_than_the_tolerance() {
    for thickness in [1e-1, 1e-3, 1e-5, 1e-6].map(|thickness| 10.0 * thickness) {
        for (counts, [y, z]) in [([9, 7, 2], [1.0, thickness]), ([9, 2, 2], [thickness; 2])] {
            let points = grid(counts).into_iter().map(|p| [p[0], y * p[1], z * p[2]]);
            let points: Vec<Point> = points.collect();
            check(&convex_hull(&points).unwrap(), &points);
        }
    }
}

#[test]
fn flat_linear_and_pointlike_sets_are_recognised() {
    let mut builder = HullBuilder::new();
    for (points, shape) in [
        (grid([4, 5, 1]), Shape::Flat),
        (grid([4, 1, 1]), Shape::Linear),
        (grid([1, 1, 1]), Shape::Point),
        (vec![], Shape::Point),
        (vec![[f64::NAN; 3], [f64::INFINITY; 3]], Shape::Point),
    ] {
        assert_eq!(builder.build(&points), shape);
        assert!(convex_hull(&points).is_err());
    }
}

#[test]
fn what_is_thinner_than_the_minimum_is_thickened_to_it_and_a_thicker_body_is_left_alone() {
    let mut builder = HullBuilder::new();
    for size in [1e-3, 1.0, 1e3] {
        let plate = |thickness: f64| -> Vec<Point> {
            let points = grid([9, 7, 2]).into_iter();
            points.map(|[x, y, z]| [size * x, size * y, thickness * z]).collect()
        };
        let wanted = MINIMUM_THICKNESS * diagonal(&plate(0.0));
        let mut solid =
            |points: &[Point]| solid_hull(&mut builder, points, [0.0, 0.0, 1.0], 0.0).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-5 * wanted;
        for share in [0.0, 0.01, 0.3, 0.9] {
            let (hull, added) = solid(&plate(share * wanted));
            let bounds = hull.bounds().unwrap();
            assert!(near(bounds.max[2], share * wanted), "the outer side stays");
            assert!(share > 0.0 || bounds.max[2] == 0.0 && (added - wanted).abs() < 1e-12 * size);
            assert!(near(bounds.max[2] - bounds.min[2], wanted), "{share}");
            assert!(near(added, (1.0 - share) * wanted), "{share}");
            assert_eq!(hull.points.len(), 8);
        }
        for times in [1.01, 5.0, 1000.0] {
            let points = plate(times * wanted);
            let (hull, added) = solid(&points);
            assert_eq!(added, 0.0);
            check(&hull, &points);
            assert_eq!(hull.points.len(), 8);
        }
    }
}

#[test]
fn lines_and_spots_become_bodies() {
    let mut builder = HullBuilder::new();
    let (rod, _) = solid_hull(&mut builder, &grid([5, 1, 1]), [0.0, 1.0, 0.0], 0.0).unwrap();
    assert!(rod.volume() > 0.0);
    assert_eq!(rod.bounds().unwrap().max[1], 0.0);
    let (spot, _) = solid_hull(&mut builder, &grid([1, 1, 1]), [0.0; 3], 0.5).unwrap();
    assert!((spot.volume() - 0.125).abs() < 1e-6, "{}", spot.volume());
    assert!(solid_hull(&mut builder, &[], [0.0; 3], 0.5).is_err());
}

#[test]
fn a_copy_grows_on_its_own_to_the_hull_of_all_points() {
    let all = random_points(7, 200);
    let mut builder = HullBuilder::new();
    builder.build(&all[..150]);
    let before = builder.extract();
    let mut copy = builder.clone();
    copy.insert(&all[150..]);
    let grown = ConvexHull::from(copy.extract());
    check(&grown, &all);
    let anew = convex_hull(&all).unwrap();
    assert!((grown.volume() - anew.volume()).abs() < 1e-9);
    assert_eq!(builder.extract(), before);
    assert!(builder.contains_all(&all[..150], 1e-6));
    assert!(!builder.contains_all(&all, 1e-6));
    assert!(copy.contains_all(&all, 1e-6));
}

#[test]
fn far_from_the_origin_and_at_any_scale_the_triangles_are_the_same() {
    let points = random_points(3, 80);
    let hull = convex_hull(&points).unwrap();
    for scale in [1e-150, 1e-20, 1e20, 1e150] {
        let scaled: Vec<Point> = points.iter().map(|p| p.map(|x| x * scale)).collect();
        assert_eq!(convex_hull(&scaled).unwrap().triangles.len(), hull.triangles.len());
    }
    let moved: Vec<Point> = points.iter().map(|p| p.map(|x| x + 1000.0)).collect();
    assert_eq!(convex_hull(&moved).unwrap().triangles, hull.triangles);
}

fn random_points(seed: u64, count: usize) -> Vec<Point> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count).map(|_| [next(), next(), next()]).collect()
}

/// Coordinates that are often equal, nearly equal, or on a grid.
fn awkward_coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        (-4i32..=4).prop_map(f64::from),
        (-4i32..=4).prop_map(|x| f64::from(x) + 1e-9),
        (-4i32..=4).prop_map(|x| f64::from(x) - 3e-7),
        -1.0..1.0,
        (-1.0f32..1.0).prop_map(f64::from),
    ]
}

/// Sets that once made a hull look for the same point for ever: with a tolerance as fine as
/// rounding errors, the point was outside by the plane of a sliver, and not by the exact answer.
const ENDLESS: [[Point; 6]; 3] = [
    [
        [-0.7308802922959753, -0.6825056764110838, -0.3000008999999997],
        [-2.923520382890093, -2.730023547668987, -1.199999835308424],
        [-2.7292917317706603e-6, 2.9242033518359147e-6, -8.996999999999999e-7],
        [2.192641262288677, 2.047516176959344, 0.8999996100000003],
        [-2.7292919365223714e-6, 2.924203571099994e-6, -8.997000899999999e-7],
        [0.5095999552097397, 0.4758753140602916, 0.209172968771384],
    ],
    [
        [0.4522368037228474, 1.9481996502860128, 0.600040000297],
        [-0.1306348980705735, -0.5627873973146597, -0.17332046970840143],
        [0.9044660076517317, 3.896400754671252, 1.1999799100000101],
        [0.45223680372284647, 1.948199650286013, 0.5999923113121488],
        [0.22612028211398222, 0.9740990801929664, 0.299999909997],
        [-0.45222907852945193, -1.948201750473624, -0.60004008999999],
    ],
    [
        [9.34456062656199e-7, 3.9008706549903796e-6, -8.169045114517211e-7],
        [1.9743725241090617, -0.3191462612334696, -0.59999709],
        [3.9487438166191846, -0.6382963753051987, -1.1999999997],
        [3.9487430971110875, -0.6383008326939609, -1.199995999999999],
        [-0.6731179547394143, 0.10881118098343202, 0.20455881085556546],
        [0.8176667431917344, -0.13216887591188362, -0.24848433596473932],
    ],
];

#[test]
fn needles_with_a_tolerance_like_rounding_errors_end() {
    for points in ENDLESS {
        for first in 4..=points.len() {
            let mut builder = HullBuilder::new().with_tolerance(1e-14);
            if builder.build(&points[..first]) == Shape::Solid {
                builder.insert(&points[first..]);
                check_closed(&builder.extract().into());
            }
        }
    }
}

/// A triangle a thousandth long and a billionth high, on a hull four across: moving its corners
/// to the centre of the first points rounded them, by next to nothing, and turned it by so much
/// that the hull's other end stood out.
#[test]
fn a_face_far_smaller_than_the_hull_is_as_exact_as_its_points() {
    const POINTS: [Point; 9] = [
        [-0.37399035716531925, -0.33110924652429197, -0.1498505616765832],
        [0.0, 0.0, 0.0],
        [-2.2461799120595866e-7, -1.988636669344098e-7, -9e-8],
        [0.7487253123441421, 0.6628803878975205, 0.3000000003],
        [1.988636668681219e-6, -2.2461799113108597e-6, 0.0],
        [0.0, 0.0, -0.000999999999],
        [2.994909200928341, 2.6515125642189155, 1.2004923931658267],
        [2.9949092016770678, 2.6515125648817945, 1.2009587770935957],
        [2.9949092009283413, 2.6515125642189146, 1.1995879346015579],
    ];
    let mut builder = HullBuilder::new();
    assert_eq!(builder.build(&POINTS[..6]), Shape::Solid);
    for point in &POINTS[6..] {
        builder.insert(std::slice::from_ref(point));
    }
    check(&builder.extract().into(), &POINTS);
}

/// The point farthest from the plane of the first three was one of them, by rounding, and the
/// hull was torn.
#[test]
fn what_rounding_errors_take_for_solid_is_flat() {
    const POINTS: [Point; 4] = [
        [0.0, 0.0, -2.0000002999999997e-6],
        [0.0, 0.0, -2e-6],
        [-7.92621434973299e-6, 6.1045168590222465e-6, -2.09e-6],
        [-0.6336602250156852, -0.7736118660110902, -0.30000009],
    ];
    for tolerance in [1e-14, 0.0] {
        let mut builder = HullBuilder::new().with_tolerance(tolerance);
        if builder.build(&POINTS) == Shape::Solid {
            check_closed(&builder.extract().into());
        }
    }
}

/// Of a sheet of points hardly thicker than the tolerance no edge bends for certain, so that no
/// vertex need be a corner: building anew with the corners alone had nothing to begin with.
#[test]
fn a_sheet_hardly_thicker_than_the_tolerance_is_flat_or_a_body() {
    // Most such sheets have some corner; this one, found by fuzzing, had none.
    let found = [
        [0.03, -0.3, -1.51e-7],
        [-0.03, 0.24, 2.18e-7],
        [0.06, 0.31, 2.52e-7],
        [0.19, 0.15, 8.4e-8],
        [0.24, -0.03, -1.7e-8],
        [0.17, 0.09, -1.7e-8],
        [-0.19, -0.16, -1.51e-7],
        [-0.12, -0.24, -1.85e-7],
    ];
    check(&convex_hull(&found).unwrap(), &found);
    let mut solid = 0;
    for round in 0..2000 {
        let thickness = DEFAULT_TOLERANCE * (1 + round % 50) as f64 / 10.0;
        let points = random_points(round, 4 + round as usize % 7).into_iter();
        let points: Vec<Point> = points.map(|[x, y, z]| [x, y, thickness * z]).collect();
        let mut builder = HullBuilder::new();
        if builder.build(&points) == Shape::Solid {
            check(&builder.extract().into(), &points);
            solid += 1;
        }
    }
    assert!((200..1800).contains(&solid), "{solid}");
}

/// Points of the unit sphere, evenly (Fibonacci's lattice).
fn sphere(count: u32) -> Vec<Point> {
    let point = |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let angle = f64::from(i) * std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let ring = (1.0 - z * z).sqrt();
        [ring * angle.cos(), ring * angle.sin(), z]
    };
    (0..count).map(point).collect()
}

/// A sphere's halves, moved apart.
fn capsule(count: u32, apart: f64) -> Vec<Point> {
    sphere(count).into_iter().map(|[x, y, z]| [x, y, z + apart * z.signum()]).collect()
}

/// The corners of a box about the origin.
fn cuboid(half: Point) -> Vec<Point> {
    let corner = |p: Point| [0, 1, 2].map(|k| (2.0 * p[k] - 1.0) * half[k]);
    grid([2; 3]).into_iter().map(corner).collect()
}

fn combined([x, y, z]: Point, axes: [Point; 3]) -> Point {
    [0, 1, 2].map(|k| x * axes[0][k] + y * axes[1][k] + z * axes[2][k])
}

fn moved(point: Point, by: f64, along: Point) -> Point {
    [0, 1, 2].map(|k| point[k] + by * along[k])
}

/// Turned and moved, so that nothing lies along the axes.
fn placed(points: &[Point]) -> ConvexHull {
    let axes = [[0.6, 0.8, 0.0], [-0.8 * 0.6, 0.36, 0.8], [0.64, -0.48, 0.6]];
    let placed = points.iter().map(|&point| moved([5.0, -3.0, 2.0], 1.0, combined(point, axes)));
    convex_hull(&placed.collect::<Vec<_>>()).unwrap()
}

fn fit_within(hull: &ConvexHull, both: f64) -> Option<Primitive> {
    fit_primitive(hull, Slack { outside: both, inside: both })
}

#[test]
fn a_turned_box_is_a_box_of_its_size() {
    let hull = placed(&cuboid([3.0, 2.0, 0.5]));
    let Some(Primitive::Cuboid { centre, mut half, .. }) = fit_within(&hull, 1e-6) else {
        panic!("it is no box");
    };
    half.sort_by(f64::total_cmp);
    assert!(norm(minus(half, [0.5, 2.0, 3.0])) < 1e-6);
    assert!(norm(minus(centre, [5.0, -3.0, 2.0])) < 1e-6);
}

#[test]
fn round_hulls_are_balls_and_capsules_within_their_slack_and_not_below() {
    let ball = placed(&sphere(200));
    // Where the slack allows more, the radius is still halfway between what is in and what is out.
    for both in [0.03, 0.2] {
        assert!(matches!(
            fit_within(&ball, both),
            Some(Primitive::Ball { radius, .. }) if (radius - 1.0).abs() < 0.03
        ));
    }
    assert_eq!(fit_within(&ball, 0.001), None);
    let long = placed(&capsule(200, 2.0));
    let Some(Primitive::Capsule { ends: [a, b], radius }) = fit_within(&long, 0.05) else {
        panic!("it is no capsule");
    };
    assert!((norm(minus(a, b)) - 4.0).abs() < 0.1 && (radius - 1.0).abs() < 0.05);
    assert_eq!(fit_within(&long, 0.001), None);
}

#[test]
fn other_hulls_stay_hulls() {
    let wedge: Vec<Point> = grid([2; 3])
        .into_iter()
        .filter(|[x, y, _]| x * y == 0.0)
        .map(|[x, y, z]| [2.0 * x, y, z])
        .collect();
    assert_eq!(fit_within(&placed(&wedge), 0.05), None);
    let cube = placed(&cuboid([1.0; 3]));
    for (outside, inside) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, f64::NAN)] {
        assert_eq!(fit_primitive(&cube, Slack { outside, inside }), None);
    }
}

/// Against many points on both surfaces.
#[test]
fn a_primitive_is_within_its_slack_both_ways() {
    let mut cut = cuboid([1.0, 0.8, 0.6]);
    cut[7] = [0.95, 0.77, 0.58];
    // The corner that is cut off is 0.0616 from what is left: no box can be nearer.
    for (points, both) in [(sphere(128), 0.05), (capsule(72, 1.5), 0.12), (cut, 0.062)] {
        let hull = placed(&points);
        let solid = Convex::new(&hull.points, &hull.triangles);
        let found = fit_within(&hull, both).unwrap_or_else(|| panic!("none within {both}"));
        let outside = |point: Point| match found {
            Primitive::Ball { centre, radius } => norm(minus(point, centre)) - radius,
            Primitive::Capsule { ends: [a, b], radius } => {
                let (along, offset) = (minus(b, a), minus(point, a));
                let place = (dot(along, offset) / dot(along, along)).clamp(0.0, 1.0);
                norm(minus(point, moved(a, place, along))) - radius
            }
            Primitive::Cuboid { centre, axes, half } => {
                let place = axes.map(|axis| dot(axis, minus(point, centre)).abs());
                norm([0, 1, 2].map(|k| (place[k] - half[k]).max(0.0)))
            }
            _ => f64::INFINITY,
        };
        assert!(hull.points.iter().all(|&point| outside(point) <= both + 1e-9));
        for direction in sphere(800) {
            let on_surface = match found {
                Primitive::Ball { centre, radius } => vec![moved(centre, radius, direction)],
                Primitive::Capsule { ends, radius } => {
                    ends.map(|end| moved(end, radius, direction)).to_vec()
                }
                Primitive::Cuboid { centre, axes, half } => {
                    let place = [0, 1, 2].map(|k| (1.5 * direction[k]).clamp(-1.0, 1.0) * half[k]);
                    vec![moved(centre, 1.0, combined(place, axes))]
                }
                _ => vec![],
            };
            assert!(on_surface.iter().all(|&point| solid.outside(point) <= both + 1e-9));
        }
    }
}

/// Points of a body, or of one that is hardly thicker than the tolerance in one direction or two.
fn thin_set() -> impl Strategy<Value = Vec<Point>> {
    let thickness = || prop_oneof![Just(1.0), Just(1e-3), Just(1e-5), Just(1e-6), Just(3e-7)];
    let points = prop::collection::vec(prop::array::uniform3(awkward_coordinate()), 8..60);
    (points, thickness(), thickness(), 0.0..3.0).prop_map(|(points, thin, thinner, angle)| {
        let (sin, cos) = f64::sin_cos(angle);
        let turned = |[x, y, z]: Point| [cos * x - sin * y, sin * x + cos * y, z + 0.3 * x];
        points.iter().map(|&[x, y, z]| turned([x, thin * y, thinner * z])).collect()
    })
}

proptest! {
    // The same cases in every run: what fails here fails everywhere. Of 600,000 others of the third
    // promise none is torn or not convex; 1 leaves a point out by more than the tolerance (2 and 16
    // with the tolerances like rounding errors).
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(1), ..ProptestConfig::with_cases(400) })]

    #[test]
    fn every_hull_is_convex_closed_and_holds_its_points(
        points in prop::collection::vec(prop::array::uniform3(awkward_coordinate()), 4..120)
    ) {
        if let Ok(hull) = convex_hull(&points) {
            check(&hull, &points);
        }
    }

    #[test]
    fn every_hull_that_grew_is_convex_closed_and_holds_its_points(
        points in prop::collection::vec(prop::array::uniform3(awkward_coordinate()), 8..80),
        first in 4usize..40,
    ) {
        let mut builder = HullBuilder::new();
        let first = first.min(points.len());
        if builder.build(&points[..first]) == Shape::Solid {
            builder.insert(&points[first..]);
            check(&builder.extract().into(), &points);
        }
    }

    /// With tolerances down to rounding errors too, where it once didn't end.
    #[test]
    fn a_hull_that_grows_in_small_steps_ends_and_holds_what_one_built_anew_holds(
        points in thin_set(),
        first in 4usize..20,
        step in 1usize..6,
        tolerance in prop_oneof![Just(DEFAULT_TOLERANCE), Just(1e-10), Just(1e-14)],
    ) {
        let mut builder = HullBuilder::new().with_tolerance(tolerance);
        let first = first.min(points.len());
        if builder.build(&points[..first]) == Shape::Solid {
            for chunk in points[first..].chunks(step) {
                builder.insert(chunk);
            }
            let grown = ConvexHull::from(builder.extract());
            check_closed(&grown);
            let size = diagonal(&points);
            // The tolerance is that of the first points, whose extent is at most the whole.
            let outside = worst_outside(&grown, &points);
            prop_assert!(outside <= DEFAULT_TOLERANCE * size * 1.01, "outside by {}", outside / size);
            if let Ok(anew) = convex_hull(&points) {
                let area: f64 = anew.corners().map(area).sum();
                let difference = (anew.volume() - grown.volume()).abs();
                prop_assert!(difference <= 2.0 * DEFAULT_TOLERANCE * size * area, "{difference}");
            }
        }
    }

    #[test]
    fn every_set_of_points_gets_a_body(
        points in prop::collection::vec(prop::array::uniform3(awkward_coordinate()), 1..40),
        flatten in prop::array::uniform3(prop::bool::ANY),
    ) {
        let points: Vec<Point> = points
            .iter()
            .map(|p| [0, 1, 2].map(|axis| if flatten[axis] { 0.5 } else { p[axis] }))
            .collect();
        let mut builder = HullBuilder::new();
        let (hull, _) = solid_hull(&mut builder, &points, [0.0, 0.0, 1.0], 1e-3).unwrap();
        prop_assert!(hull.volume() > 0.0);
        prop_assert!(worst_outside(&hull, &points) <= 2.0 * DEFAULT_TOLERANCE * 14.0);
    }
}
