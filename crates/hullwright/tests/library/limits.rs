//! Limits on size and time, deadlines, and cancelling.

use std::thread;
use std::time::{Duration, Instant};

use hullwright::surface::{self, SurfaceParameters};
use hullwright::{Control, Decomposer, Error, Method, Parameters, Preset, decompose};

use crate::common::{l_prism, ring, run, torus, view};

fn methods() -> [Method; 3] {
    let hull = Method::Hull(Parameters::default());
    [Method::default(), SurfaceParameters::default().into(), hull]
}

#[test]
fn a_mesh_with_too_many_triangles_is_refused_before_any_work() {
    let mut mesh = l_prism();
    // It would be refused for this as well, if it were looked at.
    mesh.1[0] = [1000; 3];
    let mesh = view(&mesh);
    let count = mesh.triangles().len();
    let limit = count - 1;
    let control = Control::new().with_max_triangles(limit);
    let refused = Error::TooLarge { what: "triangles", count, limit };
    for method in methods() {
        assert_eq!(method.decompose(mesh, &control), Err(refused.clone()));
        assert_eq!(method.decomposer(mesh, &control).err(), Some(refused.clone()));
    }
}

#[test]
fn a_mesh_with_as_many_triangles_as_allowed_is_decomposed() {
    let mesh = l_prism();
    let control = Control::new().with_max_triangles(mesh.1.len());
    for (method, hulls) in methods().into_iter().zip([2, 2, 1]) {
        let result = method.decompose(view(&mesh), &control);
        assert_eq!(result.map(|result| result.hulls.len()), Ok(hulls));
    }
}

#[test]
fn past_the_time_limit_the_work_ends_in_whichever_slice_it_is() {
    let mesh = &l_prism();
    let mesh = view(mesh);
    let late = Control::new().with_time_limit(Instant::now());
    // All that is done in time takes a small part of it.
    let limit = Instant::now() + Duration::from_secs(6);
    let in_time = Control::new().with_time_limit(limit);
    let mut interrupted = Vec::new();
    for method in methods() {
        assert_eq!(method.decompose(mesh, &late), Err(Error::DeadlineExceeded));
        for slices_before in 0.. {
            let mut slices = method.decomposer(mesh, &in_time).unwrap();
            let is_done = (0..slices_before).any(|_| slices.step().unwrap().is_some());
            if is_done {
                assert!(slices_before > 2);
                break;
            }
            interrupted.push((slices_before, slices));
        }
    }
    thread::sleep(limit.saturating_duration_since(Instant::now()));
    for (slices_before, mut slices) in interrupted {
        assert_eq!(slices.step(), Err(Error::DeadlineExceeded), "{slices_before}");
        assert_eq!(slices.step(), Err(Error::Finished));
    }
}

/// A limit that is met within a slice: the trees of a mesh of this size take longer.
#[test]
fn past_the_time_limit_a_slice_ends_early() {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let side = 700_u32;
    for (x, z) in (0..side).flat_map(|x| (0..side).map(move |z| (x, z))) {
        let height = f64::from(x * 7 % 13 + z * 5 % 11) / 20.0;
        positions.push([f64::from(x), height, f64::from(z)]);
        if x > 0 && z > 0 {
            let last = x * side + z;
            triangles.push([last, last - 1, last - side]);
            triangles.push([last - 1, last - side - 1, last - side]);
        }
    }
    let control = Control::new().with_time_limit(Instant::now() + Duration::from_millis(20));
    let result = decompose(view(&(positions, triangles)), &Parameters::default(), &control);
    assert_eq!(result, Err(Error::DeadlineExceeded));
}

#[test]
fn cancelling_is_a_typed_error_and_goes_before_the_time_limit() {
    for control in [Control::new(), Control::new().with_time_limit(Instant::now())] {
        control.cancel();
        for method in methods() {
            assert_eq!(method.decompose(view(&l_prism()), &control), Err(Error::Cancelled));
        }
    }
}

#[test]
fn cancelling_in_any_slice_is_a_typed_error() {
    for before in 0.. {
        let control = Control::new();
        let parameters = Parameters::default();
        let mut decomposer = Decomposer::new(view(&torus()), &parameters, &control).unwrap();
        if (0..before).any(|_| decomposer.step().unwrap().is_some()) {
            assert!(before >= 5);
            return;
        }
        control.cancel();
        assert_eq!(decomposer.step().unwrap_err(), Error::Cancelled);
    }
}

#[test]
fn after_the_deadline_the_best_so_far_is_returned() {
    let mesh = ring(1.0, 0.3, 64, 32);
    let control = Control::new().with_deadline(Instant::now());
    for method in methods() {
        let result = method.decompose(view(&mesh), &control.clone().with_parallel(false)).unwrap();
        assert!(result.run.deadline_reached || method.name() == "hull");
        assert!(!result.hulls.is_empty());
    }
}

/// It starts no threshold after the deadline, and needs one for a result.
#[cfg(feature = "parallel")]
#[test]
fn the_surface_method_on_threads_may_have_nothing_at_the_deadline() {
    let mesh = ring(1.0, 0.3, 64, 32);
    let control = Control::new().with_deadline(Instant::now());
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let parameters = SurfaceParameters::default();
    let result = threads.install(|| surface::decompose(view(&mesh), &parameters, &control));
    assert_eq!(result, Err(Error::DeadlineExceeded));
    let parameters = Parameters::default();
    let result = threads.install(|| decompose(view(&mesh), &parameters, &control)).unwrap();
    assert!(result.run.deadline_reached && !result.hulls.is_empty());
}

#[test]
fn a_further_pass_ends_at_the_deadline_with_the_result_of_the_pass_before() {
    let mesh = torus();
    let parameters = Parameters::default().with_preset(Preset::Fine);
    // More than the first pass takes: with less it would be hurried.
    let deadline = Instant::now() + Duration::from_secs(8);
    let control = Control::new().with_deadline(deadline);
    let mut decomposer = Decomposer::new(view(&mesh), &parameters, &control).unwrap();
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
