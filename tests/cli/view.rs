//! `hullwright view`, by running the program.
#![cfg(feature = "cli")]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/");

fn view(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hullwright")).arg("view").args(arguments).output().unwrap()
}

fn asset(name: &str) -> String {
    format!("{ASSETS}{name}")
}

/// Writes a page about a mesh: the page, and its data.
fn page(folder: &Path, mesh: &str, more: &[&str]) -> (String, Value) {
    let path = folder.join("page.html");
    let arguments = [&[mesh, "-o", path.to_str().unwrap()], more].concat();
    let output = view(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = std::fs::read_to_string(&path).unwrap();
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    let data = serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap();
    (page, data)
}

#[test]
fn a_prop_is_a_page_below_two_megabytes_that_loads_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (page, data) = page(folder.path(), &asset("mug.glb"), &[]);
    assert!(page.len() < 2 << 20, "{} bytes", page.len());
    assert!(page.contains("default-src 'none'"));
    let head = page.split_once("<body>").unwrap().0;
    for loads in ["src=", "href=", "@import", "url("] {
        assert!(!head.contains(loads), "{loads}");
    }
    assert_eq!(data["title"], "mug.glb");
    assert_eq!(data["bound"], 0.02);
}

#[test]
fn the_states_are_those_of_curve() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = asset("chair.glb");
    let (_, data) = page(folder.path(), &mesh, &[]);
    let program = env!("CARGO_BIN_EXE_hullwright");
    let output = Command::new(program).args(["curve", &mesh, "--json"]).output().unwrap();
    let curve: Value = serde_json::from_slice(&output.stdout).unwrap();
    let diagonal = curve["diagonal"].as_f64().unwrap();
    let states = data["sets"][0]["states"].as_array().unwrap();
    let points = curve["curve"].as_array().unwrap();
    assert_eq!(states.len(), points.len());
    for (state, point) in states.iter().zip(points) {
        assert_eq!(state["hulls"], point["hulls"]);
        let error = point["error"].as_f64().unwrap() / diagonal;
        assert!((state["error"].as_f64().unwrap() - error).abs() < 1e-12);
        assert!((0.0..=1.0).contains(&state["iou"].as_f64().unwrap()));
    }
}

#[test]
fn sampled_protrusions_are_below_the_verified_ones() {
    let folder = tempfile::tempdir().unwrap();
    let (_, data) = page(folder.path(), &asset("bowl.glb"), &[]);
    let set = &data["sets"][0];
    let verified =
        set["hulls"].as_array().unwrap().iter().map(|h| h["protrusion"].as_f64().unwrap());
    let most = verified.fold(0.0, f64::max);
    assert!(set["protrusion_most"].as_f64().unwrap() <= most + 1e-9);
    let uncovered = set["uncovered"]["most"].as_f64().unwrap();
    assert!(uncovered <= set["states"][0]["uncovered"].as_f64().unwrap() + 1e-9);
}

#[test]
fn other_methods_and_other_tools_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let hulls = folder.path().join("hulls.obj");
    let program = env!("CARGO_BIN_EXE_hullwright");
    let mesh = asset("l_prism.glb");
    let made = Command::new(program)
        .args(["decompose", &mesh, "-o", hulls.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(made.status.success());
    let more = ["--compare", "surface", "--hulls", hulls.to_str().unwrap(), "--max-error", "1%"];
    let (_, data) = page(folder.path(), &mesh, &more);
    let names: Vec<&str> =
        data["sets"].as_array().unwrap().iter().map(|set| set["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["bounded, 1%", "surface", "hulls.obj"]);
    assert!(data["sets"].as_array().unwrap().iter().all(|set| set["is_verified"] == true));
    // The same hulls, read back from a file, have the same errors.
    assert_eq!(data["sets"][0]["states"][0]["hulls"], data["sets"][2]["states"][0]["hulls"]);
}

#[test]
fn without_merging_there_is_one_state() {
    let folder = tempfile::tempdir().unwrap();
    let (_, data) = page(folder.path(), &asset("table.glb"), &["--no-merge"]);
    assert_eq!(data["sets"][0]["states"].as_array().unwrap().len(), 1);
    assert_eq!(data["sets"][0]["is_verified"], false);
}

#[test]
fn names_from_files_cannot_end_the_block_of_data() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("<script>alert(1)<!--&.obj");
    let cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n";
    let rest = "o </script><script>alert(1)\nusemtl <img src=x>\nf 2 3 4\nf 1 4 3\n";
    std::fs::write(&mesh, format!("o first\n{cube}{rest}")).unwrap();
    let (page, data) = page(folder.path(), mesh.to_str().unwrap(), &[]);
    assert_eq!(data["title"], "<script>alert(1)<!--&.obj");
    assert!(data["names"][1].as_str().unwrap().contains("</script>"));
    assert!(!page.contains("alert(1)<") && !page.contains("><script>alert"));
}

#[test]
fn what_can_not_be_written_is_said_before_the_work() {
    let output = view(&[&asset("mug.glb"), "-o", "no/such/folder/page.html"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no such folder"));
    let output = view(&[&asset("mug.glb"), "--compare", "volume"]);
    assert_eq!(output.status.code(), Some(2));
    let output = view(&[&asset("mug.glb"), "--hulls", "no-such-file.obj"]);
    assert_eq!(output.status.code(), Some(1));
}
