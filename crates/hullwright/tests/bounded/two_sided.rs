//! A solid whose faces are all there both ways round has the hulls of the same solid with each face
//! once. What is open on purpose stays a sheet.

use hullwright::inspect::{inspect, inspect_with};
use hullwright::openings::{OpeningOutcome, close_openings};
use hullwright::{
    Control, Decomposition, MassSource, MergeTree, Openings, Parameters, mass_properties,
};

use crate::common::{
    Mesh, Point, ball, both_ways, cuboid, is_filled, join, l_prism, lathe, open_sheet, run,
    run_with, turned, view,
};
use crate::{judge, promised, with_bound};

/// Points of all hulls.
fn shapes(found: &Decomposition) -> Vec<&[Point]> {
    found.hulls.iter().map(|hull| &hull.shape.points[..]).collect()
}

fn bottle() -> Mesh {
    let profile =
        [[0.005, 0.0], [0.5, 0.0], [0.55, 0.1], [0.55, 1.3], [0.2, 1.7], [0.2, 2.2], [0.005, 2.2]];
    lathe(&profile, 32)
}

/// The cuboid without its side at the top: its triangles are the first ones.
fn bucket(low: Point, high: Point) -> Mesh {
    let (positions, triangles) = cuboid(low, high);
    (positions, triangles[2..].to_vec())
}

/// Without some of its triangles.
fn without((positions, triangles): &Mesh, gone: &[usize]) -> Mesh {
    let kept = triangles.iter().enumerate().filter(|(t, _)| !gone.contains(t));
    (positions.clone(), kept.map(|(_, &triangle)| triangle).collect())
}

