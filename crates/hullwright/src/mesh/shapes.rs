//! Small meshes of known shape, for tests.

use std::f64::consts::{PI, TAU};

use crate::geometry::TriangleMesh;
use crate::geometry::vector::{Vector, as_vectors};

/// An axis-aligned box, outward. Vertex number is x + 2 y + 4 z; the last two triangles are the
/// lid at the greatest z.
pub fn cuboid(low: impl Into<Vector>, high: impl Into<Vector>) -> TriangleMesh {
    let (low, high) = (low.into(), high.into());
    let pick = |bit: usize, axis: usize| if bit == 0 { low[axis] } else { high[axis] };
    let sides =
        [[0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5], [4, 5, 7, 6]];
    TriangleMesh::new(
        (0..8).map(|v| [pick(v & 1, 0), pick(v & 2, 1), pick(v & 4, 2)]).collect(),
        sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    )
}

/// A sphere of `2 n (n - 1)` triangles, outward.
pub fn uv_sphere(n: u32, centre: impl Into<Vector>, radius: f64) -> TriangleMesh {
    let centre = centre.into();
    let mut mesh = TriangleMesh::default();
    let mut point = |theta: f64, phi: f64| {
        let direction = Vector::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        mesh.positions.push((centre + direction * radius).to_array());
    };
    let step = PI / f64::from(n);
    point(0.0, 0.0);
    for i in 1..n {
        for j in 0..n {
            point(f64::from(i) * step, f64::from(j) * 2.0 * step);
        }
    }
    point(PI, 0.0);
    let last = mesh.positions.len() as u32 - 1;
    let at = |i: u32, j: u32| 1 + (i - 1) * n + j % n;
    for j in 0..n {
        mesh.triangles.push([0, at(1, j), at(1, j + 1)]);
        for i in 1..n - 1 {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        mesh.triangles.push([last, at(n - 1, j + 1), at(n - 1, j)]);
    }
    mesh
}

/// The upper half of a sphere of radius 1, outward; `n` is even.
pub fn hemisphere(n: u32) -> TriangleMesh {
    let mut mesh = uv_sphere(n, [0.0; 3], 1.0);
    let positions = as_vectors(&mesh.positions);
    mesh.triangles.retain(|triangle| triangle.iter().all(|&v| positions[v as usize][2] > -1e-9));
    mesh
}

/// A torus around the z axis of radii 1 and 0.3, of `2 n m` triangles, outward.
pub fn torus(n: u32, m: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    for i in 0..n {
        for j in 0..m {
            let (a, b) = (f64::from(i) * TAU / f64::from(n), f64::from(j) * TAU / f64::from(m));
            let r = 1.0 + 0.3 * b.cos();
            mesh.positions.push([r * a.cos(), r * a.sin(), 0.3 * b.sin()]);
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}

/// A strip of `n` squares with half a turn, as winding that agrees wherever it can.
pub fn mobius_strip(n: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for i in 0..n {
        let a = f64::from(i) * TAU / f64::from(n);
        for side in [-0.3, 0.3] {
            let r = 1.0 + side * (a / 2.0).cos();
            mesh.positions.push([r * a.cos(), r * a.sin(), side * (a / 2.0).sin()]);
        }
        let (mut c, mut d) = (2 * ((i + 1) % n), 2 * ((i + 1) % n) + 1);
        if i + 1 == n {
            std::mem::swap(&mut c, &mut d);
        }
        mesh.triangles.extend([[2 * i, c, 2 * i + 1], [2 * i + 1, c, d]]);
    }
    mesh
}

/// The same mesh, inside out.
pub fn turn(mut mesh: TriangleMesh) -> TriangleMesh {
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    mesh
}

/// Several meshes as one.
pub fn join(parts: &[TriangleMesh]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for part in parts {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&part.positions);
        let moved = part.triangles.iter().map(|t| t.map(|v| v + first));
        mesh.triangles.extend(moved);
    }
    mesh
}
