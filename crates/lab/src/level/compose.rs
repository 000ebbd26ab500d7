//! A level as games have them, from a seed: a terrain in tiles, and props that stand on it.
//!
//! The terrain is a height field on a square grid of 1 m: value noise in four octaves, a few flat
//! places to build on, and a road, which follows the hills along its middle and is level across.
//! Props are placed as levels have them: most in groups, as of a camp, where some are within
//! others; the rest alone. Everything is rounded to `f32`, as a file holds it, so that the level
//! that is measured and the one that is written are the same.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::{DQuat, DVec3};
use hullwright::TriangleMesh;
use hullwright_formats::{NamedMesh, read_mesh};

use crate::shapes::bounds;
use crate::terminal::Failure;
use crate::tools::meshes;
use crate::tools::random::Random;

/// Meshes of more triangles are left out, so that thousands of instances fit into memory.
const MOST_TRIANGLES: usize = 20_000;

/// Tiles along each side of the terrain.
pub const TILES: usize = 16;

/// Wavelength and height of each octave, in metres: hills, slopes, mounds, and what a brush leaves.
const OCTAVES: [(f64, f64); 4] = [(180.0, 9.0), (70.0, 2.5), (28.0, 0.6), (9.0, 0.06)];

/// How many places are flat, their radii as fractions of the terrain's side, and the metres over
/// which they, and the road, give way to hills.
const PLATEAUS: (usize, [f64; 2], f64) = (8, [0.02, 0.05], 10.0);

/// The road's width in metres, and how far it swings and how often, of the terrain's side.
const ROAD: (f64, f64, f64) = (6.0, 0.1, 2.5);

/// Diagonals of props in metres, evenly drawn by their logarithm: small ones are more frequent.
const DIAGONALS: [f64; 2] = [0.3, 4.0];

/// How deep a prop's lowest point is in the ground, in metres.
const SUNK: [f64; 2] = [0.01, 0.05];

/// The fraction of props in groups, how many are in each, and its radius in metres.
const GROUPS: (f64, usize, f64) = (0.75, 25, 8.0);

/// The fraction of the side without props, bodies and balls along each border.
const MARGIN: f64 = 0.05;

/// What is composed.
#[derive(Clone, Copy)]
pub struct Plan {
    pub seed: u64,
    pub props: usize,
    pub terrain_triangles: usize,
}

/// An instance of a model.
pub struct Prop {
    pub model: usize,
    pub translation: [f32; 3],
    /// A quaternion.
    pub rotation: [f32; 4],
    pub scale: f32,
}

/// Heights on a square grid of 1 m from the origin on, along x and then z.
pub struct Terrain {
    quads: usize,
    heights: Vec<f32>,
}

pub struct Level {
    /// Of diagonal 1; the middle of the lowest side of the box is the origin.
    pub models: Vec<NamedMesh>,
    pub props: Vec<Prop>,
    pub terrain: Terrain,
}

impl Level {
    pub fn compose(folder: PathBuf, plan: Plan) -> Result<Self, Failure> {
        let mut models = Vec::new();
        for file in meshes::find(&[folder])? {
            let mesh = read_mesh(&file.path)?.mesh;
            if (1..=MOST_TRIANGLES).contains(&mesh.triangles.len()) {
                models.extend(normalized(mesh).map(|mesh| NamedMesh { name: file.name, mesh }));
            }
        }
        if models.is_empty() {
            return Err("no mesh is small enough for a prop".into());
        }
        let terrain = Terrain::new(plan);
        let mut random = Random::new(plan.seed ^ 1);
        let in_groups = (GROUPS.0 * plan.props as f64) as usize;
        let mut middle = [0.0; 2];
        let mut props = Vec::with_capacity(plan.props);
        for index in 0..plan.props {
            if index % GROUPS.1 == 0 || index >= in_groups {
                middle = terrain.anywhere(&mut random);
            }
            let spread = if index < in_groups { GROUPS.2 } else { 0.0 };
            let [x, z] = near(middle, spread, &mut random).map(|x| terrain.within(x));
            let sunk = between(SUNK, &mut random);
            let half = std::f64::consts::PI * random.unit();
            let diagonal = between(DIAGONALS.map(f64::ln), &mut random).exp();
            props.push(Prop {
                model: random.integer(0, models.len()),
                translation: [x, terrain.height(x, z) - sunk, z].map(|x| x as f32),
                rotation: [0.0, half.sin(), 0.0, half.cos()].map(|x| x as f32),
                scale: diagonal as f32,
            });
        }
        Ok(Self { models, props, terrain })
    }

