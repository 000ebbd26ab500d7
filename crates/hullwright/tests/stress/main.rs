//! Numerical stress: input that is hard on arithmetic, each with its reason. What is promised is
//! judged by exact predicates and brute force, without the crate's code.
//!
//! | file | what is hard |
//! |---|---|
//! | `range` | tiny, huge and far-away coordinates, to the ends of `f32` |
//! | `thin` | needles and plates |
//! | `flat_and_round` | very many points in a plane, on a circle, on a sphere |
//! | `noise` | noise and jitter as large as the tolerances |
//! | `topology` | surfaces that bound no solid, or touch themselves |

// The unused rest is for other tests.
#[allow(dead_code)]
#[path = "../common/mod.rs"]
mod common;
mod flat_and_round;
#[allow(dead_code)]
#[path = "../independent/mod.rs"]
mod independent;
mod noise;
mod range;
mod thin;
mod topology;

use hullwright::openings::close_openings;
use hullwright::{Control, Decomposition, Error, MeshView, Parameters, decompose};

use common::Mesh;
use independent::exact::{Faults, faults};
use independent::sampling::sample;

/// Points on hulls, and on the surface.
const SAMPLES: usize = 2_000;

/// Rounding of coordinates in single precision, as a fraction of the diagonal.
const ROUNDING: f64 = 1e-6;

/// The coordinates as files and engines hold them.
fn single((positions, triangles): &Mesh) -> Mesh {
    (positions.iter().map(|point| point.map(|x| f64::from(x as f32))).collect(), triangles.clone())
}

/// A mesh, its points moved.
fn placed(mesh: &Mesh, mut place: impl FnMut([f64; 3]) -> [f64; 3]) -> Mesh {
    (mesh.0.iter().map(|&point| place(point)).collect(), mesh.1.clone())
}

fn decomposed((positions, triangles): &Mesh) -> Result<Decomposition, Error> {
    let mesh = MeshView::new(positions, triangles);
    decompose(mesh, &Parameters::default(), &Control::new())
}

/// Decomposes a mesh in single precision. Hulls in single precision are exactly convex bodies, what
/// is verified is within the bound, and what is sampled within what is verified, hull by hull.
fn assert_sound(name: &str, mesh: &Mesh) -> Decomposition {
    let mesh = single(mesh);
    let found = decomposed(&mesh).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(!found.hulls.is_empty(), "{name}");
    for hull in &found.hulls {
        let (points, triangles) =
            hull.shape.to_single_precision().unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(faults(&points, &triangles), Faults::default(), "{name}");
    }
    let bounded = &found.report;
    let rounding = ROUNDING * found.run.diagonal;
    assert!(bounded.protrusion_max <= bounded.bound + rounding, "{name}: {bounded:?}");
    assert!(bounded.uncovered_max <= bounded.bound + rounding, "{name}: {bounded:?}");
    let view = MeshView::new(&mesh.0, &mesh.1);
    let closed = close_openings(view, &Parameters::default(), &Control::new()).unwrap();
    let sampled = sample(&found, &closed.mesh, &closed.solid, SAMPLES);
    let uncovered = sampled.uncovered * found.run.diagonal;
    assert!(uncovered <= bounded.uncovered_max + rounding, "{name}: {sampled:?} {bounded:?}");
    assert!(sampled.beyond_verified <= ROUNDING, "{name}: {sampled:?} {bounded:?}");
    found
}
