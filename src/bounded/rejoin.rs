//! Where verification has divided hulls, again and again, in halves, they join again as long as the joint hull keeps
//! the bound, those that add the least volume first. Here each joint hull is verified itself, while the search looks
//! at faces quickly and leaves room for what it overlooks.

use super::certify::phantom;
use super::finish::{Finished, Material, finished, keeps_bound};
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds};
use crate::hull::{HullBuilder, solid_hull};

/// A hull, or the place of one that has joined another.
struct Place {
    hull: Finished,
    is_alive: bool,
    volume: f64,
    min: Vector,
    max: Vector,
}

/// Two hulls whose joint hull keeps the bound.
struct Candidate {
    /// Volume that it adds, as a share of its own.
    cost: f64,
    pair: (usize, usize),
}

/// Joins hulls. O(k²) joint hulls at first for k hulls, fewer where most are far from each other, and O(k) for
/// each join.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn rejoin(
    material: &Material<'_>,
    hulls: Vec<Finished>,
) -> Result<Vec<Finished>, Error> {
    let mut places: Vec<Place> = hulls.into_iter().map(Place::new).collect();
    let mut pairs = Vec::new();
    for second in 0..places.len() {
        pairs.extend((0..second).map(|first| (first, second)));
    }
    pairs.retain(|&pair| may_join(material, &places, pair));
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut builder = HullBuilder::new();
    while !material.control.is_past_deadline() {
        let found = crate::parallel::map(&pairs, |&pair| candidate(material, &places, pair));
        for candidate in found {
            candidates.extend(candidate?);
        }
        pairs.clear();
        let least = candidates
            .iter()
            .enumerate()
            .min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost).then(a.pair.cmp(&b.pair)));
        let Some((index, _)) = least else { break };
        let (first, second) = candidates.swap_remove(index).pair;
        let (a, b) = (&places[first].hull, &places[second].hull);
        let mut set = a.seeds.clone();
        set.unite(&b.seeds);
        // Of a divided seed another hull may stand for the rest.
        let triangles = || [a, b].into_iter().flat_map(|hull| hull.triangles(material.seeds));
        let part = (a.part.is_some() || b.part.is_some()).then(|| triangles().collect());
        let inner = [a, b].into_iter().flat_map(|hull| &hull.inner).copied().collect();
        let joint = finished(material, set, part, inner, &mut builder)?;
        if !keeps_bound(&joint, material.tuning) {
            continue;
        }
        places[first].is_alive = false;
        places[second].is_alive = false;
        let is_alive = |(a, b): (usize, usize)| places[a].is_alive && places[b].is_alive;
        candidates.retain(|candidate| is_alive(candidate.pair));
        let new = places.len();
        places.push(Place::new(joint));
        pairs.extend((0..new).map(|other| (other, new)));
        pairs.retain(|&pair| may_join(material, &places, pair));
    }
    Ok(places.into_iter().filter(|place| place.is_alive).map(|place| place.hull).collect())
}

impl Place {
    fn new(hull: Finished) -> Self {
        let (min, max) = bounds(hull.hull.points.iter().copied());
        let volume = hull.hull.volume();
        Self { hull, is_alive: true, volume, min, max }
    }
}

fn may_join(material: &Material<'_>, places: &[Place], (a, b): (usize, usize)) -> bool {
    let (a, b) = (&places[a], &places[b]);
    let gap = material.tuning.bound;
    let is_near = (0..3).all(|k| a.min[k] <= b.max[k] + gap && b.min[k] <= a.max[k] + gap);
    is_near && a.is_alive && b.is_alive
}

/// A pair, if its joint hull keeps the bound.
fn candidate(
    material: &Material<'_>,
    places: &[Place],
    pair: (usize, usize),
) -> Result<Option<Candidate>, Error> {
    let &Material { solid, tuning, control, .. } = material;
    control.check()?;
    let (a, b) = (&places[pair.0], &places[pair.1]);
    let mut builder = HullBuilder::new();
    let points: Vec<Vector> =
        a.hull.hull.points.iter().chain(&b.hull.hull.points).copied().collect();
    let (joint, _) = solid_hull(&mut builder, &points, [0.0; 3], 0.0)?;
    // Vertices are hardly ever saved where that takes a cap.
    if tuning.max_vertices.is_some_and(|most| joint.points.len() > most) {
        return Ok(None);
    }
    if phantom(&joint, solid, tuning.bound, tuning.bound, control)? > tuning.bound {
        return Ok(None);
    }
    let volume = joint.volume();
    Ok(Some(Candidate { cost: (volume - a.volume - b.volume) / volume, pair }))
}
