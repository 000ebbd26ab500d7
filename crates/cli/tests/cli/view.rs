//! `hullwright view`.

use serde_json::Value;

use crate::{Place, asset};

/// Writes a page about a mesh: the page, and its data.
fn page(place: &Place, mesh: &str, more: &[&str]) -> (String, Value) {
    place.succeed(&[&["view", mesh, "-o", "page.html"], more].concat());
    let page = std::fs::read_to_string(place.path("page.html")).unwrap();
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    let data = serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap();
    (page, data)
}

#[test]
fn a_prop_is_a_page_below_two_megabytes_that_loads_nothing() {
    let place = Place::new(&[]);
    let (page, data) = page(&place, &asset("mug.glb"), &[]);
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
    let place = Place::new(&[]);
    let mesh = asset("chair.glb");
    let (_, data) = page(&place, &mesh, &[]);
    let curve = place.json(&["curve", &mesh]);
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
    let place = Place::new(&[]);
    let (_, data) = page(&place, &asset("bowl.glb"), &[]);
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
    let place = Place::new(&[]);
    let mesh = asset("l_prism.glb");
    place.succeed(&["decompose", &mesh, "-o", "hulls.obj"]);
    let more = ["--compare", "surface", "--hulls", "hulls.obj", "--max-error", "1%"];
    let (_, data) = page(&place, &mesh, &more);
    let names: Vec<&str> =
        data["sets"].as_array().unwrap().iter().map(|set| set["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["bounded, 1%", "surface", "hulls.obj"]);
    assert!(data["sets"].as_array().unwrap().iter().all(|set| set["is_verified"] == true));
    // The same hulls, read back from a file, have the same errors.
    assert_eq!(data["sets"][0]["states"][0]["hulls"], data["sets"][2]["states"][0]["hulls"]);
}

#[test]
fn without_merging_there_is_one_state() {
    let place = Place::new(&[]);
    let (_, data) = page(&place, &asset("table.glb"), &["--no-merge"]);
    assert_eq!(data["sets"][0]["states"].as_array().unwrap().len(), 1);
    assert_eq!(data["sets"][0]["is_verified"], false);
}

#[test]
fn what_can_not_be_written_is_said_before_the_work() {
    let (place, mug) = (Place::new(&[]), asset("mug.glb"));
    let error = place.fail(&["view", &mug, "-o", "no/such/folder/page.html"], 1);
    assert!(error.contains("no such folder"), "{error}");
    place.fail(&["view", &mug, "--compare", "volume"], 2);
    place.fail(&["view", &mug, "--hulls", "no-such-file.obj"], 1);
}

#[test]
fn a_picture_has_a_row_of_three_panels_for_each_method() {
    let (place, mesh) = (Place::new(&[]), asset("l_prism.glb"));
    let size = |name: &str| {
        let bytes = std::fs::read(place.path(name)).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        (reader.info().width, reader.info().height)
    };
    let shown = place.succeed(&["view", &mesh, "-o", "one.png"]);
    assert_eq!(shown, "wrote one.png: bounded, 2%: 2 hulls\n");
    place.succeed(&["view", &mesh, "-o", "two.PNG", "--compare", "surface"]);
    assert_eq!((size("one.png"), size("two.PNG")), ((1500, 500), (1500, 1000)));
}

#[test]
fn a_simplified_mesh_is_shown_before_and_after() {
    let (place, mesh) = (Place::new(&[]), asset("props.glb"));
    let made = place.json(&["simplify", &mesh, "--max-error", "1%", "-o", "out.glb"]);
    let (html, data) = page(&place, &mesh, &["--simplified", "--max-error", "1%"]);
    assert!(html.len() < 2 << 20, "{} bytes", html.len());
    assert_eq!(data["is_simplified"], true);
    assert_eq!(data["bound"], 0.01);
    assert_eq!(data["mesh"]["source_triangles"], made["source_triangles"]);
    assert_eq!(data["mesh"]["caps"], made["hidden_triangles"]);
    let set = &data["sets"][0];
    assert_eq!(set["name"], "simplified, 1%");
    assert_eq!(set["hulls"][0]["triangles"], made["triangles"]);
    let number = |value: &Value| value.as_f64().unwrap();
    for (figure, key) in [("protrusion", "from_source"), ("uncovered", "to_source")] {
        let length = number(&set["states"][0][figure]) * number(&data["diagonal"]);
        assert!(length <= number(&made[key]) * (1.0 + 1e-9), "{figure}: {length}, {made}");
    }
    // Those of points are below the bounds for all.
    assert!(number(&set["protrusion_most"]) <= number(&set["states"][0]["protrusion"]));
    assert!(number(&set["uncovered"]["most"]) <= number(&set["states"][0]["uncovered"]));

    let (_, other) = page(&place, &mesh, &["--simplified=out.glb"]);
    assert_eq!(other["sets"][0]["name"], "out.glb");
    assert_eq!(other["sets"][0]["hulls"][0]["triangles"], made["triangles"]);
}

#[test]
fn a_simplified_mesh_is_drawn_beside_the_mesh() {
    let (place, mesh) = (Place::new(&[]), asset("mug.glb"));
    let shown = place.succeed(&["view", &mesh, "--simplified", "-o", "mug.png"]);
    assert!(shown.starts_with("wrote mug.png: simplified, 0.5%: "), "{shown}");
    assert!(shown.contains(" of 1020 triangles, within 0."), "{shown}");
    let bytes = std::fs::read(place.path("mug.png")).unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (1800, 900));
}

#[test]
fn what_has_no_effect_on_a_simplified_mesh_is_refused() {
    let (place, mug) = (Place::new(&[("empty.obj", "v 0 0 0\n")]), asset("mug.glb"));
    for option in [
        &["--compare", "surface"][..],
        &["--hulls", "hulls.obj"],
        &["--no-merge"],
        &["--method", "hull"],
        &["--max-vertices", "8"],
        &["--max-hulls", "3"],
        &["--openings", "keep"],
        &["--max-error", "0%"],
    ] {
        place.fail(&[&["view", &mug, "--simplified"], option].concat(), 2);
    }
    place.fail(&["view", &mug, "--keep-hidden"], 2);
    let error = place.fail_in_one_line(&["view", &mug, "--simplified=empty.obj"], 1);
    assert!(error.contains("empty.obj"), "{error}");
    let error = place.fail_in_one_line(&["view", "empty.obj", "--simplified"], 1);
    assert!(error.contains("empty.obj"), "{error}");
}

#[test]
fn how_few_hulls_are_possible_is_said_for_each_set_on_request() {
    let place = Place::new(&[]);
    let table = asset("table.glb");
    place.succeed(&["decompose", &table, "-o", "hulls.obj"]);
    let options = ["-o", "t.html", "--hulls", "hulls.obj", "--least"];
    let written = place.succeed(&[&["view", &table], &options[..]].concat());
    let expected =
        "bounded, 2%: 5 hulls (5 at least for its errors), hulls.obj: 5 hulls (5 at least";
    assert!(written.contains(expected), "{written}");
    let (_, page) = page(&place, &table, &["--least"]);
    let facts = page["sets"][0]["facts"].as_array().unwrap();
    assert!(
        facts
            .iter()
            .any(|fact| fact[0].as_str().unwrap().starts_with("needed")
                && fact[1] == "at least 5 hulls"),
        "{facts:?}"
    );
}
