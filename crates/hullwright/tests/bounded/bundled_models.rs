//! The bundled models: the promise, and how many hulls each has.

use std::time::Instant;

use hullwright::openings::close_openings;
use hullwright::{Control, Parameters, Preset, decompose};

use crate::common::{self, Mesh, run, run_with, view};
use crate::independent::exact::{Faults, faults};
use crate::independent::sampling::sample;
use crate::{assert_promise, judge, promised, with_bound};

/// Points on hulls, and on the surface, of each model: a second or two in all.
const SAMPLES: usize = 10_000;

/// As a fraction of the diagonal: coordinates of files are in single precision.
const ROUNDING: f64 = 1e-6;

/// Hulls of each model under the default parameters. A change is a change of the algorithm, and of
/// `ALGORITHM_VERSION`.
const HULLS: [(&str, usize); 15] = [
    ("bowl", 25),
    ("chair", 10),
    ("dog", 13),
    ("gear", 30),
    ("l_prism", 2),
    ("lamp", 18),
    ("leaf", 8),
    ("mug", 22),
    ("plus", 2),
    ("props", 14),
    ("spring", 46),
    ("table", 5),
    ("teapot", 7),
    ("torus", 8),
    ("u_prism", 3),
];

fn models() -> impl Iterator<Item = (String, Mesh)> {
    let models = common::bundled_models().into_iter();
    models.map(|(name, mesh)| (name, (mesh.positions, mesh.triangles)))
}

#[test]
fn no_closed_model_stays_hollow_under_a_small_bound() {
    let mut closed = 0;
    for (name, mesh) in models().filter(|(name, _)| ["dog", "mug", "teapot"].contains(&&name[..])) {
        let hulls = run_with(&mesh, &with_bound(0.005)).hulls;
        let Some(hollow) = judge(&mesh, &hulls).uncovered_volume else { continue };
        closed += 1;
        assert!(hollow < 0.03, "{name}: {hollow}");
    }
    assert!(closed > 1);
}

#[test]
fn a_dense_sampling_without_the_crates_code_finds_no_more_than_what_is_verified() {
    for (name, mesh) in models() {
        let found = run(&mesh);
        let bounded = &found.report;
        for hull in &found.hulls {
            let (points, triangles) = hull.shape.to_single_precision().unwrap();
            assert_eq!(faults(&points, &triangles), Faults::default(), "{name}");
        }
        let closed = close_openings(view(&mesh), &Parameters::default(), &Control::new()).unwrap();
        let sampled = sample(&found, &closed.mesh, &closed.solid, SAMPLES);
        assert!(sampled.samples > 2 * SAMPLES && sampled.undecided == 0, "{name}: {sampled:?}");
        let uncovered = sampled.uncovered * found.run.diagonal;
        let rounding = ROUNDING * found.run.diagonal;
        assert!(uncovered <= bounded.uncovered_max + rounding, "{name}: {sampled:?} {bounded:?}");
        assert!(sampled.beyond_verified <= ROUNDING, "{name}: {sampled:?} {bounded:?}");
        println!("{name}: {sampled:?}");
    }
}

#[test]
fn the_promise_holds_with_as_many_hulls_as_before() {
    let found: Vec<(String, usize)> = models()
        .map(|(name, mesh)| {
            let hulls = promised(&name, &mesh).hulls.len();
            (name, hulls)
        })
        .collect();
    assert_eq!(found, HULLS.map(|(name, hulls)| (name.to_owned(), hulls)));
}

#[test]
fn past_the_deadline_hulls_are_as_few_as_those_of_fast() {
    let past = Control::new().with_deadline(Instant::now());
    let hulls = |mesh: &Mesh, preset: Preset, control: &Control| {
        let parameters = Parameters::default().with_preset(preset);
        let result = decompose(view(mesh), &parameters, control).unwrap();
        assert_promise("deadline", mesh, &result);
        (result.hulls.len(), result.run.deadline_reached)
    };
    let (mut late, mut fast) = (0, 0);
    for (name, mesh) in models() {
        for preset in [Preset::Balanced, Preset::Fine] {
            let (count, is_cut_short) = hulls(&mesh, preset, &past);
            assert!(is_cut_short, "{name}");
            late += count;
        }
        fast += hulls(&mesh, Preset::Fast, &Control::new()).0;
    }
    assert!(10 * late <= 11 * 2 * fast, "{late} and twice {fast}");
}
