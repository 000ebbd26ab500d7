//! Tests of `repair`.

use super::*;
use crate::geometry::vector::as_arrays;
use crate::mesh::shapes::{cuboid, join, torus, turn};

fn repaired(mesh: &TriangleMesh) -> PreparedMesh {
    prepare(mesh.view(), MeshOrder::Place, &Control::new()).expect("usable")
}

fn refused(positions: &[Vector], triangles: &[[u32; 3]]) -> Error {
    prepare(MeshView::new(as_arrays(positions), triangles), MeshOrder::Place, &Control::new())
        .expect_err("unusable")
}

fn cube() -> TriangleMesh {
    cuboid([0.0; 3], [1.0; 3])
}

/// The same triangles, each with vertices of its own.
fn soup(mesh: &TriangleMesh) -> TriangleMesh {
    TriangleMesh {
        positions: mesh
            .triangles
            .as_flattened()
            .iter()
            .map(|&v| mesh.points()[v as usize])
            .map(Into::into)
            .collect(),
        triangles: (0..mesh.triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
        ..TriangleMesh::default()
    }
}

fn moved(mesh: &TriangleMesh, factor: f64, offset: f64) -> TriangleMesh {
    TriangleMesh {
        positions: mesh
            .points()
            .iter()
            .map(|p| p.map(|x| x * factor + offset))
            .map(Into::into)
            .collect(),
        triangles: mesh.triangles.clone(),
        ..TriangleMesh::default()
    }
}

fn volume(mesh: &TriangleMesh) -> f64 {
    let corners = |t: &[u32; 3]| t.map(|v| mesh.points()[v as usize]);
    let tetrahedra = mesh.triangles.iter().map(corners);
    tetrahedra.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

fn sorted(numbers: &[u32]) -> Vec<u32> {
    let mut sorted = numbers.to_vec();
    sorted.sort_unstable();
    sorted
}

#[test]
fn a_clean_box_only_moves_to_the_origin_with_a_diagonal_of_one() {
    let prepared = repaired(&cuboid([1.0, 2.0, 3.0], [3.0, 5.0, 9.0]));
    assert_eq!(prepared.repairs, Repairs::default());
    assert_eq!(prepared.normalization.centre, Vector::new(2.0, 3.5, 6.0));
    assert!((prepared.normalization.diagonal - 7.0).abs() < 1e-12);
    let corner = prepared.mesh.points()[7];
    for (x, expected) in corner.to_array().into_iter().zip([1.0 / 7.0, 1.5 / 7.0, 3.0 / 7.0]) {
        assert!((x - expected).abs() < 1e-15);
    }
    assert_eq!(sorted(&prepared.source_triangles), Vec::from_iter(0..12));
    assert_eq!(sorted(&prepared.source_vertices), Vec::from_iter(0..8));
    assert_eq!(prepared.components, [0; 12]);
    assert_eq!(prepared.closed, [true]);
}

#[test]
fn single_precision_gives_the_same() {
    let positions: Vec<[f32; 3]> = cube().points().iter().map(|p| p.as_vec3().to_array()).collect();
    let prepared =
        prepare(MeshView::new(&positions, &cube().triangles), MeshOrder::Place, &Control::new());
    assert_eq!(prepared, Ok(repaired(&cube())));
}

#[test]
fn nothing_is_refused_in_clear_words() {
    let no_vertices: [Vector; 0] = [];
    assert_eq!(
        refused(&no_vertices, &[]).to_string(),
        "the mesh is empty: 0 vertices, 0 triangles"
    );
    assert_eq!(
        refused(&[Vector::ZERO], &[]).to_string(),
        "the mesh is empty: 1 vertices, 0 triangles"
    );
}

#[test]
fn a_sidedness_is_given_for_all_triangles_or_for_none() {
    let cube = cube();
    let of = |count| vec![crate::geometry::Sidedness::Two; count];
    let refused = |sidedness: &[_]| {
        prepare(cube.view().with_sidedness(sidedness), MeshOrder::Place, &Control::new())
            .expect_err("too few")
    };
    assert_eq!(refused(&of(3)), Error::SidednessCount { sidedness: 3, triangles: 12 });
    let all = of(12);
    let known = prepare(cube.view().with_sidedness(&all), MeshOrder::Place, &Control::new());
    assert_eq!(known, Ok(repaired(&cube)));
}

#[test]
fn an_index_out_of_range_is_named() {
    assert_eq!(
        refused(&[Vector::ZERO; 3], &[[0, 1, 2], [0, 3, 1]]),
        Error::IndexOutOfRange { triangle: 1, index: 3, vertices: 3 }
    );
}

#[test]
fn a_point_a_line_and_nan_are_not_usable() {
    let nan = f64::NAN;
    let unusable =
        |degenerate, non_finite| Error::NothingUsable { triangles: 1, degenerate, non_finite };
    assert_eq!(refused(&[Vector::splat(2.0); 3], &[[0, 1, 2]]), unusable(1, 0));
    let line = [Vector::ZERO, Vector::ONE, Vector::splat(2.0)];
    assert_eq!(refused(&line, &[[0, 1, 2]]), unusable(1, 0));
    let holes = [[0.0; 3], [1.0, nan, 0.0], [f64::INFINITY, 0.0, 0.0]].map(Vector::from);
    assert_eq!(refused(&holes, &[[0, 1, 2]]), unusable(0, 1));
    let tiny = [[0.0; 3], [1e-320, 0.0, 0.0], [0.0, 1e-320, 0.0]].map(Vector::from);
    assert_eq!(refused(&tiny, &[[0, 1, 2]]), unusable(1, 0));
}

#[test]
fn a_single_triangle_is_usable() {
    let triangle = TriangleMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    let prepared = repaired(&triangle);
    assert_eq!(prepared.repairs.open_edges, 3);
    assert_eq!(prepared.closed, [false]);
}

#[test]
fn any_size_that_numbers_can_hold_is_the_same_mesh() {
    let expected = repaired(&cube());
    for factor in [1e-300, 1e-20, 1e-6, 1e7, 1e30, 1e200, 1e299] {
        let prepared = repaired(&moved(&cube(), factor, 0.0));
        assert_eq!(prepared.repairs, Repairs::default(), "times {factor}");
        for (a, b) in prepared.mesh.points().iter().zip(expected.mesh.points()) {
            assert!(a.distance_squared(*b) < 1e-28, "times {factor}");
        }
    }
}

#[test]
fn a_mesh_far_from_the_origin_keeps_its_shape() {
    let source = torus(24, 12);
    let prepared = repaired(&moved(&source, 1.0, 1e7));
    assert_eq!(prepared.repairs, Repairs::default());
    let size = prepared.normalization.diagonal.powi(3);
    assert!((volume(&prepared.mesh) * size - volume(&source)).abs() < 1e-5);
}

#[test]
fn soup_is_welded() {
    let prepared = repaired(&soup(&cube()));
    assert_eq!(prepared.repairs.welded_vertices, 36 - 8);
    assert_eq!(prepared.mesh.positions.len(), 8);
    assert_eq!(prepared.closed, [true]);
}

#[test]
fn soup_with_rounded_coordinates_is_welded_to_one_of_it() {
    let mut mesh = soup(&moved(&torus(24, 12), 1.0, 0.7));
    for (v, position) in mesh.positions.iter_mut().enumerate() {
        position[v % 3] += (v % 7) as f64 * 1e-8;
    }
    let prepared = repaired(&mesh);
    assert_eq!(prepared.mesh.positions.len(), 24 * 12);
    assert_eq!(prepared.closed, [true]);
    for (&position, &source) in prepared.mesh.points().iter().zip(&prepared.source_vertices) {
        let expected = prepared.normalization.normalize(mesh.points()[source as usize]);
        assert_eq!(position, expected);
    }
}

#[test]
fn the_thinnest_wall_that_the_tolerance_allows_stays() {
    let plate = repaired(&cuboid([0.0; 3], [1.0, 1.0, 1e-5]));
    assert_eq!(plate.repairs, Repairs::default());
    let sheet = repaired(&cuboid([0.0; 3], [1.0, 1.0, 1e-7]));
    assert_eq!(sheet.mesh.triangles.len(), 2);
    assert_eq!(sheet.repairs.duplicate_triangles, 2);
    assert_eq!(sheet.repairs.degenerate_triangles, 8);
}

#[test]
fn a_vertex_that_nobody_uses_does_not_matter() {
    for stranger in [[1e12, 0.0, 0.0], [f64::NAN; 3], [f64::INFINITY; 3]] {
        let mut mesh = cube();
        mesh.positions.insert(0, stranger);
        mesh.triangles = mesh.triangles.iter().map(|t| t.map(|v| v + 1)).collect();
        let prepared = repaired(&mesh);
        assert_eq!(prepared.repairs.unused_vertices, 1);
        assert_eq!(prepared.mesh, repaired(&cube()).mesh);
        assert_eq!(sorted(&prepared.source_vertices), Vec::from_iter(1..9));
    }
}

#[test]
fn a_far_vertex_of_triangles_without_area_does_not_matter() {
    let mut mesh = cube();
    mesh.positions.push([1e9, 0.0, 0.0]);
    mesh.triangles.extend([[8, 8, 0], [0, 8, 8]]);
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs.degenerate_triangles, 2);
    assert_eq!(prepared.repairs.unused_vertices, 1);
    assert_eq!(prepared.mesh, repaired(&cube()).mesh);
}

#[test]
fn triangles_at_a_nan_vertex_go() {
    let mut mesh = torus(24, 12);
    mesh.positions[5][1] = f64::NAN;
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs.non_finite_triangles, 6);
    assert_eq!(prepared.repairs.open_edges, 6);
    assert_eq!(prepared.repairs.unused_vertices, 1);
    assert_eq!(prepared.mesh.triangles.len(), 2 * 24 * 12 - 6);
}

