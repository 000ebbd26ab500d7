//! `hullwright decompose`.

use std::process::Command;

use hullwright_formats::read_hulls;
use serde_json::Value;

use crate::{PROGRAM, Place, asset};

/// A prism over an L: two convex pieces.
const L_PRISM: &str = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n\
                       v 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 2 1\nv 0 2 1\n\
                       f 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\n\
                       f 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";

fn place() -> Place {
    Place::new(&[("l.obj", L_PRISM)])
}

impl Place {
    /// What decomposing the prism prints to standard output.
    fn decompose(&self, arguments: &[&str]) -> String {
        self.succeed(&[&["decompose", "l.obj"], arguments].concat())
    }

    fn decompose_json(&self, arguments: &[&str]) -> Value {
        self.json(&[&["decompose", "l.obj"], arguments].concat())
    }
}

#[test]
fn the_table_has_the_columns_of_the_papers_table_1() {
    let place = place();
    let shown = place.decompose(&["--method", "surface"]);
    let header = shown.lines().next().unwrap();
    for column in
        ["pieces", "average pieces", "time", "cost", "p", "r", "final polygons", "initial polygons"]
    {
        assert!(header.contains(column), "{header}");
    }
    assert!(shown.lines().nth(1).unwrap().trim_start().starts_with("2 "), "{shown}");
}

#[test]
fn json_is_one_line_with_all_fields() {
    let place = place();
    let line = place.decompose_json(&["--method", "surface"]);
    assert_eq!(line["mesh"], "l.obj");
    assert_eq!(line["method"], "surface");
    assert_eq!(line["triangles"], 20);
    assert_eq!(line["hulls"], 2);
    assert_eq!(line["algorithm_version"], hullwright::ALGORITHM_VERSION);
    assert_eq!(line["repairs"]["open_edges"], 0);
    for number in ["vertices", "seconds", "cost", "planar_threshold", "resolution", "volume_sum"] {
        assert!(line[number].is_number(), "{number}: {}", line[number]);
    }
    assert!(line.get("search").is_none());
    let search = &place.decompose_json(&["--search", "--method", "surface"])["search"];
    assert_eq!(search.as_array().map(Vec::len), Some(5));
    assert!(search[0]["thresholds"][0]["outcome"].is_string());
}

#[test]
fn json_has_the_same_keys_for_every_method() {
    let expected = [
        "mesh",
        "method",
        "notes",
        "triangles",
        "hulls",
        "vertices",
        "seconds",
        "bound",
        "protrusion_max",
        "uncovered_max",
        "hulls_without_vertex_limit",
        "patches",
        "patches_across_folds",
        "probe",
        "cost",
        "planar_threshold",
        "concavity_threshold",
        "resolution",
        "repairs",
        "openings",
        "algorithm_version",
        "version",
        "average_pieces",
        "pieces_before_merging",
        "polygons",
        "initial_polygons",
        "unit",
        "source_vertices",
        "diagonal",
        "components",
        "closed_components",
        "volume_sum",
        "thickened_hulls",
        "grown_hulls",
        "deadline_reached",
        "stage_seconds",
        "parts",
        "part_shares",
    ];
    let place = place();
    for method in ["bounded", "surface", "hacd"] {
        let line = place.decompose_json(&["--method", method, "-o", "hulls.obj"]);
        let keys: Vec<&String> = line.as_object().unwrap().keys().collect();
        assert_eq!(keys, expected, "{method}");
        assert_eq!(line["method"], method);
        assert_eq!(line["concavity_threshold"].is_number(), method == "hacd");
        assert_eq!(line["patches"].is_null(), method != "bounded");
        assert_eq!(line["cost"].is_null(), method == "bounded");
        // The only vertices in the corner of the L are on its ends, where the ray of equation (4)
        // leaves the hull at once: to HACD the whole is convex.
        let hulls = if method == "hacd" { 1 } else { 2 };
        assert_eq!(read_hulls(place.path("hulls.obj")).unwrap().len(), hulls);
    }
}

