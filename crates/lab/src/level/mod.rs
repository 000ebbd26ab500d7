//! `cargo lab level`: a level as games have them, and what simplifying does for what never moves.

pub mod compose;
mod glb;
mod steps;
mod touch;

use std::path::PathBuf;

use cpu_time::ThreadTime;
use glam::DVec3;
use hullwright::{Control, Length, TriangleMesh, simplify_surface};
use parry3d::math::Vector;
use parry3d::shape::{SharedShape, TriMesh, TriMeshFlags};

use crate::harness::describe;
use crate::independent::nearest::Tree;
use crate::independent::oracle::Triangle;
use crate::report::{NOTHING, Report, Table, number};
use crate::shapes::bounds;
use crate::terminal::{Failure, print};
use compose::{Level, Plan};
use steps::{Fixed, Judge, Steps};
use touch::{RADIUS, TOUCH, Touches};

/// Compose a level of a terrain and props, simplify its colliders, and report triangles, memory,
/// times, a step of Rapier, and where balls come to lie
///
/// The terrain has squares of 1 m; props are the meshes of at most 20,000 triangles, scaled to
/// diagonals of 0.3 to 4 m, in groups and alone. The same seed composes the same level.
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder with the props' meshes
    #[arg(value_name = "PROPS_DIR")]
    props_folder: PathBuf,

    /// The folder that the report goes to
    #[arg(short, long, value_name = "REPORT")]
    output: PathBuf,

    /// Of everything that is drawn
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// How many props
    #[arg(long, value_name = "N", default_value_t = 2_000)]
    props: usize,

    /// How many triangles the terrain has, about
    #[arg(long, value_name = "N", default_value_t = 500_000)]
    terrain_triangles: usize,

    /// The side of the cells whose props become one collider
    #[arg(long, value_name = "LENGTH", default_value = "10m")]
    cell: Length,

    /// The bound
    #[arg(long, value_name = "LENGTH", default_value = "0.02m")]
    max_error: Length,

    /// How many bodies lie on the level
    #[arg(long, value_name = "N", default_value_t = 300)]
    bodies: usize,

    /// How many balls are lowered onto the level
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    balls: usize,

    /// Also write the level as a glTF file, with a node for each prop and each tile
    #[arg(long, value_name = "LEVEL.glb")]
    write: Option<PathBuf>,
}

/// The flags of the plugin.
const FLAGS: TriMeshFlags = TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let &Arguments { seed, props, terrain_triangles, bodies, balls, .. } = arguments;
    print("composing the level")?;
    let plan = Plan { seed, props, terrain_triangles };
    let level = Level::compose(arguments.props_folder.clone(), plan)?;
    if let Some(path) = &arguments.write {
        hullwright_formats::write_file(path, &glb::bytes(&level)?)?;
    }
    let placed: Vec<TriangleMesh> = level.props.iter().map(|prop| level.placed(prop)).collect();
    let tiles = level.terrain.tiles();
    let whole = level.terrain.whole();
    let diagonal = {
        let (low, high) = bounds(&whole.positions);
        (high - low).length()
    };
    let bound = arguments.max_error.of_diagonal(diagonal);
    let cells = level.gathered(&placed, arguments.cell.of_diagonal(diagonal));
    let joined: Vec<TriangleMesh> =
        cells.iter().map(|cell| joined(cell.iter().filter_map(|&prop| placed.get(prop)))).collect();

    let of_props = Simplified::new("props", &joined, bound)?;
    let of_terrain = Simplified::new("terrain", &tiles, bound)?;
    let of_whole = Simplified::new("the terrain as one mesh", &[whole], bound)?;

    print("building shapes")?;
    let before = [Shapes::new(&placed)?, Shapes::new(&tiles)?];
    let after = [Shapes::new(&of_props.meshes)?, Shapes::new(&of_terrain.meshes)?];
    let whole_after = Shapes::new(&of_whole.meshes)?;

    let source = tree(of_props.visible.iter().chain(&of_terrain.visible));
    let surface = tree(of_props.meshes.iter().chain(&of_terrain.meshes));
    let stands: Vec<[f32; 3]> = level.props.iter().map(|prop| prop.translation).collect();
    let starts = |count, seed| touch::places(&level.terrain, &stands, count, seed);

    print(&format!("stepping {bodies} bodies"))?;
    let all = steps::bodies(&source, &starts(bodies, seed ^ 2), seed ^ 3);
    let step = |name, source, [before, after]: [&[Shapes]; 2]| {
        let fixed = |shapes: &[Shapes]| shapes.iter().flat_map(|s| s.fixed.clone()).collect();
        let judge = Judge { source, terrain: &level.terrain, bound };
        (name, steps::run([fixed(before), fixed(after)], &all, &judge))
    };
    let ground = tree(of_terrain.visible.iter());
    let worlds = [
        step("all", &source, [&before, &after]),
        step("the terrain", &ground, [&before[1..], &after[1..]]),
        step("the terrain, simplified as one mesh", &ground, [&before[1..], &[whole_after]]),
    ];

    print(&format!("lowering and rolling {balls} balls"))?;
    let touches = touch::compare(&surface, &source, &starts(balls, seed ^ 4), bound);

    let words = vec![format!(
        "A level of {} props of {} models and a terrain of {:.0} m × {:.0} m, with seed {seed}; \
         the bound is {} m. Props become {} colliders by cells of {} m, and the terrain stays \
         {} tiles.",
        level.props.len(),
        level.models.len(),
        level.terrain.side(),
        level.terrain.side(),
        number(bound),
        cells.len(),
        number(arguments.cell.of_diagonal(diagonal)),
        tiles.len(),
    )];
    let simplified = [&of_props, &of_terrain, &of_whole];
    let tables = vec![
        sizes_table(simplified, [&before, &after]),
        times_table(simplified),
        steps_table(&worlds),
        balls_table(&touches),
    ];
    let report = Report { title: "Level", name: "level", words, tables, ..Report::default() };
    crate::report::create_folder(&arguments.output)?;
    Ok(Report { machine: describe(), ..report }.write(&arguments.output)?)
}

