//! What becomes of what modellers leave open: each case with its number of hulls, points that must be filled,
//! and points that must stay empty.
//!
//! | file | contents |
//! |---|---|
//! | `cases` | the shapes |

mod cases;

use cases::*;
use hullwright::measure::{MeasureOptions, measure};
use hullwright::surface::{self, SurfaceParameters};
use hullwright::{
    ClosedMesh, Control, Decomposition, Hull, MassSource, OpeningOutcome, Openings, Parameters,
    TriangleMesh, UpAxis, close_openings, decompose, mass_properties,
};

fn run(mesh: &TriangleMesh, parameters: &Parameters) -> Decomposition {
    decompose(mesh, parameters, &Control::new()).expect("a sound mesh")
}

fn contains(hull: &Hull, point: Point) -> bool {
    hull.shape.triangles.iter().all(|triangle| {
        let [a, b, c] = triangle.map(|v| hull.shape.points[v as usize]);
        let [u, v, w] =
            [[b, a], [c, a], [point, a]].map(|[p, q]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]]);
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2] <= 1e-9
    })
}

fn is_filled(decomposition: &Decomposition, point: Point) -> bool {
    decomposition.hulls.iter().any(|hull| contains(hull, point))
}

fn outcomes(decomposition: &Decomposition) -> Vec<OpeningOutcome> {
    decomposition.run.openings.iter().map(|opening| opening.outcome).collect()
}

/// Decomposes by default into so many hulls or fewer, and sees that the bound is kept against the closed
/// solid.
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
    let bounded = &found.report;
    let shapes: Vec<_> = found.hulls.iter().map(|hull| &hull.shape).collect();
    let shapes: Vec<hullwright::ConvexHull> = shapes.into_iter().cloned().collect();
    let judged = measure(mesh, &shapes, &MeasureOptions::default(), &Control::new()).unwrap();
    let bound = bounded.bound / judged.diagonal * (1.0 + 1e-6);
    assert!(judged.protrusion.max <= bound, "protrusion {}", judged.protrusion.max);
    assert!(judged.uncovered.max <= bound, "uncovered {}", judged.uncovered.max);
    found
}

/// Decomposes by default, and sees that these are the outcomes and that a point stays empty.
#[track_caller]
fn check_left(mesh: &TriangleMesh, expected: OpeningOutcome, empty: Point) {
    let found = run(mesh, &Parameters::default());
    assert_eq!(outcomes(&found), [expected]);
    assert!(!is_filled(&found, empty));
}

#[test]
fn a_floor_tile_without_a_bottom_is_a_box() {
    let found = check(&floor_tile(), 1, &[[1.0, 0.1, 1.0]], &[]);
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed]);
    assert!((found.run.openings[0].area - 4.0).abs() < 1e-9);
    assert_eq!(found.run.openings[0].edges, 4);
    assert_eq!(found.hulls[0].shape.points.len(), 8);
}

#[test]
fn a_rock_without_a_bottom_is_solid() {
    let found = check(&rock(), 1, &[[0.0, 0.3, 0.0]], &[]);
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed]);
}

#[test]
fn a_barrel_without_a_bottom_is_solid() {
    check(&barrel(), 1, &[[0.0, 1.0, 0.0]], &[]);
}

#[test]
fn a_trunk_that_is_open_at_both_ends_and_not_lined_is_solid() {
    let found = check(&trunk(), 1, &[[0.0, 1.5, 0.0]], &[]);
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed; 2]);
}

#[test]
fn a_lined_pipe_stays_hollow() {
    let found = check(&lined_pipe(), 8, &[[0.0, 1.5, 0.8]], &[[0.0, 1.5, 0.0], [0.0, 0.1, 0.3]]);
    // The end of each is a ring between wall and liner.
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed; 2]);
}

#[test]
fn a_wall_panel_without_its_back_is_a_slab() {
    check(&wall_panel(), 1, &[[1.0, 1.0, 0.1]], &[]);
}

#[test]
fn an_opening_around_a_corner_is_not_flat_and_stays() {
    check_left(&open_corner(), OpeningOutcome::NotFlat, [0.5, 0.3, 0.3]);
}

#[test]
fn a_cup_whose_liner_is_not_welded_to_its_wall_stays_hollow() {
    let found = check(
        &cup_with_loose_liner(),
        6,
        &[[0.0, 0.1, 0.0]],
        &[[0.0, 1.0, 0.0], [0.0, 1.9, 0.0], [0.0, 0.4, 0.0]],
    );
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed]);
}

#[test]
fn a_cup_whose_liner_ends_below_its_rim_stays_hollow() {
    let found = run(&cup_with_short_liner(), &Parameters::default());
    assert!(!is_filled(&found, [0.0, 1.0, 0.0]), "{:?}", outcomes(&found));
}

#[test]
fn a_bowl_of_one_sheet_that_is_seen_from_within_stays_hollow() {
    check_left(&bowl_from_within(), OpeningOutcome::SeenInto, [0.0, 0.6, 0.0]);
}

