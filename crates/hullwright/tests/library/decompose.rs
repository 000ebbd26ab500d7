//! Promises of `decompose`, whatever the method; those of the paper's method among them.

use std::sync::{Arc, Mutex};

use hullwright::surface::{self, ResolutionOutcome, SurfaceParameters, SurfaceReport};
use hullwright::{
    Control, Decomposition, Error, Length, MeshView, Method, MethodReport, Parameters, Stage,
    decompose, single_hull,
};

use crate::common::{Mesh, cuboid, join, l_prism, ring, run, turned, view};

fn cube(low: [f64; 3], size: f64) -> Mesh {
    cuboid(low, low.map(|x| x + size))
}

fn torus(sides: u32, parts: u32) -> Mesh {
    ring(1.0, 0.3, sides, parts)
}

fn run_surface(
    mesh: &Mesh,
    change: impl FnOnce(&mut SurfaceParameters),
) -> Decomposition<SurfaceReport> {
    let mut parameters = SurfaceParameters::default();
    change(&mut parameters);
    surface::decompose(view(mesh), &parameters, &Control::new()).unwrap()
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
    let components = result.hulls.iter().map(|hull| hull.provenance.component);
    assert_eq!(components.collect::<Vec<_>>(), [0, 1]);
    assert_eq!(result.run.components, 2);
}

#[test]
fn an_l_prism_is_two_groups() {
    assert_eq!(run_surface(&l_prism(), |_| {}).report.pieces, 2);
}

#[test]
fn each_source_triangle_belongs_to_exactly_one_hull_and_each_hull_has_volume_and_a_label() {
    let mesh = torus(64, 32);
    let result = run(&mesh);
    let source = result.hulls.iter().flat_map(|hull| &hull.provenance.source_triangles);
    let mut all: Vec<u32> = source.copied().collect();
    all.sort_unstable();
    assert_eq!(all, (0..mesh.1.len() as u32).collect::<Vec<_>>());
    assert!(result.hulls.iter().all(|hull| hull.shape.volume() > 0.0));
    assert_eq!(result.grouped.groups.len(), result.grouped.triangles.len());
    let mut labels = result.grouped.groups;
    labels.sort_unstable();
    labels.dedup();
    assert_eq!(labels, (0..result.hulls.len() as u32).collect::<Vec<_>>());
}

#[test]
fn left_handed_input_gives_the_same_hulls() {
    let mesh = torus(32, 16);
    let (expected, result) = (run(&mesh), run(&turned(&mesh)));
    assert_eq!(result.run.repairs.flipped_triangles, mesh.1.len());
    assert!(result.hulls.iter().all(|hull| hull.shape.volume() > 0.0));
    assert_eq!(result.hulls.len(), expected.hulls.len());
    for (hull, expected) in result.hulls.iter().zip(&expected.hulls) {
        assert_eq!(hull.provenance.source_triangles, expected.provenance.source_triangles);
        assert_eq!(hull.shape.points, expected.shape.points);
    }
}

/// The same groups, whatever the vertices' and triangles' places.
fn labels(mesh: &Mesh, method: &Method) -> Vec<u32> {
    method.decompose(view(mesh), &Control::new()).unwrap().grouped.groups
}

