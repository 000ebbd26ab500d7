//! What becomes of what modellers leave open: each case with its number of hulls, points that must be filled,
//! and points that must stay empty.
//!
//! One long file: the cases are read side by side, and share their shapes.

use hullwright::measure::{MeasureOptions, measure};
use hullwright::{
    ClosedMesh, Control, Decomposition, Hull, MassSource, OpeningOutcome, Openings, Parameters,
    Sidedness, TriangleMesh, UpAxis, close_openings, decompose, mass_properties,
};

type Point = [f64; 3];

/// Sides of a box, by the axis and whether it is the far one.
const BOTTOM: (usize, bool) = (1, false);
const TOP: (usize, bool) = (1, true);
const BACK: (usize, bool) = (2, false);

fn quad(mesh: &mut TriangleMesh, corners: [Point; 4]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

/// A box, outward, without some of its sides.
fn box_without(low: Point, high: Point, missing: &[(usize, bool)]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for axis in 0..3 {
        for is_far in [false, true] {
            if missing.contains(&(axis, is_far)) {
                continue;
            }
            let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |u: bool, v: bool| {
                let mut point = low;
                point[axis] = if is_far { high[axis] } else { low[axis] };
                point[first] = if u { high[first] } else { low[first] };
                point[second] = if v { high[second] } else { low[second] };
                point
            };
            let around = [
                corner(false, false),
                corner(true, false),
                corner(true, true),
                corner(false, true),
            ];
            let [a, b, c, d] = around;
            quad(&mut mesh, if is_far { around } else { [a, d, c, b] });
        }
    }
    mesh
}

/// The side of a frustum about the y axis, outward, between two rings of `n` corners.
fn ring(n: usize, (low, low_radius): (f64, f64), (high, high_radius): (f64, f64)) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let at = |i: usize, y: f64, radius: f64| {
        let angle = std::f64::consts::TAU * (i % n) as f64 / n as f64;
        [radius * angle.cos(), y, -radius * angle.sin()]
    };
    for i in 0..n {
        let [a, b] = [at(i, low, low_radius), at(i + 1, low, low_radius)];
        let [c, d] = [at(i + 1, high, high_radius), at(i, high, high_radius)];
        quad(&mut mesh, [a, b, c, d]);
    }
    mesh
}

/// A disc about the y axis that faces up.
fn disc(n: usize, y: f64, radius: f64) -> TriangleMesh {
    ring(n, (y, radius), (y, 0.0))
}

fn turned(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh
}

fn joined(parts: &[TriangleMesh]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for part in parts {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&part.positions);
        mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| first + v)));
    }
    mesh
}

fn both_sided(mesh: TriangleMesh) -> TriangleMesh {
    let sidedness = vec![Sidedness::Two; mesh.triangles.len()];
    TriangleMesh { sidedness, ..mesh }
}

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
    decomposition.report.openings.iter().map(|opening| opening.outcome).collect()
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
    let bounded = found.report.bounded.as_ref().expect("the default method reports its bound");
    let shapes: Vec<_> = found.hulls.iter().map(|hull| &hull.shape).collect();
    let shapes: Vec<hullwright::ConvexHull> = shapes.into_iter().cloned().collect();
    let judged = measure(mesh, &shapes, &MeasureOptions::default(), &Control::new()).unwrap();
    let bound = bounded.bound / judged.diagonal * (1.0 + 1e-6);
    assert!(judged.protrusion.max <= bound, "protrusion {}", judged.protrusion.max);
    assert!(judged.uncovered.max <= bound, "uncovered {}", judged.uncovered.max);
    found
}

#[test]
fn a_floor_tile_without_a_bottom_is_a_box() {
    let tile = box_without([0.0; 3], [2.0, 0.2, 2.0], &[BOTTOM]);
    let found = check(&tile, 1, &[[1.0, 0.1, 1.0]], &[]);
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed]);
    assert!((found.report.openings[0].area - 4.0).abs() < 1e-9);
    assert_eq!(found.report.openings[0].edges, 4);
    assert_eq!(found.hulls[0].shape.points.len(), 8);
}

