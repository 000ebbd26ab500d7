use super::closest_point::closest_point_on_triangle;
use super::*;
use crate::geometry::vector::Vector;
use std::f64::consts::TAU;

type Mesh = (Vec<Vector>, Vec<[u32; 3]>);

/// SplitMix64: evenly spread numbers from 0 to 1.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A point of a cube of this size around the origin.
    fn point(&mut self, size: f64) -> Vector {
        Vector::from_array([(); 3].map(|()| size * (self.number() - 0.5)))
    }
}

/// Triangles anywhere, of sizes from 1e-6 to 1, with slivers, needles and points among them.
fn soup(triangles: usize, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let mut mesh = Mesh::default();
    for triangle in 0..triangles {
        let a = random.point(1.0);
        let size = 10_f64.powf(-6.0 * random.number());
        let (b, mut c) = (a + random.point(size), a + random.point(size));
        match triangle % 10 {
            // Collinear up to 1e-9 of its size, exactly, and with no length at all.
            7 => c = a + (b - a) * 0.3 + random.point(1e-9 * size),
            8 => c = a + (b - a) * 2.0,
            9 => c = a,
            _ => {}
        }
        let first = mesh.0.len() as u32;
        mesh.0.extend([a, b, c]);
        mesh.1.push([first, first + 1, first + 2]);
    }
    mesh
}

/// A cube with corners at ±`half`, its faces in pairs of triangles.
fn cube(half: f64) -> Mesh {
    let corner = |index: u32, axis: u32| if index >> axis & 1 == 1 { half } else { -half };
    let positions =
        (0..8).map(|index| Vector::from_array([0, 1, 2].map(|axis| corner(index, axis)))).collect();
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (positions, triangles)
}

