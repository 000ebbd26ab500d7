//! `cargo lab seams`: how straight bodies roll and slide over floors made of parts.
//!
//! A ball rolls and a box slides without friction over tiles and over decomposed floors, at several
//! speeds and headings. On one flat box both go straight on and stay down.

use hullwright::rapier::{ContactDispatcher, shape, shape_from_points};
use hullwright::{Control, Length, Parameters, TriangleMesh, decompose};
use hullwright_cli::terminal::{Failure, print};
use rapier3d::parry::shape::{Compound, CompoundFlags};
use rapier3d::prelude::*;

use crate::report::table::Table;

/// Show how straight a ball and a box go over seams between tiles and hulls
#[derive(clap::Args)]
pub struct Arguments {}

/// Metres per second.
const SPEEDS: [f32; 5] = [0.5, 1.0, 2.0, 5.0, 10.0];

/// The path that is watched, in metres, and the longest time for it, in seconds.
const PATH: f32 = 8.0;
const TIME: f32 = 6.0;

/// Metres.
const RADIUS: f32 = 0.1;

/// Who computes contacts.
#[derive(Clone, Copy, PartialEq)]
enum Contacts {
    Rapier,
    /// Rapier's, with Parry's flag for compounds.
    FixedEdges,
    Dispatcher,
}

/// A floor whose top is at height 0, and the headings over it, in degrees off the x axis.
struct Floor {
    name: &'static str,
    colliders: fn() -> Vec<SharedShape>,
    headings: &'static [f32],
}

/// Along a narrow path, which these headings stay on.
const NARROW: &[f32] = &[-1.0, 0.0, 0.5, 1.0];
const WIDE: &[f32] = &[0.0, 1.0, 10.0, 30.0, 45.0];

const FLOORS: [Floor; 6] = [
    Floor { name: "one box", colliders: one_box, headings: WIDE },
    Floor { name: "tiles, a collider each", colliders: tiles, headings: WIDE },
    Floor { name: "tiles, one compound", colliders: compound_of_tiles, headings: WIDE },
    Floor { name: "comb, decomposed", colliders: comb, headings: NARROW },
    Floor { name: "plate with holes, decomposed", colliders: holes, headings: NARROW },
    Floor { name: "steps at the side, decomposed", colliders: steps, headings: NARROW },
];

pub fn run(_: &Arguments) -> Result<(), Failure> {
    let mut table = Table::new(
        "Seams",
        "The worst of all speeds and headings. Deflection: from the heading, where the path ends. Hop: the \
         greatest height above that of rest. Speed: what is left of it.",
        &["floor", "body", "contacts", "deflection", "hop", "speed"],
    );
    for floor in &FLOORS {
        let shapes = (floor.colliders)();
        for (body, ball) in [("ball", true), ("box", false)] {
            for (contacts, name) in [
                (Contacts::Rapier, "Rapier's"),
                (Contacts::FixedEdges, "FIX_INTERNAL_EDGES"),
                (Contacts::Dispatcher, "dispatcher"),
            ] {
                let mut worst = Drift::default();
                for &heading in floor.headings {
                    for speed in SPEEDS {
                        worst.take(&drift(&shapes, ball, heading, speed, contacts));
                    }
                }
                table.rows.push(vec![
                    floor.name.into(),
                    body.into(),
                    name.into(),
                    format!("{:.2}°", worst.deflection),
                    format!("{:.1} mm", 1000.0 * worst.hop),
                    format!("{:.0} %", 100.0 * worst.speed),
                ]);
            }
        }
    }
    print(&table.to_markdown())
}

/// What a body does that it should not.
struct Drift {
    deflection: f32,
    hop: f32,
    speed: f32,
}

impl Default for Drift {
    fn default() -> Self {
        Self { deflection: 0.0, hop: 0.0, speed: 1.0 }
    }
}

impl Drift {
    fn take(&mut self, other: &Self) {
        self.deflection = self.deflection.max(other.deflection);
        self.hop = self.hop.max(other.hop);
        self.speed = self.speed.min(other.speed);
    }
}

fn drift(
    shapes: &[SharedShape],
    ball: bool,
    heading: f32,
    speed: f32,
    contacts: Contacts,
) -> Drift {
    let mut world = PhysicsWorld::new();
    if contacts == Contacts::Dispatcher {
        world.narrow_phase = NarrowPhase::with_query_dispatcher(ContactDispatcher);
    }
    let friction = if ball { 0.5 } else { 0.0 };
    for floor in shapes {
        let floor =
            if contacts == Contacts::FixedEdges { with_fixed_edges(floor) } else { floor.clone() };
        world.insert_collider(ColliderBuilder::new(floor).friction(friction), None);
    }
    let angle = heading.to_radians();
    let forward = Vector::new(angle.cos(), 0.0, angle.sin());
    let collider = if ball {
        ColliderBuilder::ball(RADIUS)
    } else {
        ColliderBuilder::cuboid(RADIUS, RADIUS, RADIUS)
    };
    let spin = if ball { Vector::Y.cross(forward) * speed / RADIUS } else { Vector::ZERO };
    let start = Vector::new(0.37, RADIUS, 0.0);
    let body = RigidBodyBuilder::dynamic()
        .translation(start)
        .rotation(-Vector::Y * angle)
        .linvel(forward * speed)
        .angvel(spin);
    let (body, _) = world.insert(body, collider.friction(friction).density(1000.0));
    let time = (PATH / speed).min(TIME);
    let mut hop = 0.0_f32;
    for _ in 0..(time / world.integration_parameters.dt) as usize {
        world.step();
        hop = hop.max(world.bodies[body].translation().y - RADIUS);
    }
    let end = world.bodies[body].linvel();
    let level = Vector::new(end.x, 0.0, end.z);
    let deflection = level.angle_between(forward).to_degrees();
    // What stands still has no direction.
    let deflection = if deflection.is_finite() { deflection } else { 180.0 };
    Drift { deflection, hop, speed: level.dot(forward) / speed }
}

