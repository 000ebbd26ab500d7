//! Joins of a finished decomposition, down to one hull.

use hullwright::{Control, Decomposition, Error, MergeTree, MeshView, Parameters};

use crate::common::{Mesh, l_prism, torus, u_prism};
use crate::judge::{judge, run};

fn hierarchy_of(mesh: &Mesh) -> (Decomposition, MergeTree) {
    let result = run(mesh);
    let (parameters, control) = (Parameters::default(), Control::new());
    let tree =
        MergeTree::new(MeshView::new(&mesh.0, &mesh.1), &result, &parameters, &control).unwrap();
    (result, tree)
}

#[test]
fn the_curve_goes_down_to_one_hull_and_its_error_never_falls() {
    let (result, tree) = hierarchy_of(&torus());
    let curve = tree.curve();
    assert_eq!(curve.first().unwrap().hulls, result.hulls.len());
    assert_eq!(curve.last().unwrap().hulls, 1);
    assert!(curve.windows(2).all(|pair| pair[1].hulls + 1 == pair[0].hulls));
    assert!(curve.windows(2).all(|pair| pair[0].error <= pair[1].error));
}

#[test]
fn every_state_is_valid_and_has_at_most_its_error() {
    let mesh = u_prism();
    let (_, tree) = hierarchy_of(&mesh);
    for point in tree.curve() {
        let hulls = tree.at_hulls(point.hulls);
        assert_eq!(hulls.len(), point.hulls);
        let measured = judge(&mesh, &hulls);
        let rounding = 1e-6 * measured.diagonal;
        assert!(measured.hausdorff * measured.diagonal <= point.error + rounding);
        assert_eq!(measured.non_convex_hulls, 0);
        let same = tree.at_error(point.error);
        assert!(same.len() <= point.hulls);
    }
    assert_eq!(tree.at_hulls(1).len(), 1);
    assert_eq!(tree.at_hulls(0).len(), 1);
    assert_eq!(tree.at_hulls(99).len(), 3);
    assert_eq!(tree.at_error(0.0).len(), 3);
}

/// Fields of hulls are public and may have been edited.
#[test]
fn inconsistent_hulls_are_a_typed_error() {
    let mesh = l_prism();
    let mut edited = run(&mesh);
    edited.hulls[0].shape.triangles[0][0] = 1_000_000;
    let (parameters, control) = (Parameters::default(), Control::new());
    let tree = MergeTree::new(MeshView::new(&mesh.0, &mesh.1), &edited, &parameters, &control);
    assert!(matches!(tree, Err(Error::UnusableHull { hull: 0, .. })));
}