    /// A prop where it stands.
    pub fn placed(&self, prop: &Prop) -> TriangleMesh {
        let Some(NamedMesh { mesh, .. }) = self.models.get(prop.model) else {
            return TriangleMesh::default();
        };
        let rotation = DQuat::from_array(prop.rotation.map(f64::from)).normalize();
        let translation = DVec3::from(prop.translation.map(f64::from));
        let place = |point: &[f64; 3]| {
            let turned = rotation * (DVec3::from(*point) * f64::from(prop.scale));
            (turned + translation).to_array()
        };
        TriangleMesh::new(mesh.positions.iter().map(place).collect(), mesh.triangles.clone())
    }

    /// Props by the cell of a square grid that holds the middle of their box; those larger than a
    /// cell are alone.
    pub fn gathered(&self, props: &[TriangleMesh], cell: f64) -> Vec<Vec<usize>> {
        let mut cells: BTreeMap<(bool, [i64; 2]), Vec<usize>> = BTreeMap::new();
        for (index, mesh) in props.iter().enumerate() {
            let (low, high) = bounds(&mesh.positions);
            let is_large = high.x - low.x > cell || high.z - low.z > cell;
            let middle = (low + high) / 2.0;
            let own = match is_large {
                true => [index as i64, 0],
                false => [middle.x, middle.z].map(|x| (x / cell).floor() as i64),
            };
            cells.entry((is_large, own)).or_default().push(index);
        }
        cells.into_values().collect()
    }
}

impl Terrain {
    pub fn new(plan: Plan) -> Self {
        let quads = ((plan.terrain_triangles as f64 / 2.0).sqrt().round() as usize).max(TILES);
        let mut ground = Ground { seed: plan.seed, side: quads as f64, plateaus: Vec::new() };
        let mut random = Random::new(plan.seed);
        for _ in 0..PLATEAUS.0 {
            let [x, z] = [0; 2].map(|_| ground.side * random.unit());
            let radius = ground.side * between(PLATEAUS.1, &mut random);
            ground.plateaus.push(([x, z], radius, ground.hills(x, z, OCTAVES.len())));
        }
        let at = |index: usize| ((index % (quads + 1)) as f64, (index / (quads + 1)) as f64);
        let all = (0..(quads + 1) * (quads + 1)).map(at);
        Self { quads, heights: all.map(|(x, z)| ground.height(x, z) as f32).collect() }
    }

    pub fn side(&self) -> f64 {
        self.quads as f64
    }

    /// A place off the border.
    pub fn anywhere(&self, random: &mut Random) -> [f64; 2] {
        [0; 2].map(|_| self.within(self.side() * random.unit()))
    }

    /// A coordinate moved off the border.
    pub fn within(&self, x: f64) -> f64 {
        x.clamp(MARGIN * self.side(), (1.0 - MARGIN) * self.side())
    }

    fn at(&self, column: usize, row: usize) -> f64 {
        let index = row.min(self.quads) * (self.quads + 1) + column.min(self.quads);
        self.heights.get(index).copied().unwrap_or_default().into()
    }

    /// The height of the triangles there.
    pub fn height(&self, x: f64, z: f64) -> f64 {
        let (column, row) = (x.max(0.0) as usize, z.max(0.0) as usize);
        let (s, t) = (x - column as f64, z - row as f64);
        let [a, b] = [self.at(column, row), self.at(column + 1, row + 1)];
        // Each square is cut from its least corner to its greatest.
        let (beside, first, second) = match s > t {
            true => (self.at(column + 1, row), s, t),
            false => (self.at(column, row + 1), t, s),
        };
        a + first * (beside - a) + second * (b - beside)
    }

