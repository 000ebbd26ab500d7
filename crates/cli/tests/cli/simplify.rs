//! `hullwright simplify`.

use crate::{Place, asset, value};

/// A square of 32 triangles, and a triangle as an object of its own.
fn square() -> String {
    let mut text = String::from("o square\n");
    for i in 0..25 {
        text += &format!("v {} {} 0\n", i % 5, i / 5);
    }
    for i in (0..20).filter(|i| i % 5 < 4) {
        text += &format!("f {} {} {} {}\n", i + 1, i + 2, i + 7, i + 6);
    }
    text + "o roof\nv 0 0 9\nv 1 0 9\nv 0 1 9\nf 26 27 28\n"
}

#[test]
fn a_plane_is_written_with_few_triangles_and_its_objects_keep_their_names() {
    let place = Place::new(&[("level.obj", &square())]);
    let shown = place.succeed(&["simplify", "level.obj", "--max-error", "0.02m", "-o", "out.obj"]);
    assert_eq!(value(&shown, "triangles"), "3 of 33");
    assert_eq!(value(&shown, "hidden triangles"), "0");
    assert!(shown.ends_with("wrote out.obj: 3 triangles\n"), "{shown}");
    let written = std::fs::read_to_string(place.path("out.obj")).unwrap();
    let objects: Vec<&str> = written.lines().filter(|line| line.starts_with("o ")).collect();
    assert_eq!(objects, ["o square", "o roof"]);
    let again = place.json(&["simplify", "out.obj"]);
    assert_eq!(again["source_triangles"], 3);
}

#[test]
fn json_has_counts_and_distances_within_the_bound() {
    let place = Place::new(&[]);
    let model = asset("props.glb");
    let line = place.json(&["simplify", &model, "--max-error", "1%", "-o", "out.glb"]);
    let number = |key: &str| line[key].as_f64().unwrap();
    assert!(number("from_source") <= number("bound"));
    assert!(number("to_source") <= number("bound"));
    assert!(number("triangles") < number("source_triangles"));
    let written = place.json(&["simplify", "out.glb"]);
    assert_eq!(written["source_triangles"], line["triangles"]);
}

#[test]
fn the_result_is_written_in_every_format() {
    let place = Place::new(&[("level.obj", &square())]);
    for suffix in ["obj", "glb", "off", "ply", "stl"] {
        let name = format!("out.{suffix}");
        place.succeed(&["simplify", "level.obj", "--max-error", "0.02m", "-o", &name]);
        let found = place.json(&["measure", "level.obj", &name, "--surface"]);
        assert_eq!(found["triangles"], 3, "{suffix}");
        assert!(found["to_source"].as_f64().unwrap() < 1e-6, "{suffix}");
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let place = Place::new(&[]);
    let model = asset("props.glb");
    place.succeed(&["simplify", &model, "-o", "one.obj", "--threads", "1"]);
    place.succeed(&["simplify", &model, "-o", "more.obj", "--threads", "3"]);
    let read = |name| std::fs::read(place.path(name)).unwrap();
    assert!(read("one.obj") == read("more.obj"));
}

#[test]
fn wrong_usage_is_refused_before_any_work() {
    let place = Place::new(&[("level.obj", &square())]);
    for arguments in [
        &["simplify", "level.obj", "--max-error", "0m"][..],
        &["simplify", "level.obj", "--max-error", "-1%"],
        &["simplify", "level.obj", "--max-error", "2"],
        &["simplify", "level.obj", "-o", "out.hulls"],
        &["simplify", "level.obj", "-o", "out.gltf"],
        &["simplify", "level.obj", "-o", "level.obj"],
    ] {
        assert_eq!(place.run(arguments).status.code(), Some(2), "{arguments:?}");
    }
    assert_eq!(place.run(&["simplify", "missing.obj"]).status.code(), Some(1));
}
