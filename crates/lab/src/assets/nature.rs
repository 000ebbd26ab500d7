//! What no lathe makes: a dog and a leaf.

use std::f64::consts::PI;

use super::blob::{Blob, Limb};
use super::model::{Material, Model};
use super::shape::{Point, Shape, skin};

const FUR: Material = Material::new("fur", [188, 142, 94]);
const GREEN: Material = Material::new("leaf green", [112, 156, 72]);

/// Size of the dog's quads. Some sizes, such as 0.025, let a cell catch two sheets at the hock,
/// which is then not manifold; a test watches over it.
const DOG_CELL: f64 = 0.024;

pub fn dog() -> Model {
    let limb = |from: [f64; 3], to: [f64; 3], radii: [f64; 2]| Limb {
        from: from.into(),
        to: to.into(),
        radii,
    };
    let mut limbs = vec![
        limb([-0.22, 0.400, 0.0], [0.20, 0.415, 0.0], [0.108, 0.132]),
        limb([0.24, 0.46, 0.0], [0.34, 0.60, 0.0], [0.088, 0.070]),
        limb([0.35, 0.635, 0.0], [0.40, 0.630, 0.0], [0.085, 0.076]),
        limb([0.42, 0.610, 0.0], [0.525, 0.590, 0.0], [0.055, 0.042]),
        limb([-0.30, 0.440, 0.0], [-0.40, 0.540, 0.0], [0.038, 0.034]),
        limb([-0.40, 0.540, 0.0], [-0.43, 0.655, 0.0], [0.034, 0.030]),
    ];
    for side in [-1.0, 1.0] {
        limbs.extend([
            limb([0.335, 0.690, 0.055 * side], [0.290, 0.600, 0.110 * side], [0.026, 0.030]),
            limb([0.190, 0.360, 0.080 * side], [0.165, 0.200, 0.092 * side], [0.070, 0.046]),
            limb([0.165, 0.200, 0.092 * side], [0.170, 0.040, 0.092 * side], [0.044, 0.034]),
            limb([0.170, 0.036, 0.092 * side], [0.212, 0.034, 0.092 * side], [0.038, 0.034]),
            limb([-0.230, 0.370, 0.080 * side], [-0.215, 0.230, 0.092 * side], [0.088, 0.056]),
            limb([-0.215, 0.230, 0.092 * side], [-0.270, 0.150, 0.092 * side], [0.048, 0.036]),
            limb([-0.270, 0.150, 0.092 * side], [-0.250, 0.040, 0.092 * side], [0.036, 0.033]),
            limb([-0.250, 0.036, 0.092 * side], [-0.208, 0.034, 0.092 * side], [0.038, 0.034]),
        ]);
    }
    let shape = Blob { limbs, blend: 0.045 }.surface(DOG_CELL);
    let purpose = "an animal: smooth, one closed surface, limbs at all angles";
    Model::single("dog", purpose, vec![FUR], shape.grounded())
}

pub fn leaf() -> Model {
    const LENGTH: f64 = 0.14;
    const STEPS: usize = 20;
    const HALF_STEPS: isize = 4;
    let rib = |step: usize| -> Vec<Point> {
        let along = step as f64 / STEPS as f64;
        let half_width = 0.034 * (PI * along.powf(0.75)).sin().max(0.0).powf(0.85);
        let point = |side: isize| {
            let across = side as f64 / HALF_STEPS as f64;
            let arch = 0.030 * (PI * along).sin() - 0.012 * along * along;
            let fold = 0.45 * half_width * across.abs().powf(1.4);
            let ripple = 0.0016 * across.abs() * (6.0 * PI * along).sin();
            Point::new(LENGTH * along, arch + fold + ripple, half_width * across)
        };
        (-HALF_STEPS..=HALF_STEPS).map(point).collect()
    };
    let ribs: Vec<Vec<Point>> = (0..=STEPS).map(rib).collect();
    let shape = Shape::from_corners(skin(&ribs, false, false)).grounded();
    let purpose = "an open sheet: no inside, no thickness";
    Model { closed: false, ..Model::single("leaf", purpose, vec![GREEN], shape) }
}
