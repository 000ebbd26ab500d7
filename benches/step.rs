//! What a step of Rapier costs with our hulls, with Parry's V-HACD and with the triangles
//! themselves: `cargo bench --bench step --features io,rapier`.
//!
//! A hundred bodies, ten of each of ten bundled models, fall onto each other in a box. Each kind
//! of collider runs the same scene, with the mass properties of the source mesh. The error of a
//! set of hulls is the largest of how far it stands out of its mesh and how far the mesh stands
//! out of it, as `measure` samples it; V-HACD runs at the resolutions named, with its own defaults
//! else.

use std::time::Instant;

use hullwright::io::read_mesh;
use hullwright::measure::{HullShape, MeasureOptions, measure};
use hullwright::{Control, Parameters, decompose, mass_properties, rapier};
use rapier3d::parry::transformation::vhacd::{VHACD, VHACDParameters};
use rapier3d::prelude::*;

const MODELS: [&str; 10] =
    ["mug", "table", "teapot", "lamp", "bowl", "dog", "torus", "gear", "spring", "u_prism"];

/// Of each model.
const BODIES: usize = 10;

/// All models are scaled to this diagonal, in metres, so that each meets each.
const SIZE: f64 = 1.0;

/// Falling, landing, and coming to rest.
const STEPS: usize = 300;

const VHACD_RESOLUTIONS: [u32; 2] = [64, 128];

struct Model {
    name: &'static str,
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
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
    let models: Vec<Model> = MODELS.iter().map(|name| load(name)).collect();
    let mut kinds = vec![ours(&models)];
    kinds.extend(VHACD_RESOLUTIONS.map(|resolution| vhacd(&models, resolution)));
    kinds.push(triangles(&models));

    println!(
        "{:<14} {:>6} {:>12} {:>12} {:>10} {:>10} {:>9}",
        "colliders", "parts", "mean error", "worst error", "ms a step", "slowest", "of V-HACD"
    );
    let times: Vec<[f64; 2]> = kinds.iter().map(|kind| simulate(kind, &models)).collect();
    for (kind, [mean, slowest]) in kinds.iter().zip(&times) {
        let Kind { name, parts, errors, .. } = kind;
        let (average, worst) = match errors.as_slice() {
            [] => (0.0, 0.0),
            errors => (
                errors.iter().sum::<f64>() / errors.len() as f64,
                errors.iter().copied().fold(0.0, f64::max),
            ),
        };
        // The coarser V-HACD, which is its default.
        let ratio = mean / times[1][0];
        println!(
            "{name:<14} {parts:>6} {average:>12.4} {worst:>12.4} {mean:>10.3} {slowest:>10.2} \
             {ratio:>8.2}x"
        );
    }
}

fn load(name: &'static str) -> Model {
    let path = format!("{}/assets/{name}.glb", env!("CARGO_MANIFEST_DIR"));
    let file = read_mesh(path).expect("a bundled model");
    let found = hullwright::inspect(&file.positions, &file.triangles).expect("a sound mesh");
    let factor = SIZE / found.diagonal;
    let positions: Vec<_> = file.positions.iter().map(|p| p.map(|x| x * factor)).collect();
    let properties =
        mass_properties(&positions, &file.triangles, &[], 500.0).expect("a sound mesh");
    Model { name, positions, triangles: file.triangles, properties }
}

fn ours(models: &[Model]) -> Kind {
    let mut kind = Kind::new("ours");
    for model in models {
        let parameters = Parameters::default();
        let Model { positions, triangles, .. } = model;
        let hulls = decompose(positions, triangles, &parameters, &Control::new())
            .expect("a sound mesh")
            .hulls;
        let shapes: Vec<_> = hulls.iter().map(HullShape::from).collect();
        kind.add(model, rapier::shape(&hulls, [1.0; 3]).expect("sound hulls"), &shapes);
    }
    kind
}

fn vhacd(models: &[Model], resolution: u32) -> Kind {
    let mut kind = Kind::new(&format!("V-HACD {resolution}"));
    for model in models {
        let points = vectors(model);
        let parameters = VHACDParameters { resolution, ..Default::default() };
        let found = VHACD::decompose(&parameters, &points, &model.triangles, true);
        let hulls: Vec<_> = found
            .compute_exact_convex_hulls(&points, &model.triangles)
            .into_iter()
            .map(|(points, triangles)| {
                let points: Vec<_> = points.iter().map(|p| p.to_array().map(f64::from)).collect();
                (points, triangles)
            })
            .collect();
        let parts = hulls.iter().filter_map(|(points, triangles)| {
            let points = points.iter().map(|p| Vector::from(p.map(|x| x as f32))).collect();
            Some((Pose::IDENTITY, SharedShape::convex_mesh(points, triangles)?))
        });
        let shape = SharedShape::compound(parts.collect());
        let shapes: Vec<_> =
            hulls.iter().map(|(points, triangles)| HullShape { points, triangles }).collect();
        kind.add(model, shape, &shapes);
    }
    kind
}

fn triangles(models: &[Model]) -> Kind {
    let mut kind = Kind::new("triangles");
    for model in models {
        let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
        let shape = SharedShape::trimesh_with_flags(vectors(model), model.triangles.clone(), flags);
        kind.shapes.push(shape.expect("a sound mesh"));
        kind.parts += model.triangles.len();
    }
    kind
}

fn vectors(model: &Model) -> Vec<Vector> {
    model.positions.iter().map(|p| Vector::from(p.map(|x| x as f32))).collect()
}

impl Kind {
    fn new(name: &str) -> Self {
        Self { name: name.into(), shapes: Vec::new(), parts: 0, errors: Vec::new() }
    }

    fn add(&mut self, model: &Model, shape: SharedShape, hulls: &[HullShape<'_>]) {
        let options = MeasureOptions::default();
        let found = measure(&model.positions, &model.triangles, hulls, &options)
            .unwrap_or_else(|error| panic!("{}: {error}", model.name));
        let error = found.phantom.max.max(found.exposed.max);
        self.shapes.push(shape);
        self.parts += hulls.len();
        self.errors.push(error);
    }
}

/// Milliseconds of a step: the mean over all, and the slowest.
fn simulate(kind: &Kind, models: &[Model]) -> [f64; 2] {
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
    for index in 0..BODIES * models.len() {
        let model = index % models.len();
        let (layer, place) = (index / 9, index % 9);
        let turn = index as f32;
        let at = Vector::new(
            1.2 * (place % 3) as f32 - 1.2,
            1.0 + 1.1 * layer as f32,
            1.2 * (place / 3) as f32 - 1.2,
        );
        let properties =
            rapier::mass_properties(&models[model].properties, [1.0; 3]).expect("a sound mass");
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
