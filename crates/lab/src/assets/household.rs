//! What stands on a table, and the table.

use super::model::{Material, Model, Node};
use super::shape::{Point, Shape, cells, curve, lathe, tube};

const WOOD: Material = Material::new("wood", [176, 128, 82]);
const DARK_WOOD: Material = Material::new("dark wood", [134, 92, 60]);
const GLAZE: Material = Material::new("blue glaze", [84, 132, 178]);
const PORCELAIN: Material = Material::new("porcelain", [226, 222, 210]);
const CLAY: Material = Material::new("fired clay", [190, 106, 76]);
const IRON: Material = Material::metal("iron", [88, 92, 98]);
const BRASS: Material = Material::metal("brass", [198, 164, 92]);
const GLASS: Material = Material::new("frosted glass", [244, 236, 210]);
const LINEN: Material = Material::new("linen", [216, 196, 160]);

/// Across all curves that lie in the x-y plane.
const ACROSS: Point = Point::Z;

/// Points by their coordinates x and y.
fn flat(coordinates: &[f64]) -> Vec<Point> {
    coordinates.as_chunks().0.iter().map(|&[x, y]| Point::new(x, y, 0.0)).collect()
}

pub fn mug() -> Model {
    let cup = [
        0.000, 0.002, 0.030, 0.002, 0.033, 0.000, 0.037, 0.000, 0.041, 0.005, 0.041, 0.093, 0.040,
        0.095, 0.038, 0.095, 0.037, 0.093, 0.037, 0.014, 0.031, 0.008, 0.000, 0.008,
    ];
    // The ends stop inside the wall, so that nothing shows in the cup.
    let handle = curve(
        &flat(&[
            0.0388, 0.078, 0.050, 0.081, 0.064, 0.074, 0.069, 0.056, 0.064, 0.036, 0.051, 0.023,
            0.0388, 0.022,
        ]),
        3,
    );
    let shape = lathe(&cup, 32, |_| 0).with(tube(&handle, 10, ACROSS, |_| [0.0035, 0.0055]));
    let purpose = "a cup with a wall, and a handle that a finger fits through";
    Model::single("mug", purpose, vec![GLAZE], shape.grounded())
}

pub fn bowl() -> Model {
    let profile = [
        0.000, 0.005, 0.032, 0.005, 0.034, 0.000, 0.040, 0.000, 0.041, 0.007, 0.066, 0.018, 0.086,
        0.038, 0.097, 0.066, 0.0955, 0.0675, 0.094, 0.066, 0.083, 0.041, 0.063, 0.0225, 0.035,
        0.012, 0.000, 0.010,
    ];
    let purpose = "a thin shell with an inside that must stay open";
    Model::single("bowl", purpose, vec![CLAY], lathe(&profile, 36, |_| 0).grounded())
}

pub fn teapot() -> Model {
    let body = [
        0.000, 0.002, 0.040, 0.002, 0.043, 0.000, 0.049, 0.000, 0.052, 0.005, 0.068, 0.022, 0.080,
        0.045, 0.084, 0.066, 0.079, 0.089, 0.066, 0.107, 0.050, 0.117, 0.047, 0.121, 0.044, 0.121,
        0.041, 0.116, 0.000, 0.114,
    ];
    let lid = [
        0.000, 0.112, 0.039, 0.112, 0.041, 0.1185, 0.0485, 0.1215, 0.0475, 0.125, 0.036, 0.132,
        0.018, 0.137, 0.0085, 0.139, 0.0075, 0.144, 0.0125, 0.150, 0.0130, 0.156, 0.0085, 0.162,
        0.000, 0.164,
    ];
    let spout =
        curve(&flat(&[0.060, 0.040, 0.084, 0.046, 0.106, 0.066, 0.120, 0.096, 0.142, 0.116]), 4);
    let spout = tube(&spout, 12, ACROSS, |share| {
        let narrow = 0.022 - 0.0135 * share.powf(0.8);
        [narrow, 0.9 * narrow]
    });
    let handle = curve(
        &flat(&[
            -0.066, 0.094, -0.096, 0.104, -0.124, 0.096, -0.132, 0.072, -0.116, 0.046, -0.092,
            0.032, -0.066, 0.034,
        ]),
        3,
    );
    let handle = tube(&handle, 10, ACROSS, |share| {
        let thick = 0.0052 + 0.0022 * (2.0 * share - 1.0).powi(2);
        [thick, 1.35 * thick]
    });
    let shape = lathe(&body, 32, |_| 0).with(lathe(&lid, 32, |_| 0)).with(spout).with(handle);
    let purpose = "four closed parts that run into each other, as artists make them";
    Model::single("teapot", purpose, vec![PORCELAIN], shape.grounded())
}

