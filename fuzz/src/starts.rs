//! Inputs to begin with: bytes of which the targets make solids, sheets and hard sets of points. By
//! chance bytes are a heap of loose triangles, which seldom reaches the stages behind the first.
//!
//! `FUZZ_STARTS=1 cargo test --package hullwright --test fuzz_corpus starts` writes them where
//! `fuzz/run` begins.

use std::f64::consts::{PI, TAU};

/// Vertices and triangles.
type Shape = (Vec<[f64; 3]>, Vec<[u8; 3]>);

/// A target's name, and bytes for it.
pub fn starts() -> Vec<(&'static str, Vec<u8>)> {
    let mut starts = Vec::new();
    for shape in shapes() {
        for (index, parameters) in PARAMETERS.iter().enumerate() {
            // Each in one way more than it has parameters, so that in the end each is in every way.
            let place = PLACES[(starts.len() + index) % PLACES.len()];
            starts.push(("soup", soup(&shape, parameters, place)));
        }
    }
    for points in point_sets() {
        for tolerance in [0_u8, 3, 5] {
            starts.push(("hull", hull(&points, tolerance)));
        }
    }
    starts
}

/// What `shapes::parameters` reads: paper's method, preset, bound, openings, cavities, cap on
/// hulls, cap on vertices; 0 of a ratio is yes, and 1 is no.
const PARAMETERS: &[&[u8]] = &[
    &[1, 0, 0, 0, 1, 1, 1],
    &[1, 1, 1, 0, 1, 1, 1],
    &[1, 2, 0, 1, 0, 1, 1],
    &[1, 0, 2, 2, 1, 0, 1, 1],
    &[1, 0, 1, 0, 1, 1, 0, 2],
    &[0, 0, 0, 0, 1, 1, 1],
];

/// What `points::points` reads before the number of points: thinness, scale, offset. A mesh as it
/// is, and those that are thin, tiny, huge, far away.
const PLACES: &[[u8; 3]] =
    &[[0, 0, 0], [0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 5, 0], [0, 0, 3], [3, 0, 2]];

/// Kinds of `points::points`.
const BITS: u8 = 2;
const FINE: u8 = 3;

fn soup((positions, triangles): &Shape, parameters: &[u8], place: [u8; 3]) -> Vec<u8> {
    assert!(positions.len() <= 40 && triangles.len() <= 80, "more than the target takes");
    let mut bytes = parameters.to_vec();
    bytes.push(triangles.len() as u8 - 1);
    bytes.push(positions.len() as u8 - 3);
    bytes.extend(triangles.as_flattened());
    bytes.push(if place == [0; 3] { BITS } else { FINE });
    bytes.extend(place);
    encode(&mut bytes, positions);
    bytes
}

fn hull(points: &[[f64; 3]], tolerance: u8) -> Vec<u8> {
    assert!(points.len() <= 80, "more than the target takes");
    // Inserted by threes, after the first ten.
    let mut bytes = vec![tolerance, 2, 6, BITS, 0, 0, 0];
    encode(&mut bytes, points);
    bytes
}

/// The kind is the fourth byte from the end.
fn encode(bytes: &mut Vec<u8>, positions: &[[f64; 3]]) {
    let is_fine = bytes[bytes.len() - 4] == FINE;
    bytes.push(positions.len() as u8 - 1);
    for x in positions.as_flattened() {
        if is_fine {
            bytes.extend(((x * 8192.0).round() as i16).to_le_bytes());
        } else {
            bytes.extend((*x as f32).to_le_bytes());
        }
    }
}

