//! Limits for meshes from strangers.

use std::thread;
use std::time::{Duration, Instant};

use crate::common::l_prism;
use hullwright::surface::SurfaceParameters;
use hullwright::{Control, Error, MeshView, Method, Parameters, decompose};

fn methods() -> [Method; 3] {
    let hull = Method::Hull(Parameters::default());
    [Method::default(), SurfaceParameters::default().into(), hull]
}

#[test]
fn a_mesh_with_too_many_triangles_is_refused_before_any_work() {
    let (positions, mut triangles) = l_prism();
    // It would be refused for this as well, if it were looked at.
    triangles[0] = [1000; 3];
    let mesh = MeshView::new(&positions, &triangles);
    let count = triangles.len();
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
    let (positions, triangles) = l_prism();
    let control = Control::new().with_max_triangles(triangles.len());
    for (method, hulls) in methods().into_iter().zip([2, 2, 1]) {
        let result = method.decompose(MeshView::new(&positions, &triangles), &control);
        assert_eq!(result.map(|result| result.hulls.len()), Ok(hulls));
    }
}

#[test]
fn past_the_time_limit_the_work_ends_in_whichever_slice_it_is() {
    let (positions, triangles) = l_prism();
    let mesh = MeshView::new(&positions, &triangles);
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
    let result = decompose(MeshView::new(&positions, &triangles), &Parameters::default(), &control);
    assert_eq!(result, Err(Error::DeadlineExceeded));
}

#[test]
fn cancelling_goes_before_the_time_limit() {
    let (positions, triangles) = l_prism();
    let control = Control::new().with_time_limit(Instant::now());
    control.cancel();
    let result = decompose(MeshView::new(&positions, &triangles), &Parameters::default(), &control);
    assert_eq!(result, Err(Error::Cancelled));
}