#[test]
fn scale_changes_nothing() {
    let mesh = torus(40, 20);
    for method in both_methods() {
        let expected = labels(&mesh, &method);
        for scale in [1e-6, 1e6] {
            let scaled = mesh.0.iter().map(|p| p.map(|x| x * scale)).collect();
            let labels = labels(&(scaled, mesh.1.clone()), &method);
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
    let mesh = MeshView::new(&single, &triangles);
    let result = decompose(mesh, &Parameters::default(), &Control::new()).unwrap();
    for hull in &result.hulls {
        let (points, triangles) = hull.shape.to_single_precision().unwrap();
        assert!(points.len() >= 4 && triangles.len() >= 4);
    }
}

#[test]
fn threads_change_nothing() {
    let mesh = torus(64, 32);
    let [serial, mut parallel] = [false, true].map(|is_parallel| {
        let control = Control::new().with_parallel(is_parallel);
        decompose(view(&mesh), &Parameters::default(), &control).unwrap()
    });
    parallel.run.times = serial.run.times.clone();
    assert_eq!(serial, parallel);
}

#[test]
fn resolutions_come_back_in_ascending_order_and_one_is_selected() {
    let found = run_surface(&torus(64, 32), |p| p.maximum_resolutions = vec![1000, 250, 500, 250]);
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
    let report = run_surface(&mesh, |_| {}).report;
    let outcomes: Vec<_> = report.resolutions.iter().map(|r| r.outcome).collect();
    assert!(report.pieces < 5, "{}", report.pieces);
    assert_eq!(outcomes[2..], [ResolutionOutcome::CutOff; 3]);
    assert!(!outcomes[..2].contains(&ResolutionOutcome::CutOff));
}

#[test]
fn the_unit_may_be_absolute() {
    let found = run_surface(&torus(32, 16), |p| p.unit = Length::Units(1.5));
    assert!((found.report.unit - 1.5).abs() < 1e-12);
}

#[test]
fn values_that_mean_nothing_are_errors() {
    let mesh = &cube([0.0; 3], 1.0);
    let (mesh, control) = (view(mesh), Control::new());
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
    let surface: [fn(&mut SurfaceParameters); 12] = [
        |p| p.simplification_quality = 0.0,
        |p| p.simplification_quality = f64::NAN,
        |p| p.maximum_resolutions.clear(),
        |p| p.maximum_resolutions.push(0),
        |p| p.planar_thresholds.clear(),
        |p| p.planar_thresholds.push(-1.0),
        |p| p.angular_threshold = f64::INFINITY,
        |p| p.concavity_cost_threshold = 0.0,
        |p| p.concavity_threshold = Some(0.0),
        |p| p.concavity_threshold = Some(f64::NAN),
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
fn slices_give_the_same_and_progress_never_falls() {
    let mesh = torus(32, 16);
    for (method, least_slices) in both_methods().into_iter().zip([5, 8]) {
        let seen = Arc::new(Mutex::new(Vec::new()));
        let listener = Arc::clone(&seen);
        let control = Control::new().with_parallel(false).with_progress(move |progress| {
            listener.lock().unwrap().push((progress.stage, progress.fraction));
        });
        let mut decomposer = method.decomposer(view(&mesh), &control).unwrap();
        let mut slices = 1;
        let sliced = loop {
            match decomposer.step().unwrap() {
                Some(result) => break result,
                None => slices += 1,
            }
        };
        assert!(slices >= least_slices, "{slices}");
        assert_eq!(decomposer.step(), Err(Error::Finished));
        let whole = method.decompose(view(&mesh), &Control::new()).unwrap();
        assert_eq!(sliced.report, whole.report);
        assert_eq!((sliced.hulls, sliced.grouped), (whole.hulls, whole.grouped));
        let seen = seen.lock().unwrap();
        assert!(seen.windows(2).all(|pair| pair[0].1 <= pair[1].1));
        assert_eq!(seen.last().map(|last| last.1), Some(1.0));
        let simplifying = seen.iter().filter(|progress| progress.0 == Stage::Simplify).count();
        // 1024 triangles, which become 819, 655, 524, 419, 335, 268 and 214.
        let steps = match &method {
            Method::Surface(parameters) => parameters.maximum_resolutions.len() + 7,
            _ => 1,
        };
        assert_eq!(simplifying, steps);
    }
}

#[test]
fn the_single_hull_is_that_of_all_points() {
    let apart = join(&[cube([0.0; 3], 1.0), cube([3.0, 0.0, 0.0], 1.0)]);
    for mesh in [torus(24, 12), l_prism(), apart] {
        let expected = hullwright::convex_hull(&mesh.0).unwrap();
        let made = single_hull(view(&mesh), None, &Control::new()).unwrap();
        assert_eq!(made.hulls.len(), 1);
        let hull = &made.hulls[0];
        assert!((hull.shape.volume() / expected.volume() - 1.0).abs() < 1e-9);
        assert_eq!(hull.provenance.source_triangles.len(), mesh.1.len());
        let method = Method::Hull(Parameters::default().with_max_vertices(None));
        let same = method.decompose(view(&mesh), &Control::new()).unwrap();
        assert_eq!((same.hulls, same.report), (made.hulls, MethodReport::Hull));
        let limited = single_hull(view(&mesh), Some(8), &Control::new()).unwrap();
        let limited = &limited.hulls[0];
        assert!(limited.shape.points.len() <= 8 && limited.shape.volume() >= expected.volume());
        assert!(limited.errors.simplification_growth > 0.0 || expected.points.len() <= 8);
    }
}

/// What is found can be kept by any format of serde.
#[cfg(feature = "serde")]
#[test]
fn a_decomposition_is_written_and_read() {
    let result = decompose(view(&l_prism()), &Parameters::default(), &Control::new()).unwrap();
    let text = serde_json::to_string(&result).unwrap();
    let read: Decomposition = serde_json::from_str(&text).unwrap();
    assert_eq!(read.hulls.len(), 2);
    for (read, made) in read.hulls.iter().zip(&result.hulls) {
        assert_eq!(read.provenance, made.provenance);
        assert_eq!(read.shape.triangles, made.shape.triangles);
    }
    assert_eq!(read.grouped.groups, result.grouped.groups);
    // Numbers as text may be off in the last bit.
    assert!((read.report.bound - result.report.bound).abs() < 1e-12);
}
