//! Tests of what judges hulls without the crate's code.

use hullwright::{Control, Hull, Parameters, TriangleMesh, convex_hull, decompose};

use crate::independent::exact::{Faults, faults};
use crate::independent::nearest::Tree;
use crate::independent::oracle::{Triangle, distance_to};
use crate::independent::sampling::{Sampled, sample};
use crate::shapes::cuboid;

/// Of the bound's samples.
const SAMPLES: usize = 30_000;

const POINTS: [[f32; 3]; 5] =
    [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.1, 0.1, 0.1]];
const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// The same with a dent: the face of three corners is folded in to the fifth.
const DENTED: [[u32; 3]; 6] = [[0, 2, 1], [0, 1, 3], [2, 0, 3], [1, 2, 4], [2, 3, 4], [3, 1, 4]];

#[test]
fn a_tetrahedron_is_sound_and_a_dent_by_one_bit_is_not() {
    assert_eq!(faults(&POINTS[..4], &TETRAHEDRON), Faults::default());
    let middle = |z: f32| [POINTS[0], POINTS[1], POINTS[2], POINTS[3], [0.25, 0.25, z]];
    assert_eq!(faults(&middle(0.5), &DENTED), Faults::default(), "in the plane of the face");
    assert!(faults(&middle(0.5_f32.next_down()), &DENTED).is_not_convex);
    assert_eq!(faults(&middle(0.5_f32.next_up()), &DENTED), Faults::default());
}

#[test]
fn a_missing_face_an_unused_vertex_and_two_bodies_are_open() {
    assert!(faults(&POINTS[..4], &TETRAHEDRON[1..]).is_open);
    assert!(faults(&POINTS, &TETRAHEDRON).is_open);
    assert!(faults(&POINTS[..3], &TETRAHEDRON).is_open);
    let twice: Vec<[u32; 3]> = TETRAHEDRON
        .iter()
        .copied()
        .chain(TETRAHEDRON.map(|triangle| triangle.map(|index| index + 4)))
        .collect();
    let points = [&POINTS[..4], &POINTS[..4]].concat();
    assert!(faults(&points, &twice).is_open);
}

#[test]
fn a_plate_without_thickness_has_no_volume() {
    let flat: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.3, 0.0]];
    assert!(faults(&flat, &TETRAHEDRON).has_no_volume);
}

#[test]
fn the_tree_finds_what_all_triangles_give() {
    // Triangles of three sizes around a spiral.
    let at = |t: f64, r: f64| [r * t.cos(), r * t.sin(), 0.1 * t];
    let triangles: Vec<Triangle> = (0..300)
        .map(|i| {
            let (t, size) = (f64::from(i) * 0.17, [0.01, 0.1, 1.0][i as usize % 3]);
            Triangle::new([at(t, 1.0), at(t + size, 1.2), at(t, 1.0 + size)])
        })
        .collect();
    let tree = Tree::new(triangles.clone());
    for i in 0..200 {
        let point = at(f64::from(i) * 0.31, f64::from(i % 7) * 0.4);
        assert_eq!(tree.distance(point), distance_to(&triangles, point));
    }
    assert_eq!(Tree::new(Vec::new()).distance([0.0; 3]), f64::INFINITY);
}

/// A cube's own decomposition, with another hull in place of its own.
fn cube_with(hull: &TriangleMesh, verified: f64) -> Sampled {
    let cube = cuboid([0.0; 3], [1.0; 3]);
    let mut found = decompose(&cube, &Parameters::default(), &Control::new()).unwrap();
    let mut hull = Hull::from(convex_hull(&hull.positions).unwrap());
    hull.errors.protrusion_max = Some(verified);
    found.hulls = vec![hull];
    sample(&found, &cube, &cube.triangles, SAMPLES)
}

#[test]
fn a_cube_s_own_hull_is_nowhere_outside() {
    let cube = cuboid([0.0; 3], [1.0; 3]);
    let sampled = cube_with(&cube, 0.01);
    assert!(sampled.protrusion < 1e-12 && sampled.uncovered < 1e-12, "{sampled:?}");
    assert!(sampled.beyond_verified <= 0.0 && sampled.undecided == 0);
    assert!(sampled.samples > SAMPLES);
}

#[test]
fn a_larger_hull_protrudes_and_a_smaller_one_leaves_uncovered() {
    let diagonal = 3.0_f64.sqrt();
    // Corners are farthest, by 0.1 along the diagonal of space.
    let larger = cube_with(&cuboid([-0.1; 3], [1.1; 3]), 0.05);
    assert!((larger.protrusion - 0.1).abs() < 1e-12, "{larger:?}");
    assert!((larger.beyond_verified - (0.1 - 0.05 / diagonal)).abs() < 1e-12);
    assert!(larger.uncovered < 1e-12);
    let smaller = cube_with(&cuboid([0.1; 3], [0.9; 3]), 0.05);
    assert!((smaller.uncovered - 0.1).abs() < 1e-12, "{smaller:?}");
    // All of it is inside, deeper than what was verified.
    assert_eq!(smaller.protrusion, 0.0);
    assert!(smaller.beyond_verified <= 0.0);
}