/// A closed torus of 2 n² triangles.
fn torus(n: u32) -> Mesh {
    let angle = |index: u32| TAU * f64::from(index) / f64::from(n);
    let mut mesh = Mesh::default();
    for (i, j) in (0..n * n).map(|index| (index / n, index % n)) {
        let radius = 0.3 + 0.1 * angle(j).cos();
        mesh.0.push(Vector::new(
            radius * angle(i).cos(),
            radius * angle(i).sin(),
            0.1 * angle(j).sin(),
        ));
        let vertex = |i: u32, j: u32| i % n * n + j % n;
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        mesh.1.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

fn join(mut mesh: Mesh, other: &Mesh) -> Mesh {
    let first = mesh.0.len() as u32;
    mesh.0.extend(&other.0);
    mesh.1.extend(other.1.iter().map(|triangle| triangle.map(|index| first + index)));
    mesh
}

fn flipped(mut mesh: Mesh) -> Mesh {
    mesh.1.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    mesh
}

fn bvh((positions, triangles): &Mesh) -> Bvh {
    Bvh::new(positions, triangles)
}

fn corners((positions, _): &Mesh, triangle: [u32; 3], origin: Vector) -> [Vector; 3] {
    triangle.map(|index| positions[index as usize] - origin)
}

/// Squared distance and index of the nearest triangle, over all triangles.
fn nearest_of_all(mesh: &Mesh, point: Vector) -> (f64, u32) {
    let mut best = (f64::INFINITY, u32::MAX);
    for (index, &triangle) in mesh.1.iter().enumerate() {
        let [a, b, c] = corners(mesh, triangle, point);
        let squared = closest_point_on_triangle(a, b, c).length_squared();
        if squared < best.0 {
            best = (squared, index as u32);
        }
    }
    best
}

/// The winding number as a sum of all solid angles.
fn winding_number_of_all(mesh: &Mesh, point: Vector) -> f64 {
    let halves = mesh.1.iter().map(|&triangle| {
        let [a, b, c] = corners(mesh, triangle, point);
        let [of_a, of_b, of_c] = [a, b, c].map(Vector::length);
        let real = of_a * of_b * of_c + a.dot(b) * of_c + b.dot(c) * of_a + c.dot(a) * of_b;
        a.dot(b.cross(c)).atan2(real)
    });
    halves.sum::<f64>() / TAU
}

/// Points near the mesh, in its box, far away, and on its vertices.
fn questions(mesh: &Mesh, count: usize) -> Vec<Vector> {
    let mut random = Random(7);
    (0..count)
        .map(|index| {
            let vertex = mesh.0[(random.number() * mesh.0.len() as f64) as usize];
            match index % 4 {
                0 => vertex + random.point(0.02),
                1 => random.point(1.5),
                2 => random.point(100.0),
                _ => vertex,
            }
        })
        .collect()
}

#[test]
fn the_nearest_point_of_a_triangle_lies_in_each_of_its_seven_regions() {
    let [a, b, c] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Vector::from);
    for (point, expected) in [
        (Vector::new(0.25, 0.25, 2.0), Vector::new(0.25, 0.25, 0.0)),
        (Vector::new(-1.0, -1.0, 1.0), a),
        (Vector::new(3.0, -0.5, 1.0), b),
        (Vector::new(-0.5, 3.0, 1.0), c),
        (Vector::new(0.5, -1.0, 1.0), Vector::new(0.5, 0.0, 0.0)),
        (Vector::new(-1.0, 0.5, 1.0), Vector::new(0.0, 0.5, 0.0)),
        (Vector::new(1.0, 1.0, 1.0), Vector::new(0.5, 0.5, 0.0)),
    ] {
        let [p, q, r] = [a, b, c].map(|corner| corner - point);
        for [p, q, r] in [[p, q, r], [q, r, p], [r, p, q], [q, p, r]] {
            let nearest = closest_point_on_triangle(p, q, r) + point;
            assert!(nearest.distance(expected) < 1e-12, "{point:?} {nearest:?}");
        }
    }
}

#[test]
fn the_nearest_point_of_a_sliver_is_as_good_as_its_edges() {
    let (a, b) = (Vector::ZERO, Vector::X);
    for height in [1e-5, 1e-9, 1e-14, 0.0] {
        let c = Vector::new(0.5, height, 0.0);
        for point in [[0.3, 0.2, 0.1], [0.5, -0.1, 0.0], [1.4, 0.0, 0.3], [0.5, height / 3.0, 0.2]]
            .map(Vector::from)
        {
            let [p, q, r] = [a, b, c].map(|corner| corner - point);
            let on_line = Vector::new(point[0].clamp(0.0, 1.0), 0.0, 0.0);
            for [p, q, r] in [[p, q, r], [q, r, p], [r, p, q]] {
                let found = closest_point_on_triangle(p, q, r).length();
                let expected = on_line.distance(point);
                assert!((found - expected).abs() <= height + 1e-12, "{height} {point:?} {found}");
            }
        }
    }
}

#[test]
fn distance_equals_the_minimum_over_all_triangles() {
    for mesh in [soup(400, 1), soup(3, 2), torus(20), cube(0.3), join(torus(9), &torus(9))] {
        let bvh = bvh(&mesh);
        for point in questions(&mesh, 400) {
            let (squared, triangle) = nearest_of_all(&mesh, point);
            let closest = bvh.closest_point(point, f64::INFINITY).unwrap();
            assert_eq!((closest.distance, closest.triangle), (squared.sqrt(), triangle));
            let away = closest.point.distance(point);
            assert!((away - closest.distance).abs() <= 1e-14 * (1.0 + point.length()));
        }
    }
}

#[test]
fn distance_is_exact_far_from_the_origin_too() {
    let shift = Vector::new(3000.0, -500.0, 20.0);
    let mut mesh = soup(200, 3);
    mesh.0.iter_mut().for_each(|position| *position += shift);
    let bvh = bvh(&mesh);
    for point in questions(&mesh, 200) {
        let (squared, triangle) = nearest_of_all(&mesh, point);
        let closest = bvh.closest_point(point, f64::INFINITY).unwrap();
        assert_eq!((closest.distance, closest.triangle), (squared.sqrt(), triangle));
    }
}

#[test]
fn of_equally_near_triangles_the_first_is_nearest() {
    let mesh = cube(0.5);
    let closest = bvh(&mesh).closest_point(Vector::ZERO, f64::INFINITY).unwrap();
    assert_eq!((closest.distance, closest.triangle), (0.5, 0));
    let twice = join(mesh.clone(), &mesh);
    let corner = bvh(&twice).closest_point(Vector::new(1.0, 1.0, 1.0), f64::INFINITY).unwrap();
    assert_eq!(corner.triangle, 2);
    assert_eq!(corner.point, Vector::splat(0.5));
}

#[test]
fn a_limit_is_inclusive_and_hides_all_beyond() {
    let bvh = bvh(&cube(0.5));
    let point = Vector::new(0.75, 0.0, 0.0);
    assert_eq!(bvh.closest_point(point, 0.25).map(|closest| closest.distance), Some(0.25));
    assert_eq!(bvh.closest_point(point, 0.2499), None);
    assert_eq!(bvh.closest_point(point, -1.0), None);
    assert!(bvh.is_within(point, 0.25));
    assert!(!bvh.is_within(point, 0.2499));
    assert!(!bvh.is_within(point, -1.0));
    assert!(bvh.is_within(Vector::new(0.5, 0.1, 0.1), 0.0));
}

#[test]
fn limits_and_guesses_change_nothing_but_speed() {
    let mesh = soup(300, 4);
    let bvh = bvh(&mesh);
    for (index, point) in questions(&mesh, 300).into_iter().enumerate() {
        let closest = bvh.closest_point(point, f64::INFINITY);
        for guess in [index as u32, 0, 299, 1_000_000] {
            assert_eq!(bvh.closest_point_near(point, f64::INFINITY, guess), closest);
        }
        let distance = closest.unwrap().distance;
        assert_eq!(bvh.closest_point(point, 1.01 * distance), closest);
        assert!(bvh.is_within(point, 1.01 * distance));
        assert_eq!(bvh.is_within(point, 0.99 * distance), distance == 0.0);
        assert_eq!(
            bvh.closest_point_near(point, 0.99 * distance, index as u32).is_some(),
            distance == 0.0
        );
    }
}

#[test]
fn thousands_of_triangles_in_one_place_or_in_shrinking_steps_make_a_tree() {
    let one_place = (vec![Vector::ZERO, Vector::X, Vector::Y], vec![[0, 1, 2]; 5000]);
    let mut shrinking = Mesh::default();
    for step in 0..3000 {
        let x = 0.5_f64.powi(step / 3);
        let first = shrinking.0.len() as u32;
        shrinking.0.extend([[x, 0.0, 0.0], [x, x, 0.0], [x, 0.0, x]].map(Vector::from));
        shrinking.1.push([first, first + 1, first + 2]);
    }
    for mesh in [one_place, shrinking] {
        let bvh = bvh(&mesh);
        for point in [[0.1, 0.1, 0.3], [2.0, 0.0, 0.0], [1e-9, 1e-9, 0.0]].map(Vector::from) {
            let (squared, triangle) = nearest_of_all(&mesh, point);
            let closest = bvh.closest_point(point, f64::INFINITY).unwrap();
            assert_eq!((closest.distance, closest.triangle), (squared.sqrt(), triangle));
        }
    }
}

#[test]
fn triangles_that_can_not_be_used_are_left_out() {
    let (mut positions, mut triangles) = cube(0.5);
    positions.push(Vector::new(f64::NAN, 0.0, 0.0));
    triangles.splice(0..0, [[0, 1, 8], [0, 1, 99]]);
    let bvh = Bvh::new(&positions, &triangles);
    let closest = bvh.closest_point(Vector::new(0.6, 0.0, 0.0), f64::INFINITY).unwrap();
    assert!((closest.distance - 0.1).abs() < 1e-15);
    assert_eq!(closest.triangle, 4);
    assert!((bvh.winding_number(Vector::ZERO) - 1.0).abs() < 1e-6);
    assert_eq!(bvh.closest_point_near(Vector::new(0.6, 0.0, 0.0), f64::INFINITY, 0), Some(closest));
}

#[test]
fn a_hierarchy_over_nothing_is_nowhere_near_and_has_no_inside() {
    let bvh = Bvh::new(&[], &[]);
    assert_eq!(bvh.closest_point(Vector::ZERO, f64::INFINITY), None);
    assert!(!bvh.is_within(Vector::ZERO, f64::INFINITY));
    assert_eq!(bvh.winding_number(Vector::ZERO), 0.0);
}

#[test]
fn points_that_are_not_finite_do_not_panic() {
    let bvh = bvh(&torus(8));
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX] {
        let _ = bvh.closest_point(Vector::new(x, 0.0, 0.0), f64::INFINITY);
        let _ = bvh.closest_point(Vector::ZERO, x);
        let _ = bvh.is_within(Vector::new(x, 0.0, 0.0), 1.0);
        let _ = bvh.is_inside(Vector::new(0.0, x, 0.0));
    }
}