#[test]
fn a_bowl_that_is_drawn_from_both_sides_stays_hollow() {
    check_left(&bowl_from_both_sides(), OpeningOutcome::TwoSided, [0.0, 0.6, 0.0]);
}

#[test]
fn what_is_drawn_from_both_sides_is_closed_at_the_bottom_alone() {
    let tile = both_sided(box_without([0.0; 3], [2.0, 0.2, 2.0], &[BOTTOM]));
    check(&tile, 1, &[[1.0, 0.1, 1.0]], &[]);
    let tray = both_sided(box_without([0.0; 3], [2.0, 0.2, 2.0], &[TOP]));
    assert_eq!(outcomes(&run(&tray, &Parameters::default())), [OpeningOutcome::TwoSided]);
    // The same tile in a file where z points up.
    let mut lying = tile;
    lying.positions.iter_mut().for_each(|[x, y, z]| (*x, *y, *z) = (*z, *x, *y));
    let z_up = Parameters::default().up_axis(UpAxis::Z);
    assert_eq!(outcomes(&run(&lying, &Parameters::default())), [OpeningOutcome::TwoSided]);
    assert_eq!(outcomes(&run(&lying, &z_up)), [OpeningOutcome::Closed]);
}

#[test]
fn what_is_there_both_ways_round_counts_as_drawn_from_both_sides() {
    let tile = box_without([0.0; 3], [2.0, 0.2, 2.0], &[BOTTOM]);
    check(&joined(&[tile.clone(), turned(tile)]), 1, &[[1.0, 0.1, 1.0]], &[]);
}

#[test]
fn a_tent_stays_hollow() {
    check_left(&tent(), OpeningOutcome::NotFlat, [0.0, 0.4, 1.5]);
}

#[test]
fn a_hood_and_a_leaf_stay_sheets() {
    check_left(&hood(), OpeningOutcome::Sheet, [0.0, 0.05, 0.0]);

    assert!(
        outcomes(&run(&leaf(), &Parameters::default())).iter().all(|outcome| !outcome.is_closed())
    );
}

#[test]
fn curtains_and_terrain_stay_open() {
    for mesh in [curtain(), terrain()] {
        let found = run(&mesh, &Parameters::default());
        assert_eq!(outcomes(&found), [OpeningOutcome::NotFlat]);
    }
}

#[test]
fn a_car_body_with_wheel_arches_stays_open_below() {
    let found = run(&car_body(), &Parameters::default());
    assert!(outcomes(&found).iter().all(|outcome| !outcome.is_closed()), "{:?}", outcomes(&found));
    assert!(!is_filled(&found, [0.85, 0.1, 1.0]));
}

#[test]
fn a_room_stays_empty() {
    check_left(&room(), OpeningOutcome::SeenInto, [1.5, 1.0, 1.5]);
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
    let closed = close_openings(&mesh, &Parameters::default(), &Control::new()).unwrap();
    assert_eq!((closed.openings.len(), closed.caps), (0, 0));
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
    let closed =
        close_openings(&joined(&[solid.clone(), plate]), &Parameters::default(), &Control::new())
            .unwrap();
    let outcomes = |closed: &ClosedMesh| -> Vec<_> {
        closed.openings.iter().map(|opening| opening.outcome).collect()
    };
    assert_eq!((outcomes(&closed), closed.caps), (vec![OpeningOutcome::Closed], 2));
    // A leg's end that is hidden as a whole is none.
    let leg = box_without([0.2, -2.0, 0.2], [0.4, 0.5, 0.4], &[TOP]);
    let closed =
        close_openings(&joined(&[solid, leg]), &Parameters::default(), &Control::new()).unwrap();
    assert_eq!((outcomes(&closed), closed.caps), (vec![OpeningOutcome::ClosedWithin], 0));
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
    let kept = run(&hollow, &Parameters::default().keep_cavities(true));
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
fn a_closed_mesh_whose_normals_point_inward_is_a_solid() {
    let inverted = turned(box_without([0.0; 3], [1.0; 3], &[]));
    check(&inverted, 1, &[[0.5; 3]], &[]);
}

#[test]
fn keep_leaves_a_shell_and_close_fills_what_auto_leaves() {
    let tile = box_without([0.0; 3], [2.0, 1.0, 2.0], &[BOTTOM]);
    let kept = run(&tile, &Parameters::default().openings(Openings::Keep));
    assert!(kept.hulls.len() > 1 && outcomes(&kept).is_empty());
    assert!(!is_filled(&kept, [1.0, 0.4, 1.0]));

    let room = turned(box_without([0.0; 3], [3.0, 2.0, 3.0], &[TOP]));
    let filled = run(&room, &Parameters::default().openings(Openings::Close));
    assert_eq!((filled.hulls.len(), outcomes(&filled)), (1, vec![OpeningOutcome::Closed]));
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
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/openings.md");
    let page = std::fs::read_to_string(page).unwrap();
    let keep = Parameters::default().openings(Openings::Keep);
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
