//! `hullwright curve`.

use crate::{Place, asset};

#[test]
fn the_curve_ends_with_one_hull_and_its_error_never_falls() {
    let line = Place::new(&[]).json(&["curve", &asset("mug.glb")]);
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
    let shown = Place::new(&[]).succeed(&["curve", &asset("mug.glb")]);
    assert!(shown.lines().next().unwrap().contains("error"));
    assert!(shown.lines().last().unwrap().trim_start().starts_with("1 "), "{shown}");
}

#[test]
fn the_plot_is_an_svg_and_nothing_else_is_drawn() {
    let (place, mug) = (Place::new(&[]), asset("mug.glb"));
    place.succeed(&["curve", &mug, "-o", "curve.svg"]);
    assert!(std::fs::read_to_string(place.path("curve.svg")).unwrap().starts_with("<svg"));
    place.fail(&["curve", &mug, "-o", "curve.png"], 2);
}
