//! Tests of `simplify`.

use super::*;
use crate::mesh::adjacency::{Adjacency, NO_NEIGHBOUR};
use crate::mesh::shapes::{join, uv_sphere};

#[test]
fn the_target_is_the_count_times_q_until_it_is_at_most_r() {
    // 11258, 9006, 7204, 5763, 4610, 3688, 2950, 2360, 1888, 1510, 1208, 966, 772, 617, 493
    assert_eq!(simplification_target(11_258, 0.8, 3000), 2950);
    assert_eq!(simplification_target(11_258, 0.8, 2000), 1888);
    assert_eq!(simplification_target(11_258, 0.8, 1000), 966);
    assert_eq!(simplification_target(11_258, 0.8, 500), 493);
}

#[test]
fn what_is_small_enough_stays() {
    assert_eq!(simplification_target(500, 0.8, 500), 500);
    assert_eq!(simplification_target(12, 0.8, 500), 12);
}

#[test]
fn a_quality_of_one_means_no_simplification() {
    assert_eq!(simplification_target(11_258, 1.0, 500), 11_258);
}

#[test]
fn each_step_takes_away_a_triangle_at_least() {
    assert_eq!(simplification_target(1000, 0.999_999, 3), 3);
    assert_eq!(simplification_target(1000, 1e-9, 3), 0);
}

/// Several meshes as the components of one.
fn join_components(parts: &[TriangleMesh]) -> (TriangleMesh, Vec<u32>) {
    let components = (0_u32..)
        .zip(parts)
        .flat_map(|(component, part)| vec![component; part.triangles.len()])
        .collect();
    (join(parts), components)
}

fn assert_sound(simplified: &SimplifiedMesh, source: &TriangleMesh) {
    let mesh = &simplified.mesh;
    assert_eq!(mesh.triangles.len(), simplified.components.len());
    assert_eq!(mesh.positions.len(), simplified.source_vertices.len());
    for (position, &vertex) in mesh.positions.iter().zip(&simplified.source_vertices) {
        assert_eq!(position, &source.positions[vertex as usize]);
    }
    for &triangle in &mesh.triangles {
        assert!(!is_degenerate(&mesh.positions, triangle));
    }
    let mut used = vec![false; mesh.positions.len()];
    for &vertex in mesh.triangles.as_flattened() {
        used[vertex as usize] = true;
    }
    assert!(!used.contains(&false));
}

#[test]
fn a_sphere_reaches_its_target_and_stays_closed() {
    let source = uv_sphere(40, [0.0; 3], 0.28);
    let components = vec![0; source.triangles.len()];
    for target in [2000, 1000, 250] {
        let simplified = simplify(&source, &components, target, &Control::new()).unwrap();
        assert_sound(&simplified, &source);
        let reached = simplified.mesh.triangles.len();
        assert!(reached <= target && reached + 10 > target, "{reached}");
        let adjacency = Adjacency::new(&simplified.mesh);
        assert!(!adjacency.neighbours.contains(&NO_NEIGHBOUR));
    }
}

#[test]
fn a_target_that_is_reached_already_changes_nothing() {
    let source = uv_sphere(8, [0.0; 3], 0.28);
    let components = vec![0; source.triangles.len()];
    let simplified =
        simplify(&source, &components, source.triangles.len(), &Control::new()).unwrap();
    assert_eq!(simplified.mesh, source);
    assert_eq!(simplified.error, 0.0);
}

#[test]
fn no_component_vanishes() {
    let mut parts = vec![uv_sphere(40, [0.0; 3], 0.2)];
    for i in 0..12 {
        let angle = f64::from(i) * 0.5;
        let centre = [0.27 * angle.cos(), 0.27 * angle.sin(), 0.0];
        parts.push(uv_sphere(8, centre, 0.004));
    }
    let (source, components) = join_components(&parts);
    let simplified = simplify(&source, &components, 50, &Control::new()).unwrap();
    assert_sound(&simplified, &source);
    let measure_all = |mesh: &TriangleMesh, components: &[u32]| {
        measure(&Separated::new(mesh, components), &mesh.triangles, 13)
    };
    let before = measure_all(&source, &components);
    let after = measure_all(&simplified.mesh, &simplified.components);
    for (before, after) in before.into_iter().zip(after) {
        assert!(after.0 >= 4 && !is_lost(before, after), "{after:?}");
    }
    assert!(simplified.mesh.triangles.len() < 250);
}

#[test]
fn loose_triangles_all_stay() {
    let mut source = TriangleMesh::default();
    for i in 0..100_u32 {
        let x = f64::from(i) * 0.005 - 0.25;
        source.positions.extend([[x, 0.0, 0.0], [x + 0.004, 0.0, 0.0], [x, 0.004, 0.0]]);
        source.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    let components: Vec<u32> = (0..100).collect();
    let simplified = simplify(&source, &components, 10, &Control::new()).unwrap();
    assert_sound(&simplified, &source);
    let mut left = simplified.components;
    left.sort_unstable();
    assert_eq!(left, components);
}

#[test]
fn components_that_touch_at_a_vertex_stay_apart() {
    let mut source = uv_sphere(20, [0.0; 3], 0.1);
    let half = source.triangles.len();
    let other = uv_sphere(20, [0.0, 0.0, 0.2], 0.1);
    // The north pole of the first is the south pole of the second.
    let offset = source.positions.len() as u32;
    let south = other.positions.len() as u32 - 1;
    source.positions.extend(&other.positions);
    let number = |v: u32| if v == south { 0 } else { v + offset };
    let moved = other.triangles.iter().map(|t| t.map(number));
    source.triangles.extend(moved);
    let components: Vec<u32> = (0..source.triangles.len()).map(|t| u32::from(t >= half)).collect();
    let simplified = simplify(&source, &components, 60, &Control::new()).unwrap();
    for (triangle, &component) in simplified.mesh.triangles.iter().zip(&simplified.components) {
        let height =
            triangle.iter().map(|&v| simplified.mesh.positions[v as usize][2]).sum::<f64>();
        assert_eq!(component, u32::from(height > 0.3));
    }
}