#[test]
fn degenerate_triangles_go() {
    let mut mesh = cube();
    mesh.positions.push([0.5, 0.0, 0.0]);
    // Two equal indices, and three vertices on the edge from 0 to 1.
    mesh.triangles.insert(0, [0, 0, 1]);
    mesh.triangles.push([0, 8, 1]);
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs.degenerate_triangles, 2);
    assert_eq!(prepared.repairs.unused_vertices, 1);
    assert_eq!(sorted(&prepared.source_triangles), Vec::from_iter(1..13));
    assert_eq!(prepared.closed, [true]);
}

#[test]
fn a_box_with_a_cap_in_its_edge_stays_closed() {
    // The edge from 0 to 1 has a middle vertex on one side, and a cap that hides it.
    let mut mesh = cube();
    mesh.positions.push([0.5, 0.0, 0.0]);
    let bottom = mesh.triangles.iter().position(|t| *t == [0, 3, 1]).expect("bottom");
    mesh.triangles[bottom] = [0, 3, 8];
    mesh.triangles.extend([[8, 3, 1], [0, 8, 1]]);
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs.degenerate_triangles, 1);
    assert_eq!(prepared.repairs.open_edges, 0);
    assert_eq!(prepared.closed, [true]);
    assert_eq!(prepared.mesh.triangles.len(), 14);
    assert_eq!(prepared.source_triangles.iter().filter(|&&t| t == 2).count(), 2);
    assert!((volume(&prepared.mesh) - volume(&repaired(&cube()).mesh)).abs() < 1e-12);
}

