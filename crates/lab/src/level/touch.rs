//! Where balls come to lie on a surface, and how far the source is from there.
//!
//! All is in `f64`, by distances of a tree that shares no code with the crate. A ball that touches
//! a surface has its centre at the radius from it. If no point of either surface is farther from
//! the other than the bound, its distance from the source is the radius, give or take the bound.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::compose::{Terrain, near};
use crate::independent::nearest::Tree;
use crate::tools::random::Random;

/// The ball's radius in metres.
pub const RADIUS: f64 = 0.25;

/// A gap in metres at which a ball touches. Distances are compared with a tolerance of this.
pub const TOUCH: f64 = 1e-6;

/// Balls begin this high above the terrain, in metres: above every prop.
const START: f64 = 15.0;

/// Distances on the way down. Along a wall they become ever smaller.
const MOST_DISTANCES: usize = 3_000;

/// How far a ball rolls in a step, in metres, in how many directions, and how often.
const ROLL: (f64, usize, usize) = (0.05, 6, 50);

/// How far from a prop's middle a ball may begin, in metres.
const AROUND: f64 = 1.0;

/// Distances from the source less the radius, as fractions of the bound.
#[derive(Default)]
pub struct Touches {
    pub count: usize,
    /// Rolling ended since it led nowhere lower.
    pub held: usize,
    /// Farther than the bound allows, beyond the tolerance.
    pub beyond: usize,
    pub least: f64,
    pub most: f64,
}

/// Where things fall: half of them anywhere, half beside props.
pub fn places(terrain: &Terrain, props: &[[f32; 3]], count: usize, seed: u64) -> Vec<[f64; 3]> {
    let mut random = Random::new(seed);
    let place = |index: usize| {
        let [x, z] = match props.is_empty() || index.is_multiple_of(2) {
            true => terrain.anywhere(&mut random),
            false => {
                let [x, _, z] = props[random.integer(0, props.len())].map(f64::from);
                near([x, z], AROUND, &mut random).map(|x| terrain.within(x))
            }
        };
        [x, terrain.height(x, z) + START, z]
    };
    (0..count).map(place).collect()
}

/// Lowers a ball until it touches; nothing if it touches nothing.
pub fn lowered(surface: &Tree, mut centre: [f64; 3], radius: f64) -> Option<[f64; 3]> {
    let lowest = centre[1] - 10.0 * START;
    for _ in 0..MOST_DISTANCES {
        let gap = surface.distance(centre) - radius;
        if gap < TOUCH {
            return Some(centre);
        }
        centre[1] -= gap;
        if centre[1] < lowest {
            return None;
        }
    }
    None
}

/// Rolls a ball that touches, in steps to wherever it gets lowest, and says whether it is held.
fn rolled(surface: &Tree, mut centre: [f64; 3]) -> ([f64; 3], bool) {
    let (step, directions, steps) = ROLL;
    for _ in 0..steps {
        let beside = (0..directions).filter_map(|direction| {
            let (sine, cosine) = (TAU * direction as f64 / directions as f64).sin_cos();
            let moved = [centre[0] + step * cosine, centre[1], centre[2] + step * sine];
            // Where it is in the way of the surface, that leads up.
            let is_free = surface.distance(moved) > RADIUS + TOUCH;
            if is_free { lowered(surface, moved, RADIUS) } else { None }
        });
        match beside.min_by(|a, b| a[1].total_cmp(&b[1])) {
            Some(lower) => centre = lower,
            None => return (centre, true),
        }
    }
    (centre, false)
}

/// Lowers and rolls balls on one surface, and compares with the other: those that first touch, and
/// those that have rolled.
pub fn compare(surface: &Tree, source: &Tree, starts: &[[f64; 3]], bound: f64) -> [Touches; 2] {
    let distance = |centre: [f64; 3]| source.distance(centre) - RADIUS;
    let found: Vec<_> = starts
        .par_iter()
        .filter_map(|&start| {
            let first = lowered(surface, start, RADIUS)?;
            let (last, is_held) = rolled(surface, first);
            Some([(distance(first), false), (distance(last), is_held)])
        })
        .collect();
    [0, 1].map(|which| {
        let mut touches = Touches { count: found.len(), ..Touches::default() };
        for (off, is_held) in found.iter().map(|both| both[which]) {
            touches.held += usize::from(is_held);
            touches.beyond += usize::from(off.abs() > bound + TOUCH);
            touches.least = touches.least.min(off / bound);
            touches.most = touches.most.max(off / bound);
        }
        touches
    })
}
