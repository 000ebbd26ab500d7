//! Degenerate input under every preset: a result that keeps the promise, or a typed error.

use hullwright::{Control, Error, MeshView, Parameters, Preset, decompose};

use crate::common::{Mesh, cuboid, join, l_prism, turned};
use crate::judge::assert_promise;

fn with_preset(preset: Preset) -> Parameters {
    let mut parameters = Parameters::default();
    parameters.preset = preset;
    parameters
}

fn for_each_preset(check: impl Fn(&Parameters)) {
    [Preset::Fast, Preset::Balanced, Preset::Fine].map(with_preset).iter().for_each(check);
}

fn assert_kept(name: &str, mesh: &Mesh) {
    for_each_preset(|parameters| {
        let result =
            decompose(MeshView::new(&mesh.0, &mesh.1), parameters, &Control::new()).unwrap();
        assert!(!result.hulls.is_empty(), "{name}");
        assert_promise(name, mesh, &result);
    });
}

#[test]
fn meshes_without_area_are_a_typed_error() {
    let point = (vec![[1.0; 3]], vec![[0, 0, 0]]);
    let line = (vec![[0.0; 3], [1.0; 3], [2.0; 3]], vec![[0, 1, 2]]);
    let infinite = (vec![[f64::NAN; 3], [1.0; 3], [2.0; 3]], vec![[0, 1, 2]]);
    for (positions, triangles) in [point, line, infinite] {
        for_each_preset(|parameters| {
            let result =
                decompose(MeshView::new(&positions, &triangles), parameters, &Control::new());
            assert!(matches!(result, Err(Error::NothingUsable { .. })), "{result:?}");
        });
    }
}

#[test]
fn a_single_triangle_is_a_thin_hull() {
    assert_kept("triangle", &(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]));
}

#[test]
fn a_solid_turned_inside_out_keeps_the_promise() {
    assert_kept("inside out", &turned(&l_prism()));
}

#[test]
fn overlapping_and_nested_solids_keep_the_promise() {
    let outer = cuboid([0.0; 3], [1.0; 3]);
    assert_kept("overlapping", &join(&[outer.clone(), cuboid([0.5; 3], [1.5; 3])]));
    assert_kept("nested", &join(&[outer, cuboid([0.25; 3], [0.75; 3])]));
}

#[test]
fn needles_and_specks_keep_the_promise() {
    let needle = cuboid([0.0; 3], [1.0, 1e-5, 1e-5]);
    let speck = cuboid([0.5, 0.5, 0.5], [0.5 + 1e-7, 0.5 + 1e-7, 0.5 + 1e-7]);
    assert_kept("needle and speck", &join(&[needle, speck, l_prism()]));
}

#[test]
fn three_triangles_on_one_edge_keep_the_promise() {
    let positions =
        vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, -0.5, 0.8], [0.5, -0.5, -0.8]];
    assert_kept("fan", &(positions, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]));
}
