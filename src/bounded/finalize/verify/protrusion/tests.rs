use super::*;
use crate::bounded::clustering::cluster;
use crate::bounded::containment::boundary::Boundary;
use crate::bounded::settings::Settings;
use crate::bvh::Bvh;
use crate::geometry::vector::{add, cross, normalize, scale};
use crate::hull::convex_hull;
use crate::mesh::TriangleMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::prepare;
use crate::mesh::shapes::{cuboid, join, uv_sphere};
use crate::parameters::{Length, Parameters};

#[test]
fn below_stacked_open_sheets_a_large_face_is_not_inside_as_a_whole() {
    // Six unit squares, close above each other: just below them the winding number is 3, but
    // at a depth of 0.9 less than one half.
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for sheet in 0..6_u32 {
        let z = 1e-3 * f64::from(sheet);
        positions.extend([[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]]);
        triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|v| v + 4 * sheet)));
    }
    let control = Control::new();
    let bound = 0.01;
    let boundary = Boundary::new(&positions, &triangles);
    let solid = Solid::of_surface(&positions, &triangles, boundary, bound, &control).unwrap();
    let depth = 0.9;
    let corners = [[0.5, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, 0.5, -depth], [0.6, 0.5, -0.1]];
    let hull = convex_hull(&corners).unwrap();
    assert!(!is_inside(&solid.bvh, &solid.boundary, corners[2]));
    assert!(is_inside(&solid.bvh, &solid.boundary, [0.5, 0.5, -0.3]));
    let found = protrusion(&hull, &solid, bound, f64::INFINITY, &control).unwrap();
    assert!(found >= depth, "{found}");
}

fn cube(low: Vector) -> ConvexHull {
    let corners = (0..8).map(|i| [0, 1, 2].map(|k| low[k] + f64::from(i >> k & 1)));
    convex_hull(&corners.collect::<Vec<_>>()).unwrap()
}

fn solid_of(hull: &ConvexHull, bound: f64) -> Solid {
    let boundary = Boundary::default();
    Solid::of_surface(&hull.points, &hull.triangles, boundary, bound, &Control::new()).unwrap()
}

#[test]
fn a_hull_protrudes_into_the_cavities_that_it_contains_and_into_no_other() {
    let shell = cube([0.0; 3]);
    let bound = 0.02;
    let mut solid = solid_of(&shell, bound);
    solid.cavities = vec![([0.5; 3], 0.1), ([0.5, 0.5, 0.2], 0.15), ([1.5; 3], 0.3)];
    let of = |hull| protrusion(hull, &solid, bound, f64::INFINITY, &Control::new()).unwrap();
    // A result is too large by a share at most.
    assert!((0.15..0.16).contains(&of(&shell)), "{}", of(&shell));
    let upper_half = [[0.0, 0.0, 0.4], [1.0, 0.0, 0.4], [0.0, 1.0, 0.4], [1.0, 1.0, 0.4]];
    let mut corners = upper_half.to_vec();
    corners.extend(upper_half.map(|[x, y, _]| [x, y, 1.0]));
    let upper_half = convex_hull(&corners).unwrap();
    assert!((0.1..0.11).contains(&of(&upper_half)), "{}", of(&upper_half));
}

#[test]
fn a_shifted_hull_protrudes_by_its_shift() {
    let (inner, outer) = (cube([0.0; 3]), cube([0.25; 3]));
    let (control, bound) = (Control::new(), 0.02);
    let solid = solid_of(&inner, bound);
    let of = |hull| protrusion(hull, &solid, bound, f64::INFINITY, &control).unwrap();
    // A hull that is the solid protrudes by nothing: less than the share that is not resolved is not told.
    assert!(of(&inner) <= (UNRESOLVED + RESOLUTION) * bound + f64::EPSILON, "{}", of(&inner));
    // The farthest corner is shifted by a quarter along each axis.
    let farthest = 0.25 * 3f64.sqrt();
    assert!((farthest..1.05 * farthest).contains(&of(&outer)), "{}", of(&outer));
}

const BOUND: f64 = 0.02;

/// A shape as it is searched: the points of its surface, its solid, and its source's surface.
fn searched(mesh: &TriangleMesh) -> (Vec<Vector>, Solid, Bvh) {
    let control = Control::new();
    let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
    let parameters = Parameters::default().max_error(Length::share(BOUND));
    let settings = Settings::of_preset(&parameters, 1.0).swap_remove(0);
    let clustered = cluster(&prepared, &settings, &control).unwrap();
    let solid = Solid::new(&prepared, clustered, &settings, &control).unwrap();
    let TriangleMesh { positions, triangles, .. } = prepared.mesh;
    let source = Bvh::new(&positions, &triangles);
    (positions, solid, source)
}

/// A pyramid that is within a round shape but for its tip.
fn spike(at: Vector, height: f64, width: f64) -> ConvexHull {
    let outward = normalize(at);
    let across = normalize(cross(outward, [0.48, 0.6, 0.64]));
    let along = cross(outward, across);
    let base = [[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]].map(|[x, y]| {
        let foot = add(at, scale(outward, -0.1));
        add(foot, add(scale(across, x * width), scale(along, y * width)))
    });
    let tip = add(at, scale(outward, height));
    convex_hull(&[base[0], base[1], base[2], tip]).unwrap()
}

