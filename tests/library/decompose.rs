//! Promises of `decompose`, whatever the method; those of the paper's method among them.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use hullwright::surface::{self, ResolutionOutcome, SurfaceParameters, SurfaceReport};
use hullwright::{
    Control, Decomposition, Error, Length, MeshView, Method, MethodReport, Parameters, Stage,
    decompose, single_hull,
};

use crate::common::{Mesh, cuboid, fine_torus as torus, join, l_prism};

fn cube(low: [f64; 3], size: f64) -> Mesh {
    cuboid(low, low.map(|x| x + size))
}

fn run((positions, triangles): &Mesh) -> Decomposition {
    decompose(MeshView::new(positions, triangles), &Parameters::default(), &Control::new()).unwrap()
}

fn run_surface((positions, triangles): &Mesh) -> Decomposition<SurfaceReport> {
    let mesh = MeshView::new(positions, triangles);
    surface::decompose(mesh, &SurfaceParameters::default(), &Control::new()).unwrap()
}

fn both_methods() -> [Method; 2] {
    [Method::default(), SurfaceParameters::default().into()]
}

#[test]
fn a_cube_is_one_hull_of_its_volume() {
    let result = run(&cube([0.0; 3], 2.0));
    assert_eq!(result.hulls.len(), 1);
    assert!((result.hulls[0].shape.volume() - 8.0).abs() < 1e-9);
    assert_eq!(result.hulls[0].provenance.source_triangles, (0..12).collect::<Vec<u32>>());
}

#[test]
fn disjoint_boxes_are_two_hulls_of_two_components() {
    let result = run(&join(&[cube([0.0; 3], 1.0), cube([3.0, 0.0, 0.0], 1.0)]));
    assert_eq!(result.hulls.len(), 2);
    assert_eq!(
        result.hulls.iter().map(|hull| hull.provenance.component).collect::<Vec<_>>(),
        [0, 1]
    );
    assert_eq!(result.run.components, 2);
}

#[test]
fn an_l_prism_is_two_groups() {
    assert_eq!(run_surface(&l_prism()).report.pieces, 2);
}

#[test]
fn each_source_triangle_belongs_to_exactly_one_hull() {
    let mesh = torus(64, 32);
    let result = run(&mesh);
    let mut all: Vec<u32> = result
        .hulls
        .iter()
        .flat_map(|hull| hull.provenance.source_triangles.iter().copied())
        .collect();
    all.sort_unstable();
    assert_eq!(all, (0..mesh.1.len() as u32).collect::<Vec<_>>());
}

#[test]
fn labels_name_hulls_and_each_hull_has_volume() {
    let result = run(&torus(48, 24));
    assert_eq!(result.grouped.groups.len(), result.grouped.triangles.len());
    for index in 0..result.hulls.len() as u32 {
        assert!(result.grouped.groups.contains(&index));
    }
    assert!(result.grouped.groups.iter().all(|&label| (label as usize) < result.hulls.len()));
    assert!(result.hulls.iter().all(|hull| hull.shape.volume() > 0.0));
}

#[test]
fn left_handed_input_gives_the_same_hulls() {
    let (positions, triangles) = torus(32, 16);
    let flipped: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let expected = run(&(positions.clone(), triangles.clone()));
    let result = run(&(positions, flipped));
    assert_eq!(result.run.repairs.flipped_triangles, triangles.len());
    assert!(result.hulls.iter().all(|hull| hull.shape.volume() > 0.0));
    assert_eq!(result.hulls.len(), expected.hulls.len());
    for (hull, expected) in result.hulls.iter().zip(&expected.hulls) {
        assert_eq!(hull.provenance.source_triangles, expected.provenance.source_triangles);
        assert_eq!(hull.shape.points, expected.shape.points);
    }
}

/// The same groups, whatever the vertices' and triangles' places.
fn labels((positions, triangles): &Mesh, method: &Method) -> Vec<u32> {
    let mesh = MeshView::new(positions, triangles);
    method.decompose(mesh, &Control::new()).unwrap().grouped.groups
}

