//! The shapes whose openings the tests are about, and which `cargo lab pictures opening-cases`
//! draws.

use hullwright::{Sidedness, TriangleMesh};

pub type Point = [f64; 3];

/// What becomes solid, with its name.
pub fn solids() -> Vec<(&'static str, TriangleMesh)> {
    vec![
        ("floor tile without a bottom", floor_tile()),
        ("rock without a bottom", rock()),
        ("barrel without a bottom", barrel()),
        ("trunk, open at both ends", trunk()),
        ("wall panel without its back", wall_panel()),
        ("chest of planks without backs", chest_of_planks()),
        ("leg without a top, and a beam that ends in it", leg_and_beam()),
        ("box with a vertex on a lid's edge", t_junction()),
    ]
}

/// What stays hollow, with its name.
pub fn hollows() -> Vec<(&'static str, TriangleMesh)> {
    vec![
        ("pipe with a liner", lined_pipe()),
        ("cup, its liner not welded", cup_with_loose_liner()),
        ("cup, its liner ends below the rim", cup_with_short_liner()),
        ("bowl, drawn from within", bowl_from_within()),
        ("bowl, drawn from both sides", bowl_from_both_sides()),
        ("room without a ceiling", room()),
        ("tent", tent()),
        ("hood", hood()),
        ("leaf", leaf()),
        ("curtain", curtain()),
        ("terrain", terrain()),
        ("car body with wheel arches", car_body()),
    ]
}

/// Sides of a box, by the axis and whether it is the far one.
pub const BOTTOM: (usize, bool) = (1, false);
pub const TOP: (usize, bool) = (1, true);
pub const BACK: (usize, bool) = (2, false);

pub fn quad(mesh: &mut TriangleMesh, corners: [Point; 4]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(corners);
    mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
}

/// A box, outward, without some of its sides.
pub fn box_without(low: Point, high: Point, missing: &[(usize, bool)]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for axis in 0..3 {
        for is_far in [false, true] {
            if missing.contains(&(axis, is_far)) {
                continue;
            }
            let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |u: bool, v: bool| {
                let mut point = low;
                point[axis] = if is_far { high[axis] } else { low[axis] };
                point[first] = if u { high[first] } else { low[first] };
                point[second] = if v { high[second] } else { low[second] };
                point
            };
            let around = [
                corner(false, false),
                corner(true, false),
                corner(true, true),
                corner(false, true),
            ];
            let [a, b, c, d] = around;
            quad(&mut mesh, if is_far { around } else { [a, d, c, b] });
        }
    }
    mesh
}

/// The side of a frustum about the y axis, outward, between two rings of `n` corners.
pub fn ring(
    n: usize,
    (low, low_radius): (f64, f64),
    (high, high_radius): (f64, f64),
) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let at = |i: usize, y: f64, radius: f64| {
        let angle = std::f64::consts::TAU * (i % n) as f64 / n as f64;
        [radius * angle.cos(), y, -radius * angle.sin()]
    };
    for i in 0..n {
        let [a, b] = [at(i, low, low_radius), at(i + 1, low, low_radius)];
        let [c, d] = [at(i + 1, high, high_radius), at(i, high, high_radius)];
        quad(&mut mesh, [a, b, c, d]);
    }
    mesh
}

/// A disc about the y axis that faces up.
pub fn disc(n: usize, y: f64, radius: f64) -> TriangleMesh {
    ring(n, (y, radius), (y, 0.0))
}

pub fn turned(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh
}

pub fn joined(parts: &[TriangleMesh]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for part in parts {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&part.positions);
        mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| first + v)));
    }
    mesh
}

pub fn both_sided(mesh: TriangleMesh) -> TriangleMesh {
    let sidedness = vec![Sidedness::Two; mesh.triangles.len()];
    TriangleMesh { sidedness, ..mesh }
}

