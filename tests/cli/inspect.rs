//! What the command line promises about `inspect`, errors and exit codes.
#![cfg(feature = "cli")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

const BOX: &str = "o box\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 1\nv 2 0 1\nv 2 1 1\nv 0 1 1\n\
                   f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn hullwright<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hullwright")).args(arguments).output().unwrap()
}

fn write(directory: &TempDir, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let path = directory.path().join(name);
    std::fs::write(&path, content).unwrap();
    path
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// The single line that went to standard error.
fn error_line(output: &Output, code: i32) -> String {
    assert_eq!(output.status.code(), Some(code));
    assert!(output.stdout.is_empty());
    let error = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.starts_with("error: "), "{error}");
    error
}

#[test]
fn inspect_shows_what_a_mesh_holds() {
    let directory = tempfile::tempdir().unwrap();
    let mesh = write(&directory, "box.obj", BOX);
    let output = hullwright(["inspect", text(&mesh)]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
    let shown = String::from_utf8(output.stdout).unwrap();
    let value = |name: &str| {
        let line = shown.lines().find(|line| line.starts_with(name)).expect(name);
        line[name.len()..].trim().to_owned()
    };
    assert_eq!(value("objects"), "1");
    assert_eq!(value("vertices"), "8");
    assert_eq!(value("triangles"), "12");
    assert_eq!(value("bounds to"), "2, 1, 1");
    assert_eq!(value("diagonal"), "2.44949");
    assert_eq!(value("components"), "1");
    assert_eq!(value("open edges"), "0");
    assert_eq!(value("closed"), "yes");
    assert_eq!(value("volume"), "2");
    assert_eq!(value("repairs"), "none needed");
}

#[test]
fn inspect_shows_repairs_and_holes() {
    let directory = tempfile::tempdir().unwrap();
    let broken = BOX.replace("f 4 1 5 8\n", "f 1 2 2\nf 1 2 6\nv nan 0 0\nf 1 2 9\nv 7 7 7\n");
    let mesh = write(&directory, "broken.obj", broken);
    let shown = String::from_utf8(hullwright(["inspect", text(&mesh)]).stdout).unwrap();
    for expected in [
        "closed              no",
        "openings            1 closed",
        "volume              2",
        "13, 10 after repair",
        "1 triangle that is not finite dropped",
        "1 triangle without area dropped",
        "1 duplicate triangle dropped",
    ] {
        assert!(shown.contains(expected), "{expected} is missing in\n{shown}");
    }
    let kept = hullwright(["inspect", text(&mesh), "--openings", "keep"]).stdout;
    assert!(String::from_utf8(kept).unwrap().contains("nothing is closed"));
}

#[test]
fn files_that_hold_no_mesh_end_with_one_line_and_exit_code_1() {
    let directory = tempfile::tempdir().unwrap();
    for (name, content, expected) in [
        ("empty.obj", "", "no vertices"),
        ("points.obj", "v 0 0 0\n", "the mesh is empty: 1 vertices, 0 triangles"),
        ("beyond.obj", "v 0 0 0\nf 1 1 2\n", "line 2"),
        ("lying.off", "OFF\n4000000000 1 0\n", "line 2"),
        ("cut.ply", "ply\nformat ascii 1.0\n", "end_header"),
        ("cut.stl", "solid x\nfacet normal 0 0 1\n", "inside of solid"),
        ("noise.glb", "glTF\0\0\0\0", "header"),
        ("noise.gltf", "{\"asset\":{\"version\":\"2.0\"},\n\"nodes\":3}", "line 2"),
        ("mesh.xyz", "0 0 0", "suffix"),
    ] {
        let mesh = write(&directory, name, content);
        for command in ["inspect", "decompose"] {
            let error = error_line(&hullwright([command, text(&mesh)]), 1);
            assert!(error.contains(name) && error.contains(expected), "{error}");
        }
    }
    let line = "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n";
    let mesh = write(&directory, "line.off", line);
    assert!(error_line(&hullwright(["inspect", text(&mesh)]), 1).contains("no usable triangle"));
    let missing = directory.path().join("missing.obj");
    assert!(error_line(&hullwright(["inspect", text(&missing)]), 1).contains("missing.obj"));
}

#[test]
fn wrong_usage_is_exit_code_2_and_comes_before_any_work() {
    for arguments in [
        &["decompose", "missing.obj", "--simplification-quality", "2"][..],
        &["decompose", "missing.obj", "--maximum-resolutions", "100,0"],
        &["decompose", "missing.obj", "--planar-thresholds=-0.1"],
        &["decompose", "missing.obj", "--max-vertices", "7"],
        &["decompose", "missing.obj", "--unit", "0d"],
    ] {
        let error = error_line(&hullwright(arguments.iter().copied()), 2);
        assert!(error.contains("parameter `"), "{error}");
    }
    for arguments in [
        &[][..],
        &["compose"],
        &["decompose"],
        &["decompose", "missing.obj", "--no-such-argument"],
        &["decompose", "missing.obj", "--output", "hulls.stl"],
        &["decompose", "missing.obj", "--threads", "0"],
        &["decompose", "missing.obj", "--threads", "1000000"],
        &["decompose", "missing.obj", "--unit", "long"],
        &["decompose", "missing.obj", "--method", "none"],
        &["decompose", "missing.obj", "--max-vertices", "all"],
    ] {
        let output = hullwright(arguments.iter().copied());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty());
    }
}

#[test]
fn an_output_directory_that_does_not_exist_is_noticed_before_any_work() {
    let output = hullwright(["decompose", "missing.obj", "--output", "no/such/place/hulls.obj"]);
    assert!(error_line(&output, 1).contains("does not exist"));
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let directory = tempfile::tempdir().unwrap();
    let mesh = write(&directory, "box.obj", BOX);
    for arguments in [&["inspect", text(&mesh)][..], &["--help"], &["--version"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = Command::new(env!("CARGO_BIN_EXE_hullwright"))
            .args(arguments)
            .stdout(writer)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(output.stderr.is_empty());
    }
}
