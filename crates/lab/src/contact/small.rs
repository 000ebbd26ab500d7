//! `cargo lab small-contacts`: at which sizes which shapes have wrong contacts.
//!
//! A ball and a box are put onto every face of the hulls of a model, at its middle, so that they
//! sink in by a known depth: for a convex shape the right answer is that depth, and the face's normal.
//! The table shows on which share of the hulls' surface the answer is another.

use std::path::PathBuf;

use hullwright::io::read_mesh;
use hullwright::rapier::{ContactDispatcher, shape_from_points};
use hullwright::{Control, Parameters, decompose};
use hullwright_cli::terminal::{Failure, print};
use parry3d::math::{Pose, Rotation, Vector};
use parry3d::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use parry3d::shape::{Ball, ConvexPolyhedron, Cuboid, Shape};

use crate::report::table::Table;
use crate::runs::{meshes, vhacd};

/// Show at which sizes which shapes have wrong contacts in Parry, in metres
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(help = meshes::files_help(), required = true, value_name = "MESH")]
    meshes: Vec<PathBuf>,
}

/// Diagonals of the models, in metres.
const SIZES: [f32; 8] = [100.0, 10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01];

/// Of the models' diagonals: the radius of the ball and half the edge of the box, how deep they sink
/// in, and what a depth may be off.
const RADIUS: f32 = 0.05;
const DEPTH: f32 = 0.005;
const ALLOWED: f32 = 0.001;

/// What a normal may be off: the cosine of ten degrees.
const ALLOWED_COSINE: f32 = 0.985;

type Dispatcher = dyn PersistentQueryDispatcher<(), ()>;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut ours = Vec::new();
    let mut theirs = Vec::new();
    for path in &arguments.meshes {
        let mesh = read_mesh(path)?.mesh;
        let diagonal = diagonal(&mesh.positions);
        let unit = |points: &[[f64; 3]]| -> Vec<[f64; 3]> {
            points.iter().map(|point| point.map(|x| x / diagonal)).collect()
        };
        let hulls = decompose(&mesh, &Parameters::default(), &Control::new())?.hulls;
        ours.extend(hulls.iter().map(|hull| unit(&hull.shape.points)));
        let parts = vhacd::decompose(mesh.view(), &vhacd::VHACDParameters::default());
        theirs.extend(parts.iter().map(|part| unit(&part.mesh.positions)));
    }
    let mut table = Table::new(
        "Wrong contacts",
        "Share of the hulls' surface on which a ball, or a box, that sinks in by 0.5 % of the model's \
         diagonal is found at another depth (by 0.1 % of the diagonal or more), with a normal 10° or more \
         off, or not at all.",
        &[
            "diagonal",
            "ball, our hulls",
            "ball, V-HACD's",
            "box, our hulls",
            "box, V-HACD's",
            "ball, ours, dispatcher",
            "ball, V-HACD's, dispatcher",
            "box, ours, dispatcher",
            "box, V-HACD's, dispatcher",
        ],
    );
    for size in SIZES {
        let mut row = vec![format!("{size} m")];
        for dispatcher in [&DefaultQueryDispatcher as &Dispatcher, &ContactDispatcher] {
            for body in [Body::Ball, Body::Box] {
                for hulls in [&ours, &theirs] {
                    row.push(format!(
                        "{:.1} %",
                        100.0 * wrong_share(hulls, size, body, dispatcher)
                    ));
                }
            }
        }
        table.rows.push(row);
    }
    print(&table.to_markdown())
}

fn diagonal(positions: &[[f64; 3]]) -> f64 {
    let extent = |axis: usize| {
        let along = positions.iter().map(|position| position[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    extent(0).hypot(extent(1)).hypot(extent(2))
}

#[derive(Clone, Copy)]
enum Body {
    Ball,
    Box,
}

/// The share of the hulls' area on which contacts are wrong.
fn wrong_share(hulls: &[Vec<[f64; 3]>], size: f32, body: Body, dispatcher: &Dispatcher) -> f32 {
    let (mut all, mut wrong) = (0.0, 0.0);
    for points in hulls {
        let Ok(shape) = shape_from_points(std::slice::from_ref(points), [size; 3]) else {
            continue;
        };
        let Some(polyhedron) = shape.as_convex_polyhedron() else { continue };
        for (middle, normal, area) in faces(polyhedron) {
            all += area;
            if !is_right(polyhedron, middle, normal, size, body, dispatcher) {
                wrong += area;
            }
        }
    }
    wrong / all
}

/// Middle, normal and area of each triangle of each face.
fn faces(polyhedron: &ConvexPolyhedron) -> Vec<(Vector, Vector, f32)> {
    let (points, triangles) = polyhedron.to_trimesh();
    let corner = |index: u32| points[index as usize];
    let face = |&[a, b, c]: &[u32; 3]| {
        let (a, b, c) = (corner(a), corner(b), corner(c));
        let cross = (b - a).cross(c - a);
        ((a + b + c) / 3.0, cross.normalize_or_zero(), cross.length() / 2.0)
    };
    triangles.iter().map(face).filter(|(_, normal, _)| *normal != Vector::ZERO).collect()
}

fn is_right(
    polyhedron: &ConvexPolyhedron,
    middle: Vector,
    normal: Vector,
    size: f32,
    body: Body,
    dispatcher: &Dispatcher,
) -> bool {
    let half = RADIUS * size;
    let rotation = Rotation::from_rotation_arc(Vector::Y, normal);
    let pose = Pose::from_parts(middle + normal * (half - DEPTH * size), rotation);
    let shape: &dyn Shape = match body {
        Body::Ball => &Ball::new(half),
        Body::Box => &Cuboid::new(Vector::splat(half)),
    };
    let mut manifolds: Vec<ContactManifold<(), ()>> = Vec::new();
    let prediction = DEPTH * size;
    let done = dispatcher.contact_manifolds(
        &pose,
        polyhedron,
        shape,
        prediction,
        &mut manifolds,
        &mut None,
    );
    let Some(manifold) = manifolds.first() else { return false };
    let Some(deepest) = manifold.find_deepest_contact() else { return false };
    done.is_ok()
        && (deepest.dist + DEPTH * size).abs() < ALLOWED * size
        && manifold.local_n1.dot(normal) > ALLOWED_COSINE
}
