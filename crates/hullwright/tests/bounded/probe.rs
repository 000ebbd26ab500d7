//! What a probe promises: no ball that comes from outside is entered by more than the bound, and
//! what none can reach may be filled.

use hullwright::measure::{MeasureOptions, MeasuredMesh, measure};
use hullwright::{
    Control, Decomposition, Error, Length, MergeTree, Openings, Parameters, decompose,
};

use crate::common::{
    CUP_PROFILE, Mesh, Point, ball, both_ways, comb, cuboid, cup, is_filled, join, lathe,
    open_sheet, plus_prism, prism, run, run_with, torus, turned, view,
};
use crate::independent::oracle::{Convex, Triangle};
use crate::independent::paths::deepest_entry;

/// In the units of the shapes.
const BOUND: f64 = 0.05;

fn with_radius(radius: f64) -> Parameters {
    Parameters::default()
        .with_max_error(Length::units(BOUND))
        .with_probe_radius(Length::units(radius))
}

fn with_probe(mesh: &Mesh, radius: f64) -> Decomposition {
    run_with(mesh, &with_radius(radius))
}

/// Walks with a ball as far as it goes, and says how far hulls enter it.
fn entered(mesh: &Mesh, found: &Decomposition, radius: f64, from: &[Point]) -> f64 {
    let surface = Triangle::all(&mesh.0, &mesh.1);
    let hulls: Vec<Convex> = found
        .hulls
        .iter()
        .map(|hull| Convex::new(&hull.shape.points, &hull.shape.triangles))
        .collect();
    let (deepest, places) = deepest_entry(&surface, &hulls, radius, radius / 5.0, from);
    assert!(places > 100, "{places}");
    deepest
}

/// A box with a wall on each side and a square opening in its top.
fn cave(opening: f64) -> Mesh {
    let (low, high) = (2.0 - 0.5 * opening, 2.0 + 0.5 * opening);
    join(&[
        cuboid([0.0; 3], [4.0, 4.0, 0.3]),
        cuboid([0.0, 0.0, 0.3], [0.3, 4.0, 3.7]),
        cuboid([3.7, 0.0, 0.3], [4.0, 4.0, 3.7]),
        cuboid([0.3, 0.0, 0.3], [3.7, 0.3, 3.7]),
        cuboid([0.3, 3.7, 0.3], [3.7, 4.0, 3.7]),
        cuboid([0.0, 0.0, 3.7], [low, 4.0, 4.0]),
        cuboid([high, 0.0, 3.7], [4.0, 4.0, 4.0]),
        cuboid([low, 0.0, 3.7], [high, low, 4.0]),
        cuboid([low, high, 3.7], [high, 4.0, 4.0]),
    ])
}

/// A room without a door: a box in a box.
fn room() -> Mesh {
    join(&[cuboid([0.0; 3], [4.0; 3]), turned(&cuboid([0.3; 3], [3.7; 3]))])
}

#[test]
fn a_cup_stays_open_for_what_fits_into_its_mouth_and_fills_below_what_rests_on_its_rim() {
    let cup = cup();
    for radius in [0.1, 0.4] {
        let found = with_probe(&cup, radius);
        assert!(!is_filled(&found, [0.0, 0.0, 1.9]) && !is_filled(&found, [0.0, 0.0, 0.9]));
    }
    let found = with_probe(&cup, 3.0);
    assert_eq!(found.hulls.len(), run(&cup).hulls.len().min(found.hulls.len()));
    // The ball sinks in by 0.138 at the middle of the mouth.
    let sunk = 3.0 - (9.0_f64 - 0.81).sqrt();
    assert!(!is_filled(&found, [0.0, 0.0, 2.0 - sunk + 1.01 * BOUND]));
    let fills_below = (0..8).any(|k| is_filled(&found, [0.0, 0.0, 0.3 + 0.2 * f64::from(k)]));
    assert!(fills_below || found.hulls.len() < run(&cup).hulls.len());
}

#[test]
fn a_comb_is_one_hull_where_a_ball_hardly_sinks_in_and_keeps_its_teeth_where_it_fits_between() {
    // Gaps of width 1. A ball of radius r sinks in by r - √(r² - 1/4).
    let comb = comb(5, 6.0, 3.0);
    let sinks_in = |radius: f64| radius - (radius * radius - 0.25).sqrt();
    assert!(sinks_in(5.0) < 0.6 * BOUND && sinks_in(1.0) > 2.0 * BOUND);
    assert_eq!(with_probe(&comb, 5.0).hulls.len(), 1);
    let without = run_with(&comb, &Parameters::default().with_max_error(Length::units(BOUND)));
    for radius in [0.1, 0.4] {
        let found = with_probe(&comb, radius);
        assert_eq!(found.hulls.len(), without.hulls.len(), "{radius}");
        let middles = (0..4).map(|gap| [1.5 + 2.0 * f64::from(gap), 4.0, 1.5]);
        assert!(middles.into_iter().all(|middle| !is_filled(&found, middle)), "{radius}");
    }
}

