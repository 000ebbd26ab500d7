//! Tests of `orientation`.

use super::*;
use crate::geometry::vector::cross;
use crate::mesh::TriangleMesh;
use crate::mesh::shapes::{cuboid, hemisphere, join, mobius_strip, torus, turn, uv_sphere};

fn oriented(mesh: &TriangleMesh) -> (TriangleMesh, usize) {
    let mut mesh = mesh.clone();
    let connectivity = Connectivity::new(&mesh.triangles, mesh.positions.len());
    let turned = orient(&mesh.positions, &mut mesh.triangles, &connectivity);
    (mesh, turned.iter().filter(|&&turned| turned).count())
}

fn volume(mesh: &TriangleMesh) -> f64 {
    let corners = mesh.triangles.iter().map(|&t| corners(&mesh.positions, t));
    corners.map(|[a, b, c]| dot(a, cross(b, c)) / 6.0).sum()
}

fn cube(half: f64) -> TriangleMesh {
    cuboid([-half; 3], [half; 3])
}

#[test]
fn an_outward_box_stays() {
    assert_eq!(oriented(&cube(1.0)), (cube(1.0), 0));
}

#[test]
fn an_inward_box_is_turned() {
    let (mesh, turned) = oriented(&turn(cube(1.0)));
    assert_eq!(turned, 12);
    assert!((volume(&mesh) - 8.0).abs() < 1e-12);
}

#[test]
fn random_winding_becomes_outward() {
    let mut sphere = uv_sphere(16, [0.0; 3], 1.0);
    let whole = volume(&sphere);
    for (t, triangle) in sphere.triangles.iter_mut().enumerate() {
        if (t * t + t / 3) % 5 < 2 {
            triangle.swap(0, 2);
        }
    }
    let (mesh, turned) = oriented(&sphere);
    assert!(turned > 0);
    assert!((volume(&mesh) - whole).abs() < 1e-12);
}

#[test]
fn a_cavity_stays_inward() {
    let hollow = join(&[cube(1.0), turn(cube(0.5))]);
    assert_eq!(oriented(&hollow), (hollow.clone(), 0));
    let inside_out = turn(hollow);
    let (mesh, turned) = oriented(&inside_out);
    assert_eq!(turned, 24);
    assert!((volume(&mesh) - 7.0).abs() < 1e-12);
}

#[test]
fn a_solid_in_a_cavity_is_outward() {
    let inner = cube(0.25);
    for inner in [inner.clone(), turn(inner)] {
        let nested = join(&[inner, turn(cube(0.5)), cube(1.0)]);
        assert!((volume(&oriented(&nested).0) - 7.125).abs() < 1e-12);
    }
}

#[test]
fn an_inward_box_beside_another_is_turned() {
    let beside = cuboid([3.0, -0.5, -0.5], [4.0, 0.5, 0.5]);
    let (mesh, turned) = oriented(&join(&[cube(1.0), turn(beside)]));
    assert_eq!(turned, 12);
    assert!((volume(&mesh) - 9.0).abs() < 1e-12);
}

#[test]
fn a_sphere_in_the_hole_of_a_ring_lies_in_nothing() {
    let sphere = uv_sphere(12, [0.0; 3], 0.1);
    let ring = torus(12, 12);
    assert!(volume(&ring) > 0.0);
    let (mesh, turned) = oriented(&join(&[ring.clone(), turn(sphere.clone())]));
    assert_eq!(turned, sphere.triangles.len());
    assert!((volume(&mesh) - volume(&ring) - volume(&sphere)).abs() < 1e-12);
}

#[test]
fn many_cavities_are_told_from_many_inverted_boxes() {
    let mut parts = vec![cube(1.0)];
    for i in 0..10 {
        let x = f64::from(i) * 0.18 - 0.9;
        parts.push(turn(cuboid([x, -0.1, -0.1], [x + 0.09, 0.1, 0.1])));
        parts.push(turn(cuboid([x, 1.9, -0.1], [x + 0.09, 2.1, 0.1])));
    }
    let (mesh, turned) = oriented(&join(&parts));
    assert_eq!(turned, 10 * 12);
    assert!((volume(&mesh) - 8.0).abs() < 1e-12);
}

#[test]
fn a_box_without_a_lid_keeps_its_sides() {
    let mut open = cube(1.0);
    open.triangles.truncate(10);
    assert_eq!(oriented(&open).1, 0);
    assert_eq!(oriented(&turn(open)).1, 0);
}

#[test]
fn a_flat_closed_patch_stays() {
    // A square seen from both sides, with different diagonals: the sign of its volume is
    // rounding, and once turned it would be turned again.
    let flat = TriangleMesh {
        positions: [[0.1, 0.2], [0.7, 0.3], [0.6, 0.9], [0.2, 0.7]]
            .map(|[x, y]| [x, y, 0.3 * x + 0.7 * y])
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [1, 0, 3], [3, 2, 1]],
        ..TriangleMesh::default()
    };
    assert_eq!(oriented(&flat).1, 0);
    assert_eq!(oriented(&turn(flat)).1, 0);
}

#[test]
fn an_open_sheet_keeps_its_sides() {
    let bowl = hemisphere(12);
    assert_eq!(oriented(&bowl).1, 0);
    assert_eq!(oriented(&turn(bowl)).1, 0);
}

#[test]
fn a_small_hole_does_not_hide_which_side_is_out() {
    let mut sphere = uv_sphere(16, [0.0; 3], 1.0);
    sphere.triangles.truncate(sphere.triangles.len() - 3);
    assert_eq!(oriented(&sphere).1, 0);
    let (mesh, turned) = oriented(&turn(sphere.clone()));
    assert_eq!(turned, sphere.triangles.len());
    assert!(volume(&mesh) > 0.0);
}

/// The bore of a barrel whose rim has cracks: both ends' lids cancel, and it was taken for a
/// solid that is inside out.
#[test]
fn a_tube_open_at_both_ends_keeps_its_sides() {
    let sides = 16;
    let mut tube = TriangleMesh::default();
    for side in 0..sides {
        let angle = f64::from(side) * std::f64::consts::TAU / f64::from(sides);
        tube.positions.extend([0.0, 4.0].map(|z| [angle.cos(), angle.sin(), z]));
        let [a, b] = [2 * side, 2 * ((side + 1) % sides)];
        tube.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    assert_eq!(oriented(&tube).1, 0);
    let bore = join(&[cube(8.0), turn(tube)]);
    assert_eq!(oriented(&bore).1, 0);
}

#[test]
fn an_open_sheet_turns_with_the_left_handed_mesh_that_it_belongs_to() {
    let mut sheet = cuboid([2.0, 0.0, 0.0], [3.0, 1.0, 1.0]);
    sheet.triangles.truncate(2);
    let (_, turned) = oriented(&turn(join(&[cube(1.0), sheet])));
    assert_eq!(turned, 14);
}

#[test]
fn the_majority_by_area_leads_an_open_patch() {
    let mut open = cube(1.0);
    open.triangles.truncate(10);
    let expected = open.clone();
    open.triangles[0].swap(1, 2);
    open.triangles[7].swap(1, 2);
    assert_eq!(oriented(&open), (expected, 2));
}

#[test]
fn a_surface_with_one_side_stays_as_it_is() {
    let strip = mobius_strip(12);
    assert_eq!(oriented(&strip), (strip.clone(), 0));
}
