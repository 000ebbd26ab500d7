//! Known solids, against their formulas.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::decompose::decompose;
use crate::mesh::TriangleMesh;
use crate::mesh::shapes::{cuboid, hemisphere, join, torus, turn};
use crate::parameters::{Openings, Parameters};

/// A density that is not 1, so that a forgotten one shows.
const DENSITY: f64 = 3.0;

fn of(mesh: &TriangleMesh) -> MassProperties {
    mass_properties(mesh, &[], DENSITY).unwrap()
}

fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found}, not {expected}");
}

/// Mass and inertia within `share`, everything off the diagonal next to 0.
fn assert_properties(found: &MassProperties, volume: f64, inertia: Vector, share: f64) {
    assert_close(found.mass, DENSITY * volume, share * DENSITY * volume);
    for (i, row) in found.inertia.into_iter().enumerate() {
        let size = DENSITY * inertia[i];
        for (j, found) in row.into_iter().enumerate() {
            assert_close(found, if i == j { size } else { 0.0 }, share * size);
        }
    }
}

fn box_inertia(Vector { x, y, z }: Vector) -> Vector {
    let mass = x * y * z;
    Vector::from_array([y * y + z * z, x * x + z * z, x * x + y * y].map(|sum| mass * sum / 12.0))
}

#[test]
fn a_torus_is_within_a_hundredth() {
    let mesh = torus(96, 64);
    let reach = |axis: usize| mesh.points().iter().map(|p| p[axis]).fold(0.0, f64::max);
    let (small, large) = (reach(2), reach(0) - reach(2));
    let volume = TAU * PI * large * small * small;
    let along = volume * (large * large + 0.75 * small * small);
    let across = volume * (large * large / 2.0 + 0.625 * small * small);
    let found = of(&mesh);
    assert_eq!(found.source, MassSource::Mesh);
    assert_properties(&found, volume, Vector::new(across, across, along), 0.01);
}

#[test]
fn a_cavity_is_taken_off() {
    let hollow = join(&[cuboid([-2.0; 3], [2.0; 3]), turn(cuboid([-1.5; 3], [1.5; 3]))]);
    let found = of(&hollow);
    assert_eq!(found.source, MassSource::Mesh);
    let [outer, inner] = [4.0, 3.0].map(|side| box_inertia(Vector::splat(side))[0]);
    assert_properties(&found, 64.0 - 27.0, Vector::splat(outer - inner), 1e-9);
}

#[test]
fn winding_does_not_matter() {
    let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
    let (found, turned) = (of(&mesh), of(&turn(mesh)));
    assert_close(found.mass, turned.mass, 1e-12);
}

#[test]
fn an_overlap_counts_once() {
    let bars =
        [cuboid([-2.0, -0.5, -0.5], [2.0, 0.5, 0.5]), cuboid([-0.5, -2.0, -0.5], [0.5, 2.0, 0.5])];
    let found = of(&join(&bars));
    assert_eq!(found.source, MassSource::MeshUnion);
    let bar = [
        box_inertia(Vector::new(4.0, 1.0, 1.0)),
        box_inertia(Vector::new(1.0, 4.0, 1.0)),
        box_inertia(Vector::ONE),
    ];
    let inertia = Vector::from_array([0, 1, 2].map(|i| bar[0][i] + bar[1][i] - bar[2][i]));
    assert_properties(&found, 7.0, inertia, 0.01);
}

#[test]
fn an_open_mesh_takes_the_union_of_its_hulls_or_its_own() {
    let mut bar = cuboid([0.0; 3], [2.0, 1.0, 1.0]);
    bar.triangles.pop();
    let keep = Parameters::default().openings(Openings::Keep);
    let of_shell =
        |mesh, hulls: &[Hull]| mass_properties_with(mesh, hulls, DENSITY, &keep).unwrap();
    let found = of_shell(&bar, &[]);
    assert_eq!(found.source, MassSource::ConvexHull);
    assert_properties(&found, 2.0, box_inertia(Vector::new(2.0, 1.0, 1.0)), 1e-9);

    let hull = |low, high| {
        let mesh = cuboid(low, high);
        let parameters = Parameters::default();
        decompose(&mesh, &parameters, &Control::new()).unwrap().hulls
    };
    let hulls = [hull([0.0; 3], [1.5, 1.0, 1.0]), hull([0.5, 0.0, 0.0], [2.0, 1.0, 1.0])].concat();
    let found = of_shell(&bar, &hulls);
    assert_eq!(found.source, MassSource::HullUnion);
    assert_properties(&found, 2.0, box_inertia(Vector::new(2.0, 1.0, 1.0)), 0.01);

    assert_eq!(of_shell(&hemisphere(16), &[]).source, MassSource::ConvexHull);
    assert_eq!(of(&bar).source, MassSource::Mesh, "its flat opening is closed");
}

#[test]
fn scaling_the_properties_is_scaling_the_mesh() {
    let mut mesh = join(&[cuboid([0.0; 3], [1.0, 2.0, 3.0]), cuboid([2.0; 3], [3.0, 2.5, 4.0])]);
    let scale = [-2.0, 0.5, 3.0];
    let expected = of(&mesh).scaled(scale);
    for point in &mut mesh.positions {
        *point = [0, 1, 2].map(|i| point[i] * scale[i]);
    }
    let found = of(&mesh);
    assert_close(found.mass, expected.mass, 1e-9);
    for i in 0..3 {
        assert_close(found.centre[i], expected.centre[i], 1e-9);
        for j in 0..3 {
            assert_close(found.inertia[i][j], expected.inertia[i][j], 1e-8);
        }
    }
    let heavier = found.with_mass(2.0 * found.mass);
    assert_close(heavier.inertia[0][1], 2.0 * found.inertia[0][1], 1e-9);
}

#[test]
fn a_density_of_nothing_is_an_error() {
    let mesh = cuboid([0.0; 3], [1.0; 3]);
    for density in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let result = mass_properties(&mesh, &[], density);
        assert!(matches!(result, Err(Error::InvalidParameter { name: "density", .. })));
    }
}
