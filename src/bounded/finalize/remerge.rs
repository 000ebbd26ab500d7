//! Remerging: where verification has divided hulls, in halves, they join again as long as the joint
//! hull keeps the bound, those that add the least volume first.
//!
//! Each joint hull is verified itself, while the search uses a lenient test and a margin. A tenth
//! of all meshes have divided hulls, and 7 % of those hulls can join again.

use super::context::FinalizeContext;
use super::final_hull::FinalHull;
use super::make_hull::make_hull;
use super::verify::keeps_bound::{SharedSuspects, keeps_bound};
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds};
use crate::hull::{ConvexHull, HullBuilder, joint_hull};
use crate::parallel;

/// A hull that may join others. It stays in the list when it has.
struct Entry {
    hull: FinalHull,
    is_alive: bool,
    volume: f64,
    min: Vector,
    max: Vector,
}

/// Two hulls that may join.
struct Candidate {
    /// Volume that the joint hull adds, as a share of its own.
    cost: f64,
    pair: (usize, usize),
}

/// Joins hulls. O(k²) joint hulls at first for k hulls, fewer where most are far from each other,
/// and O(k) for each join. They are verified from the cheapest on until one keeps the bound: most that are
/// dearer lose one of their hulls before it is their turn.
///
/// # Errors
/// [`Error::Cancelled`].
pub(super) fn remerge(
    context: &FinalizeContext<'_>,
    hulls: Vec<FinalHull>,
) -> Result<Vec<FinalHull>, Error> {
    let mut entries: Vec<Entry> = hulls.into_iter().map(Entry::new).collect();
    let mut pairs = Vec::new();
    for second in 0..entries.len() {
        pairs.extend((0..second).map(|first| (first, second)));
    }
    pairs.retain(|&pair| may_join(context, &entries, pair));
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut builder = HullBuilder::new();
    let suspects = SharedSuspects::default();
    while !context.control.is_past_deadline() {
        let found = parallel::map(&pairs, |&pair| candidate(context, &entries, pair));
        for candidate in found {
            candidates.extend(candidate?);
        }
        pairs.clear();
        candidates.sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost).then(a.pair.cmp(&b.pair)));
        let keeps = |candidate: &Candidate| {
            let joint = hull_of_pair(&entries, candidate.pair)?;
            let &FinalizeContext { solid, settings, control, .. } = context;
            keeps_bound(&joint, solid, settings.bound.protrusion(), &suspects, control)
        };
        let mut verdicts =
            parallel::map_until(&candidates, keeps, |verdict| !matches!(verdict, Ok(false)));
        let Some(last) = verdicts.pop() else { break };
        if !last? {
            break;
        }
        // Those before it do not keep the bound.
        let Some(cheapest) = candidates.drain(..=verdicts.len()).next_back() else { break };
        let (first, second) = cheapest.pair;
        let joint = join(context, &entries[first].hull, &entries[second].hull, &mut builder)?;
        if !joint.keeps_bound(context.settings) {
            continue;
        }
        entries[first].is_alive = false;
        entries[second].is_alive = false;
        let are_alive = |(a, b): (usize, usize)| entries[a].is_alive && entries[b].is_alive;
        candidates.retain(|candidate| are_alive(candidate.pair));
        let new = entries.len();
        entries.push(Entry::new(joint));
        pairs.extend((0..new).map(|other| (other, new)));
        pairs.retain(|&pair| may_join(context, &entries, pair));
    }
    Ok(entries.into_iter().filter(|entry| entry.is_alive).map(|entry| entry.hull).collect())
}

impl Entry {
    fn new(hull: FinalHull) -> Self {
        let (min, max) = bounds(hull.hull.points.iter().copied());
        let volume = hull.hull.volume();
        Self { hull, is_alive: true, volume, min, max }
    }
}

fn may_join(context: &FinalizeContext<'_>, entries: &[Entry], (a, b): (usize, usize)) -> bool {
    let (a, b) = (&entries[a], &entries[b]);
    let gap = context.settings.bound.protrusion();
    let is_near = (0..3).all(|k| a.min[k] <= b.max[k] + gap && b.min[k] <= a.max[k] + gap);
    is_near && a.is_alive && b.is_alive
}

/// A pair, unless the hull of both hulls has too many vertices.
fn candidate(
    context: &FinalizeContext<'_>,
    entries: &[Entry],
    pair: (usize, usize),
) -> Result<Option<Candidate>, Error> {
    context.control.check()?;
    let joint = hull_of_pair(entries, pair)?;
    // Simplification hardly ever keeps the cap of a hull that violates it here.
    if context.settings.max_vertices.is_some_and(|most| joint.points.len() > most) {
        return Ok(None);
    }
    let volume = joint.volume();
    let apart = entries[pair.0].volume + entries[pair.1].volume;
    Ok(Some(Candidate { cost: (volume - apart) / volume, pair }))
}

/// The hull of a pair of hulls.
fn hull_of_pair(entries: &[Entry], (first, second): (usize, usize)) -> Result<ConvexHull, Error> {
    let hull = |index: usize| &entries[index].hull.hull;
    joint_hull(&mut HullBuilder::new(), hull(first), hull(second))
}

/// The final hull of what two hulls represent.
fn join(
    context: &FinalizeContext<'_>,
    a: &FinalHull,
    b: &FinalHull,
    builder: &mut HullBuilder,
) -> Result<FinalHull, Error> {
    let mut set = a.patches.clone();
    set.union_with(&b.patches);
    // Another hull may represent the rest of a divided patch.
    let triangles = || [a, b].into_iter().flat_map(|hull| hull.triangles(context.patches));
    let part = (a.part.is_some() || b.part.is_some()).then(|| triangles().collect());
    let inner_points = [a, b].into_iter().flat_map(|hull| &hull.inner_points).copied().collect();
    make_hull(context, set, part, inner_points, builder)
}
