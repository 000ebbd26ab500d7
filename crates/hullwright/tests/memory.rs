//! How much memory a decomposition takes: what `docs/reliability.md` says of it. Only Linux tells
//! the peak of a process, so these tests have a process of their own.
#![cfg(target_os = "linux")]

#[allow(dead_code)]
mod common;

use std::sync::Mutex;

use hullwright::{Control, Decomposition, Parameters, decompose};

use common::{Mesh, Random, view};

/// The most resident memory that this process has had, in bytes.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches("kB").trim().parse::<u64>().unwrap() << 10
}

/// What a decomposition takes on top of its input, in bytes.
fn memory(mesh: &Mesh) -> (u64, Decomposition) {
    static ALONE: Mutex<()> = Mutex::new(());
    let _alone = ALONE.lock().unwrap();
    // The peak starts anew from the memory that is taken now.
    std::fs::write("/proc/self/clear_refs", "5").unwrap();
    let before = peak();
    let result = decompose(view(mesh), &Parameters::default(), &Control::new()).unwrap();
    (peak() - before, result)
}

/// A closed sphere with bumps, of `2 n (n - 1)` triangles.
fn bumpy_sphere(n: u32) -> Mesh {
    let (mut points, mut triangles) = (vec![[0.0, 0.0, 1.0]], Vec::new());
    let angle = std::f64::consts::PI / f64::from(n);
    for ring in 1..n {
        for step in 0..n {
            let (polar, around) = (angle * f64::from(ring), 2.0 * angle * f64::from(step));
            let radius = 1.0 + 0.1 * (5.0 * polar).sin() * (5.0 * around).sin();
            let (sine, cosine) = polar.sin_cos();
            points.push([
                radius * sine * around.cos(),
                radius * sine * around.sin(),
                radius * cosine,
            ]);
        }
    }
    points.push([0.0, 0.0, -1.0]);
    let vertex = |ring: u32, step: u32| match ring {
        0 => 0,
        ring if ring == n => 1 + (n - 1) * n,
        ring => 1 + (ring - 1) * n + step % n,
    };
    for ring in 0..n {
        for step in 0..n {
            let [a, b] = [vertex(ring, step), vertex(ring, step + 1)];
            let [c, d] = [vertex(ring + 1, step), vertex(ring + 1, step + 1)];
            triangles.extend((ring > 0).then_some([a, d, b]));
            triangles.extend((ring + 1 < n).then_some([a, c, d]));
        }
    }
    (points, triangles)
}

/// The faces of a lattice of tetrahedra whose vertices have moved by about an edge: all of them
/// cross others.
fn tangle(n: u32, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let side = n + 1;
    let mut points = Vec::new();
    for index in 0..side.pow(3) {
        let cell = [index % side, index / side % side, index / side.pow(2)];
        points.push(cell.map(|cell| f64::from(cell) + random.signed()));
    }
    let vertex = |[x, y, z]: [u32; 3]| x + side * (y + side * z);
    let mut triangles = Vec::new();
    for index in 0..n.pow(3) {
        let cell = [index % n, index / n % n, index / n.pow(2)];
        let corner = |bits: u32| vertex([0, 1, 2].map(|k| cell[k] + (bits >> k & 1)));
        for [a, b] in [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]] {
            triangles.push([corner(0), corner(a), corner(b)]);
            triangles.push([corner(0), corner(a), corner(7)]);
        }
    }
    (points, triangles)
}

/// Bytes per triangle that `docs/reliability.md` says a dense closed mesh takes at most.
const BYTES_PER_TRIANGLE: u64 = 350;

#[test]
fn a_dense_mesh_takes_350_bytes_per_triangle_at_most_also_one_of_ten_million() {
    // The larger one first: memory that a run gives back is not always taken from the process.
    for n in [2237, 708] {
        let mesh = bumpy_sphere(n);
        let count = mesh.1.len() as u64;
        let (bytes, result) = memory(&mesh);
        assert!(result.hulls.len() > 1);
        let per_triangle = bytes / count;
        assert!(per_triangle <= BYTES_PER_TRIANGLE, "{count} triangles: {per_triangle} bytes each");
    }
}

#[test]
fn a_tangle_of_50_000_triangles_takes_500_megabytes_at_most() {
    let mesh = tangle(16, 7);
    assert!(mesh.1.len() > 49_000);
    let (bytes, result) = memory(&mesh);
    assert!(!result.hulls.is_empty());
    assert!(bytes <= 500 << 20, "{} MB", bytes >> 20);
}
