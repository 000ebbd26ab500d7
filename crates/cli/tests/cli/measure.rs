//! `hullwright measure`.

use serde_json::Value;

use crate::{Place, value};

/// Corners of a box from 0 to the given size, after `base` other vertices of the file.
fn cuboid(size: [f64; 3], base: usize) -> String {
    let [x, y, z] = size;
    let corners =
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    let mut text = String::new();
    for [i, j, k] in corners {
        text += &format!("v {} {} {}\n", x * f64::from(i), y * f64::from(j), z * f64::from(k));
    }
    for quad in [[4, 3, 2, 1], [5, 6, 7, 8], [1, 2, 6, 5], [2, 3, 7, 6], [3, 4, 8, 7], [4, 1, 5, 8]]
    {
        let [a, b, c, d] = quad.map(|index: usize| index + base);
        text += &format!("f {a} {b} {c} {d}\n");
    }
    text
}

fn place(mesh: &str, hulls: &str) -> Place {
    Place::new(&[("mesh.obj", mesh), ("hulls.obj", hulls)])
}

const MEASURE: [&str; 3] = ["measure", "mesh.obj", "hulls.obj"];

fn two_hulls() -> String {
    format!("o a\n{}o b\n{}", cuboid([1.0, 1.0, 1.0], 0), cuboid([0.5, 1.0, 1.5], 8))
}

#[test]
fn the_table_has_every_figure() {
    let shown = place(&cuboid([1.0; 3], 0), &two_hulls()).succeed(&MEASURE);
    let value = |name: &str| value(&shown, name);
    assert_eq!(value("hulls"), "2");
    assert_eq!(value("vertices"), "16");
    assert_eq!(value("convex"), "all, off by at most 0.000 %");
    assert!(value("protrusion").ends_with("at most 28.868 %"));
    assert_eq!(value("uncovered  "), "mean 0.000 %, 99 % below 0.000 %, at most 0.000 %");
    assert_eq!(value("Hausdorff"), "28.868 %");
    assert_eq!(value("uncovered volume"), "0.0 %");
    assert_eq!(value("volume IoU"), "80.0 %");
    assert_eq!(value("overlap"), "1.400");
    assert!(!shown.contains("unusable") && !shown.contains("closed"));
}

#[test]
fn json_is_one_line_with_figures_and_counts() {
    let json = place(&cuboid([1.0; 3], 0), &two_hulls()).json(&MEASURE);
    let near = |pointer: &str, expected: f64| {
        let found = json.pointer(pointer).and_then(Value::as_f64).expect(pointer);
        assert!((found - expected).abs() < 2e-3, "{pointer}: {found}");
    };
    assert!(json["mesh"].as_str().unwrap().ends_with("mesh.obj"));
    assert!(json["hulls_file"].as_str().unwrap().ends_with("hulls.obj"));
    near("/hulls", 2.0);
    near("/vertices", 16.0);
    near("/protrusion/max", 0.5);
    near("/hausdorff", 0.5);
    near("/uncovered/max", 0.0);
    near("/uncovered_volume", 0.0);
    near("/iou", 0.8);
    near("/overlap", 1.4);
    near("/non_convex_hulls", 0.0);
    near("/diagonal", 3_f64.sqrt());
    assert!(json["samples"]["hull"].as_u64() >= Some(20_000));
    assert!(json["samples"]["mesh"].as_u64() >= Some(20_000));
    assert!(json["samples"]["volume"].as_u64() >= Some(60_000));
}

#[test]
fn what_is_wrong_with_hulls_is_shown() {
    let sheet = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n";
    let place = place(sheet, sheet);
    let shown = place.succeed(&MEASURE);
    assert!(shown.lines().any(|line| line.starts_with("not closed") && line.ends_with("1 of 1")));
    assert!(shown.contains("100.0 % of the mesh's edges are open"));
    let json = place.json(&MEASURE);
    assert!(
        json["iou"].is_null() && json["uncovered_volume"].is_null() && json["overlap"].is_null()
    );
}

#[test]
fn a_file_without_hulls_is_named_in_one_line() {
    let points = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    let cube = cuboid([1.0; 3], 0);
    let error = place(&cube, points).fail_in_one_line(&MEASURE, 1);
    assert!(error.contains("hulls.obj"), "{error}");
    let place = place("v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", &cube);
    assert!(place.fail(&MEASURE, 1).contains("mesh.obj"));
    place.fail(&["measure", "does_not_exist.obj", "does_not_exist.obj"], 1);
}
