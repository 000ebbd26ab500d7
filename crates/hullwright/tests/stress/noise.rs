//! Noise and jitter of every size: some of it always meets a tolerance.

use crate::common::{Mesh, Random, ball, cup, l_prism, u_prism};
use crate::{assert_sound, placed};

fn jittered(mesh: &Mesh, size: f64, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let moved = mesh.0.iter().map(|point| point.map(|x| x + size * random.signed())).collect();
    (moved, mesh.1.clone())
}

/// Jitter at the hull's tolerance of 2e-7, at welding's, and at the grid of 2^-38 on which ties
/// break.
#[test]
fn jitter_at_each_tolerance_keeps_the_promise() {
    for size in [4e-12, 1e-9, 6e-8, 2e-7, 4e-7, 1e-6, 1e-5, 1e-3] {
        for (name, mesh) in [("L", l_prism()), ("U", u_prism()), ("cup", cup())] {
            assert_sound(&format!("{name}, {size}"), &jittered(&mesh, size, 3));
        }
    }
}

/// Vertices that were one, apart by next to nothing: what welds and what does not changes the
/// surface.
#[test]
fn split_vertices_that_are_nearly_equal_keep_the_promise() {
    let (positions, triangles) = u_prism();
    for size in [0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-4] {
        let corners = triangles.iter().flatten().map(|&vertex| positions[vertex as usize]);
        let apart: Mesh = (
            corners.collect(),
            (0..triangles.len() as u32).map(|t| [0, 1, 2].map(|k| 3 * t + k)).collect(),
        );
        assert_sound(&format!("{size}"), &jittered(&apart, size, 5));
    }
}

/// From noise that rounding hides to noise that turns the surface inside out.
#[test]
fn spheres_with_noise_of_every_size_keep_the_promise() {
    for exponent in [-8.0, -7.0, -6.0, -5.0, -4.0, -3.0, -2.0, -1.0, -0.5] {
        let mut random = Random(11);
        let noisy = placed(&ball(14, 28), |point| {
            let factor = 1.0 + 10_f64.powf(exponent) * random.signed();
            point.map(|x| x * factor)
        });
        assert_sound(&format!("1e{exponent}"), &noisy);
    }
}

/// Triangles between points of a small grid: equal, coplanar and collinear throughout, and no
/// solid.
#[test]
fn lattice_soups_keep_the_promise() {
    let mut random = Random(13);
    for round in 0..40 {
        let points = 4 + random.below(50);
        let positions =
            (0..points).map(|_| [(); 3].map(|()| random.below(4) as f64)).collect::<Vec<_>>();
        let corner = |random: &mut Random| random.below(points) as u32;
        let triangles = (0..4 + random.below(150))
            .map(|_| [corner(&mut random), corner(&mut random), corner(&mut random)])
            .collect();
        assert_sound(&format!("round {round}"), &(positions, triangles));
    }
}

/// The same in a plane, up to next to nothing: sheets that cross, as thick as rounding.
#[test]
fn soups_that_are_flat_up_to_noise_keep_the_promise() {
    let mut random = Random(17);
    for exponent in [-12, -8, -7, -6, -4, -2, 0] {
        let positions = (0..60)
            .map(|_| [random.signed(), random.signed(), 10_f64.powi(exponent) * random.signed()])
            .collect();
        let triangles =
            (0..80).map(|_| [(); 3].map(|()| random.below(60) as u32)).collect::<Vec<_>>();
        assert_sound(&format!("1e{exponent}"), &(positions, triangles));
    }
}
