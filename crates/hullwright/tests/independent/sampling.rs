//! The bound against a dense sampling that shares no code with the library's: neither distances,
//! nor winding numbers, nor where the samples are.

use std::collections::BTreeMap;

use hullwright::{Decomposition, TriangleMesh};

use super::nearest::Tree;
use super::oracle::{Convex, Point, Triangle, cross, middle, minus, norm, winding_number};

/// Corners and middles are samples for this many of the surface's triangles, evenly spread.
const MOST_TRIANGLES: usize = 20_000;

/// Solid angles that are summed for each point that was asked for: 10,000 points take some seconds
/// at most. Points beyond that stay undecided.
const SOLID_ANGLES: usize = 10_000;

/// As the library defines the inside.
const INSIDE: f64 = 0.5;

/// What the samples show; lengths are fractions of the diagonal.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sampled {
    /// The farthest that a sample of a hull is outside of the solid.
    pub protrusion: f64,
    /// The farthest that a sample of the surface is outside of every hull.
    pub uncovered: f64,
    /// The most by which a sample of a hull is farther outside than was verified of that hull;
    /// negative where all are nearer.
    pub beyond_verified: f64,
    /// Points on hulls and on the surface.
    pub samples: usize,
    /// Points of hulls of which it was not decided in time whether they are inside.
    pub undecided: usize,
}

/// A point of a hull, how far it is from the surface, and how far it may be outside of it.
struct Sample {
    point: Point,
    distance: f64,
    verified: f64,
}

/// Samples hulls and surface at `count` points each, beside corners and middles of edges and faces.
/// `solid` are the triangles by whose winding number a point is inside.
pub fn sample<R>(
    found: &Decomposition<R>,
    surface: &TriangleMesh,
    solid: &[[u32; 3]],
    count: usize,
) -> Sampled {
    let diagonal = found.run.diagonal;
    let origin = surface.positions.first().copied().unwrap_or_default();
    // Near 1, so that squares neither overflow nor vanish.
    let place = |points: &[Point]| -> Vec<Point> {
        points.iter().map(|&point| minus(point, origin).map(|x| x / diagonal)).collect()
    };
    let positions = place(&surface.positions);
    let hulls: Vec<Convex> = found
        .hulls
        .iter()
        .map(|hull| Convex::new(&place(&hull.shape.points), &hull.shape.triangles))
        .collect();
    let verified: Vec<f64> = found
        .hulls
        .iter()
        .map(|hull| hull.errors.protrusion_max.unwrap_or(f64::INFINITY) / diagonal)
        .collect();
    let triangles = Triangle::all(&positions, &surface.triangles);
    let of_solid = Triangle::all(&positions, solid);
    let mut sampled = protrusion(&hulls, &verified, &triangles, (&of_solid, solid), count);
    let points = points_on(&triangles, count);
    sampled.samples += points.len();
    sampled.uncovered = points.iter().map(|&point| outside(&hulls, point)).fold(0.0, f64::max);
    sampled
}

fn protrusion(
    hulls: &[Convex],
    verified: &[f64],
    surface: &[Triangle],
    (solid, indices): (&[Triangle], &[[u32; 3]]),
    count: usize,
) -> Sampled {
    let tree = Tree::new(surface.to_vec());
    let area: f64 = hulls.iter().flat_map(|hull| &hull.faces).map(area_of).sum();
    let mut samples = Vec::new();
    for (hull, &verified) in hulls.iter().zip(verified) {
        let points = special_points(&hull.faces, 1).chain(spread(&hull.faces, count as f64 / area));
        samples.extend(points.map(|point| Sample {
            point,
            distance: tree.distance(point),
            verified,
        }));
    }
    samples.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    let mut sampled = Sampled {
        beyond_verified: f64::NEG_INFINITY,
        samples: samples.len(),
        ..Sampled::default()
    };
    let is_open = is_open(indices);
    let mut left = SOLID_ANGLES.saturating_mul(count) / solid.len().max(1);
    for Sample { point, distance, verified } in samples {
        // Only what is outside may change what is known so far.
        let beyond = distance - verified;
        if distance <= sampled.protrusion && beyond <= sampled.beyond_verified.max(0.0) {
            continue;
        }
        if left == 0 {
            sampled.undecided += 1;
            continue;
        }
        left -= 1;
        if winding_number(solid, point) <= INSIDE {
            let distance = match is_open {
                true => {
                    left = left.saturating_sub(4 * STEPS);
                    distance_to_inside(solid, point, distance)
                }
                false => distance,
            };
            sampled.protrusion = sampled.protrusion.max(distance);
            sampled.beyond_verified = sampled.beyond_verified.max(distance - verified);
        }
    }
    sampled
}