/// The same triangles, each with vertices of its own.
fn soup((positions, triangles): &Mesh) -> Mesh {
    let corners = triangles.as_flattened().iter().map(|&v| positions[v as usize]);
    (
        corners.collect(),
        (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    )
}

#[test]
fn a_solid_both_ways_round_has_the_hulls_of_the_solid() {
    let cube = cuboid([0.0; 3], [1.0; 3]);
    for (name, once, most) in [
        ("bottle", bottle(), 2),
        ("cube", cube.clone(), 1),
        ("L", l_prism(), 2),
        ("plate", cuboid([0.0; 3], [1.0, 1.0, 0.001]), 1),
        ("nested", join(&[cube.clone(), cuboid([0.3; 3], [0.6; 3])]), 1),
        ("touching at a corner", join(&[cube.clone(), cuboid([1.0; 3], [2.0; 3])]), 2),
    ] {
        let expected = run(&once);
        assert!(expected.hulls.len() <= most, "{name}");
        let copies = join(&[once.clone(), turned(&once)]);
        for (kind, mesh) in [
            ("vertices shared", both_ways(&once)),
            ("vertices doubled", copies.clone()),
            ("soup", soup(&copies)),
            ("backs first", both_ways(&turned(&once))),
            ("one back is missing", without(&both_ways(&once), &[once.1.len() + 1])),
            ("one front is missing", without(&both_ways(&once), &[0])),
        ] {
            let found = promised(name, &mesh);
            assert_eq!(shapes(&found), shapes(&expected), "{name}, {kind}");
            let flipped = usize::from(kind == "one front is missing");
            assert_eq!(found.run.repairs.flipped_triangles, flipped, "{name}, {kind}");
        }
    }
}

#[test]
fn a_few_faces_that_are_there_twice_do_not_open_a_solid() {
    let (positions, mut triangles) = bottle();
    let backs: Vec<[u32; 3]> = triangles[40..90].iter().map(|&[a, b, c]| [a, c, b]).collect();
    triangles.extend(backs);
    assert_eq!(shapes(&run(&(positions, triangles))), shapes(&run(&bottle())));
}

#[test]
fn a_missing_triangle_changes_nothing() {
    // Fifty triangles from pole to pole, the largest in the middle.
    let ball = ball(24, 48);
    for (gone, openings) in [(&[424][..], 1), (&[424, 425], 1), (&[424, 1024, 1740], 3)] {
        let found = promised("ball", &both_ways(&without(&ball, gone)));
        let outcomes = found.run.openings.iter().map(|opening| opening.outcome);
        assert_eq!(Vec::from_iter(outcomes), vec![OpeningOutcome::Closed; openings], "{gone:?}");
        // The cap of a quad may have the other diagonal.
        let is_same = shapes(&found) == shapes(&run(&ball));
        assert!(is_same || gone.len() == 2 && found.hulls.len() == 1, "{gone:?}");
    }
    // A slit around half of the ball, far from flat, as wide as a triangle.
    let slit: Vec<usize> = (0..24).map(|side| 50 * side + 24).collect();
    let slit: Vec<usize> = slit.iter().flat_map(|&first| [first, first + 1]).collect();
    let found = promised("slit", &both_ways(&without(&ball, &slit)));
    assert!(is_filled(&found, [0.0; 3]), "{:?}", found.run.openings);
    let half_a_side = without(&cuboid([0.0; 3], [1.0; 3]), &[0]);
    let found = run(&both_ways(&half_a_side));
    assert!(!is_filled(&found, [0.5; 3]), "a ball passes half a side of a cube");
}

#[test]
fn the_bound_decides_how_wide_an_opening_may_be() {
    // A mouth of radius 0.1 in a ball of radius 1: 3 % of the diagonal.
    let arc = (0..=30).map(|i| 0.1 + (std::f64::consts::PI - 0.1) * f64::from(i) / 30.0);
    let profile: Vec<[f64; 2]> =
        arc.map(|angle: f64| [angle.sin().max(0.002), -angle.cos()]).collect();
    let (positions, triangles) = lathe(&profile, 48);
    // The side from the last ring to the first is what would close it.
    let open = triangles
        .chunks(2)
        .enumerate()
        .filter(|(quad, _)| quad % profile.len() != profile.len() - 1)
        .flat_map(|(_, quad)| quad.iter().copied());
    let pot = both_ways(&(positions, open.collect()));
    assert!(is_filled(&run_with(&pot, &with_bound(0.05)), [0.0; 3]));
    assert!(!is_filled(&run_with(&pot, &with_bound(0.02)), [0.0; 3]));
    let keep = with_bound(0.05).with_openings(Openings::Keep);
    assert!(!is_filled(&run_with(&pot, &keep), [0.0; 3]));
}

#[test]
fn what_is_open_on_purpose_stays_hollow() {
    let walls = [[1.0, 0.0], [1.0, 2.0]];
    let bucket = bucket([0.0; 3], [1.0, 1.0, 1.5]);
    // With a wide mouth, and a spout that no ball passes.
    let kettle = without(
        &ball(24, 48),
        &Vec::from_iter((0..48).flat_map(|side| {
            let first = side * 50;
            [
                first + 46,
                first + 47,
                first + 44,
                first + 45,
                first + 42,
                first + 43,
                first + 48,
                first + 49,
            ]
        })),
    );
    let holed = without(&kettle, &[48 * 20]);
    let tube = lathe(&walls, 24);
    let tube = (tube.0, tube.1.chunks(4).flat_map(|quads| quads[..2].to_vec()).collect());
    // Narrower than any ball, but a cap of it would lie on it.
    let (mut positions, triangles) = open_sheet();
    positions.iter_mut().for_each(|point| point[1] *= 0.05);
    let blade = (positions, triangles);
    for (name, mesh, middle) in [
        ("blade", blade, [0.0, 0.02, 0.0]),
        ("bucket", bucket, [0.5; 3]),
        ("kettle", kettle, [0.0; 3]),
        ("kettle with a hole", holed, [0.0; 3]),
        ("tube", tube, [0.0, 0.0, 1.0]),
    ] {
        let found = promised(name, &both_ways(&mesh));
        assert!(!is_filled(&found, middle), "{name}");
        assert!(found.run.openings.iter().all(|opening| !opening.outcome.is_closed()), "{name}");
    }
}

#[test]
fn solids_beside_others_keep_their_kind() {
    let large = cuboid([0.0; 3], [2.0; 3]);
    let small = cuboid([5.0, 0.0, 0.0], [6.0, 1.0, 1.0]);
    // Beside a large one both ways, an open one still is turned as its file has it.
    let floor = bucket([5.0, 0.0, 0.0], [6.0, 1.0, 0.1]);
    for (name, mesh, hulls) in [
        ("one of two", join(&[both_ways(&large), small.clone()]), 2),
        ("the other", join(&[large.clone(), both_ways(&small)]), 2),
        ("both", both_ways(&join(&[large.clone(), small])), 2),
        ("beside an open one", join(&[both_ways(&large), floor.clone()]), 2),
        ("backs first", join(&[both_ways(&turned(&large)), floor]), 2),
    ] {
        assert_eq!(promised(name, &mesh).hulls.len(), hulls, "{name}");
    }
    let open_box = both_ways(&bucket([-1.0; 3], [3.0; 3]));
    let found = promised("in an open box", &join(&[open_box, both_ways(&large)]));
    assert!(is_filled(&found, [1.0; 3]));
    assert!(!is_filled(&found, [1.0, 1.0, 2.5]) && !is_filled(&found, [-0.5, 1.0, 1.0]));
}

#[test]
fn rooms_that_share_walls_are_solid() {
    // Two cubes with one wall between them, whose diagonals differ, and then do not.
    let cube = cuboid([0.0; 3], [1.0; 3]);
    let beside = join(&[cube.clone(), cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0])]);
    let mirrored = cube.0.iter().map(|&[x, y, z]| [2.0 - x, y, z]).collect();
    let boxes = join(&[cube.clone(), turned(&(mirrored, cube.1.clone()))]);
    for boxes in [beside, boxes.clone()] {
        assert_eq!(promised("two cubes", &both_ways(&boxes)).hulls.len(), 1);
    }
    // A fin stands on an edge.
    let fin = (vec![[2.0, 0.0, 1.0], [2.0, 1.0, 1.0], [2.0, 0.5, 2.0]], vec![[0, 1, 2]]);
    let finned = both_ways(&join(&[boxes, fin]));
    let found = promised("with a fin", &finned);
    assert!(is_filled(&found, [0.5; 3]) && is_filled(&found, [1.5, 0.5, 0.5]));
    assert!(!is_filled(&found, [1.0, 0.5, 1.7]));
    // A desk: a drawer that is closed, and a leg of one sheet at the other end.
    let leg = (
        vec![[0.0; 3], [0.0, 1.0, 0.0], [0.0, 1.0, -2.0], [0.0, 0.0, -2.0]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let found = promised("desk", &both_ways(&join(&[cuboid([0.0; 3], [3.0, 1.0, 1.0]), leg])));
    assert!(is_filled(&found, [1.5, 0.5, 0.5]) && found.hulls.len() <= 3);
}

#[test]
fn all_that_looks_at_a_mesh_says_the_same() {
    let once = bottle();
    let holed = both_ways(&without(&once, &[100]));
    let parameters = Parameters::default();
    for mesh in [both_ways(&once), holed] {
        let found = run(&mesh);
        let judged = judge(&mesh, &found.hulls);
        let expected = judge(&once, &run(&once).hulls);
        assert!((judged.iou.unwrap() - expected.iou.unwrap()).abs() < 1e-6);
        let look = inspect(view(&mesh)).unwrap();
        let volume = inspect(view(&once)).unwrap().volume;
        assert!((look.volume - volume).abs() < 1e-9);
        let mass = mass_properties(view(&mesh), &[], 2.0).unwrap();
        assert_eq!(mass.source, MassSource::Mesh);
        assert!((mass.mass - 2.0 * volume).abs() < 1e-9);
        let closed = close_openings(view(&mesh), &parameters, &Control::new()).unwrap();
        assert_eq!(closed.solid.len(), once.1.len());
        let tree = MergeTree::new(view(&mesh), &found, &parameters, &Control::new()).unwrap();
        let expected =
            MergeTree::new(view(&once), &run(&once), &parameters, &Control::new()).unwrap();
        assert_eq!(tree.curve(), expected.curve());
    }
    let bucket = both_ways(&bucket([0.0; 3], [1.0; 3]));
    let look = inspect_with(view(&bucket), &with_bound(0.02)).unwrap();
    assert_eq!((look.volume, look.is_closed()), (0.0, false));
    let nested = join(&[cuboid([0.0; 3], [1.0; 3]), cuboid([0.3; 3], [0.6; 3])]);
    let mass = mass_properties(view(&both_ways(&nested)), &[], 1.0).unwrap();
    assert!((mass.mass - 1.0).abs() < 0.01, "{mass:?}");
}
