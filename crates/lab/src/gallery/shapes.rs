//! Shapes of trouble, from formulas: what makes convex decomposition hard, one thing each.

use std::f64::consts::TAU;

use hullwright::TriangleMesh;

use crate::shapes::{Vector, cuboid, join, mobius_strip, torus, turn, uv_sphere};

/// A shape, its name, and what is hard about it.
pub struct Trouble {
    pub name: &'static str,
    pub words: &'static str,
    pub mesh: TriangleMesh,
}

/// All shapes, all y-up.
pub fn all() -> Vec<Trouble> {
    let shape = |name, words, mesh| Trouble { name, words, mesh };
    vec![
        shape(
            "thin walls",
            "A box whose five walls are a fiftieth of its width: a hull across the inside fills it.",
            open_box(0.02),
        ),
        shape(
            "sheet",
            "The same five sides without any thickness, drawn from both sides: there is no inside.",
            sheet_box(),
        ),
        shape(
            "no bottom",
            "A crate without the side that lies on the ground: an opening, which is closed.",
            without_bottom(),
        ),
        shape(
            "pipe",
            "An elbow that is open at both ends, with a wall: the way through stays free.",
            pipe(),
        ),
        shape(
            "spikes",
            "A ball with twenty spikes: each tip has to be reached, and nothing between them.",
            spikes(),
        ),
        shape("comb", "Eight thin teeth side by side, with gaps half as wide again.", comb()),
        shape("knot", "A trefoil: a tube that winds around itself.", knot()),
        shape("links", "Two rings of a chain, which must not grow together.", links()),
        shape(
            "hollow ball",
            "A ball within which is another, turned inside out: a cavity that nothing can reach.",
            hollow_ball(),
        ),
        shape(
            "Möbius strip",
            "A strip with one side: no winding agrees everywhere.",
            y_up(mobius_strip(48)),
        ),
        shape("sponge", "A cube with square holes through it, in all three directions.", sponge()),
        shape(
            "crossing beams",
            "Nine beams that run through each other, as modellers leave them: the mesh cuts itself.",
            crossing_beams(),
        ),
        shape(
            "spiral stairs",
            "Sixteen steps around a post, none of which touches the next.",
            stairs(),
        ),
    ]
}

fn y_up(mut mesh: TriangleMesh) -> TriangleMesh {
    for [_, y, z] in &mut mesh.positions {
        (*y, *z) = (*z, -*y);
    }
    mesh
}

fn moved(mut mesh: TriangleMesh, by: Vector) -> TriangleMesh {
    for point in &mut mesh.positions {
        *point = (Vector::from(*point) + by).to_array();
    }
    mesh
}

/// A closed box with a hole in it from above.
fn open_box(wall: f64) -> TriangleMesh {
    let (outer, inner) = ([-0.5, 0.5], [-0.5 + wall, 0.5 - wall]);
    let ring = |[low, high]: [f64; 2], y: f64| {
        [[low, y, low], [high, y, low], [high, y, high], [low, y, high]]
    };
    let height = 0.7;
    let mut positions = Vec::new();
    for points in [ring(outer, 0.0), ring(outer, height), ring(inner, height), ring(inner, wall)] {
        positions.extend(points);
    }
    let mut triangles = vec![[0, 1, 2], [0, 2, 3], [12, 14, 13], [12, 15, 14]];
    for level in 0..3 {
        for side in 0..4 {
            let [a, b] = [side, (side + 1) % 4].map(|side| 4 * level + side);
            triangles.extend([[a, a + 4, b + 4], [a, b + 4, b]]);
        }
    }
    TriangleMesh::new(positions, triangles)
}

/// Five sides, each both ways round.
fn sheet_box() -> TriangleMesh {
    let mut one = cuboid([-0.5, 0.0, -0.5], [0.5, 0.7, 0.5]);
    // Without what is at the greatest y.
    one.triangles.retain(|triangle| triangle.iter().any(|&v| one.positions[v as usize][1] < 0.1));
    let other = turn(one.clone());
    join(&[one, other])
}