#[test]
fn the_default_is_the_bounded_method_with_what_it_verified() {
    let place = place();
    let shown = place.decompose(&[]);
    let header = shown.lines().next().unwrap();
    for column in ["hulls", "vertices", "bound", "protrusion at most", "uncovered at most"] {
        assert!(header.contains(column), "{header}");
    }
    let line = place.decompose_json(&["--max-error", "5%"]);
    assert_eq!(line["method"], "bounded");
    assert_eq!(line["hulls"], 2);
    let number = |name: &str| line[name].as_f64().unwrap();
    assert!((number("bound") / number("diagonal") - 0.05).abs() < 1e-12);
    assert!(number("protrusion_max") <= number("bound"));
    assert!(number("uncovered_max") <= number("bound"));
    assert!(line["patches"].as_u64() > Some(0));
    assert!(line["stage_seconds"]["merge"].is_number());
}

#[test]
fn the_limit_on_hulls_holds_and_the_table_says_what_it_costs() {
    let place = place();
    let line = place.decompose_json(&["--max-hulls", "1"]);
    assert_eq!(line["hulls"], 1);
    let number = |name: &str| line[name].as_f64().unwrap();
    assert!(number("protrusion_max") > number("bound"));
    let percent = 100.0 * number("protrusion_max") / number("diagonal");
    let said = format!("protrusion: {percent:.3} %, above the bound: the limit on hulls forces it");
    let shown = place.decompose(&["--max-hulls", "1"]);
    assert!(shown.lines().any(|line| line == said), "{said} in {shown}");
    assert!(!place.decompose(&["--max-hulls", "2"]).contains("above the bound"));
}