#[test]
fn scale_changes_nothing() {
    let (positions, triangles) = torus(40, 20);
    for method in both_methods() {
        let expected = labels(&(positions.clone(), triangles.clone()), &method);
        for scale in [1e-6, 1e6] {
            let scaled = positions.iter().map(|p| p.map(|x| x * scale)).collect();
            let labels = labels(&(scaled, triangles.clone()), &method);
            assert_eq!(labels, expected, "{method}, scale {scale}");
        }
    }
}

#[test]
fn far_from_the_origin_the_groups_are_the_same() {
    let (mut positions, triangles) = torus(160, 80);
    for [x, y, z] in &mut positions {
        let dent = 1.0 + 0.05 * (5.0 * *x).sin() * (7.0 * *y).cos();
        [*x, *y, *z] = [*x * dent, *y * dent, *z * dent];
    }
    let method = SurfaceParameters::default().into();
    let expected = labels(&(positions.clone(), triangles.clone()), &method);
    // A thousand times the torus's diagonal and more.
    for place in 1..5 {
        let by = [1.7, 2.9, 4.3].map(|turn| 4000.0 * (turn * f64::from(place)).sin());
        let moved = positions.iter().map(|p| [0, 1, 2].map(|axis| p[axis] + by[axis])).collect();
        assert_eq!(labels(&(moved, triangles.clone()), &method), expected, "{by:?}");
    }
}

#[test]
fn single_precision_input_works_and_hulls_come_in_single_precision() {
    let (positions, triangles) = l_prism();
    let single: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let result =
        decompose(MeshView::new(&single, &triangles), &Parameters::default(), &Control::new())
            .unwrap();
    for hull in &result.hulls {
        let (points, triangles) = hull.shape.to_single_precision().unwrap();
        assert!(points.len() >= 4 && triangles.len() >= 4);
    }
}

#[test]
fn threads_change_nothing() {
    let (positions, triangles) = torus(64, 32);
    let parameters = Parameters::default();
    let control = |is_parallel| Control::new().with_parallel(is_parallel);
    let serial =
        decompose(MeshView::new(&positions, &triangles), &parameters, &control(false)).unwrap();
    let mut parallel =
        decompose(MeshView::new(&positions, &triangles), &parameters, &control(true)).unwrap();
    parallel.run.times = serial.run.times.clone();
    assert_eq!(serial, parallel);
}

#[test]
fn resolutions_come_back_in_ascending_order_and_one_is_selected() {
    let (positions, triangles) = torus(64, 32);
    let mut parameters = SurfaceParameters::default();
    parameters.maximum_resolutions = vec![1000, 250, 500, 250];
    let mesh = MeshView::new(&positions, &triangles);
    let found = surface::decompose(mesh, &parameters, &Control::new()).unwrap();
    let resolutions = found.report.resolutions;
    assert_eq!(resolutions.iter().map(|r| r.resolution).collect::<Vec<_>>(), [250, 500, 1000]);
    let selected = resolutions.iter().filter(|r| r.outcome == ResolutionOutcome::Selected);
    assert_eq!(selected.count(), 1);
}

