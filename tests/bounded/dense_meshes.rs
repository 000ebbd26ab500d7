//! Meshes of more than 100,000 triangles, which are searched through reduced ones.

use crate::common::{CUP_PROFILE, Mesh, cuboid, finely, join, lathe};
use crate::judge::{assert_promise, contains, lost, report, run};

/// A cup with a wavy rim, and beside it a ribbon narrower than a tenth of the bound.
fn fine_cup() -> Mesh {
    let mut cup = lathe(&finely(&CUP_PROFILE, 40), 240);
    for [x, y, z] in &mut cup.0 {
        *z += 0.02 * *z * (7.0 * y.atan2(*x)).sin();
    }
    join(&[cup, cuboid([1.3, -0.5, 0.0], [1.305, 0.5, 0.002])])
}

#[test]
fn the_promise_holds_and_no_triangle_is_lost() {
    let mesh = fine_cup();
    let result = run(&mesh);
    let report = report(&result);
    assert!(mesh.1.len() > 100_000 && report.polygons < 10_000);
    assert_promise("fine cup", &mesh, &result);
    assert!(report.uncovered_max <= 0.1 * report.bound, "{report:?}");
    assert!(result.hulls.len() <= 20, "{}", result.hulls.len());
    assert!(!result.hulls.iter().any(|hull| contains(hull, [0.3, 0.0, 1.0])), "the cup is filled");
    assert_eq!(lost(&mesh, &result), None);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| run(&mesh).hulls), result.hulls);
}

#[test]
fn no_long_triangle_is_lost() {
    // A drum of thin staves, which refinement leaves long, and beside it, flush with its top, a
    // dense ring.
    let drum = lathe(&[[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]], 13_000);
    let profile = [[0.001, 0.6], [0.3, 0.6], [0.3, 1.0], [0.001, 1.0]];
    let mut brick = lathe(&finely(&profile, 400), 120);
    brick.0.iter_mut().for_each(|point| point[0] += 1.305);
    let mesh = join(&[brick, drum]);
    let result = run(&mesh);
    let report = report(&result);
    assert!(report.protrusion_max <= report.bound && report.uncovered_max <= 0.1 * report.bound);
    assert_eq!(result.hulls.len(), 2);
    let volume: f64 = result.hulls.iter().map(|hull| hull.shape.volume()).sum();
    let expected = std::f64::consts::PI * (2.0 + 0.4 * 0.3 * 0.3);
    assert!((volume - expected).abs() < 0.02 * expected, "{volume}");
    assert_eq!(lost(&mesh, &result), None);
}
