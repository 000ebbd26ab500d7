//! `hullwright inspect`, errors and exit codes.

use std::process::Command;

use crate::{PROGRAM, Place, value};

const BOX: &str = "o box\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 1\nv 2 0 1\nv 2 1 1\nv 0 1 1\n\
                   f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

#[test]
fn inspect_shows_what_a_mesh_holds() {
    let shown = Place::new(&[("box.obj", BOX)]).succeed(&["inspect", "box.obj"]);
    let value = |name: &str| value(&shown, name);
    assert!(shown.starts_with("box.obj: 1 object\n"), "{shown}");
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
    let broken = BOX.replace("f 4 1 5 8\n", "f 1 2 2\nf 1 2 6\nv nan 0 0\nf 1 2 9\nv 7 7 7\n");
    let place = Place::new(&[("broken.obj", &broken)]);
    let shown = place.succeed(&["inspect", "broken.obj"]);
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
    let kept = place.succeed(&["inspect", "broken.obj", "--openings", "keep"]);
    assert!(kept.contains("nothing is closed"));
}

/// A tetrahedron, whose solid has no end.
const UNENDED: &str = "solid a\n\
    facet\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nend facet\n\
    facet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nend facet\n\
    facet\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendfacet\n\
    facet\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendfacet\n";

#[test]
fn what_a_reader_mends_has_a_line_for_each_kind() {
    let place = Place::new(&[("a.stl", UNENDED)]);
    let expected = "file: 2 lines such as `end solid`: read as one word\n\
                    file: 1 line `solid` or `endsolid` doubled or missing: mended\n";
    for command in ["inspect", "decompose"] {
        let shown = place.succeed(&[command, "a.stl"]);
        assert!(shown.contains(expected), "{shown}");
    }
    let line = place.json(&["decompose", "a.stl"]);
    assert_eq!(line["notes"][0]["kind"], "divided_ends");
    assert_eq!(line["notes"][0]["count"], 2);
    for arguments in [&["bake", "a.stl"][..], &["bake", "a.stl", "--per-mesh"], &["curve", "a.stl"]]
    {
        let output = place.run(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{error}");
        assert!(error.starts_with("warning: a.stl: 2 lines such as"), "{error}");
        assert_eq!(error.lines().count(), 2, "{error}");
    }
}

#[test]
fn inspect_lists_the_meshes_of_a_baked_scene() {
    let place = Place::new(&[("box.obj", BOX)]);
    place.succeed(&["bake", "box.obj"]);
    let shown = place.succeed(&["inspect", "box.hullscene"]);
    assert_eq!(value(&shown, "meshes"), "1");
    assert!(shown.lines().last().unwrap().ends_with("box"), "{shown}");
    let error = place.fail_in_one_line(&["inspect", "box.hullscene", "--openings", "keep"], 2);
    assert!(error.contains("--openings has no effect: box.hullscene holds hulls"), "{error}");
    place.write("bad.hullscene", "x");
    assert!(place.fail_in_one_line(&["inspect", "bad.hullscene"], 1).contains("bad.hullscene"));
}

#[test]
fn files_that_hold_no_mesh_end_with_one_line_and_exit_code_1() {
    let place = Place::new(&[]);
    for (name, content, expected) in [
        ("empty.obj", "", "no vertices"),
        ("points.obj", "v 0 0 0\n", "the mesh is empty: 1 vertices, 0 triangles"),
        ("beyond.obj", "v 0 0 0\nf 1 1 2\n", "line 2"),
        ("lying.off", "OFF\n4000000000 1 0\n", "line 2"),
        ("cut.ply", "ply\nformat ascii 1.0\n", "end_header"),
        ("cut.stl", "solid x\nfacet normal 0 0 1\n", "inside of a facet"),
        ("noise.glb", "glTF\0\0\0\0", "header"),
        (
            "noise.gltf",
            "{\"asset\":{\"version\":\"2.0\"},\n\"nodes\":3}",
            "its `nodes` is `3`, and a list",
        ),
        ("mesh.xyz", "0 0 0", "suffix"),
    ] {
        place.write(name, content);
        for command in ["inspect", "decompose"] {
            let error = place.fail_in_one_line(&[command, name], 1);
            assert!(error.contains(name) && error.contains(expected), "{error}");
        }
    }
    let line = "OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n";
    place.write("line.off", line);
    let error = place.fail_in_one_line(&["inspect", "line.off"], 1);
    assert!(error.contains("no usable triangle"), "{error}");
    std::fs::create_dir(place.path("folder")).unwrap();
    let error = place.fail_in_one_line(&["inspect", "folder"], 1);
    assert!(error.contains("folder: it is a folder"), "{error}");
    let error = place.fail_in_one_line(&["inspect", "missing.obj"], 1);
    assert!(error.contains("missing.obj"), "{error}");
}

#[test]
fn wrong_usage_is_exit_code_2_and_comes_before_any_work() {
    let place = Place::new(&[]);
    for arguments in [
        &["decompose", "missing.obj", "--simplification-quality", "2"][..],
        &["decompose", "missing.obj", "--maximum-resolutions", "100,0"],
        &["decompose", "missing.obj", "--planar-thresholds=-0.1"],
        &["decompose", "missing.obj", "--max-vertices", "7"],
        &["decompose", "missing.obj", "--unit", "0m"],
    ] {
        let error = place.fail_in_one_line(arguments, 2);
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
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty());
    }
}

#[test]
fn an_output_directory_that_does_not_exist_is_noticed_before_any_work() {
    let arguments = ["decompose", "missing.obj", "--output", "no/such/place/hulls.obj"];
    assert!(Place::new(&[]).fail_in_one_line(&arguments, 1).contains("does not exist"));
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let place = Place::new(&[("box.obj", BOX)]);
    for arguments in [&["inspect", "box.obj"][..], &["--help"], &["--version"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = Command::new(PROGRAM)
            .current_dir(place.0.path())
            .args(arguments)
            .stdout(writer)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(output.stderr.is_empty());
    }
}
