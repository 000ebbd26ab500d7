//! Surfaces that bound no solid, or touch themselves.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use crate::assert_sound;
use crate::common::{Mesh, Random, cuboid, join, turned};

/// A strip or tube over a grid: `wrap` says which vertex follows the last of a row.
fn grid(n: u32, m: u32, at: impl Fn(f64, f64) -> [f64; 3], wrap: impl Fn(u32) -> u32) -> Mesh {
    let share = |i: u32, of: u32| f64::from(i) / f64::from(of);
    let positions =
        (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).map(|(i, j)| at(share(i, n), share(j, m)));
    let vertex = |i: u32, j: u32| if i < n { i * m + j } else { wrap(j) };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..m - 1 {
            let [a, b] = [vertex(i, j), vertex(i + 1, j)];
            let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions.collect(), triangles)
}

/// All faces of the tetrahedra that a block of cells is divided into, its points moved: a surface
/// that meets itself along each edge, and folds everywhere.
fn tangle(cells: u32) -> Mesh {
    const MOVED: f64 = 0.3;
    let points = cells + 1;
    let index = |[x, y, z]: [u32; 3]| (x * points + y) * points + z;
    let positions = (0..points.pow(3)).map(|i| {
        let place = [i / points.pow(2), i / points % points, i % points];
        [0, 1, 2].map(|k| {
            let wave = 12.9898 * f64::from(i) + 78.233 * k as f64;
            f64::from(place[k]) + MOVED * wave.sin()
        })
    });
    let mut triangles = BTreeSet::new();
    for cell in 0..cells.pow(3) {
        let low = [cell / cells.pow(2), cell / cells % cells, cell % cells];
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            // Along one axis after the other, from a corner to the one across.
            let (mut corner, mut path) = (low, vec![index(low)]);
            for axis in order {
                corner[axis] += 1;
                path.push(index(corner));
            }
            for left_out in 0..4 {
                let mut face = path.clone();
                face.remove(left_out);
                face.sort_unstable();
                triangles.insert([face[0], face[1], face[2]]);
            }
        }
    }
    (positions.collect(), triangles.into_iter().collect())
}

/// The search compares all patches: with one for each fold, twice as many triangles would take four
/// times as long.
#[test]
fn a_surface_that_folds_everywhere_is_divided_into_few_patches_and_the_report_says_so() {
    let mesh = tangle(8);
    let found = assert_sound("tangle", &mesh);
    assert!(found.report.patches_across_folds);
    assert!(10 * found.report.patches < mesh.1.len(), "{}", found.report.patches);
    assert!(found.remarks()[0].starts_with("the surface folds everywhere"));
    let plain = assert_sound("cuboid", &cuboid([0.0; 3], [1.0; 3]));
    assert!(!plain.report.patches_across_folds && plain.remarks().is_empty());
}

/// Cubes in a block with cracks between them, from a place along the x-axis on.
fn crowd(side: u32, start: f64) -> Vec<Mesh> {
    let cube = |cell: u32| {
        let place = [cell % side, cell / side % side, cell / side.pow(2)];
        let [x, y, z] = place.map(|k| 1.01 * f64::from(k));
        cuboid([start + x, y, z], [start + x + 1.0, y + 1.0, z + 1.0])
    };
    (0..side.pow(3)).map(cube).collect()
}

/// Each part would be a patch or more, and the search compares all of them.
#[test]
fn a_surface_of_many_parts_is_divided_into_few_patches_and_the_report_says_so() {
    let found = assert_sound("a crowd of cubes", &join(&crowd(11, 0.0)));
    assert!(found.report.patches_across_folds);
    assert_eq!(found.hulls.len(), 1);
    assert!(found.report.patches < 50, "{}", found.report.patches);
    assert_eq!(found.hulls[0].provenance.source_triangles.len(), 12 * 11 * 11 * 11);
    let two = [crowd(9, 0.0), crowd(9, 30.0)].concat();
    assert_eq!(assert_sound("two crowds of cubes", &join(&two)).hulls.len(), 2);
}

/// One side only: no winding is consistent.
#[test]
fn a_moebius_strip_keeps_the_promise() {
    const ROWS: u32 = 7;
    let strip = |u: f64, v: f64| {
        let (turn, across) = (TAU * u, v * f64::from(ROWS) / f64::from(ROWS - 1) - 0.5);
        let radius = 1.0 + 0.4 * across * (turn / 2.0).cos();
        [radius * turn.cos(), radius * turn.sin(), 0.4 * across * (turn / 2.0).sin()]
    };
    assert_sound("strip", &grid(60, ROWS, strip, |j| ROWS - 1 - j));
}

