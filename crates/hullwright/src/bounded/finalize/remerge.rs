//! Remerging: hulls join again as long as the joint hull keeps the bound, those that add the least
//! volume first.
//!
//! A tenth of all meshes have divided hulls, and 7 % of those hulls can join again. A joint hull
//! for each pair of hulls that are near each other, at first and after each join.

use super::final_hull::{FinalHull, Owned, make_hull};
use super::hull_simplification::FinalizeContext;
use crate::bounded::joins::{Cost, Pair, PairQueue, are_near, near_pairs};
use crate::bounded::search::Search;
use crate::error::Error;
use crate::geometry::vector::{Vector, bounds};
use crate::hull::{ConvexHull, HullBuilder, joint_hull};
use crate::parallel;
use crate::solid::keeps_bound;

/// Pairs that are verified between two looks at the queue, and may be verified in parallel: as many
/// as there are processors in a desktop machine.
const AT_ONCE: usize = 16;

/// Joins hulls. They are verified from the cheapest pair on until one keeps the bound: most that
/// are dearer lose one of their hulls before it is their turn.
pub(super) fn remerge(
    context: &FinalizeContext<'_>,
    hulls: Vec<FinalHull>,
) -> Result<Vec<FinalHull>, Error> {
    let &Search { settings, control, .. } = &context.search;
    let gap = settings.widest_gap(settings.bound.verified());
    let entries: Vec<Entry> = hulls.into_iter().map(Entry::new).collect();
    let boxes: Vec<(u32, [Vector; 2])> =
        (0..).zip(&entries).map(|(index, entry)| (index, entry.corners)).collect();
    let queue = PairQueue::new(entries.len());
    let mut remerging = Remerging { context, gap, entries, queue };
    let mut builder = HullBuilder::new();
    remerging.consider(&near_pairs(&boxes, gap))?;
    while !control.is_past_deadline() {
        let Some(pair) = remerging.cheapest()? else { break };
        let joint = make_hull(context, remerging.owned(pair), &mut builder)?;
        if joint.keeps_bound(settings) {
            let pairs = remerging.join(pair, joint);
            remerging.consider(&pairs)?;
        }
    }
    let Remerging { entries, queue, .. } = remerging;
    let left = (0..).zip(entries).filter(|(index, _)| queue.is_left(*index));
    Ok(left.map(|(_, entry)| entry.hull).collect())
}

/// A hull that may join others. It stays in the list when it has.
struct Entry {
    hull: FinalHull,
    volume: f64,
    /// Of its bounding box.
    corners: [Vector; 2],
}

impl Entry {
    fn new(hull: FinalHull) -> Self {
        let (min, max) = bounds(hull.hull.points().iter().copied());
        let volume = hull.hull.volume();
        Self { hull, volume, corners: [min, max] }
    }
}

/// The state of remerging.
struct Remerging<'a> {
    context: &'a FinalizeContext<'a>,
    /// Hulls farther apart do not join.
    gap: f64,
    entries: Vec<Entry>,
    queue: PairQueue<Cost, ()>,
}

