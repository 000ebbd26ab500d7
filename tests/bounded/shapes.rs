//! The meshes of these tests.

pub use crate::common::{Mesh, l_prism, prism};

pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let (mut positions, triangles) =
        prism(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], &[[0, 1, 2], [0, 2, 3]], 1.0);
    for point in &mut positions {
        *point = [0, 1, 2].map(|k| low[k] + point[k] * (high[k] - low[k]));
    }
    (positions, triangles)
}

pub fn u_prism() -> Mesh {
    let outline = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    prism(&outline, &[[0, 5, 6], [0, 6, 7], [0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]], 1.0)
}

pub fn plus_prism() -> Mesh {
    let outline = [
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [3.0, 1.0],
        [3.0, 2.0],
        [2.0, 2.0],
        [2.0, 3.0],
        [1.0, 3.0],
        [1.0, 2.0],
        [0.0, 2.0],
        [0.0, 1.0],
        [1.0, 1.0],
    ];
    let fill = [
        [0, 1, 2],
        [0, 2, 11],
        [2, 3, 4],
        [2, 4, 5],
        [5, 6, 7],
        [5, 7, 8],
        [8, 9, 10],
        [8, 10, 11],
        [11, 2, 5],
        [11, 5, 8],
    ];
    prism(&outline, &fill, 1.0)
}

/// Rotates a closed polygon in the half-plane (radius, height) about the z axis.
pub fn lathe(profile: &[[f64; 2]], sides: u32) -> Mesh {
    let count = profile.len() as u32;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for side in 0..sides {
        let angle = f64::from(side) * std::f64::consts::TAU / f64::from(sides);
        positions.extend(profile.iter().map(|&[r, z]| [r * angle.cos(), r * angle.sin(), z]));
        for k in 0..count {
            let at = |side: u32, k: u32| (side % sides) * count + k % count;
            let [a, b] = [at(side, k), at(side + 1, k)];
            let [c, d] = [at(side + 1, k + 1), at(side, k + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions, triangles)
}

pub fn torus() -> Mesh {
    let ring = (0..16).map(|i| {
        let angle = f64::from(i) * std::f64::consts::TAU / 16.0;
        [1.0 + 0.3 * angle.cos(), 0.3 * angle.sin()]
    });
    lathe(&ring.collect::<Vec<_>>(), 32)
}

/// Of a cup whose wall is 0.1 thick. A hole of radius 0.005 in its floor keeps it a lathed ring.
pub const CUP_PROFILE: [[f64; 2]; 6] =
    [[0.005, 0.0], [1.0, 0.0], [1.0, 2.0], [0.9, 2.0], [0.9, 0.15], [0.005, 0.15]];

pub fn cup() -> Mesh {
    lathe(&CUP_PROFILE, 40)
}

/// A closed profile, each of its sides divided into `parts`.
pub fn finely(profile: &[[f64; 2]], parts: u32) -> Vec<[f64; 2]> {
    let ends = profile.iter().zip(profile.iter().cycle().skip(1));
    ends.flat_map(|(from, to)| {
        (0..parts).map(move |part| {
            let share = f64::from(part) / f64::from(parts);
            [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
        })
    })
    .collect()
}

/// A ball around the origin, of radius 1.
pub fn ball(stacks: u32, sides: u32) -> Mesh {
    let arc = (0..=stacks).map(|i| {
        let angle = std::f64::consts::PI * (f64::from(i) / f64::from(stacks) - 0.5);
        [angle.cos().max(0.002), angle.sin()]
    });
    lathe(&arc.collect::<Vec<_>>(), sides)
}

/// A cylinder's surface bent along an arc: a sheet without thickness.
pub fn open_sheet() -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..=20_u32 {
        let angle = f64::from(i) * 0.15;
        positions.extend([0.0, 1.0].map(|y| [angle.cos(), y, angle.sin()]));
        if i > 0 {
            let [a, b] = [2 * i - 2, 2 * i];
            triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    (positions, triangles)
}

pub fn join(parts: &[Mesh]) -> Mesh {
    let mut all: Mesh = Default::default();
    for (positions, triangles) in parts {
        let offset = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(triangles.iter().map(|t| t.map(|v| v + offset)));
    }
    all
}

pub fn turned((positions, triangles): &Mesh) -> Mesh {
    (positions.clone(), triangles.iter().map(|&[a, b, c]| [b, a, c]).collect())
}

/// A mesh with each triangle in both orientations.
pub fn both_ways((positions, triangles): &Mesh) -> Mesh {
    let turned = triangles.iter().map(|&[a, b, c]| [b, a, c]);
    (positions.clone(), triangles.iter().copied().chain(turned).collect())
}