#[test]
fn a_spike_protrudes_as_far_as_its_tip() {
    let open = |n| {
        let mut mesh = uv_sphere(n, [0.0; 3], 1.0);
        let TriangleMesh { positions, triangles, .. } = &mut mesh;
        triangles.retain(|corners| corners.iter().all(|&v| positions[v as usize][2] < 0.95));
        mesh
    };
    let closed = |n| uv_sphere(n, [0.0; 3], 1.0);
    let control = Control::new();
    // Of few triangles, of more, and of so many that they are clustered.
    for mesh in [closed(20), closed(50), closed(300), open(20), open(50)] {
        let (positions, solid, source) = searched(&mesh);
        let count = positions.len();
        assert_eq!(solid.displacement() > 0.0, count > 10_000);
        let unresolved = if solid.is_closed() { UNRESOLVED } else { UNRESOLVED_IN_OPEN };
        let least = (unresolved * BOUND).max(solid.displacement());
        let low = positions.into_iter().filter(|point| point[2] < 0.0);
        for (at, step) in low.step_by(count / 12).zip(0..) {
            for share in [0.2, 0.4, 0.6, 0.7, 0.8, 0.9, 0.98, 1.01, 1.02, 1.03, 1.2, 1.5, 2.0] {
                let (height, width) = (share * BOUND, [0.02, 0.08][step % 2]);
                let hull = spike(at, height, width);
                let tip = add(at, scale(normalize(at), height));
                let expected = source.closest_point(tip, f64::INFINITY).unwrap().distance;
                let of = |limit| protrusion(&hull, &solid, BOUND, limit, &control).unwrap();
                let found = of(f64::INFINITY);
                let most = 1.001 * enough(expected.max(least), BOUND);
                assert!(
                    (expected - 1e-12..=most).contains(&found),
                    "{count}, {share}: {found}, {expected}"
                );
                if (expected / BOUND - 1.0).abs() > 1e-3 {
                    assert_eq!(of(BOUND) > BOUND, expected > BOUND, "{count}, {share}");
                }
            }
        }
    }
}

#[test]
fn what_protrudes_farther_than_the_limit_is_told_to() {
    let (inner, outer) = (cube([0.0; 3]), cube([0.0, 0.0, 0.25]));
    let solid = solid_of(&inner, BOUND);
    // The first is what is not resolved, the last what the centres of the faces protrude.
    for limit in [UNRESOLVED * BOUND, BOUND, 0.2, 0.25 - 1e-9] {
        let found = protrusion(&outer, &solid, BOUND, limit, &Control::new()).unwrap();
        assert!(found > limit, "{found}, {limit}");
    }
}

#[test]
fn a_cavity_hides_no_protrusion_elsewhere() {
    let (inner, outer) = (cube([0.0; 3]), cube([0.0, 0.0, 0.25]));
    let mut solid = solid_of(&inner, BOUND);
    solid.cavities = vec![([0.5; 3], 0.1)];
    for limit in [0.1, 0.2, f64::INFINITY] {
        let found = protrusion(&outer, &solid, BOUND, limit, &Control::new()).unwrap();
        assert!(found > limit.min(0.25 - 1e-9), "{found}, {limit}");
    }
}

#[test]
fn across_a_gap_as_wide_as_two_bounds_or_less_the_bound_is_kept() {
    // On the line halfway the distance is the same everywhere.
    for share in [0.98, 1.02] {
        let above = 0.1 + 2.0 * share * BOUND;
        let plates = join(&[
            cuboid([0.0; 3], [1.0, 1.0, 0.1]),
            cuboid([0.0, 0.0, above], [1.0, 1.0, above + 0.1]),
        ]);
        let TriangleMesh { positions, triangles, .. } = &plates;
        let control = Control::new();
        let solid =
            Solid::of_surface(positions, triangles, Boundary::default(), BOUND, &control).unwrap();
        let hull = convex_hull(positions).unwrap();
        let found = protrusion(&hull, &solid, BOUND, BOUND, &control).unwrap();
        assert!(found >= share * BOUND, "{found}");
        assert_eq!(found <= BOUND, share <= 1.0, "{found}");
    }
}

#[test]
fn what_is_left_when_parts_are_too_many_counts_with_its_distance_and_its_radius() {
    let solid = solid_of(&cube([0.0; 3]), 0.02);
    let above = |z: f64| [[0.2, 0.2, z], [0.8, 0.2, z], [0.2, 0.8, z]];
    let to_corner = radius([0.4, 0.4, 0.0], above(0.0));
    for height in [0.0, 0.5, 2.0] {
        let upper = upper_distance(above(1.0 + height), &solid);
        assert!((upper - (height + to_corner)).abs() < 1e-9, "{height}: {upper}");
    }
}
