//! What `measure` promises: known answers, and that no hull set makes it panic.

use hullwright::measure::{MeasureOptions, Measurement, VerifiedDistances, measure, verify};
use hullwright::{Control, Error, MeshView, Openings, Parameters, decompose};

use crate::common::{Mesh, bundled_models, cuboid, join, l_prism, polygon, prism, turned, view};

fn unit_cube() -> Mesh {
    cuboid([0.0; 3], [1.0; 3])
}

fn try_measure(
    mesh: &Mesh,
    hulls: &[Mesh],
    options: &MeasureOptions,
    control: &Control,
) -> Result<Measurement, Error> {
    let hulls: Vec<MeshView<'_>> = hulls.iter().map(view).collect();
    measure(view(mesh), &hulls, options, control)
}

fn judged(mesh: &Mesh, hulls: &[Mesh]) -> Measurement {
    judged_with(mesh, hulls, |_| {})
}

fn judged_with(
    mesh: &Mesh,
    hulls: &[Mesh],
    change: impl FnOnce(&mut MeasureOptions),
) -> Measurement {
    let mut options = MeasureOptions::default();
    change(&mut options);
    try_measure(mesh, hulls, &options, &Control::new()).unwrap()
}

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} ± {tolerance}");
}

const ROUNDING: f64 = 1e-9;

/// Error of a share of 200,000 evenly spread points.
const COUNTING: f64 = 2e-3;

#[test]
fn a_box_and_its_own_hull_agree_in_everything() {
    let found = judged(&unit_cube(), &[unit_cube()]);
    assert_eq!((found.hulls, found.vertices, found.unusable_hulls), (1, 8, 0));
    assert_eq!((found.non_convex_hulls, found.open_hulls, found.non_positive_volumes), (0, 0, 0));
    assert_near(found.protrusion.max, 0.0, ROUNDING);
    assert_eq!(found.uncovered.max, 0.0);
    assert_near(found.hausdorff, 0.0, ROUNDING);
    assert_eq!(
        (found.iou, found.uncovered_volume, found.overlap),
        (Some(1.0), Some(0.0), Some(1.0))
    );
    assert_eq!(found.open_edges, 0.0);
    assert_near(found.diagonal, 3_f64.sqrt(), 1e-15);
    assert_near(found.checks[0].unwrap().volume, 1.0, 1e-12);
    assert!(found.checks[0].unwrap().is_closed);
}

#[test]
fn a_crack_beside_a_triangle_without_area_is_no_hole() {
    // One of two triangles at an edge has a vertex in its middle, a little beside it: less than a
    // weld. What closes that crack is no triangle of the source.
    let (mut positions, mut triangles) = unit_cube();
    let [a, b, c] = triangles[0];
    let middle = positions.len() as u32;
    let (start, end, third) = (positions[a as usize], positions[b as usize], positions[c as usize]);
    let beside = |axis: usize| 0.5 * (start[axis] + end[axis]) + 1e-7 * (third[axis] - end[axis]);
    positions.push([0, 1, 2].map(beside));
    triangles.splice(0..1, [[a, middle, c], [middle, b, c], [a, b, b]]);
    let cracked = (positions, triangles);
    let found = judged(&cracked, &[unit_cube()]);
    assert_near(found.uncovered.max, 0.0, 1e-6);
    assert_near(found.protrusion.max, 0.0, 1e-6);
}

#[test]
fn a_hull_grown_on_one_side_protrudes_by_that_much() {
    let found = judged(&unit_cube(), &[cuboid([0.0; 3], [1.25, 1.0, 1.0])]);
    assert_near(found.protrusion.max, 0.25 / 3_f64.sqrt(), ROUNDING);
    assert_near(found.protrusion.p99, 0.25 / 3_f64.sqrt(), ROUNDING);
    // The far face has 1 of 7 areas at 0.25, the four sides 0.25 each at 0.125 on average; of the
    // latter's points those under the old face don't count.
    let mean = (1.0 * 0.25 + 4.0 * 0.25 * 0.125) / 7.0;
    assert_near(found.protrusion.mean, mean / 3_f64.sqrt(), 1e-4);
    assert_eq!(found.uncovered.max, 0.0);
    assert_eq!(found.hausdorff, found.protrusion.max);
    assert_near(found.iou.unwrap(), 0.8, COUNTING);
    assert_eq!(found.uncovered_volume, Some(0.0));
}