/// A sheet over a grid, with a height at each place.
fn sheet(n: usize, height: impl Fn(f64, f64) -> f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let at = |i: usize, j: usize| {
        let (x, z) = (i as f64 / n as f64, j as f64 / n as f64);
        [x, height(x, z), z]
    };
    for i in 0..n {
        for j in 0..n {
            quad(&mut mesh, [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh
}

/// A floor tile without a bottom.
pub fn floor_tile() -> TriangleMesh {
    box_without([0.0; 3], [2.0, 0.2, 2.0], &[BOTTOM])
}

/// Six boards around a room, each without the side that faces it: caps would empty the chest.
pub fn chest_of_planks() -> TriangleMesh {
    let boards: Vec<TriangleMesh> = (0..3)
        .flat_map(|axis| [false, true].map(|is_far| (axis, is_far)))
        .map(|(axis, is_far)| {
            let (mut low, mut high) = ([0.0; 3], [1.0; 3]);
            if is_far {
                low[axis] = 0.9
            } else {
                high[axis] = 0.1
            }
            box_without(low, high, &[(axis, !is_far)])
        })
        .collect();
    joined(&boards)
}

/// A rock without a bottom.
pub fn rock() -> TriangleMesh {
    joined(&[ring(9, (0.0, 1.0), (0.5, 0.9)), ring(9, (0.5, 0.9), (0.9, 0.0))])
}

/// A barrel without a bottom.
pub fn barrel() -> TriangleMesh {
    joined(&[
        ring(12, (0.0, 0.8), (1.0, 1.0)),
        ring(12, (1.0, 1.0), (2.0, 0.8)),
        disc(12, 2.0, 0.8),
    ])
}

/// A trunk that is open at both ends, and not lined.
pub fn trunk() -> TriangleMesh {
    ring(12, (0.0, 0.5), (3.0, 0.4))
}

/// A pipe with a liner, open at both ends.
pub fn lined_pipe() -> TriangleMesh {
    joined(&[ring(8, (0.0, 1.0), (3.0, 1.0)), turned(ring(8, (0.0, 0.6), (3.0, 0.6)))])
}

/// A wall panel without its back.
pub fn wall_panel() -> TriangleMesh {
    box_without([0.0; 3], [2.0, 2.0, 0.2], &[BACK])
}

/// A box without two sides that meet.
pub fn open_corner() -> TriangleMesh {
    box_without([0.0; 3], [1.0; 3], &[BACK, BOTTOM])
}

/// A cup whose liner is not welded to its wall.
pub fn cup_with_loose_liner() -> TriangleMesh {
    cup_with_liner(2.0)
}

/// A cup whose liner ends below its rim.
pub fn cup_with_short_liner() -> TriangleMesh {
    cup_with_liner(1.8)
}

fn cup_with_liner(end: f64) -> TriangleMesh {
    joined(&[
        ring(4, (0.0, 1.0), (2.0, 1.0)),
        turned(disc(4, 0.0, 1.0)),
        turned(ring(4, (0.2, 0.8), (end, 0.8))),
        disc(4, 0.2, 0.8),
    ])
}

/// A bowl of one sheet, drawn from within.
pub fn bowl_from_within() -> TriangleMesh {
    turned(bowl())
}

/// A bowl of one sheet, drawn from both sides.
pub fn bowl_from_both_sides() -> TriangleMesh {
    both_sided(bowl())
}

fn bowl() -> TriangleMesh {
    joined(&[turned(disc(12, 0.0, 0.6)), ring(12, (0.0, 0.6), (0.8, 1.0))])
}

/// A tent of one sheet.
pub fn tent() -> TriangleMesh {
    let mut tent = TriangleMesh::default();
    quad(&mut tent, [[-1.0, 0.0, 0.0], [-1.0, 0.0, 3.0], [0.0, 1.0, 3.0], [0.0, 1.0, 0.0]]);
    quad(&mut tent, [[0.0, 1.0, 0.0], [0.0, 1.0, 3.0], [1.0, 0.0, 3.0], [1.0, 0.0, 0.0]]);
    tent
}

/// A hood: a shallow dome of one sheet.
pub fn hood() -> TriangleMesh {
    joined(&[ring(12, (0.0, 1.0), (0.2, 0.5)), ring(12, (0.2, 0.5), (0.25, 0.0))])
}

/// A leaf of one sheet, bent a little.
pub fn leaf() -> TriangleMesh {
    let mut leaf = TriangleMesh::default();
    quad(&mut leaf, [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.5, 0.02, 1.0], [0.5, 0.02, 0.0]]);
    quad(&mut leaf, [[0.5, 0.02, 0.0], [0.5, 0.02, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    leaf
}

/// A curtain.
pub fn curtain() -> TriangleMesh {
    sheet(8, |x, _| 0.15 * (12.0 * x).sin())
}

/// A chunk of terrain.
pub fn terrain() -> TriangleMesh {
    sheet(8, |x, z| 0.2 * (5.0 * x).sin() * (4.0 * z).cos())
}

/// A car's body without its underside.
pub fn car_body() -> TriangleMesh {
    // The sides end higher at the arches, so the rim below is not flat.
    let mut car = box_without([0.0; 3], [4.0, 1.0, 2.0], &[BOTTOM, (2, false), (2, true)]);
    for (z, is_far) in [(0.0, false), (2.0, true)] {
        for (from, to, low) in
            [(0.0, 0.5, 0.0), (0.5, 1.2, 0.5), (1.2, 2.8, 0.0), (2.8, 3.5, 0.5), (3.5, 4.0, 0.0)]
        {
            let corners = [[from, low, z], [to, low, z], [to, 1.0, z], [from, 1.0, z]];
            let [a, b, c, d] = corners;
            quad(&mut car, if is_far { corners } else { [a, d, c, b] });
        }
    }
    car
}

/// A room without a ceiling.
pub fn room() -> TriangleMesh {
    turned(box_without([0.0; 3], [3.0, 2.0, 3.0], &[TOP]))
}

/// A pot without a lid.
pub fn pot() -> TriangleMesh {
    joined(&[turned(disc(12, 0.0, 0.8)), ring(12, (0.0, 0.8), (1.0, 1.0))])
}

/// The same with a lid that shares its rim.
pub fn pot_with_lid() -> TriangleMesh {
    joined(&[pot(), ring(12, (1.0, 1.0), (1.3, 0.0))])
}

/// A leg without its top, and a beam that is open where it ends in the leg.
pub fn leg_and_beam() -> TriangleMesh {
    let leg = box_without([0.0; 3], [0.4, 2.0, 0.4], &[TOP]);
    let beam = box_without([0.2, 1.0, 0.1], [3.0, 1.2, 0.3], &[(0, false)]);
    joined(&[leg, beam])
}

/// A box whose lid has a vertex in the middle of an edge.
pub fn t_junction() -> TriangleMesh {
    let mut mesh = box_without([0.0; 3], [1.0; 3], &[TOP]);
    quad(&mut mesh, [[0.0, 1.0, 1.0], [0.5, 1.0, 1.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    quad(&mut mesh, [[0.5, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [0.5, 1.0, 0.0]]);
    mesh
}