fn without_bottom() -> TriangleMesh {
    let mut parts = vec![cuboid([-0.5, 0.0, -0.5], [0.5, 0.8, 0.5])];
    for [x, z] in [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]] {
        parts.push(cuboid([x - 0.06, 0.0, z - 0.06], [x + 0.06, 0.86, z + 0.06]));
    }
    for part in &mut parts {
        let positions = part.positions.clone();
        part.triangles.retain(|t| t.iter().any(|&v| positions[v as usize][1] > 0.1));
    }
    join(&parts)
}

/// A tube along a path, closed to a ring or with open ends. `n` points around it.
fn tube(path: &[Vector], radius: f64, n: usize, is_ring: bool) -> TriangleMesh {
    let count = path.len();
    let mut mesh = TriangleMesh::default();
    let start = path[1] - path[0];
    // Any way that is not along the path.
    let mut side = if start[2].abs() < start[1].abs() { Vector::Z } else { Vector::Y };
    for index in 0..count {
        let (before, after) = if is_ring {
            (path[(index + count - 1) % count], path[(index + 1) % count])
        } else {
            (path[index.saturating_sub(1)], path[(index + 1).min(count - 1)])
        };
        let along = (after - before).normalize_or_zero();
        // The side of the last ring, turned as little as possible.
        side = (side - along * side.dot(along)).normalize_or_zero();
        let other = along.cross(side);
        for step in 0..n {
            let (sine, cosine) = (TAU * step as f64 / n as f64).sin_cos();
            let way = side * cosine + other * sine;
            mesh.positions.push((path[index] + way * radius).to_array());
        }
    }
    let at = |ring: usize, step: usize| ((ring % count) * n + step % n) as u32;
    for ring in 0..if is_ring { count } else { count - 1 } {
        // A ring closes where its ends fit best: sides have turned on the way.
        let shift = if is_ring && ring == count - 1 { best_shift(&mesh, count, n) } else { 0 };
        for step in 0..n {
            let [a, b] = [at(ring, step), at(ring, step + 1)];
            let [c, d] = [at(ring + 1, step + shift), at(ring + 1, step + 1 + shift)];
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    mesh
}

fn best_shift(mesh: &TriangleMesh, rings: usize, n: usize) -> usize {
    let last = Vector::from(mesh.positions[(rings - 1) * n]);
    let gap = |shift: &usize| Vector::from(mesh.positions[*shift]).distance(last);
    (0..n).min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(0)
}

/// A quarter of a ring with a wall.
fn pipe() -> TriangleMesh {
    let path: Vec<Vector> = (0..=16)
        .map(|step| {
            let angle = TAU / 4.0 * f64::from(step) / 16.0;
            // One end faces the viewer.
            Vector::new(-angle.cos(), 0.0, angle.sin())
        })
        .collect();
    let n = 24;
    let (outer, inner) = (tube(&path, 0.34, n, false), turn(tube(&path, 0.28, n, false)));
    let first = outer.positions.len() as u32;
    let mut mesh = join(&[outer, inner]);
    let last = (path.len() as u32 - 1) * n as u32;
    for step in 0..n as u32 {
        let next = (step + 1) % n as u32;
        let [a, b, c, d] = [step, next, first + step, first + next];
        mesh.triangles.extend([[a, d, b], [a, c, d]]);
        let [a, b, c, d] = [a, b, c, d].map(|vertex| vertex + last);
        mesh.triangles.extend([[a, b, d], [a, d, c]]);
    }
    mesh
}

fn spikes() -> TriangleMesh {
    let mut parts = vec![uv_sphere(16, 0.5)];
    let golden = TAU / 2.0 * (3.0 - 5.0_f64.sqrt());
    for index in 0..20 {
        let height = 1.0 - 2.0 * (f64::from(index) + 0.5) / 20.0;
        let (radius, angle) = ((1.0 - height * height).sqrt(), golden * f64::from(index));
        let way = Vector::new(radius * angle.cos(), height, radius * angle.sin());
        let across = if way[1].abs() < 0.9 { Vector::Y } else { Vector::X };
        let side = way.cross(across).normalize_or_zero();
        let other = way.cross(side);
        let corner = |step: u32| {
            let (sine, cosine) = (TAU * f64::from(step) / 6.0).sin_cos();
            let around = side * cosine + other * sine;
            way * 0.42 + around * 0.1
        };
        let mut spike = TriangleMesh::new((0..6).map(corner).map(Into::into).collect(), Vec::new());
        spike.positions.push(way.to_array());
        spike.triangles.extend((0..6).map(|a| [a, (a + 1) % 6, 6]));
        spike.triangles.extend((1..5).map(|a| [0, a + 1, a]));
        parts.push(spike);
    }
    join(&parts)
}

fn comb() -> TriangleMesh {
    let teeth: Vec<f64> = (0..8).map(|tooth| 0.15 * f64::from(tooth)).collect();
    let mut parts = vec![cuboid([0.0; 3], [7.0 * 0.15 + 0.06, 0.2, 0.06])];
    parts.extend(teeth.iter().map(|&x| cuboid([x, -0.5, 0.0], [x + 0.06, 0.05, 0.06])));
    join(&parts)
}

fn knot() -> TriangleMesh {
    let path: Vec<Vector> = (0..120)
        .map(|step| {
            let t = TAU * f64::from(step) / 120.0;
            let r = 2.0 + (3.0 * t).cos();
            Vector::new(r * (2.0 * t).cos() / 3.0, r * (2.0 * t).sin() / 3.0, (3.0 * t).sin() / 3.0)
        })
        .collect();
    tube(&path, 0.14, 12, true)
}

fn links() -> TriangleMesh {
    let one = torus(36, 14);
    let other = moved(y_up(torus(36, 14)), Vector::X);
    join(&[one, other])
}

fn hollow_ball() -> TriangleMesh {
    y_up(join(&[uv_sphere(24, 1.0), turn(uv_sphere(16, 0.8))]))
}

/// The beams of a cube's lattice: three by three by three, holes between them.
fn sponge() -> TriangleMesh {
    let mut parts = Vec::new();
    for a in 0..3 {
        for b in 0..3 {
            for axis in 0..3 {
                let low = |k: usize| [a, b][k] as f64 * 0.4;
                let mut from = [0.0; 3];
                let mut to = [1.0; 3];
                (from[(axis + 1) % 3], to[(axis + 1) % 3]) = (low(0), low(0) + 0.2);
                (from[(axis + 2) % 3], to[(axis + 2) % 3]) = (low(1), low(1) + 0.2);
                parts.push(cuboid(from, to));
            }
        }
    }
    join(&parts)
}

fn crossing_beams() -> TriangleMesh {
    let beams: Vec<TriangleMesh> = (0..9)
        .map(|index| {
            let angle = TAU / 2.0 * f64::from(index) / 9.0;
            let (sine, cosine) = angle.sin_cos();
            let lift = 0.5 * (3.0 * angle).sin();
            let mut beam = cuboid([-1.0, -0.06, -0.06], [1.0, 0.06, 0.06]);
            for [x, y, z] in &mut beam.positions {
                let (along, up, across) = (*x, *y, *z);
                (*x, *y) = (along * cosine - across * sine, up + lift * along);
                *z = along * sine + across * cosine;
            }
            beam
        })
        .collect();
    join(&beams)
}

fn stairs() -> TriangleMesh {
    let mut parts = vec![cuboid([-0.08, 0.0, -0.08], [0.08, 2.0, 0.08])];
    for step in 0..16 {
        let angle = TAU * f64::from(step) / 16.0;
        let (sine, cosine) = angle.sin_cos();
        let height = 0.1 + 0.115 * f64::from(step);
        let mut tread = cuboid([0.05, height, -0.14], [0.8, height + 0.05, 0.14]);
        for [x, _, z] in &mut tread.positions {
            (*x, *z) = (*x * cosine - *z * sine, *x * sine + *z * cosine);
        }
        parts.push(tread);
    }
    join(&parts)
}
