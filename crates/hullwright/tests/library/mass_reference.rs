//! Volume, centre and inertia against closed forms: of any tetrahedron, of boxes anywhere and at
//! any turn, and of stretched balls.

use std::f64::consts::PI;

use hullwright::{MassProperties, MassSource, MeshView, convex_hull, mass_properties};

use crate::common::{Point, Random};

type Matrix = [[f64; 3]; 3];

fn of(positions: &[Point], triangles: &[[u32; 3]], density: f64) -> MassProperties {
    mass_properties(MeshView::new(positions, triangles), &[], density).unwrap()
}

fn assert_inertia(name: &str, found: Matrix, expected: Matrix, share: f64) {
    let size = expected.as_flattened().iter().map(|x| x.abs()).fold(0.0, f64::max);
    for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
        assert!((found - expected).abs() <= share * size, "{name}: {found} {expected}");
    }
}

/// The tensor of inertia from the second moments around the centre.
fn inertia(moments: Matrix) -> Matrix {
    let trace = moments[0][0] + moments[1][1] + moments[2][2];
    [0, 1, 2]
        .map(|i| [0, 1, 2].map(|j| if i == j { trace - moments[i][i] } else { -moments[i][j] }))
}

/// Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor", 2004, around the
/// centre.
#[test]
fn any_tetrahedron_has_the_mass_centre_and_inertia_of_its_formula() {
    let mut random = Random(1);
    for round in 0..300 {
        let far = if round % 3 == 0 { 50.0 } else { 0.0 };
        let offset = random.point().map(|x| far * x);
        let corners: Vec<Point> = (0..4)
            .map(|_| {
                let point = random.point();
                [0, 1, 2].map(|k| point[k] + offset[k])
            })
            .collect();
        let hull = convex_hull(&corners).unwrap();
        let [a, b, c, d] = [0, 1, 2, 3].map(|index| corners[index]);
        let edge = |to: Point| [0, 1, 2].map(|k| to[k] - a[k]);
        let [u, v, w] = [edge(b), edge(c), edge(d)];
        let determinant = u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0])
            + u[2] * (v[0] * w[1] - v[1] * w[0]);
        let volume = determinant.abs() / 6.0;
        if volume < 1e-3 {
            continue;
        }
        assert!((hull.volume() - volume).abs() < 1e-12 * volume.max(1.0), "{round}");
        let found = of(&hull.points, &hull.triangles, 2.5);
        let mass = 2.5 * volume;
        assert!((found.mass - mass).abs() < 1e-9 * mass, "{round}: {} {mass}", found.mass);
        let centre = [0, 1, 2].map(|k| (a[k] + b[k] + c[k] + d[k]) / 4.0);
        assert!((0..3).all(|k| (found.centre[k] - centre[k]).abs() < 1e-9), "{round}");
        let arms = corners.iter().map(|p| [0, 1, 2].map(|k| p[k] - centre[k]));
        let moments = arms.fold(Matrix::default(), |sum, arm| {
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| sum[i][j] + mass / 20.0 * arm[i] * arm[j]))
        });
        assert_inertia(&format!("round {round}"), found.inertia, inertia(moments), 1e-8);
    }
}

/// An evenly drawn turn would do no better than any that mixes all axes.
fn turn([x, y, z]: Point, angle: f64) -> Point {
    let (s, c) = angle.sin_cos();
    let [x, y] = [c * x - s * y, s * x + c * y];
    let [y, z] = [c * y - s * z, s * y + c * z];
    [x, y, z]
}

#[test]
fn a_box_at_any_turn_has_the_inertia_of_its_sides() {
    let mut random = Random(2);
    for round in 0..100 {
        let sides = random.point().map(|x| 0.1 + x.abs());
        let angle = 3.0 * random.signed();
        let place = random.point().map(|x| 20.0 * x);
        let corners: Vec<Point> = (0..8)
            .map(|index| {
                let corner = [0, 1, 2].map(|k| sides[k] * (f64::from(index >> k & 1) - 0.5));
                let turned = turn(corner, angle);
                [0, 1, 2].map(|k| turned[k] + place[k])
            })
            .collect();
        let hull = convex_hull(&corners).unwrap();
        let found = of(&hull.points, &hull.triangles, 1.0);
        assert_eq!(found.source, MassSource::Mesh);
        let mass = sides.iter().product::<f64>();
        assert!((found.mass - mass).abs() < 1e-9 * mass, "{round}");
        // Axes of the box, as they are turned.
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|a| turn(a, angle));
        let moments = [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| {
                (0..3).map(|k| mass * sides[k] * sides[k] / 12.0 * axes[k][i] * axes[k][j]).sum()
            })
        });
        assert_inertia(&format!("round {round}"), found.inertia, inertia(moments), 1e-8);
    }
}

/// A ball of many faces, stretched by three factors: 4/3 π abc, and a fifth of the mass times sums
/// of squares.
#[test]
fn an_ellipsoid_of_many_faces_is_within_a_hundredth_of_its_formula() {
    let radii = [1.0, 0.4, 2.5];
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let points: Vec<Point> = (0..2000)
        .map(|index| {
            let z = 1.0 - (f64::from(index) + 0.5) / 1000.0;
            let (angle, radius) = (golden * f64::from(index), (1.0 - z * z).sqrt());
            let point = [radius * angle.cos(), radius * angle.sin(), z];
            [0, 1, 2].map(|k| radii[k] * point[k])
        })
        .collect();
    let hull = convex_hull(&points).unwrap();
    let found = of(&hull.points, &hull.triangles, 1.0);
    let mass = 4.0 / 3.0 * PI * radii.iter().product::<f64>();
    assert!((found.mass / mass - 1.0).abs() < 0.01, "{} {mass}", found.mass);
    let squares = radii.map(|r| r * r);
    let expected = [squares[1] + squares[2], squares[0] + squares[2], squares[0] + squares[1]];
    for (k, square) in expected.into_iter().enumerate() {
        assert!((found.inertia[k][k] / (0.2 * mass * square) - 1.0).abs() < 0.01, "{k}");
    }
}
