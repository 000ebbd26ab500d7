//! Prisms whose best division is known have that many hulls, whatever the bound, and each hull that
//! is a box has its eight vertices.

use hullwright::{Control, Length, MeshView, Parameters, decompose};

use crate::common::{Mesh, prism};

/// The bounds, as shares of the diagonal.
const BOUNDS: [f64; 4] = [0.02, 0.005, 0.001, 0.0002];

/// Fills a simple polygon, counter-clockwise, by cutting off ears.
fn ears(outline: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let turn = |a: u32, b: u32, c: u32| {
        let [a, b, c] = [a, b, c].map(|v| outline[v as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut rest: Vec<u32> = (0..outline.len() as u32).collect();
    let mut triangles = Vec::new();
    while rest.len() > 3 {
        let count = rest.len();
        let corner = |k: usize| [rest[(k + count - 1) % count], rest[k], rest[(k + 1) % count]];
        let is_ear = |&k: &usize| {
            let [a, b, c] = corner(k);
            turn(a, b, c) > 1e-12
                && rest.iter().all(|&p| {
                    [a, b, c].contains(&p)
                        || turn(a, b, p) < -1e-12
                        || turn(b, c, p) < -1e-12
                        || turn(c, a, p) < -1e-12
                })
        };
        let k = (0..count).find(is_ear).expect("a simple polygon has an ear");
        triangles.push(corner(k));
        rest.remove(k);
    }
    triangles.push([rest[0], rest[1], rest[2]]);
    triangles
}

fn solid(outline: &[[f64; 2]], height: f64) -> Mesh {
    prism(outline, &ears(outline), height)
}

fn comb(teeth: u32) -> Mesh {
    let mut outline = vec![[0.0, 0.0], [f64::from(2 * teeth - 1), 0.0]];
    for tooth in (0..teeth).rev() {
        let x = f64::from(2 * tooth);
        outline.extend([[x + 1.0, 4.0], [x, 4.0]]);
        if tooth > 0 {
            outline.extend([[x, 1.0], [x - 1.0, 1.0]]);
        }
    }
    solid(&outline, 1.0)
}

fn stairs(steps: u32) -> Mesh {
    let size = f64::from(steps);
    let mut outline = vec![[0.0, 0.0], [size, 0.0]];
    for step in 0..steps {
        let (x, y) = (size - f64::from(step), f64::from(step) + 1.0);
        outline.extend([[x, y], [x - 1.0, y]]);
    }
    outline.pop();
    outline.push([0.0, size]);
    solid(&outline, 0.5 * size)
}

/// A square frame around a square hole.
fn frame() -> Mesh {
    let square = |low: f64, high: f64| [[low, low], [high, low], [high, high], [low, high]];
    let ring: Vec<[f64; 2]> = square(0.0, 4.0).into_iter().chain(square(1.0, 3.0)).collect();
    let at = |z: f64| ring.iter().map(move |&[x, y]| [x, y, z]);
    let positions: Vec<[f64; 3]> = at(0.0).chain(at(1.0)).collect();
    let mut triangles = Vec::new();
    for a in 0..4_u32 {
        let b = (a + 1) % 4;
        let mut quad = |[p, q, r, s]: [u32; 4]| triangles.extend([[p, q, r], [p, r, s]]);
        quad([a, b, b + 8, a + 8]);
        quad([b + 4, a + 4, a + 12, b + 12]);
        quad([a + 8, b + 8, b + 12, a + 12]);
        quad([b, a, a + 4, b + 4]);
    }
    (positions, triangles)
}

#[test]
fn plain_prisms_have_the_known_number_of_hulls_at_any_bound() {
    let l = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    let t = [
        [0.0, 2.0],
        [1.0, 2.0],
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 2.0],
        [3.0, 2.0],
        [3.0, 3.0],
        [0.0, 3.0],
    ];
    let u = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [2.0, 3.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];
    let shapes: [(&str, Mesh, usize); 7] = [
        ("box", solid(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]], 1.0), 1),
        ("L", solid(&l, 1.0), 2),
        ("T", solid(&t, 1.0), 2),
        ("U", solid(&u, 1.0), 3),
        ("frame", frame(), 4),
        ("comb", comb(5), 6),
        ("stairs", stairs(6), 6),
    ];
    for (name, (positions, triangles), expected) in shapes {
        for bound in BOUNDS {
            let parameters = Parameters::default().max_error(Length::share(bound));
            let mesh = MeshView::new(&positions, &triangles);
            let result = decompose(mesh, &parameters, &Control::new()).unwrap();
            let report = result.report;
            assert!(report.protrusion_max <= report.bound, "{name} at {bound}");
            assert!(report.uncovered_max <= report.bound, "{name} at {bound}");
            assert!(result.hulls.len() <= expected, "{name} at {bound}: {}", result.hulls.len());
            if name != "stairs" {
                for hull in &result.hulls {
                    assert_eq!(hull.shape.points.len(), 8, "{name} at {bound}");
                }
            }
        }
    }
}

#[test]
fn an_open_tile_with_a_relief_is_verified_at_once() {
    // Steps without the side that nobody sees: as a closed mesh, but for the floor.
    let (positions, mut triangles) = stairs(6);
    triangles.retain(|triangle| !triangle.iter().all(|&v| positions[v as usize][1] == 0.0));
    let mesh = MeshView::new(&positions, &triangles);
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(20);
    let control = Control::new().with_deadline(deadline);
    let result = decompose(mesh, &Parameters::default(), &control).unwrap();
    let report = &result.report;
    assert!(!result.run.deadline_reached);
    assert!(report.protrusion_max <= report.bound && report.uncovered_max <= report.bound);
}
