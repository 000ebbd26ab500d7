//! How few hulls are possible: known answers, and no result of any method has fewer.

use hullwright::hulls_format::VerifiedErrors;
use hullwright::measure::{MeasureOptions, verify};
use hullwright::surface::SurfaceParameters;
use hullwright::{
    Control, Length, Method, Parameters, Preset, decompose, least_hulls, single_hull,
};

use crate::common::{
    Mesh, ball, bundled_models, comb, cuboid, cup, join, plus_prism, turned, u_prism, view,
};
use crate::with_bound;

fn least_with(mesh: &Mesh, errors: VerifiedErrors, parameters: &Parameters) -> usize {
    let least = least_hulls(view(mesh), errors, parameters, &Control::new()).unwrap();
    assert_eq!(least.hulls, least.points.len().max(1));
    least.hulls
}

/// With an error of 0.5 % of the diagonal, both ways.
fn least(mesh: &Mesh) -> usize {
    let (low, high) = mesh.0.iter().fold(([f64::MAX; 3], [f64::MIN; 3]), |(low, high), point| {
        let pick = |f: fn(f64, f64) -> f64, a: [f64; 3]| [0, 1, 2].map(|k| f(a[k], point[k]));
        (pick(f64::min, low), pick(f64::max, high))
    });
    let diagonal = [0, 1, 2].map(|k| (high[k] - low[k]).powi(2)).iter().sum::<f64>().sqrt();
    let errors = VerifiedErrors::new(0.005 * diagonal, 0.005 * diagonal);
    least_with(mesh, errors, &with_bound(0.005))
}

#[test]
fn a_convex_body_needs_one_hull_and_bodies_that_are_apart_one_each() {
    assert_eq!(least(&cuboid([0.0; 3], [1.0, 2.0, 3.0])), 1);
    assert_eq!(least(&ball(12, 24)), 1);
    for count in [2, 5, 9] {
        let apart = (0..count).map(|i| {
            let x = 2.0 * f64::from(i);
            cuboid([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0])
        });
        let found = least(&join(&apart.collect::<Vec<_>>()));
        assert_eq!(found, count as usize);
    }
}

#[test]
fn plain_shapes_need_as_many_hulls_as_their_arms_ask_for() {
    assert_eq!(least(&u_prism()), 3, "its arms, and what is between");
    assert_eq!(least(&comb(7, 2.0, 1.0)), 8, "a tooth each, and what joins them");
    assert_eq!(least(&plus_prism()), 2, "two beams cross");
    assert!(least(&cup()) >= 5, "its wall is round");
}

#[test]
fn a_void_that_nothing_reaches_needs_no_hulls_of_its_own() {
    let hollow = join(&[ball(16, 32), turned(&scaled(&ball(16, 32), 0.8))]);
    assert_eq!(least(&hollow), 1);
    let mut keeping = with_bound(0.01);
    keeping.keep_cavities = true;
    // The bound leaves out what a hull may swallow, so that it holds for both.
    assert_eq!(least_with(&hollow, VerifiedErrors::new(0.02, 0.02), &keeping), 1);
}

fn scaled((positions, triangles): &Mesh, factor: f64) -> Mesh {
    (positions.iter().map(|point| point.map(|x| factor * x)).collect(), triangles.clone())
}

#[test]
fn with_a_probe_that_is_too_large_for_the_gaps_they_need_no_hulls() {
    let comb = comb(7, 2.0, 1.0);
    let errors = VerifiedErrors::new(0.05, 0.05);
    let with_probe = |radius: f64| {
        least_with(&comb, errors, &with_bound(0.01).with_probe_radius(Length::units(radius)))
    };
    assert_eq!(with_probe(0.3), 8, "it falls between the teeth");
    assert_eq!(with_probe(0.8), 1, "it does not");
    assert_eq!(with_probe(0.02), 1, "smaller than the bound it shows nothing");
}

#[test]
fn no_result_of_any_method_preset_or_bound_has_fewer() {
    let control = Control::new();
    let names = ["chair", "mug", "plus"];
    for (name, mesh) in bundled_models().into_iter().filter(|(name, _)| names.contains(&&name[..]))
    {
        let bounds = [0.01, 0.04].map(with_bound);
        let fast = with_bound(0.02).with_preset(Preset::Fast);
        let few = with_bound(0.02).with_max_hulls(3);
        for parameters in bounds.into_iter().chain([fast, few]) {
            let made = decompose(&mesh, &parameters, &control).unwrap();
            let errors = VerifiedErrors::new(made.report.protrusion_max, made.report.uncovered_max);
            let least = least_hulls(&mesh, errors, &parameters, &control).unwrap();
            assert!(least.hulls <= made.hulls.len(), "{name} {parameters:?}: {least:?}");
        }
        let others = [
            Method::from(SurfaceParameters::paper()).decompose(&mesh, &control).unwrap().hulls,
            single_hull(&mesh, None, &control).unwrap().hulls,
        ];
        for hulls in others {
            let options = MeasureOptions::default();
            let found = verify(&mesh, &hulls, &options, &control).unwrap();
            let least =
                least_hulls(&mesh, found.in_units(), &Parameters::default(), &control).unwrap();
            assert!(least.hulls <= hulls.len(), "{name}: {} hulls, {least:?}", hulls.len());
        }
    }
}

#[test]
fn threads_change_nothing_and_wrong_errors_are_refused() {
    let mesh = cup();
    let errors = VerifiedErrors::new(0.03, 0.001);
    let found = [true, false].map(|is_parallel| {
        let control = Control::new().with_parallel(is_parallel);
        least_hulls(view(&mesh), errors, &Parameters::default(), &control).unwrap()
    });
    assert_eq!(found[0], found[1]);
    for wrong in [f64::NAN, -1.0, f64::INFINITY] {
        for errors in [VerifiedErrors::new(wrong, 0.1), VerifiedErrors::new(0.1, wrong)] {
            let refused = least_hulls(view(&mesh), errors, &Parameters::default(), &Control::new());
            assert!(matches!(refused, Err(hullwright::Error::InvalidParameter { .. })), "{wrong}");
        }
    }
    let control = Control::new();
    control.cancel();
    let stopped = least_hulls(view(&mesh), errors, &Parameters::default(), &control);
    assert_eq!(stopped, Err(hullwright::Error::Cancelled));
}
