//! `cargo lab level`: a level of props on a terrain, and what it costs as it was modelled and within
//! a bound, with a collider for each mesh and for each cell.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cpu_time::ThreadTime;
use glam::{DAffine3, DQuat, DVec3};
use hullwright::{Control, Length, TriangleMesh, simplify_surface};
use hullwright_formats::conventions::level_cell;
use hullwright_formats::read_mesh;
use hullwright_rapier::triangle_mesh;
use rapier3d::parry::query::PointQuery;
use rapier3d::parry::shape::{SharedShape, TriMesh, TriMeshFlags};
use rapier3d::prelude::*;

use crate::report::{Table, number, write};
use crate::statistics::median;
use crate::terminal::{Failure, print};

/// What never moves: a level that is composed with a seed, as it was modelled and within a bound
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder with the props
    props: PathBuf,

    /// The report, a Markdown file
    #[arg(short, long)]
    output: PathBuf,

    /// Another level
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// How many props stand on the terrain
    #[arg(long, default_value_t = 2000)]
    count: usize,

    /// Triangles of the terrain, about
    #[arg(long, default_value_t = 500_000)]
    terrain: usize,

    /// The bound, in metres
    #[arg(long, default_value_t = 0.02)]
    max_error: f64,

    /// The side of a cell, in metres
    #[arg(long, default_value_t = 10.0)]
    cell_size: f32,
}

/// Side of the terrain, in metres.
const SIDE: f64 = 500.0;

/// The terrain is cut into so many tiles along each side, as levels are.
const TILES: usize = 16;

/// Larger meshes are no props of which a level has thousands.
const MOST_TRIANGLES: usize = 20_000;

/// Diagonals of props, in metres.
const DIAGONALS: [f64; 2] = [0.3, 4.0];

/// Props stand this deep in the ground, in metres.
const SUNK: f64 = 0.03;

/// As the Bevy plugin makes triangle meshes.
const FLAGS: TriMeshFlags = TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED;

/// Bodies that lie on the terrain, and the steps until they do.
const BODIES: usize = 300;
const SETTLING: usize = 120;
const STEPS: usize = 200;

/// Balls that are lowered, and their radius in metres.
const BALLS: usize = 10_000;
const RADIUS: f32 = 0.25;

/// What single precision leaves of lengths in a level of this size, in metres.
const ROUNDING: f32 = 1e-4;

/// Numbers with a seed (Steele et al. 2014, SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// The ground: hills of several sizes, and plateaus where they would be too high.
struct Ground {
    waves: Vec<(DVec3, f64, f64)>,
}

impl Ground {
    fn new(random: &mut Random) -> Self {
        let wave = |index: i32| {
            let length = 200.0 / 1.7_f64.powi(index);
            let angle = random.between(0.0, std::f64::consts::TAU);
            let direction = DVec3::new(angle.cos(), 0.0, angle.sin()) / length;
            (direction * std::f64::consts::TAU, random.between(0.0, 6.3), 0.03 * length)
        };
        Self { waves: (0..9).map(wave).collect() }
    }

    fn height(&self, x: f64, z: f64) -> f64 {
        let at = DVec3::new(x, 0.0, z);
        let sum = |of: &[(DVec3, f64, f64)]| -> f64 {
            of.iter().map(|(k, phase, height)| height * (k.dot(at) + phase).sin()).sum()
        };
        let (large, small) = self.waves.split_at(5);
        // Plateaus have no small hills.
        let hills = sum(large);
        if hills > 4.0 { 4.0 + 0.02 * (hills - 4.0) } else { hills + sum(small) }
    }

    fn tiles(&self, triangles: usize) -> Vec<TriangleMesh> {
        let squares = ((triangles / 2) as f64).sqrt() as usize / TILES;
        let step = SIDE / (TILES * squares) as f64;
        let tile = |tile: usize| {
            let first = [tile % TILES * squares, tile / TILES * squares];
            let row = squares + 1;
            let point = |index: usize| {
                let [x, z] = [first[0] + index % row, first[1] + index / row];
                let [x, z] = [x, z].map(|count| count as f64 * step - SIDE / 2.0);
                [x, self.height(x, z), z]
            };
            let corners = (0..squares * squares).map(|i| (i / squares * row + i % squares) as u32);
            let row = row as u32;
            let triangles =
                corners.flat_map(|a| [[a, a + row, a + 1], [a + 1, a + row, a + row + 1]]);
            let triangles = triangles.collect();
            TriangleMesh::new((0..(squares + 1).pow(2)).map(point).collect(), triangles)
        };
        (0..TILES * TILES).map(tile).collect()
    }
}

