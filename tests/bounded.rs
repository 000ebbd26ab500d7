//! Promises of the bounded method, each checked by means of its own.

mod common;

use std::time::{Duration, Instant};

use hullwright::measure::{MeasureOptions, Measurement, measure};
use hullwright::{
    Control, Decomposition, Error, Hull, Length, MergeTree, MeshView, Parameters, Preset, decompose,
};

use common::{Mesh, l_prism, prism};

fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let (mut positions, triangles) =
        prism(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], &[[0, 1, 2], [0, 2, 3]], 1.0);
    for point in &mut positions {
        *point = [0, 1, 2].map(|k| low[k] + point[k] * (high[k] - low[k]));
    }
    (positions, triangles)
}

fn u_prism() -> Mesh {
    let outline = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    prism(&outline, &[[0, 5, 6], [0, 6, 7], [0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]], 1.0)
}

fn plus_prism() -> Mesh {
    let outline = [
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [3.0, 1.0],
        [3.0, 2.0],
        [2.0, 2.0],
        [2.0, 3.0],
        [1.0, 3.0],
        [1.0, 2.0],
        [0.0, 2.0],
        [0.0, 1.0],
        [1.0, 1.0],
    ];
    let fill = [
        [0, 1, 2],
        [0, 2, 11],
        [2, 3, 4],
        [2, 4, 5],
        [5, 6, 7],
        [5, 7, 8],
        [8, 9, 10],
        [8, 10, 11],
        [11, 2, 5],
        [11, 5, 8],
    ];
    prism(&outline, &fill, 1.0)
}