/// Few triangles each, and between them every stage: convex, cut along planes, round, hollow, open,
/// one-sided, doubled, touching.
fn shapes() -> Vec<Shape> {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let unit = prism(&square, &[[0, 1, 2], [0, 2, 3]], 1.0);
    let small = moved(&unit, 0.5, [0.25; 3]);
    let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let l_fill = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let u = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    let u_fill = [[0, 5, 6], [0, 6, 7], [0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]];
    let star: Vec<[f64; 2]> = (0..14)
        .map(|i| {
            let (angle, radius) = (f64::from(i) * PI / 7.0, [1.0, 0.45][i as usize % 2]);
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let fan: Vec<[u8; 3]> = (1..7)
        .map(|i| [1, 2 * i - 1, 2 * i + 1])
        .filter(|t| t[1] != 1)
        .chain((0..7).map(|i| [2 * i + 1, (2 * i + 2) % 14, (2 * i + 3) % 14]))
        .collect();
    let torus = surface(6, 6, [true, true], |u, v| {
        let radius = 1.0 + 0.35 * (TAU * v).cos();
        [radius * (TAU * u).cos(), radius * (TAU * u).sin(), 0.35 * (TAU * v).sin()]
    });
    let ring = surface(6, 3, [true, true], |u, v| {
        let radius = 0.8 + 0.2 * (TAU * v).cos();
        [radius * (TAU * u).cos(), radius * (TAU * u).sin(), 0.2 * (TAU * v).sin()]
    });
    let other_ring = map(&moved(&ring, 1.0, [0.8, 0.0, 0.0]), |[x, y, z]| [x, z, y]);
    let bowl = surface(8, 5, [true, false], |u, v| {
        let (around, down) = (TAU * u, 0.3 + 1.2 * v);
        [down.sin() * around.cos(), down.sin() * around.sin(), -down.cos()]
    });
    let waves = surface(6, 6, [false, false], |u, v| {
        [2.0 * u, 2.0 * v, 0.3 * (9.0 * u).sin() * (7.0 * v).cos()]
    });
    let tube = surface(8, 2, [true, false], |u, v| [(TAU * u).cos(), (TAU * u).sin(), 3.0 * v]);
    let moebius = surface(12, 3, [true, false], |u, v| {
        let (turn, across) = (TAU * u, v - 0.5);
        let radius = 1.0 + across * (turn / 2.0).cos();
        [radius * turn.cos(), radius * turn.sin(), across * (turn / 2.0).sin()]
    });
    let ball = map(&bowl, |[x, y, z]| [x, y, z + 0.3 * (4.0 * x).sin()]);
    let mut shapes = vec![
        joined(&unit, &moved(&unit, 1.0, [1.0, 1.0, 0.0])),
        joined(&unit, &moved(&unit, 1.0, [0.5, 0.3, 0.2])),
        joined(&unit, &moved(&unit, 1.0, [1.5, 0.0, 0.0])),
        joined(&unit, &small),
        joined(&unit, &turned(&small)),
        joined(&unit, &turned(&unit)),
        joined(&ring, &other_ring),
        turned(&unit),
        (unit.0.clone(), unit.1[..10].to_vec()),
        (unit.0.clone(), unit.1[4..].to_vec()),
        prism(&l, &l_fill, 1.0),
        prism(&l, &l_fill, 0.02),
        prism(&u, &u_fill, 1.0),
        prism(&star, &fan, 0.4),
    ];
    shapes.extend([torus, bowl, waves, tube, moebius, ball, unit]);
    // As they stand, and at a turn, where no plane is along an axis.
    let turn = |shape: &Shape| {
        map(shape, |[x, y, z]| {
            [0.8 * x - 0.6 * y, 0.48 * x + 0.64 * y - 0.6 * z, 0.36 * x + 0.48 * y + 0.8 * z]
        })
    };
    let leaning: Vec<Shape> = shapes.iter().map(turn).collect();
    shapes.into_iter().chain(leaning).collect()
}

/// An outline, filled, pulled along the axis of heights.
fn prism(outline: &[[f64; 2]], fill: &[[u8; 3]], height: f64) -> Shape {
    let count = outline.len() as u8;
    let at = |z: f64| outline.iter().map(move |&[x, y]| [x, y, z]);
    let positions = at(0.0).chain(at(height)).collect();
    let mut triangles: Vec<[u8; 3]> = fill.iter().map(|&[a, b, c]| [a, c, b]).collect();
    triangles.extend(fill.iter().map(|triangle| triangle.map(|v| v + count)));
    for a in 0..count {
        let b = (a + 1) % count;
        triangles.extend([[a, b, b + count], [a, b + count, a + count]]);
    }
    (positions, triangles)
}

/// A grid over a function of shares, closed in the directions that say so.
fn surface(n: u8, m: u8, is_closed: [bool; 2], at: impl Fn(f64, f64) -> [f64; 3]) -> Shape {
    let steps = |count: u8, is_closed: bool| if is_closed { count } else { count - 1 };
    let [rows, columns] = [steps(n, is_closed[0]), steps(m, is_closed[1])];
    let share = |i: u8, of: u8| f64::from(i) / f64::from(of);
    let cells = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let positions = cells.map(|(i, j)| at(share(i, rows), share(j, columns))).collect();
    let vertex = |i: u8, j: u8| (i % n) * m + j % m;
    let mut triangles = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let [a, b] = [vertex(i, j), vertex(i + 1, j)];
            let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions, triangles)
}

fn map((positions, triangles): &Shape, to: impl Fn([f64; 3]) -> [f64; 3]) -> Shape {
    (positions.iter().map(|&point| to(point)).collect(), triangles.clone())
}

fn moved(shape: &Shape, scale: f64, by: [f64; 3]) -> Shape {
    map(shape, |point| [0, 1, 2].map(|k| point[k] * scale + by[k]))
}

fn turned((positions, triangles): &Shape) -> Shape {
    (positions.clone(), triangles.iter().map(|&[a, b, c]| [b, a, c]).collect())
}

fn joined(first: &Shape, second: &Shape) -> Shape {
    let count = first.0.len() as u8;
    let further = second.1.iter().map(|triangle| triangle.map(|v| v + count));
    ([first.0.clone(), second.0.clone()].concat(), first.1.iter().copied().chain(further).collect())
}

/// Grids, prisms, spheres and planes, and each with every point moved by about a tolerance.
fn point_sets() -> Vec<Vec<[f64; 3]>> {
    let grid = (0..64).map(|i| [i % 4, i / 4 % 4, i / 16].map(f64::from)).collect();
    let prism = (0..80)
        .map(|i| {
            let angle = TAU * f64::from(i / 2) / 40.0;
            [angle.cos(), angle.sin(), f64::from(i % 2)]
        })
        .collect();
    let sphere = (0..80)
        .map(|i| {
            // A spiral from pole to pole.
            let (height, angle) = (1.0 - f64::from(i) / 39.5, 2.4 * f64::from(i));
            let radius = (1.0_f64 - height * height).max(0.0).sqrt();
            [radius * angle.cos(), radius * angle.sin(), height]
        })
        .collect();
    let plane = (0..70)
        .map(|i| [f64::from(i * 7 % 11), f64::from(i * 5 % 13), f64::from(u8::from(i == 9))])
        .collect();
    // Two planes that meet at a sharp edge: what is between them is thin.
    let wedge = (0..80)
        .map(|i| {
            let [x, y] = [f64::from(i * 7 % 17) / 16.0, f64::from(i * 11 % 19) / 18.0];
            [x, y, x * f64::from(i % 2) * 1e-5]
        })
        .collect();
    let cone = (0..60)
        .map(|i| {
            let (angle, height) = (TAU * f64::from(i % 12) / 12.0, f64::from(i / 12));
            [height * angle.cos(), height * angle.sin(), 4.0 - height]
        })
        .collect();
    let sets: Vec<Vec<[f64; 3]>> = vec![grid, prism, sphere, plane, wedge, cone];
    let noise = |size: f64| {
        move |set: &Vec<[f64; 3]>| {
            let mut step = 0;
            set.iter()
                .map(|point| {
                    point.map(|x| {
                        step = (step * 37 + 11) % 101;
                        x + size * (f64::from(step) / 50.0 - 1.0)
                    })
                })
                .collect()
        }
    };
    [0.0, 1e-7, 1e-6, 1e-4].iter().flat_map(|&size| sets.iter().map(noise(size))).collect()
}
