//! Remerging: where verification has divided hulls, in halves, they join again as long as the joint
//! hull keeps the bound, those that add the least volume first.
//!
//! Takes verified hulls, gives fewer. Each joint hull is verified itself, while the search uses a lenient test
//! and a margin. A tenth of all meshes have divided hulls, and 7 % of those hulls can join again. O(k²) joint
//! hulls at first for k hulls, fewer where most are far from each other, and O(k) for each join.

use super::final_hull::{FinalHull, FinalizeContext, Represented};
use super::make_hull::make_hull;
use super::verify::keeps_bound::{SharedSuspects, keeps_bound};
use crate::bounded::joins::{Cost, Pair, PairQueue, are_near};
use crate::bounded::search::Search;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds};
use crate::hull::{ConvexHull, HullBuilder, joint_hull};
use crate::parallel;

/// A hull that may join others. It stays in the list when it has.
struct Entry {
    hull: FinalHull,
    volume: f64,
    /// Of its bounding box.
    corners: [Vector; 2],
}

impl Entry {
    fn new(hull: FinalHull) -> Self {
        let (min, max) = bounds(hull.hull.points.iter().copied());
        let volume = hull.hull.volume();
        Self { hull, volume, corners: [min, max] }
    }
}

/// Joins hulls. They are verified from the cheapest pair on until one keeps the bound: most that are dearer lose
/// one of their hulls before it is their turn.
pub(super) fn remerge(
    context: &FinalizeContext<'_>,
    hulls: Vec<FinalHull>,
) -> Result<Vec<FinalHull>, Error> {
    let &Search { patches, settings, control, .. } = &context.search;
    let gap = settings.bound.protrusion();
    let mut entries: Vec<Entry> = hulls.into_iter().map(Entry::new).collect();
    let mut queue = PairQueue::new(entries.len());
    let count = entries.len() as u32;
    let mut pairs: Vec<Pair> =
        (0..count).flat_map(|second| (0..second).map(move |first| (first, second))).collect();
    let mut builder = HullBuilder::new();
    let suspects = SharedSuspects::default();
    while !control.is_past_deadline() {
        let corners = |hull: u32| entries[hull as usize].corners;
        pairs.retain(|&(a, b)| queue.is_left(a) && are_near(corners(a), corners(b), gap));
        let costs = parallel::map(&pairs, |&pair| cost(context, &entries, pair));
        for (pair, cost) in pairs.drain(..).zip(costs) {
            if let Some(cost) = cost? {
                queue.push(Cost(cost), pair, ());
            }
        }
        let Some(pair) = cheapest(context, &entries, &mut queue, &suspects)? else { break };
        let [first, second] = [pair.0, pair.1].map(|hull| &entries[hull as usize].hull.represents);
        let represents = Represented::union(&[first, second], patches);
        let joint = make_hull(context, represents, &mut builder)?;
        if joint.keeps_bound(settings) {
            let new = queue.join(pair);
            entries.push(Entry::new(joint));
            pairs.extend((0..new).map(|other| (other, new)));
        }
    }
    let left = (0..).zip(entries).filter(|(index, _)| queue.is_left(*index));
    Ok(left.map(|(_, entry)| entry.hull).collect())
}

/// Volume that the joint hull of a pair adds, as a share of its own; `None` if it has too many vertices.
fn cost(
    context: &FinalizeContext<'_>,
    entries: &[Entry],
    pair: Pair,
) -> Result<Option<f64>, Error> {
    let &Search { settings, control, .. } = &context.search;
    control.check()?;
    let joint = hull_of_pair(entries, pair)?;
    // Simplification hardly ever keeps the cap of a hull that violates it here.
    if settings.max_vertices.is_some_and(|most| joint.points.len() > most) {
        return Ok(None);
    }
    let volume = joint.volume();
    let apart = entries[pair.0 as usize].volume + entries[pair.1 as usize].volume;
    Ok(Some((volume - apart) / volume))
}

/// Takes out the cheapest pair whose joint hull keeps the bound, and those before it, which do not.
fn cheapest(
    context: &FinalizeContext<'_>,
    entries: &[Entry],
    queue: &mut PairQueue<Cost, ()>,
    suspects: &SharedSuspects,
) -> Result<Option<Pair>, Error> {
    let &Search { solid, settings, control, .. } = &context.search;
    let candidates = queue.take_sorted();
    let pairs: Vec<Pair> = candidates.iter().map(|candidate| candidate.pair).collect();
    let keeps = |&pair: &Pair| {
        let joint = hull_of_pair(entries, pair)?;
        keeps_bound(&joint, solid, settings.bound.protrusion(), suspects, control)
    };
    let mut verdicts = parallel::map_until(&pairs, keeps, |verdict| !matches!(verdict, Ok(false)));
    let Some(last) = verdicts.pop() else { return Ok(None) };
    if !last? {
        return Ok(None);
    }
    let mut others = candidates.into_iter().skip(verdicts.len());
    let found = others.next().map(|candidate| candidate.pair);
    queue.extend(others);
    Ok(found)
}

/// The hull of a pair of hulls.
fn hull_of_pair(entries: &[Entry], (first, second): Pair) -> Result<ConvexHull, Error> {
    let hull = |index: u32| &entries[index as usize].hull.hull;
    joint_hull(&mut HullBuilder::new(), hull(first), hull(second))
}