/// Of props, the terrain, and the terrain as one mesh; shapes of the first two, before and after.
fn sizes_table([props, terrain, whole]: [&Simplified; 3], shapes: [&[Shapes; 2]; 2]) -> Table {
    let note = "Before: a collider for each node. Bytes are those of positions, indices, tree and \
        normals, as Parry counts them.";
    let mut table = Table::new("Sizes", note, &["what", "before", "after", "ratio"]);
    let both = [0, 1].map(|i| props.triangles[i] + terrain.triangles[i]);
    let sum = |size: fn(&Shapes) -> usize| shapes.map(|both| both.iter().map(size).sum());
    let seconds = shapes.map(|both| both.iter().map(|shapes| shapes.seconds).sum());
    table.rows = vec![
        row("triangles of props", props.triangles),
        row("triangles of terrain", terrain.triangles),
        row("triangles", both),
        row("triangles of the terrain as one mesh", whole.triangles),
        row("colliders", sum(|shapes| shapes.fixed.len())),
        row("bytes of Parry's meshes, props", shapes.map(|[props, _]| props.bytes)),
        row("bytes of Parry's meshes, terrain", shapes.map(|[_, terrain]| terrain.bytes)),
        row("bytes of Parry's meshes", sum(|shapes| shapes.bytes)),
        row("bytes of positions and indices", sum(|shapes| shapes.plain_bytes)),
        ratio_row("seconds to build Parry's meshes", seconds),
    ];
    table
}

fn times_table(simplified: [&Simplified; 3]) -> Table {
    let header = ["what", "triangles", "hidden", "seconds", "seconds per 100,000 triangles"];
    let mut table = Table::new("Simplifying", "Processor time of one thread.", &header);
    for &Simplified { name, triangles: [before, _], hidden, seconds, .. } in simplified {
        let rate = number(1e5 * seconds / before.max(1) as f64);
        let cells = [before.to_string(), hidden.to_string(), number(seconds), rate];
        table.rows.push([vec![name.to_owned()], cells.into()].concat());
    }
    table
}

fn steps_table(worlds: &[(&str, [Steps; 2])]) -> Table {
    let note = "Bodies that never sleep; milliseconds of processor time. Both worlds take turns. \
        Landing is the mean of the first 180 steps, resting the median of the next 300, driven of \
        300 more without keeping contacts. Depth is how much nearer the source is to a body's \
        centre than the largest ball within the body allows; too deep is by more than the bound \
        and 2 cm.";
    let header = ["on", "what", "before", "after", "ratio"];
    let mut table = Table::new("A step of Rapier", note, &header);
    for (on, both) in worlds {
        let mut add = |row: Vec<String>| table.rows.push([vec![(*on).to_owned()], row].concat());
        for (phase, name) in ["ms, landing", "ms, resting", "ms, driven"].iter().enumerate() {
            add(ratio_row(name, both.each_ref().map(|steps| steps.times[phase])));
        }
        add(row("contact manifolds", both.each_ref().map(|steps| steps.manifolds)));
        add(row("contacts", both.each_ref().map(|steps| steps.contacts)));
        let deepest = both.each_ref().map(|steps| number(steps.deepest));
        add([vec!["deepest, m".into()], deepest.into(), vec![NOTHING.into()]].concat());
        add(counts("bodies too deep", both.each_ref().map(|steps| steps.too_deep)));
        add(counts("bodies fallen through", both.each_ref().map(|steps| steps.fallen)));
    }
    table
}