fn with_fixed_edges(shape: &SharedShape) -> SharedShape {
    match shape.as_compound() {
        Some(compound) => SharedShape::new(Compound::with_flags(
            compound.shapes().to_vec(),
            CompoundFlags::FIX_INTERNAL_EDGES,
            None,
        )),
        None => shape.clone(),
    }
}

fn one_box() -> Vec<SharedShape> {
    vec![moved(SharedShape::cuboid(20.0, 0.5, 20.0), Vector::new(0.0, -0.5, 0.0))]
}

/// A shape that does not stand at the origin.
fn moved(shape: SharedShape, by: Vector) -> SharedShape {
    SharedShape::compound(vec![(Pose::from_translation(by), shape)])
}

/// The middles of tiles of a metre.
fn middles() -> impl Iterator<Item = Vector> {
    (-1..=10_i8).flat_map(|x| {
        (-4..=10_i8).map(move |z| Vector::new(f32::from(x) + 0.5, -0.25, f32::from(z)))
    })
}

fn tiles() -> Vec<SharedShape> {
    middles().map(|middle| moved(SharedShape::cuboid(0.5, 0.25, 0.5), middle)).collect()
}

fn compound_of_tiles() -> Vec<SharedShape> {
    let corners = |middle: Vector| -> Vec<[f64; 3]> {
        let corner = |index: u8| {
            let sign = |axis: u8| if index >> axis & 1 == 0 { -0.5 } else { 0.5 };
            [
                f64::from(middle.x) + sign(0),
                f64::from(middle.y) + sign(1) / 2.0,
                f64::from(middle.z) + sign(2),
            ]
        };
        (0..8).map(corner).collect()
    };
    let hulls: Vec<_> = middles().map(corners).collect();
    shape_from_points(&hulls, [1.0; 3]).into_iter().collect()
}

/// A path with a gap at one side of each second metre.
fn comb() -> Vec<SharedShape> {
    decomposed(&Cells {
        counts: [21, 1, 3],
        path: [1, 0],
        is_filled: |x, _, z| z == 0 || x % 2 == 0,
    })
}

/// A path between holes.
fn holes() -> Vec<SharedShape> {
    decomposed(&Cells {
        counts: [21, 1, 5],
        path: [1, 2],
        is_filled: |x, _, z| x % 2 == 0 || z % 2 == 0,
    })
}

/// A path with a step up at one side and a step down at the other, both with gaps.
fn steps() -> Vec<SharedShape> {
    let is_filled = |x: u32, y: u32, z: u32| y < z + u32::from(z == 1 || !x.is_multiple_of(3));
    decomposed(&Cells { counts: [21, 3, 3], path: [2, 1], is_filled })
}

/// A solid of cells, a metre long and wide and half a metre high.
struct Cells {
    counts: [u32; 3],
    /// How many cells high it is along the path, and in which row the path lies.
    path: [u32; 2],
    is_filled: fn(u32, u32, u32) -> bool,
}

impl Cells {
    fn contains(&self, cell: [i64; 3]) -> bool {
        let is_within =
            cell.iter().zip(self.counts).all(|(&at, count)| (0..i64::from(count)).contains(&at));
        let [x, y, z] = cell.map(|at| at as u32);
        is_within && (self.is_filled)(x, y, z)
    }

    /// The surface, with the path's middle along the x axis.
    fn mesh(&self) -> TriangleMesh {
        let [height, row] = self.path.map(f64::from);
        let place = |corner: [i64; 3]| {
            let [x, y, z] = corner.map(|at| at as f64);
            [x - 1.0, (y - height) / 2.0, z - row - 0.5]
        };
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        let [x, y, z] = self.counts.map(i64::from);
        let all = (0..x).flat_map(|x| (0..y).flat_map(move |y| (0..z).map(move |z| [x, y, z])));
        for cell in all.filter(|&cell| self.contains(cell)) {
            for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
                let mut beside = cell;
                beside[axis] += 2 * side - 1;
                if self.contains(beside) {
                    continue;
                }
                let first = positions.len() as u32;
                positions.extend([[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
                    let mut corner = cell;
                    corner[axis] += side;
                    corner[(axis + 1) % 3] += u;
                    corner[(axis + 2) % 3] += v;
                    place(corner)
                }));
                let [b, d] = if side == 1 { [1, 3] } else { [3, 1] };
                triangles.push([first, first + b, first + 2]);
                triangles.push([first, first + 2, first + d]);
            }
        }
        TriangleMesh::new(positions, triangles)
    }
}

/// The bound of decomposed floors, as a share of their diagonal: 5 to 10 cm, so that no hull leans over the
/// path.
const BOUND: f64 = 0.004;

fn decomposed(cells: &Cells) -> Vec<SharedShape> {
    let parameters = Parameters::default().max_error(Length::share(BOUND));
    decompose(&cells.mesh(), &parameters, &Control::new())
        .ok()
        .and_then(|decomposition| shape(&decomposition.hulls, [1.0; 3]).ok())
        .into_iter()
        .collect()
}