#[test]
fn duplicate_triangles_go_however_they_are_wound() {
    let mut mesh = cube();
    let copies: Vec<[u32; 3]> = mesh.triangles.iter().map(|&[a, b, c]| [b, c, a]).collect();
    mesh.triangles.extend(copies);
    mesh.triangles.extend(turn(cube()).triangles);
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs.duplicate_triangles, 24);
    assert_eq!(prepared.mesh, repaired(&cube()).mesh);
    assert_eq!(prepared.closed, [true]);
    assert_eq!(prepared.repairs.flipped_triangles, 0);
    assert_eq!(prepared.is_both_ways, [false; 12]);
}

#[test]
fn what_is_wound_both_ways_is_told_apart_from_what_is_there_twice() {
    let mut mesh = cube();
    let [a, b, c] = mesh.triangles[4];
    mesh.triangles.push([b, a, c]);
    mesh.triangles.push(mesh.triangles[7]);
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs.duplicate_triangles, 2);
    for (&source, &is_both_ways) in prepared.source_triangles.iter().zip(&prepared.is_both_ways) {
        assert_eq!(is_both_ways, source == 4 || source == 12, "{source}");
    }
}

#[test]
fn the_order_of_the_input_does_not_matter() {
    let mesh = torus(24, 12);
    let expected = repaired(&mesh).mesh;
    let vertices = mesh.positions.len() as u32;
    for step in [5, 7, 11] {
        // Each vertex, triangle and corner comes at another place.
        let place = |vertex: u32| vertex * step % vertices;
        let mut shuffled = TriangleMesh::new(vec![[0.0; 3]; mesh.positions.len()], Vec::new());
        for (vertex, &position) in (0_u32..).zip(mesh.points()) {
            shuffled.positions[place(vertex) as usize] = position.to_array();
        }
        let mut triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(place)).collect();
        triangles.iter_mut().for_each(|t| t.rotate_left(step as usize % 3));
        triangles.rotate_left(100);
        triangles.reverse();
        shuffled.triangles = triangles;
        assert_eq!(repaired(&shuffled).mesh, expected);
        assert_eq!(repaired(&turn(shuffled.clone())).mesh, expected, "wound the other way");
        shuffled.triangles.extend(shuffled.triangles.clone());
        assert_eq!(repaired(&shuffled).mesh, expected, "all triangles twice");
    }
}

