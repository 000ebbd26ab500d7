//! What becomes of what modellers leave open: each case with its number of hulls, points that must
//! be filled, and points that must stay empty.

mod cases;
// The unused rest is for other tests.
#[allow(dead_code)]
#[path = "../common/mod.rs"]
mod common;

use hullwright::measure::{MeasureOptions, measure};
use hullwright::openings::{ClosedMesh, OpeningOutcome, close_openings};
use hullwright::surface::{self, SurfaceParameters};
use hullwright::{
    Control, Decomposition, MassSource, Openings, Parameters, TriangleMesh, UpAxis, decompose,
    mass_properties,
};

use cases::*;
use common::is_filled;

fn run(mesh: &TriangleMesh, parameters: &Parameters) -> Decomposition {
    decompose(mesh, parameters, &Control::new()).expect("a sound mesh")
}

fn closed(mesh: &TriangleMesh) -> (Vec<OpeningOutcome>, usize) {
    let ClosedMesh { openings, caps, .. } =
        close_openings(mesh, &Parameters::default(), &Control::new()).unwrap();
    (openings.into_iter().map(|opening| opening.outcome).collect(), caps)
}

fn outcomes(decomposition: &Decomposition) -> Vec<OpeningOutcome> {
    decomposition.run.openings.iter().map(|opening| opening.outcome).collect()
}

/// Decomposes by default into at most `hulls`. The bound is kept against the closed solid.
#[track_caller]
fn check(mesh: &TriangleMesh, hulls: usize, filled: &[Point], empty: &[Point]) -> Decomposition {
    let found = run(mesh, &Parameters::default());
    let count = found.hulls.len();
    assert!(count <= hulls, "{count} hulls, not {hulls}; openings {:?}", outcomes(&found));
    for point in filled {
        assert!(is_filled(&found, *point), "{point:?} is to be filled");
    }
    for point in empty {
        assert!(!is_filled(&found, *point), "{point:?} is to stay empty");
    }
    let judged = measure(mesh, &found.hulls, &MeasureOptions::default(), &Control::new()).unwrap();
    let bound = found.report.bound / judged.diagonal * (1.0 + 1e-6);
    assert!(judged.protrusion.max <= bound, "protrusion {}", judged.protrusion.max);
    assert!(judged.uncovered.max <= bound, "uncovered {}", judged.uncovered.max);
    found
}

const CLOSED: OpeningOutcome = OpeningOutcome::Closed;

#[test]
fn a_floor_tile_without_a_bottom_is_a_box() {
    let found = check(&floor_tile(), 1, &[[1.0, 0.1, 1.0]], &[]);
    assert_eq!(outcomes(&found), [CLOSED]);
    assert!((found.run.openings[0].area - 4.0).abs() < 1e-9);
    assert_eq!(found.run.openings[0].edges, 4);
    assert_eq!(found.hulls[0].shape.points.len(), 8);
}

#[test]
fn the_skin_of_a_solid_is_closed() {
    for (mesh, filled, expected) in [
        (rock(), [0.0, 0.3, 0.0], vec![CLOSED]),
        (barrel(), [0.0, 1.0, 0.0], vec![CLOSED]),
        // It is open at both ends, and not lined.
        (trunk(), [0.0, 1.5, 0.0], vec![CLOSED; 2]),
        (wall_panel(), [1.0, 1.0, 0.1], vec![CLOSED]),
        (turned(box_without([0.0; 3], [1.0; 3], &[])), [0.5; 3], vec![]),
    ] {
        assert_eq!(outcomes(&check(&mesh, 1, &[filled], &[])), expected);
    }
}

#[test]
fn a_lined_pipe_and_cups_with_liners_stay_hollow() {
    let found = check(&lined_pipe(), 8, &[[0.0, 1.5, 0.8]], &[[0.0, 1.5, 0.0], [0.0, 0.1, 0.3]]);
    // The end of each is a ring between wall and liner.
    assert_eq!(outcomes(&found), [CLOSED; 2]);
    let empty = [1.0, 1.9, 0.4].map(|y| [0.0, y, 0.0]);
    let found = check(&cup_with_loose_liner(), 6, &[[0.0, 0.1, 0.0]], &empty);
    assert_eq!(outcomes(&found), [CLOSED]);
    let found = run(&cup_with_short_liner(), &Parameters::default());
    assert!(!is_filled(&found, [0.0, 1.0, 0.0]), "{:?}", outcomes(&found));
}

