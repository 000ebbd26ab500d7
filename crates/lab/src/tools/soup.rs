//! Random hostile meshes: the same ones for the same number, everywhere.

use hullwright::TriangleMesh;

use super::random::Random;
use crate::shapes::{cuboid, join, uv_sphere};

/// The kinds, in turn.
pub const KINDS: [&str; 8] = [
    "soup",
    "lattice",
    "boxes",
    "lattice boxes",
    "noisy sphere",
    "thin boxes",
    "flat soup",
    "broken boxes",
];

/// A mesh by its number, of the kind `number % 8`.
pub fn soup(number: u64) -> TriangleMesh {
    let random = &mut Random::new(number);
    match number % 8 {
        0 => {
            let count = random.integer(4, 120) as u32;
            any_tangle(random, count)
        }
        1 => {
            let count = random.integer(4, 60);
            let points = (0..count).map(|_| lattice(random, 0, 4)).collect();
            let triangles = random.integer(4, 200);
            TriangleMesh::new(points, any_triangles(random, count, triangles))
        }
        2 => boxes(random, 30, |random| [point(random), point(random).map(|x| x / 2.0)]),
        3 => boxes(random, 25, |random| [lattice(random, 0, 6), lattice(random, 1, 3)]),
        4 => {
            let mut mesh = uv_sphere(random.integer(6, 55) as u32, 1.0);
            let size = power(random, -8.0, -0.5);
            for point in &mut mesh.positions {
                let factor = 1.0 + size * normal(random)[0];
                *point = point.map(|x| x * factor);
            }
            mesh
        }
        5 => {
            let factor = power(random, -6.0, 6.0);
            let size = |random: &mut Random| [0, 1, 2].map(|_| power(random, -7.0, 0.0));
            let mesh = boxes(random, 20, |random| [point(random), size(random)]);
            moved(mesh, |x| x * factor)
        }
        6 => {
            let count = random.integer(3, 200);
            let height = power(random, -12.0, 0.0);
            let flat = |[x, y, z]: [f64; 3]| [x, y, z * height];
            let points = (0..count).map(|_| flat(normal(random))).collect();
            TriangleMesh::new(points, any_triangles(random, count, 2 * count))
        }
        _ => {
            let mut mesh =
                boxes(random, 8, |random| [point(random), point(random).map(|x| x / 2.0)]);
            mesh.triangles.retain(|_| random.unit() > 0.15);
            for triangle in &mut mesh.triangles {
                if random.unit() < 0.2 {
                    triangle.swap(1, 2);
                }
            }
            let offset = power(random, 0.0, 5.0);
            moved(mesh, |x| x + offset)
        }
    }
}

fn point(random: &mut Random) -> [f64; 3] {
    [0, 1, 2].map(|_| random.unit())
}

/// A sum of twelve is nearly normal, and needs no logarithm, which is not the same everywhere.
fn normal(random: &mut Random) -> [f64; 3] {
    [0, 1, 2].map(|_| (0..12).map(|_| random.unit()).sum::<f64>() - 6.0)
}

fn lattice(random: &mut Random, low: usize, end: usize) -> [f64; 3] {
    [0, 1, 2].map(|_| random.integer(low, end) as f64)
}

fn power(random: &mut Random, low: f64, high: f64) -> f64 {
    10.0_f64.powf(low + (high - low) * random.unit())
}

fn any_triangles(random: &mut Random, points: usize, count: usize) -> Vec<[u32; 3]> {
    (0..count).map(|_| [0, 1, 2].map(|_| random.integer(0, points) as u32)).collect()
}

/// Two to `most` boxes, each by a corner and a size.
fn boxes(
    random: &mut Random,
    most: usize,
    part: impl Fn(&mut Random) -> [[f64; 3]; 2],
) -> TriangleMesh {
    let count = random.integer(2, most);
    some_boxes(random, count, part)
}

fn some_boxes(
    random: &mut Random,
    count: usize,
    part: impl Fn(&mut Random) -> [[f64; 3]; 2],
) -> TriangleMesh {
    let parts: Vec<TriangleMesh> = (0..count)
        .map(|_| {
            let [low, size] = part(random);
            cuboid(low, [0, 1, 2].map(|k| low[k] + size[k]))
        })
        .collect();
    join(&parts)
}

/// So many boxes in the unit cube, of up to half the room that each has: most stand alone.
pub fn scattered_boxes(seed: u64, count: usize) -> TriangleMesh {
    let size = 0.5 / (count as f64).cbrt();
    let random = &mut Random::new(seed);
    some_boxes(random, count, |random| [point(random), point(random).map(|x| x * size)])
}

/// So many triangles whose corners are drawn from one normal distribution.
pub fn tangle(seed: u64, count: u32) -> TriangleMesh {
    any_tangle(&mut Random::new(seed), count)
}

fn any_tangle(random: &mut Random, count: u32) -> TriangleMesh {
    let points = (0..3 * count).map(|_| normal(random)).collect();
    TriangleMesh::new(points, (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
}

fn moved(mut mesh: TriangleMesh, place: impl Fn(f64) -> f64) -> TriangleMesh {
    mesh.positions.as_flattened_mut().iter_mut().for_each(|x| *x = place(*x));
    mesh
}

/// As a Wavefront OBJ file, whose decimals give the same numbers again.
pub fn to_obj(mesh: &TriangleMesh) -> String {
    let vertices = mesh.positions.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = mesh.triangles.iter().map(|t| t.map(|vertex| vertex + 1));
    vertices.chain(faces.map(|[a, b, c]| format!("f {a} {b} {c}\n"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::kinds::{DEGENERATE, NON_MANIFOLD, OPEN, SELF_INTERSECTING, kinds};

    #[test]
    fn a_number_is_a_mesh_and_another_number_another_one() {
        for number in 0..16 {
            assert_eq!(soup(number), soup(number));
            assert_ne!(soup(number), soup(number + 8));
            assert!(!soup(number).triangles.is_empty());
        }
    }

    #[test]
    fn random_meshes_are_as_bad_as_their_names_say() {
        let all =
            |number: u64| -> Vec<_> { (0..4).map(|i| kinds(&soup(number + 8 * i))).collect() };
        assert!(all(0).iter().all(|kinds| kinds.contains(&OPEN)));
        let lattices = all(1).concat();
        assert!([OPEN, NON_MANIFOLD, DEGENERATE].iter().all(|kind| lattices.contains(kind)));
        assert!(all(2).concat().contains(&SELF_INTERSECTING));
        assert!(all(4).concat().is_empty() || all(4).concat().contains(&SELF_INTERSECTING));
        assert!(all(7).iter().all(|kinds| kinds.contains(&OPEN)));
    }

    #[test]
    fn an_obj_file_is_the_same_mesh() {
        let mesh = soup(5);
        let read = hullwright_formats::read_mesh_from_bytes(
            hullwright_formats::Format::Obj,
            to_obj(&mesh).as_bytes(),
        );
        let read = read.unwrap().mesh;
        assert_eq!((read.positions, read.triangles), (mesh.positions, mesh.triangles));
    }
}