#[test]
fn a_cave_fills_whose_entrance_is_too_narrow() {
    let inside = [2.0, 2.0, 2.0];
    let without = run_with(&cave(1.0), &Parameters::default().with_max_error(Length::units(BOUND)));
    let closed = with_probe(&cave(1.0), 0.9);
    let open = with_probe(&cave(1.0), 0.4);
    assert!(!is_filled(&open, inside));
    assert!(closed.hulls.len() < open.hulls.len() && open.hulls.len() <= without.hulls.len());
    let volume = |found: &Decomposition| found.report.probe.unwrap().unreachable_volume;
    // Of the inside, 3.4 cubed.
    assert!(volume(&closed) > 30.0 && volume(&open) < 10.0, "{closed:?}");
}

#[test]
fn through_bars_a_thin_ball_passes_and_a_thick_one_does_not() {
    let bar = |k: u32| {
        let x = f64::from(k);
        cuboid([x, 0.0, 0.0], [x + 0.2, 0.2, 5.0])
    };
    let bars = join(&(0..6).map(bar).collect::<Vec<_>>());
    let thin = with_probe(&bars, 0.3);
    assert_eq!(thin.hulls.len(), 6);
    let thick = with_probe(&bars, 4.0);
    assert_eq!(thick.hulls.len(), 1, "a ball of radius 4 sinks in by 0.02 between bars 0.8 apart");
}

#[test]
fn no_ball_is_entered_by_more_than_the_bound_wherever_it_goes() {
    let shapes = [
        ("cup", cup()),
        ("comb", comb(4, 3.0, 2.0)),
        ("cave with a wide entrance", cave(2.2)),
        ("cave with a narrow entrance", cave(0.8)),
        ("plus", plus_prism()),
        ("torus", torus()),
        ("sheet", open_sheet()),
        ("sheet from both sides", both_ways(&open_sheet())),
    ];
    for (name, mesh) in shapes {
        for radius in [0.15, 0.45, 1.2] {
            let parameters = with_radius(radius).with_openings(Openings::Keep);
            let found = run_with(&mesh, &parameters);
            let entered = entered(&mesh, &found, radius, &[]);
            assert!(entered <= BOUND * (1.0 + 1e-6), "{name}, {radius}: {entered}");
            assert!(found.report.protrusion_max <= found.report.bound, "{name}, {radius}");
            assert!(found.report.uncovered_max <= found.report.bound, "{name}, {radius}");
        }
    }
}

#[test]
fn nested_shells_fill_and_a_room_without_a_door_stays_open_only_for_who_starts_in_it() {
    let inside = [2.0, 2.0, 2.0];
    let shells = join(&[room(), cuboid([1.0; 3], [3.0; 3])]);
    assert_eq!(with_probe(&shells, 0.3).hulls.len(), 1);
    assert_eq!(with_probe(&room(), 0.3).hulls.len(), 1);
    let found = run_with(&room(), &with_radius(0.3).with_probe_from([inside]));
    assert!(!is_filled(&found, inside) && found.hulls.len() >= 6);
    let entered = entered(&room(), &found, 0.3, &[inside]);
    assert!(entered <= BOUND * (1.0 + 1e-6), "{entered}");
    let again = run_with(&room(), &with_radius(0.3).with_probe_from([inside, [2.0, 1.0, 3.0]]));
    assert_eq!(again.hulls, found.hulls);
}

#[test]
fn a_radius_of_ten_diagonals_gives_the_convex_hull() {
    for mesh in [cup(), comb(5, 6.0, 3.0), plus_prism(), torus()] {
        let parameters = Parameters::default().with_probe_radius(Length::share(10.0));
        assert_eq!(run_with(&mesh, &parameters).hulls.len(), 1);
    }
}

#[test]
fn a_smaller_radius_than_the_bound_opens_nothing_and_fills_nothing_that_can_be_reached() {
    let cup = cup();
    let coarse = Parameters::default().with_max_error(Length::units(0.2));
    let found = run_with(&cup, &coarse.with_probe_radius(Length::units(0.02)));
    assert!(!is_filled(&found, [0.0, 0.0, 1.9]) && !is_filled(&found, [0.0, 0.0, 0.9]));
}

#[test]
fn a_ball_smaller_than_the_detail_that_the_search_leaves_out_has_the_hulls_of_none() {
    // More triangles than are searched as they are.
    let mesh = ball(60, 60);
    let without = run_with(&mesh, &Parameters::default());
    for share in [0.003, 0.004, 0.0041] {
        let parameters = Parameters::default().with_probe_radius(Length::share(share));
        assert_eq!(run_with(&mesh, &parameters).hulls, without.hulls, "{share}");
    }
}

