//! What a step of Rapier costs with bodies on two surfaces, and whether any body is where it should
//! not be.
//!
//! Both worlds have the same bodies and take turns, so that what else the machine does slows both.
//! Rapier keeps contacts while a body moves by less than 5 cm. So the step is timed while bodies
//! land and roll, at rest, and at rest without keeping contacts: as for bodies that are driven.

use cpu_time::ThreadTime;
use hullwright_rapier::ContactDispatcher;
use rapier3d::prelude::*;

use super::compose::{Terrain, between};
use super::touch::lowered;
use crate::independent::nearest::Tree;
use crate::statistics::{mean, median};
use crate::tools::random::Random;

/// Steps in which bodies land, and most come to rest; at rest; and at rest without keeping
/// contacts.
const STEPS: [usize; 3] = [180, 300, 300];

/// The extents of bodies in metres.
const EXTENTS: [f64; 2] = [0.3, 1.0];

/// In place of the friction that stops what rolls.
const DAMPING: f32 = 1.0;

/// How much deeper than the bound a body may lie, in metres: contacts of Rapier give way.
const GIVES_WAY: f64 = 0.02;

/// A shape at a place.
pub type Fixed = (Vector, SharedShape);

/// A body before it falls, and the radius of the largest ball about its centre within it.
pub struct Body {
    shape: SharedShape,
    place: [f64; 3],
    within: f64,
}

/// Boxes, balls and capsules, twice as many of the first two, just above a surface.
pub fn bodies(surface: &Tree, starts: &[[f64; 3]], seed: u64) -> Vec<Body> {
    let mut random = Random::new(seed);
    let body = |(index, &start): (usize, &[f64; 3])| {
        let half = [0; 3].map(|_| between(EXTENTS, &mut random) / 2.0);
        let [x, y, z] = half.map(|x| x as f32);
        let (shape, within) = match index % 5 {
            0 | 1 => (SharedShape::cuboid(x, y, z), half.into_iter().fold(f64::INFINITY, f64::min)),
            2 | 3 => (SharedShape::ball(x), half[0]),
            _ => (SharedShape::capsule_y(y, x / 2.0), half[0] / 2.0),
        };
        let around = f64::from(shape.compute_local_bounding_sphere().radius);
        lowered(surface, start, around).map(|place| Body { shape, place, within })
    };
    starts.iter().enumerate().filter_map(body).collect()
}

/// Times of steps, and what is there after the last.
pub struct Steps {
    /// In milliseconds: the mean while bodies land, the medians at rest with and without keeping
    /// contacts.
    pub times: [f64; 3],
    /// Contact manifolds: one for each triangle in the reach of a body, or two bodies.
    pub manifolds: usize,
    pub contacts: usize,
    /// Bodies below the terrain.
    pub fallen: usize,
    /// Bodies nearer to the source than what is within them, the bound and what gives way allow.
    pub too_deep: usize,
    /// How much nearer a body is than what is within it, at most, in metres.
    pub deepest: f64,
}

/// What the bodies are judged by.
pub struct Judge<'a> {
    pub source: &'a Tree,
    pub terrain: &'a Terrain,
    pub bound: f64,
}

/// Steps a world for each of the two surfaces.
pub fn run(surfaces: [Vec<Fixed>; 2], bodies: &[Body], judge: &Judge) -> [Steps; 2] {
    let mut worlds = surfaces.map(|surface| (world(surface, bodies), Vec::new()));
    for (phase, steps) in STEPS.into_iter().enumerate() {
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..steps {
            for ((world, _), times) in worlds.iter_mut().zip(&mut times) {
                world.integration_parameters.contact_recycling = phase < 2;
                let start = ThreadTime::now();
                world.step();
                times.push(1e3 * start.elapsed().as_secs_f64());
            }
        }
        for ((_, found), times) in worlds.iter_mut().zip(times) {
            found.push(if phase == 0 { mean(&times) } else { median(times) });
        }
    }
    worlds.map(|(world, times)| judge.judged(&world, &times, bodies))
}

fn world(surface: Vec<Fixed>, bodies: &[Body]) -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.narrow_phase = NarrowPhase::with_query_dispatcher(ContactDispatcher);
    for (place, shape) in surface {
        world.insert_collider(ColliderBuilder::new(shape).translation(place), None);
    }
    for body in bodies {
        let place = Vector::from(body.place.map(|x| x as f32));
        let dynamic = RigidBodyBuilder::dynamic().translation(place).can_sleep(false);
        let collider = ColliderBuilder::new(body.shape.clone());
        world.insert(dynamic.angular_damping(DAMPING), collider);
    }
    world
}

impl Judge<'_> {
    fn judged(&self, world: &PhysicsWorld, times: &[f64], bodies: &[Body]) -> Steps {
        let manifolds = || world.contact_pairs().flat_map(|pair| pair.manifolds());
        let mut steps = Steps {
            times: std::array::from_fn(|phase| times.get(phase).copied().unwrap_or_default()),
            manifolds: manifolds().count(),
            contacts: manifolds().map(|manifold| manifold.points.len()).sum(),
            fallen: 0,
            too_deep: 0,
            deepest: 0.0,
        };
        for ((_, body), Body { within, .. }) in world.rigid_bodies().zip(bodies) {
            let [x, y, z] = body.translation().to_array().map(f64::from);
            let is_beside = [x, z].iter().any(|x| !(0.0..=self.terrain.side()).contains(x));
            if is_beside {
                continue;
            }
            if y < self.terrain.height(x, z) - self.bound {
                steps.fallen += 1;
                continue;
            }
            let depth = within - self.source.distance([x, y, z]);
            steps.deepest = steps.deepest.max(depth);
            steps.too_deep += usize::from(depth > self.bound + GIVES_WAY);
        }
        steps
    }
}