/// Files below a folder, in order.
fn files(folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let entries = std::fs::read_dir(folder)
        .map_err(|error| Failure::Work(format!("{}: {error}", folder.display())))?;
    let mut entries: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        match path.is_dir() {
            true => files(&path, found)?,
            false => found.push(path),
        }
    }
    Ok(())
}

/// Meshes with a diagonal of 1, whose foot is at the origin.
fn props(folder: &Path) -> Result<Vec<TriangleMesh>, Failure> {
    let mut paths = Vec::new();
    files(folder, &mut paths)?;
    let mut props = Vec::new();
    for path in paths {
        let Ok(file) = read_mesh(&path) else { continue };
        let mut mesh = file.mesh;
        let points = || mesh.positions.iter().map(|point| DVec3::from(*point));
        let low = points().fold(DVec3::INFINITY, DVec3::min);
        let high = points().fold(DVec3::NEG_INFINITY, DVec3::max);
        let diagonal = low.distance(high);
        let is_sound = diagonal.is_normal() && mesh.triangles.len() <= MOST_TRIANGLES;
        if !is_sound || mesh.triangles.is_empty() {
            continue;
        }
        let foot = DVec3::new((low.x + high.x) / 2.0, low.y, (low.z + high.z) / 2.0);
        for point in &mut mesh.positions {
            *point = ((DVec3::from(*point) - foot) / diagonal).into();
        }
        props.push(mesh);
    }
    match props.is_empty() {
        true => Err(Failure::Work(format!("{}: there is no mesh in it", folder.display()))),
        false => Ok(props),
    }
}

fn placed(mesh: &TriangleMesh, place: &DAffine3) -> TriangleMesh {
    let put = |point: &[f64; 3]| place.transform_point3((*point).into()).into();
    TriangleMesh::new(mesh.positions.iter().map(put).collect(), mesh.triangles.clone())
}

fn add(to: &mut TriangleMesh, mesh: &TriangleMesh) {
    let first = to.positions.len() as u32;
    to.positions.extend(&mesh.positions);
    to.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|v| first + v)));
}

fn triangles(meshes: &[TriangleMesh]) -> usize {
    meshes.iter().map(|mesh| mesh.triangles.len()).sum()
}

/// Of the cell's size those that fit in are merged; the others stay alone.
fn cells(meshes: &[TriangleMesh], size: f32) -> Vec<TriangleMesh> {
    let mut cells: BTreeMap<[i32; 3], TriangleMesh> = BTreeMap::new();
    let mut alone = Vec::new();
    for mesh in meshes {
        let points = || mesh.positions.iter().map(|point| DVec3::from(*point).as_vec3());
        let low = points().reduce(glam::Vec3::min).unwrap_or_default();
        let high = points().reduce(glam::Vec3::max).unwrap_or_default();
        match level_cell(low.to_array(), high.to_array(), size) {
            Some(cell) => add(cells.entry(cell).or_default(), mesh),
            None => alone.push(mesh.clone()),
        }
    }
    alone.extend(cells.into_values());
    alone
}

/// What all simplified meshes came to.
#[derive(Default)]
struct Simplified {
    meshes: Vec<TriangleMesh>,
    /// The triangles of the sources that something can touch.
    visible: Vec<TriangleMesh>,
    hidden: usize,
    seconds: f64,
    /// The largest distances, as fractions of the bound.
    distances: [f64; 2],
}

fn simplified(sources: &[TriangleMesh], bound: f64) -> Result<Simplified, Failure> {
    let control = Control::new().with_parallel(false);
    let mut all = Simplified::default();
    for (index, source) in sources.iter().enumerate() {
        if index % 64 == 0 {
            eprintln!("simplified {index} of {}", sources.len());
        }
        let start = ThreadTime::now();
        let made = simplify_surface(source, Length::units(bound), &control)?;
        all.seconds += start.elapsed().as_secs_f64();
        all.hidden += made.hidden.len();
        let found = [made.report.from_source, made.report.to_source];
        all.distances = [0, 1].map(|way| all.distances[way].max(found[way] / bound));
        let is_visible = |index: &usize| made.hidden.binary_search(&(*index as u32)).is_err();
        let visible = (0..source.triangles.len()).filter(is_visible);
        let visible = visible.map(|index| source.triangles[index]).collect();
        all.visible.push(TriangleMesh::new(source.positions.clone(), visible));
        all.meshes.push(made.mesh);
    }
    Ok(all)
}