/// Whether triangles run along some edge more often one way than the other: there the inside ends
/// without a surface.
fn is_open(triangles: &[[u32; 3]]) -> bool {
    let mut balance: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *balance.entry((from.min(to), from.max(to))).or_default() +=
                if from < to { 1 } else { -1 };
        }
    }
    balance.values().any(|&sum| sum != 0)
}

/// Steps uphill from a point outside of an open surface.
const STEPS: usize = 12;

/// How far a point inside is that is found on the way along the winding number's gradient, in steps
/// of a share of `limit`, the distance to the surface; `limit` where there is none. The nearest one
/// may be nearer.
fn distance_to_inside(solid: &[Triangle], point: Point, limit: f64) -> f64 {
    let (difference, step) = (1e-3 * limit, limit / STEPS as f64);
    let mut at = point;
    for _ in 0..STEPS {
        let number = winding_number(solid, at);
        let slope = [0, 1, 2].map(|axis| {
            let mut beside = at;
            beside[axis] += difference;
            (winding_number(solid, beside) - number) / difference
        });
        let steepness = norm(slope);
        if steepness <= 0.0 {
            break;
        }
        // No farther than the level seems to be, and a little beyond it.
        let way = (1.05 * (INSIDE - number) / steepness + 0.01 * step).min(step);
        at = [0, 1, 2].map(|k| at[k] + way * slope[k] / steepness);
        if winding_number(solid, at) > INSIDE {
            return norm(minus(at, point)).min(limit);
        }
    }
    limit
}

/// How far a point is outside of every hull.
fn outside(hulls: &[Convex], point: Point) -> f64 {
    hulls.iter().fold(f64::INFINITY, |least, hull| {
        if hull.least_distance(point) < least { least.min(hull.outside(point)) } else { least }
    })
}

/// Points on a surface: evenly spread, and where extremes tend to be.
fn points_on(triangles: &[Triangle], count: usize) -> Vec<Point> {
    let every = triangles.len().div_ceil(MOST_TRIANGLES).max(1);
    let area: f64 = triangles.iter().map(area_of).sum();
    special_points(triangles, every).chain(spread(triangles, count as f64 / area)).collect()
}

/// Corners, middles of edges, and middles of triangles.
fn special_points(triangles: &[Triangle], every: usize) -> impl Iterator<Item = Point> + '_ {
    triangles.iter().step_by(every).flat_map(|triangle| {
        let [a, b, c] = triangle.corners;
        [a, b, c, middle(a, b), middle(b, c), middle(c, a), triangle.centre]
    })
}

/// So many points for a unit of area, spread over triangles.
pub fn spread(triangles: &[Triangle], density: f64) -> impl Iterator<Item = Point> + '_ {
    // Shares of a triangle are those of the additive recurrence of the plastic number (Roberts
    // 2018).
    const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    let mut due = 0.0;
    let mut count = 0.0;
    triangles.iter().flat_map(move |triangle| {
        let expected = density * area_of(triangle);
        due += if expected.is_finite() { expected } else { 0.0 };
        let mut points = Vec::new();
        while due >= 1.0 {
            due -= 1.0;
            count += 1.0;
            let [mut u, mut v] = STEPS.map(|step| (count * step) % 1.0);
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let [a, b, c] = triangle.corners;
            points.push([0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k])));
        }
        points
    })
}

fn area_of(triangle: &Triangle) -> f64 {
    let [a, b, c] = triangle.corners;
    0.5 * norm(cross(minus(b, a), minus(c, a)))
}