#[test]
fn a_missing_half_is_uncovered_and_hollow() {
    let found = judged(&unit_cube(), &[cuboid([0.0; 3], [0.5, 1.0, 1.0])]);
    assert_near(found.uncovered.max, 0.5 / 3_f64.sqrt(), ROUNDING);
    assert_near(found.uncovered.mean, (0.5 + 4.0 * 0.5 * 0.25) / 6.0 / 3_f64.sqrt(), 1e-4);
    assert_near(found.protrusion.max, 0.0, ROUNDING);
    assert_eq!(found.hausdorff, found.uncovered.max);
    assert_near(found.uncovered_volume.unwrap(), 0.5, COUNTING);
    assert_near(found.iou.unwrap(), 0.5, COUNTING);
}

#[test]
fn duplicate_hulls_overlap_twice_and_change_nothing_else() {
    let once = judged(&unit_cube(), &[unit_cube()]);
    let twice = judged(&unit_cube(), &[unit_cube(), unit_cube()]);
    assert_eq!(twice.overlap, Some(2.0));
    assert_eq!((twice.iou, twice.uncovered_volume), (once.iou, once.uncovered_volume));
    assert_near(twice.hausdorff, 0.0, ROUNDING);
}

#[test]
fn hulls_that_share_a_face_leave_no_gap() {
    let thirds = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];
    let slabs: Vec<Mesh> = thirds
        .windows(2)
        // Rounded as in files with coordinates in single precision.
        .map(|x| cuboid([f64::from(x[0] as f32), 0.0, 0.0], [f64::from(x[1] as f32), 1.0, 1.0]))
        .collect();
    let found = judged(&unit_cube(), &slabs);
    assert_eq!(found.uncovered.max, 0.0);
    assert_eq!(found.uncovered_volume, Some(0.0));
    assert_near(found.protrusion.max, 0.0, ROUNDING);
    assert_near(found.overlap.unwrap(), 1.0, 1e-4);
}

#[test]
fn what_is_inside_another_hull_is_no_boundary() {
    // A small box inside of a larger hull that fills the mesh's gap.
    let (left, right) = (cuboid([0.0; 3], [1.0; 3]), cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0]));
    let all = cuboid([0.0; 3], [4.0, 1.0, 1.0]);
    let within = cuboid([1.6, 0.4, 0.4], [2.4, 0.6, 0.6]);
    let mesh = join(&[left, right]);
    let alone = judged(&mesh, std::slice::from_ref(&all));
    let both = judged(&mesh, &[all, within]);
    assert!(both.samples.boundary < both.samples.hull);
    assert_near(both.protrusion.mean, alone.protrusion.mean, 1e-3);
    assert_near(both.protrusion.max, alone.protrusion.max, 1e-3);
}

#[test]
fn the_hull_of_a_u_fills_its_gap() {
    // Legs of width 1 and height 3 on a base of height 1, gap of width 2 and height 3.
    let outline =
        polygon(&[0.0, 0.0, 4.0, 0.0, 4.0, 4.0, 3.0, 4.0, 3.0, 1.0, 1.0, 1.0, 1.0, 4.0, 0.0, 4.0]);
    let found = judged(&prism(&outline, 5.0), &[cuboid([0.0; 3], [4.0, 4.0, 5.0])]);
    // Farthest is the middle of the mouth, half a gap from both legs.
    let diagonal = (16.0_f64 + 16.0 + 25.0).sqrt();
    assert_near(found.protrusion.max, 1.0 / diagonal, 1e-3);
    assert_eq!(found.uncovered.max, 0.0);
    assert_near(found.iou.unwrap(), 10.0 / 16.0, COUNTING);
    assert_eq!(found.uncovered_volume, Some(0.0));
}