#[test]
fn the_winding_number_of_a_cube_is_one_inside_and_zero_outside() {
    let mesh = cube(0.3);
    let (outward, inward) = (bvh(&mesh), bvh(&flipped(mesh)));
    for inside in [[0.0; 3], [0.29, 0.29, 0.29], [-0.2999, 0.1, 0.0]].map(Vector::from) {
        assert!((outward.winding_number(inside) - 1.0).abs() < 1e-4);
        assert!((inward.winding_number(inside) + 1.0).abs() < 1e-4);
        assert!(outward.is_inside(inside) && !inward.is_inside(inside));
    }
    for outside in [[0.31, 0.0, 0.0], [0.3001, 0.3001, 0.3001], [5.0, -3.0, 2.0]].map(Vector::from)
    {
        assert!(outward.winding_number(outside).abs() < 1e-2);
        assert!(!outward.is_inside(outside));
    }
}

#[test]
fn a_missing_face_takes_its_solid_angle_away() {
    let (positions, triangles) = cube(0.3);
    let bvh = Bvh::new(&positions, &triangles[2..]);
    assert!((bvh.winding_number(Vector::ZERO) - 5.0 / 6.0).abs() < 1e-5);
    assert!(bvh.is_inside(Vector::new(0.1, 0.0, 0.0)));
    assert!(!bvh.is_inside(Vector::new(-0.31, 0.0, 0.0)));
}