/// Parry's meshes, the seconds that they take, and their bytes, about.
fn shapes(meshes: &[TriangleMesh]) -> (Vec<TriMesh>, f64, usize) {
    let start = Instant::now();
    let shapes: Vec<TriMesh> =
        meshes.iter().filter_map(|mesh| triangle_mesh(mesh, FLAGS).ok()).collect();
    let seconds = start.elapsed().as_secs_f64();
    let bytes = shapes.iter().map(|shape| {
        let (points, triangles) = (shape.vertices().len(), shape.indices().len());
        // Points and their normals; corners, normals of three sides, two topologies of half-edges;
        // two nodes of a tree for each triangle.
        points * (12 + 12 + 4) + triangles * (12 + 36 + 3 * 16 + 4 + 2 * 32)
    });
    let bytes = bytes.sum();
    (shapes, seconds, bytes)
}

/// A world with bodies above the ground.
fn world(shapes: &[TriMesh], ground: &Ground, seed: u64) -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    for shape in shapes {
        world.insert_collider(ColliderBuilder::new(SharedShape::new(shape.clone())), None);
    }
    let mut random = Random(seed);
    for index in 0..BODIES {
        let [x, z] = [(); 2].map(|()| random.between(-0.45 * SIDE, 0.45 * SIDE));
        let half = random.between(0.15, 0.5) as f32;
        let collider = match index % 3 {
            0 => ColliderBuilder::cuboid(half, half, half),
            1 => ColliderBuilder::ball(half),
            _ => ColliderBuilder::capsule_x(half, 0.6 * half),
        };
        // Above all props.
        let place = Vector::new(x as f32, ground.height(x, z) as f32 + 2.0 + half, z as f32);
        let body = RigidBodyBuilder::dynamic().translation(place).can_sleep(false);
        world.insert(body.linear_damping(0.5).angular_damping(1.0), collider.friction(0.9));
    }
    world
}

/// The median of steps in both worlds, taken in turn, in milliseconds, and the bodies that fell.
fn steps(worlds: &mut [PhysicsWorld; 2]) -> ([f64; 2], [usize; 2]) {
    let mut times = [Vec::new(), Vec::new()];
    for step in 0..SETTLING + STEPS {
        for (world, times) in worlds.iter_mut().zip(&mut times) {
            let start = ThreadTime::now();
            world.step();
            if step >= SETTLING {
                times.push(1e3 * start.elapsed().as_secs_f64());
            }
        }
    }
    let fallen = |world: &PhysicsWorld| {
        world.bodies.iter().filter(|(_, body)| body.translation().y < -60.0).count()
    };
    (times.map(median), [0, 1].map(|world| fallen(&worlds[world])))
}

/// Where balls that are lowered rest on a surface: the least and the largest of how much farther
/// than their radius another surface is, in metres. Each comes down by what is free below it.
fn rest(on: &TriMesh, from: &TriMesh, ground: &Ground, seed: u64) -> [f32; 2] {
    let mut random = Random(seed);
    let distance = |mesh: &TriMesh, point: Vector| {
        (mesh.project_local_point(point, false).point - point).length()
    };
    let mut found = [f32::INFINITY, f32::NEG_INFINITY];
    for _ in 0..BALLS {
        let [x, z] = [(); 2].map(|()| random.between(-0.49 * SIDE, 0.49 * SIDE));
        let mut centre = Vector::new(x as f32, ground.height(x, z) as f32 + 6.0, z as f32);
        for _ in 0..1000 {
            let free = distance(on, centre) - RADIUS;
            if free < ROUNDING / 10.0 {
                break;
            }
            centre.y -= free;
        }
        let beyond = distance(from, centre) - RADIUS;
        found = [found[0].min(beyond), found[1].max(beyond)];
    }
    found
}

