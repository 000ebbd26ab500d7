//! Meshes, decompositions and random numbers that several of the tests use.

use hullwright::{Control, Decomposition, Hull, MeshView, Parameters, decompose};

pub type Point = [f64; 3];
pub type Mesh = (Vec<Point>, Vec<[u32; 3]>);

pub fn view((positions, triangles): &Mesh) -> MeshView<'_> {
    MeshView::new(positions, triangles)
}

pub fn run_with(mesh: &Mesh, parameters: &Parameters) -> Decomposition {
    decompose(view(mesh), parameters, &Control::new()).unwrap()
}

pub fn run(mesh: &Mesh) -> Decomposition {
    run_with(mesh, &Parameters::default())
}

/// The bundled models, by name.
pub fn bundled_models() -> Vec<(String, hullwright::TriangleMesh)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut models: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|extension| extension == "glb"))
        .map(|path| {
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            (name, hullwright_formats::read_mesh(path).unwrap().mesh)
        })
        .collect();
    models.sort_by(|a, b| a.0.cmp(&b.0));
    models
}

/// Whether a point is in a hull, or nearly.
pub fn contains(hull: &Hull, point: Point) -> bool {
    hull.shape.triangles.iter().all(|triangle| {
        let [a, b, c] = triangle.map(|v| hull.shape.points[v as usize]);
        let [u, v, w] =
            [[b, a], [c, a], [point, a]].map(|[p, q]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]]);
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2] <= 1e-9
    })
}

pub fn is_filled(decomposition: &Decomposition, point: Point) -> bool {
    decomposition.hulls.iter().any(|hull| contains(hull, point))
}

/// A polygon from the coordinates of its corners, x and y in turn.
pub fn polygon(coordinates: &[f64]) -> Vec<[f64; 2]> {
    coordinates.as_chunks::<2>().0.to_vec()
}

/// Fills a simple polygon, counter-clockwise, by cutting off ears.
fn ears(outline: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let turn = |a: u32, b: u32, c: u32| {
        let [a, b, c] = [a, b, c].map(|v| outline[v as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut rest: Vec<u32> = (0..outline.len() as u32).collect();
    let mut triangles = Vec::new();
    while rest.len() > 3 {
        let count = rest.len();
        let corner = |k: usize| [rest[(k + count - 1) % count], rest[k], rest[(k + 1) % count]];
        let is_outside = |p: u32, [a, b, c]: [u32; 3]| {
            [turn(a, b, p), turn(b, c, p), turn(c, a, p)].iter().any(|&turn| turn < -1e-12)
        };
        let is_ear = |&k: &usize| {
            let [a, b, c] = corner(k);
            turn(a, b, c) > 1e-12
                && rest.iter().all(|&p| [a, b, c].contains(&p) || is_outside(p, [a, b, c]))
        };
        let k = (1..=count).map(|k| k % count).find(is_ear).expect("a simple polygon has an ear");
        triangles.push(corner(k));
        rest.remove(k);
    }
    triangles.push([rest[0], rest[1], rest[2]]);
    triangles
}

/// A prism over a simple polygon in the x-y plane, counter-clockwise.
pub fn prism(outline: &[[f64; 2]], height: f64) -> Mesh {
    let count = outline.len() as u32;
    let at = |z: f64| outline.iter().map(move |&[x, y]| [x, y, z]);
    let positions = at(0.0).chain(at(height)).collect();
    let fill = ears(outline);
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
    prism(&polygon(&[0.0, 0.0, 2.0, 0.0, 2.0, 1.0, 1.0, 1.0, 1.0, 2.0, 0.0, 2.0]), 1.0)
}

pub fn cuboid(low: Point, high: Point) -> Mesh {
    let (mut positions, triangles) =
        prism(&polygon(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]), 1.0);
    for point in &mut positions {
        *point = [0, 1, 2].map(|k| low[k] + point[k] * (high[k] - low[k]));
    }
    (positions, triangles)
}

pub fn u_prism() -> Mesh {
    let outline =
        polygon(&[0.0, 0.0, 3.0, 0.0, 3.0, 2.0, 2.0, 2.0, 2.0, 1.0, 1.0, 1.0, 1.0, 2.0, 0.0, 2.0]);
    prism(&outline, 1.0)
}

pub fn plus_prism() -> Mesh {
    let outline = polygon(&[
        1.0, 0.0, 2.0, 0.0, 2.0, 1.0, 3.0, 1.0, 3.0, 2.0, 2.0, 2.0, 2.0, 3.0, 1.0, 3.0, 1.0, 2.0,
        0.0, 2.0, 0.0, 1.0, 1.0, 1.0,
    ]);
    prism(&outline, 1.0)
}

/// A prism over a comb: a base of height 1 with teeth up to `top`, a gap as wide as a tooth between
/// them.
pub fn comb(teeth: u32, top: f64, height: f64) -> Mesh {
    let mut outline = vec![[0.0, 0.0], [f64::from(2 * teeth - 1), 0.0]];
    for tooth in (0..teeth).rev() {
        let x = f64::from(2 * tooth);
        outline.extend([[x + 1.0, top], [x, top]]);
        if tooth > 0 {
            outline.extend([[x, 1.0], [x - 1.0, 1.0]]);
        }
    }
    prism(&outline, height)
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
    ring(1.0, 0.3, 32, 16)
}

/// A torus of two radii, of `sides` rings of `parts` vertices.
pub fn ring(large: f64, small: f64, sides: u32, parts: u32) -> Mesh {
    let ring = (0..parts).map(|i| {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(parts);
        [large + small * angle.cos(), small * angle.sin()]
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
pub fn both_ways(mesh: &Mesh) -> Mesh {
    (mesh.0.clone(), [mesh.1.clone(), turned(mesh).1].concat())
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
    pub fn point(&mut self) -> Point {
        [(); 3].map(|()| self.signed())
    }
}
