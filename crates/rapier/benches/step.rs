//! What a step of Rapier costs with our hulls, with Parry's V-HACD and with the triangles
//! themselves: `cargo bench --package hullwright_rapier --bench step`.
//!
//! A hundred bodies, as many of each of some bundled models, fall onto each other in a box. Each
//! kind of collider runs the same scenes, with the mass properties of the source mesh: in each
//! round the bodies start turned otherwise, since one heap differs from the next by more than the
//! kinds do, and the kinds take turns. The error of a set of hulls is the larger of its protrusion
//! and its uncovered distance, as `measure` samples them; V-HACD runs at the resolutions named,
//! with its own defaults else. Ours runs at its default error, and with each model's error under
//! V-HACD to spend, as a user does for whom that is enough. The errors of "ours, primitives" are
//! those of the hulls; the primitives stay within the bound too. Errors of "ours, probe" count what
//! it fills. A second heap is of models that are made of boxes.

use std::time::Instant;

use hullwright::hulls_format::HullsFile;
use hullwright::measure::{MeasureOptions, measure};
use hullwright::{
    Control, ConvexHull, Length, Parameters, TriangleMesh, decompose, mass_properties,
};
use hullwright_formats::read_mesh;
use rapier3d::parry::transformation::vhacd::{VHACD, VHACDParameters};
use rapier3d::prelude::*;

const MODELS: [&str; 10] =
    ["mug", "table", "teapot", "lamp", "bowl", "dog", "torus", "gear", "spring", "u_prism"];

/// Models of boxes.
const BOXES: [&str; 5] = ["table", "chair", "plus", "l_prism", "u_prism"];

/// In a heap.
const BODIES: usize = 100;

/// All models are scaled to this diagonal, in metres, so that each meets each.
const SIZE: f64 = 1.0;

/// kg per m³; wood, about.
const DENSITY: f64 = 500.0;

/// Falling, landing, and coming to rest.
const STEPS: usize = 300;

/// The radius of "ours, probe": of the models' diagonal.
const PROBE: Length = Length::share(0.06);

/// The first is its default.
const VHACD_RESOLUTIONS: [u32; 2] = [64, 128];

/// Heaps; medians over them are printed.
const ROUNDS: usize = 9;

struct Model {
    name: &'static str,
    mesh: TriangleMesh,
    properties: hullwright::MassProperties,
}

/// A kind of collider: a shape of each model, how many parts they have, and their largest error.
struct Kind {
    name: String,
    shapes: Vec<SharedShape>,
    parts: usize,
    errors: Vec<f64>,
}

fn main() {
    heap(&MODELS, true);
    heap(&BOXES, false);
}

