//! Costs and collapses that can be worked out by hand.

use super::surface::{Depth, Judge, Surface};
use super::*;
use crate::shapes::{cuboid, join, torus, turn};

/// Two right triangles that make a square of side 1.
fn square() -> TriangleMesh {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]])
}

/// An L of two unit squares along the y axis, seen from within: a wall that looks along x and a
/// floor that looks along z.
fn wall_and_floor() -> TriangleMesh {
    let line = |y: f64| [[0.0, y, 1.0], [0.0, y, 0.0], [1.0, y, 0.0]];
    let positions = [line(0.0), line(1.0)].concat();
    TriangleMesh::new(positions, vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
}

/// Depth of the L's corner: its normal is (1, 0, 2) / √5, since the floor has two triangles there,
/// and the hull ends at x + z = 1.
const CORNER_DEPTH: f64 = 0.745_355_992_499_929_9;

fn groups(mesh: &TriangleMesh, concavity: f64) -> (Vec<u32>, usize) {
    let threshold = Threshold { concavity, length: mean_triangle_diagonal(mesh) };
    collapse(mesh, &neighbours(mesh), threshold, &Control::new()).unwrap()
}

/// The triangles of each group, in ascending order.
fn members((groups, count): &(Vec<u32>, usize)) -> Vec<Vec<u32>> {
    let mut members = vec![Vec::new(); *count];
    (0..).zip(groups).for_each(|(triangle, &group)| members[group as usize].push(triangle));
    members
}

fn surfaces(mesh: &TriangleMesh) -> Vec<Surface> {
    (0..mesh.triangles.len() as u32).map(|t| Surface::triangle(mesh, t)).collect()
}

/// Joins two surfaces as a collapse does.
fn joined(judge: &mut Judge, first: &Surface, second: &Surface, shared: f64) -> Surface {
    let hull = judge.joint_hull(first, second);
    let depth = judge.joint_depth(first, second, hull.as_ref(), f64::INFINITY);
    let mut joint = first.clone();
    joint.absorb(second.clone(), shared, hull, depth);
    joint
}

#[test]
fn a_square_has_the_shape_factor_of_a_square() {
    let mesh = square();
    let [first, second] = [0, 1].map(|t| Surface::triangle(&mesh, t));
    let diagonal = f64::sqrt(2.0);
    assert!((first.perimeter - (2.0 + diagonal)).abs() < 1e-12);
    assert!((first.area - 0.5).abs() < 1e-12);
    // ρ = 4, σ = 1: ρ² / (4 π σ) = 4 / π.
    let factor = first.joint_shape_factor(&second, diagonal);
    assert!((factor - 4.0 / std::f64::consts::PI).abs() < 1e-12, "{factor}");
    assert!((first.joint_diagonal(&second) - diagonal).abs() < 1e-12);
}

#[test]
fn coplanar_triangles_are_joined_however_small_the_threshold() {
    assert_eq!(groups(&square(), 1e-6), (vec![0, 0], 1));
}

#[test]
fn the_depth_of_an_l_is_that_of_its_corner_along_its_own_normal() {
    let mesh = wall_and_floor();
    let [a, b, c, d] = [0, 1, 2, 3].map(|t| Surface::triangle(&mesh, t));
    let diagonal = f64::sqrt(2.0);
    let mut judge = Judge::new(&mesh);
    let wall = joined(&mut judge, &a, &b, diagonal);
    let floor = joined(&mut judge, &c, &d, diagonal);
    let mut depth = |a, b, limit| {
        let hull = judge.joint_hull(a, b);
        judge.joint_depth(a, b, hull.as_ref(), limit)
    };
    let found = depth(&wall, &floor, f64::INFINITY);
    assert!((found.depth - CORNER_DEPTH).abs() < 1e-9, "{found:?}");
    assert!([1, 4].contains(&found.vertex));
    assert!(depth(&wall, &floor, 0.7).depth >= 0.7);
    assert_eq!(depth(&a, &b, 0.1), Depth { depth: 0.0, vertex: 0 });
}

#[test]
fn an_l_is_one_surface_only_above_its_cost() {
    // Depth over √3, and α E_shape = β √2 / (10 √3) · 36 / (8 π), below β.
    let least = CORNER_DEPTH
        / 3.0_f64.sqrt()
        / (1.0 - f64::sqrt(2.0 / 3.0) / 10.0 * 36.0 / (8.0 * std::f64::consts::PI));
    assert!((0.48..0.49).contains(&least), "{least}");
    assert_eq!(groups(&wall_and_floor(), least - 0.001), (vec![0, 0, 1, 1], 2));
    assert_eq!(groups(&wall_and_floor(), least + 0.001).1, 1);
}

#[test]
fn an_l_seen_from_outside_is_convex() {
    assert_eq!(groups(&turn(wall_and_floor()), 1e-6).1, 1);
}

#[test]
fn the_shape_factor_alone_can_forbid_a_collapse() {
    let mesh = square();
    let with_length = |length| {
        let threshold = Threshold { concavity: 0.05, length };
        collapse(&mesh, &neighbours(&mesh), threshold, &Control::new()).unwrap().1
    };
    // β ℓ / (10 √2) · 4/π < β as long as ℓ < 10 √2 π / 4 = 11.1.
    assert_eq!(with_length(11.0), 1);
    assert_eq!(with_length(11.2), 2);
}

#[test]
fn a_cube_is_one_surface_without_border() {
    let mesh = cuboid([0.0; 3], [1.0; 3]);
    assert_eq!(groups(&mesh, 0.01).1, 1);
    let all = surfaces(&mesh);
    let mut whole = all[0].clone();
    let neighbours = neighbours(&mesh);
    let mut judge = Judge::new(&mesh);
    while whole.triangles.len() < 12 {
        // The next triangle that shares a side, and the length of what they share.
        let rest = all.iter().filter(|one| !whole.triangles.contains(&one.triangles[0]));
        let shared = rest.map(|one| (one, border(&mesh, &neighbours, &whole, one)));
        let (next, length) = shared.into_iter().find(|(_, length)| *length > 0.0).unwrap();
        whole = joined(&mut judge, &whole, next, length);
    }
    assert!(whole.perimeter.abs() < 1e-9);
    assert!((whole.area - 6.0).abs() < 1e-12);
    assert_eq!(whole.hull_points.len(), 8);
    assert_eq!(whole.vertices.len(), 8);
}

#[test]
fn fewer_surfaces_with_a_larger_threshold_and_each_triangle_in_one() {
    let mesh = torus(24, 12);
    let counts: Vec<usize> = [0.01, 0.05, 0.2].map(|beta| groups(&mesh, beta).1).to_vec();
    assert!(counts[0] > counts[1] && counts[1] > counts[2], "{counts:?}");
    let groups = groups(&mesh, 0.05);
    assert!(members(&groups).iter().all(|group| !group.is_empty()));
    assert_eq!(groups.0[0], 0);
}

#[test]
fn no_surface_costs_beta_or_more() {
    let mesh = torus(24, 12);
    let beta = 0.05;
    for group in members(&groups(&mesh, beta)) {
        let triangles = group.iter().map(|&triangle| mesh.triangles[triangle as usize]).collect();
        let alone = TriangleMesh::new(mesh.positions.clone(), triangles);
        let cost = average_cost(&grouped(&alone, &vec![0; group.len()])).unwrap();
        assert!(cost < beta, "{cost}");
    }
}

#[test]
fn separate_cubes_stay_separate() {
    let mesh = join(&[cuboid([0.0; 3], [1.0; 3]), cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0])]);
    let found = decompose(&mesh, &HacdParameters::default(), &Control::new());
    let found = found.unwrap();
    assert_eq!(found.hulls.len(), 2);
    assert!(found.hulls.iter().all(|hull| (hull.shape.volume() - 1.0).abs() < 1e-9));
    assert!(found.cost < 1e-9);
}