#[test]
fn a_rock_without_a_bottom_is_solid() {
    let rock = joined(&[ring(9, (0.0, 1.0), (0.5, 0.9)), ring(9, (0.5, 0.9), (0.9, 0.0))]);
    let found = check(&rock, 1, &[[0.0, 0.3, 0.0]], &[]);
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed]);
}

#[test]
fn a_barrel_without_a_bottom_is_solid() {
    let barrel = joined(&[
        ring(12, (0.0, 0.8), (1.0, 1.0)),
        ring(12, (1.0, 1.0), (2.0, 0.8)),
        disc(12, 2.0, 0.8),
    ]);
    check(&barrel, 1, &[[0.0, 1.0, 0.0]], &[]);
}

#[test]
fn a_trunk_that_is_open_at_both_ends_and_not_lined_is_solid() {
    let found = check(&ring(12, (0.0, 0.5), (3.0, 0.4)), 1, &[[0.0, 1.5, 0.0]], &[]);
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed; 2]);
}

#[test]
fn a_lined_pipe_stays_hollow() {
    let pipe = joined(&[ring(8, (0.0, 1.0), (3.0, 1.0)), turned(ring(8, (0.0, 0.6), (3.0, 0.6)))]);
    let found = check(&pipe, 8, &[[0.0, 1.5, 0.8]], &[[0.0, 1.5, 0.0], [0.0, 0.1, 0.3]]);
    // The end of each is a ring between wall and liner.
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed; 2]);
}

#[test]
fn a_wall_panel_without_its_back_is_a_slab() {
    let panel = box_without([0.0; 3], [2.0, 2.0, 0.2], &[BACK]);
    check(&panel, 1, &[[1.0, 1.0, 0.1]], &[]);
}

#[test]
fn an_opening_around_a_corner_is_not_flat_and_stays() {
    let corner = box_without([0.0; 3], [1.0; 3], &[BACK, BOTTOM]);
    let found = run(&corner, &Parameters::default());
    assert_eq!(outcomes(&found), [OpeningOutcome::NotFlat]);
    assert!(!is_filled(&found, [0.5, 0.3, 0.3]));
}

#[test]
fn a_cup_whose_liner_is_not_welded_to_its_wall_stays_hollow() {
    let cup = joined(&[
        ring(4, (0.0, 1.0), (2.0, 1.0)),
        turned(disc(4, 0.0, 1.0)),
        turned(ring(4, (0.2, 0.8), (2.0, 0.8))),
        disc(4, 0.2, 0.8),
    ]);
    let found =
        check(&cup, 6, &[[0.0, 0.1, 0.0]], &[[0.0, 1.0, 0.0], [0.0, 1.9, 0.0], [0.0, 0.4, 0.0]]);
    assert_eq!(outcomes(&found), [OpeningOutcome::Closed]);
}

#[test]
fn a_cup_whose_liner_ends_below_its_rim_stays_hollow() {
    let cup = joined(&[
        ring(4, (0.0, 1.0), (2.0, 1.0)),
        turned(disc(4, 0.0, 1.0)),
        turned(ring(4, (0.2, 0.8), (1.8, 0.8))),
        disc(4, 0.2, 0.8),
    ]);
    let found = run(&cup, &Parameters::default());
    assert!(!is_filled(&found, [0.0, 1.0, 0.0]), "{:?}", outcomes(&found));
}

#[test]
fn a_bowl_of_one_sheet_that_is_seen_from_within_stays_hollow() {
    let bowl = turned(joined(&[turned(disc(12, 0.0, 0.6)), ring(12, (0.0, 0.6), (0.8, 1.0))]));
    let found = run(&bowl, &Parameters::default());
    assert_eq!(outcomes(&found), [OpeningOutcome::SeenInto]);
    assert!(!is_filled(&found, [0.0, 0.6, 0.0]));
}