#[test]
fn a_sheet_that_is_thicker_than_the_bound_is_said_in_the_table() {
    let place = Place::new(&[("sheet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
    let shown = place.succeed(&["decompose", "sheet.obj", "--max-error", "0.001%"]);
    let said = "above the bound: a flat part has to be thicker to be a hull";
    assert!(shown.contains(said), "{shown}");
}

#[test]
fn the_help_fits_on_a_screen_of_80_columns_and_the_papers_options_come_last() {
    for (command, most) in [
        ("decompose", 50),
        ("view", 70),
        ("curve", 50),
        ("bake", 70),
        ("measure", 35),
        ("inspect", 25),
    ] {
        let help = Command::new(PROGRAM).env("COLUMNS", "80").args([command, "--help"]).output();
        let help = String::from_utf8(help.unwrap().stdout).unwrap();
        let lines = help.lines().count();
        assert!(lines <= most, "{lines} lines:\n{help}");
        assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
        let Some((others, paper)) =
            help.split_once("The paper's method (--method surface, or hacd)")
        else {
            continue;
        };
        for option in ["--paper", "--simplification-quality", "--unit"] {
            assert!(paper.contains(option) && !others.contains(option), "{option} in\n{help}");
        }
    }
}

#[test]
fn an_option_of_another_method_is_refused_by_name() {
    let place = place();
    for (line, reason) in [
        ("decompose l.obj --method surface --max-hulls 3", "--max-hulls is for --method bounded"),
        ("decompose l.obj --search", "--search is for --method surface or hacd"),
        ("bake l.obj --method hull --preset fine", "--preset is for --method bounded"),
        ("curve l.obj --unit 1m", "--unit is for --method surface"),
        ("view l.obj --compare surface --method hull --max-hulls 2", "not for hull and surface"),
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        let error = place.fail_in_one_line(&words, 2);
        assert!(error.contains(reason), "{error}");
    }
}

#[test]
fn every_command_says_in_the_same_words_that_a_bound_is_exceeded() {
    let place = place();
    let shown = place.decompose(&["--max-hulls", "1", "-o", "l.hulls"]);
    let line = shown.lines().find(|line| line.contains("above the bound")).unwrap();
    for arguments in [
        "view l.obj --max-hulls 1 -o l.png",
        "curve l.obj --max-hulls 1",
        "bake l.obj --max-hulls 1",
        "bake l.obj --max-hulls 1 --per-mesh -o baked",
        "inspect l.hulls",
        "inspect l.hullscene",
    ] {
        let words: Vec<&str> = arguments.split(' ').collect();
        let shown = place.succeed(&words);
        assert!(shown.lines().any(|other| other.ends_with(line)), "{arguments}: {shown}");
    }
}

#[test]
fn search_shows_every_resolution_and_what_became_of_it() {
    let place = place();
    let shown = place.decompose(&["--paper", "--search", "--maximum-resolutions", "250,777"]);
    assert!(shown.lines().any(|line| line.trim_start().starts_with("250 ")), "{shown}");
    assert!(shown.lines().any(|line| line.trim_start().starts_with("777 ")), "{shown}");
    assert!(shown.contains("selected") && shown.contains("candidate"), "{shown}");
}

#[test]
fn hulls_are_written_and_announced() {
    let place = place();
    for name in ["hulls.obj", "hulls.glb"] {
        let shown = place.decompose(&["-o", name]);
        assert!(shown.contains(&format!("wrote {name}: 2 hulls, ")), "{shown}");
        assert_eq!(read_hulls(place.path(name)).unwrap().len(), 2);
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let place = place();
    place.decompose(&["--output", "one.obj", "--threads", "1"]);
    place.decompose(&["--output", "four.obj", "--threads", "4"]);
    place.decompose(&["--output", "all.obj"]);
    let read = |name| std::fs::read(place.path(name)).unwrap();
    assert!(read("one.obj") == read("four.obj"));
    assert!(read("one.obj") == read("all.obj"));
}

#[test]
fn parameters_reach_the_method() {
    let place = place();
    let coarse = place.decompose_json(&["--paper", "--planar-thresholds", "1", "--unit", "10000%"]);
    assert_eq!(coarse["planar_threshold"], 1.0);
    assert_eq!(place.decompose_json(&["--paper"])["hulls"], 2);
}

#[test]
fn a_mesh_of_nothing_but_a_line_is_exit_code_1() {
    let place = place();
    place.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let error = place.fail(&["decompose", "line.obj"], 1);
    assert!(error.contains("line.obj: no usable triangle"), "{error}");
}

#[test]
fn the_mesh_itself_is_not_overwritten() {
    let place = place();
    std::fs::copy(asset("plus.glb"), place.path("plus.glb")).unwrap();
    for (command, output, reason) in
        [("decompose", "./plus.glb", "the mesh itself"), ("view", "plus.glb", "html or png")]
    {
        let error = place.fail_in_one_line(&[command, "plus.glb", "-o", output], 2);
        assert!(error.contains(reason), "{error}");
    }
    let bytes = |path| std::fs::read(path).unwrap();
    assert_eq!(bytes(place.path("plus.glb")), bytes(asset("plus.glb").into()));
}

#[test]
fn a_probe_fills_what_it_cannot_reach_and_says_so() {
    let place = Place::new(&[]);
    let chair = asset("chair.glb");
    let hulls = |arguments: &[&str]| {
        let line = place.json(&[&["decompose", &chair], arguments].concat());
        (line["hulls"].as_u64().unwrap(), line["probe"]["unreachable_volume"].as_f64())
    };
    let ((without, none), (with, volume)) = (hulls(&[]), hulls(&["--probe-radius", "12%"]));
    assert!(with < without && none.is_none(), "{with} of {without}");
    assert!(volume.is_some_and(|volume| volume >= 0.0));
    let shown = place.succeed(&["decompose", &chair, "--probe-radius", "0.1m"]);
    assert!(shown.contains("probe: a ball of radius"), "{shown}");
    let refused = place.fail(&["decompose", &chair, "--probe-radius", "-1m"], 2);
    assert!(refused.contains("probe_radius"), "{refused}");
}