#[test]
fn threads_and_scale_change_nothing() {
    let mesh = torus(40, 20);
    let parameters = HacdParameters::default();
    let run = |is_parallel: bool, scale: f64| {
        let positions: Vec<[f64; 3]> =
            mesh.positions.iter().map(|p| p.map(|x| x * scale)).collect();
        let control = Control::new().with_parallel(is_parallel);
        decompose(MeshView::new(&positions, &mesh.triangles), &parameters, &control).unwrap()
    };
    let first = run(true, 1.0);
    assert_eq!(run(false, 1.0).hulls, first.hulls);
    assert_eq!(run(true, 1024.0).grouped.groups, first.grouped.groups);
}

#[test]
fn values_that_mean_nothing_are_refused() {
    let mesh = square();
    let parameters = HacdParameters { concavity_threshold: 0.0, ..HacdParameters::default() };
    let refused = decompose(&mesh, &parameters, &Control::new());
    assert!(matches!(refused, Err(Error::InvalidParameter { name: "concavity_threshold", .. })));
}

#[test]
fn a_deadline_in_the_past_is_an_error() {
    let mesh = torus(40, 20);
    let control = Control::new().with_deadline(Instant::now());
    let result = decompose(&mesh, &HacdParameters::default(), &control);
    assert_eq!(result.unwrap_err(), Error::DeadlineExceeded);
}