#[test]
fn a_cavity_is_solid_unless_it_is_kept() {
    let outer = cuboid([0.0; 3], [1.0; 3]);
    let hollow = join(&[outer.clone(), turned(&cuboid([0.25; 3], [0.75; 3]))]);
    let filled = judged(&hollow, std::slice::from_ref(&outer));
    assert_near(filled.iou.unwrap(), 1.0, COUNTING);
    let kept = |hull| judged_with(&hollow, &[hull], |options| options.keep_cavities = true);
    let found = kept(outer);
    assert_near(found.iou.unwrap(), 7.0 / 8.0, COUNTING);
    assert_near(found.protrusion.max, 0.0, ROUNDING);
    let inner = kept(cuboid([0.25; 3], [0.75; 3]));
    assert_eq!(inner.iou, Some(0.0));
    assert_eq!(inner.uncovered_volume, Some(1.0));
}

#[test]
fn an_open_sheet_has_distances_but_no_volume() {
    let sheet: Mesh = (
        vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let found = judged(&sheet, &[cuboid([0.0, 0.0, -0.1], [1.0, 1.0, 0.2])]);
    assert_near(found.protrusion.max, 0.2 / 2_f64.sqrt(), ROUNDING);
    assert_eq!(found.uncovered.max, 0.0);
    assert_eq!((found.iou, found.uncovered_volume), (None, None));
    assert_eq!(found.open_edges, 0.8);
    assert_eq!(found.overlap, Some(1.0));
}

#[test]
fn a_hole_does_not_turn_the_solid_inside_out() {
    let mut open = unit_cube();
    open.1.remove(0);
    let hull = [cuboid([0.1; 3], [0.9; 3])];
    let found = judged_with(&open, &hull, |options| options.openings = Openings::Keep);
    assert_near(found.protrusion.max, 0.0, ROUNDING);
    assert_eq!(found.iou, None);
    let closed = judged(&open, &hull);
    assert_near(closed.iou.unwrap(), 0.512, COUNTING);
}

#[test]
fn a_mesh_inside_out_is_turned_around() {
    let hulls = [cuboid([0.1; 3], [1.2; 3])];
    let (outward, inward) = (judged(&unit_cube(), &hulls), judged(&turned(&unit_cube()), &hulls));
    assert_eq!(inward.iou, outward.iou);
    assert_near(inward.protrusion.mean, outward.protrusion.mean, 1e-9);
}

#[test]
fn an_l_is_not_convex() {
    let l = l_prism();
    let found = judged(&l, &[l.clone(), unit_cube()]);
    assert_eq!((found.hulls, found.non_convex_hulls, found.open_hulls), (2, 1, 0));
    // The end of one leg lies a whole leg in front of the other's inner face.
    assert_near(found.worst_concavity, 1.0 / 3.0, 1e-12);
    assert_eq!(found.checks[1].unwrap().concavity, 0.0);
    // It is judged as what an engine makes of it: its convex hull.
    assert_near(found.iou.unwrap(), 3.0 / 3.5, COUNTING);
}

#[test]
fn a_hull_wound_inward_or_anyhow_is_flagged_and_judged_by_its_points() {
    let expected = judged(&unit_cube(), &[cuboid([0.1; 3], [1.2; 3])]);
    let inward = turned(&cuboid([0.1; 3], [1.2; 3]));
    let mut mixed = cuboid([0.1; 3], [1.2; 3]);
    mixed.1[3].swap(0, 1);
    let mut torn = cuboid([0.1; 3], [1.2; 3]);
    torn.1.truncate(9);
    for (hull, flags) in [(inward, (0, 1)), (mixed, (1, 0)), (torn, (1, 0))] {
        let found = judged(&unit_cube(), &[hull]);
        assert_eq!((found.open_hulls, found.non_positive_volumes), flags);
        assert_eq!((found.protrusion, found.uncovered), (expected.protrusion, expected.uncovered));
        assert_eq!((found.iou, found.non_convex_hulls), (expected.iou, 0));
    }
}

#[test]
fn a_flat_hull_holds_nothing_but_is_a_surface() {
    let square: Mesh = (
        vec![[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let found = judged(&unit_cube(), &[square]);
    assert_eq!((found.hulls, found.non_positive_volumes, found.open_hulls), (1, 1, 1));
    assert!(found.checks[0].unwrap().is_flat);
    assert_eq!((found.uncovered_volume, found.iou, found.overlap), (Some(1.0), Some(0.0), None));
    assert_near(found.uncovered.max, 0.5 / 3_f64.sqrt(), ROUNDING);
    assert_near(found.protrusion.max, 0.0, ROUNDING);
}

#[test]
fn garbage_among_hulls_is_counted_and_left_out() {
    let expected = judged(&unit_cube(), &[unit_cube()]);
    let (points, triangles) = unit_cube();
    let mut not_finite = points.clone();
    not_finite[3][1] = f64::NAN;
    let mut far = points.clone();
    far[3][1] = 1e300;
    let garbage: [Mesh; 6] = [
        (vec![], vec![]),
        (points.clone(), vec![]),
        (vec![], triangles.clone()),
        (points[..7].to_vec(), triangles.clone()),
        (not_finite, triangles.clone()),
        (far, triangles.clone()),
    ];
    let mut hulls = garbage.to_vec();
    hulls.insert(2, (points, triangles));
    let found = judged(&unit_cube(), &hulls);
    assert_eq!((found.hulls, found.unusable_hulls), (1, 6));
    assert_eq!((found.protrusion, found.uncovered), (expected.protrusion, expected.uncovered));
    let judged: Vec<bool> = found.checks.iter().map(Option::is_some).collect();
    assert_eq!(judged, [false, false, true, false, false, false, false]);

    let (options, control) = (MeasureOptions::default(), Control::new());
    let error = |hulls: &[Mesh]| try_measure(&unit_cube(), hulls, &options, &control).err();
    assert!(matches!(error(&garbage), Some(Error::UnusableHull { hull: 0, .. })));
    assert_eq!(error(&[]), Some(Error::NoHulls));
}

#[test]
fn hulls_without_extent_do_not_panic() {
    let spot: Mesh = (vec![[0.5; 3]; 3], vec![[0, 1, 2]]);
    let line: Mesh = (vec![[0.0; 3], [0.5; 3], [1.0; 3]], vec![[0, 1, 2], [2, 1, 0]]);
    for hulls in [vec![spot.clone()], vec![line.clone()], vec![spot, line, unit_cube()]] {
        let found = judged(&unit_cube(), &hulls);
        assert!(found.protrusion.max.is_finite() && found.uncovered.mean.is_finite());
        assert!(found.non_positive_volumes >= 1);
    }
}

#[test]
fn a_mesh_that_can_not_be_judged_is_an_error() {
    let (positions, triangles) = unit_cube();
    let cube = [unit_cube()];
    let run = |positions: &[[f64; 3]], triangles: &[[u32; 3]]| {
        let mesh = (positions.to_vec(), triangles.to_vec());
        try_measure(&mesh, &cube, &MeasureOptions::default(), &Control::new()).map(|_| ())
    };
    assert_eq!(run(&[], &triangles), Err(Error::EmptyMesh { vertices: 0, triangles: 12 }));
    assert_eq!(run(&positions, &[]), Err(Error::EmptyMesh { vertices: 8, triangles: 0 }));
    assert_eq!(
        run(&positions, &[[0, 1, 2], [1, 2, 8]]),
        Err(Error::IndexOutOfRange { triangle: 1, index: 8, vertices: 8 })
    );
    assert_eq!(
        run(&[[f64::NAN; 3], [1.0; 3]], &[[0, 1, 1], [1, 1, 1]]),
        Err(Error::NothingUsable { triangles: 2, degenerate: 1, non_finite: 1 })
    );
}

#[test]
fn triangles_that_are_not_finite_or_without_area_are_left_out_with_their_corners() {
    let [far, farther, infinite] =
        [[1e30, 0.0, 0.0], [1e308, -1e308, 0.0], [f64::INFINITY, 0.0, 0.0]];
    for (corner, triangle) in [(far, [8, 8, 0]), (farther, [8, 8, 0]), (infinite, [0, 1, 8])] {
        let (mut positions, mut triangles) = unit_cube();
        positions.push(corner);
        triangles.push(triangle);
        let found = judged(&(positions, triangles), &[unit_cube()]);
        assert_eq!(found, judged(&unit_cube(), &[unit_cube()]));
    }
}

#[test]
fn random_points_are_the_same_for_a_seed_on_any_number_of_threads_and_others_for_another() {
    let wide = [cuboid([0.0; 3], [1.2, 1.0, 1.0])];
    let of = |seed: u64, parallel: bool| {
        let mut options = MeasureOptions::default();
        options.random_seed = Some(seed);
        let control = Control::new().with_parallel(parallel);
        try_measure(&unit_cube(), &wide, &options, &control).unwrap()
    };
    assert_eq!(of(1, true), of(1, false));
    assert_ne!(of(1, true), of(2, true));
    let even = judged(&unit_cube(), &wide).protrusion.mean;
    assert!((of(1, true).protrusion.mean - even).abs() < 0.02 * even);
}

/// A needle thinner than repair's welding is dropped by `decompose`, and was held against its
/// hulls.
#[test]
fn a_needle_that_repair_takes_for_a_line_leaves_nothing_uncovered() {
    let mesh = join(&[unit_cube(), cuboid([0.5, 0.5, 1.5], [0.5 + 1e-7, 0.5 + 1e-7, 4.5])]);
    let found = judged(&mesh, &[unit_cube()]);
    assert!(found.uncovered.max < 1e-6, "{:?}", found.uncovered);
    let plate = join(&[unit_cube(), cuboid([0.0, 0.0, 1.5], [1.0, 1.0, 1.5 + 1e-7])]);
    assert!(judged(&plate, &[unit_cube()]).uncovered.max > 0.1, "a plate is a surface");
}

#[test]
fn vertices_that_no_triangle_uses_do_not_count_for_the_diagonal() {
    let (mut positions, triangles) = unit_cube();
    positions.push([100.0; 3]);
    assert_near(judged(&(positions, triangles), &[unit_cube()]).diagonal, 3_f64.sqrt(), 1e-15);
}

#[test]
fn options_that_mean_nothing_are_errors() {
    let name = |change: fn(&mut MeasureOptions)| {
        let mut options = MeasureOptions::default();
        change(&mut options);
        match try_measure(&unit_cube(), &[unit_cube()], &options, &Control::new()) {
            Err(Error::InvalidParameter { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(name(|options| options.hull_samples = 0), "hull_samples");
    assert_eq!(name(|options| options.mesh_samples = 0), "mesh_samples");
    assert_eq!(name(|options| options.convexity_tolerance = f64::NAN), "convexity_tolerance");
}

#[test]
fn size_and_place_do_not_matter() {
    let mesh = join(&[unit_cube(), cuboid([2.0, 0.0, 0.0], [3.0, 0.5, 0.7])]);
    let hulls = [cuboid([-0.1; 3], [1.1; 3]), cuboid([1.9, 0.1, 0.1], [3.0, 0.7, 0.7])];
    let expected = judged(&mesh, &hulls);
    for (factor, shift) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 3000.0)] {
        let moved = |(positions, triangles): &Mesh| -> Mesh {
            let place = |point: &[f64; 3]| point.map(|x| factor * (x + shift));
            (positions.iter().map(place).collect(), triangles.clone())
        };
        let found = judged(&moved(&mesh), &hulls.each_ref().map(moved));
        assert_near(found.protrusion.max, expected.protrusion.max, 1e-6);
        assert_near(found.protrusion.mean, expected.protrusion.mean, 1e-4);
        assert_near(found.uncovered.max, expected.uncovered.max, 1e-6);
        assert_near(found.iou.unwrap(), expected.iou.unwrap(), 1e-4);
        assert_near(found.diagonal, factor * expected.diagonal, 1e-9 * factor);
    }
}

#[test]
fn threads_do_not_matter() {
    let hulls = [cuboid([-0.1; 3], [0.6, 1.1, 1.0]), cuboid([0.5, 0.1, 0.0], [1.0, 1.0, 1.2])];
    let of = |is_parallel| {
        let control = Control::new().with_parallel(is_parallel);
        try_measure(&unit_cube(), &hulls, &MeasureOptions::default(), &control).unwrap()
    };
    assert_eq!(of(true), of(false));
}

#[test]
fn the_counts_of_samples_are_stated() {
    let hulls = [unit_cube(), cuboid([2.0, 0.0, 0.0], [3.0, 1.0, 1.0])];
    let found = judged_with(&unit_cube(), &hulls, |options| {
        (options.hull_samples, options.mesh_samples, options.volume_samples) = (1000, 500, 2000);
    });
    let samples = found.samples;
    assert_eq!((samples.hull, samples.boundary), (1000, 1000));
    assert_eq!((samples.mesh, samples.volume), (500, 2000));
    assert_near(samples.solid as f64 / 2000.0, 1.0 / 3.0, 0.01);
    assert_near(samples.union as f64 / 2000.0, 2.0 / 3.0, 0.01);
    assert_eq!(samples.in_hulls, samples.union);
}

#[test]
fn without_samples_in_space_there_are_no_volumes() {
    let found = judged_with(&unit_cube(), &[unit_cube()], |options| options.volume_samples = 0);
    assert_eq!((found.iou, found.uncovered_volume, found.overlap), (None, None, None));
}

#[test]
fn triangles_wound_at_random_have_the_same_inside() {
    let mut mesh = unit_cube();
    for triangle in mesh.1.iter_mut().step_by(3) {
        triangle.swap(0, 1);
    }
    let half = cuboid([0.0; 3], [1.0, 1.0, 0.5]);
    let [expected, found] =
        [unit_cube(), mesh].map(|mesh| judged(&mesh, std::slice::from_ref(&half)));
    assert_near(found.protrusion.max, expected.protrusion.max, ROUNDING);
    assert_near(expected.protrusion.max, 0.0, ROUNDING);
    assert_near(found.uncovered_volume.unwrap(), 0.5, COUNTING);
}

#[test]
fn an_open_box_wound_inward_is_a_sheet_without_an_inside() {
    let mut open = unit_cube();
    // Without its lid.
    open.1.truncate(10);
    let inside = cuboid([0.25; 3], [0.75; 3]);
    let wound_outward = judged(&open, std::slice::from_ref(&inside));
    let wound_inward = judged(&turned(&open), &[inside]);
    assert_near(wound_outward.protrusion.max, 0.0, ROUNDING);
    assert!(wound_inward.protrusion.max > 0.1);
}

#[test]
fn verified_distances_are_upper_bounds_that_are_nearly_reached() {
    let cube = unit_cube();
    let diagonal = 3_f64.sqrt();
    for height in [0.0001, 0.003, 0.02, 0.1, 0.7] {
        let taller = cuboid([0.0; 3], [1.0, 1.0, 1.0 + height]);
        let found = verified(&cube, std::slice::from_ref(&taller));
        let expected = height / diagonal;
        assert_near(found.diagonal, diagonal, 1e-15);
        let above = found.protrusion_max - expected;
        assert!((0.0..=found.resolution + 1e-6).contains(&above), "{height}: {found:?}");
        assert!(found.resolution < 0.015 * expected.max(1e-4 / 0.015), "{height}: {found:?}");
        assert!(
            found.uncovered_max <= 0.03 * found.protrusion_max.max(1e-4),
            "{height}: {found:?}"
        );
        // The other way round it is the mesh that lies outside.
        let found = verified(&taller, &[unit_cube()]);
        let expected = height / found.diagonal;
        let above = found.uncovered_max - expected;
        assert!((-1e-9..=found.resolution + 1e-6).contains(&above), "{height}: {found:?}");
    }
}

#[test]
fn a_spike_that_samples_miss_is_verified() {
    // A needle on a face: hardly any point of the surface is near its tip.
    let (mut positions, mut triangles) = unit_cube();
    let base = positions.len() as u32;
    positions.extend([[0.5, 0.5, 1.0], [0.5001, 0.5, 1.0], [0.5, 0.5001, 1.0], [0.5, 0.5, 1.5]]);
    triangles.extend([[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]].map(|t| t.map(|v| base + v)));
    let needle = (positions, triangles);
    let sampled = judged(&needle, &[unit_cube()]);
    let found = verified(&needle, &[unit_cube()]);
    let expected = 0.5 / found.diagonal;
    assert!(sampled.uncovered.max < 0.95 * expected, "{}", sampled.uncovered.max);
    assert!((expected - 1e-9..1.02 * expected).contains(&found.uncovered_max), "{found:?}");
}

#[test]
fn what_cannot_be_judged_is_left_out_of_verification_and_flat_hulls_are_judged() {
    let cube = unit_cube();
    let unusable = (vec![[f64::NAN; 3]; 3], vec![[0, 1, 2]]);
    let flat = (vec![[0.0, 0.0, 1.3], [1.0, 0.0, 1.3], [0.0, 1.0, 1.3]], vec![[0, 1, 2]]);
    let found = verified(&cube, &[unusable.clone(), unit_cube(), flat]);
    let expected = 0.3 / found.diagonal;
    assert!((expected - 1e-9..1.02 * expected).contains(&found.protrusion_max), "{found:?}");
    assert!(found.uncovered_max <= 0.03 * found.protrusion_max, "{found:?}");
    // A sheet is covered by itself.
    let sheet = (vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let found = verified(&sheet, std::slice::from_ref(&sheet));
    assert!(found.protrusion_max < 1e-4 && found.uncovered_max < 1e-4, "{found:?}");
    let control = Control::new();
    let try_verify = |hulls: &[Mesh]| {
        let hulls: Vec<MeshView<'_>> = hulls.iter().map(view).collect();
        verify(view(&cube), &hulls, &MeasureOptions::default(), &control)
    };
    assert_eq!(try_verify(&[]), Err(Error::NoHulls));
    assert!(matches!(try_verify(&[unusable]), Err(Error::UnusableHull { hull: 0, .. })));
    control.cancel();
    assert_eq!(try_verify(&[unit_cube()]), Err(Error::Cancelled));
}

#[test]
fn verification_finds_no_more_than_a_decomposition_says_of_itself() {
    for (name, mesh) in bundled_models() {
        let control = Control::new();
        let made = decompose(&mesh, &Parameters::default(), &control).unwrap();
        let found = verify(&mesh, &made.hulls, &MeasureOptions::default(), &control).unwrap();
        let report = &made.report;
        for (verified, said) in [
            (found.protrusion_max, report.protrusion_max),
            (found.uncovered_max, report.uncovered_max),
        ] {
            // What is far below the bound is not resolved there.
            let most = said / made.run.diagonal + found.resolution;
            assert!(verified <= most + 1e-6, "{name}: {found:?} {report:?}");
        }
    }
}

fn verified(mesh: &Mesh, hulls: &[Mesh]) -> VerifiedDistances {
    let hulls: Vec<MeshView<'_>> = hulls.iter().map(view).collect();
    verify(view(mesh), &hulls, &MeasureOptions::default(), &Control::new()).unwrap()
}