#[test]
fn simple_shapes_skip_higher_resolutions() {
    // A dense slab: one group at each resolution, so μ = 5 ends the search after r = 500.
    let mut mesh = (Vec::new(), Vec::new());
    const SIDE: u32 = 41;
    for x in 0..SIDE {
        for y in 0..SIDE {
            let (u, v) = (f64::from(x) - 20.0, f64::from(y) - 20.0);
            mesh.0.push([u, v, -0.01 * (u * u + v * v)]);
        }
    }
    for x in 0..SIDE - 1 {
        for y in 0..SIDE - 1 {
            let [a, b] = [x * SIDE + y, (x + 1) * SIDE + y];
            mesh.1.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    let report = run_surface(&mesh).report;
    let outcomes: Vec<_> = report.resolutions.iter().map(|r| r.outcome).collect();
    assert!(report.pieces < 5, "{}", report.pieces);
    assert_eq!(outcomes[2..], [ResolutionOutcome::CutOff; 3]);
    assert!(!outcomes[..2].contains(&ResolutionOutcome::CutOff));
}

#[test]
fn the_unit_may_be_absolute() {
    let (positions, triangles) = torus(32, 16);
    let mut parameters = SurfaceParameters::default();
    parameters.unit = Length::Units(1.5);
    let mesh = MeshView::new(&positions, &triangles);
    let found = surface::decompose(mesh, &parameters, &Control::new()).unwrap();
    assert!((found.report.unit - 1.5).abs() < 1e-12);
}

#[test]
fn values_that_mean_nothing_are_errors() {
    let (positions, triangles) = cube([0.0; 3], 1.0);
    let mesh = MeshView::new(&positions, &triangles);
    let control = Control::new();
    let is_rejected = |method: Method| {
        let result = method.decompose(mesh, &control);
        assert_eq!(result.err(), method.validate().err());
        matches!(method.validate(), Err(Error::InvalidParameter { .. }))
    };
    let bounded: [fn(&mut Parameters); 4] = [
        |p| p.max_error = Length::Share(0.0),
        |p| p.max_error = Length::Units(f64::NAN),
        |p| p.max_hulls = Some(0),
        |p| p.max_vertices = Some(3),
    ];
    for change in bounded {
        let mut parameters = Parameters::default();
        change(&mut parameters);
        assert!(is_rejected(parameters.clone().into()), "{parameters}");
        assert!(is_rejected(Method::Hull(parameters)));
    }
    let surface: [fn(&mut SurfaceParameters); 10] = [
        |p| p.simplification_quality = 0.0,
        |p| p.simplification_quality = f64::NAN,
        |p| p.maximum_resolutions.clear(),
        |p| p.maximum_resolutions.push(0),
        |p| p.planar_thresholds.clear(),
        |p| p.planar_thresholds.push(-1.0),
        |p| p.angular_threshold = f64::INFINITY,
        |p| p.concavity_cost_threshold = 0.0,
        |p| p.unit = Length::Share(0.0),
        |p| p.max_vertices = Some(3),
    ];
    for change in surface {
        let mut parameters = SurfaceParameters::default();
        change(&mut parameters);
        assert!(is_rejected(parameters.into()));
    }
    let hull = single_hull(mesh, Some(3), &control);
    assert!(matches!(hull, Err(Error::InvalidParameter { name: "max_vertices", .. })));
}

#[test]
fn unusable_input_is_a_typed_error() {
    let control = Control::new();
    let parameters = Parameters::default();
    let of = |positions: &[[f64; 3]], triangles: &[[u32; 3]]| {
        decompose(MeshView::new(positions, triangles), &parameters, &control).unwrap_err()
    };
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(of(&[], &[]), Error::EmptyMesh { vertices: 0, triangles: 0 });
    let out_of_range = Error::IndexOutOfRange { triangle: 0, index: 3, vertices: 3 };
    assert_eq!(of(&corners, &[[0, 1, 3]]), out_of_range);
    assert!(matches!(of(&[[0.0; 3]; 3], &[[0, 1, 2]]), Error::NothingUsable { .. }));
    assert!(matches!(of(&[[f64::NAN; 3]; 3], &[[0, 1, 2]]), Error::NothingUsable { .. }));
}

#[test]
fn cancelling_stops_with_a_typed_error() {
    let (positions, triangles) = torus(32, 16);
    let control = Control::new();
    control.cancel();
    for method in both_methods() {
        let result = method.decompose(MeshView::new(&positions, &triangles), &control);
        assert_eq!(result, Err(Error::Cancelled));
    }
}

#[test]
fn after_the_deadline_the_best_so_far_is_returned() {
    let (positions, triangles) = torus(64, 32);
    for method in both_methods() {
        let control = Control::new().with_parallel(false).with_deadline(Instant::now());
        let mesh = MeshView::new(&positions, &triangles);
        let result = method.decompose(mesh, &control).unwrap();
        assert!(result.run.deadline_reached);
        assert!(!result.hulls.is_empty());
    }
}

/// It starts no threshold after the deadline, and needs one for a result.
#[cfg(feature = "parallel")]
#[test]
fn the_surface_method_on_threads_may_have_nothing_at_the_deadline() {
    let (positions, triangles) = torus(64, 32);
    let mesh = MeshView::new(&positions, &triangles);
    let control = Control::new().with_deadline(Instant::now());
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let parameters = SurfaceParameters::default();
    let result = threads.install(|| surface::decompose(mesh, &parameters, &control));
    assert_eq!(result, Err(Error::DeadlineExceeded));
    let result = threads.install(|| decompose(mesh, &Parameters::default(), &control)).unwrap();
    assert!(result.run.deadline_reached && !result.hulls.is_empty());
}

#[test]
fn slices_give_the_same_and_progress_never_falls() {
    let (positions, triangles) = torus(32, 16);
    let seen = Arc::new(Mutex::new(Vec::new()));
    let listener = Arc::clone(&seen);
    let control = Control::new().with_progress(move |progress| {
        listener.lock().unwrap().push((progress.stage, progress.fraction));
    });
    let control = control.with_parallel(false);
    let parameters = SurfaceParameters::default();
    let method = Method::from(parameters.clone());
    let mesh = MeshView::new(&positions, &triangles);
    let mut decomposer = method.decomposer(mesh, &control).unwrap();
    let mut slices = 0;
    let sliced = loop {
        slices += 1;
        if let Some(result) = decomposer.step().unwrap() {
            break result;
        }
    };
    assert!(slices > 7);
    assert_eq!(decomposer.step(), Err(Error::Finished));
    let whole = surface::decompose(mesh, &parameters, &Control::new()).unwrap();
    assert_eq!((sliced.hulls, sliced.grouped), (whole.hulls, whole.grouped));
    assert_eq!(sliced.report, MethodReport::Surface(whole.report));
    let seen = seen.lock().unwrap();
    assert!(seen.windows(2).all(|pair| pair[0].1 <= pair[1].1));
    assert_eq!(seen.last().map(|last| last.1), Some(1.0));
    let simplifying = seen.iter().filter(|progress| progress.0 == Stage::Simplify).count();
    assert_eq!(simplifying, parameters.maximum_resolutions.len());
}

#[test]
fn the_single_hull_is_that_of_all_points() {
    let apart = join(&[cube([0.0; 3], 1.0), cube([3.0, 0.0, 0.0], 1.0)]);
    for (positions, triangles) in [torus(24, 12), l_prism(), apart] {
        let expected = hullwright::convex_hull(&positions).unwrap();
        let mesh = MeshView::new(&positions, &triangles);
        let made = single_hull(mesh, None, &Control::new()).unwrap();
        assert_eq!(made.hulls.len(), 1);
        let hull = &made.hulls[0];
        assert!((hull.shape.volume() / expected.volume() - 1.0).abs() < 1e-9);
        assert_eq!(hull.provenance.source_triangles.len(), triangles.len());
        let method = Method::Hull(Parameters::default().max_vertices(None));
        let same = method.decompose(mesh, &Control::new()).unwrap();
        assert_eq!((same.hulls, same.report), (made.hulls, MethodReport::Hull));
        let capped = single_hull(mesh, Some(8), &Control::new()).unwrap();
        let capped = &capped.hulls[0];
        assert!(capped.shape.points.len() <= 8 && capped.shape.volume() >= expected.volume());
        assert!(capped.errors.simplification_growth > 0.0 || expected.points.len() <= 8);
    }
}
