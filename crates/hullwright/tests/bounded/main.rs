//! Promises of the default method, each judged by means of the tests' own.
//!
//! | file | promises |
//! |---|---|
//! | `promise` | the bound is kept, for every bound, preset and kind of mesh, also a very dense one |
//! | `degenerate_input` | degenerate input has a result that keeps it, or a typed error |
//! | `bundled_models` | the bundled models keep it, with as many hulls as before |
//! | `verified` | what is verified agrees with brute force |
//! | `shapes` | simple shapes have few hulls, which fill the solid and leave empty what is empty |
//! | `two_sided` | solids whose faces are there both ways round are solids; what is open on purpose stays a sheet |
//! | `probe` | no ball that comes from outside is entered by more than the bound; what none reaches may fill |
//! | `least_hulls` | no result has fewer hulls than the lower bound says |
//! | `limits` | limits on vertices and hulls are kept; joins down to one hull |

mod bundled_models;
// The unused rest is for other tests.
#[allow(dead_code)]
#[path = "../common/mod.rs"]
mod common;
mod degenerate_input;
#[allow(dead_code)]
#[path = "../independent/mod.rs"]
mod independent;
mod least_hulls;
mod limits;
mod probe;
mod promise;
mod shapes;
mod two_sided;
mod verified;

use hullwright::measure::{MeasureOptions, Measurement, measure};
use hullwright::{Control, Decomposition, Hull, Length, Parameters};

use common::{Mesh, run_with, view};

/// The default parameters with another bound, as a fraction of the diagonal.
fn with_bound(bound: f64) -> Parameters {
    Parameters::default().with_max_error(Length::share(bound))
}

/// A decomposition by default, which keeps the promise.
fn promised(name: &str, mesh: &Mesh) -> Decomposition {
    promised_with(name, mesh, &Parameters::default())
}

/// A decomposition, which keeps the promise.
fn promised_with(name: &str, mesh: &Mesh, parameters: &Parameters) -> Decomposition {
    let result = run_with(mesh, parameters);
    assert_promise(name, mesh, &result);
    result
}

/// The hulls against dense samples of mesh and hulls.
fn judge(mesh: &Mesh, hulls: &[Hull]) -> Measurement {
    let mut options = MeasureOptions::default();
    options.volume_samples = 50_000;
    measure(view(mesh), hulls, &options, &Control::new()).unwrap()
}

/// The promise: verified errors are within the bound, dense samples within the verified errors, and
/// hulls are convex and have volume.
fn assert_promise(name: &str, mesh: &Mesh, result: &Decomposition) {
    let report = &result.report;
    let measured = judge(mesh, &result.hulls);
    let diagonal = measured.diagonal;
    let rounding = 1e-6 * diagonal;
    assert!(report.protrusion_max <= report.bound + rounding, "{name}: {report:?}");
    assert!(report.uncovered_max <= report.bound + rounding, "{name}: {report:?}");
    let (protrusion, uncovered) =
        (measured.protrusion.max * diagonal, measured.uncovered.max * diagonal);
    assert!(protrusion <= report.protrusion_max + rounding, "{name}: {protrusion} {report:?}");
    assert!(uncovered <= report.uncovered_max + rounding, "{name}: {uncovered} {report:?}");
    assert_eq!(measured.non_convex_hulls, 0, "{name}");
    assert_eq!(measured.non_positive_volumes, 0, "{name}");
}