pub fn lamp() -> Model {
    const FOOT: usize = 0;
    const STEM: usize = 1;
    const BULB: usize = 2;
    const SHADE: usize = 3;
    let profile = [
        0.000, 0.000, 0.088, 0.000, 0.092, 0.006, 0.088, 0.014, 0.040, 0.020, 0.020, 0.030, 0.011,
        0.042, 0.009, 0.090, 0.014, 0.100, 0.009, 0.110, 0.008, 0.210, 0.015, 0.218, 0.015, 0.238,
        0.024, 0.252, 0.032, 0.274, 0.029, 0.296, 0.017, 0.311, 0.005, 0.316, 0.005, 0.352, 0.070,
        0.352, 0.136, 0.196, 0.139, 0.196, 0.073, 0.355, 0.008, 0.355, 0.010, 0.362, 0.006, 0.370,
        0.000, 0.372,
    ];
    /// Bands of the profile from its start on, and their material.
    const BANDS: [(usize, usize); 6] =
        [(5, FOOT), (7, STEM), (5, BULB), (1, STEM), (5, SHADE), (3, STEM)];
    let materials: Vec<usize> =
        BANDS.iter().flat_map(|&(count, material)| vec![material; count]).collect();
    let shape = lathe(&profile, 28, |band| materials[band]);
    let purpose = "one closed surface in four materials: each primitive alone is an open fragment";
    Model::single("lamp", purpose, vec![IRON, BRASS, GLASS, LINEN], shape.grounded())
}

pub fn table() -> Model {
    let across = [-0.60, -0.54, 0.54, 0.60];
    let deep = [-0.40, -0.34, 0.34, 0.40];
    let shape =
        cells([&across, &[0.0, 0.70, 0.74], &deep], |[x, y, z]| y == 1 || (x != 1 && z != 1));
    let purpose = "low-poly, top and legs in one connected surface";
    Model::single("table", purpose, vec![WOOD], shape.grounded())
}

pub fn chair() -> Model {
    let half = [-0.5, 0.5];
    let cube: Shape = cells([&half, &half, &half], |_| true);
    let mut nodes = vec![Node::new("chair", None)];
    let block = |name: &str, parent: usize, scale: [f64; 3], translation: [f64; 3]| Node {
        parent: Some(parent),
        scale,
        translation,
        ..Node::new(name, Some(0))
    };
    nodes.push(block("seat", 0, [0.44, 0.04, 0.44], [0.0, 0.45, 0.0]));
    for (name, x, z) in [
        ("front left leg", -0.19, 0.19),
        ("front right leg", 0.19, 0.19),
        ("rear left leg", -0.19, -0.19),
        ("rear right leg", 0.19, -0.19),
    ] {
        nodes.push(block(name, 0, [0.045, 0.44, 0.045], [x, 0.22, z]));
    }
    let back = nodes.len();
    nodes.push(Node {
        parent: Some(0),
        tilt: -9.0,
        translation: [0.0, 0.45, -0.19],
        ..Node::new("back", None)
    });
    for (name, x) in [("left post", -0.195), ("right post", 0.195)] {
        nodes.push(block(name, back, [0.04, 0.48, 0.035], [x, 0.235, 0.0]));
    }
    for (name, y) in [("lower slat", 0.16), ("middle slat", 0.28), ("upper slat", 0.41)] {
        nodes.push(block(name, back, [0.37, 0.07, 0.018], [0.0, y, 0.0]));
    }
    Model {
        name: "chair",
        purpose: "ten boxes: one mesh, placed by a tree of nodes that move, turn and stretch it",
        closed: true,
        materials: vec![DARK_WOOD],
        meshes: vec![cube],
        mesh_names: vec!["chair"],
        nodes,
    }
}
