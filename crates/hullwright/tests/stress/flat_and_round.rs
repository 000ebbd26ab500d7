//! Very many points in a plane, on a circle, on a sphere: every sign of a determinant is in doubt.

use std::f64::consts::{PI, TAU};

use hullwright::{ConvexHull, convex_hull};

use crate::common::{Mesh, Random, lathe};
use crate::independent::exact::{Faults, faults};
use crate::{assert_sound, placed};

/// The hull of points, which is exactly convex.
fn exact_hull(points: &[[f64; 3]]) -> ConvexHull {
    let hull = convex_hull(points).unwrap();
    assert_eq!(faults(&hull.points, &hull.triangles), Faults::default());
    hull
}

/// A flat side that is askew, so that none of its points is exactly in its plane, and of a million
/// points.
#[test]
fn a_million_coplanar_points_are_the_corners_of_a_pyramid() {
    const SIDE: usize = 1000;
    let mut points = vec![[0.2, 0.3, 2.0]];
    points.extend((0..SIDE * SIDE).map(|index| {
        let [x, y] = [index % SIDE, index / SIDE].map(|k| k as f64 / (SIDE - 1) as f64);
        [x, y, (0.3 * x - 0.7 * y) / 3.0]
    }));
    assert_eq!(exact_hull(&points).points.len(), 5);
    let rounded: Vec<[f64; 3]> = points.iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
    let corners = exact_hull(&rounded).points.len();
    assert!(corners < 20, "{corners}");
}

/// A box whose lid is askew and of so many triangles in a plane.
fn box_with_a_fine_lid(side: u32) -> Mesh {
    let at = |i: u32, j: u32, top: u32| (i * (side + 1) + j) * 2 + top;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..=side {
        for j in 0..=side {
            let (x, y) = (f64::from(i) / f64::from(side), f64::from(j) / f64::from(side));
            positions.extend([[x, y, 0.0], [x, y, 1.0 + 0.123 * x + 0.456 * y]]);
        }
    }
    for i in 0..side {
        for j in 0..side {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let [a, b, c, d] = corners.map(|(i, j)| at(i, j, 1));
            triangles.extend([[a, b, c], [a, c, d]]);
            let [a, b, c, d] = corners.map(|(i, j)| at(i, j, 0));
            triangles.extend([[a, c, b], [a, d, c]]);
        }
        let mut wall = |from: (u32, u32), to: (u32, u32)| {
            let [a, b] = [from, to].map(|(i, j)| at(i, j, 0));
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        };
        wall((i, 0), (i + 1, 0));
        wall((side, i), (side, i + 1));
        wall((side - i, side), (side - i - 1, side));
        wall((0, side - i), (0, side - i - 1));
    }
    (positions, triangles)
}

/// Fifty thousand triangles in two planes: the hull has eight corners, and no sliver from rounding.
#[test]
fn a_box_with_tens_of_thousands_of_coplanar_triangles_is_one_hull_of_eight_corners() {
    let found = assert_sound("box", &box_with_a_fine_lid(112));
    assert_eq!(found.hulls.len(), 1);
    assert_eq!(found.hulls[0].shape.points.len(), 8);
}

fn regular_prism(sides: u32, turn: f64) -> Mesh {
    let rim = |z: f64| {
        (0..sides).map(move |side| {
            let angle = TAU * f64::from(side) / f64::from(sides) + turn;
            [angle.cos(), angle.sin(), z]
        })
    };
    let positions = rim(0.0).chain(rim(1.0)).collect();
    let mut triangles = Vec::new();
    for a in 0..sides {
        let b = (a + 1) % sides;
        triangles.extend([[a, b, b + sides], [a, b + sides, a + sides]]);
        if a > 1 {
            triangles.extend([[0, a, a - 1], [sides, sides + a - 1, sides + a]]);
        }
    }
    (positions, triangles)
}

/// Four points of a rim are on a circle, and four of a wall in a plane: no choice is better than
/// the other.
#[test]
fn prisms_of_up_to_4096_sides_are_one_hull() {
    for sides in [3, 17, 64, 512, 4096] {
        for turn in [0.0, 0.1] {
            let mesh = regular_prism(sides, turn);
            let hull = exact_hull(&mesh.0);
            if sides <= 512 {
                assert_eq!(hull.points.len() as u32, 2 * sides);
            }
            let found = assert_sound(&format!("{sides} sides"), &mesh);
            assert_eq!(found.hulls.len(), 1, "{sides} sides");
        }
    }
}

/// All points of a ball are corners; their planes are as close as they can be.
#[test]
fn tens_of_thousands_of_cospherical_points_have_an_exact_hull() {
    let mut random = Random(7);
    for count in [100, 1_000, 20_000] {
        let points: Vec<[f64; 3]> = (0..count)
            .map(|_| {
                let (z, angle) = (random.signed(), PI * random.signed());
                let radius = (1.0 - z * z).sqrt();
                [radius * angle.cos(), radius * angle.sin(), z].map(|x| f64::from(x as f32))
            })
            .collect();
        let hull = convex_hull(&points).unwrap();
        let some = &hull.triangles;
        assert_eq!(hull.points.len() + some.len(), some.len() * 3 / 2 + 2, "Euler's formula");
        if count <= 1_000 {
            assert_eq!(faults(&hull.points, &hull.triangles), Faults::default(), "{count}");
            assert_eq!(hull.points.len(), count);
        }
    }
}

/// Quads of a lathe are coplanar except for rounding, so that flat and curved can not be told
/// apart.
#[test]
fn a_ring_of_coplanar_quads_at_any_turn_keeps_the_promise() {
    let ring = lathe(&[[0.7, 0.0], [1.0, 0.0], [1.0, 0.3], [0.7, 0.3]], 48);
    let counts: Vec<usize> = [0.0, 0.1, 1.0, 2.0]
        .iter()
        .map(|turn| {
            let (sin, cos) = f64::sin_cos(*turn);
            let turned = placed(&ring, |[x, y, z]| [cos * x - sin * z, y, sin * x + cos * z]);
            assert_sound("ring", &turned).hulls.len()
        })
        .collect();
    assert!(counts.iter().all(|count| count.abs_diff(counts[0]) <= 3), "{counts:?}");
}
