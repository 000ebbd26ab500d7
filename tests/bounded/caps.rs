//! Caps on vertices and on hulls.

use hullwright::{Length, Parameters};

use crate::common::{ball, torus, u_prism};
use crate::judge::{assert_promise, judge, report, run_with};

fn with_max_vertices(most: usize) -> Parameters {
    let mut parameters = Parameters::default();
    parameters.max_vertices = Some(most);
    parameters
}

#[test]
fn hulls_keep_the_cap_on_vertices() {
    let mesh = torus();
    let result = run_with(&mesh, &with_max_vertices(12));
    assert!(result.hulls.iter().all(|hull| hull.shape.points.len() <= 12));
    assert_promise("capped", &mesh, &result);
}

#[test]
fn a_ball_that_a_cap_divides_stays_filled() {
    let ball = ball(24, 48);
    let result = run_with(&ball, &with_max_vertices(12));
    assert!(result.hulls.len() > 1);
    assert!(result.hulls.iter().all(|hull| hull.shape.points.len() <= 12));
    assert_promise("ball", &ball, &result);
    // Hulls of the surface alone leave half of the ball empty.
    let hollow = judge(&ball, &result.hulls).uncovered_volume;
    assert!(hollow.is_some_and(|hollow| hollow < 0.01), "{hollow:?}");
}

#[test]
fn the_cap_on_hulls_is_kept_and_the_report_says_what_it_costs() {
    let mut parameters = Parameters::default();
    parameters.max_hulls = Some(2);
    let mesh = u_prism();
    let result = run_with(&mesh, &parameters);
    assert_eq!(result.hulls.len(), 2);
    let report = report(&result);
    assert!(report.protrusion_max > report.bound);
    let measured = judge(&mesh, &result.hulls);
    assert!(measured.protrusion.max * measured.diagonal <= report.protrusion_max + 1e-6);
}

/// Joining hulls of the smaller bound one after the other gives 1.2 times the larger one.
#[test]
fn a_cap_on_hulls_costs_no_more_error_than_the_bound_that_ends_with_as_many() {
    let mesh = torus();
    for share in [0.03, 0.05, 0.08] {
        let larger = run_with(&mesh, &Parameters::default().max_error(Length::Share(share)));
        let capped = run_with(&mesh, &Parameters::default().max_hulls(larger.hulls.len()));
        assert!(capped.hulls.len() <= larger.hulls.len());
        let (capped, bound) = (report(&capped), report(&larger).bound);
        let error = capped.protrusion_max.max(capped.uncovered_max);
        assert!(error <= 1.05 * bound, "{share}: {}", error / bound);
    }
}
