//! `hullwright curve`, by running the program.
#![cfg(feature = "cli")]

use std::process::{Command, Output};

const MUG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/mug.glb");

fn curve(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hullwright")).arg("curve").args(arguments).output().unwrap()
}

#[test]
fn the_curve_ends_with_one_hull_and_its_error_never_falls() {
    let output = curve(&[MUG, "--json"]);
    assert!(output.status.success());
    let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let points = line["curve"].as_array().unwrap();
    let last = points.last().unwrap();
    assert_eq!(last["hulls"], 1);
    let distance = |name: &str| last[name].as_f64().expect(name);
    let largest = distance("protrusion_max").max(distance("uncovered_max"));
    assert_eq!(distance("error"), largest);
    let errors: Vec<f64> = points.iter().map(|point| point["error"].as_f64().unwrap()).collect();
    assert!(errors.len() > 3);
    assert!(errors.windows(2).all(|pair| pair[0] <= pair[1]));
}

#[test]
fn the_table_has_a_row_for_each_number_of_hulls() {
    let output = curve(&[MUG]);
    let shown = String::from_utf8(output.stdout).unwrap();
    assert!(shown.lines().next().unwrap().contains("error"));
    assert!(shown.lines().last().unwrap().trim_start().starts_with("1 "), "{shown}");
}

#[test]
fn the_plot_is_an_svg_and_nothing_else_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("curve.svg");
    assert!(curve(&[MUG, "-o", path.to_str().unwrap()]).status.success());
    assert!(std::fs::read_to_string(&path).unwrap().starts_with("<svg"));
    assert_eq!(curve(&[MUG, "-o", "curve.png"]).status.code(), Some(2));
}