/// Rotates a closed polygon in the half-plane (radius, height) about the z axis.
fn lathe(profile: &[[f64; 2]], sides: u32) -> Mesh {
    let count = profile.len() as u32;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for side in 0..sides {
        let angle = f64::from(side) * std::f64::consts::TAU / f64::from(sides);
        positions.extend(profile.iter().map(|&[r, z]| [r * angle.cos(), r * angle.sin(), z]));
        for k in 0..count {
            let at = |side: u32, k: u32| (side % sides) * count + k % count;
            let [a, b] = [at(side, k), at(side + 1, k)];
            let [c, d] = [at(side + 1, k + 1), at(side, k + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions, triangles)
}

fn torus() -> Mesh {
    let ring = (0..16).map(|i| {
        let angle = f64::from(i) * std::f64::consts::TAU / 16.0;
        [1.0 + 0.3 * angle.cos(), 0.3 * angle.sin()]
    });
    lathe(&ring.collect::<Vec<_>>(), 32)
}

/// Of a cup whose wall is 0.1 thick. (A hole as wide as a needle in the middle of its floor keeps it
/// a lathed ring.)
const CUP_PROFILE: [[f64; 2]; 6] =
    [[0.005, 0.0], [1.0, 0.0], [1.0, 2.0], [0.9, 2.0], [0.9, 0.15], [0.005, 0.15]];

fn cup() -> Mesh {
    lathe(&CUP_PROFILE, 40)
}

/// A closed profile whose sides are divided into as many parts each.
fn finely(profile: &[[f64; 2]], parts: u32) -> Vec<[f64; 2]> {
    let ends = profile.iter().zip(profile.iter().cycle().skip(1));
    ends.flat_map(|(from, to)| {
        (0..parts).map(move |part| {
            let share = f64::from(part) / f64::from(parts);
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        })
    })
    .collect()
}

/// A cup of more triangles than are searched one by one, its rim wavy, and beside it a ribbon narrower than
/// a tenth of the bound.
fn fine_cup() -> Mesh {
    let mut cup = lathe(&finely(&CUP_PROFILE, 40), 240);
    for [x, y, z] in &mut cup.0 {
        *z += 0.02 * *z * (7.0 * y.atan2(*x)).sin();
    }
    join(&[cup, cuboid([1.3, -0.5, 0.0], [1.305, 0.5, 0.002])])
}

fn join(parts: &[Mesh]) -> Mesh {
    let mut all: Mesh = Default::default();
    for (positions, triangles) in parts {
        let offset = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(triangles.iter().map(|t| t.map(|v| v + offset)));
    }
    all
}

fn run_with((positions, triangles): &Mesh, parameters: &Parameters) -> Decomposition {
    decompose(MeshView::new(positions, triangles), parameters, &Control::new()).unwrap()
}

fn run(mesh: &Mesh) -> Decomposition {
    run_with(mesh, &Parameters::default())
}

fn judge((positions, triangles): &Mesh, hulls: &[Hull]) -> Measurement {
    let shapes: Vec<MeshView<'_>> = hulls.iter().map(MeshView::from).collect();
    let mut options = MeasureOptions::default();
    options.volume_samples = 50_000;
    measure(MeshView::new(positions, triangles), &shapes, &options, &Control::new()).unwrap()
}

/// What was promised and verified, against dense samples.
fn assert_promise(name: &str, mesh: &Mesh, result: &Decomposition) {
    let report = result.report.bounded.as_ref().unwrap();
    let measured = judge(mesh, &result.hulls);
    let diagonal = measured.diagonal;
    let rounding = 1e-6 * diagonal;
    assert!(report.protrusion_max <= report.bound + rounding, "{name}: {report:?}");
    assert!(report.uncovered_max <= report.bound + rounding, "{name}: {report:?}");
    let (phantom, exposed) =
        (measured.protrusion.max * diagonal, measured.uncovered.max * diagonal);
    assert!(phantom <= report.protrusion_max + rounding, "{name}: {phantom} {report:?}");
    assert!(exposed <= report.uncovered_max + rounding, "{name}: {exposed} {report:?}");
    assert_eq!(measured.non_convex_hulls, 0, "{name}");
    assert_eq!(measured.non_positive_volumes, 0, "{name}");
}

#[test]
fn an_l_prism_is_two_boxes() {
    let mesh = l_prism();
    let result = run(&mesh);
    assert_eq!(result.hulls.len(), 2);
    assert_promise("L", &mesh, &result);
    assert!(judge(&mesh, &result.hulls).iou.unwrap() > 0.97);
}

/// Thin sheets nearer to each other than a cell of any grid: they once cost minutes, and ended in
/// hundreds of hulls.
#[test]
fn thin_sheets_close_together_are_told_apart_under_a_small_bound() {
    let sheet = |low: f64, high: f64| cuboid([0.0, 0.0, low], [1.0, 1.0, high]);
    let body = cuboid([0.0, 0.0, 0.05], [0.5, 1.0, 0.5]);
    let mesh = join(&[sheet(0.0, 0.002), sheet(0.004, 0.006), body]);
    for (bound, hulls) in [(0.002, 2), (0.0005, 3)] {
        let mut parameters = Parameters::default();
        parameters.bounded.max_error = Length::Share(bound);
        let result = run_with(&mesh, &parameters);
        assert_eq!(result.hulls.len(), hulls, "{bound}");
        assert_promise("sheets", &mesh, &result);
    }
}

/// Hulls are public, and may have been edited before they are joined.
#[test]
fn a_merge_tree_of_edited_hulls_is_a_typed_error() {
    let mesh = l_prism();
    let mut edited = run(&mesh);
    edited.hulls[0].shape.triangles[0][0] = 1_000_000;
    let (parameters, control) = (Parameters::default(), Control::new());
    let tree = MergeTree::new(MeshView::new(&mesh.0, &mesh.1), &edited, &parameters, &control);
    assert!(matches!(tree, Err(Error::NoHull { .. })));
}

#[test]
fn convex_input_is_one_hull_at_once() {
    let profile = [[0.005, 0.0], [1.0, 0.0], [1.0, 3.0], [0.005, 3.0]];
    let mesh = lathe(&profile, 96);
    let result = run(&mesh);
    assert_eq!(result.hulls.len(), 1);
    assert_eq!(result.report.bounded.as_ref().unwrap().patches, 1);
    assert_promise("cylinder", &mesh, &result);
}

#[test]
fn a_round_solid_of_many_more_vertices_than_a_hull_may_have_is_one_hull() {
    // A hull of 64 vertices needs nearly all of the bound.
    let arc = (0..=40).map(|i| {
        let angle = std::f64::consts::PI * (f64::from(i) / 40.0 - 0.5);
        [angle.cos().max(0.002), angle.sin()]
    });
    let ball = lathe(&arc.collect::<Vec<_>>(), 80);
    let result = run(&ball);
    assert_eq!(result.hulls.len(), 1);
    assert!(result.hulls[0].shape.points.len() <= 64);
    assert_promise("ball", &ball, &result);
}

#[test]
fn a_u_prism_is_three_boxes() {
    let mesh = u_prism();
    let result = run(&mesh);
    assert_eq!(result.hulls.len(), 3);
    assert_promise("U", &mesh, &result);
}

#[test]
fn a_plus_sign_is_at_most_three_hulls() {
    let mesh = plus_prism();
    let result = run(&mesh);
    assert!(result.hulls.len() <= 3, "{}", result.hulls.len());
    assert_promise("plus", &mesh, &result);
}

#[test]
fn a_torus_is_at_most_twelve_hulls() {
    let mesh = torus();
    let result = run(&mesh);
    assert!(result.hulls.len() <= 12, "{}", result.hulls.len());
    assert_promise("torus", &mesh, &result);
}

#[test]
fn a_thin_walled_cup_stays_hollow() {
    let mesh = cup();
    let result = run(&mesh);
    assert_promise("cup", &mesh, &result);
    // A marble in the cup touches nothing above the floor.
    for z in [0.5, 1.0, 1.9] {
        for hull in &result.hulls {
            assert!(!holds(hull, [0.0, 0.0, z]), "{z}");
        }
    }
}

fn holds(hull: &Hull, [x, y, z]: [f64; 3]) -> bool {
    hull.shape.triangles.iter().all(|triangle| {
        let [a, b, c] = triangle.map(|index| hull.shape.points[index as usize]);
        let [u, v] =
            [[b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]];
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        normal[0] * (x - a[0]) + normal[1] * (y - a[1]) + normal[2] * (z - a[2]) <= 0.0
    })
}

#[test]
fn parts_that_do_not_touch_stay_apart() {
    let near = cuboid([0.0; 3], [1.0; 3]);
    let far = cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0]);
    let result = run(&join(&[near, far]));
    assert_eq!(result.hulls.len(), 2);
    assert_eq!(
        result.hulls.iter().map(|hull| hull.provenance.component).collect::<Vec<_>>(),
        [0, 1]
    );
}

#[test]
fn a_solid_has_no_void() {
    for (name, mesh) in [("L", l_prism()), ("torus", torus()), ("plus", plus_prism())] {
        let hollow = judge(&mesh, &run(&mesh).hulls).uncovered_volume.unwrap();
        assert!(hollow <= 0.01, "{name}: {hollow}");
    }
}

#[test]
fn the_promise_holds_for_every_bound() {
    for percent in [0.5, 1.0, 4.0, 8.0] {
        let mut parameters = Parameters::default();
        parameters.bounded.max_error = Length::Share(percent / 100.0);
        let mesh = torus();
        assert_promise(&format!("{percent} %"), &mesh, &run_with(&mesh, &parameters));
    }
}

#[test]
fn every_preset_keeps_the_promise() {
    for preset in [Preset::Fast, Preset::Balanced, Preset::Fine] {
        let mut parameters = Parameters::default();
        parameters.bounded.preset = preset;
        assert_promise(preset.name(), &cup(), &run_with(&cup(), &parameters));
    }
}

#[test]
fn a_bound_in_units_is_that_of_as_many_diagonals() {
    let mesh = u_prism();
    let diagonal = run(&mesh).report.diagonal;
    let mut parameters = Parameters::default();
    parameters.bounded.max_error = Length::Units(0.02 * diagonal);
    let absolute = run_with(&mesh, &parameters);
    assert!((absolute.report.bounded.unwrap().bound - 0.02 * diagonal).abs() < 1e-12);
    assert_eq!(absolute.hulls.len(), 3);
}

#[cfg(feature = "io")]
#[test]
fn the_promise_holds_on_all_bundled_models() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "glb") {
            continue;
        }
        let file = hullwright::io::read_mesh(&path).unwrap();
        let mesh = (file.mesh.positions, file.mesh.triangles);
        assert_promise(&path.display().to_string(), &mesh, &run(&mesh));
        seen += 1;
    }
    assert!(seen >= 14, "{seen}");
}

