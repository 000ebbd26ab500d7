//! Limits on vertices and on hulls, and joins of a finished decomposition, down to one hull.

use hullwright::hulls_format::HullsFile;
use hullwright::{Control, Decomposition, Error, MergeTree, Parameters};

use crate::common::{Mesh, ball, l_prism, run, run_with, torus, u_prism, view};
use crate::{judge, promised_with, with_bound};

#[test]
fn hulls_keep_the_limit_on_vertices_and_a_ball_that_it_divides_stays_filled() {
    let limited = Parameters::default().with_max_vertices(12);
    let ball = ball(24, 48);
    for (name, mesh) in [("torus", &torus()), ("ball", &ball)] {
        let result = promised_with(name, mesh, &limited);
        assert!(result.hulls.len() > 1);
        assert!(result.hulls.iter().all(|hull| hull.shape.points.len() <= 12));
    }
    // Hulls of the surface alone leave half of the ball empty.
    let hollow = judge(&ball, &run_with(&ball, &limited).hulls).uncovered_volume;
    assert!(hollow.is_some_and(|hollow| hollow < 0.01), "{hollow:?}");
}

#[test]
fn the_limit_on_hulls_is_kept_and_the_report_has_its_error() {
    let mesh = u_prism();
    let result = run_with(&mesh, &Parameters::default().with_max_hulls(2));
    assert_eq!(result.hulls.len(), 2);
    let report = &result.report;
    assert!(report.protrusion_max > report.bound);
    let measured = judge(&mesh, &result.hulls);
    assert!(measured.protrusion.max * measured.diagonal <= report.protrusion_max + 1e-6);
}

/// Joining hulls of the smaller bound one after the other gives 1.2 times the larger one.
#[test]
fn a_limit_on_hulls_costs_no_more_error_than_the_bound_that_ends_with_as_many() {
    let mesh = torus();
    for share in [0.03, 0.05, 0.08] {
        let larger = run_with(&mesh, &with_bound(share));
        let limited = run_with(&mesh, &Parameters::default().with_max_hulls(larger.hulls.len()));
        assert!(limited.hulls.len() <= larger.hulls.len());
        let (limited, bound) = (limited.report, larger.report.bound);
        let error = limited.protrusion_max.max(limited.uncovered_max);
        assert!(error <= 1.05 * bound, "{share}: {}", error / bound);
    }
}

/// Where the limit on vertices divides a hull, searches for a limit on hulls end with far more:
/// they are given up.
#[test]
fn one_hull_of_a_ball_has_the_error_that_its_vertices_allow() {
    let ball = ball(40, 40);
    let one = run_with(&ball, &with_bound(0.005).with_max_hulls(1));
    let larger = run_with(&ball, &with_bound(0.03));
    assert_eq!((one.hulls.len(), larger.hulls.len()), (1, 1));
    let error =
        |result: &Decomposition| result.report.protrusion_max.max(result.report.uncovered_max);
    assert!(error(&one) <= 1.05 * error(&larger), "{}", error(&one) / error(&larger));
}

fn tree(mesh: &Mesh, result: &Decomposition) -> Result<MergeTree, Error> {
    MergeTree::new(view(mesh), result, &Parameters::default(), &Control::new())
}

fn tree_of(mesh: &Mesh) -> (Decomposition, MergeTree) {
    let result = run(mesh);
    let tree = tree(mesh, &result).unwrap();
    (result, tree)
}

#[test]
fn the_curve_goes_down_to_one_hull_and_its_error_never_falls() {
    let (result, tree) = tree_of(&torus());
    let curve = tree.curve();
    assert_eq!(curve.first().unwrap().hulls, result.hulls.len());
    assert_eq!(curve.last().unwrap().hulls, 1);
    assert!(curve.windows(2).all(|pair| pair[1].hulls + 1 == pair[0].hulls));
    assert!(curve.windows(2).all(|pair| pair[0].error <= pair[1].error));
}

#[test]
fn every_state_is_valid_and_has_at_most_its_error() {
    let mesh = u_prism();
    let (_, tree) = tree_of(&mesh);
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
    assert_eq!([1, 0, 99].map(|most| tree.at_hulls(most).len()), [1, 1, 3]);
    assert_eq!(tree.at_error(0.0).len(), 3);
}

#[test]
fn a_state_is_a_file_with_its_hulls_and_errors() {
    let (result, tree) = tree_of(&u_prism());
    assert_eq!(tree.to_file("u", 99), HullsFile::new("u", &result));
    for point in tree.curve() {
        let file = tree.to_file("u", point.hulls);
        assert_eq!(HullsFile::from_bytes(&file.to_bytes().unwrap()).as_ref(), Ok(&file));
        assert_eq!(file.verified.unwrap().protrusion_max, point.protrusion_max);
        let shapes = tree.at_hulls(point.hulls).into_iter().map(|hull| hull.shape);
        assert!(file.hulls.iter().map(|hull| hull.shape.clone()).eq(shapes));
        let is_beyond = point.protrusion_max > result.report.bound;
        assert_eq!(file.exceeded_bound().is_some(), is_beyond);
    }
}

/// Fields of hulls are public and may have been edited.
#[test]
fn inconsistent_hulls_are_a_typed_error() {
    let mesh = l_prism();
    let mut edited = run(&mesh);
    edited.hulls[0].shape.triangles[0][0] = 1_000_000;
    assert!(matches!(tree(&mesh, &edited), Err(Error::UnusableHull { hull: 0, .. })));
}

#[test]
fn where_the_vertex_limit_forces_hulls_the_report_says_how_many_there_would_be_without_it() {
    let ball = ball(40, 40);
    let parameters = with_bound(0.005);
    let limited = run_with(&ball, &parameters);
    let free = run_with(&ball, &parameters.clone().with_max_vertices(None));
    assert!(limited.hulls.len() > 1 && free.hulls.len() == 1);
    assert_eq!(limited.report.hulls_without_vertex_limit, 1);
    assert_eq!(limited.remarks(), ["the vertex limit forces hulls: 1 without it"]);
    assert_eq!(free.report.hulls_without_vertex_limit, 1);
    assert!(free.remarks().is_empty());
}
