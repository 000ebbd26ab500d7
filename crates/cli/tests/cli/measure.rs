//! `hullwright measure`.

use serde_json::Value;

use crate::{Place, asset, value};

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
    assert!(value("protrusion").ends_with("largest 28.868 %"));
    assert_eq!(value("uncovered  "), "mean 0.000 %, 99 % below 0.000 %, largest 0.000 %");
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

const SURFACE: [&str; 4] = ["measure", "mesh.obj", "hulls.obj", "--surface"];

#[test]
fn two_surfaces_are_measured_both_ways() {
    let place = place(&cuboid([3.0, 4.0, 0.0], 0), &cuboid([3.0, 2.0, 0.0], 0));
    let shown = place.succeed(&SURFACE);
    assert_eq!(value(&shown, "triangles of the mesh"), "12");
    assert_eq!(value(&shown, "triangles of the result"), "12");
    assert_eq!(value(&shown, "diagonal of the mesh"), "5.000");
    let far = value(&shown, "mesh from result, at most");
    assert!(
        far.starts_with("2.0") && far.ends_with(" % of the diagonal), at least 2.000"),
        "{far}"
    );
    assert_eq!(value(&shown, "resolution"), "1 % of a distance");
    let json = place.json(&SURFACE);
    let number = |key: &str| json[key].as_f64().unwrap();
    assert!((2.0..2.02).contains(&number("to_source")), "{json}");
    assert!(number("from_source") < 1e-10, "{json}");
    assert_eq!((number("source_triangles"), number("triangles")), (12.0, 12.0));
}

#[test]
fn a_simplified_file_is_within_the_bound_that_it_was_made_with() {
    let place = Place::new(&[]);
    let model = asset("props.glb");
    let made = place.json(&["simplify", &model, "--max-error", "1%", "-o", "out.glb"]);
    let found = place.json(&["measure", &model, "out.glb", "--surface"]);
    // Coordinates of a GLB are rounded.
    let most = made["bound"].as_f64().unwrap() * (1.0 + 1e-5);
    for key in ["from_source", "to_source"] {
        let (found, made) = (found[key].as_f64().unwrap(), made[key].as_f64().unwrap());
        assert!(found <= most && found <= 1.02 * made + 1e-5 * most, "{key}: {found}, {made}");
    }
    for key in ["source_triangles", "triangles", "hidden_triangles"] {
        assert_eq!(found[key], made[key], "{key}");
    }
}

#[test]
fn hidden_triangles_are_left_out_and_counted_unless_they_are_kept() {
    let floor = cuboid([4.0, 4.0, 4.0], 0);
    // From 1 to 2 along each axis.
    let moved = |line: &str| match line.strip_prefix("v ") {
        Some(place) => format!("v {}\n", place.replace('1', "2").replace('0', "1")),
        None => format!("{line}\n"),
    };
    let sunk: String = cuboid([1.0; 3], 8).lines().map(moved).collect();
    let place = place(&(floor.clone() + &sunk), &floor);
    let shown = place.succeed(&SURFACE);
    assert_eq!(value(&shown, "triangles of the mesh"), "24, of them 12 hidden");
    assert!(value(&shown, "mesh from result, at most").contains("(0.0000 %"), "{shown}");
    let kept = place.json(&[&SURFACE[..], &["--keep-hidden"]].concat());
    assert_eq!(kept["hidden_triangles"], 0);
    assert!(kept["to_source"].as_f64().unwrap() > 0.9, "{kept}");
}

#[test]
fn surfaces_that_can_not_be_measured_are_named_in_one_line() {
    let (cube, nothing) = (cuboid([1.0; 3], 0), "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n");
    let empty = "v 0 0 0\n";
    for wrong in [nothing, empty, "no mesh at all"] {
        let error = place(&cube, wrong).fail_in_one_line(&SURFACE, 1);
        assert!(error.contains("hulls.obj"), "{error}");
        let error = place(wrong, &cube).fail_in_one_line(&SURFACE, 1);
        assert!(error.contains("mesh.obj"), "{error}");
    }
    let place = place(&cube, &cuboid([100.0; 3], 0));
    place.fail(&["measure", "mesh.obj", "does_not_exist.obj", "--surface"], 1);
    for option in [&["--max-error", "1%"][..], &["--openings", "keep"], &["--probe-radius", "1%"]] {
        place.fail(&[&SURFACE[..], option].concat(), 2);
    }
    place.fail(&["measure", "mesh.obj", "hulls.obj", "--keep-hidden"], 2);
    // Another unit.
    let warning = place.fail(&SURFACE, 0);
    assert!(warning.starts_with("warning: ") && warning.contains("units or places"), "{warning}");
}

#[test]
fn verified_errors_are_upper_bounds_for_whole_faces_on_request() {
    let place = place(&cuboid([1.0; 3], 0), &two_hulls());
    let verify = ["measure", "mesh.obj", "hulls.obj", "--verify"];
    let shown = place.succeed(&verify);
    let line = shown.lines().last().unwrap();
    // Half of a box whose diagonal is the root of three: 28.87 %, and at most 1 % more.
    let protrusion = line.strip_prefix("verified: protrusion at most ").expect(line);
    let protrusion: f64 = protrusion.split(' ').next().unwrap().parse().unwrap();
    assert!((28.86..29.2).contains(&protrusion), "{line}");
    assert!(line.contains(" (too large by ") && line.contains("uncovered at most "), "{line}");
    let json = place.json(&verify);
    let verified = |name: &str| json["verified"][name].as_f64().unwrap();
    assert!((0.5..0.506).contains(&verified("protrusion_max")), "{json}");
    assert!(verified("uncovered_max") <= 0.03 * verified("protrusion_max"), "{json}");
    assert!(place.json(&MEASURE)["verified"].is_null());
    place.fail(&["measure", "mesh.obj", "hulls.obj", "--verify", "--surface"], 2);
}

#[test]
fn hulls_of_another_mesh_or_in_another_unit_are_warned_of() {
    let cube = cuboid([1.0; 3], 0);
    let warning = |hulls: &str| {
        let output = place(&cube, hulls).run(&MEASURE);
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let expected = "warning: hulls.obj and mesh.obj are far apart: units or places may differ\n";
    assert_eq!(warning(&cuboid([1000.0; 3], 0)), expected);
    assert_eq!(warning(&cuboid([0.001; 3], 0)), expected);
    assert_eq!(warning(&two_hulls()), "");
}
