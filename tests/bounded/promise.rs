//! The bound is kept: for every bound, every preset, and meshes of every kind.

use hullwright::{Length, Parameters, Preset};

use crate::common::{cuboid, cup, join, lathe, open_sheet, torus, turned, u_prism};
use crate::judge::{assert_promise, judge, report, run, run_with, with_bound};

#[test]
fn the_promise_holds_for_every_bound() {
    for percent in [0.5, 1.0, 4.0, 8.0] {
        let mesh = torus();
        let result = run_with(&mesh, &with_bound(percent / 100.0));
        assert_promise(&format!("{percent} %"), &mesh, &result);
    }
}

#[test]
fn every_preset_keeps_the_promise() {
    for preset in [Preset::Fast, Preset::Balanced, Preset::Fine] {
        let mut parameters = Parameters::default();
        parameters.preset = preset;
        assert_promise(preset.name(), &cup(), &run_with(&cup(), &parameters));
    }
}

#[test]
fn a_bound_in_units_equals_one_in_diagonals() {
    let mesh = u_prism();
    let relative = run(&mesh);
    let diagonal = relative.run.diagonal;
    let mut parameters = Parameters::default();
    parameters.max_error = Length::Units(0.02 * diagonal);
    let absolute = run_with(&mesh, &parameters);
    assert!((report(&absolute).bound - 0.02 * diagonal).abs() < 1e-12);
    assert_eq!(absolute.hulls, relative.hulls);
}

#[test]
fn a_box_without_a_floor_keeps_the_promise() {
    // Its inside ends where there is no surface.
    let (positions, mut triangles) = cuboid([0.0; 3], [1.0, 1.0, 0.6]);
    triangles.retain(|triangle| triangle.iter().any(|&vertex| vertex >= 4));
    let mesh = (positions, triangles);
    assert_promise("open box", &mesh, &run(&mesh));
}

#[test]
fn an_open_sheet_is_covered_by_thin_hulls() {
    let mesh = open_sheet();
    let result = run(&mesh);
    assert!(result.hulls.len() > 1);
    assert_promise("sheet", &mesh, &result);
}

/// Sheets nearer to each other than a cell of any grid once took minutes and hundreds of hulls.
#[test]
fn thin_sheets_close_together_stay_separate_under_a_small_bound() {
    let sheet = |low: f64, high: f64| cuboid([0.0, 0.0, low], [1.0, 1.0, high]);
    let body = cuboid([0.0, 0.0, 0.05], [0.5, 1.0, 0.5]);
    let mesh = join(&[sheet(0.0, 0.002), sheet(0.004, 0.006), body]);
    for (bound, hulls) in [(0.002, 2), (0.0005, 3)] {
        let result = run_with(&mesh, &with_bound(bound));
        assert_eq!(result.hulls.len(), hulls, "{bound}");
        assert_promise("sheets", &mesh, &result);
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
    let result = run(&plates);
    assert_promise("plates", &plates, &result);
    let judged = judge(&plates, &result.hulls);
    assert!(judged.uncovered.max < 0.002, "{}", judged.uncovered.max);
}