fn balls_table(touches: &[Touches; 2]) -> Table {
    let note = format!(
        "Balls of {RADIUS} m touch the simplified surface with a gap of at most {TOUCH} m. The \
         distance of their centres from the source less the radius, as a fraction of the bound; \
         beyond is by more than {TOUCH} m. All is in double precision.",
    );
    let header = ["balls", "number", "held", "least", "most", "beyond the bound"];
    let mut table = Table::new("Balls", &note, &header);
    for (name, touches) in ["first touch", "rolled"].into_iter().zip(touches) {
        let Touches { count, held, beyond, least, most } = *touches;
        let held = if name == "rolled" { held.to_string() } else { NOTHING.into() };
        let (count, beyond) = (count.to_string(), beyond.to_string());
        table.rows.push(vec![name.into(), count, held, number(least), number(most), beyond]);
    }
    table
}

fn counts(name: &str, [before, after]: [usize; 2]) -> Vec<String> {
    vec![name.into(), before.to_string(), after.to_string(), NOTHING.into()]
}

fn row(name: &str, [before, after]: [usize; 2]) -> Vec<String> {
    let ratio = number(after as f64 / before.max(1) as f64);
    vec![name.into(), before.to_string(), after.to_string(), ratio]
}

fn ratio_row(name: &str, [before, after]: [f64; 2]) -> Vec<String> {
    vec![name.into(), number(before), number(after), number(after / before)]
}

fn joined<'a>(meshes: impl Iterator<Item = &'a TriangleMesh>) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for mesh in meshes {
        let first = all.positions.len() as u32;
        all.positions.extend(&mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|v| v + first)));
    }
    all
}

fn tree<'a>(meshes: impl Iterator<Item = &'a TriangleMesh>) -> Tree {
    Tree::new(meshes.flat_map(|mesh| Triangle::all(&mesh.positions, &mesh.triangles)).collect())
}

/// Meshes, each simplified alone.
struct Simplified {
    name: &'static str,
    meshes: Vec<TriangleMesh>,
    /// The sources without what is hidden.
    visible: Vec<TriangleMesh>,
    /// Before and after.
    triangles: [usize; 2],
    hidden: usize,
    seconds: f64,
}

impl Simplified {
    fn new(name: &'static str, sources: &[TriangleMesh], bound: f64) -> Result<Self, Failure> {
        let (meshes, visible) = (Vec::new(), Vec::new());
        let mut all = Self { name, meshes, visible, triangles: [0; 2], hidden: 0, seconds: 0.0 };
        let control = Control::new().with_parallel(false);
        for (index, source) in sources.iter().enumerate() {
            if index % 100 == 0 {
                print(&format!("simplifying {name}, {index} of {}", sources.len()))?;
            }
            let start = ThreadTime::now();
            let result = simplify_surface(source, Length::units(bound), &control)?;
            all.seconds += start.elapsed().as_secs_f64();
            let mut visible = source.clone();
            let mut number = 0..;
            let is_seen = |_: &[u32; 3]| {
                number.next().is_some_and(|number| result.hidden.binary_search(&number).is_err())
            };
            visible.triangles.retain(is_seen);
            all.triangles[0] += source.triangles.len();
            all.triangles[1] += result.mesh.triangles.len();
            all.hidden += result.hidden.len();
            all.meshes.push(result.mesh);
            all.visible.push(visible);
        }
        Ok(all)
    }
}

/// Parry's meshes about their middles, where `f32` is finest, and what they take.
struct Shapes {
    fixed: Vec<Fixed>,
    bytes: usize,
    plain_bytes: usize,
    seconds: f64,
}

impl Shapes {
    fn new(meshes: &[TriangleMesh]) -> Result<Self, Failure> {
        let mut all = Self { fixed: Vec::new(), bytes: 0, plain_bytes: 0, seconds: 0.0 };
        for mesh in meshes {
            let (low, high) = bounds(&mesh.positions);
            let middle = ((low + high) / 2.0).as_vec3().as_dvec3();
            let mut own = mesh.clone();
            for point in &mut own.positions {
                *point = (DVec3::from(*point) - middle).to_array();
            }
            let start = ThreadTime::now();
            let shape = hullwright_rapier::triangle_mesh(&own, FLAGS)
                .map_err(|error| Failure::Work(error.to_string()))?;
            all.seconds += start.elapsed().as_secs_f64();
            all.bytes += shape.total_memory_size();
            all.plain_bytes += plain_bytes(&shape);
            let place = Vector::from(middle.to_array().map(|x| x as f32));
            all.fixed.push((place, SharedShape::new(shape)));
        }
        Ok(all)
    }
}

fn plain_bytes(shape: &TriMesh) -> usize {
    size_of_val(shape.vertices()) + size_of_val(shape.indices())
}
