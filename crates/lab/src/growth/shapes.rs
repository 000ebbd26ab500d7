//! Kinds of meshes that come in any size, the same ones each time.

use hullwright::TriangleMesh;

use crate::level::compose::{Plan, Terrain};
use crate::shapes::{Vector, bounds, cuboid, subdivided, torus, uv_sphere};
use crate::tools::soup::{scattered_boxes, tangle};
use crate::tools::variations::Variation;

const SEED: u64 = 1;

/// Height of bumps and waves as a fraction of the radius, and how many are around.
const BUMPS: (f64, f64) = (0.1, 8.0);

/// Noise as a fraction of the diagonal: a quarter of the bound.
const NOISE: f64 = 5e-3;

/// Height of the terrain as a fraction of its side: mountains, since hills are below the bound.
const RELIEF: f64 = 0.2;

/// A kind of mesh: its name, its least number of triangles, and what makes about so many of it.
pub type Kind = (&'static str, usize, fn(usize) -> TriangleMesh);

pub const KINDS: [Kind; 7] = [
    ("sphere with bumps", 1000, |triangles| {
        moved(uv_sphere(root(triangles, 2), 1.0), |point| {
            point * (1.0 + BUMPS.0 * point.to_array().map(wave).iter().product::<f64>())
        })
    }),
    ("sphere with noise", 1000, |triangles| {
        Variation::JitterWelded(NOISE).apply(&uv_sphere(root(triangles, 2), 1.0)).0
    }),
    ("torus with waves", 1000, |triangles| {
        // Squares all around, since the ring is three times as long as wide.
        let around = root(3 * triangles, 2);
        moved(torus(around, (around / 3).max(3)), |point| {
            point + Vector::Z * BUMPS.0 * wave(point.x) * wave(point.y)
        })
    }),
    ("box, finely cut", 1000, |triangles| {
        subdivided(&cuboid([0.0; 3], [1.0, 2.0, 3.0]), root(triangles, 12))
    }),
    ("terrain", 1000, |triangles| {
        // Of squares of one size: a larger one has more mountains.
        let plan = Plan { seed: SEED, props: 0, terrain_triangles: triangles };
        let mesh = Terrain::new(plan).whole();
        let (low, high) = bounds(&mesh.positions);
        let stretch = RELIEF * (high.x - low.x) / (high.y - low.y);
        moved(mesh, |point| point * Vector::new(1.0, stretch, 1.0))
    }),
    ("scattered boxes", 1000, |triangles| scattered_boxes(SEED, triangles.div_ceil(12))),
    ("tangle", 100, |triangles| tangle(SEED, triangles as u32)),
];

/// The n whose square, so many times, is closest to a number.
fn root(triangles: usize, times: usize) -> u32 {
    ((triangles as f64 / times as f64).sqrt().round() as u32).max(3)
}

fn wave(x: f64) -> f64 {
    (BUMPS.1 * x).cos()
}

fn moved(mut mesh: TriangleMesh, place: impl Fn(Vector) -> Vector) -> TriangleMesh {
    mesh.positions.iter_mut().for_each(|point| *point = place(Vector::from(*point)).to_array());
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::volume;
    use crate::tools::kinds::kinds;

    #[test]
    fn each_kind_has_about_as_many_triangles_as_it_should_and_is_the_same_again() {
        for (name, _, make) in KINDS {
            for triangles in [1000, 3000, 10_000] {
                let mesh = make(triangles);
                let share = mesh.triangles.len() as f64 / triangles as f64;
                assert!((0.9..1.1).contains(&share), "{name}: {share}");
                assert_eq!(mesh, make(triangles), "{name}");
            }
        }
    }

    #[test]
    fn what_is_solid_is_closed_and_faces_outward() {
        for (name, _, make) in &KINDS[..4] {
            let mesh = make(1000);
            assert_eq!(kinds(&mesh), [""; 0], "{name}");
            assert!(volume(&mesh) > 0.0, "{name}");
        }
    }
}
