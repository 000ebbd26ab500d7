//! Prisms with a known answer, and machine parts.

use std::f64::consts::TAU;

use glam::Vec3Swizzles as _;

use super::model::{Material, Model};
use super::shape::{Point, Shape, prism, skin, tube};

const STONE: Material = Material::new("stone", [168, 164, 156]);
const STEEL: Material = Material::metal("steel", [150, 156, 165]);
const RUBBER: Material = Material::new("rubber", [214, 96, 72]);

/// Side of the square beams that the prisms are made of.
const BEAM: f64 = 0.5;

/// A prism whose outline is given in beams.
fn beams(name: &'static str, purpose: &'static str, outline: &[f64]) -> Model {
    let points = outline.as_chunks::<2>().0.iter();
    let outline: Vec<[f64; 2]> = points.map(|point| point.map(|value| value * BEAM)).collect();
    Model::single(name, purpose, vec![STONE], prism(&outline, BEAM).grounded())
}

pub fn l_prism() -> Model {
    let outline = [0., 0., 2., 0., 2., 1., 1., 1., 1., 2., 0., 2.];
    beams("l_prism", "the least concave solid: 12 vertices, two boxes", &outline)
}

pub fn u_prism() -> Model {
    let outline = [0., 0., 3., 0., 3., 2., 2., 2., 2., 1., 1., 1., 1., 2., 0., 2.];
    beams("u_prism", "three boxes and a gap that must stay open", &outline)
}

pub fn plus() -> Model {
    let outline = [
        1., 0., 2., 0., 2., 1., 3., 1., 3., 2., 2., 2., 2., 3., 1., 3., 1., 2., 0., 2., 0., 1., 1.,
        1.,
    ];
    beams("plus", "four notches; a bar and two stubs at the least", &outline)
}

/// The circle in the x-z plane, as places at a share of the turn, distance and height.
fn around(share: f64, radius: f64, height: f64) -> Point {
    let (sine, cosine) = (TAU * share).sin_cos();
    Point::new(radius * cosine, height, radius * sine)
}

pub fn torus() -> Model {
    const SEGMENTS: usize = 32;
    const SIDES: usize = 16;
    let ring = |segment: usize| -> Vec<Point> {
        let point = |side: usize| {
            let (sine, cosine) = (TAU * side as f64 / SIDES as f64).sin_cos();
            around(segment as f64 / SEGMENTS as f64, 0.35 + 0.13 * cosine, 0.13 * sine)
        };
        (0..SIDES).map(point).collect()
    };
    let rings: Vec<Vec<Point>> = (0..SEGMENTS).map(ring).collect();
    let shape = Shape::from_corners(skin(&rings, true, true)).outward();
    let purpose = "a swimming ring: a hole all the way through a smooth body";
    Model::single("torus", purpose, vec![RUBBER], shape.grounded())
}

pub fn gear() -> Model {
    const TEETH: usize = 14;
    /// Where in a tooth's share of the turn an edge lies, and whether it is at the tip.
    const FLANKS: [(f64, bool); 4] = [(-0.29, false), (-0.13, true), (0.13, true), (0.29, false)];
    const TIP: f64 = 0.060;
    const ROOT: f64 = 0.050;
    /// Radius and half thickness from the bore outward, up to the teeth.
    const SECTION: [[f64; 2]; 5] =
        [[0.010, 0.012], [0.019, 0.012], [0.020, 0.004], [0.039, 0.004], [0.041, 0.009]];
    let ring = |index: usize| -> Vec<Point> {
        let (place, is_tip) = FLANKS[index % FLANKS.len()];
        let share = ((index / FLANKS.len()) as f64 + place) / TEETH as f64;
        let teeth = [if is_tip { TIP } else { ROOT }, 0.009];
        let upper = SECTION.iter().chain([&teeth]).map(|[radius, half]| (*radius, *half));
        let lower = upper.clone().rev().map(|(radius, half)| (radius, -half));
        let point = |(radius, height)| {
            // The axle lies along z, so that the gear stands on its teeth.
            around(share, radius, height).xzy()
        };
        upper.chain(lower).map(point).collect()
    };
    let rings: Vec<Vec<Point>> = (0..TEETH * FLANKS.len()).map(ring).collect();
    let shape = Shape::from_corners(skin(&rings, true, true)).outward();
    let purpose = "teeth that must mesh and a bore that an axle must fit";
    Model::single("gear", purpose, vec![STEEL], shape.grounded())
}

pub fn spring() -> Model {
    const TURNS: f64 = 4.5;
    const STEPS_PER_TURN: f64 = 18.0;
    const RADIUS: f64 = 0.030;
    const RISE_PER_TURN: f64 = 0.017;
    let point = |step: usize| {
        let turn = step as f64 / STEPS_PER_TURN;
        around(turn, RADIUS, RISE_PER_TURN * turn)
    };
    let path: Vec<Point> = (0..=(TURNS * STEPS_PER_TURN) as usize).map(point).collect();
    let shape = tube(&path, 8, Point::Y, |_| [0.004, 0.004]);
    let purpose = "a helix: no plane cuts it well";
    Model::single("spring", purpose, vec![STEEL], shape.grounded())
}