#[test]
fn what_is_hollow_or_a_sheet_is_left_and_stays_empty() {
    use OpeningOutcome::{NotFlat, SeenInto, Sheet, TwoSided};
    for (name, mesh, expected, empty) in [
        ("around a corner", open_corner(), NotFlat, [0.5, 0.3, 0.3]),
        ("bowl from within", bowl_from_within(), SeenInto, [0.0, 0.6, 0.0]),
        ("bowl from both sides", bowl_from_both_sides(), TwoSided, [0.0, 0.6, 0.0]),
        ("tent", tent(), NotFlat, [0.0, 0.4, 1.5]),
        ("hood", hood(), Sheet, [0.0, 0.05, 0.0]),
        ("curtain", curtain(), NotFlat, [0.5, 1.0, 0.5]),
        ("terrain", terrain(), NotFlat, [0.5, 1.0, 0.5]),
        ("room", room(), SeenInto, [1.5, 1.0, 1.5]),
    ] {
        let found = run(&mesh, &Parameters::default());
        assert_eq!(outcomes(&found), [expected], "{name}");
        assert!(!is_filled(&found, empty), "{name}");
    }
    for (mesh, empty) in [(leaf(), [0.5, 1.0, 0.5]), (car_body(), [0.85, 0.1, 1.0])] {
        let found = run(&mesh, &Parameters::default());
        assert!(!outcomes(&found).iter().any(|o| o.is_closed()), "{:?}", outcomes(&found));
        assert!(!is_filled(&found, empty));
    }
}

/// The tile is closed in a pass of its own; then the room is looked at once more.
#[test]
fn what_is_seen_into_stays_so_where_another_opening_is_closed() {
    let far = |[x, y, z]: [f64; 3]| [x + 10.0, y, z];
    let mut tile = floor_tile();
    tile.positions = tile.positions.into_iter().map(far).collect();
    let found = run(&joined(&[room(), tile]), &Parameters::default());
    let [left, closed] = [OpeningOutcome::SeenInto, CLOSED]
        .map(|outcome| outcomes(&found).into_iter().filter(|&o| o == outcome).count());
    assert_eq!([left, closed, outcomes(&found).len()], [1, 1, 2]);
    assert!(is_filled(&found, [11.0, 0.1, 1.0]) && !is_filled(&found, [1.5, 1.0, 1.5]));
}

#[test]
fn what_is_drawn_from_both_sides_is_closed_at_the_bottom_alone() {
    let tile = both_sided(floor_tile());
    check(&tile, 1, &[[1.0, 0.1, 1.0]], &[]);
    let tray = both_sided(box_without([0.0; 3], [2.0, 0.2, 2.0], &[TOP]));
    assert_eq!(outcomes(&run(&tray, &Parameters::default())), [OpeningOutcome::TwoSided]);
    // The same tile in a file where z points up.
    let mut lying = tile;
    lying.positions.iter_mut().for_each(|[x, y, z]| (*x, *y, *z) = (*z, *x, *y));
    let z_up = Parameters::default().with_up_axis(UpAxis::Z);
    assert_eq!(outcomes(&run(&lying, &Parameters::default())), [OpeningOutcome::TwoSided]);
    assert_eq!(outcomes(&run(&lying, &z_up)), [CLOSED]);
}

#[test]
fn what_is_there_both_ways_round_counts_as_drawn_from_both_sides() {
    check(&joined(&[floor_tile(), turned(floor_tile())]), 1, &[[1.0, 0.1, 1.0]], &[]);
}

#[test]
fn a_pot_and_its_lid_that_share_a_rim_are_one_solid() {
    let pot = pot();
    let found = check(&pot_with_lid(), 1, &[[0.0, 0.5, 0.0]], &[]);
    assert_eq!(outcomes(&found), []);
    // A lid with a rim of its own leaves two loops, which lie on each other.
    let finer = joined(&[pot, ring(24, (1.0, 1.0), (1.3, 0.0))]);
    check(&finer, 1, &[[0.0, 0.5, 0.0]], &[]);
}

#[test]
fn a_t_junction_is_no_opening() {
    let mesh = t_junction();
    assert_eq!(closed(&mesh), (vec![], 0));
    let found = check(&mesh, 1, &[[0.5, 0.5, 0.5]], &[]);
    let mass = mass_properties(&mesh, &found.hulls, 1.0).unwrap();
    assert_eq!(mass.source, MassSource::Mesh, "it is closed");
}

#[test]
fn a_part_that_is_stuck_through_a_solid_does_not_keep_it_open() {
    let found = check(&leg_and_beam(), 2, &[[0.2, 1.5, 0.2], [2.0, 1.1, 0.2]], &[[2.0, 0.5, 0.2]]);
    assert!(outcomes(&found).iter().all(|outcome| outcome.is_closed()), "{:?}", outcomes(&found));
}

#[test]
fn a_cap_that_reaches_out_of_the_solid_around_it_is_surface() {
    // A plate without its lower side, most of it within a box, and thinner than the bound.
    let solid = box_without([0.0; 3], [1.0; 3], &[]);
    let plate = box_without([-0.3, 0.5, 0.2], [0.5, 0.51, 0.8], &[BOTTOM]);
    assert_eq!(closed(&joined(&[solid.clone(), plate])), (vec![CLOSED], 2));
    // A leg's end that is hidden as a whole is none.
    let leg = box_without([0.2, -2.0, 0.2], [0.4, 0.5, 0.4], &[TOP]);
    assert_eq!(closed(&joined(&[solid, leg])), (vec![OpeningOutcome::ClosedWithin], 0));
}

#[test]
fn planks_without_backs_enclose_a_chest_together() {
    let found = run(&chest_of_planks(), &Parameters::default());
    assert_eq!(found.hulls.len(), 1, "{:?}", outcomes(&found));
}