#[test]
fn hulls_keep_the_cap_on_vertices() {
    let mut parameters = Parameters::default();
    parameters.max_vertices = Some(12);
    let mesh = torus();
    let result = run_with(&mesh, &parameters);
    assert!(result.hulls.iter().all(|hull| hull.shape.points.len() <= 12));
    assert_promise("capped", &mesh, &result);
}

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
    let seen = std::sync::Arc::new(std::sync::Mutex::new(Vec::new()));
    let listener = std::sync::Arc::clone(&seen);
    let control = Control::new()
        .with_progress(move |progress| listener.lock().unwrap().push(progress.fraction));
    let mut decomposer =
        hullwright::Decomposer::new(MeshView::new(&mesh.0, &mesh.1), &Parameters::default())
            .unwrap();
    let mut slices = 1;
    let sliced = loop {
        if let Some(result) = decomposer.step(&control).unwrap() {
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
fn after_the_deadline_the_best_so_far_is_returned_and_keeps_the_promise() {
    let mesh = torus();
    let past = Instant::now() - Duration::from_secs(1);
    let control = Control::new().with_deadline(past);
    let result =
        decompose(MeshView::new(&mesh.0, &mesh.1), &Parameters::default(), &control).unwrap();
    assert!(result.report.deadline_reached);
    assert_promise("deadline", &mesh, &result);
}

fn tree_of(mesh: &Mesh) -> (Decomposition, MergeTree) {
    let result = run(mesh);
    let (parameters, control) = (Parameters::default(), Control::new());
    let tree =
        MergeTree::new(MeshView::new(&mesh.0, &mesh.1), &result, &parameters, &control).unwrap();
    (result, tree)
}

#[test]
fn the_curve_goes_down_to_one_hull_and_its_error_never_falls() {
    let (result, tree) = tree_of(&torus());
    let curve = tree.curve();
    assert_eq!(curve.first().unwrap().hulls, result.hulls.len());
    assert_eq!(curve.last().unwrap().hulls, 1);
    assert!(curve.windows(2).all(|pair| pair[1].hulls + 1 == pair[0].hulls));
    assert!(curve.windows(2).all(|pair| pair[0].error <= pair[1].error));
}

#[test]
fn every_state_of_the_tree_is_valid_and_off_by_no_more_than_it_says() {
    let mesh = u_prism();
    let (_, tree) = tree_of(&mesh);
    for point in tree.curve() {
        let hulls = tree.at_hulls(point.hulls);
        assert_eq!(hulls.len(), point.hulls);
        let measured = judge(&mesh, &hulls);
        let rounding = 1e-6 * measured.diagonal;
        assert!(measured.hausdorff * measured.diagonal <= point.error + rounding);
        assert_eq!(measured.non_convex_hulls, 0);
        let same = tree.at_error(point.error);
        assert!(same.len() <= point.hulls);
    }
    assert_eq!(tree.at_hulls(1).len(), 1);
    assert_eq!(tree.at_hulls(0).len(), 1);
    assert_eq!(tree.at_hulls(99).len(), 3);
    assert_eq!(tree.at_error(0.0).len(), 3);
}

#[test]
fn the_cap_on_hulls_is_kept_and_the_report_says_what_it_costs() {
    let mut parameters = Parameters::default();
    parameters.bounded.max_hulls = Some(2);
    let mesh = u_prism();
    let result = run_with(&mesh, &parameters);
    assert_eq!(result.hulls.len(), 2);
    let report = result.report.bounded.unwrap();
    assert!(report.protrusion_max > report.bound);
    let measured = judge(&mesh, &result.hulls);
    assert!(measured.protrusion.max * measured.diagonal <= report.protrusion_max + 1e-6);
}

#[test]
fn an_open_sheet_is_covered_by_thin_hulls() {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..=20_u32 {
        let angle = f64::from(i) * 0.15;
        positions.extend([0.0, 1.0].map(|y| [angle.cos(), y, angle.sin()]));
        if i > 0 {
            let [a, b] = [2 * i - 2, 2 * i];
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    let mesh = (positions, triangles);
    let result = run(&mesh);
    assert!(result.hulls.len() > 1);
    assert_promise("sheet", &mesh, &result);
}

fn turned((positions, triangles): &Mesh) -> Mesh {
    (positions.clone(), triangles.iter().map(|&[a, b, c]| [b, a, c]).collect())
}

#[test]
fn a_box_that_is_wound_both_ways_is_a_sheet_and_stays_hollow() {
    // Its winding number is 0 everywhere: found in models whose every side is drawn from both
    // sides, where hulls that filled the inside stood out of the surface by 8 bounds.
    let (positions, mut triangles) = cuboid([0.0; 3], [1.0, 1.2, 1.4]);
    triangles.extend(turned(&(positions.clone(), triangles.clone())).1);
    let mesh = (positions, triangles);
    let result = run(&mesh);
    assert_promise("double box", &mesh, &result);
    assert!(result.hulls.iter().all(|hull| !holds(hull, [0.5, 0.6, 0.7])));
}

#[test]
fn triangles_that_are_there_twice_change_nothing() {
    let (positions, mut triangles) = l_prism();
    triangles.extend(triangles.clone());
    assert_eq!(run(&(positions, triangles)).hulls.len(), 2);
}

#[test]
fn a_box_without_a_floor_keeps_the_promise() {
    // Its inside ends where there is no surface.
    let (positions, mut triangles) = cuboid([0.0; 3], [1.0, 1.0, 0.6]);
    triangles.retain(|triangle| triangle.iter().any(|&vertex| vertex >= 4));
    let mesh = (positions, triangles);
    assert_promise("open box", &mesh, &run(&mesh));
}

#[test]
fn a_cavity_fills_unless_it_is_to_be_kept() {
    let hollow = join(&[l_prism(), turned(&cuboid([0.4; 3], [0.6; 3]))]);
    let result = run(&hollow);
    assert_promise("filled", &hollow, &result);
    assert!(result.hulls.iter().any(|hull| holds(hull, [0.5; 3])));
    let mut parameters = Parameters::default();
    parameters.bounded.keep_cavities = true;
    let result = run_with(&hollow, &parameters);
    assert_promise("kept", &hollow, &result);
    assert!(result.hulls.iter().all(|hull| !holds(hull, [0.5; 3])));
    // Who keeps cavities has the same hulls where there are none.
    assert_eq!(run_with(&l_prism(), &parameters).hulls, run(&l_prism()).hulls);
}

#[test]
fn the_tips_of_sharp_plates_are_covered() {
    // Beyond an edge as sharp as this a point is far away that is hardly in front of any face.
    let rim: Vec<[f64; 2]> = vec![[0.0, 0.001], [0.7, 0.0003], [1.0, 0.0], [0.7, -0.0003]];
    let lens = lathe(&[&rim[..], &[[0.0, -0.001]]].concat(), 24);
    let plates = join(&[lens.clone(), {
        let (positions, triangles) = lens;
        (
            positions.iter().map(|&[x, y, z]| [x, z, y + 1.2]).collect(),
            turned(&(vec![], triangles)).1,
        )
    }]);
    let result = run(&plates);
    assert_promise("plates", &plates, &result);
    let judged = judge(&plates, &result.hulls);
    assert!(judged.uncovered.max < 0.002, "{}", judged.uncovered.max);
}

/// A triangle, not shrunk to a line, that no hull stands for.
fn lost((positions, triangles): &Mesh, result: &Decomposition) -> Option<usize> {
    let mut is_held = vec![false; triangles.len()];
    for &triangle in result.hulls.iter().flat_map(|hull| &hull.provenance.source_triangles) {
        is_held[triangle as usize] = true;
    }
    let has_area = |triangle: usize| {
        let [a, b, c] = triangles[triangle].map(|vertex| positions[vertex as usize]);
        a != b && b != c && c != a
    };
    (0..triangles.len()).find(|&triangle| !is_held[triangle] && has_area(triangle))
}

#[test]
fn of_very_many_triangles_none_is_lost_and_the_promise_holds() {
    let mesh = fine_cup();
    let result = run(&mesh);
    let report = result.report.bounded.as_ref().unwrap();
    assert!(mesh.1.len() > 100_000 && report.polygons < 10_000);
    assert_promise("fine cup", &mesh, &result);
    assert!(report.uncovered_max <= 0.1 * report.bound, "{report:?}");
    assert!(result.hulls.len() <= run(&cup()).hulls.len() + 3, "{}", result.hulls.len());
    assert!(!result.hulls.iter().any(|hull| holds(hull, [0.3, 0.0, 1.0])), "the cup is filled");
    assert_eq!(lost(&mesh, &result), None);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| run(&mesh).hulls), result.hulls);
}

#[test]
fn of_very_many_long_triangles_none_is_lost() {
    // A drum of thin staves, which refinement leaves long, and beside it, flush with its top, a dense brick.
    let drum = lathe(&[[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]], 13_000);
    let profile = [[0.001, 0.6], [0.3, 0.6], [0.3, 1.0], [0.001, 1.0]];
    let mut brick = lathe(&finely(&profile, 400), 120);
    brick.0.iter_mut().for_each(|point| point[0] += 1.305);
    let mesh = join(&[brick, drum]);
    let result = run(&mesh);
    let report = result.report.bounded.as_ref().unwrap();
    assert!(report.protrusion_max <= report.bound && report.uncovered_max <= 0.1 * report.bound);
    assert_eq!(result.hulls.len(), 2);
    let volume: f64 = result.hulls.iter().map(|hull| hull.shape.volume()).sum();
    let expected = std::f64::consts::PI * (2.0 + 0.4 * 0.3 * 0.3);
    assert!((volume - expected).abs() < 0.02 * expected, "{volume}");
    assert_eq!(lost(&mesh, &result), None);
}

#[test]
fn plates_and_rods_far_thinner_than_the_bound_stay_what_they_are() {
    // All but four corners hardly stand out of the others' hull: once that was a tetrahedron, and two thirds of
    // the plate were empty.
    for extent in [[1.0, 1.0, 0.001], [1.0, 1.0, 0.0003], [1.0, 0.001, 0.001]] {
        let plate = cuboid([0.0; 3], extent);
        let result = run(&plate);
        assert_eq!(result.hulls.len(), 1);
        let volume: f64 = extent.iter().product();
        assert!(
            result.hulls[0].shape.volume() > 0.95 * volume,
            "{extent:?}: {}",
            result.hulls[0].shape.volume()
        );
    }
}

#[test]
fn a_cap_that_divides_a_ball_leaves_its_middle_filled() {
    let rim = (0..=24).map(|i| {
        let angle = f64::from(i) * std::f64::consts::PI / 24.0;
        [angle.sin().max(0.001), -angle.cos()]
    });
    let ball = lathe(&rim.collect::<Vec<_>>(), 48);
    let mut parameters = Parameters::default();
    parameters.max_vertices = Some(12);
    let result = run_with(&ball, &parameters);
    assert!(result.hulls.len() > 1);
    assert!(result.hulls.iter().all(|hull| hull.shape.points.len() <= 12));
    assert_promise("ball", &ball, &result);
    // Hulls of the surface alone left half of it empty.
    let hollow = judge(&ball, &result.hulls).uncovered_volume;
    assert!(hollow.is_some_and(|hollow| hollow < 0.01), "{hollow:?}");
}

#[test]
fn hulls_that_verification_divided_join_again() {
    // Once a cube drawn from both sides became 244 shreds.
    let (positions, mut triangles) = cuboid([0.0; 3], [1.0; 3]);
    triangles.extend(turned(&(positions.clone(), triangles.clone())).1);
    let mesh = (positions, triangles);
    let result = run(&mesh);
    assert_promise("double cube", &mesh, &result);
    assert!(result.hulls.len() <= 40, "{}", result.hulls.len());
}

#[test]
fn the_fine_preset_has_no_more_hulls() {
    let mut fine = Parameters::default();
    fine.bounded.preset = Preset::Fine;
    for mesh in [torus(), cup(), plus_prism()] {
        assert!(run_with(&mesh, &fine).hulls.len() <= run(&mesh).hulls.len());
    }
}

#[test]
fn long_needles_are_no_reason_to_divide() {
    // A tube of 300 facets once became 5,000 seeds.
    let tube = lathe(&[[0.2, -0.5], [0.22, -0.5], [0.22, 0.5], [0.2, 0.5]], 300);
    let result = run(&tube);
    let seeds = result.report.bounded.as_ref().unwrap().patches;
    assert!(seeds < 1500, "{seeds}");
    assert_promise("tube", &tube, &result);
}
