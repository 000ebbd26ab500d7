//! Degenerate input under every preset: a result that keeps the promise, or a typed error.

use hullwright::{Control, Error, Parameters, Preset, decompose};

use crate::common::{Mesh, cuboid, join, l_prism, turned, view};
use crate::promised_with;

fn presets() -> [Parameters; 3] {
    [Preset::Fast, Preset::Balanced, Preset::Fine].map(|p| Parameters::default().with_preset(p))
}

fn assert_kept(name: &str, mesh: &Mesh) {
    for parameters in presets() {
        assert!(!promised_with(name, mesh, &parameters).hulls.is_empty(), "{name}");
    }
}

#[test]
fn meshes_without_area_are_a_typed_error() {
    let point = (vec![[1.0; 3]], vec![[0, 0, 0]]);
    let line = (vec![[0.0; 3], [1.0; 3], [2.0; 3]], vec![[0, 1, 2]]);
    let infinite = (vec![[f64::NAN; 3], [1.0; 3], [2.0; 3]], vec![[0, 1, 2]]);
    for mesh in [point, line, infinite] {
        for parameters in presets() {
            let result = decompose(view(&mesh), &parameters, &Control::new());
            assert!(matches!(result, Err(Error::NothingUsable { .. })), "{result:?}");
        }
    }
}

#[test]
fn a_single_triangle_is_a_thin_hull() {
    assert_kept("triangle", &(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]));
}

#[test]
fn solids_inside_out_overlapping_nested_and_needles_keep_the_promise() {
    let outer = cuboid([0.0; 3], [1.0; 3]);
    let needle = cuboid([0.0; 3], [1.0, 1e-5, 1e-5]);
    let speck = cuboid([0.5; 3], [0.5 + 1e-7; 3]);
    for (name, mesh) in [
        ("inside out", turned(&l_prism())),
        ("overlapping", join(&[outer.clone(), cuboid([0.5; 3], [1.5; 3])])),
        ("nested", join(&[outer, cuboid([0.25; 3], [0.75; 3])])),
        ("needle and speck", join(&[needle, speck, l_prism()])),
    ] {
        assert_kept(name, &mesh);
    }
}

#[test]
fn three_triangles_on_one_edge_keep_the_promise() {
    let positions =
        vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, -0.5, 0.8], [0.5, -0.5, -0.8]];
    assert_kept("fan", &(positions, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]));
}