#[test]
fn a_cavity_is_outside_and_an_overlap_inside_twice() {
    let with_cavity = bvh(&join(cube(0.5), &flipped(cube(0.2))));
    assert!(!with_cavity.is_inside(Vector::ZERO));
    assert!(with_cavity.is_inside(Vector::new(0.35, 0.0, 0.0)));
    let doubled = bvh(&join(cube(0.5), &cube(0.2)));
    assert!((doubled.winding_number(Vector::ZERO) - 2.0).abs() < 1e-2);
}

#[test]
fn the_hierarchy_agrees_with_the_sum_of_all_solid_angles() {
    // Half a torus is open, and a soup has cancelling triangles at all scales.
    let mut half = torus(48);
    half.1.truncate(48 * 48);
    for mesh in [torus(48), half, soup(2000, 5), join(torus(30), &cube(0.2))] {
        let bvh = bvh(&mesh);
        for point in questions(&mesh, 400).into_iter().enumerate().filter(|(i, _)| i % 4 != 3) {
            let expected = winding_number_of_all(&mesh, point.1);
            let found = bvh.winding_number(point.1);
            assert!((found - expected).abs() < 0.02, "{found} {expected}");
        }
    }
}

#[test]
fn on_the_surface_the_winding_number_is_finite() {
    let mesh = cube(0.25);
    let bvh = bvh(&mesh);
    let middle_of_edge = (mesh.0[0] + mesh.0[1]) * 0.5;
    for point in mesh.0.iter().copied().chain([
        middle_of_edge,
        Vector::new(0.25, 0.0, 0.0),
        Vector::new(0.25, 0.1, 0.2),
    ]) {
        let winding_number = bvh.winding_number(point);
        assert!((-0.01..=1.01).contains(&winding_number), "{winding_number}");
    }
}

#[test]
fn the_same_mesh_gives_the_same_bits() {
    let mesh = torus(30);
    let (one, other) = (bvh(&mesh), bvh(&mesh.clone()));
    for point in questions(&mesh, 200) {
        assert_eq!(one.winding_number(point).to_bits(), other.winding_number(point).to_bits());
        assert_eq!(one.closest_point(point, 1.0), other.closest_point(point, 1.0));
    }
}