impl Remerging<'_> {
    /// Makes pairs candidates.
    fn consider(&mut self, pairs: &[Pair]) -> Result<(), Error> {
        let costs = parallel::map(pairs, |&pair| self.cost(pair));
        for (&pair, cost) in pairs.iter().zip(costs) {
            if let Some(cost) = cost? {
                self.queue.push(Cost(cost), pair, ());
            }
        }
        Ok(())
    }

    /// Volume that the joint hull of a pair adds, as a share of its own; `None` if it has too many
    /// vertices.
    fn cost(&self, pair: Pair) -> Result<Option<f64>, Error> {
        let &Search { settings, control, .. } = &self.context.search;
        control.check()?;
        let joint = self.hull_of(pair)?;
        // Simplification hardly ever keeps the limit of a hull that exceeds it here.
        if settings.max_vertices.is_some_and(|most| joint.points.len() > most) {
            return Ok(None);
        }
        let volume = joint.volume();
        let apart = self.entry(pair.0).volume + self.entry(pair.1).volume;
        Ok(Some((volume - apart) / volume))
    }

    /// Takes out the cheapest pair whose joint hull keeps the bound, and those before it, which do
    /// not.
    fn cheapest(&mut self) -> Result<Option<Pair>, Error> {
        let &Search { exact_solid: solid, settings, control, .. } = &self.context.search;
        loop {
            let candidates: Vec<(Cost, Pair, ())> =
                std::iter::from_fn(|| self.queue.pop()).take(AT_ONCE).collect();
            if candidates.is_empty() {
                return Ok(None);
            }
            let keeps = |&(_, pair, ()): &(Cost, Pair, ())| {
                keeps_bound(&self.hull_of(pair)?, solid, settings.bound.verified(), control)
            };
            let is_last = |verdict: &Result<bool, Error>| !matches!(verdict, Ok(false));
            let mut verdicts = parallel::map_until(&candidates, keeps, is_last);
            if let Some(last) = verdicts.pop()
                && last?
            {
                let mut rest = candidates.into_iter().skip(verdicts.len());
                let found = rest.next().map(|(_, pair, ())| pair);
                rest.for_each(|(cost, pair, ())| self.queue.push(cost, pair, ()));
                return Ok(found);
            }
        }
    }

    /// Replaces two hulls by their joint one. Returns its pairs that may join.
    fn join(&mut self, pair: Pair, joint: FinalHull) -> Vec<Pair> {
        let (new, joint) = (self.queue.join(pair), Entry::new(joint));
        let is_near = |&other: &u32| are_near(self.entry(other).corners, joint.corners, self.gap);
        let near = self.queue.left().filter(|&other| other != new).filter(is_near);
        let pairs = near.map(|other| (other, new)).collect();
        self.entries.push(joint);
        pairs
    }

    fn entry(&self, hull: u32) -> &Entry {
        &self.entries[hull as usize]
    }

    fn owned(&self, pair: Pair) -> Owned {
        let [first, second] = [pair.0, pair.1].map(|hull| &self.entry(hull).hull.owned);
        Owned::union(&[first, second], self.context.search.patches)
    }

    /// The hull of a pair of hulls.
    fn hull_of(&self, pair: Pair) -> Result<ConvexHull, Error> {
        let [first, second] = [pair.0, pair.1].map(|hull| &self.entry(hull).hull.hull);
        joint_hull(&mut HullBuilder::new(), first, second)
    }
}

#[cfg(test)]
mod tests {
    use super::super::division::hulls_of_piece;
    use super::*;
    use crate::bounded::fixture::{Fixture, cubes, l_prism, u_prism};

    fn context(fixture: &Fixture) -> FinalizeContext<'_> {
        FinalizeContext { search: fixture.search(), volume_per_vertex: 0.0 }
    }

    #[test]
    fn hulls_of_one_convex_part_join_again() {
        for (mesh, parts) in [(l_prism(), 2), (u_prism(), 3)] {
            let fixture = Fixture::new(&mesh, 0.02);
            // One hull for each patch.
            let pieces = (0..fixture.patches.count() as u32).map(|patch| fixture.piece([patch]));
            let hulls = pieces.flat_map(|piece| {
                hulls_of_piece(&context(&fixture), &piece).unwrap().unwrap().hulls
            });
            let joined = remerge(&context(&fixture), hulls.collect()).unwrap();
            assert_eq!(joined.len(), parts);
            assert!(joined.iter().all(|hull| hull.keeps_bound(&fixture.settings)));
            assert!(fixture.owners(&joined).iter().all(|&owners| owners == 1));
        }
    }

    #[test]
    fn hulls_apart_do_not_join_and_hulls_at_a_crack_do() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 3.0]), 0.02);
        let joined = remerge(&context(&fixture), fixture.hulls_of_patches()).unwrap();
        let mut sets: Vec<Vec<u32>> =
            joined.iter().map(|hull| hull.owned.patches.iter().collect()).collect();
        sets.sort();
        assert_eq!(sets, [vec![0, 1], vec![2]]);
    }

    fn remerging<'a>(context: &'a FinalizeContext<'a>, hulls: Vec<FinalHull>) -> Remerging<'a> {
        let queue = PairQueue::new(hulls.len());
        let entries = hulls.into_iter().map(Entry::new).collect();
        Remerging { context, gap: 0.1, entries, queue }
    }

    #[test]
    fn a_pair_with_more_vertices_than_the_limit_has_no_cost() {
        let mut fixture = Fixture::new(&cubes([0.0, 1.02]), 0.02);
        let hulls = || fixture.hulls_of_patches();
        let found = remerging(&context(&fixture), hulls()).cost((0, 1)).unwrap().unwrap();
        assert!((found - 0.02 / 2.02).abs() < 1e-6, "{found}");
        let hulls = hulls();
        fixture.settings.max_vertices = Some(7);
        assert_eq!(remerging(&context(&fixture), hulls).cost((0, 1)).unwrap(), None);
    }

    #[test]
    fn a_joint_hull_may_join_those_that_are_near_it() {
        let fixture = Fixture::new(&cubes([0.0, 1.02, 2.04, 9.0]), 0.02);
        let context = context(&fixture);
        let mut some = remerging(&context, fixture.hulls_of_patches());
        let joint = fixture.hulls_of_patches().swap_remove(1);
        assert_eq!(some.join((0, 1), joint), [(2, 4)]);
    }
}
