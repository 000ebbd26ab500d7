//! The bound is kept: for every bound, every preset, and meshes of every kind, also of more than
//! 100,000 triangles, which are divided into patches through reduced ones.

use hullwright::{Decomposition, Length, Parameters, Preset};

use crate::common::{
    CUP_PROFILE, Mesh, cuboid, cup, finely, is_filled, join, lathe, open_sheet, run, run_with,
    torus, turned, u_prism,
};
use crate::{judge, promised, promised_with, with_bound};

#[test]
fn the_promise_holds_for_every_bound() {
    for percent in [0.5, 1.0, 4.0, 8.0] {
        promised_with(&format!("{percent} %"), &torus(), &with_bound(percent / 100.0));
    }
}

#[test]
fn every_preset_keeps_the_promise() {
    for preset in [Preset::Fast, Preset::Balanced, Preset::Fine] {
        promised_with(preset.name(), &cup(), &Parameters::default().with_preset(preset));
    }
}

#[test]
fn a_bound_in_units_equals_one_as_a_fraction_of_the_diagonal() {
    let mesh = u_prism();
    let relative = run(&mesh);
    let diagonal = relative.run.diagonal;
    let parameters = Parameters::default().with_max_error(Length::units(0.02 * diagonal));
    let absolute = run_with(&mesh, &parameters);
    assert!((absolute.report.bound - 0.02 * diagonal).abs() < 1e-12);
    assert_eq!(absolute.hulls, relative.hulls);
}

#[test]
fn a_box_without_a_floor_keeps_the_promise() {
    // Its inside ends where there is no surface.
    let (positions, mut triangles) = cuboid([0.0; 3], [1.0, 1.0, 0.6]);
    triangles.retain(|triangle| triangle.iter().any(|&vertex| vertex >= 4));
    promised("open box", &(positions, triangles));
}

#[test]
fn an_open_sheet_is_covered_by_thin_hulls() {
    assert!(promised("sheet", &open_sheet()).hulls.len() > 1);
}

/// Sheets nearer to each other than a cell of any grid once took minutes and hundreds of hulls.
#[test]
fn thin_sheets_close_together_stay_separate_under_a_small_bound() {
    let sheet = |low: f64, high: f64| cuboid([0.0, 0.0, low], [1.0, 1.0, high]);
    let body = cuboid([0.0, 0.0, 0.05], [0.5, 1.0, 0.5]);
    let mesh = join(&[sheet(0.0, 0.002), sheet(0.004, 0.006), body]);
    for (bound, hulls) in [(0.002, 2), (0.0005, 3)] {
        let result = promised_with("sheets", &mesh, &with_bound(bound));
        assert_eq!(result.hulls.len(), hulls, "{bound}");
    }
}

#[test]
fn the_tips_of_sharp_plates_are_covered() {
    // Beyond an edge as sharp as this, a point hardly in front of any face can be far away.
    let rim: Vec<[f64; 2]> = vec![[0.0, 0.001], [0.7, 0.0003], [1.0, 0.0], [0.7, -0.0003]];
    let lens = lathe(&[&rim[..], &[[0.0, -0.001]]].concat(), 24);
    let mut upright = turned(&lens);
    upright.0.iter_mut().for_each(|point| *point = [point[0], point[2], point[1] + 1.2]);
    let plates = join(&[lens, upright]);
    let result = promised("plates", &plates);
    let judged = judge(&plates, &result.hulls);
    assert!(judged.uncovered.max < 0.002, "{}", judged.uncovered.max);
}

/// A triangle with three different corners that no hull represents.
fn lost((positions, triangles): &Mesh, result: &Decomposition) -> Option<usize> {
    let mut is_represented = vec![false; triangles.len()];
    for &triangle in result.hulls.iter().flat_map(|hull| &hull.provenance.source_triangles) {
        is_represented[triangle as usize] = true;
    }
    let has_area = |triangle: usize| {
        let [a, b, c] = triangles[triangle].map(|vertex| positions[vertex as usize]);
        a != b && b != c && c != a
    };
    (0..triangles.len()).find(|&triangle| !is_represented[triangle] && has_area(triangle))
}

/// A cup with a wavy rim, and beside it a ribbon narrower than a tenth of the bound.
fn fine_cup() -> Mesh {
    let mut cup = lathe(&finely(&CUP_PROFILE, 40), 240);
    for [x, y, z] in &mut cup.0 {
        *z += 0.02 * *z * (7.0 * y.atan2(*x)).sin();
    }
    join(&[cup, cuboid([1.3, -0.5, 0.0], [1.305, 0.5, 0.002])])
}

#[test]
fn of_a_dense_mesh_no_triangle_is_lost() {
    let mesh = fine_cup();
    let result = promised("fine cup", &mesh);
    let report = &result.report;
    assert!(mesh.1.len() > 100_000 && report.polygons < 10_000);
    assert!(report.uncovered_max <= 0.1 * report.bound, "{report:?}");
    assert!(result.hulls.len() <= 20, "{}", result.hulls.len());
    assert!(!is_filled(&result, [0.3, 0.0, 1.0]), "the cup is filled");
    assert_eq!(lost(&mesh, &result), None);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| run(&mesh).hulls), result.hulls);
}

#[test]
fn an_open_dense_mesh_keeps_the_promise() {
    // A can without walls' thickness and without a lid.
    let profile = finely(&[[1e-3, -1.0], [1.0, -1.0], [1.0, 1.0]], 200);
    let mut can = lathe(&profile[..400], 400);
    // The lathe also joins the last ring with the first.
    can.1.retain(|triangle| {
        let along = triangle.map(|vertex| vertex % 400);
        along.iter().max().unwrap() - along.iter().min().unwrap() < 399
    });
    assert!(can.1.len() > 100_000);
    promised("an open can", &can);
}

#[test]
fn of_a_dense_mesh_no_long_triangle_is_lost() {
    // A drum of thin staves, which refinement leaves long, and beside it, flush with its top, a
    // dense ring.
    let drum = lathe(&[[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]], 13_000);
    let profile = [[0.001, 0.6], [0.3, 0.6], [0.3, 1.0], [0.001, 1.0]];
    let mut brick = lathe(&finely(&profile, 400), 120);
    brick.0.iter_mut().for_each(|point| point[0] += 1.305);
    let mesh = join(&[brick, drum]);
    let result = run(&mesh);
    let report = &result.report;
    assert!(report.protrusion_max <= report.bound && report.uncovered_max <= 0.1 * report.bound);
    assert_eq!(result.hulls.len(), 2);
    let volume: f64 = result.hulls.iter().map(|hull| hull.shape.volume()).sum();
    let expected = std::f64::consts::PI * (2.0 + 0.4 * 0.3 * 0.3);
    assert!((volume - expected).abs() < 0.02 * expected, "{volume}");
    assert_eq!(lost(&mesh, &result), None);
}
