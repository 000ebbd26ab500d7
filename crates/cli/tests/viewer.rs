//! What a page holds.

use hullwright::{
    Control, Error, Hull, MergeTree, Parameters, TriangleMesh, convex_hull, decompose,
};
use hullwright_cli::viewer::{HullSet, Page};
use hullwright_formats::Object;
use serde_json::Value;

/// Two boxes apart: two hulls, and one join.
fn pair() -> TriangleMesh {
    let corners = |x: f64| {
        (0..8).map(move |k| [x + f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)])
    };
    let boxes = [0.0, 2.0].map(|x| convex_hull(&corners(x).collect::<Vec<_>>()).unwrap());
    let second = boxes[1].triangles.iter().map(|corners| corners.map(|k| k + 8));
    let triangles = boxes[0].triangles.iter().copied().chain(second).collect();
    TriangleMesh::new([&boxes[0].points[..], &boxes[1].points].concat(), triangles)
}

fn page_of(mesh: &TriangleMesh, title: &str, names: &[&str]) -> String {
    let (parameters, control) = (Parameters::default(), Control::new());
    let result = decompose(mesh, &parameters, &control).unwrap();
    let tree = MergeTree::new(mesh, &result, &parameters, &control).unwrap();
    let count = mesh.triangles.len() / names.len().max(1);
    let objects: Vec<Object> = names
        .iter()
        .enumerate()
        .map(|(i, &name)| Object { name: name.into(), triangles: i * count..(i + 1) * count })
        .collect();
    let page = Page::new(title, mesh, &parameters, &control).unwrap();
    let mut page = page.objects(&objects);
    page.add(HullSet::new("ours", &result.hulls).tree(&tree).fact("time", "1 s"), &control)
        .unwrap();
    page.to_html().unwrap()
}

fn block<'a>(page: &'a str, id: &str) -> &'a str {
    let (_, rest) = page.split_once(&format!("id=\"{id}\">")).unwrap();
    rest.split_once("</script>").unwrap().0
}

fn data(page: &str) -> Value {
    serde_json::from_str(block(page, "data")).unwrap()
}

#[test]
fn two_boxes_are_two_hulls_and_a_join_that_protrudes_by_half_their_gap() {
    let data = data(&page_of(&pair(), "pair", &["left", "right"]));
    let set = &data["sets"][0];
    assert_eq!(set["leaves"], 2);
    assert_eq!(set["joins"], serde_json::json!([[0, 1]]));
    let states = set["states"].as_array().unwrap();
    assert_eq!((states[0]["hulls"].as_u64(), states[1]["hulls"].as_u64()), (Some(2), Some(1)));
    assert_eq!(
        (states[0]["vertices"].as_u64(), states[1]["vertices"].as_u64()),
        (Some(16), Some(8))
    );
    // Half of a gap of 1, in a diagonal of √11.
    let protrusion = states[1]["error"].as_f64().unwrap() * 11_f64.sqrt();
    assert!((0.5..0.55).contains(&protrusion), "{protrusion}");
    let sampled = set["protrusion_most"].as_f64().unwrap() * 11_f64.sqrt();
    assert!((0.45..=0.5 + 1e-9).contains(&sampled), "{sampled}");
    let iou = |state: usize| states[state]["iou"].as_f64().unwrap();
    assert!((iou(0) - 1.0).abs() < 0.01 && (iou(1) - 2.0 / 3.0).abs() < 0.01);
}

#[test]
fn each_hull_says_which_part_of_the_mesh_it_stands_for() {
    let data = data(&page_of(&pair(), "pair", &["left", "right"]));
    let of = |hull: usize| data["sets"][0]["hulls"][hull]["objects"].clone();
    let mut leaves = [of(0), of(1)].map(|objects| objects[0].as_u64());
    leaves.sort_unstable();
    assert_eq!(leaves, [Some(0), Some(1)]);
    assert_eq!(of(2), serde_json::json!([0, 1]), "the joint hull stands for both");
}

#[test]
fn no_name_can_end_the_block_of_data() {
    let hostile = "</script><script>alert(1)</script><!--&\u{2028}";
    let page = page_of(&pair(), hostile, &[hostile, "plain"]);
    let text = block(&page, "data");
    assert!(!text.contains(['<', '>', '&', '\u{2028}']));
    assert_eq!(data(&page)["title"], hostile);
    assert_eq!(data(&page)["names"][0], hostile);
}

#[test]
fn the_template_has_one_place_for_the_data_and_forbids_all_requests() {
    let template = include_str!("../src/viewer/template.html");
    assert_eq!(template.matches("<!--data-->").count(), 1);
    assert!(template.contains("default-src 'none'"));
    assert!(template.len() < 1 << 20, "{} bytes", template.len());
}

#[test]
fn a_page_is_the_same_on_every_run() {
    assert_eq!(page_of(&pair(), "pair", &[]), page_of(&pair(), "pair", &[]));
}

#[test]
fn hulls_without_a_tree_have_one_state_with_sampled_errors() {
    let (mesh, parameters, control) = (pair(), Parameters::default(), Control::new());
    let hull = Hull::from(convex_hull(&mesh.positions).unwrap());
    let mut page = Page::new("one", &mesh, &parameters, &control).unwrap();
    page.add(HullSet::new("one", &[hull]), &control).unwrap();
    let set = &data(&page.to_html().unwrap())["sets"][0];
    assert_eq!((&set["is_verified"], set["states"].as_array().unwrap().len()), (&false.into(), 1));
    let error = set["states"][0]["error"].as_f64().unwrap() * 11_f64.sqrt();
    assert!((0.4..=0.5 + 1e-9).contains(&error), "{error}");
}

#[test]
fn a_page_without_hulls_to_add_is_refused() {
    let (mesh, parameters, control) = (pair(), Parameters::default(), Control::new());
    let mut page = Page::new("none", &mesh, &parameters, &control).unwrap();
    assert_eq!(page.add(HullSet::new("none", &[]), &control), Err(Error::NoHulls));
}