#[test]
fn a_bowl_that_is_drawn_from_both_sides_stays_hollow() {
    let bowl = both_sided(joined(&[turned(disc(12, 0.0, 0.6)), ring(12, (0.0, 0.6), (0.8, 1.0))]));
    let found = run(&bowl, &Parameters::default());
    assert_eq!(outcomes(&found), [OpeningOutcome::TwoSided]);
    assert!(!is_filled(&found, [0.0, 0.6, 0.0]));
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
    let mut tent = TriangleMesh::default();
    quad(&mut tent, [[-1.0, 0.0, 0.0], [-1.0, 0.0, 3.0], [0.0, 1.0, 3.0], [0.0, 1.0, 0.0]]);
    quad(&mut tent, [[0.0, 1.0, 0.0], [0.0, 1.0, 3.0], [1.0, 0.0, 3.0], [1.0, 0.0, 0.0]]);
    let found = run(&tent, &Parameters::default());
    assert_eq!(outcomes(&found), [OpeningOutcome::NotFlat]);
    assert!(!is_filled(&found, [0.0, 0.4, 1.5]));
}

#[test]
fn a_hood_and_a_leaf_stay_sheets() {
    let hood = joined(&[ring(12, (0.0, 1.0), (0.2, 0.5)), ring(12, (0.2, 0.5), (0.25, 0.0))]);
    let found = run(&hood, &Parameters::default());
    assert_eq!(outcomes(&found), [OpeningOutcome::Sheet]);
    assert!(!is_filled(&found, [0.0, 0.05, 0.0]));

    let mut leaf = TriangleMesh::default();
    quad(&mut leaf, [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.02, 1.0], [0.5, 0.02, 0.0]]);
    quad(&mut leaf, [[0.5, 0.02, 0.0], [0.5, 0.02, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    assert!(
        outcomes(&run(&leaf, &Parameters::default())).iter().all(|outcome| !outcome.is_closed())
    );
}

/// A sheet over a grid, with a height at each place.
fn sheet(n: usize, height: impl Fn(f64, f64) -> f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let at = |i: usize, j: usize| {
        let (x, z) = (i as f64 / n as f64, j as f64 / n as f64);
        [x, height(x, z), z]
    };
    for i in 0..n {
        for j in 0..n {
            quad(&mut mesh, [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh
}

#[test]
fn curtains_and_terrain_stay_open() {
    let curtain = sheet(8, |x, _| 0.15 * (12.0 * x).sin());
    let terrain = sheet(8, |x, z| 0.2 * (5.0 * x).sin() * (4.0 * z).cos());
    for mesh in [curtain, terrain] {
        let found = run(&mesh, &Parameters::default());
        assert_eq!(outcomes(&found), [OpeningOutcome::NotFlat]);
    }
}

#[test]
fn a_car_body_with_wheel_arches_stays_open_below() {
    // The sides end higher at the arches, so the rim below is not flat.
    let mut car = box_without([0.0; 3], [4.0, 1.0, 2.0], &[BOTTOM, (2, false), (2, true)]);
    for (z, is_far) in [(0.0, false), (2.0, true)] {
        for (from, to, low) in
            [(0.0, 0.5, 0.0), (0.5, 1.2, 0.5), (1.2, 2.8, 0.0), (2.8, 3.5, 0.5), (3.5, 4.0, 0.0)]
        {
            let corners = [[from, low, z], [to, low, z], [to, 1.0, z], [from, 1.0, z]];
            let [a, b, c, d] = corners;
            quad(&mut car, if is_far { corners } else { [a, d, c, b] });
        }
    }
    let found = run(&car, &Parameters::default());
    assert!(outcomes(&found).iter().all(|outcome| !outcome.is_closed()), "{:?}", outcomes(&found));
    assert!(!is_filled(&found, [0.85, 0.1, 1.0]));
}

#[test]
fn a_room_stays_empty() {
    let room = turned(box_without([0.0; 3], [3.0, 2.0, 3.0], &[TOP]));
    let found = run(&room, &Parameters::default());
    assert_eq!(outcomes(&found), [OpeningOutcome::SeenInto]);
    assert!(!is_filled(&found, [1.5, 1.0, 1.5]));
}

#[test]
fn a_pot_and_its_lid_that_share_a_rim_are_one_solid() {
    let pot = joined(&[turned(disc(12, 0.0, 0.8)), ring(12, (0.0, 0.8), (1.0, 1.0))]);
    let lid = ring(12, (1.0, 1.0), (1.3, 0.0));
    let found = check(&joined(&[pot.clone(), lid]), 1, &[[0.0, 0.5, 0.0]], &[]);
    assert_eq!(outcomes(&found), []);
    // A lid with a rim of its own leaves two loops, which lie on each other.
    let finer = joined(&[pot, ring(24, (1.0, 1.0), (1.3, 0.0))]);
    check(&finer, 1, &[[0.0, 0.5, 0.0]], &[]);
}

#[test]
fn a_t_junction_is_no_opening() {
    let mut mesh = box_without([0.0; 3], [1.0; 3], &[TOP]);
    // The lid's front edge has a vertex in its middle.
    quad(&mut mesh, [[0.0, 1.0, 1.0], [0.5, 1.0, 1.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    quad(&mut mesh, [[0.5, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [0.5, 1.0, 0.0]]);
    let closed = close_openings(&mesh, &Parameters::default(), &Control::new()).unwrap();
    assert_eq!((closed.openings.len(), closed.caps), (0, 0));
    let found = check(&mesh, 1, &[[0.5, 0.5, 0.5]], &[]);
    let mass = mass_properties(&mesh, &found.hulls, 1.0).unwrap();
    assert_eq!(mass.source, MassSource::Mesh, "it is closed");
}

#[test]
fn a_part_that_is_stuck_through_a_solid_does_not_keep_it_open() {
    // A leg without its top, and a beam that is open where it ends in the leg.
    let leg = box_without([0.0; 3], [0.4, 2.0, 0.4], &[TOP]);
    let beam = box_without([0.2, 1.0, 0.1], [3.0, 1.2, 0.3], &[(0, false)]);
    let found =
        check(&joined(&[leg, beam]), 2, &[[0.2, 1.5, 0.2], [2.0, 1.1, 0.2]], &[[2.0, 0.5, 0.2]]);
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
    // Six boards around a room, each without the side that faces it: caps would empty the chest.
    let boards: Vec<TriangleMesh> = (0..3)
        .flat_map(|axis| [false, true].map(|is_far| (axis, is_far)))
        .map(|(axis, is_far)| {
            let (mut low, mut high) = ([0.0; 3], [1.0; 3]);
            if is_far {
                low[axis] = 0.9
            } else {
                high[axis] = 0.1
            }
            box_without(low, high, &[(axis, !is_far)])
        })
        .collect();
    let found = run(&joined(&boards), &Parameters::default());
    assert_eq!(found.hulls.len(), 1, "{:?}", outcomes(&found));
}

#[test]
fn the_inner_faces_of_a_crate_are_filled_unless_cavities_are_kept() {
    let outer = box_without([0.0; 3], [2.0; 3], &[]);
    let inner = box_without([0.2; 3], [1.8; 3], &[]);
    for inner in [turned(inner.clone()), inner] {
        let found = check(&joined(&[outer.clone(), inner]), 1, &[[1.0; 3]], &[]);
        assert_eq!(found.report.nested_components, 1);
        assert_eq!(found.hulls[0].shape.points.len(), 8);
    }
    let hollow = joined(&[outer, turned(box_without([0.2; 3], [1.8; 3], &[]))]);
    let kept = run(&hollow, &Parameters::default().keep_cavities(true));
    assert_eq!(kept.report.nested_components, 0);
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
    assert_eq!(found.report.nested_components, 0);
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
    let paper = run(&tile, &Parameters::paper());
    assert!(outcomes(&paper).is_empty(), "the paper takes the mesh as it is");
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
