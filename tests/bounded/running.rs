//! Threads, slices, progress, cancellation and deadlines.

use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use hullwright::{Control, Decomposer, Error, MeshView, Parameters, Preset, decompose};

use crate::common::{cup, torus};
use crate::judge::{assert_promise, run};

#[test]
fn one_two_and_four_threads_give_the_same() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&cup()).hulls)
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(4));
}

#[test]
fn slices_give_the_same_and_progress_never_falls() {
    let mesh = torus();
    let seen = Arc::new(Mutex::new(Vec::new()));
    let listener = Arc::clone(&seen);
    let control = Control::new()
        .with_progress(move |progress| listener.lock().unwrap().push(progress.fraction));
    let mut decomposer =
        Decomposer::new(MeshView::new(&mesh.0, &mesh.1), &Parameters::default(), &control).unwrap();
    let mut slices = 1;
    let sliced = loop {
        if let Some(result) = decomposer.step().unwrap() {
            break result;
        }
        slices += 1;
    };
    assert!(slices >= 5);
    assert_eq!(sliced.hulls, run(&mesh).hulls);
    let fractions = seen.lock().unwrap();
    assert!(fractions.windows(2).all(|pair| pair[0] <= pair[1]));
    assert_eq!(fractions.last(), Some(&1.0));
}

#[test]
fn cancelling_is_a_typed_error() {
    let control = Control::new();
    control.cancel();
    let (positions, triangles) = torus();
    let result = decompose(MeshView::new(&positions, &triangles), &Parameters::default(), &control);
    assert_eq!(result, Err(Error::Cancelled));
}

#[test]
fn cancelling_in_any_slice_is_a_typed_error() {
    let (positions, triangles) = torus();
    let view = MeshView::new(&positions, &triangles);
    for before in 0.. {
        let control = Control::new();
        let mut decomposer = Decomposer::new(view, &Parameters::default(), &control).unwrap();
        for _ in 0..before {
            if decomposer.step().unwrap().is_some() {
                assert!(before >= 5);
                return;
            }
        }
        control.cancel();
        assert_eq!(decomposer.step().unwrap_err(), Error::Cancelled);
    }
}

#[test]
fn after_the_deadline_the_best_so_far_is_returned_and_keeps_the_promise() {
    let mesh = torus();
    let past = Instant::now() - Duration::from_secs(1);
    let control = Control::new().with_deadline(past);
    let result =
        decompose(MeshView::new(&mesh.0, &mesh.1), &Parameters::default(), &control).unwrap();
    assert!(result.run.deadline_reached);
    assert_promise("deadline", &mesh, &result);
}

#[test]
fn a_further_pass_ends_at_the_deadline_with_the_result_of_the_pass_before() {
    let mesh = torus();
    let view = MeshView::new(&mesh.0, &mesh.1);
    let parameters = Parameters::default().preset(Preset::Fine);
    // More than the first pass takes: with less it would be hurried.
    let deadline = Instant::now() + Duration::from_secs(8);
    let control = Control::new().with_deadline(deadline);
    let mut decomposer = Decomposer::new(view, &parameters, &control).unwrap();
    // Repair, openings, and the stages of the first pass.
    for _ in 0..7 {
        assert!(decomposer.step().unwrap().is_none());
    }
    thread::sleep(deadline.saturating_duration_since(Instant::now()));
    // What ends at once leaves the result to be returned.
    let result = std::iter::repeat_with(|| decomposer.step().unwrap()).flatten().next().unwrap();
    assert!(result.run.deadline_reached);
    assert_eq!(result.hulls, run(&mesh).hulls);
}
