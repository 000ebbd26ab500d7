//! What is seen through an opening: the backs of faces, or their fronts.
//!
//! The back of a face that is drawn from one side is invisible. So where only backs are seen from a cap, the
//! surface is the skin of a solid. Fronts, or a way out, mean that the inside is a room; except the fronts of
//! other solids that are stuck into this one, which the ray leaves again through their backs.

use super::cap::Cap;
use crate::bvh::Bvh;
use crate::geometry::vector::Vector;

/// Rays start from so many points, spread over the cap by area.
const POINTS: usize = 32;

/// Rays from each point, spread over the half-space within as light from a matt surface is.
const RAYS_PER_POINT: usize = 4;

/// Through the opening of a solid no more than this share of the rays sees anything.
const MOST_SEEN: f64 = 0.05;

/// Where more of the rays than this only see another cap, there is too little surface to decide: between the rim
/// of a cup and that of its liner a little below.
const MOST_CAPPED: f64 = 0.5;

/// A ray through more faces than this decides nothing.
const MOST_HITS: usize = 32;

/// A hit nearer than this fraction of the diagonal is on the rim that the ray starts from.
const START: f64 = 1e-7;

/// Steps of the additive recurrences that spread points evenly: 1/φ, and 1/ρ, 1/ρ² for the plastic
/// number ρ (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
const GOLDEN: f64 = 0.618_033_988_749_894_9;
const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

/// Whether more than `MOST_SEEN` of the rays from a cap inward see a front, or a way out, or more than
/// `MOST_CAPPED` leave the solid through another cap. Triangles from number `surface` on are caps; `counts`
/// says which triangles are there.
pub(super) fn is_seen_into(
    cap: &Cap,
    positions: &[Vector],
    bvh: &Bvh,
    surface: usize,
    counts: impl Fn(u32) -> bool,
) -> bool {
    let inward = -cap.normal;
    let is_more =
        |count: usize, share: f64| count as f64 > share * (POINTS * RAYS_PER_POINT) as f64;
    let (mut seen, mut capped) = (0, 0);
    for (number, point) in points(cap, positions).into_iter().enumerate() {
        for ray in 0..RAYS_PER_POINT {
            let direction = direction(cap, inward, number * RAYS_PER_POINT + ray);
            match leaves_through(bvh, point, direction, &counts) {
                None => seen += 1,
                Some(triangle) => capped += usize::from(triangle as usize >= surface),
            }
        }
        if is_more(seen, MOST_SEEN) || is_more(capped, MOST_CAPPED) {
            return true;
        }
    }
    false
}

/// Through which triangle a ray that starts in the solid leaves it, if it does: through one back more than
/// fronts. A part of another solid that is stuck into this one shows its front, and then its own back.
fn leaves_through(
    bvh: &Bvh,
    origin: Vector,
    direction: Vector,
    counts: impl Fn(u32) -> bool,
) -> Option<u32> {
    let mut solids = 1;
    let mut start = START;
    for _ in 0..MOST_HITS {
        let hit = bvh.first_hit(origin, direction, start, |triangle, _| counts(triangle))?;
        solids += if hit.is_back { -1 } else { 1 };
        if solids == 0 {
            return Some(hit.triangle);
        }
        start = hit.distance;
    }
    None
}

/// The next number of an additive recurrence.
fn spread(step: f64, number: usize) -> f64 {
    (0.5 + step * (number + 1) as f64).fract()
}

/// Spread evenly by area.
pub(super) fn points(cap: &Cap, positions: &[Vector]) -> Vec<Vector> {
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| positions[vertex as usize]);
    let areas: Vec<f64> = cap
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = corners(triangle).map(|corner| cap.flatten(corner));
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
        })
        .collect();
    let whole: f64 = areas.iter().sum();
    let (mut triangle, mut before) = (0, 0.0);
    (0..POINTS)
        .filter_map(|number| {
            let target = whole * (number as f64 + 0.5) / POINTS as f64;
            while triangle + 1 < areas.len() && before + areas[triangle] < target {
                before += areas[triangle];
                triangle += 1;
            }
            let [a, b, c] = corners(cap.triangles.get(triangle)?);
            let (mut v, mut w) = (spread(PLASTIC[0], number), spread(PLASTIC[1], number));
            if v + w > 1.0 {
                (v, w) = (1.0 - v, 1.0 - w);
            }
            Some(a + ((b - a) * v + (c - a) * w))
        })
        .collect()
}

/// With a density that is proportional to the cosine with `inward`.
fn direction(cap: &Cap, inward: Vector, number: usize) -> Vector {
    let height_squared = spread(GOLDEN, number);
    let turn = std::f64::consts::TAU * (number as f64 + 0.5) / (POINTS * RAYS_PER_POINT) as f64;
    let radius = (1.0 - height_squared).sqrt();
    let across =
        cap.axes[0] * (radius * libm::cos(turn)) + cap.axes[1] * (radius * libm::sin(turn));
    inward * height_squared.sqrt() + across
}
