//! Costs and collapses that can be worked out by hand, and by brute force.

use super::super::{SurfaceParameters, decompose};
use super::*;
use crate::decomposition::GroupedMesh;
use crate::mesh::grouping::members;
use crate::mesh::shapes::{cuboid, join, torus, turn};
use crate::surface::average_cost;

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

/// Two unit cubes, and a square beam between them that stands on their facing sides.
fn boxes_and_bridge() -> TriangleMesh {
    let (left, right) = (cuboid([0.0; 3], [1.0; 3]), cuboid([2.0, 0.0, 0.0], [3.0, 1.0, 1.0]));
    let beam = cuboid([1.0, 0.4, 0.4], [2.0, 0.6, 0.6]);
    let mut mesh = join(&[left, right, beam]);
    // The facing sides and the ends of the beam go; rings take their place.
    let is_end = |corners: [[f64; 3]; 3]| {
        [1.0, 2.0].iter().any(|x| corners.iter().all(|corner| corner[0] == *x))
    };
    let positions = mesh.positions.clone();
    mesh.triangles.retain(|triangle| !is_end(triangle.map(|vertex| positions[vertex as usize])));
    let ring = |outer: [u32; 4], inner: [u32; 4]| {
        (0..4).flat_map(move |k| {
            let next = (k + 1) % 4;
            [[outer[k], outer[next], inner[k]], [outer[next], inner[next], inner[k]]]
        })
    };
    // Vertex number is x + 2 y + 4 z.
    mesh.triangles.extend(ring([1, 3, 7, 5], [16, 18, 22, 20]));
    mesh.triangles.extend(ring([8, 12, 14, 10], [17, 21, 23, 19]));
    mesh
}

/// Depth of the L's corner: its normal is (1, 0, 2) / √5, since the floor has two triangles there,
/// and the hull ends at x + z = 1.
const CORNER_DEPTH: f64 = 0.745_355_992_499_929_9;

fn groups(mesh: &TriangleMesh, threshold: f64) -> Grouping {
    group(mesh, &Adjacency::new(mesh), threshold, &Control::new()).unwrap()
}

/// The triangles of each group, in ascending order.
fn triangles_of(Grouping { labels, count }: &Grouping) -> Vec<Vec<u32>> {
    let mut groups = members(labels, *count);
    groups.sort();
    groups
}

fn labelled(labels: &[u32], count: usize) -> Grouping {
    Grouping { labels: labels.to_vec(), count }
}

/// Joins two surfaces as a collapse does.
fn joined(mesh: &TriangleMesh, first: &Surface, second: &Surface, border: f64) -> Surface {
    let hull = joint_hull(&mut HullBuilder::new(), first, second);
    let deepest = joint_deepest(mesh, first, second, hull.as_ref(), f64::INFINITY);
    let mut joint = first.clone();
    joint.absorb(second.clone(), border, hull, deepest);
    joint
}

#[test]
fn a_square_has_the_shape_factor_of_a_square() {
    let mesh = square();
    let [first, second] = [0, 1].map(|triangle| Surface::triangle(&mesh, triangle));
    let diagonal = f64::sqrt(2.0);
    // ρ = 4, σ = 1: ρ² / (4 π σ) = 4 / π.
    let factor = first.joint_shape_factor(&second, diagonal);
    assert!((factor - 4.0 / PI).abs() < 1e-12, "{factor}");
    assert!((first.joint_diagonal(&second) - diagonal).abs() < 1e-12);
    assert!((joined(&mesh, &first, &second, diagonal).area - 1.0).abs() < 1e-12);
}

#[test]
fn coplanar_triangles_are_joined_however_small_the_threshold() {
    assert_eq!(groups(&square(), 1e-6), labelled(&[0, 0], 1));
}