#[test]
fn a_large_mesh_and_a_small_ball_are_bounded_in_memory_and_the_report_says_so() {
    let pillar = |k: u32| {
        let [x, y] = [k % 8, k / 8].map(|x| 12.0 * f64::from(x));
        cuboid([x, y, 0.0], [x + 1.0, y + 1.0, 10.0])
    };
    let level = join(&(0..64).map(pillar).collect::<Vec<_>>());
    let found = with_probe(&level, 0.1);
    let probe = found.report.probe.unwrap();
    assert_eq!(probe.radius, 0.1);
    assert!(probe.cell > 0.5 * probe.radius, "{probe:?}");
    assert_eq!(found.hulls.len(), 64);
}

#[test]
fn without_a_probe_nothing_is_reported_and_with_one_the_result_does_not_depend_on_threads() {
    assert_eq!(run(&plus_prism()).report.probe, None);
    let parameters = with_radius(0.4);
    let one = Control::new().with_parallel(false);
    let alone = decompose(view(&cave(0.9)), &parameters, &one).unwrap();
    let many = decompose(view(&cave(0.9)), &parameters, &Control::new()).unwrap();
    assert_eq!((alone.hulls, alone.report), (many.hulls, many.report));
}

#[test]
fn measured_and_joined_hulls_are_judged_by_what_the_probe_reaches() {
    let comb = comb(5, 6.0, 3.0);
    let (parameters, control) = (with_radius(5.0), Control::new());
    let found = run_with(&comb, &parameters);
    let of = |parameters: &Parameters| {
        measure(view(&comb), &found.hulls, &MeasureOptions::from(parameters), &control).unwrap()
    };
    let seen = of(&parameters);
    assert!(seen.protrusion.max * seen.diagonal <= BOUND, "{:?}", seen.protrusion);
    let unseen = of(&Parameters::default());
    assert!(unseen.protrusion.max * unseen.diagonal > 0.4, "{:?}", unseen.protrusion);
    let four = run_with(&plus_prism(), &with_radius(0.3));
    let tree = MergeTree::new(view(&plus_prism()), &four, &with_radius(0.3), &control).unwrap();
    let curve = tree.curve();
    assert!(curve.windows(2).all(|pair| pair[0].error <= pair[1].error));
    let limited = run_with(&cave(1.0), &with_radius(0.4).with_max_hulls(3));
    assert!(limited.hulls.len() <= 3 && limited.report.protrusion_max > BOUND);
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    let refused =
        |parameters: &Parameters| match decompose(view(&room()), parameters, &Control::new()) {
            Err(Error::InvalidParameter { name, reason }) => (name, reason),
            other => panic!("{other:?}"),
        };
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for radius in [Length::share(radius), Length::units(radius)] {
            let parameters = Parameters::default().with_probe_radius(radius);
            assert_eq!(refused(&parameters).0, "probe_radius", "{radius:?}");
        }
    }
    let (name, reason) = refused(&with_radius(0.3).with_keep_cavities(true));
    assert!(name == "probe_radius" && reason.contains("keep_cavities"), "{reason}");
    for (point, expected) in [
        ([0.5, 2.0, 2.0], "nearer to the mesh"),
        ([0.15, 2.0, 2.0], "in the solid"),
        ([f64::NAN, 0.0, 0.0], "not finite"),
    ] {
        let parameters = with_radius(0.3).with_probe_from([point]);
        let (name, reason) = refused(&parameters);
        assert!(name == "probe_from" && reason.contains(expected), "{reason}");
        let measured = MeasuredMesh::new(view(&room()), &parameters, &Control::new());
        assert_eq!(measured.err(), Some(Error::InvalidParameter { name, reason }));
    }
    let (name, reason) = refused(&Parameters::default().with_probe_from([[9.0; 3]]));
    assert!(name == "probe_from" && reason.contains("probe_radius"), "{reason}");
}

#[test]
fn parameters_with_a_probe_are_text() {
    let parameters = with_radius(0.1).with_probe_from([[1.0, -2.5, 0.125], [0.0, 1e-3, 4.0]]);
    let text = parameters.to_string();
    assert_eq!(text, "max_error=0.05m probe_radius=0.1m probe_from=1,-2.5,0.125;0,0.001,4");
    assert_eq!(text.parse(), Ok(parameters));
    assert!("probe_from=1,2".parse::<Parameters>().is_err());
}

#[test]
fn a_vase_with_a_narrow_neck_fills_and_one_with_a_wide_neck_does_not() {
    let mut profile = CUP_PROFILE;
    // The mouth narrows to a radius of 0.3.
    profile[2] = [0.4, 2.0];
    profile[3] = [0.3, 2.0];
    let vase = lathe(&profile, 24);
    let (narrow, wide) = (with_probe(&vase, 0.5), with_probe(&vase, 0.2));
    assert!(narrow.hulls.len() < wide.hulls.len(), "{}", narrow.hulls.len());
    assert!(!is_filled(&wide, [0.0, 0.0, 0.6]));
    // A prism with a slot is as good as closed for what is wider.
    let slot = prism(
        &[
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 3.0],
            [2.05, 3.0],
            [2.05, 1.0],
            [1.95, 1.0],
            [1.95, 3.0],
            [0.0, 3.0],
        ],
        2.0,
    );
    assert_eq!(with_probe(&slot, 0.5).hulls.len(), 1);
}