/// Judges every pair before every collapse, as slowly as it can be said.
fn grouped_slowly(mesh: &TriangleMesh, threshold: Threshold) -> Vec<Vec<u32>> {
    let neighbours = neighbours(mesh);
    let mut judge = Judge::new(mesh);
    let mut all: Vec<Surface> = surfaces(mesh);
    loop {
        let mut best: Option<(f64, usize, usize, f64)> = None;
        for (i, j) in (0..all.len()).flat_map(|i| (i + 1..all.len()).map(move |j| (i, j))) {
            let shared = border(mesh, &neighbours, &all[i], &all[j]);
            if shared == 0.0 {
                continue;
            }
            let (diagonal, shape) = threshold.shape_cost(&all[i], &all[j], shared);
            let hull = judge.joint_hull(&all[i], &all[j]);
            let depth = judge.joint_depth(&all[i], &all[j], hull.as_ref(), f64::INFINITY);
            let cost = depth.depth / diagonal + shape;
            if cost < threshold.concavity && best.is_none_or(|best| cost < best.0) {
                best = Some((cost, i, j, shared));
            }
        }
        let Some((_, i, j, shared)) = best else { break };
        let second = all.remove(j);
        all[i] = joined(&mut judge, &all[i], &second, shared);
    }
    let mut groups: Vec<Vec<u32>> = all.into_iter().map(|surface| surface.triangles).collect();
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort();
    groups
}

/// Length of the sides that two surfaces share.
fn border(mesh: &TriangleMesh, all: &Neighbours, first: &Surface, second: &Surface) -> f64 {
    let sides = first.triangles.iter().flat_map(|&triangle| (0..3).map(move |k| (triangle, k)));
    let shared = sides.filter(|&(triangle, side)| {
        all[triangle as usize][side].is_some_and(|other| second.triangles.contains(&other))
    });
    let length = |(triangle, side): (u32, usize)| {
        let corners = corners(mesh, triangle);
        corners[side].distance(corners[(side + 1) % 3])
    };
    shared.map(length).sum()
}

#[test]
fn the_queue_gives_what_judging_every_pair_each_time_would() {
    // Without symmetry, so that no two costs are equal.
    let mut mesh = torus(9, 5);
    for (i, point) in (0..).zip(&mut mesh.positions) {
        let sway = |k: f64| 0.05 * (f64::from(i) * k).sin();
        *point = [point[0] + sway(1.3), point[1] + sway(2.7), 1.4 * point[2] + sway(3.1)];
    }
    for concavity in [0.02, 0.05, 0.1] {
        let threshold = Threshold { concavity, length: mean_triangle_diagonal(&mesh) };
        let found = collapse(&mesh, &neighbours(&mesh), threshold, &Control::new()).unwrap();
        let mut groups = members(&found);
        groups.sort();
        assert!(found.1 > 1);
        assert_eq!(groups, grouped_slowly(&mesh, threshold), "{concavity}");
    }
}