#[test]
fn the_inner_faces_of_a_crate_are_filled_unless_cavities_are_kept() {
    let outer = box_without([0.0; 3], [2.0; 3], &[]);
    let inner = box_without([0.2; 3], [1.8; 3], &[]);
    for inner in [turned(inner.clone()), inner] {
        let found = check(&joined(&[outer.clone(), inner]), 1, &[[1.0; 3]], &[]);
        assert_eq!(found.run.nested_components, 1);
        assert_eq!(found.hulls[0].shape.points.len(), 8);
    }
    let hollow = joined(&[outer, turned(box_without([0.2; 3], [1.8; 3], &[]))]);
    let kept = run(&hollow, &Parameters::default().with_keep_cavities(true));
    assert_eq!(kept.run.nested_components, 0);
    assert!(!is_filled(&kept, [1.0; 3]));
    let mass = mass_properties(&hollow, &[], 1.0).unwrap();
    assert!((mass.mass - (8.0 - 1.6_f64.powi(3))).abs() < 1e-9, "a hollow crate is lighter");
}

#[test]
fn components_that_overlap_in_part_both_stay() {
    let cross = joined(&[
        box_without([-2.0, -0.2, -0.2], [2.0, 0.2, 0.2], &[]),
        box_without([-0.2, -2.0, -0.2], [0.2, 2.0, 0.2], &[]),
    ]);
    let found = check(&cross, 2, &[[1.5, 0.0, 0.0], [0.0, 1.5, 0.0]], &[[1.0, 1.0, 0.0]]);
    assert_eq!(found.run.nested_components, 0);
}

#[test]
fn keep_leaves_a_shell_and_close_fills_what_auto_leaves() {
    let tile = box_without([0.0; 3], [2.0, 1.0, 2.0], &[BOTTOM]);
    let kept = run(&tile, &Parameters::default().with_openings(Openings::Keep));
    assert!(kept.hulls.len() > 1 && outcomes(&kept).is_empty());
    assert!(!is_filled(&kept, [1.0, 0.4, 1.0]));

    let filled = run(&room(), &Parameters::default().with_openings(Openings::Close));
    assert_eq!((filled.hulls.len(), outcomes(&filled)), (1, vec![CLOSED]));
    let paper = surface::decompose(&tile, &SurfaceParameters::paper(), &Control::new()).unwrap();
    assert!(paper.run.openings.is_empty(), "the paper takes the mesh as it is");
}

#[test]
fn the_mass_of_a_closed_opening_is_that_of_the_solid() {
    let tile = box_without([0.0; 3], [2.0, 0.5, 2.0], &[BOTTOM]);
    let mass = mass_properties(&tile, &[], 3.0).unwrap();
    assert_eq!(mass.source, MassSource::Mesh);
    assert!((mass.mass - 6.0).abs() < 1e-9);
    assert!((mass.centre[1] - 0.25).abs() < 1e-9);
}

#[test]
fn a_cap_that_the_surface_goes_through_is_left() {
    // A wall through the opening, part of the same mesh's surface and open itself.
    let tile = box_without([0.0; 3], [2.0, 1.0, 2.0], &[BOTTOM]);
    let mut wall = TriangleMesh::default();
    quad(&mut wall, [[0.5, -1.0, 1.0], [1.5, -1.0, 1.0], [1.5, 0.5, 1.0], [0.5, 0.5, 1.0]]);
    let found = run(&joined(&[tile, wall]), &Parameters::default());
    assert!(outcomes(&found).contains(&OpeningOutcome::Cut), "{:?}", outcomes(&found));
    assert!(outcomes(&found).iter().all(|outcome| !outcome.is_closed()));
}

#[test]
fn the_page_about_openings_has_the_rows_of_all_cases_and_the_words_of_all_outcomes() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/openings.md");
    let page = std::fs::read_to_string(page).unwrap();
    let keep = Parameters::default().with_openings(Openings::Keep);
    for (name, mesh) in solids().into_iter().chain(hollows()) {
        let [kept, found] = [run(&mesh, &keep), run(&mesh, &Parameters::default())];
        let mut openings: Vec<_> = outcomes(&found).iter().map(|own| own.describe()).collect();
        openings.sort_unstable();
        openings.dedup();
        let openings = if openings.is_empty() { "none".into() } else { openings.join("; ") };
        let row =
            format!("\n| {name} | {} | {} | {openings} |\n", kept.hulls.len(), found.hulls.len());
        assert!(page.contains(&row), "the page lacks {row}");
    }
    let text = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for outcome in [
        OpeningOutcome::ClosedWithin,
        OpeningOutcome::NotFlat,
        OpeningOutcome::NotSimple,
        OpeningOutcome::Sheet,
        OpeningOutcome::Cut,
        OpeningOutcome::TwoSided,
        OpeningOutcome::SeenInto,
        OpeningOutcome::SolidBeyond,
        OpeningOutcome::Fragment,
    ] {
        let words = outcome.describe().trim_start_matches("left: ");
        assert!(text.contains(&format!("*{words}*")), "{words}");
    }
}
