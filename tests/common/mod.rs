//! Meshes and random numbers that several of the tests use.

pub type Mesh = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A prism over a polygon in the x-y plane, counter-clockwise, given with the triangles that fill
/// it.
pub fn prism(outline: &[[f64; 2]], fill: &[[u32; 3]], height: f64) -> Mesh {
    let count = outline.len() as u32;
    let at = |z: f64| outline.iter().map(move |&[x, y]| [x, y, z]);
    let positions = at(0.0).chain(at(height)).collect();
    let top = fill.iter().map(|t| t.map(|v| v + count));
    let bottom = fill.iter().map(|&[a, b, c]| [a, c, b]);
    let walls = (0..count).flat_map(|a| {
        let b = (a + 1) % count;
        [[a, b, b + count], [a, b + count, a + count]]
    });
    (positions, top.chain(bottom).chain(walls).collect())
}

/// Two legs of length 2 and width 1, of height 1.
pub fn l_prism() -> Mesh {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    prism(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 1.0)
}

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
    fine_torus(32, 16)
}

/// Of `sides` rings of `parts` vertices.
pub fn fine_torus(sides: u32, parts: u32) -> Mesh {
    let ring = (0..parts).map(|i| {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(parts);
        [1.0 + 0.3 * angle.cos(), 0.3 * angle.sin()]
    });
    lathe(&ring.collect::<Vec<_>>(), sides)
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

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    /// From -1 to 1.
    pub fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn below(&mut self, end: usize) -> usize {
        ((0.5 + 0.5 * self.signed()) * end as f64) as usize
    }

    /// In the cube from -1 to 1.
    pub fn point(&mut self) -> [f64; 3] {
        [(); 3].map(|()| self.signed())
    }
}