fn whole(meshes: &[TriangleMesh]) -> Result<TriMesh, Failure> {
    let mut all = TriangleMesh::default();
    meshes.iter().for_each(|mesh| add(&mut all, mesh));
    let built = triangle_mesh(&all, TriMeshFlags::empty());
    built.map_err(|error| Failure::Work(error.to_string()))
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { props: folder, output, seed, count, terrain, max_error, cell_size } = arguments;
    let mut random = Random(*seed);
    let ground = Ground::new(&mut random);
    let tiles = ground.tiles(*terrain);
    let models = props(folder)?;
    let things: Vec<TriangleMesh> = (0..*count)
        .map(|_| {
            let model = &models[(random.next() * models.len() as f64) as usize % models.len()];
            let [x, z] = [(); 2].map(|()| random.between(-0.48 * SIDE, 0.48 * SIDE));
            let scale = random.between(DIAGONALS[0], DIAGONALS[1]);
            let turn = DQuat::from_rotation_y(random.between(0.0, std::f64::consts::TAU));
            let at = DVec3::new(x, ground.height(x, z) - SUNK, z);
            placed(model, &DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, at))
        })
        .collect();
    eprintln!("{} props, {} triangles", models.len(), triangles(&tiles) + triangles(&things));

    let of_tiles = simplified(&tiles, *max_error)?;
    let of_cells = simplified(&cells(&things, *cell_size), *max_error)?;
    let before: Vec<TriangleMesh> = [&tiles[..], &things[..]].concat();
    let after = [&of_tiles.meshes[..], &of_cells.meshes[..]].concat();
    let (shapes_before, seconds_before, bytes_before) = shapes(&before);
    let (shapes_after, seconds_after, bytes_after) = shapes(&after);
    eprintln!("stepping");
    let mut worlds = [&shapes_before, &shapes_after].map(|shapes| world(shapes, &ground, *seed));
    let (times, fallen) = steps(&mut worlds);
    eprintln!("lowering balls");
    let visible = [of_tiles.visible, of_cells.visible].concat();
    let found = rest(&whole(&after)?, &whole(&visible)?, &ground, *seed);

    let mut table = Table::new("The level", "", &["what", "before", "after", "after / before"]);
    let mut row = |what: &str, before: f64, after: f64| {
        let ratio = number(after / before);
        table.rows.push(vec![what.into(), number(before), number(after), ratio]);
    };
    let all = (triangles(&before), triangles(&after));
    row("triangles of the terrain", triangles(&tiles) as f64, triangles(&of_tiles.meshes) as f64);
    row("triangles of props", triangles(&things) as f64, triangles(&of_cells.meshes) as f64);
    row("triangles", all.0 as f64, all.1 as f64);
    row("colliders", before.len() as f64, after.len() as f64);
    row("colliders of props", things.len() as f64, of_cells.meshes.len() as f64);
    row("bytes of shapes, about, MB", bytes_before as f64 / 1e6, bytes_after as f64 / 1e6);
    row("seconds to build shapes", seconds_before, seconds_after);
    row("a step with 300 bodies, median, ms", times[0], times[1]);
    row("bodies that fell through", fallen[0] as f64, fallen[1] as f64);
    let seconds = of_tiles.seconds + of_cells.seconds;
    let per = |seconds: f64, triangles: usize| number(seconds / triangles as f64 * 1e5);
    let farthest = [0, 1].map(|way| of_tiles.distances[way].max(of_cells.distances[way]));
    let beyond = found.map(|x| f64::from(x) / max_error);
    let is_within = found.iter().all(|x| f64::from(x.abs() - ROUNDING) <= *max_error);
    let words = format!(
        "# A level, simplified\n\n{count} props of {} models on a terrain, seed {seed}, within {max_error} m, \
         cells of {cell_size} m. `cargo lab level FOLDER -o REPORT` makes it again.\n\n\
         Hidden triangles: {}. One thread takes {} s, {} s for 100,000 triangles of the terrain, {} of props. \
         Verified distances, as fractions of the bound: {} from the source, {} to it.\n\n\
         {BALLS} balls of {RADIUS} m are lowered until they rest on the simplified level. The nearest \
         triangle of the source is farther from their centre than their radius by {} to {} of the bound; \
         {}.\n\n",
        models.len(),
        of_tiles.hidden + of_cells.hidden,
        number(seconds),
        per(of_tiles.seconds, triangles(&tiles)),
        per(of_cells.seconds, triangles(&things)),
        number(farthest[0]),
        number(farthest[1]),
        number(beyond[0]),
        number(beyond[1]),
        if is_within { "none is beyond it" } else { "SOME ARE BEYOND IT" },
    );
    let text = words + &table.to_markdown();
    write(output, &text)?;
    print(&text)
}