/// Closed, one-sided, and through itself.
#[test]
fn a_klein_bottle_keeps_the_promise() {
    const ROWS: u32 = 17;
    // Lawson's figure of eight, swept with half a turn.
    let bottle = |u: f64, v: f64| {
        let (turn, around) = (TAU * u, TAU * v * f64::from(ROWS) / f64::from(ROWS - 1));
        let (x, y) = (around.sin(), (2.0 * around).sin());
        let radius = 2.0 + (turn / 2.0).cos() * x - (turn / 2.0).sin() * y;
        let height = (turn / 2.0).sin() * x + (turn / 2.0).cos() * y;
        [radius * turn.cos(), radius * turn.sin(), height]
    };
    assert_sound("bottle", &grid(48, ROWS, bottle, |j| ROWS - 1 - j));
}

/// Shell within shell, as near as thousandths: which side is inside changes at each.
#[test]
fn nested_shells_keep_the_promise_whichever_way_they_face() {
    let shell = |k: u32| cuboid([0.05 * f64::from(k); 3], [2.0 - 0.05 * f64::from(k); 3]);
    let alike: Vec<Mesh> = (0..12).map(shell).collect();
    let alternating: Vec<Mesh> =
        (0..12).map(|k| if k % 2 == 0 { shell(k) } else { turned(&shell(k)) }).collect();
    let close: Vec<Mesh> = (0..6)
        .map(|k| cuboid([0.001 * f64::from(k); 3], [1.0 - 0.001 * f64::from(k); 3]))
        .collect();
    for (name, parts) in [("alike", alike), ("alternating", alternating), ("close", close)] {
        assert_sound(name, &join(&parts));
    }
}

/// Boxes that share a vertex, an edge or a face, with their vertices welded: non-manifold, and no
/// thickness where they meet.
#[test]
fn boxes_that_share_a_vertex_an_edge_or_a_face_are_two_hulls_at_most() {
    let first = cuboid([0.0; 3], [1.0; 3]);
    for low in [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]] {
        let second = cuboid(low, low.map(|x| x + 1.0));
        let found = assert_sound(&format!("{low:?}"), &join(&[first.clone(), second]));
        assert!(found.hulls.len() <= 2, "{low:?}: {}", found.hulls.len());
    }
}

/// A box each of whose walls meets finer ones along its edges: cracks without width.
#[test]
fn t_junctions_along_every_edge_of_a_box_are_one_hull() {
    const PARTS: u32 = 5;
    let (mut positions, mut triangles): Mesh = Default::default();
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            // Walls across the second axis are fine, the others coarse.
            let parts = if axis == 1 { PARTS } else { 1 };
            let point = |i: u32, j: u32| {
                let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(parts));
                let mut point = [side; 3];
                (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (u, v);
                point
            };
            for (i, j) in (0..parts * parts).map(|k| (k / parts, k % parts)) {
                let first = positions.len() as u32;
                positions.extend([
                    point(i, j),
                    point(i + 1, j),
                    point(i + 1, j + 1),
                    point(i, j + 1),
                ]);
                let [a, b] = if side == 1.0 { [1, 2] } else { [2, 1] };
                let [c, d] = if side == 1.0 { [2, 3] } else { [3, 2] };
                triangles.extend([[0, a, b], [0, c, d]].map(|t| t.map(|v| v + first)));
            }
        }
    }
    let found = assert_sound("box", &(positions, triangles));
    assert_eq!(found.hulls.len(), 1);
    assert!((found.hulls[0].shape.volume() - 1.0).abs() < 1e-6);
}

/// A fan of sheets around one edge: each pair of them bounds a wedge, and none a solid.
#[test]
fn many_sheets_on_one_edge_keep_the_promise() {
    let mut positions = vec![[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]];
    let mut triangles = Vec::new();
    for k in 0..24 {
        let angle = TAU * f64::from(k) / 24.0;
        positions.push([angle.cos(), angle.sin(), 0.0]);
        triangles.push([0, 1, k + 2]);
    }
    assert_sound("fan", &(positions, triangles));
}

/// Loose triangles through one another, each with edges of its own: the inside ends without a
/// surface at all of them, and winding numbers of either sign add up and cancel.
#[test]
fn loose_triangles_keep_the_promise() {
    for (seed, count) in [(224, 97), (13, 40), (7, 12)] {
        let mut random = Random(seed);
        let positions = (0..3 * count).map(|_| [(); 3].map(|()| random.signed())).collect();
        let triangles = (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        assert_sound(&format!("{count} triangles"), &(positions, triangles));
    }
}
