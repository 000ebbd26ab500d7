//! What the command line promises about `measure`.
#![cfg(feature = "cli")]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

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

fn measure(mesh: &str, hulls: &str, more: &[&str]) -> Output {
    let directory = tempfile::tempdir().unwrap();
    let (mesh_path, hulls_path) =
        (directory.path().join("mesh.obj"), directory.path().join("hulls.obj"));
    std::fs::write(&mesh_path, mesh).unwrap();
    std::fs::write(&hulls_path, hulls).unwrap();
    run(&mesh_path, &hulls_path, more)
}

fn run(mesh: &Path, hulls: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hullwright"));
    command.arg("measure").arg(mesh).arg(hulls).args(more).output().unwrap()
}

fn two_hulls() -> String {
    format!("o a\n{}o b\n{}", cuboid([1.0, 1.0, 1.0], 0), cuboid([0.5, 1.0, 1.5], 8))
}

#[test]
fn the_table_has_every_figure() {
    let output = measure(&cuboid([1.0; 3], 0), &two_hulls(), &[]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
    let shown = String::from_utf8(output.stdout).unwrap();
    let value = |name: &str| {
        let line = shown.lines().find(|line| line.starts_with(name)).expect(name);
        line[name.len()..].trim().to_owned()
    };
    assert_eq!(value("hulls"), "2");
    assert_eq!(value("vertices"), "16");
    assert_eq!(value("convex"), "all, off by at most 0.0000");
    assert!(value("protrusion").ends_with("at most 0.2887"));
    assert_eq!(value("uncovered  "), "mean 0.0000, 99 % below 0.0000, at most 0.0000");
    assert_eq!(value("Hausdorff"), "0.2887");
    assert_eq!(value("uncovered volume"), "0.0 %");
    assert_eq!(value("volume IoU"), "80.0 %");
    assert_eq!(value("overlap"), "1.400");
    assert!(!shown.contains("unusable") && !shown.contains("closed"));
}

#[test]
fn json_is_one_line_with_figures_and_counts() {
    let output = measure(&cuboid([1.0; 3], 0), &two_hulls(), &["--json"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 1);
    let json: Value = serde_json::from_str(&text).unwrap();
    let near = |pointer: &str, expected: f64| {
        let found = json.pointer(pointer).and_then(Value::as_f64).expect(pointer);
        assert!((found - expected).abs() < 2e-3, "{pointer}: {found}");
    };
    assert!(json["mesh"].as_str().unwrap().ends_with("mesh.obj"));
    assert!(json["hulls_file"].as_str().unwrap().ends_with("hulls.obj"));
    near("/hulls", 2.0);
    near("/vertices", 16.0);
    near("/protrusion/max", 0.5 / 3_f64.sqrt());
    near("/hausdorff", 0.5 / 3_f64.sqrt());
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
    let output = measure(sheet, sheet, &[]);
    assert_eq!(output.status.code(), Some(0));
    let shown = String::from_utf8(output.stdout).unwrap();
    assert!(shown.lines().any(|line| line.starts_with("not closed") && line.ends_with("1 of 1")));
    assert!(shown.contains("100.0 % of the mesh's edges are open"));
    let output = measure(sheet, sheet, &["--json"]);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        json["iou"].is_null() && json["uncovered_volume"].is_null() && json["overlap"].is_null()
    );
}

#[test]
fn a_file_without_hulls_is_named_in_one_line() {
    let points = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    let output = measure(&cuboid([1.0; 3], 0), points, &[]);
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(error.lines().count(), 1);
    assert!(error.starts_with("error: ") && error.contains("hulls.obj"), "{error}");
    let output = measure("v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", &cuboid([1.0; 3], 0), &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8(output.stderr).unwrap().contains("mesh.obj"));
    let missing = Path::new("does_not_exist.obj");
    assert_eq!(run(missing, missing, &[]).status.code(), Some(1));
}