#[test]
fn boxes_that_share_an_edge_are_one_component_and_both_outward() {
    let mesh = join(&[cube(), turn(cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0]))]);
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs.welded_vertices, 2);
    assert_eq!(prepared.repairs.non_manifold_edges, 1);
    assert_eq!(prepared.repairs.flipped_triangles, 12);
    assert_eq!(prepared.closed, [false]);
    let size = prepared.normalization.diagonal.powi(3);
    assert!((volume(&prepared.mesh) * size - 2.0).abs() < 1e-12);
}

#[test]
fn boxes_that_share_a_corner_are_two_components() {
    let mesh = join(&[cube(), cuboid([1.0; 3], [2.0; 3])]);
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs.welded_vertices, 1);
    assert_eq!(prepared.closed, [true, true]);
}

#[test]
fn a_fin_stays_and_is_counted() {
    let mut mesh = cube();
    mesh.positions.push([-1.0, -1.0, 0.5]);
    mesh.triangles.push([0, 4, 8]);
    let prepared = repaired(&mesh);
    assert_eq!(prepared.mesh.triangles.len(), 13);
    assert_eq!(prepared.repairs.non_manifold_edges, 1);
    assert_eq!(prepared.repairs.open_edges, 2);
    assert_eq!(prepared.closed, [false]);
}

#[test]
fn a_klein_bottle_is_left_alone_and_not_closed() {
    // A torus glued along its last ring with a reflection.
    let (n, m) = (24_u32, 12_u32);
    let mut mesh = torus(n, m);
    let start = (n - 1) * m;
    for triangle in &mut mesh.triangles {
        if triangle.iter().any(|&v| v >= start) && triangle.iter().any(|&v| v < m) {
            *triangle = triangle.map(|v| if v < m { (m - v) % m } else { v });
        }
    }
    let prepared = repaired(&mesh);
    assert_eq!(prepared.repairs, Repairs::default());
    assert_eq!(prepared.closed, [false]);
}

#[test]
fn every_given_vertex_is_kept_welded_or_unused() {
    let mut mesh = soup(&torus(24, 12));
    mesh.positions[7][2] = f64::INFINITY;
    mesh.positions.push([9.0; 3]);
    let prepared = repaired(&mesh);
    let Repairs { welded_vertices, unused_vertices, .. } = prepared.repairs;
    assert_eq!(
        prepared.mesh.positions.len() + welded_vertices + unused_vertices,
        mesh.positions.len()
    );
}

#[test]
fn it_stops_when_cancelled() {
    let control = Control::new();
    control.cancel();
    let mesh = cube();
    let result = prepare(mesh.view(), MeshOrder::Place, &control);
    assert_eq!(result, Err(Error::Cancelled));
}