#[test]
fn the_depth_of_an_l_is_that_of_its_corner_along_its_own_normal() {
    let mesh = wall_and_floor();
    let [a, b, c, d] = [0, 1, 2, 3].map(|triangle| Surface::triangle(&mesh, triangle));
    let diagonal = f64::sqrt(2.0);
    let (wall, floor) = (joined(&mesh, &a, &b, diagonal), joined(&mesh, &c, &d, diagonal));
    let deepest = |first, second, limit| {
        let hull = joint_hull(&mut HullBuilder::new(), first, second);
        joint_deepest(&mesh, first, second, hull.as_ref(), limit)
    };
    let found = deepest(&wall, &floor, f64::INFINITY);
    assert!((found.depth - CORNER_DEPTH).abs() < 1e-9, "{found:?}");
    assert!([1, 4].contains(&found.vertex));
    assert!(deepest(&wall, &floor, 0.7).depth >= 0.7);
    assert_eq!(deepest(&a, &b, 0.1), Deepest { depth: 0.0, vertex: 0 });
}

#[test]
fn an_l_is_one_surface_only_above_its_cost() {
    // Depth over √3, and α E_shape = β √2 / (10 √3) · 36 / (8 π), below β.
    let shape = f64::sqrt(2.0 / 3.0) / 10.0 * 36.0 / (8.0 * PI);
    let least = CORNER_DEPTH / 3.0_f64.sqrt() / (1.0 - shape);
    assert!((0.48..0.49).contains(&least), "{least}");
    assert_eq!(groups(&wall_and_floor(), least - 0.001), labelled(&[0, 0, 1, 1], 2));
    assert_eq!(groups(&wall_and_floor(), least + 0.001).count, 1);
    assert_eq!(groups(&turn(wall_and_floor()), 1e-6).count, 1, "from outside it is convex");
}

#[test]
fn the_shape_factor_alone_can_forbid_a_collapse() {
    let (mesh, threshold) = (square(), 0.05);
    let with_length = |length| {
        let graph =
            DualGraph { length, ..DualGraph::new(&mesh, &Adjacency::new(&mesh), threshold) };
        let [first, second] = [0, 1].map(|node: usize| &graph.surfaces[node]);
        graph.shape_cost(first, second, f64::sqrt(2.0)).1
    };
    // β ℓ / (10 √2) · 4/π < β as long as ℓ < 10 √2 π / 4 = 11.1.
    assert!(with_length(11.0) < threshold && with_length(11.2) > threshold);
}

#[test]
fn a_cube_is_one_surface_without_border() {
    let mesh = cuboid([0.0; 3], [1.0; 3]);
    assert_eq!(groups(&mesh, 0.01).count, 1);
    let adjacency = Adjacency::new(&mesh);
    let mut graph = DualGraph::new(&mesh, &adjacency, 0.01);
    while let Some((edge, deepest)) = graph.cheapest() {
        graph.collapse(edge, deepest);
    }
    let whole = graph.surfaces.iter().find(|surface| !surface.triangles.is_empty()).unwrap();
    assert!(whole.perimeter.abs() < 1e-9);
    assert!((whole.area - 6.0).abs() < 1e-12);
    assert_eq!((whole.hull_points.len(), whole.corners.len()), (8, 8));
}

#[test]
fn two_boxes_and_a_bridge_are_three_surfaces() {
    let mesh = boxes_and_bridge();
    let found = groups(&mesh, 0.05);
    let sizes: Vec<usize> = triangles_of(&found).iter().map(Vec::len).collect();
    assert_eq!(sizes, [18, 18, 8], "{found:?}");
    assert_eq!(groups(&mesh, 10.0).count, 1);
}

#[test]
fn fewer_surfaces_with_a_larger_threshold_and_none_costs_as_much() {
    let mesh = torus(24, 12);
    let counts = [0.01, 0.05, 0.2].map(|threshold| groups(&mesh, threshold).count);
    assert!(counts[0] > counts[1] && counts[1] > counts[2], "{counts:?}");
    for group in triangles_of(&groups(&mesh, 0.05)) {
        let triangles: Vec<[u32; 3]> =
            group.iter().map(|&triangle| mesh.triangles[triangle as usize]).collect();
        let groups = vec![0; triangles.len()];
        let alone = GroupedMesh { positions: mesh.positions.clone(), triangles, groups };
        let cost = average_cost(&alone).unwrap();
        assert!(cost < 0.05, "{cost}");
    }
}

