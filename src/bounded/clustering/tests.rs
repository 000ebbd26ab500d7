use super::*;
use crate::bvh::Bvh;
use crate::geometry::vector::{add, length, scale};
use crate::mesh::Normalization;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::repair::prepare;
use crate::mesh::shapes::{cuboid, join, torus, uv_sphere};

const BOUND: f64 = 0.02;

fn clustered(mesh: &TriangleMesh) -> Option<Clustered> {
    let control = Control::new();
    let prepared = prepare(mesh.view(), MeshOrder::Place, &control).unwrap();
    Clustered::new(&prepared, BOUND, 0.08, &control).unwrap()
}

#[test]
fn a_mesh_of_few_triangles_is_not_clustered() {
    assert!(clustered(&torus(100, 40)).is_none());
}

#[test]
fn a_surface_with_a_hole_is_not_clustered() {
    let mut mesh = torus(400, 160);
    mesh.triangles.pop();
    assert!(clustered(&mesh).is_none());
}

#[test]
fn the_many_triangles_at_a_pole_do_not_keep_a_sphere_from_being_clustered() {
    let clustered = clustered(&uv_sphere(800, [0.0; 3], 1.0)).unwrap();
    let longest = clustered.around.longest();
    assert!(longest > MAX_CLUSTER, "{longest}");
}

#[test]
fn the_tip_of_a_needle_stays() {
    // Four cells long, on one triangle of a torus with a diagonal of about 2.6.
    let mut mesh = torus(400, 160);
    let [a, b, c] = mesh.triangles.swap_remove(0);
    let at = mesh.positions[a as usize];
    let out = [at[0], at[1], 0.0];
    let tip = add(at, scale(out, 0.1 / length(out)));
    let new = mesh.positions.len() as u32;
    mesh.positions.push(tip);
    mesh.triangles.extend([[a, b, new], [b, c, new], [c, a, new]]);
    let clustered = clustered(&mesh).unwrap();
    let normalization = Normalization::of(mesh.positions.iter().copied());
    let is_tip = |&vertex: &u32| {
        let position = clustered.mesh.positions[vertex as usize];
        distance(normalization.restore(position), tip) < 1e-6
    };
    assert!(clustered.mesh.triangles.as_flattened().iter().any(is_tip));
}

#[test]
fn the_reduced_mesh_is_closed_and_represents_every_triangle() {
    let clustered = clustered(&torus(400, 160)).unwrap();
    let (mesh, surface) = (&clustered.mesh, &clustered.surface);
    assert!(3 * mesh.triangles.len() < surface.triangles.len());
    assert!(clustered.displacement > 0.0 && clustered.displacement < BOUND);
    let mut edges = std::collections::BTreeMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from.min(to), from.max(to))).or_insert(0) +=
                if from < to { 1 } else { -1 };
        }
    }
    assert!(edges.values().all(|&count| count == 0));
    for (triangle, &representative) in surface.triangles.iter().zip(&clustered.representatives) {
        let corners = mesh.triangles[representative as usize].map(|v| mesh.positions[v as usize]);
        let corner = surface.positions[triangle[0] as usize];
        let nearest = corners.map(|other| distance(corner, other)).into_iter();
        assert!(nearest.fold(f64::INFINITY, f64::min) <= 2.0 * clustered.displacement);
    }
}

#[test]
fn distances_to_the_source_are_exact_or_hardly_too_large() {
    let clustered = clustered(&torus(400, 160)).unwrap();
    let (mesh, surface) = (&clustered.mesh, &clustered.surface);
    let own = Bvh::new(&mesh.positions, &mesh.triangles);
    let source = Bvh::new(&surface.positions, &surface.triangles);
    for i in 0..2000 {
        // Points all around the surface, at most a bound away from it.
        let from = surface.positions[37 * i % surface.positions.len()];
        let away = [0, 1, 2].map(|k| ((i * (k + 3)) as f64).sin());
        let point = add(from, scale(away, 0.5 * BOUND));
        let near = own.closest_point(point, f64::INFINITY).unwrap();
        let corners = mesh.triangles[near.triangle as usize];
        let (found, triangle) = clustered.closest_around(corners, point, near.distance);
        let exact = source.closest_point(point, f64::INFINITY).unwrap().distance;
        assert!((near.distance - exact).abs() <= clustered.displacement);
        assert!(found >= exact - 1e-9 && found <= exact + 0.01 * BOUND, "{found} {exact}");
        assert_eq!(clustered.squared_distance_to(point, triangle).sqrt(), found);
    }
}

#[test]
fn a_ribbon_narrower_than_a_cell_stays() {
    let ribbon = cuboid([2.0, -1.0, 0.0], [2.001, 1.0, 0.001]);
    let mesh = join(&[torus(400, 160), ribbon]);
    let normalization = Normalization::of(mesh.positions.iter().copied());
    let clustered = clustered(&mesh).unwrap();
    let triangles = clustered.mesh.triangles.iter().zip(&clustered.components);
    let of_ribbon = triangles.filter(|(_, component)| **component == 1);
    let ends = of_ribbon.flat_map(|(triangle, _)| triangle);
    let along = ends.map(|&vertex| clustered.mesh.positions[vertex as usize][1]);
    let (low, high) =
        along.fold((0.0, 0.0), |(low, high): (f64, f64), y| (low.min(y), high.max(y)));
    assert!((high - low) * normalization.diagonal > 1.98);
}
