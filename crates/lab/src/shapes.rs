//! Meshes of known shape, for pictures and tests.

use std::f64::consts::{PI, TAU};

use hullwright::TriangleMesh;

pub type Vector = glam::DVec3;

/// An axis-aligned box, outward. Vertex number is x + 2 y + 4 z; the last two triangles are the
/// lid at the greatest z.
pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> TriangleMesh {
    let pick = |bit: usize, axis: usize| if bit == 0 { low[axis] } else { high[axis] };
    let positions = (0..8).map(|v| [pick(v & 1, 0), pick(v & 2, 1), pick(v & 4, 2)]).collect();
    // From the corner with the least coordinates of each side around it.
    let sides =
        [[0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new(positions, triangles)
}

/// A sphere of `2 n (n - 1)` triangles around the origin, outward.
pub fn uv_sphere(n: u32, radius: f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let mut point = |theta: f64, phi: f64| {
        let direction = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        mesh.positions.push(direction.map(|x| x * radius));
    };
    let step = PI / f64::from(n);
    point(0.0, 0.0);
    for (i, j) in (1..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        point(f64::from(i) * step, f64::from(j) * 2.0 * step);
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

/// A torus around the z axis of radii 1 and 0.3, of `2 n m` triangles, outward.
pub fn torus(n: u32, m: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let (a, b) = (f64::from(i) * TAU / f64::from(n), f64::from(j) * TAU / f64::from(m));
        let r = 1.0 + 0.3 * b.cos();
        mesh.positions.push([r * a.cos(), r * a.sin(), 0.3 * b.sin()]);
        mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    mesh
}

/// A mesh of `n` times `n` triangles for each, in the same planes.
pub fn subdivided(mesh: &TriangleMesh, n: u32) -> TriangleMesh {
    let mut fine = TriangleMesh::default();
    for triangle in &mesh.triangles {
        let first = fine.positions.len() as u32;
        let [a, b, c] = triangle.map(|vertex| Vector::from(mesh.positions[vertex as usize]));
        // Row i from a has i + 1 points, from the side toward b to that toward c.
        let at = |i: u32, j: u32| first + i * (i + 1) / 2 + j;
        for (i, j) in (0..=n).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let sum = a * f64::from(n - i) + b * f64::from(i - j) + c * f64::from(j);
            fine.positions.push((sum / f64::from(n)).to_array());
            if i < n {
                fine.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            }
            if j < i && i < n {
                fine.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    fine
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
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh
}

/// Several meshes as one.
pub fn join(parts: &[TriangleMesh]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for part in parts {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&part.positions);
        mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    mesh
}

/// Negative where triangles face inward.
pub fn volume(mesh: &TriangleMesh) -> f64 {
    let at = |vertex: u32| Vector::from(mesh.positions[vertex as usize]);
    let corners = mesh.triangles.iter().map(|triangle| triangle.map(at));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Least and greatest corner of what is finite.
pub fn bounds(points: &[[f64; 3]]) -> (Vector, Vector) {
    let nothing = (Vector::INFINITY, Vector::NEG_INFINITY);
    let points = points.iter().map(|&point| Vector::from(point)).filter(|point| point.is_finite());
    points.fold(nothing, |(low, high), point| (low.min(point), high.max(point)))
}

/// Of the bounding box.
pub fn middle(points: &[[f64; 3]]) -> Vector {
    let (low, high) = bounds(points);
    low.midpoint(high)
}