#[test]
fn separate_cubes_stay_separate_and_the_report_says_who_grouped() {
    let mesh = join(&[cuboid([0.0; 3], [1.0; 3]), cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0])]);
    let found = decompose(&mesh, &SurfaceParameters::hacd(), &Control::new()).unwrap();
    assert_eq!(found.hulls.len(), 2);
    assert!(found.hulls.iter().all(|hull| (hull.shape.volume() - 1.0).abs() < 1e-9));
    let report = &found.report;
    assert_eq!((report.planar_threshold, report.concavity_threshold), (None, Some(0.05)));
    assert!(report.cost < 1e-9);
    assert!(report.resolutions.iter().all(|resolution| resolution.thresholds.len() <= 1));
    assert!(report.to_string().contains("concavity threshold 0.05"), "{report}");
}

/// Judges every pair before every collapse, as slowly as it can be said.
fn grouped_slowly(mesh: &TriangleMesh, threshold: f64) -> Vec<Vec<u32>> {
    let adjacency = Adjacency::new(mesh);
    let graph = DualGraph::new(mesh, &adjacency, threshold);
    let mut all = graph.surfaces.clone();
    loop {
        let mut best: Option<(f64, usize, usize, f64)> = None;
        for (i, j) in (0..all.len()).flat_map(|i| (i + 1..all.len()).map(move |j| (i, j))) {
            let border = border(mesh, &adjacency, &all[i], &all[j]);
            if border == 0.0 {
                continue;
            }
            let (diagonal, shape) = graph.shape_cost(&all[i], &all[j], border);
            let hull = joint_hull(&mut HullBuilder::new(), &all[i], &all[j]);
            let deepest = joint_deepest(mesh, &all[i], &all[j], hull.as_ref(), f64::INFINITY);
            let cost = deepest.depth / diagonal + shape;
            if cost < threshold && best.is_none_or(|best| cost < best.0) {
                best = Some((cost, i, j, border));
            }
        }
        let Some((_, i, j, border)) = best else { break };
        let second = all.remove(j);
        all[i] = joined(mesh, &all[i], &second, border);
    }
    let mut groups: Vec<Vec<u32>> = all.into_iter().map(|surface| surface.triangles).collect();
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort();
    groups
}

/// Length of the sides that two surfaces share.
fn border(mesh: &TriangleMesh, adjacency: &Adjacency, first: &Surface, second: &Surface) -> f64 {
    let sides = first.triangles.iter().flat_map(|&triangle| (0..3).map(move |k| (triangle, k)));
    let length = |(triangle, side): (u32, usize)| {
        let is_shared = second.triangles.contains(&adjacency.triangle_neighbours(triangle)[side]);
        let corners = corners(mesh, triangle);
        if is_shared { corners[side].distance(corners[(side + 1) % 3]) } else { 0.0 }
    };
    sides.map(length).sum()
}

#[test]
fn the_queue_gives_what_judging_every_pair_each_time_would() {
    // Without symmetry, so that no two costs are equal.
    let mut mesh = torus(9, 5);
    for (i, point) in (0..).zip(&mut mesh.positions) {
        let sway = |k: f64| 0.05 * (f64::from(i) * k).sin();
        *point = [point[0] + sway(1.3), point[1] + sway(2.7), 1.4 * point[2] + sway(3.1)];
    }
    for threshold in [0.02, 0.05, 0.1] {
        let found = groups(&mesh, threshold);
        assert!(found.count > 1);
        assert_eq!(triangles_of(&found), grouped_slowly(&mesh, threshold), "{threshold}");
    }
}