/// Steps of a heap of these models with each kind of collider.
fn heap(names: &[&'static str], with_triangles: bool) {
    let models: Vec<Model> = names.iter().map(|name| load(name)).collect();
    let peers = VHACD_RESOLUTIONS.map(|resolution| vhacd(&models, resolution));
    let default = vec![Parameters::default(); models.len()];
    let probe = vec![Parameters::default().with_probe_radius(PROBE); models.len()];
    let at_error = |&error: &f64| Parameters::default().with_max_error(Length::share(error));
    let at_errors: Vec<Parameters> = peers[0].errors.iter().map(at_error).collect();
    let mut kinds = vec![
        ours("ours", &models, &default, false),
        ours("ours, primitives", &models, &default, true),
        ours("ours, probe", &models, &probe, false),
        ours("ours, its error", &models, &at_errors, false),
    ];
    let reference = kinds.len();
    kinds.extend(peers);

    let mut rounds: Vec<Vec<[f64; 2]>> = vec![Vec::new(); kinds.len()];
    for round in 0..ROUNDS {
        for (kind, times) in kinds.iter().zip(&mut rounds) {
            times.push(simulate(kind, &models, round));
        }
    }
    if with_triangles {
        // They take ten times as long: one round.
        kinds.push(triangles(&models));
        rounds.push(vec![simulate(&kinds[kinds.len() - 1], &models, 0)]);
    }
    println!("a heap of {}", names.join(", "));
    print_table(&kinds, &rounds, reference);
}

/// Each kind beside the reference and beside the first, by the ratios within each round.
fn print_table(kinds: &[Kind], rounds: &[Vec<[f64; 2]>], reference: usize) {
    println!(
        "{:<16} {:>6} {:>12} {:>12} {:>10} {:>10}  of {} (least, most), of {}",
        "colliders",
        "parts",
        "mean error",
        "worst error",
        "ms a step",
        "slowest",
        kinds[reference].name,
        kinds[0].name
    );
    for (kind, times) in kinds.iter().zip(rounds) {
        let of = |other: usize| {
            let pairs = times.iter().zip(&rounds[other]);
            spread(pairs.map(|(own, other)| own[0] / other[0]).collect())
        };
        let ([least, middle, most], [_, of_first, _]) = (of(reference), of(0));
        let [_, mean, _] = spread(times.iter().map(|time| time[0]).collect());
        let [_, slowest, _] = spread(times.iter().map(|time| time[1]).collect());
        let Kind { name, parts, errors, .. } = kind;
        println!(
            "{name:<16} {parts:>6} {:>12.4} {:>12.4} {mean:>10.3} {slowest:>10.2}  \
             {middle:.2}x ({least:.2}, {most:.2}), {of_first:.2}x",
            errors.iter().fold(0.0, |sum, error| sum + error) / errors.len().max(1) as f64,
            errors.iter().copied().fold(0.0, f64::max),
        );
    }
}

/// The least, the median and the most.
fn spread(mut figures: Vec<f64>) -> [f64; 3] {
    figures.sort_by(f64::total_cmp);
    [figures[0], figures[figures.len() / 2], figures[figures.len() - 1]]
}

fn load(name: &'static str) -> Model {
    let path = format!("{}/../../assets/{name}.glb", env!("CARGO_MANIFEST_DIR"));
    let mut mesh = read_mesh(path).expect("a bundled model").mesh;
    let factor = SIZE / hullwright::inspect::inspect(&mesh).expect("a sound mesh").diagonal;
    mesh.positions.iter_mut().flatten().for_each(|x| *x *= factor);
    let properties = mass_properties(&mesh, &[], DENSITY).expect("a sound mesh");
    Model { name, mesh, properties }
}

/// With `primitives`, hulls that are boxes, balls or capsules within the bound are these.
fn ours(name: &str, models: &[Model], parameters: &[Parameters], primitives: bool) -> Kind {
    let mut kind = Kind::new(name);
    let mut replaced = 0;
    for (model, parameters) in models.iter().zip(parameters) {
        let result = decompose(&model.mesh, parameters, &Control::new()).expect("a sound mesh");
        let shape = match primitives {
            true => {
                hullwright_rapier::shape_with_primitives(&HullsFile::new("", &result), [1.0; 3])
            }
            false => hullwright_rapier::shape(&result.hulls, [1.0; 3]),
        };
        let shape = shape.expect("sound hulls");
        if let Some(compound) = shape.as_compound() {
            let parts = compound.shapes().iter();
            replaced += parts.filter(|(_, part)| part.as_convex_polyhedron().is_none()).count();
        }
        let hulls: Vec<_> = result.hulls.into_iter().map(|hull| hull.shape).collect();
        kind.add(model, shape, &hulls);
    }
    if primitives {
        println!("{name}: {replaced} of {} hulls are boxes, balls or capsules", kind.parts);
    }
    kind
}

fn vhacd(models: &[Model], resolution: u32) -> Kind {
    let mut kind = Kind::new(&format!("V-HACD {resolution}"));
    for model in models {
        let points = vectors(model);
        let parameters = VHACDParameters { resolution, ..Default::default() };
        let found = VHACD::decompose(&parameters, &points, &model.mesh.triangles, true);
        let hulls: Vec<_> = found
            .compute_exact_convex_hulls(&points, &model.mesh.triangles)
            .into_iter()
            .map(|(points, triangles)| {
                let points: Vec<_> = points.iter().map(|p| p.to_array().map(f64::from)).collect();
                ConvexHull { points, triangles }
            })
            .collect();
        let parts = hulls.iter().filter_map(|hull: &ConvexHull| {
            let points = hull.points_as::<[f32; 3]>().map(Vector::from).collect();
            Some((Pose::IDENTITY, SharedShape::convex_mesh(points, &hull.triangles)?))
        });
        let shape = SharedShape::compound(parts.collect());
        kind.add(model, shape, &hulls);
    }
    kind
}

fn triangles(models: &[Model]) -> Kind {
    let mut kind = Kind::new("triangles");
    for model in models {
        let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
        let shape =
            SharedShape::trimesh_with_flags(vectors(model), model.mesh.triangles.clone(), flags);
        kind.shapes.push(shape.expect("a sound mesh"));
        kind.parts += model.mesh.triangles.len();
    }
    kind
}

fn vectors(model: &Model) -> Vec<Vector> {
    model.mesh.positions.iter().map(|p| Vector::from(p.map(|x| x as f32))).collect()
}

impl Kind {
    fn new(name: &str) -> Self {
        Self { name: name.into(), shapes: Vec::new(), parts: 0, errors: Vec::new() }
    }

    fn add(&mut self, model: &Model, shape: SharedShape, hulls: &[ConvexHull]) {
        let options = MeasureOptions::default();
        let found = measure(&model.mesh, hulls, &options, &Control::new())
            .unwrap_or_else(|error| panic!("{}: {error}", model.name));
        let error = found.protrusion.max.max(found.uncovered.max);
        self.shapes.push(shape);
        self.parts += hulls.len();
        self.errors.push(error);
    }
}

/// Milliseconds of a step: the mean over all, and the slowest.
fn simulate(kind: &Kind, models: &[Model], round: usize) -> [f64; 2] {
    let mut world = PhysicsWorld::new();
    world.insert_collider(
        ColliderBuilder::cuboid(4.0, 0.5, 4.0).translation(Vector::NEG_Y / 2.0),
        None,
    );
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let thick = |across: f32| if across == 0.0 { 4.0 } else { 0.5 };
        let wall = ColliderBuilder::cuboid(thick(x), 20.0, thick(z));
        world.insert_collider(wall.translation(Vector::new(2.5 * x, 20.0, 2.5 * z)), None);
    }
    for index in 0..BODIES {
        let model = index % models.len();
        let (layer, place) = (index / 9, index % 9);
        let turn = (index + round) as f32;
        let at = Vector::new(
            1.2 * (place % 3) as f32 - 1.2,
            1.0 + 1.1 * layer as f32,
            1.2 * (place / 3) as f32 - 1.2,
        );
        let properties = hullwright_rapier::mass_properties(&models[model].properties, [1.0; 3])
            .expect("a sound mass");
        let collider = ColliderBuilder::new(kind.shapes[model].clone()).mass_properties(properties);
        let body = RigidBodyBuilder::dynamic().translation(at).rotation(Vector::splat(turn));
        world.insert(body.can_sleep(false), collider);
    }
    let mut slowest: f64 = 0.0;
    let start = Instant::now();
    for _ in 0..STEPS {
        let step = Instant::now();
        world.step();
        slowest = slowest.max(step.elapsed().as_secs_f64());
    }
    [1000.0 * start.elapsed().as_secs_f64() / STEPS as f64, 1000.0 * slowest]
}