    /// The squares of some columns and rows, as triangles that face up.
    fn part(&self, columns: [usize; 2], rows: [usize; 2]) -> TriangleMesh {
        let width = columns[1] - columns[0];
        let mut mesh = TriangleMesh::default();
        for (row, column) in
            (rows[0]..=rows[1]).flat_map(|row| (columns[0]..=columns[1]).map(move |x| (row, x)))
        {
            let corner = mesh.positions.len() as u32;
            mesh.positions.push([column as f64, self.at(column, row), row as f64]);
            if row < rows[1] && column < columns[1] {
                let below = corner + width as u32 + 1;
                mesh.triangles.push([corner, below, below + 1]);
                mesh.triangles.push([corner, below + 1, corner + 1]);
            }
        }
        mesh
    }

    /// Tiles along x and then z. Neighbours have the vertices of their common border.
    pub fn tiles(&self) -> Vec<TriangleMesh> {
        let range = |tile: usize| [tile, tile + 1].map(|end| end * self.quads / TILES);
        let tile = |index: usize| self.part(range(index % TILES), range(index / TILES));
        (0..TILES * TILES).map(tile).collect()
    }

    pub fn whole(&self) -> TriangleMesh {
        self.part([0, self.quads], [0, self.quads])
    }
}

/// Heights of the terrain as a function.
struct Ground {
    seed: u64,
    side: f64,
    /// Middle, radius and height.
    plateaus: Vec<([f64; 2], f64, f64)>,
}

impl Ground {
    /// The first octaves.
    fn hills(&self, x: f64, z: f64, octaves: usize) -> f64 {
        let octaves = (1..).zip(OCTAVES).take(octaves);
        octaves
            .map(|(octave, (length, height))| height * self.noise(octave, x / length, z / length))
            .sum()
    }

    fn height(&self, x: f64, z: f64) -> f64 {
        let mut height = self.hills(x, z, OCTAVES.len());
        for ([px, pz], radius, level) in &self.plateaus {
            let beyond = (x - px).hypot(z - pz) - radius;
            height += smooth(1.0 - beyond / PLATEAUS.2) * (level - height);
        }
        let (width, swing, turns) = ROAD;
        let middle =
            self.side * (0.5 + swing * (turns * std::f64::consts::TAU * x / self.side).sin());
        let beyond = (z - middle).abs() - width / 2.0;
        height + smooth(1.0 - beyond / PLATEAUS.2) * (self.hills(x, middle, 2) - height)
    }

    /// Value noise: smooth between numbers from -1 to 1 at whole coordinates.
    fn noise(&self, octave: u64, x: f64, z: f64) -> f64 {
        let (column, row) = (x.floor(), z.floor());
        let at = |dx: f64, dz: f64| {
            let [i, j] = [column + dx, row + dz].map(|x| x as i64 as u64);
            let seeds = [octave, i, j].into_iter().fold(self.seed, |seed, next| {
                seed.wrapping_mul(0x0000_0100_0000_01b3).wrapping_add(next)
            });
            2.0 * Random::new(seeds).unit() - 1.0
        };
        let (s, t) = (smooth(x - column), smooth(z - row));
        let mix = |a: f64, b: f64, s: f64| a + s * (b - a);
        mix(mix(at(0.0, 0.0), at(1.0, 0.0), s), mix(at(0.0, 1.0), at(1.0, 1.0), s), t)
    }
}

/// From 0 to 1 with a continuous curvature.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (x * (6.0 * x - 15.0) + 10.0)
}

pub fn between([low, high]: [f64; 2], random: &mut Random) -> f64 {
    low + (high - low) * random.unit()
}

/// A place in the square around another.
pub fn near(middle: [f64; 2], spread: f64, random: &mut Random) -> [f64; 2] {
    middle.map(|x| x + between([-spread, spread], random))
}

/// Nothing where a mesh has no extent.
fn normalized(mut mesh: TriangleMesh) -> Option<TriangleMesh> {
    let (low, high) = bounds(&mesh.positions);
    let base = DVec3::new((low.x + high.x) / 2.0, low.y, (low.z + high.z) / 2.0);
    let diagonal = (high - low).length();
    for point in &mut mesh.positions {
        let moved = (DVec3::from(*point) - base) / diagonal;
        *point = moved.to_array().map(|x| f64::from(x as f32));
    }
    (diagonal.is_finite() && diagonal > 0.0).then_some(mesh)
}
